//! The offline half: from the base mesh and scans to a model blob (feature `fit`, native only).
//!
//! `base_mesh` and `subdivide` make the generic head, [`template`] names its points and regions,
//! `population` samples registered faces, `align`, `pca`, `smooth`, `surround` and `learn` turn
//! them into a model, `render` draws any of it without a GPU.

pub mod align;
pub mod base_mesh;
pub mod colour;
pub mod crease;
pub mod describe;
pub mod eyeball;
pub mod files;
pub mod generic_head;
pub mod geodesic;
pub mod learn;
pub mod measures;
pub mod pca;
pub mod pictures;
pub mod ply;
pub mod population;
pub mod region;
pub mod render;
pub mod smooth;
pub mod subdivide;
pub mod surround;
pub mod template;

mod error;

pub use error::{FitError, FitResult};
