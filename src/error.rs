use thiserror::Error;

/// Why something was refused.
///
/// Every message is one line that names the cause, so that it can be shown to a person as it is.
#[derive(Debug, Error, Clone, PartialEq)]
#[non_exhaustive]
pub enum Error {
    /// The bytes are not a phiz blob, or a damaged one.
    #[error("not a usable phiz blob: {0}")]
    Blob(String),
    /// The blob is of a version that this build does not read.
    #[error("phiz blob version {found} cannot be read; this build reads version {expected}")]
    Version {
        /// The version in the blob.
        found: u32,
        /// The version that this build reads.
        expected: u32,
    },
    /// No control, region, measure or landmark of that name.
    #[error("no {kind} is called {name:?}")]
    Unknown {
        /// What was looked for: `control`, `region` ...
        kind: &'static str,
        /// The name that was given.
        name: String,
    },
    /// A number outside the range in which it has a meaning, or not a number.
    #[error("{what} must be {wanted}, not {got}")]
    Value {
        /// What the number is.
        what: &'static str,
        /// The range that is meant.
        wanted: String,
        /// The number that was given.
        got: f64,
    },
    /// A face code that was not made by [`crate::Face::code`] for this model.
    #[error("not a face code of this model: {0}")]
    Code(String),
    /// Two things that do not belong together, such as faces of two models.
    #[error("{0}")]
    Mismatch(String),
}

/// A result whose error is an [`enum@Error`].
pub type Result<T, E = Error> = std::result::Result<T, E>;
