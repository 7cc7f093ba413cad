//! Arrays for numpy: an `.npz`, which is a ZIP of `.npy` files, none of them packed, as `numpy.savez` writes it.

use std::borrow::Borrow;
use std::io::{BufWriter, Cursor, Result, Write};

use npyz::{DType, Serialize, WriteOptions, WriterBuilder};
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipWriter};

/// Arrays by their names: little-endian, row by row, whole in memory.
///
/// All that adds one fails when it has not as many values as its shape says, and when all are more than the 4 GiB of a
/// plain ZIP.
#[derive(Debug)]
pub struct Npz {
    zip: ZipWriter<Cursor<Vec<u8>>>,
}

impl Default for Npz {
    fn default() -> Self {
        let zip = ZipWriter::new(Cursor::default());
        Self { zip }
    }
}

impl Npz {
    /// Adds one of f32.
    pub fn f32(
        &mut self,
        name: &str,
        shape: &[usize],
        values: impl IntoIterator<Item = f32>,
    ) -> Result<()> {
        self.add::<f32, _>(name, "<f4", shape, values)
    }

    /// Adds one of u32.
    pub fn u32(
        &mut self,
        name: &str,
        shape: &[usize],
        values: impl IntoIterator<Item = u32>,
    ) -> Result<()> {
        self.add::<u32, _>(name, "<u4", shape, values)
    }

    /// Adds one of booleans, in one dimension.
    pub fn bools(&mut self, name: &str, values: &[bool]) -> Result<()> {
        self.add::<bool, _>(name, "|b1", &[values.len()], values)
    }

    /// Adds one of words, in one dimension, each as long as the longest (UTF-32 padded with zeros, numpy's `U`).
    pub fn words<'a>(
        &mut self,
        name: &str,
        words: impl IntoIterator<Item = &'a str>,
    ) -> Result<()> {
        let words: Vec<&str> = words.into_iter().collect();
        let longest = words.iter().map(|w| w.chars().count()).max();
        let kind = format!("<U{}", longest.unwrap_or_default().max(1));
        self.add::<str, _>(name, &kind, &[words.len()], words)
    }

    /// `kind` is numpy's name of the type of a value.
    fn add<T: Serialize + ?Sized, V: Borrow<T>>(
        &mut self,
        name: &str,
        kind: &str,
        shape: &[usize],
        values: impl IntoIterator<Item = V>,
    ) -> Result<()> {
        let plain = SimpleFileOptions::default().compression_method(CompressionMethod::Stored);
        self.zip
            .start_file(npyz::npz::file_name_from_array_name(name), plain)?;
        let shape: Vec<u64> = shape.iter().map(|&n| n as u64).collect();
        // Values are written one by one.
        let mut file = BufWriter::new(&mut self.zip);
        let mut array = WriteOptions::<T>::new()
            .dtype(DType::Plain(kind.parse().expect("a type")))
            .shape(&shape)
            .writer(&mut file)
            .begin_nd()?;
        for value in values {
            array.push(value.borrow())?;
        }
        array.finish()?;
        file.flush()
    }

    /// The bytes of the file.
    pub fn finish(self) -> Result<Vec<u8>> {
        Ok(self.zip.finish()?.into_inner())
    }
}
