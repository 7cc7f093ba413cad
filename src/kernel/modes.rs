//! Modes as `i16`, and weighted sums of them.

use glam::Vec3;
use wide::{i16x8, i32x4};

use crate::predict::fours;
use crate::quantise::{Quantised, STEPS, nearest_step};

/// Eights of a tile that have the same two modes, or fours of sums: as many as there are registers for.
const FOURS: usize = 6;
/// Words of two sums each that are summed together where there are no vectors.
const WORDS: usize = 6;
/// Numbers that are summed side by side: whole vertices.
const TILE: usize = 4 * FOURS;
/// Tiles that are summed before their sums are used.
const TILES: usize = 20;
/// Numbers of so many tiles: 160 vertices.
pub(crate) const CHUNK: usize = TILE * TILES;
/// The largest magnitude that modes may have in sum, each at its largest: times a weight of 32,767
/// it is still an `i32`.
const MOST: u32 = 65_536;

/// The modes of a block: numbers in steps, three a support vertex and mode.
///
/// They are laid out for their sum: of each tile of 24 numbers two modes after the other, those two
/// number by number, so that one instruction multiplies eight and adds pairs, memory is read from
/// one end to the other, and two modes of a tile, if no other changed, are two cache lines.
#[derive(Debug, Clone, PartialEq)]
pub struct Modes {
    step: f32,
    modes: usize,
    numbers: usize,
    /// Tile after tile; of each, pair after pair.
    tiles: Vec<[i16x8; FOURS]>,
    /// The largest magnitudes of the two modes of each pair, in sum.
    largest: Vec<u32>,
}

/// A part of the weights of a block's modes, made ready: those of some modes, or the higher or lower
/// bits of them, so that their sums are `i32`.
pub(crate) struct Part {
    /// The first pair of modes.
    first: usize,
    /// The weights of it and of pairs that follow it, four times the same.
    pairs: Vec<i16x8>,
    /// The value of 1 in the weights that were given: a power of two.
    pub unit: f64,
}

impl Modes {
    /// Modes in units of `step` mm (see [`nearest_step`]): of each vertex in turn all modes, of each
    /// x, y and z.
    pub fn new(step: f32, modes: usize, by_vertex: &[i16]) -> Self {
        let mut rows = Vec::with_capacity(by_vertex.len() / modes.max(1) * fours(modes));
        for own in by_vertex.chunks_exact((3 * modes).max(1)) {
            let number = |axis: usize, k: usize| own.get(3 * k + axis).map_or(0, |&n| n.into());
            let each = (0..3).flat_map(|axis| (0..fours(modes)).map(move |four| (axis, 4 * four)));
            rows.extend(
                each.map(|(axis, k)| i32x4::new([0, 1, 2, 3].map(|i| number(axis, k + i)))),
            );
        }
        Self::of_rows(step, modes, &rows).0
    }

    /// Modes as what is predicted is restored: of each number in turn all modes, in [`fours`]; and
    /// whether each is one of 16 bits, as it should be.
    pub(crate) fn of_rows(step: f32, modes: usize, rows: &[i32x4]) -> (Self, bool) {
        let own = fours(modes).max(1);
        let row = modes.div_ceil(2);
        let numbers = rows.len() / own;
        let mut tiles = vec![[i16x8::ZERO; FOURS]; numbers.div_ceil(TILE) * row];
        let mut most = vec![[i32x4::ZERO; 2]; own];
        let tiled = tiles.chunks_exact_mut(row.max(1));
        for (tile, rows) in tiled.zip(rows.chunks(TILE * own)) {
            for (four, rows) in rows.chunks(4 * own).enumerate() {
                lay(rows, tile, four, &mut most);
            }
        }
        let largest = most
            .iter()
            .flat_map(|[most, _]| bytemuck::cast::<_, [[u32; 2]; 2]>(*most));
        let bits = most.iter().fold(i32x4::ZERO, |all, [_, bits]| all | *bits);
        let all = Self {
            step: nearest_step(step),
            modes,
            numbers,
            tiles,
            largest: (largest.map(|[a, b]| a.saturating_add(b)))
                .take(modes.div_ceil(2))
                .collect(),
        };
        // Of numbers of 16 bits, whichever sign they have, these have no higher one.
        let fit = bits.to_array().iter().all(|&bits| bits <= i16::MAX.into());
        (all, fit)
    }

    /// Modes that were rounded, a mode after another.
    pub fn of(rounded: &Quantised, modes: usize) -> Self {
        let numbers = rounded.integers.len() / modes.max(1);
        let by_vertex = (0..numbers / 3).flat_map(|v| (0..modes).map(move |k| numbers * k + 3 * v));
        let by_vertex: Vec<i16> = by_vertex
            .flat_map(|at| &rounded.integers[at..at + 3])
            .copied()
            .collect();
        Self::new(rounded.step, modes, &by_vertex)
    }

    /// Of each vertex in turn all modes, of each x, y and z: what [`Modes::new`] takes.
    pub fn by_vertex(&self) -> Vec<i16> {
        let each = (0..self.numbers / 3).flat_map(|v| (0..self.modes).map(move |k| (v, k)));
        each.flat_map(|(v, k)| [0, 1, 2].map(|axis| self.get(k, 3 * v + axis)))
            .collect()
    }

    /// The value of 1, in mm.
    pub fn step(&self) -> f32 {
        self.step
    }

    /// How many there are.
    pub fn count(&self) -> usize {
        self.modes
    }

    /// How many numbers each has: three a support vertex.
    pub fn numbers(&self) -> usize {
        self.numbers
    }

    /// How many times finer a step could be without any sum of modes becoming too large for `i32`,
    /// as a power of two that [`STEPS`] allow.
    pub(crate) fn headroom(&self) -> u32 {
        let sum: u32 = self.largest.iter().sum();
        let largest = self.largest.iter().max().map_or(1, |&l| l.max(1));
        let most = (MOST / sum.max(1)).min(i16::MAX as u32 / largest).max(1);
        most.ilog2().min(STEPS)
    }

    /// Number `number` of mode `mode`, in steps.
    pub fn get(&self, mode: usize, number: usize) -> i16 {
        let pair = self.tiles[number / TILE * self.row() + mode / 2];
        pair[number % TILE / 4].to_array()[number % 4 * 2 + mode % 2]
    }

    /// How mode `mode` moves the support vertex at `place`, mm.
    pub fn displacement(&self, mode: usize, place: usize) -> Vec3 {
        let number = |axis| f32::from(self.get(mode, 3 * place + axis));
        Vec3::new(number(0), number(1), number(2)) * self.step
    }

    /// The numbers as they lie in memory.
    #[cfg(feature = "bench")]
    pub(crate) fn tiles(&self) -> &[i16x8] {
        self.tiles.as_flattened()
    }

    /// How many pairs of modes a tile has.
    fn row(&self) -> usize {
        self.modes.div_ceil(2)
    }

    /// Weights, whole numbers below 2^29 in magnitude, one a mode, in parts whose sums add up to the
    /// whole; none where all weights are zero, and nearly always one.
    pub(crate) fn weights(&self, weights: &[i32]) -> Vec<Part> {
        // Those that people have are whole multiples of some power of two, and fit then.
        let together = weights.iter().fold(0, |all, w| all | w);
        let shift = together.trailing_zeros().min(30);
        let most = weights.iter().map(|w| (w >> shift).unsigned_abs()).max();
        // The smallest i16 is left out: twice its square is no i32.
        let fit = most < Some(1 << 15);
        let mut parts: Vec<Part> = Vec::new();
        for high in [false, true] {
            let mut sum = u32::MAX;
            for (place, pair) in weights.chunks(2).enumerate() {
                // `low + 32768 high`
                let of = |weight: i32| {
                    let weight = weight >> shift;
                    let above = if fit { 0 } else { (weight + (1 << 14)) >> 15 };
                    (if high { above } else { weight - (above << 15) }) as i16
                };
                let [a, b] = [of(pair[0]), pair.get(1).map_or(0, |&b| of(b))];
                if a == 0 && b == 0 {
                    continue;
                }
                sum = sum.saturating_add(self.largest[place]);
                if sum > MOST {
                    sum = self.largest[place];
                    parts.push(Part {
                        first: place,
                        pairs: Vec::new(),
                        unit: f64::from(1_u32 << shift) * if high { 32_768.0 } else { 1.0 },
                    });
                }
                if let Some(part) = parts.last_mut() {
                    part.pairs.resize(place - part.first, i16x8::ZERO);
                    part.pairs.push(i16x8::new([a, b, a, b, a, b, a, b]));
                }
            }
        }
        parts
    }

    /// Weighted sums of the modes by a part of the weights, in steps: whole numbers for [`CHUNK`] numbers
    /// from number `first` on, which is a multiple of it.
    #[inline(never)]
    pub(crate) fn sum(&self, part: &Part, first: usize, sums: &mut [i32x4; CHUNK / 4]) {
        let row = self.row().max(1);
        let start = (first / TILE * row).min(self.tiles.len());
        let end = (start + TILES * row).min(self.tiles.len());
        let outs = sums.as_chunks_mut::<FOURS>().0;
        // One length for both, which ends the loop.
        let count = part.pairs.len().min(row - part.first.min(row));
        let own = part.first..part.first + count;
        for (tile, out) in self.tiles[start..end].chunks_exact(row).zip(outs) {
            let (pairs, weights) = (&tile[own.clone()], &part.pairs[..count]);
            *out = if ONE_BY_ONE {
                in_words(pairs, weights)
            } else {
                in_vectors(pairs, weights)
            };
        }
    }
}

/// Whether there are no instructions for eight numbers at once.
const ONE_BY_ONE: bool = cfg!(not(any(
    target_feature = "simd128",
    target_feature = "sse2",
    target_feature = "neon"
)));

/// Sums of a tile, by instructions that multiply eight numbers and add pairs.
#[inline(always)]
fn in_vectors(pairs: &[[i16x8; FOURS]], weights: &[i16x8]) -> [i32x4; FOURS] {
    let mut sums = [i32x4::ZERO; FOURS];
    for (pair, &weights) in pairs.iter().zip(weights) {
        for (sum, &numbers) in sums.iter_mut().zip(pair) {
            *sum += numbers.dot(weights);
        }
    }
    sums
}

/// The same sums where there are no such instructions: two of them to a word of 64 bits, which a multiplication
/// moves on together. Numbers are made positive for that, and the sums begin below zero by as much.
#[inline(always)]
fn in_words(pairs: &[[i16x8; FOURS]], weights: &[i16x8]) -> [i32x4; FOURS] {
    const EVEN: u64 = 0x0000_ffff_0000_ffff;
    const SIGNS: u64 = 0x8000_8000_8000_8000;
    let of = |weights: &i16x8| {
        let [a, b, ..] = weights.to_array();
        [a, b].map(|w| i64::from(w) as u64)
    };
    let all =
        (weights.iter().map(of)).fold(0_u64, |all, [a, b]| all.wrapping_add(a).wrapping_add(b));
    let start = all.wrapping_mul(1 << 15).wrapping_neg();
    let start = start.wrapping_add(start << 32);
    let mut sums = [[0; 4]; FOURS];
    // As many at a time as there are registers for.
    for (group, sums) in sums.chunks_exact_mut(WORDS / 2).enumerate() {
        let mut words = [start; WORDS];
        for (pair, weights) in pairs.iter().zip(weights) {
            let [a, b] = of(weights);
            let own = &pair[group * (WORDS / 2)..][..WORDS / 2];
            let own: &[u64] = bytemuck::cast_slice(own);
            for (word, numbers) in words.iter_mut().zip(own) {
                let numbers = numbers ^ SIGNS;
                let even = (numbers & EVEN).wrapping_mul(a);
                let odd = (numbers >> 16 & EVEN).wrapping_mul(b);
                *word = word.wrapping_add(even).wrapping_add(odd);
            }
        }
        for (sums, word) in sums
            .as_flattened_mut()
            .as_chunks_mut::<2>()
            .0
            .iter_mut()
            .zip(words)
        {
            let low = word as i32;
            *sums = [low, (word.wrapping_sub(i64::from(low) as u64) >> 32) as i32];
        }
    }
    sums.map(i32x4::new)
}

/// Puts up to four numbers into the eights of a tile that are theirs, at `place` of each pair, and notes
/// the largest magnitudes, and which bits there are beside the sign.
// Not inlined, as what is done for each of many parts of a model: see `Walk::restore_one`.
#[cfg_attr(target_arch = "wasm32", inline(never))]
fn lay(rows: &[i32x4], tile: &mut [[i16x8; FOURS]], place: usize, most: &mut [[i32x4; 2]]) {
    let own = most.len();
    let mut eights = tile.iter_mut().map(|pair| &mut pair[place]);
    for (k, [most, bits]) in most.iter_mut().enumerate() {
        let of = |i: usize| rows.get(i * own + k).copied().unwrap_or(i32x4::ZERO);
        let four = [0, 1, 2, 3].map(of);
        for number in four {
            *most = most.max(number.abs());
            *bits |= number ^ (number >> 31);
        }
        // Two modes of a number are moved as one.
        let narrow = |a: i32x4, b: i32x4| -> [u32; 4] {
            bytemuck::cast(i16x8::from_i32x8_saturate(bytemuck::cast([a, b])))
        };
        let ([a, b, c, d], [e, f, g, h]) = (narrow(four[0], four[1]), narrow(four[2], four[3]));
        for (pairs, eight) in [[a, c, e, g], [b, d, f, h]]
            .into_iter()
            .zip(eights.by_ref())
        {
            *eight = bytemuck::cast(pairs);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Random;

    /// The definition: one number after the other.
    fn plain(modes: &Modes, weights: &[i32], i: usize) -> i64 {
        let terms = weights.iter().enumerate();
        terms
            .map(|(k, &w)| i64::from(w) * i64::from(modes.get(k, i)))
            .sum()
    }

    fn check(modes: &Modes, weights: &[i32]) {
        let mut sums = vec![0.0; modes.numbers()];
        for part in modes.weights(weights) {
            for (tile, own) in modes.tiles.chunks_exact(modes.row().max(1)).enumerate() {
                let own = &own[part.first..][..part.pairs.len()];
                let (vectors, words) = (in_vectors(own, &part.pairs), in_words(own, &part.pairs));
                assert_eq!(vectors, words, "tile {tile}");
            }
            for (chunk, sums) in sums.chunks_mut(CHUNK).enumerate() {
                let mut own = [i32x4::ONE; CHUNK / 4];
                modes.sum(&part, CHUNK * chunk, &mut own);
                for (sum, own) in sums.iter_mut().zip(bytemuck::cast_slice::<_, i32>(&own)) {
                    *sum += part.unit * f64::from(*own);
                }
            }
        }
        for (i, &sum) in sums.iter().enumerate() {
            assert_eq!(sum, plain(modes, weights, i) as f64, "number {i}");
        }
    }

    #[test]
    fn sums_are_those_of_one_number_after_the_other() {
        let mut random = Random::new(2);
        let mut below = |most: f64| (random.normal() * most / 3.0) as i32;
        for (count, numbers, most) in [
            (0, 30, 10.0),
            (1, 3, 1000.0),
            (2, 480, 300.0),
            (7, 483, 9000.0),
            (16, 1203, 2000.0),
            (31, 960, 20_000.0),
        ] {
            let values: Vec<i16> = (0..count * numbers).map(|_| below(most) as i16).collect();
            let modes = Modes::new(0.005, count, &values);
            for (k, i) in (0..count).flat_map(|k| (0..numbers).map(move |i| (k, i))) {
                assert_eq!(modes.get(k, i), values[i / 3 * 3 * count + 3 * k + i % 3]);
            }
            assert_eq!(modes.by_vertex(), values);
            // Weights that fit, that fit once they are divided, that do not, none, and but one.
            let small: Vec<i32> = (0..count).map(|_| below(30_000.0)).collect();
            let even: Vec<i32> = small.iter().map(|w| 8 * w).collect();
            let large: Vec<i32> = (0..count).map(|_| below(6e6)).collect();
            let one: Vec<i32> = (0..count).map(|k| i32::from(k == count / 2)).collect();
            for weights in [small, even, large, one, vec![0; count]] {
                check(&modes, &weights);
            }
        }
    }

    #[test]
    fn modes_of_the_largest_numbers_do_not_overflow() {
        for number in [i16::MIN, i16::MAX] {
            let modes = Modes::new(1.0, 5, &[number; 240]);
            for weight in [-32_768, -32_767, 32_767, -98_305, (1 << 29) - 1] {
                check(&modes, &[weight; 5]);
            }
        }
    }

    #[test]
    fn headroom_is_what_still_fits() {
        for largest in [0, 1, 900, 9000, 32_767] {
            let small = largest / 8;
            let modes = Modes::new(
                1.0,
                4,
                &[[largest; 3], [small; 3], [small; 3], [small; 3]].concat(),
            );
            let finer = i32::from(largest) << modes.headroom();
            assert!(finer <= i16::MAX.into() && finer + 3 * (finer / 8) <= MOST as i32);
        }
    }
}
