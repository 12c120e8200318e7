use crate::SpeciesFile;

#[test]
fn mistakes_of_colors_are_named_with_their_place() {
    let error = |text: &str| SpeciesFile::parse("a.toml", text).unwrap_err().to_string();
    let word = error("leaf_colour = \"green\"");
    assert!(word.contains("leaf_colour") && word.contains("\"texture\" or \"measured\""), "{word}");
    let entry = error("leaf_colour = [{ colour = \"texture\" }, { colour = \"mesured\" }]");
    assert!(entry.contains("leaf_colour[1].colour") && entry.contains("mesured"), "{entry}");
    let wood = error("wood_colour = [{ colour = \"brown\" }]");
    assert!(wood.contains("wood_colour[0].colour") && wood.contains("brown"), "{wood}");
    let long = format!("leaf_colour = [{{ material = {:?}, colour = \"texture\" }}]", "a".repeat(257));
    assert!(error(&long).contains("leaf_colour[0].material"), "{long}");
}

#[test]
fn surfaces_of_materials_have_the_bands_of_the_rest() {
    let band = |head: &str, name: &str| {
        format!(
            "[[surfaces]]\n{head}name = \"{name}\"\nleaf = {{ reflectance = 0.5, transmittance = 0.4 }}\n"
        )
    };
    let of = |bands: &[(&str, &str)]| {
        let text: String = bands.iter().map(|(head, name)| band(head, name)).collect();
        SpeciesFile::parse("a.toml", &text)
    };
    let petal = "material = \"petal\"\n";
    let species = of(&[(petal, "R"), (petal, "G"), (petal, "B")]).unwrap();
    assert_eq!((species.surfaces, species.sets.len()), (None, 1));
    let [set] = &species.sets[..] else { panic!("one set") };
    assert_eq!((set.pattern.as_str(), set.surfaces.bands[2].leaf.reflectance), ("petal", 0.5));
    // The wood is that of the rest.
    assert_eq!(set.surfaces.bands[0].wood, crate::leaf::knapp_carter().bands[0].wood);

    let error = of(&[(petal, "R"), (petal, "G")]).unwrap_err().to_string();
    assert!(
        error.contains("surfaces[0].name") && error.contains("R, G, B, as everything else has"),
        "{error}"
    );
    let error = of(&[("material = \"\"\n", "R")]).unwrap_err().to_string();
    assert!(error.contains("surfaces[0].material"), "{error}");
    let error = of(&[("", "R")]).unwrap_err().to_string();
    assert!(error.contains("surfaces[0].wood") && error.contains("nothing"), "{error}");
}
