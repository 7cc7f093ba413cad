//! Writing files so that nothing is lost.

use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};

use tempfile::NamedTempFile;

use crate::fit::{FitError, FitResult};

/// Writes a file whole or not at all: a new file beside it takes its place. What a link leads to is written, and the
/// link stays; what is no plain file, as a pipe, is written into.
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
    let filled = |file: &mut File| {
        let mut buffered = BufWriter::new(file);
        write(&mut buffered)?;
        buffered.flush().map_err(fail)
    };
    let former = path.metadata().ok();
    if former.as_ref().is_some_and(|former| !former.is_file()) {
        let mut file = File::options().write(true).open(path).map_err(fail)?;
        return filled(&mut file);
    }
    let target = place(path);
    let mut file = beside(&target).map_err(fail)?;
    filled(file.as_file_mut())?;
    // What takes the place of a file is for those whom that was for.
    if let Some(former) = former {
        let permissions = former.permissions();
        file.as_file().set_permissions(permissions).map_err(fail)?;
    }
    file.persist(&target)
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
    // A pipe or a device is written into: whether that goes, only writing tells.
    if path.metadata().is_ok_and(|there| !there.is_file()) {
        return Ok(());
    }
    match beside(&place(path)) {
        Ok(_) => Ok(()),
        Err(e) => Err(FitError::file(path, e)),
    }
}

/// The files of a folder, in no order: without its folders, and without hidden ones, as macOS leaves beside each file
/// on disks of others (`._me.obj`).
///
/// # Errors
/// When the folder cannot be read.
pub fn files_of(folder: &Path) -> FitResult<Vec<PathBuf>> {
    let entries = std::fs::read_dir(folder).map_err(|e| FitError::file(folder, e))?;
    let mut files = Vec::new();
    for entry in entries {
        let entry = entry.map_err(|e| FitError::file(folder, e))?;
        let hidden = entry.file_name().as_encoded_bytes().starts_with(b".");
        // A link counts as what it leads to.
        if !hidden && !entry.path().is_dir() {
            files.push(entry.path());
        }
    }
    Ok(files)
}

/// Whether files that are to be written are other ones than each other, and than those that a verb reads: as
/// `(what it is, file)`. By their places on the disk, however they are named, and before the work: what is written over
/// may be all that there is of a scan.
///
/// # Errors
/// When two are the same, with what it is.
pub fn check_apart(written: &[&Path], read: &[(&str, &Path)]) -> FitResult<()> {
    let kept: Vec<(&str, PathBuf)> = read
        .iter()
        .map(|&(what, path)| (what, place(path)))
        .collect();
    for (i, path) in written.iter().enumerate() {
        let at = place(path);
        if let Some((what, _)) = kept.iter().find(|(_, kept)| *kept == at) {
            let cause = format!("is {what}, which would be lost: it is written to another file");
            return Err(FitError::file(path, cause));
        }
        if written[..i].iter().any(|other| place(other) == at) {
            let cause = "two files are to be written there: each needs a name of its own";
            return Err(FitError::file(path, cause));
        }
    }
    Ok(())
}

/// Where a file is, or will be: without links and dots.
pub(in crate::fit) fn place(path: &Path) -> PathBuf {
    let there = path.canonicalize().ok();
    let new = || {
        let folder = folder(path).canonicalize().ok()?;
        Some(folder.join(path.file_name()?))
    };
    there.or_else(new).unwrap_or_else(|| path.to_owned())
}

/// The folder that a file is in.
pub fn folder(path: &Path) -> &Path {
    match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    }
}

/// A new file in the folder of another. It is for whom the umask says, where a temporary file is for its
/// owner alone.
fn beside(path: &Path) -> std::io::Result<NamedTempFile> {
    let mut builder = tempfile::Builder::new();
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        builder.permissions(std::fs::Permissions::from_mode(0o666));
    }
    builder.tempfile_in(folder(path)).map_err(|e| {
        // The library names the file that it tried to make, whose name nobody gave.
        let said = e.to_string();
        let cause = said.split(" at path ").next().unwrap_or_default();
        std::io::Error::new(e.kind(), cause)
    })
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
    fn links_stay_and_pipes_are_written_into() {
        use std::os::unix::fs::FileTypeExt;
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        fs::create_dir(at("sub")).unwrap();
        fs::write(at("sub/real"), "1").unwrap();
        std::os::unix::fs::symlink("sub/real", at("link")).unwrap();
        check_writable(&at("link")).unwrap();
        write_atomically(&at("link"), b"2").unwrap();
        assert!(fs::symlink_metadata(at("link")).unwrap().is_symlink());
        assert_eq!(fs::read(at("sub/real")).unwrap(), b"2");

        let pipe = at("pipe");
        let made = std::process::Command::new("mkfifo").arg(&pipe).status();
        assert!(made.unwrap().success());
        check_writable(&pipe).unwrap();
        let reader = std::thread::spawn({
            let pipe = pipe.clone();
            move || fs::read(pipe).unwrap()
        });
        write_atomically(&pipe, b"3").unwrap();
        // Before the reader is waited for, who would wait for a pipe that was replaced without end.
        assert!(fs::metadata(&pipe).unwrap().file_type().is_fifo());
        assert_eq!(reader.join().unwrap(), b"3");
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 3);
    }

    #[test]
    fn what_is_read_is_not_written_over_however_it_is_named() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        fs::create_dir(at("sub")).unwrap();
        fs::write(at("me.ply"), "").unwrap();
        std::os::unix::fs::symlink(at("me.ply"), at("link.ply")).unwrap();
        let (scan, new) = (at("me.ply"), at("new.png"));
        let read: [(&str, &Path); 1] = [("the scan", &scan)];
        check_apart(&[&new, &at("sub/new.png")], &read).unwrap();
        for same in ["me.ply", "sub/../me.ply", "link.ply"] {
            let error = check_apart(&[&at(same)], &read).unwrap_err().to_string();
            assert!(
                error.contains("is the scan, which would be lost"),
                "{error}"
            );
        }
        let error = check_apart(&[&new, &at("sub/../new.png")], &read).unwrap_err();
        assert!(error.to_string().contains("two files"), "{error}");
    }

    #[test]
    fn what_cannot_be_written_is_known_before() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a");
        check_writable(&path).unwrap();
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
        for bad in [folder.path(), &path.join("b")] {
            let error = check_writable(bad).unwrap_err().to_string();
            let start = format!("{}: ", bad.display());
            let cause = error.strip_prefix(&start).expect(&error);
            // Nor is there a path that nobody has named.
            assert!(!cause.contains('/'), "{error}");
        }
    }
}
