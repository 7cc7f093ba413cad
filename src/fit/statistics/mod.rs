//! Linear statistics of displacement fields: their [`gram`] matrices, principal components ([`pca`](mod@pca)), and the nearest of a
//! [`subspace`]. It knows no other room.

pub mod gram;
pub mod pca;
pub mod subspace;
