//! Typed, bounds-checked reading of glTF accessors: strided, interleaved, normalised, quantised and
//! sparse. Bounds are checked once when an accessor is opened; elements are read where they lie, so
//! that cost follows what is used, not what a file declares.

use gltf::json::accessor::{ComponentType, GenericComponentType, IndexComponentType, Type};
use gltf::json::validation::Checked;
use gltf::json::{Accessor as Json, Root};

use super::buffers::Buffers;
use crate::import::error::ImportError;
use crate::import::files::Files;
use crate::import::limits;

/// Elements of up to 16 components.
pub(super) struct Accessor<'a> {
    /// Number of elements.
    pub count: usize,
    /// Components per element.
    pub lanes: usize,
    dense: Option<Strided<'a>>,
    sparse: Option<Sparse<'a>>,
    component: ComponentType,
    normalized: bool,
}

/// Elements in bytes: all of `count` elements are known to lie inside.
#[derive(Clone, Copy)]
struct Strided<'a> {
    bytes: &'a [u8],
    stride: usize,
}

/// Replacements: `indices` ascend and are below the accessor's count.
struct Sparse<'a> {
    count: usize,
    indices: Strided<'a>,
    index_type: ComponentType,
    values: Strided<'a>,
}

/// Opens accessors of one file; counts the work that its size does not bound.
pub(super) struct Accessors<'a> {
    /// The file's JSON.
    pub root: &'a Root,
    /// The file's bytes.
    pub buffers: &'a Buffers,
    /// Sparse elements and skin joints read so far.
    pub work: u64,
}

impl<'a> Accessors<'a> {
    /// Opens accessor `index`, which must be of one of `types` and hold at most `most` elements.
    /// `place` says who asks.
    pub(super) fn open(
        &mut self,
        files: &Files,
        place: &str,
        index: usize,
        types: &[Type],
        most: u64,
    ) -> Result<Accessor<'a>, ImportError> {
        let Some(json) = self.root.accessors.get(index) else {
            let expected = format!("one of {}", self.root.accessors.len());
            return Err(files.malformed(place, format!("accessor {index}"), expected));
        };
        let place = format!("accessors[{index}] ({place})");
        let (component, type_) = types_of(files, &place, json)?;
        if !types.contains(&type_) {
            return Err(files.malformed(place, format!("type {type_:?}"), format!("{types:?}")));
        }
        let lanes = type_.multiplicity();
        files.limit(format!("{place}: count"), json.count.0, most)?;
        let count = json.count.0 as usize;
        let size = component.size() * lanes;
        let dense = match json.buffer_view {
            Some(view) => {
                let offset = json.byte_offset.map_or(0, |offset| offset.0);
                Some(self.strided(files, &place, view.value(), offset, count, size)?)
            }
            None => None,
        };
        let sparse = match &json.sparse {
            Some(sparse) => {
                let (count, most) = (sparse.count.0, json.count.0);
                if count > most {
                    return Err(files.malformed(
                        &place,
                        format!("sparse.count {count}"),
                        format!("at most {most}"),
                    ));
                }
                let count = count as usize;
                let Checked::Valid(IndexComponentType(index_type)) = sparse.indices.component_type else {
                    return Err(files.malformed(
                        &place,
                        "an unknown componentType of sparse.indices",
                        "5121, 5123 or 5125",
                    ));
                };
                let (indices, values) = (&sparse.indices, &sparse.values);
                let (index_view, value_view) = (indices.buffer_view.value(), values.buffer_view.value());
                let sparse = Sparse {
                    count,
                    indices: self.strided(
                        files,
                        &place,
                        index_view,
                        indices.byte_offset.0,
                        count,
                        index_type.size(),
                    )?,
                    index_type,
                    values: self.strided(files, &place, value_view, values.byte_offset.0, count, size)?,
                };
                self.work += count as u64;
                files.limit("sparse elements read", self.work, 4 * limits::VERTICES)?;
                sparse.check(files, &place, json.count.0 as usize)?;
                Some(sparse)
            }
            None => None,
        };
        Ok(Accessor { count, lanes, dense, sparse, component, normalized: json.normalized })
    }

    fn strided(
        &self,
        files: &Files,
        place: &str,
        view: usize,
        offset: u64,
        count: usize,
        size: usize,
    ) -> Result<Strided<'a>, ImportError> {
        let view = self.buffers.view(files, self.root, place, view)?;
        let stride = view.stride.unwrap_or(size);
        if stride < size {
            return Err(files.malformed(place, format!("byteStride {stride}"), format!("at least {size}")));
        }
        let length = match count as u64 {
            0 => Some(0),
            count => (count - 1).checked_mul(stride as u64).and_then(|bytes| bytes.checked_add(size as u64)),
        };
        let end = length.and_then(|length| offset.checked_add(length));
        match end.filter(|&end| end <= view.bytes.len() as u64) {
            Some(end) => Ok(Strided { bytes: &view.bytes[offset.min(end) as usize..end as usize], stride }),
            None => {
                let found = format!("{count} elements of {size} bytes, {stride} apart, from byte {offset}");
                Err(files.malformed(
                    place,
                    found,
                    format!("to end within the view's {} bytes", view.bytes.len()),
                ))
            }
        }
    }
}

fn types_of(files: &Files, place: &str, json: &Json) -> Result<(ComponentType, Type), ImportError> {
    let Checked::Valid(GenericComponentType(component)) = json.component_type else {
        return Err(files.malformed(place, "an unknown componentType", "5120..=5123, 5125 or 5126"));
    };
    let Checked::Valid(type_) = json.type_ else {
        return Err(files.malformed(
            place,
            "an unknown type",
            "SCALAR, VEC2, VEC3, VEC4, MAT2, MAT3 or MAT4",
        ));
    };
    Ok((component, type_))
}

impl Accessor<'_> {
    /// An error unless components are of one of `kinds`: a type, and whether its integers are normalised.
    pub(super) fn check_components(
        &self,
        files: &Files,
        place: &str,
        kinds: &[(ComponentType, bool)],
    ) -> Result<(), ImportError> {
        let found = (self.component, self.normalized);
        if kinds.contains(&found) {
            return Ok(());
        }
        let word = |(component, normalized): (ComponentType, bool)| {
            format!("{}{component:?}", if normalized { "normalised " } else { "" })
        };
        let expected = kinds.iter().map(|&kind| word(kind)).collect::<Vec<_>>().join(" or ");
        Err(files.malformed(place, format!("components of {}", word(found)), expected))
    }

    /// The type of its components, and whether integers are normalised.
    pub(super) fn component(&self) -> (ComponentType, bool) {
        (self.component, self.normalized)
    }

    /// The components of element `index` (below `count`); without a view they are zero. Lanes that
    /// the element lacks stay as they are.
    pub(super) fn read(&self, index: usize, out: &mut [f64]) {
        assert!(index < self.count, "element {index} of {}", self.count);
        let replaced = self.sparse.as_ref().and_then(|sparse| sparse.find(index));
        let (source, at) = match (replaced, &self.dense) {
            (Some((values, at)), _) => (values, at),
            (None, Some(dense)) => (*dense, index),
            (None, None) => {
                out.iter_mut().take(self.lanes).for_each(|value| *value = 0.0);
                return;
            }
        };
        let size = self.component.size();
        let element = &source.bytes[at * source.stride..];
        for (value, bytes) in out.iter_mut().zip(element.chunks_exact(size)).take(self.lanes) {
            *value = component(bytes, self.component, self.normalized);
        }
    }

    /// Element `index` as `N` components.
    pub(super) fn get<const N: usize>(&self, index: usize) -> [f64; N] {
        let mut out = [0.0; N];
        self.read(index, &mut out);
        out
    }

    /// Element `index` as a whole number; `None` if it is not one.
    pub(super) fn get_index(&self, index: usize) -> Option<u32> {
        let [value] = self.get::<1>(index);
        (value >= 0.0 && value <= f64::from(u32::MAX) && value.fract() == 0.0).then_some(value as u32)
    }
}

impl<'a> Sparse<'a> {
    fn index(&self, at: usize) -> usize {
        component(&self.indices.bytes[at * self.indices.stride..], self.index_type, false) as usize
    }

    fn check(&self, files: &Files, place: &str, count: usize) -> Result<(), ImportError> {
        let mut next = 0;
        for at in 0..self.count {
            let index = self.index(at);
            if index < next || index >= count {
                let expected = format!("ascending indices below {count}");
                return Err(files.malformed(place, format!("sparse index {index} at {at}"), expected));
            }
            next = index + 1;
        }
        Ok(())
    }

    fn find(&self, index: usize) -> Option<(Strided<'a>, usize)> {
        let (mut low, mut high) = (0, self.count);
        while low < high {
            let middle = low + (high - low) / 2;
            match self.index(middle).cmp(&index) {
                std::cmp::Ordering::Less => low = middle + 1,
                std::cmp::Ordering::Greater => high = middle,
                std::cmp::Ordering::Equal => return Some((self.values, middle)),
            }
        }
        None
    }
}

/// glTF 2.0, section 3.6.2.2 and 3.11: little-endian; normalised integers span -1..=1 or 0..=1.
fn component(bytes: &[u8], kind: ComponentType, normalized: bool) -> f64 {
    let (value, largest) = match kind {
        ComponentType::I8 => (f64::from(bytes[0] as i8), 127.0),
        ComponentType::U8 => (f64::from(bytes[0]), 255.0),
        ComponentType::I16 => (f64::from(i16::from_le_bytes([bytes[0], bytes[1]])), 32767.0),
        ComponentType::U16 => (f64::from(u16::from_le_bytes([bytes[0], bytes[1]])), 65535.0),
        ComponentType::U32 => {
            (f64::from(u32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]])), 4294967295.0)
        }
        ComponentType::F32 => {
            return f64::from(f32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]));
        }
    };
    if normalized { (value / largest).max(-1.0) } else { value }
}
