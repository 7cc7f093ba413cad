//! phiz: design 3D human faces.
mod error;
pub use error::{Error, Result};
#[cfg(feature = "fit")]
pub mod fit;
