//! What follows a region at one fall-off distance (region morphing, eqs. 11 and 12).

use wide::{f32x4, i32x4};

use super::Modes;
use crate::model::{SOURCES, Surround, falloff};
use crate::predict::fours;

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

/// Appends how all modes move the support vertex at `place`: x of all, in [`fours`], y and z.
// Not inlined, as all that is done for each of many parts of a model: see `Walk::restore_one`.
#[cfg_attr(target_arch = "wasm32", inline(never))]
fn extend(rows: &mut Vec<f32x4>, modes: &Modes, place: usize) {
    let number = |axis: usize, k: usize| match k < modes.count() {
        true => modes.get(k, 3 * place + axis).into(),
        false => 0.0,
    };
    let each = (0..3).flat_map(|axis| (0..fours(modes.count())).map(move |four| (axis, 4 * four)));
    rows.extend(each.map(|(axis, k)| f32x4::new([0, 1, 2, 3].map(|i| number(axis, k + i)))));
}

/// Adds as many numbers, times a weight.
#[cfg_attr(target_arch = "wasm32", inline(never))]
fn add(sums: &mut [f32x4], weight: f32, numbers: &[f32x4]) {
    let weight = f32x4::splat(weight);
    for (sum, &x) in sums.iter_mut().zip(numbers) {
        *sum += weight * x;
    }
}

/// Appends the sums, scaled and rounded; whether one is not zero then.
#[cfg_attr(target_arch = "wasm32", inline(never))]
fn append(followed: &mut Vec<i32x4>, sums: &[f32x4], scale: f32) -> bool {
    // Of numbers from this one on, up to twice its third, the last bit counts whole ones: sums are
    // rounded to the nearest, ties to even, by the addition.
    let whole = f32x4::splat(12_582_912.0);
    let (scale, offset) = (f32x4::splat(scale), bytemuck::cast::<_, i32x4>(whole));
    let mut any = i32x4::ZERO;
    followed.extend(sums.iter().map(|&sum| {
        let rounded = bytemuck::cast::<_, i32x4>(sum * scale + whole) - offset;
        any |= rounded;
        rounded
    }));
    any != i32x4::ZERO
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
                modes: Modes::of_rows(modes.step(), modes.count(), &[]),
            };
        };
        let finer = modes.headroom();
        // All modes of a source side by side: those of a vertex are a sum of few such rows.
        let numbers = 3 * fours(modes.count());
        let places = (surround.sources.iter()).fold(0, |most, &place| most.max(place as usize + 1));
        // Where the row of each source starts, once it is there.
        let mut starts = vec![usize::MAX; places];
        let mut rows: Vec<f32x4> = Vec::new();
        for place in surround.sources.iter().map(|&place| place as usize) {
            if starts[place] == usize::MAX {
                starts[place] = rows.len();
                extend(&mut rows, modes, place);
            }
        }
        let mut targets = Vec::with_capacity(active.len());
        let mut followed = Vec::with_capacity(numbers * active.len());
        let mut sums = vec![f32x4::ZERO; numbers];
        for &t in &active {
            sums.fill(f32x4::ZERO);
            for i in t * SOURCES..(t + 1) * SOURCES {
                let row = &rows[starts[surround.sources[i] as usize]..];
                add(&mut sums, surround.weights[i].into(), row);
            }
            let scale = fades[t] / 65_535.0 * (1 << finer) as f32;
            let start = followed.len();
            // Towards its end the fall-off leaves nothing to follow.
            match append(&mut followed, &sums, scale) {
                true => targets.push(surround.targets[t]),
                false => followed.truncate(start),
            }
        }
        Self {
            targets,
            modes: Modes::of_rows(modes.step() / (1 << finer) as f32, modes.count(), &followed),
        }
    }
}
