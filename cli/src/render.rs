//! `flb render` of a single plant: the mesh ray traced, with the indirect light of a file.

use std::path::Path;

use flb_files::check_unread;
use flb_format::{FieldKind, SpeciesMeta, sun};
use flb_render::picture::SHEET_GAP;
use flb_render::{
    Daylight, Indirect, LightQuery, Lighting, Look, Picture, Portrait, Shading, Species, contact_sheet,
    render_plant, render_reference,
};
use flb_runtime::{InstanceLight, Library, LightCursors, SkyLight, SpeciesLight, Transform};
use flb_stage::{StageSky, even_sky, sun_strength};

use crate::args::{RenderArgs, RenderBackendArg};
use crate::exit::{Failure, USAGE};
use crate::inputs::{check_output_of, choose_species, open};
use crate::memory::{check, sampler_bytes};
use crate::mesh_of_light::{MeshOfLight, check_fit, mesh_of_species};
use crate::picture::{Difference, Rendered, check_sky, indirect, picture_format, shown, write};
use crate::print::{self, line, say};
use crate::sky::{read_sky, sky_file};
use crate::stages::Stages;
use flb_scene::scene::SceneSky;
use flb_scene::{ClassedMesh, Step};

/// A file, the species to show, and what it asks of the renderer.
struct Subject {
    library: Library,
    index: usize,
    settings: Settings,
}

/// What a picture of a file is asked for.
struct Settings {
    shading: Shading,
    portrait: Portrait,
    look: Look,
    /// Light of the sky.
    ambient: f32,
    exposure: f32,
}

impl Settings {
    /// Of a sun: nothing comes through the ground.
    fn sun_strength(&self, sun_deg: Option<[f64; 2]>) -> f32 {
        sun_strength(sun_deg, self.portrait.has_ground)
    }
}

impl Subject {
    fn open(file: &Path, mesh: &Path, args: &RenderArgs) -> Result<Subject, Failure> {
        let library = open(file)?;
        let stem = mesh.file_stem().map(|stem| stem.to_string_lossy().into_owned());
        let index = choose_species(&library, args.species.as_deref(), stem.as_deref())?;
        let library = shown(library, index, &args.bands)?;
        let meta = &library.container().species()[index].meta;
        let needed = sampler_bytes(&library.container().species()[index]);
        check(&library, &format!("the bases of species {:?}", meta.name), needed, &args.memory)?;
        let settings = settings(args, meta).map_err(|failure| failure.at(library.path()))?;
        Ok(Subject { library, index, settings })
    }

    fn meta(&self) -> &SpeciesMeta {
        &self.library.container().species()[self.index].meta
    }

    /// Its light for the suns of the pictures; `None` where they show none of it.
    fn light(&self, args: &RenderArgs) -> Result<Option<SpeciesLight<'static>>, Failure> {
        if args.path_traced || self.settings.look.indirect == Indirect::Off {
            return Ok(None);
        }
        let lit = args.sun.iter().filter(|sun| self.settings.sun_strength(Some(**sun)) > 0.0);
        let suns = lit.map(|[azimuth, elevation]| sun::towards_sun(*azimuth, *elevation));
        Ok(Some(SpeciesLight::load_for(&self.library, self.index, suns, self.settings.ambient > 0.0)?))
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
    if args.gpus.is_some() {
        return Err(Failure::new(USAGE, "--gpus is for scenes (.toml); a single plant is drawn on the CPU"));
    }
    if args.scene_light.is_some() {
        return Err(Failure::new(
            USAGE,
            "--scene-light is for scenes (.toml); a plant alone has no neighbours",
        ));
    }
    let mut inputs: Vec<&Path> = vec![&args.file, mesh_file];
    inputs.extend(args.against.as_deref());
    inputs.extend(sky_file(&args.sky));
    check_output_of(&args.output, &inputs, args.force)?;
    let format = picture_format(&args.output)?;
    let stages = Stages::default();
    let chosen = read_sky(&args.sky, &SceneSky::Even)?;
    let subject = Subject::open(&args.file, mesh_file, args)?;
    let other = args.against.as_deref().map(|file| Subject::open(file, mesh_file, args)).transpose()?;
    let (meta, settings) = (subject.meta(), &subject.settings);
    let MeshOfLight { mesh, matched } = stages.run(Step::Import, &meta.name, |_| {
        mesh_of_species(mesh_file, meta, args.gltf_mesh.as_deref(), args.mesh_differs)
    })?;
    if let Some(other) = &other {
        check_fit(mesh_file, other.meta(), &mesh, args.mesh_differs)?;
    }
    check_unread(&args.output)?;
    let light = subject.light(args)?;
    let other_light = other.as_ref().map(|other| other.light(args)).transpose()?;
    let mut pictures = Vec::new();
    let mut squares = Squares::default();
    let suns: Vec<Option<[f64; 2]>> = match args.sun.is_empty() {
        true => vec![None],
        false => args.sun.iter().copied().map(Some).collect(),
    };
    for sun in suns {
        let take = |subject: &Subject, light: Option<&SpeciesLight<'_>>| {
            let lighting = lit_by(&subject.settings, &chosen, sun, args.ambient)?;
            let name = flb_stage::frames::subject(sun);
            relit(args, light, &mesh, (&subject.settings, &lighting, &name), &stages)
        };
        let picture = take(&subject, light.as_ref())?;
        let Some((other, light)) = other.as_ref().zip(other_light.as_ref()) else {
            pictures.push(picture);
            continue;
        };
        let beside = take(other, light.as_ref())?;
        let difference = picture.difference(&beside, args.times)?;
        squares.add(&picture.tone_mapped(settings.exposure), &beside.tone_mapped(settings.exposure));
        pictures.extend([picture, beside, difference]);
    }
    let picture = match pictures.len() {
        1 => pictures.remove(0),
        _ => contact_sheet(&pictures, SHEET_GAP)?,
    };
    write(&args.output, args.force, &picture, format, settings.exposure)?;
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

/// A sun and a sky; without a sun, the sky alone.
fn lit_by(
    settings: &Settings,
    sky: &StageSky,
    sun: Option<[f64; 2]>,
    ambient: Option<f32>,
) -> Result<Lighting, Failure> {
    let units = settings.shading.units();
    Ok(sky.lighting((sun, settings.sun_strength(sun)), (settings.ambient, ambient), units)?)
}

/// One picture in a light, which has a name.
fn relit(
    args: &RenderArgs,
    light: Option<&SpeciesLight<'_>>,
    ClassedMesh { mesh, classes }: &ClassedMesh,
    (settings, lighting, subject): (&Settings, &Lighting, &str),
    stages: &Stages,
) -> Result<Picture, Failure> {
    let Settings { shading, portrait, look, .. } = settings;
    let plant = Species { mesh, classes, shading: *shading };
    if args.path_traced {
        let traced = stages.run(Step::Render, subject, |progress| {
            render_reference(&plant, portrait, lighting, look, progress)
        })?;
        return Ok(traced.picture);
    }
    let uneven = match (&lighting.dome, light) {
        (Some(dome), Some(light)) => {
            Some(stages.run(Step::Sky, subject, |_| light.sky(&dome.patches(), &Transform::IDENTITY))?)
        }
        _ => None,
    };
    let lit = light.map(|light| under(light, uneven.as_ref(), settings, lighting, stages)).transpose()?;
    let cursors = LightCursors::new(std::slice::from_ref(&lit));
    let light = |query: LightQuery, phi: &mut [f32; 3]| cursors.at_facing(0, query.point, query.facing, phi);
    Ok(stages.run(Step::Render, subject, |progress| {
        render_plant(&plant, portrait, lighting, look, &light, progress)
    })?)
}

/// Light of a plant that stands as its model does.
fn under<'l>(
    light: &'l SpeciesLight<'_>,
    uneven: Option<&'l SkyLight<'l>>,
    settings: &Settings,
    lighting: &Lighting,
    stages: &Stages,
) -> Result<InstanceLight<'l>, Failure> {
    check_sky(light, settings.ambient)?;
    let sky = if uneven.is_some() { 0.0 } else { even_sky(settings.ambient) };
    let lit = light.lit_by_in_model(&Daylight { sky, ..lighting.daylight })?;
    let lit = match uneven {
        Some(sky) => lit.with_sky(sky, lighting.sun_color),
        None => lit,
    };
    match settings.shading.surfaces() {
        None => Ok(lit),
        Some(_) => Ok(stages.run(Step::Prepare, "", |_| lit.prepared())),
    }
}

/// What the flags ask for, of a file of its model. The sun comes later.
fn settings(args: &RenderArgs, meta: &SpeciesMeta) -> Result<Settings, Failure> {
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
    if meta.physical().is_some_and(|(_, light)| light.field == FieldKind::Total) && !args.path_traced {
        say!("warning: the fields hold the sun's beam, which shadow rays add again: the sun counts twice");
    }
    let ([width, height], view) = (args.size.unwrap_or([512; 2]), args.view.unwrap_or([180.0, 8.0]));
    let look = Look::default();
    Ok(Settings {
        shading,
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
            indirect: indirect(args.indirect),
            indirect_scale: args.indirect_scale.unwrap_or(look.indirect_scale),
            ..look
        },
        ambient: args.ambient.unwrap_or(units.default_sky()),
        exposure: args.exposure.unwrap_or(units.default_exposure()),
    })
}
