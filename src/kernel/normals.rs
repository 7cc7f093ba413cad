//! Vertex normals.

use std::cell::RefCell;
use std::ops::Range;

use glam::{Vec3, Vec3A, Vec4};
use wide::f32x4;

use crate::mesh::VertexTriangles;

/// The triangles of a mesh for normals: two that share an edge as one.
///
/// Of triangles (a, b, c) and (a, c, d) the cross products sum to (c - a) x (d - b): a and c take
/// that, b takes the first one's, d the rest.
#[derive(Debug, Clone, Default)]
pub(crate) struct Facets {
    pairs: Vec<[u32; 4]>,
    single: Vec<[u32; 3]>,
}

/// The vertices that move together in an event, and what their move does to normals.
#[derive(Debug, Clone)]
pub(crate) struct Patch {
    /// The smallest range of vertices in which a position or a normal changes.
    pub range: Range<u32>,
    /// The vertices whose normal changes.
    turned: Vec<Range<u32>>,
    /// The corners of `facets`.
    corners: Vec<Range<u32>>,
    facets: Facets,
}

/// Vertices as ranges, increasing.
fn ranges(vertices: &[bool]) -> Vec<Range<u32>> {
    let mut ranges: Vec<Range<u32>> = Vec::new();
    for v in (0..vertices.len() as u32).filter(|&v| vertices[v as usize]) {
        match ranges.last_mut() {
            Some(last) if last.end == v => last.end = v + 1,
            _ => ranges.push(v..v + 1),
        }
    }
    ranges
}

impl Facets {
    /// Pairs what can be paired of the triangles: first with the one before, as two of a quad are,
    /// then with any neighbour that is left.
    pub fn new(triangles: &[[u32; 3]], adjacency: &VertexTriangles) -> Self {
        let mut left = vec![true; triangles.len()];
        let mut pairs = Vec::new();
        let mut pair = |left: &mut [bool], one: usize, other: usize| {
            let found = left[one] && left[other] && one != other;
            let Some(corners) = found
                .then(|| joined(triangles[one], triangles[other]))
                .flatten()
            else {
                return false;
            };
            (left[one], left[other]) = (false, false);
            pairs.push(corners);
            true
        };
        for t in 1..triangles.len() {
            pair(&mut left, t - 1, t);
        }
        for t in 0..triangles.len() {
            if left[t] {
                let around = triangles[t].into_iter().flat_map(|v| adjacency.of(v));
                let mut around = around.map(|&other| other as usize);
                let _ = around.any(|other| pair(&mut left, t, other));
            }
        }
        let single = triangles.iter().zip(left);
        Self {
            pairs,
            single: single.filter(|t| t.1).map(|t| *t.0).collect(),
        }
    }

    /// What a move of the vertices `moved` of `count` touches.
    pub fn patch(&self, moved: &[&[u32]], count: usize) -> Patch {
        let mut touched = vec![false; count];
        for &v in moved.iter().copied().flatten() {
            touched[v as usize] = true;
        }
        let mut turned = vec![false; count];
        // A triangle turns when a corner of it moves. Of a pair only one may; that the other's corner
        // is computed again as well does not change it.
        self.all(&touched, |v| turned[v as usize] = true);
        let mut corners = turned.clone();
        self.all(&turned, |v| corners[v as usize] = true);
        let turned_ranges = ranges(&turned);
        let any = |corners: &[u32]| corners.iter().any(|&v| turned[v as usize]);
        Patch {
            range: turned_ranges.first().map_or(0, |r| r.start)
                ..turned_ranges.last().map_or(0, |r| r.end),
            turned: turned_ranges,
            corners: ranges(&corners),
            facets: Facets {
                pairs: self.pairs.iter().filter(|p| any(&p[..])).copied().collect(),
                single: self
                    .single
                    .iter()
                    .filter(|t| any(&t[..]))
                    .copied()
                    .collect(),
            },
        }
    }

    /// Calls `mark` for each corner of those facets that have one of some vertices.
    fn all(&self, some: &[bool], mut mark: impl FnMut(u32)) {
        let pairs = self.pairs.iter().map(|p| &p[..]);
        for corners in pairs.chain(self.single.iter().map(|t| &t[..])) {
            if corners.iter().any(|&v| some[v as usize]) {
                corners.iter().for_each(|&v| mark(v));
            }
        }
    }
}

/// Triangles (a, b, c) and (a, c, d) as [a, b, c, d], when two are such.
fn joined(one: [u32; 3], other: [u32; 3]) -> Option<[u32; 4]> {
    let turns = |[p, q, r]: [u32; 3]| [[p, q, r], [q, r, p], [r, p, q]];
    turns(one).into_iter().find_map(|[a, b, c]| {
        let second = turns(other).into_iter().find(|t| t[..2] == [a, c])?;
        Some([a, b, c, second[2]])
    })
}

impl Patch {
    /// How many facets it has.
    pub fn size(&self) -> usize {
        self.facets.pairs.len() + self.facets.single.len()
    }

    /// Recomputes the unit normals of the patch: the sum of the cross products of the triangles
    /// around a vertex, so each counts by its area.
    ///
    /// Both slices have one entry more than there are vertices, so that four numbers can be read
    /// wherever three are. A vertex whose triangles have no area gets a zero normal. Where no normals
    /// are kept, nothing happens.
    pub fn normals(&self, positions: &[Vec3], normals: &mut [Vec3]) {
        if normals.is_empty() {
            return;
        }
        thread_local! {
            // Larger than all else that an event needs, and needed only while it lasts.
            static SUMS: RefCell<Vec<Vec3A>> = const { RefCell::new(Vec::new()) };
        }
        SUMS.with_borrow_mut(|sums| {
            if sums.len() < positions.len() {
                sums.resize(positions.len(), Vec3A::ZERO);
            }
            for range in &self.corners {
                sums[range.start as usize..range.end as usize].fill(Vec3A::ZERO);
            }
            self.facets.sum(bytemuck::cast_slice(positions), sums);
            for range in &self.turned {
                let range = range.start as usize..range.end as usize;
                normalise(&sums[range.clone()], &mut normals[range]);
            }
        });
    }
}

impl Facets {
    /// Adds cross products to those of the corners.
    fn sum(&self, positions: &[f32], sums: &mut [Vec3A]) {
        let at = |v: u32| {
            // Four numbers at once, so that they are one load.
            let four = positions[3 * v as usize..].first_chunk::<4>();
            Vec3A::from_vec4(four.map_or(Vec4::ZERO, |four| bytemuck::cast(*four)))
        };
        for &[a, b, c, d] in &self.pairs {
            let start = at(a);
            let second = at(b);
            let diagonal = at(c) - start;
            let both = diagonal.cross(at(d) - second);
            let first = (second - start).cross(diagonal);
            sums[a as usize] += both;
            sums[b as usize] += first;
            sums[c as usize] += both;
            sums[d as usize] += both - first;
        }
        for &[a, b, c] in &self.single {
            let start = at(a);
            let normal = (at(b) - start).cross(at(c) - start);
            sums[a as usize] += normal;
            sums[b as usize] += normal;
            sums[c as usize] += normal;
        }
    }
}

/// Vectors of length 1, or 0 where there was none.
fn normalise(sums: &[Vec3A], normals: &mut [Vec3]) {
    let (fours, rest) = sums.as_chunks::<4>();
    let (outs, ends) = normals.as_chunks_mut::<4>();
    for (four, out) in fours.iter().zip(outs) {
        let rows = four.map(|v| f32x4::new(v.extend(0.0).to_array()));
        let [x, y, z, _] = f32x4::transpose(rows);
        let shorter = one_over((x * x + y * y + z * z).sqrt()).to_array();
        let out = bytemuck::cast_slice_mut(out);
        for (i, (row, shorter)) in four.iter().zip(shorter).enumerate() {
            // Whole rows, each over the fourth number of the one before, as far as there is room.
            let row: [f32; 4] = (*row * shorter).extend(0.0).into();
            let room = 4.min(12 - 3 * i);
            out[3 * i..3 * i + room].copy_from_slice(&row[..room]);
        }
    }
    for (out, v) in ends.iter_mut().zip(rest) {
        let length = (v.x * v.x + v.y * v.y + v.z * v.z).sqrt();
        *out = Vec3::from(*v * one_over(f32x4::splat(length)).to_array()[0]);
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
    use super::*;
    use crate::Random;
    use crate::mesh::Topology;

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

    fn facets(count: usize, triangles: &[[u32; 3]]) -> Facets {
        let topology = Topology {
            uv_vertices: (0..count as u32).collect(),
            uv_triangles: triangles.to_vec(),
            regions: vec![0; count],
            ..Topology::default()
        };
        Facets::new(triangles, &topology.vertex_triangles())
    }

    #[test]
    fn each_triangle_is_in_one_facet() {
        let triangles = sheet(9);
        let facets = facets(81, &triangles);
        let pairs = facets.pairs.iter();
        let halves = pairs.flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]);
        let least_first = |t: [u32; 3]| {
            let least = (0..3).min_by_key(|&i| t[i]).unwrap_or(0);
            [t[least], t[(least + 1) % 3], t[(least + 2) % 3]]
        };
        let mut all: Vec<_> = halves
            .chain(facets.single.iter().copied())
            .map(least_first)
            .collect();
        let mut given: Vec<_> = triangles.iter().copied().map(least_first).collect();
        all.sort_unstable();
        given.sort_unstable();
        assert_eq!(all, given);
        assert!(facets.single.len() < 4, "{:?}", facets.single);
    }

    #[test]
    fn normals_are_those_of_one_triangle_after_the_other() {
        let mut random = Random::new(4);
        let triangles = sheet(9);
        let facets = facets(81, &triangles);
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
        facets
            .patch(&[&(0..81).collect::<Vec<_>>()], 81)
            .normals(&positions, &mut normals);
        check(&normals, &positions);
        // A part of it, after a move of some.
        let patch = facets.patch(&[&[40, 41], &[8]], 81);
        [40, 41, 8]
            .iter()
            .for_each(|&v: &usize| positions[v].z += 1.0);
        patch.normals(&positions, &mut normals);
        check(&normals, &positions);
        assert_eq!(normals[81], Vec3::splat(7.0), "nothing beyond the vertices");
        assert!(patch.size() < 30, "{}", patch.size());
        assert_eq!(patch.range, 7..52);
    }

    #[test]
    fn what_has_no_area_has_no_normal() {
        let facets = facets(3, &[[0, 1, 2]]);
        let mut normals = vec![Vec3::ONE; 4];
        facets
            .patch(&[&[0, 1, 2]], 3)
            .normals(&[Vec3::X; 4], &mut normals);
        assert_eq!(normals[..3], [Vec3::ZERO; 3]);
    }
}
