//! The header's values as bytes.
//!
//! Little-endian, one after another without padding: u32, f32 and f64 as they are; a string or a
//! list as a u32 count and what it holds, a string in UTF-8; an option as a byte, 0 or 1, and the
//! value if it is there; a record as its fields in order. Who reads knows what comes, so that the
//! reader is as small as a page wants it.

/// A value of a header.
pub trait Value: Sized {
    /// Appends the value's bytes.
    fn write(&self, out: &mut Vec<u8>);
    /// Takes a value off the bytes; `None` when they are not one.
    fn read(bytes: &mut &[u8]) -> Option<Self>;
}

/// The value that bytes are, if they are one and nothing else.
pub(super) fn whole<V: Value>(mut bytes: &[u8]) -> Option<V> {
    V::read(&mut bytes).filter(|_| bytes.is_empty())
}

fn take<const N: usize>(bytes: &mut &[u8]) -> Option<[u8; N]> {
    let (first, rest) = bytes.split_first_chunk()?;
    *bytes = rest;
    Some(*first)
}

macro_rules! number {
    ($type:ty) => {
        impl Value for $type {
            fn write(&self, out: &mut Vec<u8>) {
                out.extend_from_slice(&self.to_le_bytes());
            }
            fn read(bytes: &mut &[u8]) -> Option<Self> {
                take(bytes).map(<$type>::from_le_bytes)
            }
        }
    };
}
number!(u32);
number!(f32);
number!(f64);

impl Value for String {
    fn write(&self, out: &mut Vec<u8>) {
        (self.len() as u32).write(out);
        out.extend_from_slice(self.as_bytes());
    }
    #[inline(never)]
    fn read(bytes: &mut &[u8]) -> Option<Self> {
        let length = u32::read(bytes)? as usize;
        let (text, rest) = bytes.split_at_checked(length)?;
        *bytes = rest;
        String::from_utf8(text.to_vec()).ok()
    }
}

impl<T: Value> Value for Vec<T> {
    fn write(&self, out: &mut Vec<u8>) {
        (self.len() as u32).write(out);
        self.iter().for_each(|value| value.write(out));
    }
    fn read(bytes: &mut &[u8]) -> Option<Self> {
        // A count may be a lie: nothing is allocated for what is not there.
        (0..u32::read(bytes)?).map(|_| T::read(bytes)).collect()
    }
}

impl<T: Value> Value for Option<T> {
    fn write(&self, out: &mut Vec<u8>) {
        out.push(self.is_some().into());
        if let Some(value) = self {
            value.write(out);
        }
    }
    fn read(bytes: &mut &[u8]) -> Option<Self> {
        match take(bytes)? {
            [0] => Some(None),
            [1] => T::read(bytes).map(Some),
            _ => None,
        }
    }
}

impl<A: Value, B: Value> Value for (A, B) {
    fn write(&self, out: &mut Vec<u8>) {
        self.0.write(out);
        self.1.write(out);
    }
    fn read(bytes: &mut &[u8]) -> Option<Self> {
        Some((A::read(bytes)?, B::read(bytes)?))
    }
}

impl<T: Value + Copy + Default, const N: usize> Value for [T; N] {
    fn write(&self, out: &mut Vec<u8>) {
        self.iter().for_each(|value| value.write(out));
    }
    fn read(bytes: &mut &[u8]) -> Option<Self> {
        let mut values = [T::default(); N];
        for value in &mut values {
            *value = T::read(bytes)?;
        }
        Some(values)
    }
}

/// Makes structs records, with all of their fields.
macro_rules! record {
    ($($type:ident { $($field:ident),* $(,)? })*) => {
        $(impl $crate::blob::record::Value for $type {
            fn write(&self, out: &mut Vec<u8>) {
                let Self { $($field),* } = self;
                $($crate::blob::record::Value::write($field, out);)*
            }
            fn read(bytes: &mut &[u8]) -> Option<Self> {
                $(let $field = $crate::blob::record::Value::read(bytes)?;)*
                Some(Self { $($field),* })
            }
        })*
    };
}
pub(crate) use record;

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(Debug, PartialEq)]
    struct Some3 {
        name: String,
        pairs: Vec<(u32, f64)>,
        ends: [f32; 2],
        also: Option<u32>,
    }
    record! { Some3 { name, pairs, ends, also } }

    fn values() -> Vec<Some3> {
        let one = |name: &str, pairs: Vec<(u32, f64)>, also| Some3 {
            name: name.into(),
            pairs,
            ends: [f32::MIN_POSITIVE, -0.1],
            also,
        };
        vec![
            one("", vec![], None),
            one(
                "Größe \u{1f600}",
                vec![(7, 0.1), (u32::MAX, -1e300)],
                Some(3),
            ),
        ]
    }

    #[test]
    fn what_is_written_is_read() {
        let mut bytes = Vec::new();
        values().write(&mut bytes);
        let mut rest = &bytes[..];
        assert_eq!(Vec::read(&mut rest), Some(values()));
        assert!(rest.is_empty());
    }

    #[test]
    fn what_is_cut_short_or_no_value_is_refused() {
        let mut bytes = Vec::new();
        values().write(&mut bytes);
        for end in 0..bytes.len() {
            assert_eq!(Vec::<Some3>::read(&mut &bytes[..end]), None, "{end}");
        }
        // Four thousand million strings of which none is there.
        assert_eq!(Vec::<String>::read(&mut &[255; 4][..]), None);
        assert_eq!(Option::<u32>::read(&mut &[2, 0, 0, 0, 0][..]), None);
        assert_eq!(String::read(&mut &[1, 0, 0, 0, 0xff][..]), None);
    }
}
