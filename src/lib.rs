//! phiz: design 3D human faces.
mod error;
pub use error::{Error, Result};
mod random;
pub use random::Random;
#[cfg(feature = "fit")]
pub mod fit;
