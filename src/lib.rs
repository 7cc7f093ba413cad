//! phiz: design 3D human faces.
//!
//! A [`FaceModel`] is a mean head and bases learned from people, one a facial feature; a [`Face`]
//! is a vector of coefficients for them. Sliders, blending and random faces all work on that
//! vector. Lengths are millimetres; y is up, z out of the face, x to the subject's left.
//!
//! ```no_run
//! use phiz::FaceModel;
//!
//! let model = FaceModel::parse(&std::fs::read("www/public/model.phiz")?)?;
//! let mut face = model.face();
//! face.set("nose 1", 0.9)?; // more than 90 % of people have it
//! println!("{} vertices, code {}", face.positions().len(), face.code());
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! A random face around a nose that is kept:
//!
//! ```no_run
//! # use phiz::{FaceModel, Randomize};
//! # let model = FaceModel::parse(&[])?;
//! let mut face = model.face();
//! face.lock("nose")?;
//! face.randomize(&Randomize { seed: Some(7), ..Default::default() })?;
//! # Ok::<(), phiz::Error>(())
//! ```
//!
//! Online, coefficients and modes are integers, and positions are within 2 micrometres RMS of the same
//! modes summed in f64.
//! Rounding the modes for the file moves the vertices of random faces by 19 micrometres RMS. Feature
//! `fit` adds the offline half (template, population, training); on wasm32 the bindings are added.

pub mod anatomy;
#[cfg(feature = "bench")]
#[doc(hidden)]
pub mod bench;
pub mod blob;
mod error;
pub mod expression;
mod face;
#[cfg(feature = "fit")]
pub mod fit;
mod kernel;
pub mod mesh;
pub mod model;
#[cfg(feature = "photo")]
pub mod photo;
mod predict;
pub mod quantise;
mod random;
#[cfg(feature = "photo")]
mod srgb;
#[cfg(all(target_arch = "wasm32", not(feature = "photo")))]
mod wasm;
#[cfg(all(target_arch = "wasm32", feature = "photo"))]
#[path = "wasm/photo.rs"]
mod wasm;

pub use error::{Error, Result};
pub use expression::{Expressions, Performance};
pub use face::{Face, Randomize};
pub use model::{FaceModel, IncomingModel};
pub use random::Random;
