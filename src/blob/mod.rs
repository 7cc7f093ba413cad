//! The blob: the one file format in which templates and models are kept.
//!
//! Everything is little-endian. A blob is
//!
//! | bytes | what |
//! |---|---|
//! | 0..8 | magic `70 68 69 7A 0D 0A 1A 0A` (`phiz`, CR LF, ctrl-Z, LF: a text-mode copy damages it visibly) |
//! | 8..12 | u32 version, [`VERSION`] |
//! | 12..16 | u32 kind: 1 a template, 2 a model, 3 people, 4 expressions |
//! | 16..20 | u32 length of the whole blob in bytes |
//! | 20..24 | u32 length of the header in bytes |
//! | 24..28 | u32 number of sections |
//! | 28..32 | zero |
//! | 32..40 | u64 checksum of all other bytes (`checksum`) |
//! | 40.. | the section table, 32 bytes a section |
//! | then | the header, what is no long list of numbers (`blob::record`) |
//! | then | the sections, each starting at a multiple of 16, zeros between |
//!
//! A row of the section table is: 16 bytes of name (ASCII, zero-padded), u32 element type
//! (1 u8, 2 u16, 3 i16, 4 u32, 5 f32, 6 f64, 7 planes), u32 offset from the start of the blob, u32
//! length in bytes, u32 zero.
//!
//! Planes are small integers: each is folded to a number that is not negative (0, -1, 1, -2 ...
//! become 0, 1, 2, 3 ...); then come the lowest bytes of all, the next bytes of all, and so on,
//! one to four times, as the largest needs. Where most numbers are small, all planes but the first
//! are zeros.
//!
//! On disk a model is a blob in gzip ([`pack`], [`unpack`]): its sections are laid out to be small
//! then. A page inflates with what the platform has, native code with [`unpack`]; the blob in it is
//! what [`Blob::parse`] reads, and a blob that is not packed is as good.
//!
//! What the sections of a model mean is documented in [`crate::model`] beside the code that reads
//! them; those of expressions in [`crate::expression`], those of a template in `fit::head::template`.
//!
//! The reader trusts nothing. It never allocates more than a small multiple of the bytes that it
//! was given, and every offset, length and number is checked before it is used.

pub(crate) mod record;

use wide::{f32x4, i32x4, u8x16, u16x8};

use crate::error::Number;
use crate::{Error, Result};

const MAGIC: [u8; 8] = *b"phiz\r\n\x1a\n";
/// The format's version: a reader takes its own version and no other.
pub const VERSION: u32 = 3;
const PREAMBLE: usize = 40;
const ROW: usize = 32;
const ALIGNMENT: usize = 16;
/// More than 63 blocks or 500 expressions have, few enough that a damaged count cannot cost time.
const MAX_SECTIONS: usize = 1024;
/// 64 MiB: twenty times the default model. It is also the most that a packed blob may inflate to;
/// `www/phiz/index.js` has it too.
pub(crate) const MAX_BYTES: usize = 1 << 26;
/// The element type of planes.
const PLANES: u32 = 7;

/// What a blob holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// A generic head, for the offline program.
    Template,
    /// A face model, for everyone.
    Model,
    /// What a generic head has learned from people, for the offline program.
    People,
    /// Expressions of the faces of a model, for everyone.
    Expressions,
}

impl Kind {
    fn code(self) -> u32 {
        match self {
            Kind::Template => 1,
            Kind::Model => 2,
            Kind::People => 3,
            Kind::Expressions => 4,
        }
    }
}

/// A number type that a section can hold.
pub trait Element: Copy {
    /// The element type's code in the section table.
    const CODE: u32;
    /// Bytes an element.
    const SIZE: usize;
    /// Appends the little-endian bytes.
    fn write(self, out: &mut Vec<u8>);
    /// Reads from `Self::SIZE` little-endian bytes.
    fn read(bytes: &[u8]) -> Self;
}

macro_rules! element {
    ($type:ty, $code:literal) => {
        impl Element for $type {
            const CODE: u32 = $code;
            const SIZE: usize = size_of::<$type>();
            fn write(self, out: &mut Vec<u8>) {
                out.extend_from_slice(&self.to_le_bytes());
            }
            fn read(bytes: &[u8]) -> Self {
                let mut array = [0; size_of::<$type>()];
                array.copy_from_slice(bytes);
                <$type>::from_le_bytes(array)
            }
        }
    };
}
element!(u8, 1);
element!(u16, 2);
element!(i16, 3);
element!(u32, 4);
element!(f32, 5);
element!(f64, 6);

/// FNV-1a over the little-endian 64-bit words of a blob but for its checksum (bytes 32..40), the
/// last word padded with zeros. `bytes` holds at least a preamble.
///
/// Each step is a bijection of the running value, so any single changed word, and so any flipped
/// bit, changes the result.
fn checksum(bytes: &[u8]) -> u64 {
    let mut hash = 0xcbf2_9ce4_8422_2325_u64;
    let mut mix = |word: u64| hash = (hash ^ word).wrapping_mul(0x0000_0100_0000_01b3);
    let words = bytes[PREAMBLE..].chunks_exact(8);
    let rest = words.remainder();
    for word in bytes[..PREAMBLE - 8].chunks_exact(8).chain(words) {
        mix(u64::from_le_bytes([
            word[0], word[1], word[2], word[3], word[4], word[5], word[6], word[7],
        ]));
    }
    let mut last = [0; 8];
    last[..rest.len()].copy_from_slice(rest);
    mix(u64::from_le_bytes(last));
    hash
}

/// Puts a blob together.
pub struct BlobWriter {
    kind: Kind,
    header: Vec<u8>,
    sections: Vec<(String, u32, Vec<u8>)>,
}

impl BlobWriter {
    /// Starts a blob with its header.
    pub fn new(kind: Kind, header: &impl record::Value) -> Self {
        let mut bytes = Vec::new();
        header.write(&mut bytes);
        Self {
            kind,
            header: bytes,
            sections: Vec::new(),
        }
    }

    /// Adds a section. `name` is ASCII of at most 16 bytes, unlike every other.
    pub fn section<T: Element>(&mut self, name: &str, elements: &[T]) {
        debug_assert!(name.is_ascii() && name.len() <= 16);
        let mut bytes = Vec::with_capacity(elements.len() * T::SIZE);
        for &element in elements {
            element.write(&mut bytes);
        }
        self.sections.push((name.to_owned(), T::CODE, bytes));
    }

    /// Adds indices, as u16 when they all fit and as u32 otherwise. Read with [`Blob::indices`].
    pub fn indices(&mut self, name: &str, indices: &[u32]) {
        match indices
            .iter()
            .map(|&i| u16::try_from(i))
            .collect::<Result<Vec<_>, _>>()
        {
            Ok(short) => self.section(name, &short),
            Err(_) => self.section(name, indices),
        }
    }

    /// Adds integers that are mostly small, as planes. Read with [`Blob::planes`].
    pub fn planes(&mut self, name: &str, numbers: &[i32]) {
        debug_assert!(name.is_ascii() && name.len() <= 16);
        self.sections
            .push((name.to_owned(), PLANES, in_planes(numbers)));
    }

    /// Adds a value as the header's are kept. Read with [`Blob::record`].
    pub fn record(&mut self, name: &str, value: &impl record::Value) {
        let mut bytes = Vec::new();
        value.write(&mut bytes);
        self.section(name, &bytes);
    }

    /// The bytes of the blob.
    ///
    /// # Errors
    /// When these are more sections or bytes than a reader takes.
    pub fn finish(&self) -> Result<Vec<u8>> {
        let sections = self.sections.len();
        let bytes = self.sections.iter().map(|s| s.2.len() + ROW + ALIGNMENT);
        let bytes = bytes.sum::<usize>() + PREAMBLE + self.header.len();
        if sections > MAX_SECTIONS || bytes > MAX_BYTES {
            return Err(Error::Blob(format!(
                "{sections} sections and {bytes} bytes are over the limits of {MAX_SECTIONS} and {MAX_BYTES}"
            )));
        }
        let mut out = Vec::new();
        out.extend_from_slice(&MAGIC);
        VERSION.write(&mut out);
        self.kind.code().write(&mut out);
        0_u32.write(&mut out);
        (self.header.len() as u32).write(&mut out);
        (self.sections.len() as u32).write(&mut out);
        0_u32.write(&mut out);
        out.extend_from_slice(&[0; 8]);

        let mut offset = PREAMBLE + ROW * self.sections.len() + self.header.len();
        for (name, code, bytes) in &self.sections {
            offset = offset.next_multiple_of(ALIGNMENT);
            let mut padded = [0; 16];
            padded[..name.len()].copy_from_slice(name.as_bytes());
            out.extend_from_slice(&padded);
            code.write(&mut out);
            (offset as u32).write(&mut out);
            (bytes.len() as u32).write(&mut out);
            0_u32.write(&mut out);
            offset += bytes.len();
        }
        out.extend_from_slice(&self.header);
        for (_, _, bytes) in &self.sections {
            out.resize(out.len().next_multiple_of(ALIGNMENT), 0);
            out.extend_from_slice(bytes);
        }
        seal(&mut out);
        Ok(out)
    }
}

/// Writes the length and the checksum of a blob into its preamble.
///
/// [`BlobWriter::finish`] does this; it is public for programs that change a blob in place, and
/// for tests, whose damage would otherwise stop at the checksum. Fewer bytes than a preamble stay
/// as they are.
pub fn seal(bytes: &mut [u8]) {
    if bytes.len() < PREAMBLE {
        return;
    }
    let total = bytes.len() as u32;
    bytes[16..20].copy_from_slice(&total.to_le_bytes());
    let sum = checksum(bytes);
    bytes[32..40].copy_from_slice(&sum.to_le_bytes());
}

struct Row<'a> {
    name: &'a [u8],
    code: u32,
    bytes: &'a [u8],
}

/// A blob whose preamble, table and checksum have been checked.
pub struct Blob<'a> {
    header: &'a [u8],
    rows: Vec<Row<'a>>,
    checksum: u64,
}

/// Numbers as planes.
pub(crate) fn in_planes(numbers: &[i32]) -> Vec<u8> {
    let folded = || numbers.iter().map(|&n| ((n << 1) ^ (n >> 31)) as u32);
    let largest = folded().max().unwrap_or(0);
    let planes = (4 - largest.leading_zeros() / 8).max(1);
    let bytes = (0..planes).flat_map(|p| folded().map(move |n| (n >> (8 * p)) as u8));
    bytes.collect()
}

/// A section of integers in planes.
#[derive(Clone, Copy)]
pub(crate) struct Planes<'a> {
    bytes: &'a [u8],
    /// How many numbers there are.
    length: usize,
}

/// Numbers of a row of planes that are read at once.
pub(crate) const READ: usize = 16;

impl<'a> Planes<'a> {
    /// One to four planes of `length` numbers each.
    pub fn new(bytes: &'a [u8], length: usize) -> Option<Self> {
        let planes = bytes.len().checked_div(length).unwrap_or(1);
        let whole = bytes.len() == planes * length && (1..=4).contains(&planes);
        whole.then_some(Self { bytes, length })
    }

    /// Four rows of [`READ`] numbers, side by side, each from another number on, into every `step`-th of
    /// `out`. After the last of all numbers they are whatever, and of a row that
    /// starts there zeros.
    // Not inlined, as all that is done for each of many parts of a model: an engine runs the fast code
    // of a function from its next call on, and a model is read once.
    #[cfg_attr(target_arch = "wasm32", inline(never))]
    pub fn read(self, firsts: [usize; 4], out: &mut [i32x4], step: usize) {
        let low = self.halves(0, firsts);
        let lowest = i32x4::splat(0xffff);
        // Nearly always: two bytes a number, eight of which are unfolded at once.
        if 2 * self.length >= self.bytes.len() {
            for (i, &half) in low.iter().enumerate() {
                let n: u16x8 = bytemuck::cast(half);
                let sign: u16x8 = u16x8::ZERO - (n & u16x8::ONE);
                let half: i32x4 = bytemuck::cast(n >> 1 ^ sign);
                if let Some([first, .., second]) = out.get_mut(2 * i * step..=(2 * i + 1) * step) {
                    (*first, *second) = (half << 16 >> 16, half >> 16);
                }
            }
            return;
        }
        let high = self.halves(2, firsts);
        for i in 0..READ {
            let (low, high) = (low[i / 2], high[i / 2]);
            let n = match i % 2 {
                0 => low & lowest | high << 16,
                _ => low >> 16 & lowest | (high & !lowest),
            };
            let positive = n >> 1 & i32x4::splat(i32::MAX);
            if let Some(out) = out.get_mut(i * step) {
                *out = positive ^ (i32x4::ZERO - (n & i32x4::ONE));
            }
        }
    }

    /// Two planes of four rows, as halves of numbers: of each two numbers the first half is the lower
    /// one.
    #[cfg_attr(target_arch = "wasm32", inline(never))]
    fn halves(self, plane: usize, firsts: [usize; 4]) -> [i32x4; READ / 2] {
        let (mut start, mut end) = ([f32x4::ZERO; 4], [f32x4::ZERO; 4]);
        for ((start, end), first) in start.iter_mut().zip(&mut end).zip(firsts) {
            let (low, high) = (self.bytes(plane, first), self.bytes(plane + 1, first));
            *start = bytemuck::cast(u8x16::unpack_low(low, high));
            *end = bytemuck::cast(u8x16::unpack_high(low, high));
        }
        // Numbers only move, whatever they are.
        let [a, b, c, d] = f32x4::transpose(start);
        let [e, f, g, h] = f32x4::transpose(end);
        let halves: [[i32; 4]; READ / 2] = bytemuck::cast([a, b, c, d, e, f, g, h]);
        halves.map(|four| i32x4::new(four.map(i32::from_le)))
    }

    /// Bytes of a plane from number `first` on; zeros where there are none.
    #[inline(always)]
    fn bytes(self, plane: usize, first: usize) -> u8x16 {
        let rest = match first < self.length {
            true => self.bytes.get(plane * self.length + first..),
            false => None,
        };
        let rest = rest.unwrap_or_default();
        u8x16::new(rest.first_chunk().copied().unwrap_or_else(|| {
            let mut last = [0; READ];
            last[..rest.len()].copy_from_slice(rest);
            last
        }))
    }
}

fn word(bytes: &[u8], at: usize) -> u32 {
    u32::read(&bytes[at..at + 4])
}

impl<'a> Blob<'a> {
    /// Checks the container.
    ///
    /// # Errors
    /// [`Error::Version`] for another version, [`Error::Blob`] for everything else that is wrong.
    pub fn parse(bytes: &'a [u8], kind: Kind) -> Result<Self> {
        Self::open(bytes, kind, true)
    }

    /// The container of which these bytes are the first, unchecked: the table ends before the first section
    /// that is not there yet, so that a name means what it means in the whole. Whoever reads them has to check the whole ([`Blob::parse`]) before what was read counts.
    ///
    /// # Errors
    /// When the header is not there yet, or as [`Blob::parse`].
    pub(crate) fn first_bytes(bytes: &'a [u8], kind: Kind) -> Result<Self> {
        Self::open(bytes, kind, false)
    }

    fn open(bytes: &'a [u8], kind: Kind, whole: bool) -> Result<Self> {
        let bad = |why: String| Err(Error::Blob(why));
        if bytes.len() < PREAMBLE {
            return bad(format!(
                "{} bytes are too few for a preamble of {PREAMBLE}",
                bytes.len()
            ));
        }
        if bytes.starts_with(&GZIP) {
            return bad("it is packed: inflate it first".into());
        }
        if bytes[..8] != MAGIC {
            return bad("it does not start with the phiz signature".into());
        }
        if word(bytes, 8) != VERSION {
            return Err(Error::Version {
                found: word(bytes, 8),
                expected: VERSION,
            });
        }
        if bytes.len() > MAX_BYTES {
            return bad(format!(
                "{} bytes are over the limit of {MAX_BYTES}",
                bytes.len()
            ));
        }
        let total = word(bytes, 16) as usize;
        if whole && total != bytes.len() {
            return bad(format!(
                "it says that it is {total} bytes long, but {} are here",
                bytes.len()
            ));
        }
        let expected = u64::from_le_bytes(bytes[32..40].try_into().unwrap_or_default());
        if whole && checksum(bytes) != expected {
            return bad("its checksum does not match: the bytes were damaged".into());
        }
        if word(bytes, 12) != kind.code() {
            return bad(match kind {
                Kind::Template => "it is not a template".into(),
                Kind::Model => "it is not a face model".into(),
                Kind::People => "it is not learned from people".into(),
                Kind::Expressions => "it does not hold expressions".into(),
            });
        }
        if word(bytes, 28) != 0 {
            return bad("its reserved bytes are not zero".into());
        }
        let count = word(bytes, 24) as usize;
        if count > MAX_SECTIONS {
            return bad(format!(
                "{count} sections are over the limit of {MAX_SECTIONS}"
            ));
        }
        let header_start = PREAMBLE + count * ROW;
        let header_len = word(bytes, 20) as usize;
        let Some(header_end) = header_start
            .checked_add(header_len)
            .filter(|&end| end <= bytes.len())
        else {
            return bad("its header reaches past its end".into());
        };
        let mut rows = Vec::with_capacity(count);
        // Sections that lay over each other would be more than the bytes that there are.
        let mut free = header_end;
        for i in 0..count {
            let row = &bytes[PREAMBLE + i * ROW..PREAMBLE + (i + 1) * ROW];
            let (offset, length) = (word(row, 20) as usize, word(row, 24) as usize);
            let section = offset
                .checked_add(length)
                .filter(|_| offset >= free && offset.is_multiple_of(ALIGNMENT))
                .and_then(|end| bytes.get(offset..end));
            let Some(section) = section else {
                if !whole {
                    break;
                }
                return bad(format!("section {i} is not in its place"));
            };
            free = offset + length;
            rows.push(Row {
                name: row[..16]
                    .trim_ascii_end()
                    .split(|&b| b == 0)
                    .next()
                    .unwrap_or(&[]),
                code: word(row, 16),
                bytes: section,
            });
        }
        Ok(Self {
            header: &bytes[header_start..header_end],
            rows,
            checksum: expected,
        })
    }

    /// The checksum of the contents, shorter: the identity of the model.
    pub fn fingerprint(&self) -> u32 {
        (self.checksum ^ (self.checksum >> 32)) as u32
    }

    /// The header.
    ///
    /// # Errors
    /// When it is cut short, goes on, or is not what `H` wants.
    pub fn header<H: record::Value>(&self) -> Result<H> {
        record::whole(self.header)
            .ok_or_else(|| Error::Blob("its header is not what it should be".into()))
    }

    /// A section written by [`BlobWriter::record`]; `None` when there is none of that name.
    ///
    /// # Errors
    /// When it is not what `R` wants.
    pub fn record<R: record::Value>(&self, name: &str) -> Result<Option<R>> {
        let Some(row) = self.find(name) else {
            return Ok(None);
        };
        match record::whole(row.bytes) {
            Some(value) if row.code == u8::CODE => Ok(Some(value)),
            _ => Err(Error::Blob(format!(
                "section \"{name}\" is of another type"
            ))),
        }
    }

    /// Whether a section is there.
    pub(crate) fn has(&self, name: &str) -> bool {
        self.find(name).is_some()
    }

    fn find(&self, name: &str) -> Option<&Row<'a>> {
        self.rows.iter().find(|row| row.name == name.as_bytes())
    }

    fn row(&self, name: &str) -> Result<&Row<'a>> {
        self.find(name)
            .ok_or_else(|| Error::Blob(format!("section \"{name}\" is missing")))
    }

    /// A section of exactly `length` elements.
    ///
    /// # Errors
    /// When it is missing, of another type or of another length.
    pub fn section<T: Element>(&self, name: &str, length: usize) -> Result<Vec<T>> {
        let bytes = self.exactly(name, T::CODE, length, T::SIZE)?;
        Ok(bytes.chunks_exact(T::SIZE).map(T::read).collect())
    }

    /// A section of exactly `length` bytes, where it lies.
    ///
    /// # Errors
    /// As [`Blob::section`].
    pub fn bytes(&self, name: &str, length: usize) -> Result<&'a [u8]> {
        self.exactly(name, u8::CODE, length, 1)
    }

    fn exactly(&self, name: &str, code: u32, length: usize, size: usize) -> Result<&'a [u8]> {
        let row = self.row(name)?;
        match row.code == code && row.bytes.len() == length.saturating_mul(size) {
            true => Ok(row.bytes),
            false => Err(Error::Blob(format!(
                "section \"{name}\" is not {length} numbers of its type"
            ))),
        }
    }

    /// A section of any length.
    ///
    /// # Errors
    /// When it is missing or of another type.
    pub fn sized<T: Element>(&self, name: &str) -> Result<Vec<T>> {
        let row = self.row(name)?;
        if row.code != T::CODE || !row.bytes.len().is_multiple_of(T::SIZE) {
            return Err(Error::Blob(format!(
                "section \"{name}\" is of another type"
            )));
        }
        Ok(row.bytes.chunks_exact(T::SIZE).map(T::read).collect())
    }

    /// A section of `length` integers, written by [`BlobWriter::planes`].
    ///
    /// # Errors
    /// When it is missing, of another type or of another length.
    #[inline(never)]
    pub fn planes(&self, name: &str, length: usize) -> Result<Vec<i32>> {
        let planes = self.in_planes(name, length)?;
        let (mut numbers, mut read) = (vec![0; length], [i32x4::ZERO; READ]);
        for (out, first) in numbers.chunks_mut(4 * READ).zip((0..).step_by(4 * READ)) {
            planes.read([0, 1, 2, 3].map(|row| first + row * READ), &mut read, 1);
            for (row, out) in out.chunks_mut(READ).enumerate() {
                for (out, numbers) in out.iter_mut().zip(&read) {
                    *out = numbers.to_array()[row];
                }
            }
        }
        Ok(numbers)
    }

    /// The same, not read yet.
    pub(crate) fn in_planes(&self, name: &str, length: usize) -> Result<Planes<'a>> {
        let row = self.row(name)?;
        let planes = Planes::new(row.bytes, length).filter(|_| row.code == PLANES);
        planes.ok_or_else(|| {
            Error::Blob(format!(
                "section \"{name}\" is not {length} numbers in planes"
            ))
        })
    }

    /// A section of finite f32, none larger than `limit` in magnitude.
    ///
    /// # Errors
    /// As [`Blob::section`], or when a number is out of range.
    pub fn floats(&self, name: &str, length: usize, limit: f32) -> Result<Vec<f32>> {
        let section = self.section::<f32>(name, length)?;
        match section.iter().position(|x| !(x.abs() <= limit)) {
            Some(at) => Err(Error::Blob(format!(
                "number {at} of section \"{name}\" is {}, outside +-{}",
                Number(section[at].into()),
                Number(limit.into())
            ))),
            None => Ok(section),
        }
    }

    /// A section of indices below `bound`, written by [`BlobWriter::indices`].
    ///
    /// # Errors
    /// When it is missing, of another type, or an index is out of range.
    pub fn indices(&self, name: &str, bound: usize) -> Result<Vec<u32>> {
        let indices = if self.row(name)?.code == u16::CODE {
            self.sized::<u16>(name)?
                .into_iter()
                .map(u32::from)
                .collect()
        } else {
            self.sized::<u32>(name)?
        };
        match indices.iter().position(|&i| i as usize >= bound) {
            Some(at) => Err(Error::Blob(format!(
                "index {at} of section \"{name}\" is {}, not below {bound}",
                indices[at]
            ))),
            None => Ok(indices),
        }
    }
}

/// What a gzip stream starts with.
const GZIP: [u8; 2] = [0x1f, 0x8b];

/// Packs a blob for the disk: gzip, the same bytes for the same blob.
///
/// # Errors
/// When there is no memory for it.
#[cfg(not(target_arch = "wasm32"))]
pub fn pack(blob: &[u8]) -> Result<Vec<u8>> {
    use std::io::Write;
    let mut packer = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::best());
    let packed = packer.write_all(blob).and_then(|()| packer.finish());
    packed.map_err(|e| Error::Blob(format!("packing it: {e}")))
}

/// The blob in a packed one; bytes that do not start like gzip come back as they are.
///
/// # Errors
/// When the packed bytes are damaged, go on after their end, or inflate to more than 64 MiB.
#[cfg(not(target_arch = "wasm32"))]
pub fn unpack(bytes: &[u8]) -> Result<std::borrow::Cow<'_, [u8]>> {
    use std::io::Read;
    if !bytes.starts_with(&GZIP) {
        return Ok(bytes.into());
    }
    let mut unpacker = flate2::bufread::GzDecoder::new(bytes).take(MAX_BYTES as u64 + 1);
    let mut blob = Vec::new();
    if let Err(e) = unpacker.read_to_end(&mut blob) {
        return Err(Error::Blob(format!("its packed bytes are damaged: {e}")));
    }
    if blob.len() > MAX_BYTES {
        return Err(Error::Blob(format!(
            "unpacked it is over the limit of {MAX_BYTES} bytes"
        )));
    }
    if !unpacker.into_inner().into_inner().is_empty() {
        return Err(Error::Blob("bytes follow its packed ones".into()));
    }
    Ok(blob.into())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn small() -> Vec<u8> {
        let mut writer = BlobWriter::new(Kind::Model, &1_u32);
        writer.section("floats", &[1.0_f32, 2.0, -3.5]);
        writer.indices("indices", &[0, 5, 65_536]);
        writer.section("bytes", &[7_u8]);
        writer.planes("planes", &[0, -1, 127, -129, i32::MAX, i32::MIN]);
        writer.planes("thin", &[-128, 127, 5]);
        writer.planes("none", &[]);
        writer.finish().unwrap()
    }

    #[test]
    fn what_is_written_is_read() {
        let bytes = small();
        let blob = Blob::parse(&bytes, Kind::Model).unwrap();
        assert_eq!(blob.floats("floats", 3, 4.0).unwrap(), [1.0, 2.0, -3.5]);
        assert_eq!(blob.indices("indices", 65_537).unwrap(), [0, 5, 65_536]);
        assert!(blob.indices("indices", 65_536).is_err());
        assert!(blob.floats("floats", 3, 3.0).is_err());
        assert!(blob.section::<u8>("bytes", 2).is_err());
        assert!(blob.section::<u16>("bytes", 1).is_err());
        let planes = [0, -1, 127, -129, i32::MAX, i32::MIN];
        assert_eq!(blob.planes("planes", 6).unwrap(), planes);
        assert_eq!(blob.planes("thin", 3).unwrap(), [-128, 127, 5]);
        assert!(blob.planes("none", 0).unwrap().is_empty());
        assert!(blob.planes("none", 1).is_err());
        assert!(blob.planes("planes", 5).is_err());
        assert!(blob.planes("bytes", 1).is_err());
        assert!(blob.section::<u8>("nowhere", 1).is_err());
        assert!(Blob::parse(&bytes, Kind::Template).is_err());
    }

    #[test]
    fn what_no_reader_takes_is_not_written() {
        let mut writer = BlobWriter::new(Kind::Model, &1_u32);
        for i in 0..MAX_SECTIONS {
            writer.section(&format!("{i}"), &[7_u8]);
        }
        assert!(Blob::parse(&writer.finish().unwrap(), Kind::Model).is_ok());
        writer.section("one more", &[7_u8]);
        let why = writer.finish().unwrap_err().to_string();
        assert!(why.contains("1025 sections"), "{why}");
        let mut writer = BlobWriter::new(Kind::Model, &1_u32);
        writer.section("long", &vec![7_u8; MAX_BYTES]);
        let why = writer.finish().unwrap_err().to_string();
        assert!(why.contains("over the limits"), "{why}");
    }

    #[test]
    fn every_truncation_and_every_flipped_bit_is_an_error() {
        let bytes = small();
        for end in 0..bytes.len() {
            assert!(
                Blob::parse(&bytes[..end], Kind::Model).is_err(),
                "cut at {end}"
            );
        }
        for bit in 0..bytes.len() * 8 {
            let mut flipped = bytes.clone();
            flipped[bit / 8] ^= 1 << (bit % 8);
            assert!(Blob::parse(&flipped, Kind::Model).is_err(), "bit {bit}");
        }
    }

    #[test]
    fn another_version_is_named() {
        let mut bytes = small();
        bytes[8] = 9;
        assert_eq!(
            Blob::parse(&bytes, Kind::Model).err(),
            Some(Error::Version {
                found: 9,
                expected: VERSION
            })
        );
    }
}
