//! Which triangles of a mesh stand for one side of a leaf: what [`crate::sheets`] finds.

/// The sides of a leaf that a triangle stands for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Side {
    /// Both sides: the triangle is the whole leaf.
    #[default]
    Both,
    /// The one from which its vertices run counter-clockwise.
    Front,
    /// The side from which the vertices run clockwise.
    Back,
}

impl Side {
    /// Whether a ray meets the triangle that comes from the side from which its vertices run counter-clockwise, or from
    /// the other one.
    pub fn is_met(self, from_front: bool) -> bool {
        match self {
            Side::Both => true,
            Side::Front => from_front,
            Side::Back => !from_front,
        }
    }

    /// Share of a triangle's area that counts.
    pub fn share(self) -> f64 {
        if self == Side::Both { 1.0 } else { 0.5 }
    }
}

/// Triangles of leaf that stand for one side, and their area.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Sided {
    /// Number of triangles.
    pub triangles: u64,
    /// Area of all triangles, square metres; half of it counts.
    pub area_m2: f64,
}

/// Closed shells of leaf that are too thick to be leaves.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Thick {
    /// Area of the shells, square metres.
    pub area_m2: f64,
    /// Mean thickness of the thickest shell: twice its volume over its area, metres.
    pub thickness_m: f64,
}

/// Triangles of a mesh that are there twice. The default is none.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Sheets {
    /// Side of each triangle; empty where all stand for both sides.
    pub sides: Vec<Side>,
    /// Triangles that lay exactly on those of another material and were dropped, once classes were known.
    pub dropped: u64,
    /// Triangles of third and further sheets of one leaf that were dropped.
    pub further: u64,
    /// Leaf triangles that others lie on, which are the other side of the same leaf.
    pub pairs: Sided,
    /// Leaf triangles of thin closed shells.
    pub shells: Sided,
    /// Closed shells that stay as they are.
    pub thick: Thick,
}

impl Sheets {
    /// The side that a triangle stands for.
    pub fn side(&self, triangle: usize) -> Side {
        self.sides.get(triangle).copied().unwrap_or_default()
    }

    /// Describes what is there twice, a sentence each.
    pub fn notes(&self) -> Vec<String> {
        let mut notes = Vec::new();
        if self.dropped > 0 {
            notes.push(format!(
                "dropped {} triangles that lie exactly on those of another material (their area counts once)",
                self.dropped
            ));
        }
        if self.further > 0 {
            notes.push(format!(
                "dropped {} triangles of third and further sheets of one leaf (two are its sides)",
                self.further
            ));
        }
        let mut say = |found: &Sided, what: &str| {
            if found.triangles > 0 {
                let (area, triangles) = (found.area_m2, found.triangles);
                notes
                    .push(format!("{area:.3} m2 of leaf in {triangles} triangles {what}: half of it counts"));
            }
        };
        say(&self.pairs, "are two sheets each, one for either side of a leaf");
        say(&self.shells, "are thin closed shells around leaves");
        notes
    }
}
