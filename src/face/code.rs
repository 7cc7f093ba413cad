//! A face as a short string for URLs.
//!
//! base64url (no padding) of: the model's fingerprint (4 bytes), a varint with the fall-off
//! distance in micrometres, then for each coefficient the difference from the median face in grid
//! units as a zigzag varint, where a zero is followed by a varint that says how many more zeros
//! come. A region that was not touched costs two bytes.

use base64::Engine;
use base64::engine::general_purpose::URL_SAFE_NO_PAD;

use super::{FARTHEST, Face, GRID};
use crate::{Error, FaceModel, Result};

impl Face {
    /// The face as a string of letters, digits, `-` and `_`: with [`crate::FaceModel::from_code`]
    /// it gives the same face, bit for bit. Locks are not kept in it.
    pub fn code(&self) -> String {
        encode(&self.model, self.alpha, &self.state)
    }

    /// Takes the coefficients and the fall-off distance of a code.
    ///
    /// # Errors
    /// [`Error::Code`] when the code is damaged or of another model; the face stays as it was.
    pub fn set_code(&mut self, code: &str) -> Result<()> {
        let bad = |why: &str| Error::Code(why.into());
        let bytes = URL_SAFE_NO_PAD
            .decode(code)
            .map_err(|_| bad("it has strange characters"))?;
        let Some((fingerprint, mut rest)) = bytes.split_first_chunk::<4>() else {
            return Err(bad("it is too short"));
        };
        if *fingerprint != self.model.derived.fingerprint.to_le_bytes() {
            return Err(bad("it belongs to another model"));
        }
        let cut = || bad("it is cut short");
        let alpha = take(&mut rest).ok_or_else(cut)? as f32 / 1000.0;
        let mut state = self.model.derived.median.clone();
        let mut at = 0;
        while at < state.len() {
            let zigzag = take(&mut rest).ok_or_else(cut)?;
            let difference = (zigzag >> 1) as i64 ^ -((zigzag & 1) as i64);
            let coefficient = i64::from(state[at]).saturating_add(difference);
            if coefficient.unsigned_abs() as f64 > f64::from(FARTHEST) * GRID {
                return Err(bad("a coefficient is out of range"));
            }
            state[at] = coefficient as i32;
            at += 1;
            if difference == 0 {
                let more = take(&mut rest).ok_or_else(cut)?;
                if more > (state.len() - at) as u64 {
                    return Err(bad("it has too many coefficients"));
                }
                at += more as usize;
            }
        }
        if !rest.is_empty() {
            return Err(bad("it is too long"));
        }
        if alpha != self.alpha {
            self.set_alpha(alpha)
                .map_err(|_| bad("its blending distance is out of range"))?;
        }
        self.replace(state);
        self.changed = 0..self.positions.len() as u32;
        Ok(())
    }
}

/// The code of a state (coefficients in grid units) with a fall-off distance (mm).
pub(crate) fn encode(model: &FaceModel, alpha: f32, state: &[i32]) -> String {
    let mut bytes = model.derived.fingerprint.to_le_bytes().to_vec();
    put(&mut bytes, (alpha * 1000.0).round() as u64);
    let differences: Vec<i64> = (state.iter().zip(&model.derived.median))
        .map(|(&c, &m)| i64::from(c) - i64::from(m))
        .collect();
    let mut at = 0;
    while at < differences.len() {
        let difference = differences[at];
        put(&mut bytes, ((difference << 1) ^ (difference >> 63)) as u64);
        at += 1;
        if difference == 0 {
            let more = differences[at..].iter().take_while(|&&d| d == 0).count();
            put(&mut bytes, more as u64);
            at += more;
        }
    }
    URL_SAFE_NO_PAD.encode(bytes)
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
