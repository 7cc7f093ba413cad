//! A face as a short string for URLs.
//!
//! base64url (no padding) of: the model's fingerprint (4 bytes), a varint with the fall-off
//! distance in micrometres, then for each coefficient the difference from the median face in grid
//! units as a zigzag varint, where a zero is followed by a varint that says how many more zeros
//! come. A region that was not touched costs two bytes. Where regions were locked, what they took
//! back follows: for each anchor a varint with a bit a region, and its coefficients likewise.

use base64ct::{Base64UrlUnpadded, Encoding};

use super::anchor::{Anchor, MOST};
use super::{FARTHEST, Face};
use crate::quantise::PER_SIGMA;
use crate::{Error, FaceModel, Result};

impl Face {
    /// The face as a string of letters, digits, `-` and `_`: with [`crate::FaceModel::from_code`]
    /// it gives the same face, bit for bit. Locks are not kept in it.
    pub fn code(&self) -> String {
        encode(&self.model, self.alpha(), &self.state, &self.anchors)
    }

    /// Takes the coefficients and the fall-off distance of a code, and what locks took back. Measures that are held are
    /// held at the lengths they have then: it is another face.
    ///
    /// # Errors
    /// [`Error::Code`] when the code is damaged or of another model; the face stays as it was.
    pub fn set_code(&mut self, code: &str) -> Result<()> {
        let bad = |why: &str| Error::Code(why.into());
        let bytes =
            Base64UrlUnpadded::decode_vec(code).map_err(|_| bad("it has strange characters"))?;
        let Some((fingerprint, mut rest)) = bytes.split_first_chunk::<4>() else {
            return Err(bad("it is too short"));
        };
        if *fingerprint != self.model.derived.fingerprint.to_le_bytes() {
            return Err(bad("it belongs to another model"));
        }
        let cut = || bad("it is cut short");
        let alpha = take(&mut rest).ok_or_else(cut)? as f32 / 1000.0;
        let mut state = Vec::new();
        let differences = take_all(&mut rest, self.state.len())?;
        for (&median, difference) in self.model.derived.median.iter().zip(differences) {
            let coefficient = i64::from(median).saturating_add(difference);
            if coefficient.unsigned_abs() as f64 > f64::from(FARTHEST) * PER_SIGMA {
                return Err(bad("a coefficient is out of range"));
            }
            state.push(coefficient as i32);
        }
        let mut anchors: Vec<Anchor> = Vec::new();
        while !rest.is_empty() {
            let blocks = &self.model.parts().blocks;
            let people = blocks.iter().filter(|b| b.local_to.is_none()).count();
            let regions = take(&mut rest).ok_or_else(cut)?;
            if regions >> people != 0 {
                return Err(bad("an anchor is of other regions"));
            }
            let last = anchors.last().map_or(0, |last| last.regions);
            if regions <= last {
                return Err(bad("its anchors are out of order"));
            }
            let taken = take_all(&mut rest, self.state.len())?.into_iter();
            let sound = |e: i64| i32::try_from(e).ok().filter(|e| (-MOST..=MOST).contains(e));
            let taken: Option<Vec<i32>> = taken.map(sound).collect();
            let Some(own) = taken.filter(|own| own.iter().any(|&e| e != 0)) else {
                return Err(bad("an anchor is out of range"));
            };
            anchors.push(self.new_anchor(regions, own));
        }
        if alpha != self.alpha() {
            self.set_alpha(alpha)
                .map_err(|_| bad("its blending distance is out of range"))?;
        }
        if anchors.is_empty() && self.anchors.is_empty() {
            self.adopt(state);
        } else {
            (self.state, self.anchors) = (state, anchors);
            self.evaluate_all();
        }
        for (measure, _) in self.held.clone() {
            self.hold_measure(measure);
        }
        self.changed = self.all();
        Ok(())
    }
}

/// The code of a state (coefficients in grid units) with the model's fall-off distance.
#[cfg(feature = "photo")]
pub(crate) fn of_state(model: &FaceModel, state: &[i32]) -> String {
    encode(model, model.parts().blending.alpha, state, &[])
}

/// The code of a state (coefficients in grid units) with a fall-off distance (mm), and of what locks
/// took back.
fn encode(model: &FaceModel, alpha: f32, state: &[i32], anchors: &[Anchor]) -> String {
    let mut bytes = model.derived.fingerprint.to_le_bytes().to_vec();
    put(&mut bytes, (alpha * 1000.0).round() as u64);
    let differences = state.iter().zip(&model.derived.median);
    put_all(
        &mut bytes,
        differences.map(|(&c, &m)| i64::from(c) - i64::from(m)),
    );
    for anchor in anchors {
        put(&mut bytes, anchor.regions);
        put_all(&mut bytes, anchor.state.iter().map(|&e| i64::from(e)));
    }
    Base64UrlUnpadded::encode_string(&bytes)
}

/// Numbers as zigzag varints, runs of zeros as their lengths.
fn put_all(bytes: &mut Vec<u8>, numbers: impl Iterator<Item = i64>) {
    let numbers: Vec<i64> = numbers.collect();
    let mut at = 0;
    while at < numbers.len() {
        let number = numbers[at];
        put(bytes, ((number << 1) ^ (number >> 63)) as u64);
        at += 1;
        if number == 0 {
            let more = numbers[at..].iter().take_while(|&&d| d == 0).count();
            put(bytes, more as u64);
            at += more;
        }
    }
}

/// So many numbers of [`put_all`].
fn take_all(bytes: &mut &[u8], count: usize) -> Result<Vec<i64>> {
    let cut = || Error::Code("it is cut short".into());
    let mut numbers = Vec::with_capacity(count);
    while numbers.len() < count {
        let zigzag = take(bytes).ok_or_else(cut)?;
        let number = (zigzag >> 1) as i64 ^ -((zigzag & 1) as i64);
        numbers.push(number);
        if number == 0 {
            let more = take(bytes).ok_or_else(cut)?;
            if more > (count - numbers.len()) as u64 {
                return Err(Error::Code("it has too many coefficients".into()));
            }
            numbers.resize(numbers.len() + more as usize, 0);
        }
    }
    Ok(numbers)
}

fn put(bytes: &mut Vec<u8>, mut number: u64) {
    while number >= 0x80 {
        bytes.push(number as u8 | 0x80);
        number >>= 7;
    }
    bytes.push(number as u8);
}

fn take(bytes: &mut &[u8]) -> Option<u64> {
    let mut number = 0;
    for shift in (0..63).step_by(7) {
        let (&byte, rest) = bytes.split_first()?;
        *bytes = rest;
        number |= u64::from(byte & 0x7f) << shift;
        if byte & 0x80 == 0 {
            return Some(number);
        }
    }
    None
}
