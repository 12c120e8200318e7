//! What a material's triangles are to the light.

use flb_format::surface::SurfacePart;

/// The class of a material.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum MaterialClass {
    /// Lets light through and scatters it.
    Leaf,
    /// Opaque, scatters back.
    Wood,
    /// Left out of the medium.
    Neither,
}

impl MaterialClass {
    /// The word for it in files and messages.
    pub fn name(self) -> &'static str {
        match self {
            MaterialClass::Leaf => "leaf",
            MaterialClass::Wood => "wood",
            MaterialClass::Neither => "neither",
        }
    }

    /// The class of a word.
    pub fn of_name(name: &str) -> Option<MaterialClass> {
        let classes = [MaterialClass::Leaf, MaterialClass::Wood, MaterialClass::Neither];
        classes.into_iter().find(|class| class.name() == name)
    }
}

impl From<MaterialClass> for SurfacePart {
    fn from(class: MaterialClass) -> SurfacePart {
        match class {
            MaterialClass::Leaf => SurfacePart::Leaf,
            MaterialClass::Wood => SurfacePart::Wood,
            MaterialClass::Neither => SurfacePart::Other,
        }
    }
}
