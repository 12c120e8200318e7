//! An open file, on this machine or behind a URL: its container and the source of its bytes.

use std::path::{Path, PathBuf};

use flb_format::colors::BandsError;
use flb_format::mesh::{MeshMark, MeshMatch};
use flb_format::{Container, Source};

use crate::source::{FileSource, MappedSource, Traffic};
#[cfg(feature = "remote")]
use crate::source::{RemoteSettings, RemoteSource, RemoteUrl};
use crate::{Location, RuntimeError};

/// A library of species, opened and with its tables verified. Pages are verified as they are read.
pub struct Library {
    path: PathBuf,
    source: Box<dyn Source>,
    container: Container,
    #[cfg(feature = "remote")]
    counts: Option<std::sync::Arc<crate::source::remote::Counts>>,
}

impl Library {
    /// Reads the file at positions. A file that shrinks or changes meanwhile is an error, never a signal.
    ///
    /// # Errors
    /// [`RuntimeError::Io`], [`RuntimeError::NotAFile`] and [`RuntimeError::Empty`] for what cannot be read,
    /// [`RuntimeError::Format`] for tables that fail their checks.
    pub fn open(path: impl AsRef<Path>) -> Result<Library, RuntimeError> {
        let path = path.as_ref();
        Library::from_source(path, Box::new(FileSource::open(path)?))
    }

    /// Maps the file into memory, for those who can keep others from it: another program that shortens it meanwhile can
    /// end this one by a signal. [`MappedSource`] has the contract.
    ///
    /// # Errors
    /// As [`Library::open`].
    pub fn open_mapped(path: impl AsRef<Path>) -> Result<Library, RuntimeError> {
        let path = path.as_ref();
        Library::from_source(path, Box::new(MappedSource::open(path)?))
    }

    /// Reads the file at positions, or behind its URL.
    pub fn open_location(location: &Location) -> Result<Library, RuntimeError> {
        match location {
            Location::File(path) => Library::open(path),
            #[cfg(feature = "remote")]
            Location::Remote(url) => Library::open_remote(url, &RemoteSettings::default()),
        }
    }

    /// Reads the file behind a URL. A file that is replaced meanwhile is an error for which
    /// [`is_replaced`](crate::source::is_replaced) holds; [`retry_replaced`](crate::source::retry_replaced) starts
    /// again.
    #[cfg(feature = "remote")]
    pub fn open_remote(url: &RemoteUrl, settings: &RemoteSettings) -> Result<Library, RuntimeError> {
        let source = RemoteSource::open(url, settings)?;
        let counts = source.counts();
        let library = Library::from_source(url.to_string(), Box::new(source))?;
        Ok(Library { counts: Some(counts), ..library })
    }

    /// Takes bytes from anywhere; `path` only names them in errors.
    pub fn from_source(path: impl Into<PathBuf>, source: Box<dyn Source>) -> Result<Library, RuntimeError> {
        let path = path.into();
        match Container::open(source.as_ref()) {
            Ok(container) => Ok(Library {
                path,
                source,
                container,
                #[cfg(feature = "remote")]
                counts: None,
            }),
            Err(source) => Err(RuntimeError::Format { path, source: Box::new(source) }),
        }
    }

    /// The file as it was named.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The verified tables and metadata.
    pub fn container(&self) -> &Container {
        &self.container
    }

    /// Restricts a species to these bands, in this order: metadata, light and surfaces read from the library are of
    /// them alone. For renderers, to which bands 0, 1 and 2 are red, green and blue.
    ///
    /// ```
    /// # fn main() -> Result<(), flb_runtime::RuntimeError> {
    /// # let library = flb_runtime::Library::open("golden/shrub.flb")?;
    /// // A file may have its bands in another order, and others beside them.
    /// let meta = &library.container().species()[0].meta;
    /// let rgb = meta.color_bands().expect("red, green and blue");
    /// let library = library.with_bands(0, &rgb);
    /// # assert_eq!(library.container().species()[0].meta.model.band(0), "R");
    /// # Ok(())
    /// # }
    /// ```
    ///
    /// # Panics
    /// If there is no such species or band, or no band at all.
    #[must_use]
    pub fn with_bands(mut self, species: usize, bands: &[usize]) -> Library {
        self.container = self.container.with_bands(species, bands);
        self
    }

    /// Returns the library with those bands of a species that a picture shows as red, green and blue
    /// ([`SpeciesMeta::picture_bands`](flb_format::SpeciesMeta::picture_bands)).
    ///
    /// # Errors
    /// [`BandsError`].
    ///
    /// # Panics
    /// If there is no such species.
    pub fn with_picture_bands(self, species: usize, wanted: &[String]) -> Result<Library, BandsError> {
        let meta = &self.container.species()[species].meta;
        let bands = meta.picture_bands(wanted)?;
        let is_whole = bands == [0, 1, 2] && meta.band_count() == 3;
        Ok(if is_whole { self } else { self.with_bands(species, &bands) })
    }

    /// The bytes.
    pub fn source(&self) -> &dyn Source {
        self.source.as_ref()
    }

    /// Requests and bytes fetched so far of a file behind a URL; `None` for a file on this machine.
    pub fn traffic(&self) -> Option<Traffic> {
        #[cfg(feature = "remote")]
        return self.counts.as_ref().map(|counts| counts.traffic());
        #[cfg(not(feature = "remote"))]
        None
    }

    /// Compares a mesh with the one that the light of a species was baked from: whether it is the same, and whether the
    /// light fits it if not. Light of another mesh looks like light.
    ///
    /// ```
    /// use flb_runtime::{Library, MeshMark, MeshMatch};
    ///
    /// # fn main() -> Result<(), flb_runtime::RuntimeError> {
    /// # let (positions, triangles) = ([[0.0; 3], [0.2, 1.0, 0.0], [-0.2, 1.0, 0.0]], [[0, 1, 2]]);
    /// let library = Library::open("golden/shrub.flb")?;
    /// // Of the mesh at rest, in model space and metres, with its leaves and wood alone.
    /// let mark = MeshMark::of(&positions, &triangles).expect("a mesh");
    /// match library.matches(0, &mark)? {
    ///     MeshMatch::Same => (),
    ///     found if found.fits() => println!("another level of detail, or an old file: {found:?}"),
    ///     found => println!("not this plant, or in another unit: {found:?}"),
    /// }
    /// # Ok(())
    /// # }
    /// ```
    ///
    /// # Errors
    /// [`RuntimeError::NoSuchSpecies`].
    pub fn matches(&self, species: usize, mesh: &MeshMark) -> Result<MeshMatch, RuntimeError> {
        let all = self.container.species();
        let none =
            || RuntimeError::NoSuchSpecies { path: self.path.clone(), index: species, count: all.len() };
        Ok(MeshMatch::of(&all.get(species).ok_or_else(none)?.meta, mesh))
    }

    /// Index of the species of this name.
    pub fn find_species(&self, name: &str) -> Option<usize> {
        self.container.species().iter().position(|species| species.meta.name == name)
    }
}
