//! Writing files so that nothing is lost.

use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::Path;

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
    let folder = match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    };
    let fail = |e: std::io::Error| FitError::file(path, e);
    let mut file = tempfile::NamedTempFile::new_in(folder).map_err(fail)?;
    let mut buffered = BufWriter::new(file.as_file_mut());
    write(&mut buffered)?;
    buffered.flush().map_err(fail)?;
    drop(buffered);
    // A temporary file is for its owner alone; what takes a name is for whom the umask says.
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        let everyone = std::fs::Permissions::from_mode(0o644);
        file.as_file().set_permissions(everyone).map_err(fail)?;
    }
    file.persist(path)
        .map_err(|e| FitError::file(path, e.error))?;
    Ok(())
}
