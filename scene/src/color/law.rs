//! From a material of a mesh to the law of its texels ([`flb_format::surface`]).

use flb_format::surface::Law;
use glam::Vec3;

use crate::MaterialClass;
use crate::mesh::Material;

/// Makes the law of a material whose mean colour on the mesh is `mean`, of a plant whose `class` reflects and lets
/// through `of_class`.
pub fn law(material: &Material, class: MaterialClass, of_class: [Vec3; 2], mean: Vec3) -> Law {
    if class == MaterialClass::Neither {
        return Law::PLAIN;
    }
    let [reflectance, transmittance] = of_class.map(|share| share.to_array());
    let own = material.surface.as_ref().and_then(|surface| Law::of_material(surface, mean.to_array()));
    own.unwrap_or(Law { unit: mean.to_array(), reflectance, transmittance })
}
