//! Which materials are leaf and which wood. The first rule that speaks decides:
//!
//! 1. patterns of the command line, 2. patterns of the species file (within each: a pattern that is
//!    the exact name first, then leaf, wood, ignore), 3. diffuse transmission is leaf, 4. a texture
//!    whose alpha really cuts is leaf, 5. words in the material's name, then in its texture's name
//!    ([`words`]), 6. if all that is decided so far is leaf, an opaque rest is wood.
//!
//! Whatever is still open is an error that shows the materials and the flags, never a guess.
//! Neither is what the user says is neither: a pot or the ground shades the plant, so it is not left
//! out unasked.

pub mod table;
pub mod words;

use globset::{GlobBuilder, GlobMatcher};

use crate::class::MaterialClass;
use crate::import::{ImportError, cut_share};
use crate::mesh::{AlphaMode, Material, Mesh};

/// Share of a texture's texels that must be cut away for it to count as leaf evidence: less than
/// this is an edge that compression frayed, not an outline.
pub const LEAST_CUT_SHARE: f64 = 0.01;

/// Patterns (globs, any case) that material names are matched with.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct ClassRules {
    /// `--leaf`.
    pub leaf: Vec<String>,
    /// `--wood`.
    pub wood: Vec<String>,
    /// `--ignore`.
    pub ignore: Vec<String>,
    /// Those of a species file, with its name.
    pub species: Option<SpeciesRules>,
    /// Names of the materials of the job's other meshes: a pattern that is meant for one of them need not
    /// match here.
    pub elsewhere: Vec<String>,
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
    let decisions = decide(mesh, rules)?;
    let shown = || table::text_table(&table::rows(mesh, &decisions));
    let open: Vec<&str> = undecided(mesh, &decisions);
    if !open.is_empty() {
        let flags: Vec<String> = open
            .iter()
            .map(|name| format!("--leaf '{name}' or --wood '{name}' or --ignore '{name}'"))
            .collect();
        let undecided = open.iter().map(|name| format!("'{name}'")).collect::<Vec<_>>().join(", ");
        return Err(ImportError::Undecided { undecided, table: shown(), flags: flags.join("; ") });
    }
    let nothing = "no triangles".to_owned();
    let classified: Vec<Classified> = decisions
        .iter()
        .map(|decision| {
            decision.clone().unwrap_or(Classified { class: MaterialClass::Neither, rule: nothing.clone() })
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

/// Like [`classify`], with `None` for what is open or has no triangles.
///
/// # Errors
/// A pattern that is none or matches nothing.
pub fn decide(mesh: &Mesh, rules: &ClassRules) -> Result<Vec<Option<Classified>>, ImportError> {
    let patterns = Patterns::compile(mesh, rules)?;
    let counts = table::triangle_counts(mesh);
    let mut decisions: Vec<Option<Classified>> = mesh
        .materials
        .iter()
        .zip(&counts)
        .map(|(material, &count)| (count > 0).then(|| by_itself(mesh, material, &patterns)).flatten())
        .collect();
    let known = || decisions.iter().flatten().filter(|decision| decision.class != MaterialClass::Neither);
    let all_leaf = known().next().is_some() && known().all(|decision| decision.class == MaterialClass::Leaf);
    if all_leaf {
        for ((material, decision), &count) in mesh.materials.iter().zip(&mut decisions).zip(&counts) {
            if decision.is_none() && count > 0 && material.alpha_mode == AlphaMode::Opaque {
                let rule = "opaque, and the rest of the plant is leaf: taken as wood".to_owned();
                *decision = Some(Classified { class: MaterialClass::Wood, rule });
            }
        }
    }
    Ok(decisions)
}

/// Names of the materials with triangles that have no decision.
pub fn undecided<'a>(mesh: &'a Mesh, decisions: &[Option<Classified>]) -> Vec<&'a str> {
    let counts = table::triangle_counts(mesh);
    let open = mesh.materials.iter().zip(decisions).zip(&counts);
    open.filter(|((_, decision), count)| decision.is_none() && **count > 0)
        .map(|((material, _), _)| material.name.as_str())
        .collect()
}

/// Rules 1 to 5.
fn by_itself(mesh: &Mesh, material: &Material, patterns: &Patterns) -> Option<Classified> {
    let decided = |class, rule: String| Some(Classified { class, rule });
    if let Some(pattern) = patterns.find(&material.name) {
        return decided(pattern.class, format!("{} '{}'", pattern.origin, pattern.text));
    }
    if let Some(factor) = material.diffuse_transmission {
        return decided(MaterialClass::Leaf, format!("diffuse transmission {factor}"));
    }
    if let AlphaMode::Cut { cutoff } = material.alpha_mode {
        let texture = material.alpha_texture.or(material.color_texture);
        if let Some(image) = texture.and_then(|texture| mesh.images.get(texture.image as usize)) {
            let share = cut_share(image, cutoff);
            if share >= LEAST_CUT_SHARE {
                let rule = format!("the alpha of '{}' cuts {:.0} % away", image.name, 100.0 * share);
                return decided(MaterialClass::Leaf, rule);
            }
        }
    }
    if let Some((class, word)) = words::class_of_name(&material.name) {
        return decided(class, format!("'{word}' in its name"));
    }
    let image = mesh.images.get(material.color_texture?.image as usize)?;
    let (class, word) = words::class_of_name(stem_of(&image.name))?;
    decided(class, format!("'{word}' in the name of its texture '{}'", image.name))
}

fn stem_of(file_name: &str) -> &str {
    file_name.rsplit_once('.').map_or(file_name, |(stem, _)| stem)
}

struct Pattern {
    text: String,
    origin: String,
    class: MaterialClass,
    matcher: GlobMatcher,
}

impl Pattern {
    fn is_name(&self, name: &str) -> bool {
        self.text.to_lowercase() == name.to_lowercase()
    }

    fn matches(&self, name: &str) -> bool {
        self.is_name(name) || self.matcher.is_match(name)
    }
}

/// Patterns in the order in which they are asked: command line, then species file.
struct Patterns {
    groups: [Vec<Pattern>; 2],
}

impl Patterns {
    fn compile(mesh: &Mesh, rules: &ClassRules) -> Result<Patterns, ImportError> {
        let names = mesh.materials.iter().map(|material| &material.name);
        let known: Vec<&str> = names.chain(&rules.elsewhere).map(String::as_str).collect();
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

    fn find(&self, name: &str) -> Option<&Pattern> {
        self.groups.iter().find_map(|group| {
            let exact = group.iter().find(|pattern| pattern.is_name(name));
            exact.or_else(|| group.iter().find(|pattern| pattern.matches(name)))
        })
    }
}

/// `known` holds the names that a pattern may match; one that matches none is an error.
fn compile_group(
    known: &[&str],
    lists: [&Vec<String>; 3],
    origin_of: impl Fn(&str) -> String,
) -> Result<Vec<Pattern>, ImportError> {
    let kinds =
        [("leaf", MaterialClass::Leaf), ("wood", MaterialClass::Wood), ("ignore", MaterialClass::Neither)];
    let mut group = Vec::new();
    for (list, (key, class)) in lists.into_iter().zip(kinds) {
        for text in list {
            let origin = origin_of(key);
            let glob = GlobBuilder::new(text).case_insensitive(true).build();
            // A material's exact name is a pattern even where it is no glob, as `leaf[` is.
            let exact = || known.iter().any(|name| name.to_lowercase() == text.to_lowercase());
            let glob = match glob {
                Err(_) if exact() => GlobBuilder::new(&globset::escape(text)).build(),
                other => other,
            };
            let matcher = glob
                .map_err(|error| ImportError::BadPattern {
                    origin: origin.clone(),
                    pattern: text.clone(),
                    reason: error.kind().to_string(),
                })?
                .compile_matcher();
            let pattern = Pattern { text: text.clone(), origin, class, matcher };
            if !known.iter().any(|name| pattern.matches(name)) {
                let names: Vec<String> = known.iter().map(|name| format!("'{name}'")).collect();
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
