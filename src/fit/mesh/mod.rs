//! Meshes of any kind: closest points on their [`surface`], [`geodesic`] distances, rigid and similar ways to
//! [`align`] them, [`folds`] in them, and the same surface in other triangles ([`resample`]).

pub mod align;
pub mod folds;
pub mod geodesic;
pub mod resample;
pub mod surface;
