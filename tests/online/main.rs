//! The core: models and their files, faces, and faces in photos.
//!
//! One binary, so that one long test runs beside the others, and what all stand on is linked once.
#![cfg(not(target_arch = "wasm32"))]

#[cfg(feature = "fit")]
#[path = "../common/base_mesh.rs"]
mod base_mesh;
#[path = "../common/mod.rs"]
mod common;
#[cfg(feature = "fit")]
#[path = "../common/heads.rs"]
mod heads;
#[cfg(feature = "fit")]
#[path = "../common/ict.rs"]
mod ict;
#[cfg(feature = "photo")]
#[path = "../common/photo.rs"]
mod staged;

mod attribute;
mod blob;
mod expression;
mod face;
#[cfg(feature = "photo")]
mod photo;
#[cfg(feature = "photo")]
mod photo_edit;
#[cfg(feature = "photo")]
mod photo_head;
mod semantic;
