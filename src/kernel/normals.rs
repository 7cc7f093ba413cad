//! Vertex normals.

use std::ops::Range;

use glam::{Vec3, Vec4, Vec4Swizzles};
use wide::f32x4;

use crate::predict::Around;

/// Sums that stay in the fastest memory until their vectors are made of length 1.
const CHUNK: usize = 64;

/// Corners of a polygon, each as the place of its first number: three times a vertex.
type Ring = [u32; 6];

/// The vertices whose normals change together, and what those are computed from.
///
/// The triangles around a vertex fill a polygon, and the sum of their cross products depends on nothing
/// but its corners: of six it is (r0 - r2) x (r1 - r5) + (r2 - r4) x (r3 - r5), where six triangles have a
/// cross product each, and nothing has to be added to what other vertices have. Nearly all vertices have
/// six triangles or fewer; of fewer the last corner is there again.
#[derive(Debug, Clone)]
pub(crate) struct Patch {
    /// How many vertices the mesh has.
    count: usize,
    /// The smallest range of vertices in which a position or a normal changes.
    pub range: Range<u32>,
    /// The vertices of which any does.
    turned: Vec<Range<u32>>,
    /// A polygon of each of them.
    rings: Vec<Ring>,
    /// The other polygons of those that have more, with the place of the vertex among them, increasing.
    more: Vec<(u32, Ring)>,
}

/// Which edge has some vertex at its start (0) or end (1).
///
/// What is not found among so many makes more polygons of fewer corners: no mesh, however strange, costs
/// more than its size.
fn find(edges: &[[u32; 2]], which: usize, vertex: u32) -> Option<usize> {
    edges.iter().take(64).position(|edge| edge[which] == vertex)
}

/// Appends a polygon in pieces of six corners.
fn cut(mut corners: &[u32], pieces: &mut Vec<Ring>) {
    let Some(&first) = corners.first() else {
        return;
    };
    let mut ring = [first; 6];
    // Each piece but the first starts at the first corner and the last of the piece before.
    let mut from = 0;
    loop {
        let last = corners.len() - 1;
        for (corner, i) in ring.iter_mut().skip(from).zip(0..) {
            *corner = corners[last.min(i)];
        }
        pieces.push(ring.map(|v| 3 * v));
        if last < 6 - from {
            return;
        }
        corners = &corners[5 - from..];
        from = 1;
        ring[0] = first;
    }
}

impl Patch {
    /// All vertices of a mesh.
    // Not inlined, as all that only reading needs: the module is downloaded before it runs.
    #[inline(never)]
    pub fn new(around: &Around) -> Self {
        // It was indexed by each vertex that it names, so that none is `count` or beyond.
        let count = around.count();
        let mut whole = Self {
            count,
            range: 0..count as u32,
            turned: std::iter::once(0..count as u32).collect(),
            rings: Vec::with_capacity(count),
            more: Vec::new(),
        };
        let (mut edges, mut corners, mut pieces) = (Vec::new(), Vec::new(), Vec::new());
        for v in 0..count as u32 {
            edges.clear();
            edges.extend_from_slice(around.of(v));
            pieces.clear();
            // Edges that go on from one another; mostly one way around the vertex.
            while let Some([start, mut end]) = edges.pop() {
                corners.clear();
                corners.extend([start, end]);
                while end != start
                    && let Some(next) = find(&edges, 0, end)
                {
                    end = edges.swap_remove(next)[1];
                    corners.push(end);
                }
                if start == end {
                    corners.pop();
                } else {
                    // At a border the vertex itself is a corner; then come those before the first.
                    corners.push(v);
                    let ahead = corners.len();
                    let mut first = start;
                    while let Some(before) = find(&edges, 1, first) {
                        first = edges.swap_remove(before)[0];
                        corners.push(first);
                    }
                    corners[ahead..].reverse();
                }
                cut(&corners, &mut pieces);
            }
            let mut pieces = pieces.iter();
            whole.rings.push(*pieces.next().unwrap_or(&[3 * v; 6]));
            whole.more.extend(pieces.map(|ring| (v, *ring)));
        }
        whole
    }

    /// The part of the whole mesh that a move of some vertices touches.
    #[inline(never)]
    pub fn part(&self, moved: &[&[u32]]) -> Self {
        let mut touched = vec![false; 3 * self.rings.len()];
        for &v in moved.iter().copied().flatten() {
            touched[3 * v as usize] = true;
        }
        // A normal turns when a vertex around its own moves; a position that changes counts as well.
        let turns = |ring: &Ring| ring.iter().any(|&corner| touched[corner as usize]);
        let mut turned: Vec<bool> = self.rings.iter().map(turns).collect();
        for &v in moved.iter().copied().flatten() {
            turned[v as usize] = true;
        }
        for (v, ring) in &self.more {
            turned[*v as usize] |= turns(ring);
        }
        let mut part = Self {
            count: self.count,
            range: 0..0,
            turned: Vec::new(),
            rings: Vec::new(),
            more: Vec::new(),
        };
        let mut more = self.more.iter().peekable();
        for (v, ring) in (0..).zip(&self.rings) {
            let place = part.rings.len() as u32;
            while let Some((_, ring)) = more.next_if(|more| more.0 == v) {
                if turned[v as usize] {
                    part.more.push((place, *ring));
                }
            }
            if !turned[v as usize] {
                continue;
            }
            part.rings.push(*ring);
            match part.turned.last_mut() {
                Some(last) if last.end == v => last.end = v + 1,
                _ => part.turned.push(v..v + 1),
            }
        }
        let ends = part.turned.first().zip(part.turned.last());
        part.range = ends.map_or(0..0, |(first, last)| first.start..last.end);
        part
    }

    /// How many polygons it has.
    pub fn size(&self) -> usize {
        self.rings.len() + self.more.len()
    }

    /// Recomputes the unit normals of the patch: the sum of the cross products of the triangles
    /// around a vertex, so each counts by its area.
    ///
    /// Both slices have one entry more than there are vertices, so that four numbers can be read
    /// wherever three are. A vertex whose triangles have no area gets a zero normal. Where no normals
    /// are kept, nothing happens.
    pub fn normals(&self, positions: &[Vec3], normals: &mut [Vec3]) {
        // Reading relies on the number of positions.
        if normals.is_empty() || positions.len() <= self.count {
            return;
        }
        // SAFETY: the corners of all rings are below `count`: `Around::new`, whose vertices `Patch::new`
        // makes all rings of that there are, would have panicked, and none is changed later.
        #[allow(unsafe_code)]
        let area = |ring: &Ring| unsafe { area(positions, ring) };
        let mut rings = &self.rings[..];
        let mut more = self.more.iter().peekable();
        let mut place = 0;
        let mut sums = [Vec4::ZERO; CHUNK];
        for range in &self.turned {
            let range = range.start as usize..range.end as usize;
            for normals in normals[range].chunks_mut(CHUNK) {
                let (own, rest) = rings.split_at(normals.len());
                rings = rest;
                for (sum, ring) in sums.iter_mut().zip(own) {
                    *sum = area(ring);
                }
                let end = place + own.len() as u32;
                while let Some((at, ring)) = more.next_if(|more| more.0 < end) {
                    sums[(at - place) as usize] += area(ring);
                }
                place = end;
                normalise(&sums[..own.len()], normals);
            }
        }
    }
}

/// Twice the area of a polygon, along its normal.
///
/// # Safety
/// All places of the ring are of vertices, and positions have one more than these.
#[allow(unsafe_code)]
#[inline(always)]
unsafe fn area(positions: &[Vec3], ring: &Ring) -> Vec4 {
    let numbers = positions.as_ptr().cast::<f32>();
    // Four numbers at once, so that they are one load. Checked loads take the whole kernel 1.4 times
    // as long.
    // SAFETY: four numbers from a vertex's first on are its own and the first of the next one, which is
    // there.
    let corner = |at: u32| unsafe { numbers.add(at as usize).cast::<Vec4>().read_unaligned() };
    let [a, b, c, d, e, f] = ring.map(corner);
    // Cross products but for the order of their numbers, which their sum is put into.
    let turned = |a: Vec4, b: Vec4| a * b.yzxw() - a.yzxw() * b;
    let sum = turned(a - c, b - f) + turned(c - e, d - f);
    sum.yzxw()
}

/// Vectors of length 1, or 0 where there was none.
fn normalise(sums: &[Vec4], normals: &mut [Vec3]) {
    let (fours, rest) = sums.as_chunks::<4>();
    let (outs, ends) = normals.as_chunks_mut::<4>();
    for (four, out) in fours.iter().zip(outs) {
        let [x, y, z, _] = f32x4::transpose(bytemuck::cast(*four));
        let shorter = one_over((x * x + y * y + z * z).sqrt()).to_array();
        let out = bytemuck::cast_slice_mut(out);
        for (i, (row, shorter)) in four.iter().zip(shorter).enumerate() {
            // Whole rows, each over the fourth number of the one before, as far as there is room.
            let row: [f32; 4] = (*row * shorter).into();
            let room = 4.min(12 - 3 * i);
            out[3 * i..3 * i + room].copy_from_slice(&row[..room]);
        }
    }
    for (out, v) in ends.iter_mut().zip(rest) {
        let length = (v.x * v.x + v.y * v.y + v.z * v.z).sqrt();
        *out = (*v * one_over(f32x4::splat(length)).to_array()[0]).truncate();
    }
}

/// 1 / x, and 0 where that is none.
#[inline]
fn one_over(x: f32x4) -> f32x4 {
    let one = f32x4::ONE / x;
    // Where x is too small to be divided by, one / x is infinite: not below the largest number.
    one.simd_le(f32x4::splat(f32::MAX)) & one
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::Random;

    /// A sheet of squares, some of them cut the other way, one half missing.
    fn sheet(side: u32) -> Vec<[u32; 3]> {
        let squares = (0..side - 1).flat_map(|y| (0..side - 1).map(move |x| y * side + x));
        let mut triangles: Vec<[u32; 3]> = squares
            .flat_map(|a| {
                let [b, c, d] = [a + 1, a + side + 1, a + side];
                match a % 3 {
                    0 => [[a, b, d], [b, c, d]],
                    _ => [[c, d, a], [a, b, c]],
                }
            })
            .collect();
        triangles.remove(7);
        triangles
    }

    #[test]
    fn normals_are_those_of_one_triangle_after_the_other() {
        let mut random = Random::new(4);
        let triangles = sheet(9);
        let whole = Patch::new(&Around::new(81, &triangles));
        let mut positions: Vec<Vec3> = (0..82)
            .map(|v| Vec3::new((v % 9) as f32, (v / 9) as f32, random.normal() as f32))
            .collect();
        let plain = |positions: &[Vec3]| -> Vec<Vec3> {
            let mut sums = vec![Vec3::ZERO; 81];
            for t in &triangles {
                let [a, b, c] = t.map(|v| positions[v as usize]);
                t.iter()
                    .for_each(|&v| sums[v as usize] += (b - a).cross(c - a));
            }
            sums.into_iter().map(Vec3::normalize_or_zero).collect()
        };
        let mut normals = vec![Vec3::splat(7.0); 82];
        let check = |normals: &[Vec3], positions: &[Vec3]| {
            for (plain, fast) in plain(positions).iter().zip(normals) {
                // Sums of six cross products of the size of 1, each rounded some times to 6e-8.
                assert!(plain.distance(*fast) < 2e-6, "{plain}, {fast}");
            }
        };
        whole.normals(&positions, &mut normals);
        check(&normals, &positions);
        // A part of it, after a move of some.
        let patch = whole.part(&[&[40, 41], &[8]]);
        [40, 41, 8]
            .iter()
            .for_each(|&v: &usize| positions[v].z += 1.0);
        patch.normals(&positions, &mut normals);
        check(&normals, &positions);
        assert_eq!(normals[81], Vec3::splat(7.0), "nothing beyond the vertices");
        assert!(patch.size() < 30, "{}", patch.size());
        assert_eq!(patch.range, 7..52);
    }

    /// Fans of triangles, in an order of chance, some of which meet in one vertex, some closed, and some
    /// of no triangle that a mesh should have.
    #[test]
    fn whatever_is_around_a_vertex_is_filled() {
        let mut random = Random::new(9);
        for size in 1..60 {
            let mut triangles: Vec<[u32; 3]> = (1..size)
                .map(|i| [0, (i - 1) % 40 + 1, i % 40 + 1])
                .collect();
            let corner = |random: &mut Random| (random.uniform() * 41.0) as u32;
            for _ in 0..size % 7 {
                triangles.push([0; 3].map(|_| corner(&mut random)));
            }
            for i in (1..triangles.len()).rev() {
                let other = (random.uniform() * (i + 1) as f64) as usize;
                triangles.swap(i, other);
            }
            let positions: Vec<Vec3> = (0..42)
                .map(|_| Vec3::from_array([0; 3].map(|_| random.normal() as f32)))
                .collect();
            let whole = Patch::new(&Around::new(41, &triangles));
            let mut filled = [DVec3::ZERO; 41];
            let rings = whole.rings.iter().zip(0..).map(|(ring, v)| (v, ring));
            for (v, ring) in rings.chain(whole.more.iter().map(|(v, ring)| (*v, ring))) {
                let corners = ring.map(|at| positions[at as usize / 3].as_dvec3());
                let next = (1..7).map(|i| corners[i % 6]);
                filled[v as usize] += corners
                    .iter()
                    .zip(next)
                    .map(|(p, q)| p.cross(q))
                    .sum::<DVec3>();
            }
            let mut sums = [DVec3::ZERO; 41];
            for t in &triangles {
                let [a, b, c] = t.map(|v| positions[v as usize].as_dvec3());
                t.iter()
                    .for_each(|&v| sums[v as usize] += (b - a).cross(c - a));
            }
            for (v, (sum, filled)) in sums.iter().zip(filled).enumerate() {
                assert!(
                    sum.distance(filled) < 1e-9,
                    "{v} of {size}: {sum}, {filled}"
                );
            }
        }
    }

    #[test]
    fn what_has_no_area_has_no_normal() {
        let mut normals = vec![Vec3::ONE; 4];
        Patch::new(&Around::new(3, &[[0, 1, 2]])).normals(&[Vec3::X; 4], &mut normals);
        assert_eq!(normals[..3], [Vec3::ZERO; 3]);
    }
}
