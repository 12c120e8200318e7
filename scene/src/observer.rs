//! Progress of long work: which step runs, how far it is, what a user should know; and a way to stop it.

use flb_format::progress::{Cancelled, Progress};

/// Step of a bake, of frames or of a judgement.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Step {
    /// A mesh is read and classified.
    Import,
    /// Voxels that leaf and wood touch are found.
    Voxelise,
    /// Voxels become sites.
    Downsample,
    /// The extinction of every site is measured on the mesh; `physical` only.
    Crown,
    /// The fields are solved.
    Solve,
    /// Photons are traced to judge the fields by; `physical`, where asked for.
    MonteCarlo,
    /// The light at solids is found.
    Solids,
    /// The media of a scene's plants are brought onto its lattice; scene light only.
    Merge,
    /// Fields are coded.
    Encode,
    /// A file is written.
    Write,
    /// Light is read.
    Load,
    /// A scene is made ready for rays, or light for suns and skies.
    Prepare,
    /// Light that plants take from each other is found for a sun.
    Shade,
    /// Camera rays, or paths on a mesh, are traced.
    Trace,
    /// Light of an uneven sky is found for each plant.
    Sky,
    /// Points that the camera sees are lit.
    Relight,
    /// A picture of a single plant is drawn.
    Render,
    /// Light of a file is compared with traced light.
    Judge,
    /// Sites of every lattice are counted.
    Survey,
    /// Bases are copied from file to file.
    Copy,
}

impl Step {
    /// Name in summaries: lower-case words.
    pub fn name(self) -> &'static str {
        match self {
            Step::Import => "import",
            Step::Voxelise => "voxelise",
            Step::Downsample => "downsample",
            Step::Crown => "crown",
            Step::Solve => "solve",
            Step::MonteCarlo => "monte carlo",
            Step::Solids => "solids",
            Step::Merge => "merge",
            Step::Encode => "encode",
            Step::Write => "write",
            Step::Load => "load",
            Step::Prepare => "prepare",
            Step::Shade => "shade",
            Step::Trace => "trace",
            Step::Sky => "sky",
            Step::Relight => "relight",
            Step::Render => "render",
            Step::Judge => "judge",
            Step::Survey => "survey",
            Step::Copy => "copy",
        }
    }

    /// Does the work of this step. The [`Progress`] that it gets asks the observer whether to stop, and tells the share
    /// that is done. The observer is told the end however it comes.
    pub fn run<T, O: Observer + ?Sized>(
        self,
        observer: &O,
        subject: &str,
        work: impl FnOnce(&Progress<'_>) -> T,
    ) -> T {
        struct Running<'a, O: Observer + ?Sized>(&'a O, Step);
        impl<O: Observer + ?Sized> Drop for Running<'_, O> {
            fn drop(&mut self) {
                self.0.end(self.1);
            }
        }
        observer.begin(self, subject);
        let _running = Running(observer, self);
        work(&|share| {
            if observer.is_cancelled() {
                return Err(Cancelled);
            }
            observer.progress(share);
            Ok(())
        })
    }
}

/// Follower of long work, who may stop it. Every method may do nothing.
pub trait Observer: Sync {
    /// Called when a step begins. `subject` is a species, a sun, a GPU, a lattice or nothing.
    fn begin(&self, step: Step, subject: &str) {
        let _ = (step, subject);
    }

    /// Called with the share of the step that is done, 0..=1; from any thread.
    fn progress(&self, share: f64) {
        let _ = share;
    }

    /// Called when the step has ended, by an error, too.
    fn end(&self, step: Step) {
        let _ = step;
    }

    /// Called with a sentence that a user should read, such as which GPU draws.
    fn note(&self, text: &str) {
        let _ = text;
    }

    /// Returns whether to stop. A step asks as it goes on, from any thread, and one of a bake when it begins, too; it
    /// then ends with [`Cancelled`] in its error. A step that tells no progress does not ask.
    fn is_cancelled(&self) -> bool {
        false
    }
}

/// Observer that does nothing.
#[derive(Debug, Clone, Copy, Default)]
pub struct Unobserved;

impl Observer for Unobserved {}
