//! What pictures show: light, parts of it, or what it is made of.

use std::fmt;
use std::str::FromStr;

use flb_render::settings::MAX_PIXELS;
use flb_render::{Indirect, Look};

use crate::StageError;

/// Content of a picture, or of one of its layers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum SceneShow {
    /// Light, or those parts of it that the look asks for.
    #[default]
    Light,
    /// Light straight from the sun, and the sky behind.
    Direct,
    /// All other light, before black. In linear light it and [`SceneShow::Direct`] make [`SceneShow::Light`].
    Indirect,
    /// Light of one base by itself, by its place among those of each species, on the CPU.
    Base(u16),
    /// Scene light by itself, on the CPU, in grey: the light that plants have among their neighbours over the light
    /// that they have alone, the sun and the sky together, linear. The sun is white, of irradiance 1, and alone.
    Global,
    /// How much of each pixel is covered by plants, ground and water, on the CPU. Beside it no picture has a sky behind
    /// ([`Look::has_backdrop`]).
    Alpha,
}

impl SceneShow {
    /// Words that [`FromStr`] takes.
    pub const EXPECTED: &str = "light, direct, indirect, base:N, global or alpha";

    /// The look of a picture of it.
    pub(crate) fn look(self, look: &Look) -> Look {
        let indirect = match self {
            SceneShow::Light | SceneShow::Global | SceneShow::Alpha => look.indirect,
            SceneShow::Direct => Indirect::Off,
            SceneShow::Indirect | SceneShow::Base(_) => Indirect::Only,
        };
        Look { indirect, ..*look }
    }

    /// Whether it is light, of all suns.
    pub(crate) fn is_light(self) -> bool {
        matches!(self, SceneShow::Light | SceneShow::Direct | SceneShow::Indirect)
    }
}

impl fmt::Display for SceneShow {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            SceneShow::Light => out.write_str("light"),
            SceneShow::Direct => out.write_str("direct"),
            SceneShow::Indirect => out.write_str("indirect"),
            SceneShow::Base(base) => write!(out, "base:{base}"),
            SceneShow::Global => out.write_str("global"),
            SceneShow::Alpha => out.write_str("alpha"),
        }
    }
}

impl FromStr for SceneShow {
    type Err = String;

    fn from_str(text: &str) -> Result<SceneShow, String> {
        Ok(match text {
            "light" => SceneShow::Light,
            "direct" => SceneShow::Direct,
            "indirect" => SceneShow::Indirect,
            "global" => SceneShow::Global,
            "alpha" => SceneShow::Alpha,
            _ => match text.strip_prefix("base:").map(str::parse) {
                Some(Ok(base)) => SceneShow::Base(base),
                _ => return Err(format!("found {text:?}, expected {}", SceneShow::EXPECTED)),
            },
        })
    }
}

/// Looks and needs of a list of contents.
pub(crate) struct Shows<'a>(pub &'a [SceneShow]);

impl Shows<'_> {
    /// The look that all have; beside alpha there is no sky behind.
    pub(crate) fn look(&self, look: Look) -> Look {
        Look { has_backdrop: look.has_backdrop && !self.0.contains(&SceneShow::Alpha), ..look }
    }

    /// Whether any shows what files hold.
    pub(crate) fn has_fields(&self, look: &Look) -> bool {
        let shows = |show: &SceneShow| *show != SceneShow::Alpha && show.look(look).indirect != Indirect::Off;
        self.0.iter().any(shows)
    }

    /// Whether any is of bases, whatever the suns.
    pub(crate) fn has_bases(&self) -> bool {
        self.0.iter().any(|show| matches!(show, SceneShow::Base(_)))
    }

    /// Whether the CPU alone can show all of them.
    pub(crate) fn needs_cpu(&self) -> bool {
        self.0.iter().any(|show| !show.is_light())
    }

    /// Refuses an empty list, contents that are there twice, bases that species of at most so many do not have, and
    /// more layers of a size than memory is promised for.
    pub(crate) fn check(&self, bases: usize, size: [u32; 2]) -> Result<(), StageError> {
        if self.0.is_empty() {
            return Err(StageError::Shows("nothing".to_owned()));
        }
        for (at, show) in self.0.iter().enumerate() {
            if self.0[..at].contains(show) {
                return Err(StageError::Shows(format!("{show} twice")));
            }
            if let SceneShow::Base(base) = show
                && usize::from(*base) >= bases
            {
                return Err(StageError::NoBase { base: *base, last: bases.saturating_sub(1) });
            }
        }
        let pixels = size.into_iter().map(u64::from).product::<u64>().saturating_mul(self.0.len() as u64);
        match self.0.len() > 1 && pixels > MAX_PIXELS {
            true => Err(StageError::LayerPixels { found: pixels, limit: MAX_PIXELS }),
            false => Ok(()),
        }
    }
}
