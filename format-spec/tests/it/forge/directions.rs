//! Species whose suns are a list of directions that breaks M57. The first species of the golden file has those of an
//! octahedron.

use flb_format::records::{KIND_DETAIL, MAX_PAGE_BYTES, SectionKey};

use super::content::{Case, relayout, set_first_page};
use super::forge;

const FILE: &str = "directions";
const DIRECTIONS: &str = "[0,1,0],[0,-1,0],[0,0,-1],[1,0,0],[0,0,1],[-1,0,0]";
const TRIANGLES: &str = "[0,2,5],[0,3,2],[0,4,3],[0,5,4],[1,2,3],[1,3,4],[1,4,5],[1,5,2]";

/// Other directions and triangles in the first species.
fn suns(directions: &str, triangles: &str) -> Vec<u8> {
    let list = |d: &str, t: &str| {
        format!("\"suns\":{{\"directions\":[{d}],\"kind\":\"directions\",\"triangles\":[{t}]}}")
    };
    metadata(&list(DIRECTIONS, TRIANGLES), &list(directions, triangles))
}

fn metadata(from: &str, to: &str) -> Vec<u8> {
    forge(FILE, |parts| {
        let text = String::from_utf8(parts.stored(0, 0).to_vec()).expect("metadata are UTF-8");
        assert!(text.contains(from), "{from} is not in {text}");
        parts.sections[0].page_bytes = MAX_PAGE_BYTES;
        set_first_page(parts, 0, text.replacen(from, to, 1).as_bytes());
    })
}

fn without_detail(species: u32, item: u32) -> Vec<u8> {
    forge(FILE, |parts| {
        let key = SectionKey { kind: KIND_DETAIL, species, item };
        let at = parts.sections.iter().position(|section| section.key == key).expect("it is there");
        parts.sections.remove(at);
        parts.tables.remove(at);
        relayout(parts);
    })
}

/// Numbers from 6 on: a second octahedron in the same place.
fn second() -> String {
    let digits = |c: char| c.to_digit(10).map_or(c.to_string(), |digit| (digit + 6).to_string());
    TRIANGLES.chars().map(digits).collect()
}

pub(crate) fn directions_cases() -> Vec<Case> {
    let of_triangles = |from: &str, to: &str| {
        assert!(TRIANGLES.contains(from), "{from}");
        suns(DIRECTIONS, &TRIANGLES.replacen(from, to, 1))
    };
    let of_directions = |from: &str, to: &str| {
        assert!(DIRECTIONS.contains(from), "{from}");
        suns(&DIRECTIONS.replacen(from, to, 1), TRIANGLES)
    };
    // One triangle cut in three by a seventh direction, which has no base.
    let cut = "[0,2,5],[0,3,2],[0,4,6],[0,5,4],[0,6,3],[1,2,3],[1,3,4],[1,4,5],[1,5,2],[3,6,4]";
    let seventh = format!("{DIRECTIONS},[0.6,0.64,0.48]");
    let tetrahedron =
        ("[0.6,0.8,0],[0.6,-0.8,0],[-0.6,0,0.8],[-0.6,0,-0.8]", "[0,1,3],[0,2,1],[0,3,2],[1,2,3]");
    let many = vec!["[0,1,0]"; 256].join(",");
    let twice = format!("{DIRECTIONS},{DIRECTIONS}");
    vec![
        (2007, "item is 5, expected 0 to 4, as the metadata say", suns(tetrahedron.0, tetrahedron.1)),
        (2008, "species 0 has no base 7", suns(&seventh, cut)),
        (2008, "species 1 has no detail of base 35", without_detail(1, 35)),
        (5003, "light.suns of kind \"directions\"", metadata("\"suns\":{", "\"suns\":{\"degree\":1,")),
        (
            5003,
            "light.suns of kind \"direction\"",
            metadata("\"kind\":\"directions\",", "\"kind\":\"direction\","),
        ),
        (5003, "6 directions, no triangles", metadata(&format!(",\"triangles\":[{TRIANGLES}]}}"), "}")),
        (5003, "metadata is", of_directions("[0,1,0]", "[0,1]")),
        (5003, "metadata is", of_directions("[0,1,0]", "[0,1,0,0]")),
        (5003, "metadata is", of_directions("[0,1,0]", "[0,true,0]")),
        (5003, "metadata is", of_directions("[0,1,0]", "{\"x\":0}")),
        (5003, "metadata is", of_triangles("[0,2,5]", "[0,2]")),
        (5003, "metadata is", of_triangles("[0,2,5]", "[0,2.5,5]")),
        (5003, "metadata is", of_triangles("[0,2,5]", "[-1,2,5]")),
        (5003, "metadata is", of_triangles("[0,2,5]", "[0,2,4294967296]")),
        (5003, "directions is 3 vectors, expected 4 to 255", suns("[0,1,0],[0,-1,0],[0,0,-1]", "")),
        (5003, "directions is 256 vectors", suns(&many, TRIANGLES)),
        (5003, "directions[0], its length, is 1.00001", of_directions("[0,1,0]", "[0,1.00001,0]")),
        (5003, "directions[0], its length, is 0.5", of_directions("[0,1,0]", "[0,0.5,0]")),
        (5003, "triangles[7] is [1, 5, 6], expected indices", of_triangles("[1,5,2]", "[1,5,6]")),
        (5003, "triangles[7] is [1, 5, 5], expected indices", of_triangles("[1,5,2]", "[1,5,5]")),
        (5003, "triangles[7] is [5, 2, 1], expected indices", of_triangles("[1,5,2]", "[5,2,1]")),
        (5003, "triangles[1] is [0, 2, 5], expected after", of_triangles("[0,3,2]", "[0,2,5]")),
        (
            5003,
            "triangles[2] is [0, 3, 2], expected after",
            of_triangles("[0,3,2],[0,4,3]", "[0,4,3],[0,3,2]"),
        ),
        (
            5003,
            "triangles[0], its corners' determinant, is -1",
            of_directions("[0,1,0],[0,-1,0]", "[0,-1,0],[0,1,0]"),
        ),
        (5003, "triangles[1], its corners' determinant, is 0", of_directions("[1,0,0]", "[0,0,-1]")),
        (5003, "is of two triangles, expected of one", {
            suns(&seventh, &TRIANGLES.replacen("[0,5,4]", "[0,4,6],[0,5,4]", 1))
        }),
        (5003, "is of one triangle alone", of_triangles(",[1,5,2]", "")),
        (5003, "directions[0] is of no triangle", suns(DIRECTIONS, "")),
        (5003, "directions[6] is of no triangle", suns(&seventh, TRIANGLES)),
        (5003, "the sum of their solid angles, is 25.13", suns(&twice, &format!("{TRIANGLES},{}", second()))),
        (5003, "left_out.bases is {5}, expected []", {
            metadata("\"light\":", "\"left_out\":{\"bands\":[],\"bases\":[5],\"reason\":\"r\"},\"light\":")
        }),
    ]
}
