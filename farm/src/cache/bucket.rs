//! Entries as objects of a bucket.

use flb_runtime::source::{self, RemoteUrl};

use super::shelf::{Listed, NotRead, Shelf, Writing};
use crate::FarmError;

/// A prefix of a bucket.
pub(super) struct Bucket {
    url: RemoteUrl,
    bucket: source::Bucket,
}

impl Bucket {
    pub(super) fn open(url: &RemoteUrl) -> Result<Bucket, FarmError> {
        Ok(Bucket { url: url.clone(), bucket: source::Bucket::open(url)? })
    }

    fn refuse(&self, error: source::BucketError) -> FarmError {
        FarmError::Bucket { url: self.url.to_string(), error: error.to_string() }
    }
}

impl Shelf for Bucket {
    fn get(&self, entry: &str) -> Result<Option<Vec<u8>>, NotRead> {
        self.bucket.get(entry).map_err(|error| NotRead::All(error.to_string()))
    }

    fn has(&self, entry: &str) -> Result<bool, String> {
        self.bucket.has(entry).map_err(|error| error.to_string())
    }

    fn put(&self, entry: &str, bytes: &[u8], writing: Writing) -> Result<(), String> {
        let put = match writing {
            Writing::Create => self.bucket.create(entry, bytes),
            Writing::Replace => self.bucket.replace(entry, bytes),
        };
        put.map_err(|error| error.to_string())
    }

    fn list(&self) -> Result<Vec<Listed>, FarmError> {
        let listed = self.bucket.list().map_err(|error| self.refuse(error))?;
        let of = |one: source::Listed| Listed { name: one.name, bytes: one.bytes, used: one.modified };
        Ok(listed.into_iter().map(of).collect())
    }

    fn remove(&self, entry: &str) -> Result<(), FarmError> {
        self.bucket.remove(entry).map_err(|error| self.refuse(error))
    }

    fn name(&self, entry: &str) -> String {
        format!("{}/{entry}", self.url.to_string().trim_end_matches('/'))
    }
}
