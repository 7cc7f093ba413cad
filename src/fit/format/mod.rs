//! Files: one place knows each format, and [`files`] writes all of them whole or not at all.

pub mod colours;
pub mod files;
pub mod glb;
pub mod npz;
pub mod obj;
pub mod ply;
pub mod stl;
pub mod text;
