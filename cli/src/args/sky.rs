//! The sky of a picture.

use std::path::PathBuf;

use clap::Args;

#[derive(Args)]
pub(crate) struct SkyArgs {
    /// The sky over `physical` files: `even` from all sides; `clear`, blue and bright around its sun, which has its
    /// colour and strength by elevation too; or an image of the whole sphere (.exr or .hdr, width twice the height,
    /// north in its middle), whose light has the fluence of --ambient. Under an image --sun may be left out [default:
    /// the scene's, else even]
    #[arg(long, value_name = "even|clear|FILE")]
    pub sky: Option<PathBuf>,
    /// How hazy a clear sky is, 2 to 10 [default: the scene's, else 3]
    #[arg(long, value_name = "T")]
    pub turbidity: Option<f64>,
    /// An image of the whole sphere, as for --sky, that is drawn where no plant is, as bright in the mean as the
    /// sky that lights, and mirrored by water. It lights nothing [default: the scene's, else the sky that lights]
    #[arg(long, value_name = "FILE")]
    pub backdrop: Option<PathBuf>,
}
