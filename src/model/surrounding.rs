//! What follows a region at one fall-off distance (region morphing, eqs. 11 and 12).

use wide::{f32x4, i32x4};

use super::{Block, SOURCES, falloff};
use crate::kernel::Modes;
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

/// Appends weighted sums of rows, scaled and rounded; whether one is not zero then.
#[cfg_attr(target_arch = "wasm32", inline(never))]
fn append(
    followed: &mut Vec<i32x4>,
    rows: [&[f32x4]; SOURCES],
    weights: [f32; SOURCES],
    scale: f32,
) -> bool {
    // Of numbers from this one on, up to twice its third, the last bit counts whole ones: sums are
    // rounded to the nearest, ties to even, by the addition.
    let whole = f32x4::splat(12_582_912.0);
    let (scale, offset) = (f32x4::splat(scale), bytemuck::cast::<_, i32x4>(whole));
    let weights = weights.map(f32x4::splat);
    let numbers = rows[0].len();
    let rows = rows.map(|row| &row[..numbers]);
    let mut any = i32x4::ZERO;
    followed.extend((0..numbers).map(|i| {
        let each = weights.iter().zip(&rows);
        let sum = each.fold(f32x4::ZERO, |sum, (&weight, row)| sum + weight * row[i]);
        let rounded = bytemuck::cast::<_, i32x4>(sum * scale + whole) - offset;
        any |= rounded;
        rounded
    }));
    any != i32x4::ZERO
}

impl Surrounding {
    /// Of a block; empty where it has no surround.
    pub fn new(block: &Block, alpha: f32) -> Self {
        let (modes, surround) = (&block.modes, block.surround.as_ref());
        let fades = surround.map_or(&[][..], |s| &s.distances).iter();
        let fades: Vec<f32> = fades.map(|d| falloff(d / alpha)).collect();
        let active: Vec<usize> = (0..fades.len()).filter(|&t| fades[t] > 0.0).collect();
        let (Some(surround), false) = (surround, active.is_empty()) else {
            return Self {
                targets: Vec::new(),
                modes: Modes::of_rows(modes.step(), modes.count(), &[]).0,
            };
        };
        let finer = modes.headroom();
        let own = surround.rows(&active);
        // All modes of a source side by side: those of a vertex are a sum of few such rows.
        let numbers = 3 * fours(modes.count());
        // Where the row of each source starts, once it is there.
        let mut starts = vec![usize::MAX; modes.numbers() / 3];
        let mut rows: Vec<f32x4> = Vec::new();
        for place in own.as_flattened().iter().map(|&(place, _)| place as usize) {
            if starts[place] == usize::MAX {
                starts[place] = rows.len();
                extend(&mut rows, modes, place);
            }
        }
        let mut targets = Vec::with_capacity(active.len());
        let mut followed = Vec::with_capacity(numbers * active.len());
        for (&t, own) in active.iter().zip(&own) {
            let (rows, weights) = (
                own.map(|(place, _)| &rows[starts[place as usize]..][..numbers]),
                own.map(|(_, weight)| f32::from(weight)),
            );
            let scale = fades[t] / 65_535.0 * (1 << finer) as f32;
            let start = followed.len();
            // Towards its end the fall-off leaves nothing to follow.
            match append(&mut followed, rows, weights, scale) {
                true => targets.push(surround.targets[t]),
                false => followed.truncate(start),
            }
        }
        Self {
            targets,
            modes: Modes::of_rows(modes.step() / (1 << finer) as f32, modes.count(), &followed).0,
        }
    }
}
