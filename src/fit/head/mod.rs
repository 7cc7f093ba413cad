//! The generic head: one topology for every face, and what is known of it.
//!
//! [`base_mesh`] and [`subdivide`] are what [`generic_head`] makes the [`template`] from, with its [`eyeball`]s,
//! [`region`]s and [`colour`]s, and a `layout` of textures. [`people`] are what it has learned from others, with a [`prior`] of shapes;
//! [`expression`]s move it, [`folds`] are found on it, and [`cage`] writes shapes of it on the base mesh.

pub mod base_mesh;
pub mod cage;
pub mod colour;
pub mod expression;
pub mod eyeball;
pub mod folds;
pub mod generic_head;
mod layout;
pub mod people;
pub mod prior;
pub mod region;
pub mod subdivide;
pub mod template;
