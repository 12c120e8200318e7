//! The files that a mesh names, whether an import reads them or not: normal maps, other levels of detail. None of them
//! is to be overwritten by what is made of the mesh.

use std::path::{Path, PathBuf};

use ::gltf::json::Root;

use super::error::ImportError;
use super::files::{Files, Found};
use super::{Format, format_of, gltf, limits, obj};

/// The files beside a mesh that it names and that are there. Of what is no mesh, or cannot be read, those that are
/// named up to there: the command that reads it says what is wrong with it.
pub fn named_files(mesh: &Path) -> Vec<PathBuf> {
    let mut named = Named { files: Files::beside(mesh), found: Vec::new() };
    let _ = named.collect(mesh);
    named.found
}

struct Named {
    files: Files,
    found: Vec<PathBuf>,
}

impl Named {
    fn collect(&mut self, mesh: &Path) -> Result<(), ImportError> {
        match format_of(mesh)? {
            Format::Gltf => {
                let bytes = self.files.read(mesh, limits::FILE_BYTES)?;
                let root = gltf::root(&mut self.files, bytes)?;
                uris(&root).try_for_each(|uri| self.add(uri, &[]))
            }
            Format::Obj => {
                let mut libraries = Vec::new();
                self.files.read_lines(mesh, limits::OBJ_BYTES, &mut |files, _, line| {
                    if let Some(names) = obj::library_names(line) {
                        files.limit("mtllib lines", libraries.len() as u64 + 1, limits::LIBRARIES)?;
                        libraries.push(names.to_owned());
                    }
                    Ok(())
                })?;
                libraries.iter().try_for_each(|names| self.library(names))
            }
        }
    }

    fn library(&mut self, names: &str) -> Result<(), ImportError> {
        let all: Vec<&str> = names.split_whitespace().collect();
        for name in [names].into_iter().chain(all) {
            let Found::File(path) = self.files.find("mtllib", name, &[])? else { continue };
            let folder = self.files.folder_of(&path);
            self.found.push(path.clone());
            let mut maps = Vec::new();
            self.files.read_lines(&path, limits::MTL_BYTES, &mut |_, _, line| {
                maps.extend(obj::map_name(line));
                Ok(())
            })?;
            maps.iter().try_for_each(|map| self.add(map, &[&folder, Path::new("")]))?;
        }
        Ok(())
    }

    fn add(&mut self, name: &str, folders: &[&Path]) -> Result<(), ImportError> {
        // One that lies outside is named all the same, and the mesh that names it is refused.
        if let Ok(Found::File(path)) = self.files.find("a mesh", name, folders) {
            self.found.push(path);
        }
        Ok(())
    }
}

/// Of buffers and images, without data URIs.
fn uris(root: &Root) -> impl Iterator<Item = &str> {
    let buffers = root.buffers.iter().filter_map(|buffer| buffer.uri.as_deref());
    let images = root.images.iter().filter_map(|image| image.uri.as_deref());
    buffers.chain(images).filter(|uri| !uri.starts_with("data:"))
}
