use std::io::Cursor;

use exr::prelude as exr_read;
use flb_format::Grid;

use super::*;

const N: u32 = 16;

fn names() -> Vec<String> {
    ["R", "G", "B"].map(str::to_owned).to_vec()
}

/// Every value different, so that any mistake of order shows.
fn counting_field(bands: u32) -> Field {
    let mut field = Field::zeros(N, bands);
    field.values_mut().iter_mut().enumerate().for_each(|(i, v)| *v = i as f32 * 0.001);
    field
}

/// One leaf site of density 0.5 at (1, 2, 3) and one wood site of density 1 at (4, 5, 6).
fn medium() -> Medium {
    let grid = Grid { lattice: N, origin_m: [0.0; 3], spacing_m: 1.0 };
    let mut medium = Medium::empty(grid);
    let (leaf, wood) = (grid.index(1, 2, 3), grid.index(4, 5, 6));
    (medium.density[leaf], medium.class[leaf], medium.leaf_area_density[leaf]) = (0.5, Class::Leaf, 7.25);
    (medium.density[wood], medium.class[wood], medium.wood_area_density[wood]) = (1.0, Class::Wood, 3.5);
    medium
}

struct Sheet {
    width: u32,
    height: u32,
    rgb: Vec<u8>,
}

impl Sheet {
    fn read(bytes: &[u8]) -> Sheet {
        let mut reader = png::Decoder::new(Cursor::new(bytes)).read_info().unwrap();
        let mut rgb = vec![0; reader.output_buffer_size().unwrap()];
        let info = reader.next_frame(&mut rgb).unwrap();
        Sheet { width: info.width, height: info.height, rgb }
    }

    fn pixel(&self, x: u32, y: u32) -> [u8; 3] {
        std::array::from_fn(|c| self.rgb[(y * self.width + x) as usize * 3 + c])
    }

    /// Pixel of a site when all 16 slices are shown, 4 by 4.
    fn site(&self, [x, y, z]: [u32; 3]) -> [u8; 3] {
        self.pixel(z % 4 * (N + 1) + x, z / 4 * (N + 1) + N - 1 - y)
    }
}

#[test]
fn a_sheet_shows_every_site_upright_and_in_order() {
    let mut field = Field::zeros(N, 3);
    let grid = Grid { lattice: N, origin_m: [0.0; 3], spacing_m: 1.0 };
    let marks = [[0, 0, 0], [15, 0, 1], [0, 15, 2], [3, 7, 11], [15, 15, 15]];
    for (band, mark) in [0, 1, 2, 0, 1].into_iter().zip(marks) {
        field.values_mut()[band * grid.sites() + grid.index(mark[0], mark[1], mark[2])] = 2.0;
    }
    let sheet = Sheet::read(&slice_sheet_png(&Volume::Base { field: &field, bands: &names() }, N).unwrap());
    assert_eq!((sheet.width, sheet.height), (67, 67));
    for (band, mark) in [0, 1, 2, 0, 1].into_iter().zip(marks) {
        let mut expected = [0; 3];
        expected[band] = 255;
        assert_eq!(sheet.site(mark), expected, "{mark:?}");
    }
    assert_eq!(sheet.site([8, 8, 8]), [0; 3]);
    assert_eq!(sheet.pixel(16, 0), [64; 3], "a line between slices");
    let lit = sheet.rgb.iter().filter(|c| **c == 255).count();
    assert_eq!(lit, marks.len());
}

#[test]
fn fewer_slices_are_spread_evenly() {
    let field = counting_field(1);
    let sheet =
        |slices| Sheet::read(&slice_sheet_png(&Volume::Base { field: &field, bands: &[] }, slices).unwrap());
    assert_eq!((sheet(1).width, sheet(1).height), (16, 16));
    assert_eq!((sheet(3).width, sheet(3).height), (33, 33));
    assert_eq!((sheet(9999).width, sheet(0).height), (67, 16));
    // Slices at z = 4 and 12 of 16.
    let whole = sheet(N);
    assert_eq!(sheet(2).pixel(5, 5), whole.site([5, 10, 4]));
    assert_eq!(sheet(2).pixel(22, 5), whole.site([5, 10, 12]));
}

#[test]
fn a_sheet_is_normalised_to_the_largest_value_and_srgb_encoded() {
    let mut field = Field::zeros(N, 1);
    field.values_mut()[..5].copy_from_slice(&[4.0, 2.0, 0.4, -1.0, f32::NAN]);
    let sheet = Sheet::read(&slice_sheet_png(&Volume::Base { field: &field, bands: &[] }, N).unwrap());
    // 1, 0.5 and 0.1 in sRGB: known values of the standard's curve.
    let row: Vec<u8> = (0..5).map(|x| sheet.site([x, 0, 0])[0]).collect();
    assert_eq!(row, [255, 188, 89, 0, 0]);
    assert_eq!(sheet.site([1, 0, 0]), [188; 3], "one band is grey");
}

#[test]
fn a_volume_of_zeros_is_black() {
    let field = Field::zeros(N, 3);
    let sheet = Sheet::read(&slice_sheet_png(&Volume::Base { field: &field, bands: &names() }, 1).unwrap());
    assert!(sheet.rgb.iter().all(|c| *c == 0));
}

#[test]
fn every_8_bit_code_round_trips_through_the_table() {
    let encode = Srgb::new();
    for code in 0..=255u8 {
        let e = f64::from(code) / 255.0;
        let linear = if e <= 0.04045 { e / 12.92 } else { libm::pow((e + 0.055) / 1.055, 2.4) };
        assert_eq!(encode.byte(linear as f32), code);
    }
    assert_eq!((encode.byte(-1.0), encode.byte(2.0), encode.byte(f32::NAN)), (0, 255, 0));
}

#[test]
fn leaf_is_grey_and_wood_is_tinted() {
    let medium = medium();
    let sheet = Sheet::read(&slice_sheet_png(&Volume::Density(&medium), N).unwrap());
    assert_eq!(sheet.site([1, 2, 3]), [188; 3]);
    let [r, g, b] = sheet.site([4, 5, 6]);
    assert!(r == 255 && g < 230 && b < g, "{r} {g} {b}");
    assert_eq!(sheet.site([1, 2, 4]), [0; 3]);
}

#[test]
fn extinction_shows_both_its_parts() {
    let medium = medium();
    let turbid = TurbidMedium {
        grid: medium.grid,
        leaf_per_m: medium.leaf_area_density.iter().map(|area| area / 2.0).collect(),
        wood_per_m: medium.wood_area_density.iter().map(|area| area * 2.0).collect(),
        angles: flb_format::matter::LeafAngles::planophile(),
    };
    let volume = Volume::Extinction(&turbid);
    let sheet = Sheet::read(&slice_sheet_png(&volume, N).unwrap());
    let [r, g, b] = sheet.site([4, 5, 6]);
    assert!(r == 255 && g < 230 && b < g, "wood of 7 m^-1 is the largest and brown: {r} {g} {b}");
    let [r, g, b] = sheet.site([1, 2, 3]);
    assert!(r > 150 && r == g && g == b, "leaf of 3.625 m^-1 is grey: {r} {g} {b}");

    let bytes = volume_npy(&volume);
    let floats: Vec<f32> =
        bytes[bytes.len() - 2 * 4096 * 4..].as_chunks().0.iter().map(|b| f32::from_le_bytes(*b)).collect();
    assert!(String::from_utf8_lossy(&bytes[..128]).contains("(2, 16, 16, 16"));
    assert_eq!((&floats[..4096], &floats[4096..]), (&turbid.leaf_per_m[..], &turbid.wood_per_m[..]));
    let slice = &layers(&volume_exr(&volume).unwrap())[3].1;
    assert_eq!(
        slice.iter().map(|(name, _)| name.as_str()).collect::<Vec<_>>(),
        ["leaf_extinction", "wood_extinction"]
    );
    assert_eq!(slice[0].1.iter().filter(|value| **value == 3.625).count(), 1);
}

/// A channel's name and values.
type Channel = (String, Vec<f32>);

/// All layers of an EXR, each with its name.
fn layers(bytes: &[u8]) -> Vec<(String, Vec<Channel>)> {
    use exr_read::*;
    let image = read()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .all_layers()
        .all_attributes()
        .from_buffered(Cursor::new(bytes))
        .unwrap();
    let values = |channel: &AnyChannel<FlatSamples>| match &channel.sample_data {
        FlatSamples::F32(values) => (channel.name.to_string(), values.clone()),
        other => panic!("{} samples that are not 32-bit floats", other.len()),
    };
    image
        .layer_data
        .iter()
        .map(|layer| {
            let name = layer.attributes.layer_name.as_ref().expect("a named layer").to_string();
            (name, layer.channel_data.list.iter().map(values).collect())
        })
        .collect()
}

#[test]
fn exr_holds_every_value_of_a_base_exactly() {
    let field = counting_field(3);
    let layers = layers(&volume_exr(&Volume::Base { field: &field, bands: &names() }).unwrap());
    assert_eq!(layers.len(), N as usize);
    let n = N as usize;
    for (z, (name, channels)) in layers.iter().enumerate() {
        assert_eq!(*name, format!("z{z:03}"));
        assert_eq!(channels.iter().map(|c| c.0.as_str()).collect::<Vec<_>>(), ["B", "G", "R"]);
        for (band, (_, values)) in [2, 1, 0].into_iter().zip(channels) {
            for row in 0..n {
                let expected = &field.band(band)[(z * n + n - 1 - row) * n..][..n];
                assert_eq!(&values[row * n..][..n], expected, "layer {z}, band {band}, row {row}");
            }
        }
    }
}

#[test]
fn exr_of_the_density_holds_all_four_arrays() {
    let medium = medium();
    let layers = layers(&volume_exr(&Volume::Density(&medium)).unwrap());
    let channel = |z: usize, name: &str| &layers[z].1.iter().find(|c| c.0 == name).unwrap().1;
    let at = |x: usize, y: usize| (15 - y) * 16 + x;
    assert_eq!(channel(3, "density")[at(1, 2)], 0.5);
    assert_eq!(channel(3, "leaf_area_density")[at(1, 2)], 7.25);
    assert_eq!(channel(6, "class")[at(4, 5)], 2.0);
    assert_eq!(channel(6, "wood_area_density")[at(4, 5)], 3.5);
    let sum: f32 = (0..16).flat_map(|z| channel(z, "density")).sum();
    assert_eq!(sum, 1.5);
}

#[test]
fn exr_bytes_are_the_same_each_time() {
    let field = counting_field(3);
    let volume = Volume::Base { field: &field, bands: &names() };
    assert_eq!(volume_exr(&volume).unwrap(), volume_exr(&volume).unwrap());
}

#[test]
fn unfit_or_repeated_band_names_become_numbers() {
    let bands = ["R", "a.b", "R", ""].map(str::to_owned);
    let found: Vec<String> = (0..5).map(|band| channel_name(&bands, band)).collect();
    assert_eq!(found, ["band0", "band1", "band2", "band3", "band4"]);
    assert_eq!(channel_name(&names(), 1), "G");
}

/// The dictionary of a NumPy file, and its values.
fn read_npy(bytes: &[u8]) -> (&str, Vec<f32>) {
    assert_eq!(&bytes[..8], b"\x93NUMPY\x01\x00");
    let header = 10 + usize::from(u16::from_le_bytes([bytes[8], bytes[9]]));
    assert_eq!((header % 64, bytes[header - 1]), (0, b'\n'));
    let values = bytes[header..].as_chunks::<4>().0;
    assert_eq!(values.len() * 4, bytes.len() - header);
    (
        std::str::from_utf8(&bytes[10..header]).unwrap().trim_end(),
        values.iter().map(|value| f32::from_le_bytes(*value)).collect(),
    )
}

#[test]
fn npy_holds_every_value_exactly_in_the_documented_shape() {
    let field = counting_field(3);
    let bytes = volume_npy(&Volume::Base { field: &field, bands: &names() });
    let (dictionary, values) = read_npy(&bytes);
    assert_eq!(dictionary, "{'descr': '<f4', 'fortran_order': False, 'shape': (3, 16, 16, 16), }");
    assert_eq!(values, *field.values());

    let medium = medium();
    let bytes = volume_npy(&Volume::Density(&medium));
    let (dictionary, values) = read_npy(&bytes);
    assert!(dictionary.contains("'shape': (16, 16, 16), "), "{dictionary}");
    assert_eq!(values, medium.density);
}
