//! The statements of OBJ (Wavefront, Object Files, version 3.0) and of MTL, with what exporters add.

use super::Rule::{self, NoMeaning, Read, Warned, WarnedUnless};

/// A statement: its keyword, what is made of it, and an example of what follows.
pub type Row = (&'static str, Rule, &'static str);

const GLOSS: Rule = NoMeaning("gloss; light is solved for surfaces that scatter evenly");
const DISPLAY: Rule = NoMeaning("how a program shows it");
const FREE_FORM: Rule = NoMeaning("of curves and surfaces, which are counted and left out");
const SENDS: &str = "light that a plant sends out by itself is left out";

/// Statements of OBJ.
pub const OBJ: &[Row] = &[
    ("v", Read, "0 0 0"),
    ("vt", Read, "0 0"),
    ("vn", Read, "0 0 1"),
    ("f", Read, "1 2 3"),
    ("fo", Read, "1 2 3"),
    ("g", Read, "trunk"),
    ("o", Read, "tree"),
    ("usemtl", Read, "bark"),
    ("mtllib", Read, "tree.mtl"),
    ("l", Warned("lines have no surface"), "1 2"),
    ("p", Warned("points have no surface"), "1"),
    ("curv", Warned("export the surface as polygons"), "0 1 1 2"),
    ("curv2", Warned("export the surface as polygons"), "1 2"),
    ("surf", Warned("export the surface as polygons"), "0 1 0 1 1 2 3"),
    ("call", Warned("what another file holds is not read"), "other.obj"),
    ("csh", Warned("no command is run"), "ls"),
    ("usemap", Warned("textures are those of materials"), "leaf"),
    ("maplib", Warned("textures are those of materials"), "leaf.map"),
    ("vp", FREE_FORM, "0 0"),
    ("cstype", FREE_FORM, "bezier"),
    ("deg", FREE_FORM, "3"),
    ("bmat", FREE_FORM, "u 1"),
    ("step", FREE_FORM, "1"),
    ("parm", FREE_FORM, "u 0 1"),
    ("trim", FREE_FORM, "0 1 1"),
    ("hole", FREE_FORM, "0 1 1"),
    ("scrv", FREE_FORM, "0 1 1"),
    ("sp", FREE_FORM, "1"),
    ("end", FREE_FORM, ""),
    ("con", FREE_FORM, "1 0 1 1 2 0 1 1"),
    ("s", NoMeaning("normals are the file's, or those of the triangles"), "off"),
    ("mg", FREE_FORM, "off"),
    ("bevel", DISPLAY, "off"),
    ("c_interp", DISPLAY, "off"),
    ("d_interp", DISPLAY, "off"),
    ("lod", DISPLAY, "3"),
    ("shadow_obj", DISPLAY, "s.obj"),
    ("trace_obj", DISPLAY, "t.obj"),
    ("ctech", FREE_FORM, "cparm 1"),
    ("stech", FREE_FORM, "cparma 1 1"),
];

/// Statements of MTL, in lower case.
pub const MTL: &[Row] = &[
    ("newmtl", Read, "bark"),
    ("kd", Read, "1 0 0"),
    ("d", Read, "0.5"),
    ("tr", Read, "0.5"),
    ("map_kd", Read, "a.png"),
    ("map_ka", Read, "a.png"),
    ("map_d", Read, "a.png"),
    ("map_opacity", Read, "a.png"),
    ("map_tr", Read, "a.png"),
    ("ke", WarnedUnless(SENDS, "0 0 0"), "1 0 0"),
    ("map_ke", Warned(SENDS), "a.png"),
    ("tf", WarnedUnless("light that passes a leaf is measured", "1 1 1"), "0.5 0.5 0.5"),
    ("disp", Warned("the shape is that of the triangles"), "a.png"),
    ("map_disp", Warned("the shape is that of the triangles"), "a.png"),
    ("decal", Warned("colours are those of map_Kd"), "a.png"),
    ("ka", NoMeaning("light is solved instead"), "1 1 1"),
    ("ks", GLOSS, "1 1 1"),
    ("ns", GLOSS, "10"),
    ("ni", GLOSS, "1.5"),
    ("illum", DISPLAY, "2"),
    ("sharpness", GLOSS, "60"),
    ("map_ks", GLOSS, "a.png"),
    ("map_ns", GLOSS, "a.png"),
    ("refl", GLOSS, "a.png"),
    ("map_refl", GLOSS, "a.png"),
    ("map_aat", DISPLAY, "on"),
    ("bump", NoMeaning("finer than a site of the light; pictures shade by triangles"), "a.png"),
    ("map_bump", NoMeaning("finer than a site of the light; pictures shade by triangles"), "a.png"),
    ("norm", NoMeaning("finer than a site of the light; pictures shade by triangles"), "a.png"),
    ("map_kn", NoMeaning("finer than a site of the light; pictures shade by triangles"), "a.png"),
    ("pr", GLOSS, "0.5"),
    ("pm", GLOSS, "0.5"),
    ("ps", GLOSS, "0.5"),
    ("pc", GLOSS, "0.5"),
    ("pcr", GLOSS, "0.5"),
    ("aniso", GLOSS, "0.5"),
    ("anisor", GLOSS, "0.5"),
    ("km", GLOSS, "0"),
    ("map_pr", GLOSS, "a.png"),
    ("map_pm", GLOSS, "a.png"),
    ("map_ps", GLOSS, "a.png"),
    ("map_rma", GLOSS, "a.png"),
    ("map_orm", GLOSS, "a.png"),
    ("map_refl_type", GLOSS, "sphere"),
];

/// Returns the reason why a statement is not read; `None` where there is nothing to say. `rest` is what follows the
/// keyword.
pub fn unread(rows: &[Row], keyword: &str, rest: &str) -> Option<&'static str> {
    match rows.iter().find(|(name, ..)| *name == keyword).map(|(_, rule, _)| *rule) {
        None => Some("it is not known"),
        Some(Warned(why)) => Some(why),
        Some(WarnedUnless(why, nothing)) => (!are_same(rest, nothing)).then_some(why),
        Some(Read | NoMeaning(_) | Rule::Refused(_)) => None,
    }
}

/// Whether two lists of numbers are the same, of which one that is short repeats its last.
fn are_same(found: &str, nothing: &str) -> bool {
    let numbers =
        |text: &str| -> Option<Vec<f64>> { text.split_whitespace().map(|word| word.parse().ok()).collect() };
    match (numbers(found), numbers(nothing)) {
        (Some(found), Some(nothing)) if !found.is_empty() => {
            nothing.iter().enumerate().all(|(at, value)| found.get(at).or(found.last()) == Some(value))
        }
        _ => false,
    }
}
