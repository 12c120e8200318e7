//! Species whose suns are a list of directions that breaks M57. The first species of the golden file has those of an
//! octahedron.

use super::{List, Of};
use crate::container::records::KIND_DETAIL;

const DIRECTIONS: &str = "[0,1,0],[0,-1,0],[0,0,-1],[1,0,0],[0,0,1],[-1,0,0]";
const TRIANGLES: &str = "[0,2,5],[0,3,2],[0,4,3],[0,5,4],[1,2,3],[1,3,4],[1,4,5],[1,5,2]";

impl Of<'_> {
    /// Other directions and triangles in the first species.
    fn suns(&mut self, code: u32, words: &'static str, directions: &str, triangles: &str) {
        let list = |d: &str, t: &str| {
            format!("\"suns\":{{\"directions\":[{d}],\"kind\":\"directions\",\"triangles\":[{t}]}}")
        };
        self.swap(code, words, &list(DIRECTIONS, TRIANGLES), &list(directions, triangles));
    }

    fn direction(&mut self, words: &'static str, from: &str, to: &str) {
        assert!(DIRECTIONS.contains(from), "{from}");
        self.suns(5003, words, &DIRECTIONS.replacen(from, to, 1), TRIANGLES);
    }

    fn triangle(&mut self, words: &'static str, from: &str, to: &str) {
        assert!(TRIANGLES.contains(from), "{from}");
        self.suns(5003, words, DIRECTIONS, &TRIANGLES.replacen(from, to, 1));
    }
}

/// Numbers from 6 on: a second octahedron in the same place.
fn second() -> String {
    let digits = |c: char| c.to_digit(10).map_or(c.to_string(), |digit| (digit + 6).to_string());
    TRIANGLES.chars().map(digits).collect()
}

pub(super) fn add(list: &mut List) {
    let mut of = list.of("directions");
    // One triangle cut in three by a seventh direction, which has no base.
    let cut = "[0,2,5],[0,3,2],[0,4,6],[0,5,4],[0,6,3],[1,2,3],[1,3,4],[1,4,5],[1,5,2],[3,6,4]";
    let seventh = format!("{DIRECTIONS},[0.6,0.64,0.48]");
    let tetrahedron =
        ("[0.6,0.8,0],[0.6,-0.8,0],[-0.6,0,0.8],[-0.6,0,-0.8]", "[0,1,3],[0,2,1],[0,3,2],[1,2,3]");
    of.suns(2007, "item is 5, expected 0 to 4, as the metadata say", tetrahedron.0, tetrahedron.1);
    of.suns(2008, "species 0 has no base 7", &seventh, cut);
    of.without(KIND_DETAIL, 1, 35, 2008, "species 1 has no detail of base 35");
    of.swap(5003, "light.suns of kind \"directions\"", "\"suns\":{", "\"suns\":{\"degree\":1,");
    let words = "light.suns of kind \"direction\"";
    of.swap(5003, words, "\"kind\":\"directions\",", "\"kind\":\"direction\",");
    of.swap(5003, "6 directions, no triangles", &format!(",\"triangles\":[{TRIANGLES}]}}"), "}");
    of.direction("metadata is", "[0,1,0]", "[0,1]");
    of.direction("metadata is", "[0,1,0]", "[0,1,0,0]");
    of.direction("metadata is", "[0,1,0]", "[0,true,0]");
    of.direction("metadata is", "[0,1,0]", "{\"x\":0}");
    of.triangle("metadata is", "[0,2,5]", "[0,2]");
    of.triangle("metadata is", "[0,2,5]", "[0,2.5,5]");
    of.triangle("metadata is", "[0,2,5]", "[-1,2,5]");
    of.triangle("metadata is", "[0,2,5]", "[0,2,4294967296]");
    of.suns(5003, "directions is 3 vectors, expected 4 to 255", "[0,1,0],[0,-1,0],[0,0,-1]", "");
    of.suns(5003, "directions is 256 vectors", &vec!["[0,1,0]"; 256].join(","), TRIANGLES);
    of.direction("directions[0], its length, is 1.00001", "[0,1,0]", "[0,1.00001,0]");
    of.direction("directions[0], its length, is 0.5", "[0,1,0]", "[0,0.5,0]");
    of.triangle("triangles[7] is [1, 5, 6], expected indices", "[1,5,2]", "[1,5,6]");
    of.triangle("triangles[7] is [1, 5, 5], expected indices", "[1,5,2]", "[1,5,5]");
    of.triangle("triangles[7] is [5, 2, 1], expected indices", "[1,5,2]", "[5,2,1]");
    of.triangle("triangles[1] is [0, 2, 5], expected after", "[0,3,2]", "[0,2,5]");
    of.triangle("triangles[2] is [0, 3, 2], expected after", "[0,3,2],[0,4,3]", "[0,4,3],[0,3,2]");
    let words = "triangles[0], its corners' determinant, is -1";
    of.direction(words, "[0,1,0],[0,-1,0]", "[0,-1,0],[0,1,0]");
    of.direction("triangles[1], its corners' determinant, is 0", "[1,0,0]", "[0,0,-1]");
    let both = TRIANGLES.replacen("[0,5,4]", "[0,4,6],[0,5,4]", 1);
    of.suns(5003, "is of two triangles, expected of one", &seventh, &both);
    of.triangle("is of one triangle alone", ",[1,5,2]", "");
    of.suns(5003, "directions[0] is of no triangle", DIRECTIONS, "");
    of.suns(5003, "directions[6] is of no triangle", &seventh, TRIANGLES);
    let (twice, triangles) = (format!("{DIRECTIONS},{DIRECTIONS}"), format!("{TRIANGLES},{}", second()));
    of.suns(5003, "the sum of their solid angles, is 25.13", &twice, &triangles);
    let left_out = "\"left_out\":{\"bands\":[],\"bases\":[5],\"reason\":\"r\"},\"light\":";
    of.swap(5003, "left_out.bases is {5}, expected []", "\"light\":", left_out);
}
