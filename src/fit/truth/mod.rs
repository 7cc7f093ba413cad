//! People whose true shape is known: to measure by, and to learn from.
//!
//! A [`population`] is sampled from the base mesh's targets. People of [`ict`] are the template's by a [`binding`], and become scans by
//! [`simulate`](mod@simulate) and photos by [`photograph`](mod@photograph), whose pixels are those of a
//! [`portrait`], with expressions in some `mood`.

pub mod binding;
pub mod ict;
mod mood;
pub mod photograph;
pub mod population;
pub mod portrait;
pub mod simulate;
