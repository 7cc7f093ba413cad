//! Pictures, for people to check and for the documentation: [`render`](mod@render) draws without a GPU, lengths in the
//! colours of the [`colour_bar`], and [`pictures`] says what.

pub mod colour_bar;
pub mod pictures;
pub mod render;
