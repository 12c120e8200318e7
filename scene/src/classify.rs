//! Which materials are leaf and which wood. The first rule that speaks decides:
//!
//! 1. patterns of the command line, 2. patterns of the species file (within each: a pattern that is
//!    the exact name first, then leaf, wood, ignore), 3. words ([`words`]) in the material's name, then in
//!    its texture's, then in the names of its parts (nodes, meshes, groups), 4. diffuse transmission is
//!    leaf, and a texture of it that lets nothing through is wood, 5. a texture whose alpha really cuts is
//!    leaf, 6. if all that is decided so far is leaf, an opaque rest that is not green is wood.
//!
//! Where parts of leaf and parts of wood wear a material whose name says that it is an atlas, their names go first.
//!
//! A name that ends in a noun of something that is no plant (`flower_pot`) ends the search: neither alpha nor the rest
//! of the plant tells what a pot is. So does a part that is none of the plant's, as `UCX_trunk`, whatever material it
//! wears; a name of both a leaf and a trunk; and cards, cut by alpha and neither brown nor grey, whose name is one of
//! wood.
//!
//! Whatever is still open is an error that shows the materials and the flags, never a guess. Neither is what the user
//! says is neither: a pot or the ground shades the plant, so it is not left out unasked.

mod cards;
mod flags;
pub mod table;
pub mod words;

use self::cards::Hue;
use self::words::Told;
use crate::class::MaterialClass;
use crate::import::{
    ImportError, Things, cut_share, is_met_by, quoted, splits, told_of_material, told_of_part,
};
use crate::mesh::{AlphaMode, Material, Mesh, Part};
use crate::name_pattern::NamePattern;

/// Share of a texture's texels that must be cut away for it to count as leaf evidence: less than
/// this is an edge that compression frayed, not an outline.
pub const MIN_CUT_SHARE: f64 = 0.01;

/// Patterns (globs, any case) that material names are matched with.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct ClassRules {
    /// Patterns of leaf materials, of `--leaf`.
    pub leaf: Vec<String>,
    /// Patterns of wood materials, of `--wood`.
    pub wood: Vec<String>,
    /// Patterns of materials to leave out, of `--ignore`.
    pub ignore: Vec<String>,
    /// Patterns of a species file, with its name.
    pub species: Option<SpeciesRules>,
    /// Names of the materials of the job's other meshes: a pattern that is meant for one of them need not
    /// match here.
    pub elsewhere: Vec<String>,
}

impl ClassRules {
    /// Returns the patterns that name a part, too.
    pub fn split_patterns(&self) -> Vec<String> {
        let line = [&self.leaf, &self.wood, &self.ignore];
        let file = self.species.iter().flat_map(|species| [&species.leaf, &species.wood, &species.ignore]);
        line.into_iter().chain(file).flatten().filter(|pattern| splits(pattern)).cloned().collect()
    }
}

/// Patterns of a species file.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct SpeciesRules {
    /// The file's name, for messages.
    pub file: String,
    /// `leaf = [..]`.
    pub leaf: Vec<String>,
    /// `wood = [..]`.
    pub wood: Vec<String>,
    /// `ignore = [..]`.
    pub ignore: Vec<String>,
}

/// A material's class and why.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Classified {
    /// The class.
    pub class: MaterialClass,
    /// The rule that decided, for the user.
    pub rule: String,
}

/// The class of every material of `mesh`, in their order. A material without triangles is
/// [`MaterialClass::Neither`].
///
/// # Errors
/// A pattern that is none or matches nothing; materials that no rule decides; no leaf and no wood.
/// A plant of wood alone (a dead tree) is fine.
pub fn classify(mesh: &Mesh, rules: &ClassRules) -> Result<Vec<Classified>, ImportError> {
    let found = found(mesh, rules)?;
    let shown = || table::text_table(&table::rows(mesh, &found));
    let open = flags::undecided(mesh, &found);
    if !open.is_empty() {
        let flags: Vec<String> = open
            .iter()
            .map(|name| format!("--leaf '{name}' or --wood '{name}' or --ignore '{name}'"))
            .collect();
        let undecided = open.iter().map(|name| format!("'{name}'")).collect::<Vec<_>>().join(", ");
        return Err(ImportError::Undecided { undecided, table: shown(), flags: flags.join("; ") });
    }
    let nothing = "no triangles".to_owned();
    let classified: Vec<Classified> = found
        .iter()
        .map(|found| match found {
            Found::Class(classified) => classified.clone(),
            Found::Open(_) | Found::Unused => {
                Classified { class: MaterialClass::Neither, rule: nothing.clone() }
            }
        })
        .collect();
    let counts = table::triangle_counts(mesh);
    let used =
        classified.iter().zip(&counts).any(|(c, &count)| c.class != MaterialClass::Neither && count > 0);
    if !used {
        return Err(ImportError::NothingToBake { table: shown() });
    }
    Ok(classified)
}

/// Knowledge of a material's class.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Found {
    /// A rule decides: class, and reason.
    Class(Classified),
    /// No rule decides: reason.
    Open(String),
    /// The material has no triangles.
    Unused,
}

/// Finds the class of every material, as far as it is known.
///
/// # Errors
/// A pattern that is none or matches nothing.
pub fn found(mesh: &Mesh, rules: &ClassRules) -> Result<Vec<Found>, ImportError> {
    let users = Users::of(mesh);
    let patterns = Patterns::compile(&users, rules)?;
    let counts = table::triangle_counts(mesh);
    let by_itself = counts.iter().enumerate().map(|(material, &count)| match count {
        0 => Evidence::Unused,
        _ => by_itself(&users, material, &patterns),
    });
    let evidence: Vec<Evidence> = by_itself.collect();
    let known = || {
        evidence.iter().filter_map(|evidence| match evidence {
            Evidence::Class(known) | Evidence::Weak(known, _) if known.class != MaterialClass::Neither => {
                Some(known.class)
            }
            _ => None,
        })
    };
    let all_leaf = known().next().is_some() && known().all(|class| class == MaterialClass::Leaf);
    let is_opaque = |material: &Material| material.alpha_mode == AlphaMode::Opaque;
    let is_rest = |(evidence, material): (&Evidence, &Material)| {
        all_leaf && matches!(evidence, Evidence::Nothing) && is_opaque(material)
    };
    let rests: Vec<bool> = evidence.iter().zip(&mesh.materials).map(is_rest).collect();
    let is_asked =
        |(is_rest, evidence): (&bool, &Evidence)| *is_rest || matches!(evidence, Evidence::Weak(..));
    let hues = cards::hues(mesh, &rests.iter().zip(&evidence).map(is_asked).collect::<Vec<_>>());
    let of_material = rests.iter().zip(hues).zip(&mesh.materials);
    let resolved = evidence.iter().zip(of_material).map(|(evidence, ((&is_rest, hue), material))| match evidence {
        Evidence::Unused => Found::Unused,
        Evidence::Class(known) => Found::Class(known.clone()),
        Evidence::Weak(known, weak) => match weak.contradicted(known.class, hue, is_opaque(material)) {
            Some(seen) => Found::Open(format!("{}, but it is {seen}", known.rule)),
            None => Found::Class(known.clone()),
        },
        Evidence::Foreign(word) => Found::Open(format!("{word} is no word of a plant")),
        Evidence::Both([leaf, wood]) => Found::Open(format!("its name says both '{leaf}' and '{wood}'")),
        Evidence::Card(word, cut) => Found::Open(format!(
            "'{word}' in its name is of wood, but alpha cuts {:.0} % of it away and what is left is neither brown nor grey",
            100.0 * cut
        )),
        Evidence::Unsure(word) => Found::Open(format!("'{word}' in its name is not known")),
        Evidence::Nothing if is_rest && hue == Hue::Green => {
            Found::Open("opaque as wood is, but green as leaves are".to_owned())
        }
        Evidence::Nothing if is_rest && hue == Hue::Other => {
            Found::Open("opaque as wood is, but neither brown nor grey".to_owned())
        }
        Evidence::Nothing if is_rest => {
            let rule = "opaque, and the rest of the plant is leaf: taken as wood".to_owned();
            Found::Class(Classified { class: MaterialClass::Wood, rule })
        }
        Evidence::Nothing => Found::Open("no rule decides".to_owned()),
    });
    Ok(resolved.collect())
}

/// Which parts use which material.
struct Users<'m> {
    mesh: &'m Mesh,
    /// `[material]`: indices of parts.
    parts: Vec<Vec<u32>>,
    things: Things,
}

impl Users<'_> {
    fn of(mesh: &Mesh) -> Users<'_> {
        let mut parts = vec![Vec::new(); mesh.materials.len()];
        for (at, part) in mesh.parts.iter().enumerate() {
            part.uses.iter().for_each(|used| parts[used.material as usize].push(at as u32));
        }
        let told: Vec<Option<Told>> =
            mesh.materials.iter().map(|material| told_of_material(&mesh.images, material)).collect();
        let used = |part: &Part| part.uses.iter().map(|used| used.material).collect();
        let things = Things::of(&told, &mesh.parts, || mesh.parts.iter().map(used).collect());
        Users { mesh, parts, things }
    }

    /// Whether a material is used, and by nothing but parts that are no part of the plant.
    fn is_of_things(&self, material: usize) -> bool {
        let parts = &self.parts[material];
        !parts.is_empty() && parts.iter().all(|&part| self.things.has(part))
    }

    fn parts(&self, material: usize) -> impl Iterator<Item = &Part> {
        self.parts[material].iter().map(|&part| &self.mesh.parts[part as usize])
    }
}

/// What a material says of its class.
enum Evidence {
    Unused,
    Class(Classified),
    /// A name says so, if the colour does not speak against it.
    Weak(Classified, Weak),
    Foreign(String),
    /// A leaf word and a wood word.
    Both([String; 2]),
    /// A wood word, and the share that alpha cuts away of what has no colour of bark.
    Card(String, f64),
    Unsure(String),
    Nothing,
}

/// Reason why a name tells little by itself.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Weak {
    /// It is that of a node above the part, which may be a thing of its own: blossom below a trunk.
    Above,
    /// The word is said of leaves and of wood: twigs, branches.
    Either,
}

impl Weak {
    /// Look of a material that speaks against its class.
    fn contradicted(self, class: MaterialClass, hue: Hue, is_opaque: bool) -> Option<&'static str> {
        match (self, class, hue) {
            (_, MaterialClass::Leaf, Hue::Bark) if is_opaque => Some("opaque, and brown or grey"),
            (_, MaterialClass::Wood, Hue::Green) => Some("green"),
            (Weak::Above, MaterialClass::Wood, Hue::Other) => Some("neither brown nor grey"),
            _ => None,
        }
    }
}

/// Rules 1 to 5.
fn by_itself(users: &Users, index: usize, patterns: &Patterns) -> Evidence {
    let mesh = users.mesh;
    let material = &mesh.materials[index];
    let decided = |class, rule: String| Evidence::Class(Classified { class, rule });
    if let Some(pattern) = patterns.find(users, index) {
        return decided(pattern.class, format!("{} '{}'", pattern.origin, pattern.text));
    }
    if (material.is_told_by_parts || users.is_of_things(index))
        && let Some(evidence) = by_parts(users, index)
    {
        return evidence;
    }
    let image = material.color_texture.and_then(|texture| mesh.images.get(texture.image as usize));
    let mut unsure = None;
    let mut both = None;
    let own = [Some((material.name.as_str(), "its name".to_owned()))];
    let of_image = image.map(|image| (image.stem(), format!("the name of its texture '{}'", image.name)));
    for (name, place) in own.into_iter().chain([of_image]).flatten() {
        match words::told(name) {
            Told::Class(class, word) => {
                let cut = (class == MaterialClass::Wood).then(|| cards::cut_of_leaves(mesh, index)).flatten();
                let is_of_either = words::is_of_either(&word);
                let rule = format!("'{word}' in {place}");
                return match cut {
                    Some(cut) => Evidence::Card(word, cut),
                    None if is_of_either => Evidence::Weak(Classified { class, rule }, Weak::Either),
                    None => decided(class, rule),
                };
            }
            Told::Foreign(word) => return Evidence::Foreign(format!("'{word}'")),
            Told::Both(words) => {
                both = Some(words);
                break;
            }
            Told::Unsure(word) => unsure = unsure.or(Some(word)),
            Told::Nothing => {}
        }
    }
    if let Some(evidence) = by_parts(users, index) {
        return evidence;
    }
    if let Some(words) = both {
        return Evidence::Both(words);
    }
    match material.diffuse_transmission {
        Some(factor) if factor > 0.0 => {
            return decided(MaterialClass::Leaf, format!("diffuse transmission {factor}"));
        }
        Some(_) if material.passes_by_texture => {
            return decided(
                MaterialClass::Wood,
                "its texture of diffuse transmission lets nothing pass".to_owned(),
            );
        }
        _ => {}
    }
    let cutoff = match material.alpha_mode {
        AlphaMode::Cut { cutoff } => Some(cutoff),
        AlphaMode::Blend => Some(0.5),
        AlphaMode::Opaque => None,
    };
    let texture = material.alpha_texture.or(material.color_texture);
    let image = texture.and_then(|texture| mesh.images.get(texture.image as usize));
    if let Some((cutoff, image)) = cutoff.zip(image) {
        let share = cut_share(image, cutoff);
        if share >= MIN_CUT_SHARE {
            let rule = format!("the alpha of '{}' cuts {:.0} % away", image.name, 100.0 * share);
            return decided(MaterialClass::Leaf, rule);
        }
    }
    unsure.map_or(Evidence::Nothing, Evidence::Unsure)
}

/// What the names of all parts that use a material say; nothing where they differ, or where one says nothing.
fn by_parts(users: &Users, index: usize) -> Option<Evidence> {
    let mut found: Option<(Told, &str)> = None;
    let mut is_above = false;
    for part in users.parts(index) {
        let told = told_of_part(part)?;
        let is_same = match (&found, &told.0) {
            (None, _) => true,
            (Some((Told::Class(a, _), _)), Told::Class(b, _)) => a == b,
            (Some((Told::Foreign(_), _)), Told::Foreign(_)) => true,
            _ => false,
        };
        if !is_same {
            return None;
        }
        is_above |= !part.own_names().iter().any(|name| name == told.1);
        found.get_or_insert(told);
    }
    match found? {
        (Told::Class(class, word), name) => {
            let rule = format!("'{word}' in the name of its part '{}'", quoted(name));
            let known = Classified { class, rule };
            Some(if is_above { Evidence::Weak(known, Weak::Above) } else { Evidence::Class(known) })
        }
        (Told::Foreign(word), name) => {
            Some(Evidence::Foreign(format!("'{word}' in the name of its part '{}'", quoted(name))))
        }
        (Told::Both(_) | Told::Unsure(_) | Told::Nothing, _) => None,
    }
}

struct Pattern {
    text: String,
    origin: String,
    class: MaterialClass,
    names: NamePattern,
}

impl Pattern {
    /// Whether it means a material, by its name or by its name and its parts.
    fn means(&self, users: &Users, index: usize) -> bool {
        let name = &users.mesh.materials[index].name;
        self.names.matches(name) || (splits(&self.text) && is_met_by(&self.text, name, users.parts(index)))
    }
}

/// Patterns in the order in which they are asked: command line, then species file.
struct Patterns {
    groups: [Vec<Pattern>; 2],
}

impl Patterns {
    fn compile(users: &Users, rules: &ClassRules) -> Result<Patterns, ImportError> {
        let names = users.mesh.materials.iter().map(|material| &material.name);
        let known: Vec<&str> = names.chain(&rules.elsewhere).map(String::as_str).collect();
        let known = Known { users, names: known };
        let line =
            compile_group(&known, [&rules.leaf, &rules.wood, &rules.ignore], |key| format!("--{key}"))?;
        let file = match &rules.species {
            Some(species) => compile_group(&known, [&species.leaf, &species.wood, &species.ignore], |key| {
                format!("{}: {key}", species.file)
            })?,
            None => Vec::new(),
        };
        Ok(Patterns { groups: [line, file] })
    }

    fn find(&self, users: &Users, index: usize) -> Option<&Pattern> {
        let name = &users.mesh.materials[index].name;
        self.groups.iter().find_map(|group| {
            let exact = group.iter().find(|pattern| pattern.names.is_name(name));
            // What names a part as well says more than what names the material alone.
            let of_part =
                || group.iter().find(|p| splits(&p.text) && !p.names.matches(name) && p.means(users, index));
            exact.or_else(of_part).or_else(|| group.iter().find(|pattern| pattern.means(users, index)))
        })
    }
}

/// What a pattern may match: materials of the mesh, and names of other meshes' materials.
struct Known<'m> {
    users: &'m Users<'m>,
    names: Vec<&'m str>,
}

/// A pattern that matches nothing that is known is an error.
fn compile_group(
    known: &Known,
    lists: [&Vec<String>; 3],
    origin_of: impl Fn(&str) -> String,
) -> Result<Vec<Pattern>, ImportError> {
    let kinds =
        [("leaf", MaterialClass::Leaf), ("wood", MaterialClass::Wood), ("ignore", MaterialClass::Neither)];
    let mut group = Vec::new();
    for (list, (key, class)) in lists.into_iter().zip(kinds) {
        for text in list {
            let origin = origin_of(key);
            // A material's exact name is a pattern even where it is no glob, as `leaf[` is.
            let exactly = NamePattern::exactly(text);
            let names = match NamePattern::compile(text) {
                Err(_) if known.names.iter().any(|name| exactly.is_name(name)) => exactly,
                compiled => compiled.map_err(|error| ImportError::BadPattern {
                    origin: origin.clone(),
                    pattern: text.clone(),
                    reason: error.kind().to_string(),
                })?,
            };
            let pattern = Pattern { text: text.clone(), origin, class, names };
            let means_any =
                || (0..known.users.mesh.materials.len()).any(|index| pattern.means(known.users, index));
            if !known.names.iter().any(|name| pattern.names.matches(name)) && !means_any() {
                let names: Vec<String> = known.names.iter().map(|name| format!("'{name}'")).collect();
                let (origin, pattern) = (pattern.origin, pattern.text);
                return Err(ImportError::NothingMatched { origin, pattern, materials: names.join(", ") });
            }
            group.push(pattern);
        }
    }
    Ok(group)
}

#[cfg(test)]
mod tests;
