//! Files of the format, whole and damaged, read by this crate and by `reader.py`.

mod forge;

mod corruption;
mod forged;
mod reader;
