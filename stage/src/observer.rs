//! Who hears how the work is coming along.

/// A step of the work on frames.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Step {
    /// Light is read.
    Load,
    /// The scene is made ready for rays, or light for skies.
    Prepare,
    /// What plants do to each other's light is found for a sun.
    Shade,
    /// What the camera sees is found.
    Trace,
    /// What an uneven sky gives each plant is found.
    Sky,
    /// What the camera sees is lit.
    Relight,
}

impl Step {
    /// One lower-case word.
    pub fn name(self) -> &'static str {
        match self {
            Step::Load => "load",
            Step::Prepare => "prepare",
            Step::Shade => "shade",
            Step::Trace => "trace",
            Step::Sky => "sky",
            Step::Relight => "relight",
        }
    }
}

/// Hears of steps as they begin, go on and end, and of what a user should know. All is optional.
pub trait Observer: Sync {
    /// A step begins; the subject is a sun, a GPU or nothing.
    fn begin(&self, _step: Step, _subject: &str) {}
    /// The share of the step that is done, 0..=1; from any thread.
    fn progress(&self, _share: f64) {}
    /// It ends.
    fn end(&self, _step: Step) {}
    /// Something that a user should know, such as which GPU draws.
    fn note(&self, _text: &str) {}
}

/// Hears nothing.
#[derive(Debug, Clone, Copy, Default)]
pub struct Unobserved;

impl Observer for Unobserved {}

/// Does the work of a step, with `progress` to tell how far it is.
pub(crate) fn step<T>(
    observer: &dyn Observer,
    step: Step,
    subject: &str,
    work: impl FnOnce(&(dyn Fn(f64) + Sync)) -> T,
) -> T {
    observer.begin(step, subject);
    let done = work(&|share| observer.progress(share));
    observer.end(step);
    done
}
