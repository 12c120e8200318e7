//! `flb render` of a single plant: the mesh ray traced, with the indirect light of a file.

use std::path::Path;

use flb_files::check_unread;
use flb_format::SpeciesMeta;
use flb_render::{Look, Portrait, Shading};
use flb_scene::scene::SceneSky;
use flb_scene::{ClassedMesh, Step};
use flb_stage::alone::{PlantLook, PlantRenderer};
use flb_stage::plant::PlantLight;
use flb_stage::{SceneShow, StageSky};

use crate::args::{RenderArgs, RenderBackendArg};
use crate::exit::{Failure, USAGE};
use crate::inputs::{check_output_of, choose_species, open};
use crate::memory::{check, sampler_bytes};
use crate::mesh_of_light::{MeshOfLight, Said, check_fit, mesh_of_species};
use crate::picture::{Difference, Rendered, check_layers, picture_format, sheet, write};
use crate::print::{self, line};
use crate::sky::{read_sky, sky_file, sky_files};
use crate::stages::Stages;

/// A file, the species to show, and what it asks of the renderer.
struct Subject {
    light: PlantLight,
    look: PlantLook,
    exposure: f32,
}

impl Subject {
    fn open(file: &Path, mesh: &Path, args: &RenderArgs, sky: &StageSky) -> Result<Subject, Failure> {
        let library = open(file)?;
        let stem = mesh.file_stem().map(|stem| stem.to_string_lossy().into_owned());
        let index = choose_species(&library, args.species.as_deref(), stem.as_deref())?;
        let light = PlantLight::shown(library, index, &args.bands.show_bands)?;
        let entry = &light.library.container().species()[index];
        let needed = sampler_bytes(entry);
        check(&light.library, &format!("the bases of species {:?}", entry.meta.name), needed, &args.memory)?;
        let (look, exposure) =
            look(args, &entry.meta, sky).map_err(|failure| failure.at(light.library.path()))?;
        if !args.path_traced {
            light.tell_of_beam(&Said);
        }
        Ok(Subject { light, look, exposure })
    }

    /// The renderer of its pictures.
    fn renderer<'m>(&self, mesh: &'m ClassedMesh, suns: &[[f64; 2]]) -> Result<PlantRenderer<'m>, Failure> {
        Ok(PlantRenderer::new(mesh, &self.light, self.look.clone(), suns)?)
    }
}

/// Imports the mesh as it was baked, renders one picture per sun, writes them as one.
pub(crate) fn run(args: &RenderArgs) -> Result<u8, Failure> {
    let missing =
        |flag: &str| Failure::new(USAGE, format!("{flag} is missing; only a scene (.toml) does without"));
    let mesh_file = args.mesh.as_deref().ok_or_else(|| missing("--mesh <MESH>"))?;
    if args.sun.is_empty() && sky_file(&args.sky).is_none() {
        return Err(missing("--sun <AZIMUTH,ELEVATION>"));
    }
    if args.frames.is_some() {
        return Err(Failure::new(
            USAGE,
            "--frames is for scenes (.toml); several --sun make a contact sheet",
        ));
    }
    if args.backend != RenderBackendArg::Cpu {
        return Err(Failure::new(
            USAGE,
            "--backend is for scenes (.toml); a single plant is drawn on the CPU",
        ));
    }
    if args.find.is_some() {
        return Err(Failure::new(USAGE, "--find is for scenes (.toml)"));
    }
    if args.gpus.is_some() {
        return Err(Failure::new(USAGE, "--gpus is for scenes (.toml); a single plant is drawn on the CPU"));
    }
    if args.show.contains(&SceneShow::Global) {
        let message = "--show global is for scenes (.toml); a plant alone has no neighbours";
        return Err(Failure::new(USAGE, message));
    }
    if args.against.is_some() && args.show.len() > 1 {
        return Err(Failure::new(USAGE, "--against compares one of --show"));
    }
    if let Some(flag) = args.scene_light.given() {
        return Err(Failure::new(
            USAGE,
            format!("{flag} is for scenes (.toml); a plant alone has no neighbours"),
        ));
    }
    let mut inputs: Vec<&Path> = vec![&args.file, mesh_file];
    inputs.extend(args.against.as_deref());
    inputs.extend(sky_files(&args.sky));
    check_output_of(&args.output, &inputs, args.existing)?;
    let format = picture_format(&args.output)?;
    check_layers(&args.output, format, &args.show)?;
    let stages = Stages::default();
    let sky = read_sky(&args.sky, &SceneSky::Even, None)?;
    let open = |file: &Path| Subject::open(file, mesh_file, args, &sky);
    let subject = open(&args.file)?;
    let other = args.against.as_deref().map(open).transpose()?;
    let (meta, exposure) = (subject.light.meta(), subject.exposure);
    let MeshOfLight { mesh, matched, .. } = stages.run(Step::Import, &meta.name, |_| {
        mesh_of_species(mesh_file, meta, args.gltf_mesh.as_deref(), args.mesh_differs)
    })?;
    if let Some(other) = &other {
        check_fit(mesh_file, other.light.meta(), &mesh, args.mesh_differs)?;
    }
    check_unread(&args.output)?;
    let renderer = subject.renderer(&mesh, &args.sun)?;
    let beside = other.as_ref().map(|other| other.renderer(&mesh, &args.sun)).transpose()?;
    let mut pictures = Vec::new();
    let mut squares = Squares::default();
    let suns: Vec<Option<[f64; 2]>> = match args.sun.is_empty() {
        true => vec![None],
        false => args.sun.iter().copied().map(Some).collect(),
    };
    for sun in suns {
        let layers = renderer.layers(sun, &stages)?;
        let Some(beside) = &beside else {
            pictures.push(layers);
            continue;
        };
        let (picture, beside) = (&layers[0].1, beside.picture(sun, &stages)?);
        let difference = picture.difference(&beside, args.times)?;
        squares.add(&picture.tone_mapped(exposure), &beside.tone_mapped(exposure));
        let show = layers[0].0;
        pictures.extend([layers, vec![(show, beside)], vec![(show, difference)]]);
    }
    let layers = sheet(pictures)?;
    write(&args.output, args.existing, &layers, format, exposure)?;
    let picture = &layers[0].1;
    let rendered = Rendered::<()> {
        output: args.output.display().to_string(),
        species: meta.name.clone(),
        width: picture.width,
        height: picture.height,
        suns: args.sun.clone(),
        mesh_match: Some(matched.name()),
        difference: other.is_some().then(|| squares.difference()),
        scene: None,
        stages: stages.list(),
    };
    match args.json {
        true => print::json(&rendered)?,
        false => print::out(&text(&rendered))?,
    }
    Ok(0)
}

/// Square differences of pairs of pictures.
#[derive(Default)]
struct Squares {
    sum: f64,
    count: usize,
    max: u8,
}

impl Squares {
    fn add(&mut self, a: &[u8], b: &[u8]) {
        for (a, b) in a.iter().zip(b) {
            let apart = a.abs_diff(*b);
            self.sum += f64::from(apart) * f64::from(apart);
            self.max = self.max.max(apart);
        }
        self.count += a.len();
    }

    fn difference(&self) -> Difference {
        Difference { rms: libm::sqrt(self.sum / self.count.max(1) as f64), max: self.max }
    }
}

/// What is said of a single plant.
fn text(rendered: &Rendered<()>) -> String {
    let suns = format!("{} sun{}", rendered.suns.len(), if rendered.suns.len() == 1 { "" } else { "s" });
    let Rendered { output, species, width, height, .. } = rendered;
    let drawn = line!("{output}: {species} under {suns}, {width} x {height} pixels");
    let difference = rendered.difference.as_ref();
    let difference = difference.map(|d| line!("difference: {:.3} rms, {} at most, of 255", d.rms, d.max));
    drawn + &difference.unwrap_or_default()
}

/// What the flags ask for, of a file of its model, and stops of exposure.
fn look(args: &RenderArgs, meta: &SpeciesMeta, sky: &StageSky) -> Result<(PlantLook, f32), Failure> {
    let refuse = |message: &str| Err(Failure::new(USAGE, message));
    let shading = Shading::of(meta);
    let units = shading.units();
    if shading.surfaces().is_none() && args.path_traced {
        return refuse(
            "--path-traced needs a physical file: a paper file does not say what leaves reflect and transmit",
        );
    }
    if !units.has_indirect_scale() && args.indirect_scale.is_some() {
        return refuse(
            "--indirect-scale is for paper files: a physical one has its light in the sun's units",
        );
    }
    let highlight = args.highlight.choice();
    if !units.has_highlights() && highlight.is_any() {
        return refuse(
            "--highlight is for paper files: leaves of a physical file are matt until their gloss is measured",
        );
    }
    let ([width, height], view) = (args.size.unwrap_or([512; 2]), args.view.unwrap_or([180.0, 8.0]));
    let default = Look::of_light([meta]);
    let look = PlantLook {
        portrait: Portrait {
            width,
            height,
            samples: args.samples.unwrap_or(16),
            view_azimuth_deg: view[0],
            view_elevation_deg: view[1],
            has_ground: args.ground,
            ..Portrait::default()
        },
        look: Look {
            indirect_scale: args.indirect_scale.unwrap_or(default.indirect_scale),
            highlights: default.highlights.with(&highlight),
            ..default
        },
        ambient: args.ambient,
        sky: sky.clone(),
        sunlight: args.sunlight.of_a_plant(),
        shows: args.show.clone(),
        is_path_traced: args.path_traced,
    };
    Ok((look, args.exposure.unwrap_or(units.default_exposure())))
}
