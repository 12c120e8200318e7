//! Whether parts wear what their names say: a trunk may wear the material of the leaves, where one atlas serves both.

use super::Doubt;
use crate::classify::words::{Told, is_plainly, told};
use crate::import::quoted;
use crate::mesh::Part;
use crate::{ClassedMesh, MaterialClass};

/// Least area of such parts that is worth a doubt, as a share of that of leaves and wood.
const MIN_SHARE: f64 = 0.01;
/// Parts that a doubt lists.
const LISTED: usize = 4;

/// The doubt, if there are such parts: called trunk, bark or leaves, and of the other class alone.
pub(super) fn doubt(plant: &ClassedMesh) -> Option<Doubt> {
    let parts = &plant.mesh.parts;
    let class_of = |material: u32| plant.classes[material as usize];
    let is_plant = |class: MaterialClass| class != MaterialClass::Neither;
    let area = |part: &Part| {
        let uses = part.uses.iter().filter(|used| is_plant(class_of(used.material)));
        uses.map(|used| used.area_m2).sum::<f64>()
    };
    let all_m2: f64 = parts.iter().map(area).sum();
    let other = |part: &&Part| {
        let said = part.own_names().iter().find_map(|name| match told(name) {
            Told::Class(class, word) if is_plainly(class, &word) => Some(class),
            _ => None,
        });
        said.is_some_and(|said| {
            let mut worn = part.uses.iter().map(|used| class_of(used.material));
            !part.uses.is_empty() && worn.all(|class| is_plant(class) && class != said)
        })
    };
    let found: Vec<&Part> = parts.iter().filter(other).collect();
    let area_m2: f64 = found.iter().map(|part| area(part)).sum();
    if found.is_empty() || area_m2 < MIN_SHARE * all_m2 {
        return None;
    }
    let name = |part: &&Part| {
        let material =
            part.uses.first().map_or("", |used| &plant.mesh.materials[used.material as usize].name);
        format!("{}@{}", quoted(material), part.label())
    };
    let classes = found.iter().filter_map(|part| Some(class_of(part.uses.first()?.material)));
    let mut classes: Vec<MaterialClass> = classes.collect();
    classes.dedup();
    Some(Doubt::Names {
        parts: found.iter().take(LISTED).map(name).collect(),
        area_m2,
        class: classes.first().copied().filter(|_| classes.len() == 1),
    })
}
