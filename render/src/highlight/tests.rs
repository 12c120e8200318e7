use flb_scene::MaterialClass;

use super::{Highlight, Highlights};
use crate::tests::{Setup, at, material, plain, render, wall};

#[test]
fn a_highlight_is_the_cosine_of_the_mirrored_sun_and_the_eye_to_an_exponent() {
    // A wall that is looked at along its normal: the mirrored sun is as far from the eye as the sun is.
    let mesh = wall(material("wall", [0.0; 3]), vec![], 1.0);
    let seen = |class, highlights, degrees: f64| {
        let radians = degrees.to_radians();
        let setup = Setup { sun: [libm::sin(radians), 0.0, libm::cos(radians)], highlights, ..plain() };
        at(&render(&mesh, &[class], &|_, phi| *phi = [0.0; 3], &setup).unwrap(), 16, 16)[0]
    };
    let of = |strength, exponent| Highlight { strength, exponent };
    let both = Highlights { leaf: of(0.5, 8.0), wood: of(0.25, 3.0), water: Highlight::MATT };
    for degrees in [0.0f64, 20.0, 60.0] {
        let cosine = libm::cos(degrees.to_radians());
        let [leaf, wood] =
            [MaterialClass::Leaf, MaterialClass::Wood].map(|class| f64::from(seen(class, both, degrees)));
        // The ray of the pixel is not quite the normal.
        assert!((leaf - 0.5 * libm::pow(cosine, 8.0)).abs() < 0.02, "{degrees}: {leaf}");
        assert!((wood - 0.25 * libm::pow(cosine, 3.0)).abs() < 0.01, "{degrees}: {wood}");
    }
    assert_eq!(seen(MaterialClass::Leaf, both, 120.0), 0.0, "the sun stands behind the wall");
    assert_eq!(seen(MaterialClass::Wood, Highlights::default(), 0.0), 0.0, "wood is matt by default");
    assert!(seen(MaterialClass::Leaf, Highlights::default(), 0.0) > 0.07);
}
