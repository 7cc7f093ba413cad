//! Arrays for numpy: an `.npz`, which is a ZIP of `.npy` files, none of them packed, as `numpy.savez` writes it.

use std::path::Path;

use crate::fit::format::files::write_atomically;
use crate::fit::{FitError, FitResult};

/// A named array, whole in memory: little-endian, row by row.
#[derive(Debug, Clone, PartialEq)]
pub struct Array {
    name: String,
    /// numpy's name of the type of a number, as `<f4`.
    kind: String,
    shape: Vec<usize>,
    bytes: Vec<u8>,
}

impl Array {
    /// Of f32.
    pub fn of_f32(name: &str, shape: &[usize], numbers: impl IntoIterator<Item = f32>) -> Self {
        let bytes = numbers.into_iter().flat_map(f32::to_le_bytes);
        Self::new(name, "<f4", shape, bytes.collect(), 4)
    }

    /// Of u32.
    pub fn of_u32(name: &str, shape: &[usize], numbers: impl IntoIterator<Item = u32>) -> Self {
        let bytes = numbers.into_iter().flat_map(u32::to_le_bytes);
        Self::new(name, "<u4", shape, bytes.collect(), 4)
    }

    /// Of booleans, in one dimension.
    pub fn of_bools(name: &str, values: &[bool]) -> Self {
        let bytes = values.iter().map(|&value| value.into());
        Self::new(name, "|b1", &[values.len()], bytes.collect(), 1)
    }

    /// Of words, in one dimension, each as long as the longest (UTF-32 padded with zeros, numpy's `U`).
    pub fn of_words<'a>(name: &str, words: impl IntoIterator<Item = &'a str>) -> Self {
        let words: Vec<Vec<char>> = words.into_iter().map(|w| w.chars().collect()).collect();
        let longest = words.iter().map(Vec::len).max().unwrap_or_default().max(1);
        let mut bytes = Vec::new();
        for word in &words {
            let padded = word.iter().map(|&c| u32::from(c));
            let padded = padded.chain(std::iter::repeat(0)).take(longest);
            bytes.extend(padded.flat_map(u32::to_le_bytes));
        }
        let kind = format!("<U{longest}");
        Self::new(name, &kind, &[words.len()], bytes, 4 * longest)
    }

    fn new(name: &str, kind: &str, shape: &[usize], bytes: Vec<u8>, size: usize) -> Self {
        assert_eq!(
            bytes.len(),
            size * shape.iter().product::<usize>(),
            "{name}"
        );
        Self {
            name: name.into(),
            kind: kind.into(),
            shape: shape.to_vec(),
            bytes,
        }
    }

    /// The bytes of its `.npy`, version 1.0 of the format.
    fn npy(&self) -> Vec<u8> {
        // A tuple of one has a comma.
        let shape: String = self.shape.iter().map(|n| format!("{n}, ")).collect();
        let kind = &self.kind;
        let header = format!("{{'descr': '{kind}', 'fortran_order': False, 'shape': ({shape}), }}");
        // What precedes the numbers is a multiple of 64, with the magic, the version and the length.
        let length = (10 + header.len() + 1).next_multiple_of(64) - 10;
        let mut npy = b"\x93NUMPY\x01\x00".to_vec();
        npy.extend((length as u16).to_le_bytes());
        npy.extend(format!("{header:<width$}\n", width = length - 1).bytes());
        npy.extend(&self.bytes);
        npy
    }
}

/// Writes arrays into one file, whole or not at all.
///
/// # Errors
/// When they are more than 4 GiB, which would need another kind of ZIP, or the file cannot be written.
pub fn write(path: &Path, arrays: &[Array]) -> FitResult<()> {
    let bytes = zip(arrays.iter().map(|a| (format!("{}.npy", a.name), a.npy())));
    let bytes = bytes.ok_or_else(|| FitError::file(path, "more than 4 GiB of arrays"))?;
    write_atomically(path, &bytes)
}

/// A ZIP of files as they are; `None` where places in it need more than 32 bits.
fn zip(files: impl Iterator<Item = (String, Vec<u8>)>) -> Option<Vec<u8>> {
    /// Version 2.0 to read it, no flags, no method of packing, and the first day that a ZIP knows.
    const COMMON: [u8; 10] = [20, 0, 0, 0, 0, 0, 0, 0, 0x21, 0];
    let (mut zip, mut directory, mut count) = (Vec::new(), Vec::new(), 0_u16);
    for (name, bytes) in files {
        let mut crc = flate2::Crc::new();
        crc.update(&bytes);
        let mut about = COMMON.to_vec();
        about.extend(crc.sum().to_le_bytes());
        let size = u32::try_from(bytes.len()).ok()?.to_le_bytes();
        about.extend([size, size].as_flattened());
        about.extend((name.len() as u16).to_le_bytes());
        about.extend([0, 0]);
        directory.extend(b"PK\x01\x02\x14\x00");
        directory.extend(&about);
        directory.extend([0; 10]);
        directory.extend(u32::try_from(zip.len()).ok()?.to_le_bytes());
        directory.extend(name.bytes());
        zip.extend(b"PK\x03\x04");
        zip.extend(&about);
        zip.extend(name.bytes());
        zip.extend(bytes);
        count += 1;
    }
    let start = u32::try_from(zip.len()).ok()?;
    zip.extend(&directory);
    zip.extend(b"PK\x05\x06\x00\x00\x00\x00");
    zip.extend([count, count].map(u16::to_le_bytes).as_flattened());
    zip.extend((directory.len() as u32).to_le_bytes());
    zip.extend(start.to_le_bytes());
    zip.extend([0, 0]);
    Some(zip)
}
