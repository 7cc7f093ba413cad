//! The offline half: from the base mesh and scans to a model blob (feature `fit`, native only).
//!
//! `base_mesh` and `subdivide` make the generic head, [`template`] names its points and regions,
//! `population` samples registered faces, `align`, `pca`, `smooth`, `surround` and `learn` turn
//! them into a model, `render` draws any of it without a GPU.

pub mod base_mesh;
pub mod colour;
pub mod eyeball;
pub mod generic_head;
pub mod geodesic;
pub mod ply;
pub mod population;
pub mod region;
pub mod render;
pub mod subdivide;
pub mod template;

pub use error::{FitError, FitResult};

mod error;
