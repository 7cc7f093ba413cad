//! Whatever the bytes, reading them as a model, all at once or while they come in, must end in the same model or
//! error, and a model that comes out must take every use. Panics, overflows, reads out of bounds, endless loops and huge
//! allocations are findings.
//!
//! The first byte picks the mode. Even: the rest is the blob, as it is. Odd: the rest is a list of
//! changes to a small sound blob, whose length and checksum are then made right, so that the
//! damage reaches the code behind them.
#![no_main]

use std::sync::LazyLock;

use libfuzzer_sys::fuzz_target;
use phiz::{FaceModel, IncomingModel};
use phiz::blob::seal;

#[path = "../../common/mod.rs"]
mod common;

static SOUND: LazyLock<Vec<u8>> = LazyLock::new(common::sheet_blob);

/// Takes the next bytes of the input, zeros after its end.
struct Source<'a>(&'a [u8]);

impl Source<'_> {
    fn number(&mut self) -> u32 {
        let mut bytes = [0; 4];
        let count = self.0.len().min(4);
        bytes[..count].copy_from_slice(&self.0[..count]);
        self.0 = &self.0[count..];
        u32::from_le_bytes(bytes)
    }

    fn below(&mut self, bound: usize) -> usize {
        self.number() as usize % bound.max(1)
    }
}

fn changed(input: &[u8]) -> Vec<u8> {
    let mut source = Source(input);
    let mut bytes = SOUND.clone();
    while !source.0.is_empty() && !bytes.is_empty() {
        let kind = source.number() % 6;
        let at = source.below(bytes.len());
        match kind {
            0 => bytes[at] = source.number() as u8,
            1 => {
                let word = source.number().to_le_bytes();
                let at = at / 4 * 4;
                let end = (at + 4).min(bytes.len());
                bytes[at..end].copy_from_slice(&word[..end - at]);
            }
            2 => {
                let end = (at + source.below(64)).min(bytes.len());
                bytes.drain(at..end);
            }
            3 => {
                let count = source.below(64).min(source.0.len());
                let (new, rest) = source.0.split_at(count);
                bytes.splice(at..at, new.iter().copied());
                source.0 = rest;
            }
            4 => {
                let to = source.below(bytes.len());
                let count = source.below(64).min(bytes.len() - at).min(bytes.len() - to);
                bytes.copy_within(at..at + count, to);
            }
            // A digit of the JSON header, where most of the meaning is.
            _ => {
                let start = 40 + 32 * SOUND[24] as usize;
                let digits: Vec<usize> = (start..bytes.len().min(start + 6000))
                    .filter(|&i| bytes[i].is_ascii_digit())
                    .collect();
                if let Some(&digit) = digits.get(at % digits.len().max(1)) {
                    bytes[digit] = b"0123456789-.e,[]"[source.below(16)];
                }
            }
        }
    }
    seal(&mut bytes);
    bytes
}

fuzz_target!(|input: &[u8]| {
    let Some((&mode, rest)) = input.split_first() else {
        return;
    };
    let bytes = if mode % 2 == 0 { rest.to_vec() } else { changed(rest) };
    let mut incoming = IncomingModel::default();
    for chunk in bytes.chunks(bytes.len() / 7 + 1) {
        incoming.push(chunk.to_vec());
    }
    let streamed = incoming.finish().map(|(model, _)| model.parts().clone());
    // Packed bytes are for the one that has them all.
    let whole = FaceModel::parse(&bytes);
    if !bytes.starts_with(&[0x1f, 0x8b]) {
        let told = whole.as_ref().map(|model| model.parts().clone());
        assert_eq!(format!("{streamed:?}"), format!("{:?}", told.as_ref().map_err(|why| *why)));
    }
    if let Ok(model) = whole {
        common::exercise(&model);
    }
});
