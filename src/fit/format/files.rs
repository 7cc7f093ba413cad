//! Writing files so that nothing is lost.

use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::Path;

use tempfile::NamedTempFile;

use crate::fit::{FitError, FitResult};

/// Writes a file whole or not at all: a new file beside it takes its place.
///
/// # Errors
/// When the folder does not exist or cannot be written to.
pub fn write_atomically(path: &Path, bytes: &[u8]) -> FitResult<()> {
    write_through(path, |file| {
        file.write_all(bytes).map_err(|e| FitError::file(path, e))
    })
}

/// Writes a file whole or not at all, piece by piece: the file appears when `write` is done, and if
/// it fails nothing does.
///
/// # Errors
/// Those of `write`, or when the folder does not exist or cannot be written to.
pub fn write_through(
    path: &Path,
    write: impl FnOnce(&mut BufWriter<&mut File>) -> FitResult<()>,
) -> FitResult<()> {
    let fail = |e: std::io::Error| FitError::file(path, e);
    let mut file = beside(path).map_err(fail)?;
    let mut buffered = BufWriter::new(file.as_file_mut());
    write(&mut buffered)?;
    buffered.flush().map_err(fail)?;
    drop(buffered);
    // What takes the place of a file is for those whom that was for.
    if let Ok(former) = path.metadata()
        && former.is_file()
    {
        let permissions = former.permissions();
        file.as_file().set_permissions(permissions).map_err(fail)?;
    }
    file.persist(path)
        .map_err(|e| FitError::file(path, e.error))?;
    Ok(())
}

/// Whether a file can be written, before the work whose result it is: by making one beside it, which goes at
/// once.
///
/// # Errors
/// When the folder does not exist or cannot be written to, or the path is a folder's.
pub fn check_writable(path: &Path) -> FitResult<()> {
    if path.is_dir() {
        return Err(FitError::file(
            path,
            "a folder, where a file is to be written",
        ));
    }
    match beside(path) {
        Ok(_) => Ok(()),
        Err(e) => Err(FitError::file(path, e)),
    }
}

/// A new file in the folder of another. It is for whom the umask says, where a temporary file is for its
/// owner alone.
fn beside(path: &Path) -> std::io::Result<NamedTempFile> {
    let folder = match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    };
    let mut builder = tempfile::Builder::new();
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        builder.permissions(std::fs::Permissions::from_mode(0o666));
    }
    builder.tempfile_in(folder)
}

#[cfg(all(test, unix))]
mod tests {
    use std::fs::{self, Permissions};
    use std::os::unix::fs::PermissionsExt;

    use super::*;

    #[test]
    fn a_file_is_for_those_for_whom_others_are() {
        let folder = tempfile::tempdir().unwrap();
        let mode = |name: &str| {
            let metadata = fs::metadata(folder.path().join(name)).unwrap();
            metadata.permissions().mode() & 0o777
        };
        // Another program's file has what the umask leaves.
        fs::write(folder.path().join("plain"), "").unwrap();
        let path = folder.path().join("new");
        write_atomically(&path, b"1").unwrap();
        assert_eq!(mode("new"), mode("plain"));
        for own in [0o600, 0o664] {
            fs::set_permissions(&path, Permissions::from_mode(own)).unwrap();
            write_atomically(&path, b"2").unwrap();
            assert_eq!(
                (mode("new"), fs::read(&path).unwrap()),
                (own, b"2".to_vec())
            );
        }
    }

    #[test]
    fn what_cannot_be_written_is_known_before() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a");
        check_writable(&path).unwrap();
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
        for bad in [folder.path(), &path.join("b")] {
            let error = check_writable(bad).unwrap_err().to_string();
            assert!(
                error.starts_with(&format!("{}: ", bad.display())),
                "{error}"
            );
        }
    }
}
