//! What follows a region at one fall-off distance (region morphing, eqs. 11 and 12).

use super::Modes;
use crate::model::{SOURCES, Surround, falloff};

/// The vertices that follow a block at a fall-off distance, and how its modes move them.
///
/// A vertex moves by the weighted mean of what [`SOURCES`] vertices of the region's border move by,
/// times its fall-off. All of that is linear in the coefficients, so it is done once for each mode
/// and not for each event: of an event, a vertex that follows is like one of the region.
#[derive(Debug, Clone)]
pub(crate) struct Surrounding {
    /// The vertices that follow, increasing: those that any mode moves by more than rounding.
    pub targets: Vec<u32>,
    /// How each mode moves them, in finer steps than the block's: a sixteenth of it where the
    /// largest allow, so that rounding them moves faces by less than a micrometre.
    pub modes: Modes,
}

/// Appends how all modes move the support vertex at `place`.
// Not inlined, as what is done for each vertex: see `read_part` of the blob.
#[cfg_attr(target_arch = "wasm32", inline(never))]
fn extend(rows: &mut Vec<f32>, modes: &Modes, place: usize) {
    let row = (0..3 * modes.count()).map(|i| modes.get(i / 3, 3 * place + i % 3));
    rows.extend(row.map(f32::from));
}

/// Adds as many numbers, times a weight.
#[cfg_attr(target_arch = "wasm32", inline(never))]
fn add(sums: &mut [f32], weight: f32, numbers: &[f32]) {
    for (sum, x) in sums.iter_mut().zip(numbers) {
        *sum += weight * x;
    }
}

/// Appends the sums, scaled and rounded.
#[cfg_attr(target_arch = "wasm32", inline(never))]
fn append(followed: &mut Vec<i16>, sums: &[f32], scale: f32) {
    followed.extend((sums.iter()).map(|sum| (sum * scale).round_ties_even() as i16));
}

impl Surrounding {
    /// Of a block's modes and its surround; empty without one.
    pub fn new(modes: &Modes, surround: Option<&Surround>, alpha: f32) -> Self {
        let fades = surround.map_or(&[][..], |s| &s.distances).iter();
        let fades: Vec<f32> = fades.map(|d| falloff(d / alpha)).collect();
        let active: Vec<usize> = (0..fades.len()).filter(|&t| fades[t] > 0.0).collect();
        let (Some(surround), false) = (surround, active.is_empty()) else {
            return Self {
                targets: Vec::new(),
                modes: Modes::new(modes.step(), modes.count(), &[]),
            };
        };
        let finer = modes.headroom();
        // All modes of a source side by side: those of a vertex are a sum of few such rows.
        let numbers = 3 * modes.count();
        let places = (surround.sources.iter()).fold(0, |most, &place| most.max(place as usize + 1));
        // Where the row of each source starts, once it is there.
        let mut starts = vec![usize::MAX; places];
        let mut rows: Vec<f32> = Vec::new();
        for place in surround.sources.iter().map(|&place| place as usize) {
            if starts[place] == usize::MAX {
                starts[place] = rows.len();
                extend(&mut rows, modes, place);
            }
        }
        let mut targets = Vec::with_capacity(active.len());
        let mut followed = Vec::with_capacity(numbers * active.len());
        let mut sums = vec![0.0_f32; numbers];
        for &t in &active {
            sums.fill(0.0);
            for i in t * SOURCES..(t + 1) * SOURCES {
                let row = &rows[starts[surround.sources[i] as usize]..];
                add(&mut sums, surround.weights[i].into(), row);
            }
            let scale = fades[t] / 65_535.0 * (1 << finer) as f32;
            let start = followed.len();
            append(&mut followed, &sums, scale);
            // Towards its end the fall-off leaves nothing to follow.
            match followed[start..].iter().any(|&x| x != 0) {
                true => targets.push(surround.targets[t]),
                false => followed.truncate(start),
            }
        }
        Self {
            targets,
            modes: Modes::new(modes.step() / (1 << finer) as f32, modes.count(), &followed),
        }
    }
}
