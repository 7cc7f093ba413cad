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
    #[error("no {kind} is called \"{name}\"")]
    Unknown {
        /// What was looked for: `control`, `region` ...
        kind: &'static str,
        /// The name that was given.
        name: String,
    },
    /// A number outside the range in which it has a meaning, or not a number.
    #[error("{what} must be {wanted}, not {}", Number(*got))]
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

/// A number in a message: to a millionth, or as a power of ten where it is huge. (The shortest digits
/// that give the same number again, which `{}` finds, take more code than a whole event.)
pub(crate) struct Number(pub f64);

impl std::fmt::Display for Number {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self(number) = *self;
        if number.is_nan() {
            return f.write_str("NaN");
        }
        if number < 0.0 {
            f.write_str("-")?;
        }
        let mut size = number.abs();
        if size.is_infinite() {
            return f.write_str("inf");
        }
        let mut power = 0;
        while size >= 1e9 {
            size /= 10.0;
            power += 1;
            if size < 1e9 {
                size /= 1e8;
                power += 8;
            }
        }
        let millionths = (size * 1e6).round() as u64;
        write!(f, "{}", millionths / 1_000_000)?;
        let mut rest = millionths % 1_000_000;
        if rest != 0 {
            let mut digits = 6;
            while rest.is_multiple_of(10) {
                rest /= 10;
                digits -= 1;
            }
            write!(f, ".{rest:0digits$}")?;
        }
        if power != 0 {
            write!(f, "e{power}")?;
        }
        Ok(())
    }
}

/// What is wanted of a value: from one limit to the other, in a unit.
#[cold]
#[inline(never)]
pub(crate) fn range([least, most]: [f64; 2], unit: &str) -> String {
    format!("from {} to {}{unit}", Number(least), Number(most))
}

/// A result whose error is an [`enum@Error`].
pub type Result<T, E = Error> = std::result::Result<T, E>;

#[cfg(test)]
mod tests {
    use super::Number;

    #[test]
    fn numbers_read_as_people_write_them() {
        for (number, text) in [
            (0.0, "0"),
            (-1.5, "-1.5"),
            (0.25, "0.25"),
            (1e-7, "0"),
            (3.000_001, "3.000001"),
            (123_456_789.0, "123456789"),
            (1e9, "1e9"),
            (-2.5e30, "-2.5e30"),
            (9.999_999_9e8, "999999990"),
            (f64::MAX, "1.797693e308"),
            (f64::NAN, "NaN"),
            (f64::NEG_INFINITY, "-inf"),
        ] {
            assert_eq!(Number(number).to_string(), text);
        }
    }
}
