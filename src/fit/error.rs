use std::path::{Path, PathBuf};

use thiserror::Error;

/// Why an offline step could not be done: one line with the file and the cause.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum FitError {
    /// A file could not be read, written or understood.
    #[error("{}: {cause}", path.display())]
    File {
        /// The file or folder.
        path: PathBuf,
        /// What is wrong with it, with the line or record where that is known.
        cause: String,
    },
    /// A file that is meant to be there could not be opened or read: what it holds is not known.
    #[error("{}: {source}", path.display())]
    Unread {
        /// The file.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// The inputs do not allow the step (too few faces, another topology, a bad setting).
    #[error("{0}")]
    Input(String),
    /// An error of the core (a bad blob, an unknown name).
    #[error(transparent)]
    Core(#[from] crate::Error),
}

impl FitError {
    /// A [`FitError::File`].
    pub fn file(path: &Path, cause: impl std::fmt::Display) -> Self {
        FitError::File {
            path: path.to_owned(),
            cause: cause.to_string(),
        }
    }

    /// A [`FitError::Unread`].
    pub fn unread(path: &Path, source: std::io::Error) -> Self {
        FitError::Unread {
            path: path.to_owned(),
            source,
        }
    }

    /// The same with more words behind it.
    #[must_use]
    pub fn and(self, more: &str) -> Self {
        match self {
            FitError::File { path, cause } => FitError::File {
                path,
                cause: format!("{cause}; {more}"),
            },
            FitError::Unread { path, source } => FitError::Unread {
                path,
                source: std::io::Error::new(source.kind(), format!("{source}; {more}")),
            },
            FitError::Input(_) | FitError::Core(_) => FitError::Input(format!("{self}; {more}")),
        }
    }

    /// The same of a file or folder, if it names none.
    #[must_use]
    pub fn of(self, path: &Path) -> Self {
        match self {
            FitError::File { .. } | FitError::Unread { .. } => self,
            FitError::Input(_) | FitError::Core(_) => Self::file(path, self),
        }
    }
}

/// So many faces, in words: "1 face", "2 faces".
pub fn counted(faces: usize) -> String {
    format!("{faces} face{}", if faces == 1 { "" } else { "s" })
}

/// The same with a verb: "1 face is", "2 faces are".
pub(in crate::fit) fn faces_are(count: usize) -> String {
    format!(
        "{} {}",
        counted(count),
        if count == 1 { "is" } else { "are" }
    )
}

/// A result whose error is a [`FitError`].
pub type FitResult<T> = std::result::Result<T, FitError>;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_error_names_one_file() {
        let of = |error: FitError| error.of(Path::new("faces")).to_string();
        assert_eq!(of(FitError::Input("too few".into())), "faces: too few");
        assert_eq!(of(FitError::file(Path::new("a.ply"), "bad")), "a.ply: bad");
        let gone = FitError::unread(Path::new("a.ply"), std::io::Error::other("gone"));
        assert_eq!(of(gone.and("it stays")), "a.ply: gone; it stays");
    }
}
