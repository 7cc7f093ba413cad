//! Prediction of numbers on a mesh from their neighbours.
//!
//! Positions, modes and texture coordinates vary smoothly along a surface, so a vertex is told
//! well by those around it that are known already, and what is left to store is small: the
//! parallelogram rule (Touma & Gotsman 1998, "Triangle mesh compression"), averaged over the
//! parallelograms there are. Writer and reader derive the same [`Walk`] from the triangles;
//! everything is integer arithmetic, so what is restored is exact.

use std::cell::Cell;

use wide::i32x4;

use crate::blob::{Planes, READ};

/// Of the triangles around a vertex so many are looked at, so that no mesh, however strange, costs
/// more than its size. A head has 12 at most.
const MOST_AROUND: usize = 32;
/// Vertices whose residuals are read before they are needed: of each mode some that lie side by side.
const ROWS: usize = 4 * READ;
/// A vertex is predicted from so many others' numbers at most.
const MOST_PREDICTORS: usize = 8;

/// An order of a mesh's vertices and what predicts each from earlier ones.
#[derive(Debug)]
pub(crate) struct Walk {
    order: Vec<u32>,
    /// Predictors of `order[i]` are those from `starts[i]` to `starts[i + 1]`.
    starts: Vec<u32>,
    /// `[a, b, c]`: a + b - c. A vertex has 1, 2, 4 or 8 of them, so that the mean is a shift, but
    /// the first, which has none.
    predictors: Vec<[u32; 3]>,
    /// How many vertices it is of, with those that are the images of others.
    places: usize,
    /// Of each of these its own place, and that of the vertex whose image it is.
    images: Vec<[u32; 2]>,
}

impl Walk {
    // Not inlined, as all that only reading needs: the module is downloaded before it runs.
    /// A breadth-first walk over all vertices.
    #[inline(never)]
    pub fn new(around: &Around) -> Self {
        let count = around.count();
        const UNSEEN: u32 = u32::MAX;
        let mut rank = vec![UNSEEN; count];
        let mut walk = Self::with_capacity(count);
        let mut next = 0;
        for seed in 0..count as u32 {
            if rank[seed as usize] != UNSEEN {
                continue;
            }
            rank[seed as usize] = walk.order.len() as u32;
            walk.order.push(seed);
            while let Some(&vertex) = walk.order.get(next) {
                next += 1;
                for &other in around.few(vertex).as_flattened() {
                    if rank[other as usize] == UNSEEN {
                        rank[other as usize] = walk.order.len() as u32;
                        walk.order.push(other);
                    }
                }
            }
        }
        for at in 0..count {
            let vertex = walk.order[at];
            let known = |v: u32| rank[v as usize] < at as u32;
            let first = walk.predictors.len();
            for &[a, b] in around.few(vertex) {
                if !(known(a) && known(b)) {
                    continue;
                }
                // The triangles on the other side of the edge a b.
                for &[x, y] in around.few(a) {
                    if x == b && known(y) {
                        walk.predictors.push([a, b, y]);
                    } else if y == b && known(x) {
                        walk.predictors.push([a, b, x]);
                    }
                }
            }
            if walk.predictors.len() == first {
                let near = around.few(vertex).as_flattened().iter();
                let near = near.filter(|v| known(**v)).map(|&v| [v; 3]);
                walk.predictors.extend(near);
            }
            walk.close(first);
        }
        walk
    }

    fn with_capacity(count: usize) -> Self {
        let mut starts = Vec::with_capacity(count + 1);
        starts.push(0);
        Self {
            order: Vec::with_capacity(count),
            starts,
            predictors: Vec::with_capacity(2 * count),
            places: count,
            images: Vec::new(),
        }
    }

    /// Ends the predictors, from `first` on, of the next vertex of the order.
    fn close(&mut self, first: usize) {
        let at = self.starts.len() - 1;
        if self.predictors.len() == first && at > 0 {
            self.predictors.push([self.order[at - 1]; 3]);
        }
        let count = (self.predictors.len() - first).min(MOST_PREDICTORS);
        if count > 0 {
            self.predictors.truncate(first + (1 << count.ilog2()));
        }
        self.starts.push(self.predictors.len() as u32);
    }

    /// The part of the walk on some vertices (increasing), which get their places among these for
    /// numbers: the order stays, and predictors that lie wholly on them; a vertex that loses all
    /// is predicted from those corners that are left.
    ///
    /// By a `mirror` map one whose image is an earlier one of them is left out, too, unless they are taken `whole`:
    /// its numbers are its image's, but for their signs.
    #[inline(never)]
    pub fn on(&self, vertices: &[u32], mirror: &[u32], whole: bool) -> Self {
        const OUTSIDE: u32 = u32::MAX;
        let mut place = vec![OUTSIDE; self.order.len()];
        let mut images = Vec::new();
        for (&vertex, at) in vertices.iter().zip(0..) {
            let image = place[mirror[vertex as usize] as usize];
            if image == OUTSIDE || whole {
                place[vertex as usize] = at;
            } else {
                images.push([at, image]);
            }
        }
        let mut walk = Self::with_capacity(vertices.len());
        for (&vertex, row) in self.order.iter().zip(self.starts.windows(2)) {
            if place[vertex as usize] == OUTSIDE {
                continue;
            }
            walk.order.push(place[vertex as usize]);
            let first = walk.predictors.len();
            let all = &self.predictors[row[0] as usize..row[1] as usize];
            let placed = || all.iter().map(|p| p.map(|v| place[v as usize]));
            let whole = placed().filter(|p| !p.contains(&OUTSIDE));
            walk.predictors.extend(whole);
            if walk.predictors.len() == first {
                let left = placed().flatten().filter(|&v| v != OUTSIDE);
                walk.predictors.extend(left.map(|v| [v; 3]));
            }
            walk.close(first);
        }
        walk.images = images;
        walk
    }

    /// How many vertices there are numbers of.
    pub fn count(&self) -> usize {
        self.order.len()
    }

    /// The predictors of the vertex at place `at` of the order.
    fn predictors(&self, at: usize) -> &[[u32; 3]] {
        &self.predictors[self.starts[at] as usize..self.starts[at + 1] as usize]
    }

    /// What prediction misses, in the order of the walk, all of axis 0, then all of axis 1 ...
    /// `values` are `axes` numbers a vertex, images included.
    pub fn residuals(&self, values: &[i32], axes: usize) -> Vec<i32> {
        let mut residuals = vec![0; self.order.len() * axes];
        for (at, &vertex) in self.order.iter().enumerate() {
            let own = self.predictors(at);
            let value = |v: u32, axis: usize| values[v as usize * axes + axis];
            for axis in 0..axes {
                let sum = own.iter().fold(own.len() as i32 / 2, |sum, &[a, b, c]| {
                    let guess = value(a, axis).wrapping_add(value(b, axis));
                    sum.wrapping_add(guess.wrapping_sub(value(c, axis)))
                });
                let guess = sum >> own.len().max(1).ilog2();
                residuals[axis * self.order.len() + at] = value(vertex, axis).wrapping_sub(guess);
            }
        }
        residuals
    }

    /// The values of [`Walk::residuals`], in planes, of which there may be more: `numbers` of `modes`
    /// a vertex, number 0 of all modes first. In the residuals it is all numbers of mode 0.
    ///
    /// They come in fours ([`fours`] a number of a vertex), the last filled up with zeros, so that all
    /// arithmetic is on four at a time.
    ///
    /// Where there are images, `odd` says for each mode in these fours which numbers have the other sign on them:
    /// the first, where it is 0, and all others, where it is -1.
    #[inline(never)]
    pub fn restore(
        &self,
        residuals: Planes,
        modes: usize,
        numbers: usize,
        odd: &[[i32; 4]],
    ) -> Vec<i32x4> {
        let width = numbers * fours(modes);
        let mut values = vec![i32x4::ZERO; self.places * width];
        // A row is read while another is written.
        let cells = Cell::from_mut(&mut values[..]).as_slice_of_cells();
        let mut missed = vec![i32x4::ZERO; ROWS * width];
        for first in (0..self.order.len()).step_by(ROWS) {
            for (i, mode) in (0..width).map(|i| (i, i % fours(modes) * 4)) {
                for (out, first) in missed.chunks_mut(READ * width).zip((first..).step_by(READ)) {
                    let row = |k: usize| match mode + k < modes {
                        true => {
                            ((mode + k) * numbers + i / fours(modes)) * self.order.len() + first
                        }
                        false => usize::MAX,
                    };
                    residuals.read([row(0), row(1), row(2), row(3)], &mut out[i..], width);
                }
            }
            let each = (first..self.order.len()).zip(missed.chunks_exact(width.max(1)));
            for (at, missed) in each {
                self.restore_one(at, missed, cells);
            }
        }
        for &[own, image] in &self.images {
            let numbers = row(cells, width, own).iter().zip(row(cells, width, image));
            for (i, (own, image)) in numbers.enumerate() {
                let first = i32x4::splat(-i32::from(i < odd.len()));
                let negative = i32x4::new(odd[i % odd.len()]) ^ first;
                own.set((image.get() ^ negative) - negative);
            }
        }
        values
    }

    /// Restores the numbers of the vertex at place `at` of the order: the mean of its predictors,
    /// rounded to the nearest, and what that missed, in arithmetic modulo 2^32.
    // Not inlined, as all that is done for each of many parts of a model: an engine runs the fast code
    // of a function from its next call on, and a model is read once.
    #[cfg_attr(target_arch = "wasm32", inline(never))]
    fn restore_one(&self, at: usize, missed: &[i32x4], values: &[Cell<i32x4>]) {
        let width = missed.len();
        let own = row(values, width, self.order[at])
            .iter()
            .zip(missed)
            .zip(0..width);
        match self.predictors(at) {
            // Six of seven vertices have two.
            [p, q] => {
                let (p, q) = (corners(values, width, p), corners(values, width, q));
                for ((value, &missed), i) in own {
                    let sum = guess(&p, i) + guess(&q, i) + i32x4::ONE;
                    value.set((sum >> 1) + missed);
                }
            }
            all => {
                let shift = all.len().max(1).ilog2();
                for ((value, &missed), i) in own {
                    let half = i32x4::splat(all.len() as i32 / 2);
                    let mut sum = half;
                    for p in all {
                        sum += guess(&corners(values, width, p), i);
                    }
                    value.set((sum >> shift) + missed);
                }
            }
        }
    }
}

/// The numbers of a vertex, of which all have as many.
#[inline(always)]
fn row(values: &[Cell<i32x4>], width: usize, v: u32) -> &[Cell<i32x4>] {
    &values[v as usize * width..][..width]
}

/// Those of three.
#[inline(always)]
fn corners<'a>(values: &'a [Cell<i32x4>], width: usize, p: &[u32; 3]) -> [&'a [Cell<i32x4>]; 3] {
    [
        row(values, width, p[0]),
        row(values, width, p[1]),
        row(values, width, p[2]),
    ]
}

/// Number `i` of a parallelogram's fourth corner, by rows of the others.
#[inline(always)]
fn guess(corners: &[&[Cell<i32x4>]; 3], i: usize) -> i32x4 {
    corners[0][i].get() + corners[1][i].get() - corners[2][i].get()
}

/// How many fours hold so many numbers.
pub(crate) const fn fours(numbers: usize) -> usize {
    numbers.div_ceil(4)
}

/// The other two corners of the triangles around each vertex, in their order.
pub(crate) struct Around {
    starts: Vec<u32>,
    edges: Vec<[u32; 2]>,
}

impl Around {
    // Not inlined, as two need it.
    #[inline(never)]
    pub fn new(count: usize, triangles: &[[u32; 3]]) -> Self {
        let mut starts = vec![0_u32; count + 1];
        for &vertex in triangles.as_flattened() {
            starts[vertex as usize + 1] += 1;
        }
        for v in 0..count {
            starts[v + 1] += starts[v];
        }
        let mut next = starts.clone();
        let mut edges = vec![[0; 2]; 3 * triangles.len()];
        for &[a, b, c] in triangles {
            for (vertex, edge) in [(a, [b, c]), (b, [c, a]), (c, [a, b])] {
                let at = &mut next[vertex as usize];
                edges[*at as usize] = edge;
                *at += 1;
            }
        }
        Self { starts, edges }
    }

    /// How many vertices there are.
    pub fn count(&self) -> usize {
        self.starts.len() - 1
    }

    /// Of all.
    pub fn of(&self, vertex: u32) -> &[[u32; 2]] {
        let v = vertex as usize;
        &self.edges[self.starts[v] as usize..self.starts[v + 1] as usize]
    }

    /// Of the first.
    fn few(&self, vertex: u32) -> &[[u32; 2]] {
        let all = self.of(vertex);
        &all[..all.len().min(MOST_AROUND)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::blob::in_planes;

    /// What is restored of residuals, `axes` numbers a vertex.
    fn restored(walk: &Walk, residuals: &[i32], modes: usize, numbers: usize) -> Vec<i32> {
        let planes = in_planes(residuals);
        let planes = Planes::new(&planes, residuals.len()).unwrap();
        let fours = walk.restore(planes, modes, numbers, &[]);
        let rows = bytemuck::cast_slice::<_, i32>(&fours).chunks_exact(4 * super::fours(modes));
        let rows: Vec<&[i32]> = rows.collect();
        let vertices = rows.chunks_exact(numbers);
        let by_mode = vertices.flat_map(|v| (0..modes).flat_map(|k| v.iter().map(move |n| n[k])));
        assert!(rows.iter().all(|row| row[modes..].iter().all(|&n| n == 0)));
        by_mode.collect()
    }

    /// A grid of `side` x `side` vertices, two triangles a square.
    fn grid(side: u32) -> Vec<[u32; 3]> {
        let mut triangles = Vec::new();
        for y in 0..side - 1 {
            for x in 0..side - 1 {
                let a = y * side + x;
                triangles.push([a, a + 1, a + side + 1]);
                triangles.push([a, a + side + 1, a + side]);
            }
        }
        triangles
    }

    #[test]
    fn what_is_linear_along_a_grid_is_predicted_exactly() {
        let walk = Walk::new(&Around::new(81, &grid(9)));
        let values: Vec<i32> = (0..81).map(|v| 7 * (v % 9) - 300 * (v / 9) + 40).collect();
        let residuals = walk.residuals(&values, 1);
        // The first, and the borders at its two sides, have no parallelogram before them.
        let missed = residuals.iter().filter(|r| **r != 0).count();
        assert!(missed < 2 * 9, "{missed} of 81: {residuals:?}");
    }

    #[test]
    fn whatever_is_predicted_is_restored() {
        let mut random = crate::Random::new(5);
        let strange = [
            vec![],
            vec![[0, 0, 0], [1, 1, 2], [2, 1, 1]],
            (1..80).map(|v| [0, v, v + 1]).collect(),
            (2..81).map(|v| [0, 1, v]).collect(),
            grid(9),
        ];
        for triangles in strange {
            let walk = Walk::new(&Around::new(81, &triangles));
            let mut order = walk.order.clone();
            order.sort_unstable();
            assert!(order.iter().copied().eq(0..81), "each vertex once");
            for scale in [10.0, 1e9] {
                let values: Vec<i32> = (0..243).map(|_| (random.normal() * scale) as i32).collect();
                for (modes, numbers) in [(3, 1), (1, 3)] {
                    let residuals = walk.residuals(&values, 3);
                    assert_eq!(restored(&walk, &residuals, modes, numbers), values);
                }
            }
        }
    }

    /// A grid of which columns are mirror images; one vertex has its image outside of what is kept.
    #[test]
    fn what_one_side_says_of_the_other_is_restored() {
        let walk = Walk::new(&Around::new(81, &grid(9)));
        let mirror: Vec<u32> = (0..81).map(|v| v / 9 * 9 + (8 - v % 9)).collect();
        let vertices: Vec<u32> = (9..81).filter(|v| *v != 20).collect();
        let half = walk.on(&vertices, &mirror, false);
        assert_eq!(half.count(), 8 * 5);
        assert_eq!(walk.on(&vertices, &mirror, true).count(), vertices.len());
        let mut random = crate::Random::new(3);
        // Of two modes the first is even and the second odd, in x, y, z a vertex.
        let negative = |mode: usize, axis: usize| (axis == 0) == (mode == 0);
        let mut values = vec![0; 81 * 6];
        for v in 0..81 {
            for i in 0..6 {
                let image = values[mirror[v] as usize * 6 + i];
                values[v * 6 + i] = match mirror[v].cmp(&(v as u32)) {
                    std::cmp::Ordering::Less if negative(i / 3, i % 3) => -image,
                    std::cmp::Ordering::Less => image,
                    _ => (random.normal() * 100.0) as i32,
                };
            }
        }
        let of = |some: &[u32]| -> Vec<i32> {
            let rows = some.iter().map(|&v| &values[v as usize * 6..][..6]);
            rows.flatten().copied().collect()
        };
        let residuals = half.residuals(&of(&vertices), 6);
        let planes = in_planes(&residuals);
        let planes = Planes::new(&planes, residuals.len()).unwrap();
        let rows = half.restore(planes, 2, 3, &[[0, -1, 0, 0]]);
        let all = of(&vertices);
        for (found, expected) in rows.chunks_exact(3).zip(all.chunks_exact(6)) {
            let modes = [0, 1].map(|mode| [0, 1, 2].map(|axis| found[axis].to_array()[mode]));
            assert_eq!(modes.as_flattened(), expected);
        }
    }

    #[test]
    fn a_part_of_a_walk_predicts_and_restores_numbers_of_its_vertices() {
        let walk = Walk::new(&Around::new(81, &grid(9)));
        let inside = |v: &u32| (2..8).contains(&(v % 9)) && v / 9 > 2;
        let vertices: Vec<u32> = (0..81).filter(inside).collect();
        let all: Vec<u32> = (0..81).collect();
        let part = walk.on(&vertices, &all, true);
        let linear = |&v: &u32| 7 * (v as i32 % 9) - 300 * (v as i32 / 9) + 40;
        let values: Vec<i32> = vertices.iter().map(linear).collect();
        let residuals = part.residuals(&values, 1);
        assert_eq!(restored(&part, &residuals, 1, 1), values);
        // All but the borders along which the walk comes in.
        let missed = residuals.iter().filter(|r| **r != 0).count();
        assert!(missed < 3 * 6, "{missed} of 36: {residuals:?}");
        assert!(walk.on(&[], &all, true).order.is_empty());
    }
}
