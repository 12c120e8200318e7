use flb_format::Container;

use super::*;

fn golden(name: &str) -> Vec<u8> {
    let path = format!("{}/../format-spec/golden/{name}.flb", env!("CARGO_MANIFEST_DIR"));
    std::fs::read(path).expect("golden files are in the repository")
}

#[test]
fn a_golden_file_is_valid_at_every_level() {
    for (level, name) in Level::ALL {
        assert_eq!(Level::from_name(name), Some(level));
        let report = validate(&golden("haar-paper"), level);
        assert!(report.valid && report.issues.is_empty() && report.class.is_none(), "{report:?}");
    }
    assert_eq!(Level::from_name("all"), None);
}

#[test]
fn info_names_the_codec_of_16_bits_and_its_pages_are_half_as_large() {
    let bytes = golden("raw-f16");
    let info = crate::info(&Container::open(&bytes).expect("it opens"));
    assert!(info.species.iter().all(|species| species.codec == "raw-f16" && species.threshold == 0.0));
    let bases: Vec<_> = info.sections.iter().filter(|section| section.kind == "base").collect();
    let sizes: Vec<u64> = bases.iter().map(|section| section.raw_bytes).collect();
    assert_eq!(sizes, [3, 3, 2].map(|bands| 2 * 4096 * bands));
    assert!(bases.iter().all(|section| section.codec == "raw-f16"));
    assert!(validate(&bytes, Level::Decode).valid);
}

#[test]
fn each_level_finds_what_the_one_before_does_not_look_at() {
    let good = golden("raw-f32");
    let damaged = |at: usize| {
        let mut bytes = good.clone();
        bytes[at] ^= 1;
        bytes
    };
    let container = Container::open(&good).expect("it opens");
    let padding = container.header().tables_end as usize;
    let table = [
        (Level::Header, damaged(20), "FLB-1005", "header at byte 120"),
        (Level::Tables, damaged(130), "FLB-2002", "table of contents at byte 128"),
        (Level::Pages, damaged(padding), "FLB-4004", "padding at byte "),
        (Level::Pages, damaged(good.len() - 1), "FLB-4001", "page 2 of base 1 of species 0 at byte "),
    ];
    for (level, bytes, code, place) in table {
        for (other, name) in Level::ALL {
            let report = validate(&bytes, other);
            assert_eq!(report.valid, other < level, "{code} at level {name}");
            if let Some(issue) = report.issues.first() {
                assert_eq!(issue.code, code);
                assert!(issue.place.starts_with(place), "{issue:?}");
                assert!(issue.message.contains(code) && issue.message.contains(&issue.place), "{issue:?}");
                assert_eq!(report.class, Some(ErrorClass::Invalid));
            }
        }
    }
}

#[test]
fn the_report_serialises_to_its_schema() {
    let json = serde_json::to_value(validate(&b"no".to_vec(), Level::Header)).expect("it serialises");
    assert_eq!(json["valid"], false);
    let mut keys: Vec<_> = json["issues"][0].as_object().expect("an object").keys().collect();
    keys.sort();
    assert_eq!(keys, ["code", "message", "place"]);
    assert_eq!(json["issues"][0]["code"], "FLB-1001");
}

#[test]
fn info_of_a_golden_file_tells_what_it_holds() {
    let bytes = golden("haar-paper");
    let info = crate::info(&Container::open(&bytes).expect("it opens"));
    let json = serde_json::to_value(&info).expect("it serialises");
    assert_eq!(json["format_version"], "1.0");
    let sphere = &json["species"][0];
    assert_eq!((sphere["name"].as_str(), sphere["lattice"].as_u64()), (Some("sphere"), Some(16)));
    assert_eq!(sphere["bases"], serde_json::json!([0, 4]));
    assert_eq!(sphere["bands"], serde_json::json!(["R", "G", "B"]));
    assert_eq!((sphere["codec"].as_str(), sphere["spacing_m"].as_f64()), (Some("haar-paper"), Some(0.125)));
    assert_eq!(sphere["bounds"], serde_json::json!([[-0.75, 0.25, -0.75], [0.75, 1.75, 0.75]]));
    let sections = info.sections.iter().map(|s| s.bytes).sum::<u64>();
    let of_species = info.species.iter().map(|s| s.bytes - s.shared_bytes).sum::<u64>();
    let pages = info.sections.iter().map(|s| u64::from(s.pages)).sum::<u64>();
    assert!((of_species..of_species + 16 * pages).contains(&sections), "{of_species} of {sections}");
    // Both species have one medium, of which the second stores nothing.
    assert!(info.species[0].shared_bytes < info.species[1].shared_bytes, "{info:?}");
    assert_eq!(info.sections.len(), 2 + 8 + 3);
}
