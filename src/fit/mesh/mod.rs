//! Meshes of any kind: closest points on their [`surface`], [`geodesic`] distances, rigid and similar ways to
//! [`align`] them, [`cotangent`] weights, their [`mirror`](mod@mirror) images, and the same surface in other triangles ([`resample`]). It
//! knows no other room.

pub mod align;
pub mod cotangent;
pub mod geodesic;
pub mod mirror;
pub mod resample;
pub mod surface;
