//! The sun's highlights in a picture.

use clap::Args;
use flb_scene::scene::{HIGHLIGHT_EXPONENTS, HighlightChoice, MAX_HIGHLIGHT};

#[derive(Args)]
pub(crate) struct HighlightArgs {
    /// Strength K and exponent S of the sun's highlight K (v.r)^S on `leaf`, `wood` or `water`, of `paper` files: v
    /// points to the eye, r to the mirrored sun. Repeat it for each [default: the scene's, else leaf=0.08,6; wood and
    /// water have none]
    #[arg(long, value_name = "SURFACE=K,S", value_parser = highlight)]
    pub highlight: Vec<HighlightChoice>,
}

impl HighlightArgs {
    /// What was chosen; of two for one surface, the last.
    pub(crate) fn choice(&self) -> HighlightChoice {
        self.highlight.iter().fold(HighlightChoice::default(), |all, one| one.or(all))
    }
}

fn highlight(text: &str) -> Result<HighlightChoice, String> {
    let expected = || format!("found {text:?}, expected leaf, wood or water, then =K,S, such as leaf=0.08,6");
    let (surface, numbers) = text.split_once('=').ok_or_else(expected)?;
    let (strength, exponent) = numbers.split_once(',').ok_or_else(expected)?;
    let number = |text: &str| text.trim().parse::<f64>().map_err(|_| expected());
    let (strength, exponent) = (number(strength)?, number(exponent)?);
    let [low, high] = HIGHLIGHT_EXPONENTS;
    if !(0.0..=MAX_HIGHLIGHT).contains(&strength) {
        return Err(format!("strength {strength}, expected 0 to {MAX_HIGHLIGHT}"));
    }
    if !(low..=high).contains(&exponent) {
        return Err(format!("exponent {exponent}, expected {low} to {high}"));
    }
    let chosen = Some([strength as f32, exponent as f32]);
    let none = HighlightChoice::default();
    match surface {
        "leaf" => Ok(HighlightChoice { leaf: chosen, ..none }),
        "wood" => Ok(HighlightChoice { wood: chosen, ..none }),
        "water" => Ok(HighlightChoice { water: chosen, ..none }),
        _ => Err(expected()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_highlight_is_of_one_surface_and_the_last_one_counts() {
        let choice = |texts: &[&str]| {
            let highlight = texts.iter().map(|text| highlight(text).expect(text)).collect();
            HighlightArgs { highlight }.choice()
        };
        assert!(!choice(&[]).is_any());
        let both = choice(&["leaf=0.1,8", "water=2,500", "leaf=0.2,9"]);
        assert_eq!(both, HighlightChoice { leaf: Some([0.2, 9.0]), wood: None, water: Some([2.0, 500.0]) });
        for bad in
            ["leaf", "leaf=1", "bark=1,2", "leaf=-1,2", "leaf=1,0", "leaf=nan,2", "leaf=1,1e9", "leaf=1,2,3"]
        {
            assert!(highlight(bad).is_err(), "{bad}");
        }
    }
}
