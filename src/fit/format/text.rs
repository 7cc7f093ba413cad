//! Text as programs on any system write it: its encoding, its ends of lines, and names of files in it.

use std::borrow::Cow;
use std::collections::HashSet;
use std::fmt;
use std::marker::PhantomData;
use std::path::{Path, PathBuf};

use serde::de::{Deserialize, DeserializeOwned, Deserializer, Error, MapAccess, Visitor};

use crate::fit::{FitError, FitResult};

/// The bytes of a text file without a byte order mark; UTF-16, which only a mark tells, as UTF-8.
/// What is Latin-1 or UTF-8 stays as it is: [`decoded`] tells them apart word by word.
///
/// # Errors
/// When what follows a mark of UTF-16 is none.
pub fn plain(bytes: &[u8]) -> Result<Cow<'_, [u8]>, String> {
    let big = match bytes {
        [0xef, 0xbb, 0xbf, rest @ ..] => return Ok(rest.into()),
        [0xfe, 0xff, ..] => true,
        [0xff, 0xfe, ..] => false,
        _ => return Ok(bytes.into()),
    };
    let (pairs, odd) = bytes[2..].as_chunks();
    let read = if big {
        u16::from_be_bytes
    } else {
        u16::from_le_bytes
    };
    let units: Vec<u16> = pairs.iter().map(|&pair| read(pair)).collect();
    match (String::from_utf16(&units), odd) {
        (Ok(text), []) => Ok(text.into_bytes().into()),
        _ => Err("no text: it begins as UTF-16 and is none".into()),
    }
}

/// Reads a file of JSON, in any encoding that [`plain`] knows.
///
/// # Errors
/// When it cannot be read, or is not what is meant: with the file and the place in it.
pub fn json<T: DeserializeOwned>(path: &Path) -> FitResult<T> {
    let bytes = std::fs::read(path).map_err(|e| FitError::unread(path, e))?;
    let bytes = plain(&bytes).map_err(|cause| FitError::file(path, cause))?;
    serde_json::from_slice(&bytes).map_err(|e| FitError::file(path, e))
}

/// The members of a JSON object in their order. One that is there twice is refused: which of them is meant, nobody knows.
#[derive(Debug)]
pub struct Members<T>(pub Vec<(String, T)>);

impl<'de, T: Deserialize<'de>> Deserialize<'de> for Members<T> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Object<T>(PhantomData<T>);
        impl<'de, T: Deserialize<'de>> Visitor<'de> for Object<T> {
            type Value = Members<T>;

            fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
                f.write_str("an object")
            }

            fn visit_map<M: MapAccess<'de>>(self, mut map: M) -> Result<Members<T>, M::Error> {
                let mut names = HashSet::new();
                let mut members = Vec::new();
                while let Some(name) = map.next_key::<String>()? {
                    if !names.insert(name.clone()) {
                        return Err(M::Error::custom(format!("`{name}` is there twice")));
                    }
                    members.push((name, map.next_value()?));
                }
                Ok(Members(members))
            }
        }
        deserializer.deserialize_map(Object(PhantomData))
    }
}

/// Whether a word of text stands for a number that is not finite: also as Microsoft's libraries write that, `-1.#IND` and
/// `-nan(ind)`.
pub fn not_finite(word: &[u8]) -> bool {
    let lower = word.to_ascii_lowercase();
    let digits = lower.strip_prefix(b"-").unwrap_or(&lower);
    digits.starts_with(b"1.#") || digits.starts_with(b"nan") || digits.starts_with(b"inf")
}

/// UTF-8, or else Latin-1, in which any bytes are text.
pub fn decoded(bytes: &[u8]) -> Cow<'_, str> {
    match std::str::from_utf8(bytes) {
        Ok(text) => text.into(),
        Err(_) => bytes.iter().map(|&b| char::from(b)).collect(),
    }
}

/// The lines of a text, with their numbers from 1: they end with LF, CR LF, or CR alone.
pub fn lines(bytes: &[u8]) -> impl Iterator<Item = (usize, &[u8])> {
    let mut rest = Some(bytes);
    let line = move || {
        let text = rest?;
        let end = text.iter().position(|b| matches!(b, b'\n' | b'\r'));
        let (line, after) = text.split_at(end.unwrap_or(text.len()));
        rest = match after {
            [b'\r', b'\n', after @ ..] | [_, after @ ..] => Some(after),
            [] => None,
        };
        Some(line)
    };
    (1..).zip(std::iter::from_fn(line))
}

/// The file that a text names, as seen from a folder: in the first of these ways in which it is there.
///
/// As it is written; by its last part alone, since what was written on another machine may name that
/// machine's folders; each with the name in Latin-1, as an old archive may have unpacked it; and in letters of another
/// case, which are the same to the systems that most scanners run on.
pub fn named(folder: &Path, name: &str) -> PathBuf {
    let name = name.replace('\\', "/");
    let last = name.rsplit('/').next().unwrap_or_default();
    let mut ways = vec![folder.join(&name), folder.join(last)];
    #[cfg(unix)]
    for name in [&name, last] {
        use std::os::unix::ffi::OsStrExt;
        let bytes: Result<Vec<u8>, _> = name.chars().map(u8::try_from).collect();
        if let Some(bytes) = bytes.ok().filter(|_| !name.is_ascii()) {
            ways.push(folder.join(std::ffi::OsStr::from_bytes(&bytes)));
        }
    }
    let there = ways.iter().find(|file| file.is_file()).cloned();
    let there = there.or_else(|| ways.iter().find_map(|file| in_another_case(file)));
    there.unwrap_or_else(|| ways.swap_remove(0))
}

/// The first file, by name, that has a file's name but for the case of its letters.
fn in_another_case(file: &Path) -> Option<PathBuf> {
    let name = file.file_name()?;
    let folder = file
        .parent()
        .filter(|folder| !folder.as_os_str().is_empty());
    let entries = std::fs::read_dir(folder.unwrap_or(Path::new("."))).ok()?;
    let alike = entries.flatten().map(|entry| entry.file_name());
    let mut alike: Vec<_> = alike
        .filter(|other| other.eq_ignore_ascii_case(name))
        .collect();
    alike.sort();
    let mut paths = alike.into_iter().map(|name| file.with_file_name(name));
    paths.find(|path| path.is_file())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_end_in_three_ways() {
        let text = b"a\nb\r\n\rc\r\r\nd";
        let found: Vec<_> = lines(text).collect();
        let expected: [(usize, &[u8]); 6] = [
            (1, b"a"),
            (2, b"b"),
            (3, b""),
            (4, b"c"),
            (5, b""),
            (6, b"d"),
        ];
        assert_eq!(found, expected);
    }

    #[test]
    fn a_file_is_found_in_letters_of_another_case() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        std::fs::write(at("Skin.JPG"), "").unwrap();
        assert!(named(folder.path(), "skin.jpg").is_file());
        assert!(named(folder.path(), r"C:\scans\SKIN.jpg").is_file());
        // As it is written comes first; what is not there is named as it is written.
        std::fs::write(at("skin.jpg"), "").unwrap();
        assert_eq!(named(folder.path(), "skin.jpg"), at("skin.jpg"));
        assert_eq!(named(folder.path(), "gone.jpg"), at("gone.jpg"));
    }

    #[test]
    fn marks_go_and_both_kinds_of_letters_are_read() {
        assert_eq!(*plain(b"\xef\xbb\xbfv 1").unwrap(), *b"v 1");
        assert_eq!(*plain(b"\xff\xfev\0\xfc\0").unwrap(), *"vü".as_bytes());
        assert_eq!(*plain(b"\xfe\xff\0v").unwrap(), *b"v");
        assert!(plain(b"\xff\xfev").is_err());
        for bytes in [&b"Gr\xfc\xdfe"[..], "Grüße".as_bytes()] {
            assert_eq!(decoded(bytes), "Grüße");
        }
    }
}
