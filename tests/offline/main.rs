//! The offline half: scans and their registration, learning, what is measured of a model, and the
//! program's own verbs.
//!
//! One binary, since each test of it stands on the same few things, which take seconds: the generic
//! head, what registers to it, and the people of ICT-FaceKit.

#[path = "../common/base_mesh.rs"]
mod base_mesh;
#[path = "../common/mod.rs"]
mod common;
#[path = "../common/heads.rs"]
mod heads;
#[path = "../common/ict.rs"]
mod ict;
#[path = "../common/james.rs"]
mod james;

mod arrays;
mod bad_scans;
mod detect;
mod evaluate;
mod export;
mod head;
mod learning;
mod measure;
mod real_scan;
mod register;
mod register_batch;
mod sample;
mod scan_colours;
mod scan_files;
mod scan_formats;
mod simulate;
mod sparse;
mod usage;
mod validate;
