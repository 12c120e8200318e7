//! Files of the format, whole and damaged, read by this crate and by `reader.py`.

mod said;

mod corruption;
mod damage;
mod forged;
mod reader;
mod torture;
