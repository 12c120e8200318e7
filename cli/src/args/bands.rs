//! Which bands pictures show.

use clap::Args;

#[derive(Args, Default)]
pub(crate) struct BandArgs {
    /// Show these bands as red, green and blue, by their names; one alone as grey [default: R, G and B]
    #[arg(long, value_name = "A,B,C", value_delimiter = ',')]
    pub show_bands: Vec<String>,
}
