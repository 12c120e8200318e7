//! Buffers and buffer views of a glTF as checked byte slices: the BIN chunk, data URIs, external
//! files, and views that EXT_meshopt_compression unpacks.

use base64::Engine;
use flb_format::text::url::shown_reference;
use gltf::json::Root;
use serde::Deserialize;

use super::meshopt_view::{self, Compressed};
use crate::import::error::ImportError;
use crate::import::files::{Files, Found};
use crate::import::limits;

/// The bytes of every buffer that has some, and of every view that had to be unpacked.
pub(super) struct Buffers {
    buffers: Vec<Option<Vec<u8>>>,
    unpacked: Vec<Option<Vec<u8>>>,
    /// Memory that was held for all of it.
    pub held_bytes: u64,
}

/// The bytes of a view and the distance between its elements, where it states one.
#[derive(Clone, Copy)]
pub(super) struct View<'a> {
    /// The whole view.
    pub bytes: &'a [u8],
    /// Bytes from one element to the next.
    pub stride: Option<usize>,
}

impl Buffers {
    /// Reads all buffers of `root` and unpacks compressed views.
    pub(super) fn load(
        files: &mut Files,
        root: &Root,
        mut binary: Option<Vec<u8>>,
    ) -> Result<Buffers, ImportError> {
        let mut total = 0u64;
        let mut buffers = Vec::with_capacity(root.buffers.len());
        for (index, buffer) in root.buffers.iter().enumerate() {
            let place = format!("buffers[{index}]");
            let bytes = match &buffer.uri {
                Some(uri) if uri.starts_with("data:") => Some(decode_data_uri(files, &place, uri)?),
                Some(uri) => Some(read_external(files, &place, uri)?),
                // Only the first buffer may be the BIN chunk. Others without a source are the
                // fallbacks of compressed views: an error only if something reads them.
                None if index == 0 => binary.take(),
                None => None,
            };
            if let Some(bytes) = &bytes {
                files.hold("buffers", bytes.len() as u64)?;
                let stated = buffer.byte_length.0;
                if stated > bytes.len() as u64 {
                    let found = format!("{} bytes", bytes.len());
                    return Err(files.malformed(place, found, format!("byteLength {stated}")));
                }
                total = total.saturating_add(bytes.len() as u64);
                files.limit("bytes of all buffers", total, limits::BUFFER_BYTES)?;
            }
            buffers.push(bytes);
        }
        let mut loaded = Buffers { buffers, unpacked: Vec::new(), held_bytes: total };
        loaded.unpack(files, root)?;
        Ok(loaded)
    }

    fn unpack(&mut self, files: &mut Files, root: &Root) -> Result<(), ImportError> {
        let mut total = 0u64;
        let mut unpacked = Vec::with_capacity(root.buffer_views.len());
        for (index, view) in root.buffer_views.iter().enumerate() {
            let extension = view.extensions.as_ref().and_then(|extensions| {
                let others = &extensions.others;
                others.get("EXT_meshopt_compression").or_else(|| others.get("KHR_meshopt_compression"))
            });
            let Some(extension) = extension else {
                unpacked.push(None);
                continue;
            };
            let place = format!("bufferViews[{index}].extensions.EXT_meshopt_compression");
            let compressed = Compressed::deserialize(extension)
                .map_err(|error| files.malformed(&place, error, "the extension's members"))?;
            let size = compressed.unpacked_bytes(files, &place)?;
            total = total.saturating_add(size);
            files.limit("bytes that EXT_meshopt_compression unpacks", total, limits::BUFFER_BYTES)?;
            files.hold("unpacked buffers", size)?;
            files.room_for("the unpacking of buffers", size)?;
            let source =
                self.range(files, &place, compressed.buffer, compressed.byte_offset, compressed.byte_length)?;
            unpacked.push(Some(meshopt_view::unpack(files, &place, &compressed, source)?));
        }
        self.unpacked = unpacked;
        self.held_bytes += total;
        Ok(())
    }

    /// The bytes of view `index`.
    pub(super) fn view(
        &self,
        files: &Files,
        root: &Root,
        place: &str,
        index: usize,
    ) -> Result<View<'_>, ImportError> {
        let Some(view) = root.buffer_views.get(index) else {
            let found = format!("bufferView {index}");
            return Err(files.malformed(place, found, format!("one of {}", root.buffer_views.len())));
        };
        let stride = view.byte_stride.map(|stride| stride.0).filter(|&stride| stride > 0);
        if let Some(Some(bytes)) = self.unpacked.get(index) {
            return Ok(View { bytes, stride });
        }
        let place = format!("bufferViews[{index}]");
        let offset = view.byte_offset.map_or(0, |offset| offset.0);
        let bytes = self.range(files, &place, view.buffer.value(), offset, view.byte_length.0)?;
        Ok(View { bytes, stride })
    }

    fn range(
        &self,
        files: &Files,
        place: &str,
        buffer: usize,
        offset: u64,
        length: u64,
    ) -> Result<&[u8], ImportError> {
        let Some(bytes) = self.buffers.get(buffer) else {
            let expected = format!("one of {}", self.buffers.len());
            return Err(files.malformed(place, format!("buffer {buffer}"), expected));
        };
        let Some(bytes) = bytes else {
            return Err(files.malformed(
                place,
                format!("buffer {buffer}, which has no data"),
                "a buffer with data",
            ));
        };
        let end = offset.checked_add(length).filter(|&end| end <= bytes.len() as u64);
        match end {
            Some(end) => Ok(&bytes[offset as usize..end as usize]),
            None => {
                let found = format!("bytes {offset} + {length}");
                Err(files.malformed(
                    place,
                    found,
                    format!("to end within the {} of buffer {buffer}", bytes.len()),
                ))
            }
        }
    }
}

fn read_external(files: &mut Files, place: &str, uri: &str) -> Result<Vec<u8>, ImportError> {
    match files.find(place, uri, &[])? {
        Found::File(path) => files.read(&path, limits::FILE_BYTES),
        Found::Missing(looked_for) => Err(ImportError::MissingFile {
            file: files.file.clone(),
            place: place.to_owned(),
            uri: shorten(uri),
            looked_for,
        }),
    }
}

/// The bytes of a `data:[type][;base64],...` URI.
pub(super) fn decode_data_uri(files: &Files, place: &str, uri: &str) -> Result<Vec<u8>, ImportError> {
    files.room_for(&format!("the data URI of {place}"), 2 * uri.len() as u64)?;
    let malformed = |found: String| files.malformed(place, found, "a data URI: data:[type][;base64],data");
    let (head, data) = uri.split_once(',').ok_or_else(|| malformed(shorten(uri)))?;
    if !head.ends_with(";base64") {
        return Ok(percent_encoding::percent_decode_str(data).collect());
    }
    // Some exporters leave out the padding, some break lines.
    let compact: Vec<u8> = data.bytes().filter(|byte| !byte.is_ascii_whitespace() && *byte != b'=').collect();
    base64::engine::general_purpose::STANDARD_NO_PAD
        .decode(compact)
        .map_err(|error| malformed(format!("base64 that does not decode ({error})")))
}

/// A URI for a message.
pub(super) fn shorten(uri: &str) -> String {
    let uri = shown_reference(uri);
    match uri.char_indices().nth(80) {
        Some((end, _)) => format!("{}...", &uri[..end]),
        None => uri.into_owned(),
    }
}
