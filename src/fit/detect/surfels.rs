//! A surface as little pieces on a grid, for quick and rough questions.

use glam::DVec3;

/// Pieces of a surface (surfels), one a grid cell that the surface passes through, and the nearest
/// of them for each cell around.
///
/// However fine or coarse its triangles are, a mesh has as many surfels as its area asks for.
pub struct Surfels {
    /// The mean point of the surface in each cell, mm.
    pub points: Vec<DVec3>,
    /// Unit normals, outwards.
    pub normals: Vec<DVec3>,
    /// mm^2.
    pub areas: Vec<f64>,
    /// The edge of a cell, mm.
    pub cell: f64,
    low: DVec3,
    counts: [usize; 3],
    /// The nearest surfel of each cell, or [`NONE`]; x runs fastest.
    nearest: Vec<u32>,
}

const NONE: u32 = u32::MAX;

/// With more cells than this (128 MB) they grow instead.
const MOST_CELLS: f64 = 16e6;

impl Surfels {
    /// The surfels of a mesh on cells of an edge of `cell` mm, or of more where the mesh is so large
    /// that they would not fit into memory. [`Surfels::near`] reaches `reach` cells far.
    pub fn new(positions: &[DVec3], triangles: &[[u32; 3]], cell: f64, reach: usize) -> Self {
        let corners = || triangles.iter().flatten().map(|&v| positions[v as usize]);
        let low = corners().fold(DVec3::INFINITY, DVec3::min);
        let size = corners().fold(DVec3::NEG_INFINITY, DVec3::max) - low;
        let margin = (reach + 1) as f64;
        let mut cell = cell;
        let counts = loop {
            let counts = (size / cell + 2.0 * margin).ceil();
            if !(counts.element_product() > MOST_CELLS) {
                break counts.to_array().map(|n| n as usize + 1);
            }
            cell *= 1.2;
        };
        let low = low - margin * cell;
        let mut surfels = Self {
            points: Vec::new(),
            normals: Vec::new(),
            areas: Vec::new(),
            cell,
            low,
            counts,
            nearest: vec![NONE; counts.iter().product()],
        };
        surfels.gather(positions, triangles);
        surfels.spread(reach);
        surfels
    }

    /// Sums the surface cell by cell. Surfels are numbered along the grid.
    fn gather(&mut self, positions: &[DVec3], triangles: &[[u32; 3]]) {
        // Cell, area-weighted point and normal, area.
        let mut sums: Vec<(usize, DVec3, DVec3, f64)> = Vec::new();
        for triangle in triangles {
            let [a, b, c] = triangle.map(|v| positions[v as usize]);
            let (ab, ac) = (b - a, c - a);
            let normal = 0.5 * ab.cross(ac);
            let area = normal.length();
            let longest = ab.length().max(ac.length()).max(b.distance(c));
            // A triangle larger than a cell is cut into m^2 equal ones.
            let m = (longest / (0.7 * self.cell)).ceil().max(1.0) as usize;
            let share = 1.0 / (m * m) as f64;
            let mut add = |u: f64, v: f64| {
                let p = a + ab * (u / m as f64) + ac * (v / m as f64);
                let cell = self.cell_of(p).unwrap_or(0);
                let slot = self.nearest[cell] as usize;
                if let Some(sum) = sums.get_mut(slot) {
                    sum.1 += p * (area * share);
                    sum.2 += normal * share;
                    sum.3 += area * share;
                } else {
                    self.nearest[cell] = sums.len() as u32;
                    sums.push((cell, p * (area * share), normal * share, area * share));
                }
            };
            for i in 0..m {
                for j in 0..m - i {
                    add(i as f64 + 1.0 / 3.0, j as f64 + 1.0 / 3.0);
                    if i + j + 1 < m {
                        add(i as f64 + 2.0 / 3.0, j as f64 + 2.0 / 3.0);
                    }
                }
            }
        }
        sums.sort_unstable_by_key(|sum| sum.0);
        for (cell, point, normal, area) in sums {
            // Where two sheets meet in one cell their normals cancel, and it faces nowhere.
            if area > 0.0 && normal.length() > 0.3 * area {
                self.nearest[cell] = self.points.len() as u32;
                self.points.push(point / area);
                self.normals.push(normal.normalize());
                self.areas.push(area);
            } else {
                self.nearest[cell] = NONE;
            }
        }
    }

    /// Gives empty cells their nearest surfel, shell by shell.
    fn spread(&mut self, reach: usize) {
        let [nx, ny, _] = self.counts;
        let (dx, dy, dz) = (1isize, nx as isize, (nx * ny) as isize);
        let offsets: Vec<isize> = (0..27)
            .filter(|&i| i != 13)
            .map(|i| (i % 3 - 1) * dx + (i / 3 % 3 - 1) * dy + (i / 9 - 1) * dz)
            .collect();
        let mut distances = vec![f32::INFINITY; self.nearest.len()];
        let mut shell: Vec<usize> = (0..self.nearest.len())
            .filter(|&cell| self.nearest[cell] != NONE)
            .collect();
        shell.iter().for_each(|&cell| distances[cell] = 0.0);
        for _ in 0..reach {
            let mut next = Vec::new();
            for &cell in &shell {
                let surfel = self.nearest[cell];
                let point = self.points[surfel as usize];
                for &offset in &offsets {
                    // The margin of `reach` + 1 empty cells keeps it inside the grid.
                    let neighbour = cell.wrapping_add_signed(offset);
                    let away = self.centre(neighbour).distance_squared(point) as f32;
                    if away < distances[neighbour] {
                        distances[neighbour] = away;
                        if self.nearest[neighbour] == NONE {
                            next.push(neighbour);
                        }
                        self.nearest[neighbour] = surfel;
                    }
                }
            }
            shell = next;
        }
    }

    /// A surfel near `p`, nearly the nearest; none where the surface is out of reach.
    pub fn near(&self, p: DVec3) -> Option<usize> {
        let surfel = self.nearest[self.cell_of(p)?];
        (surfel != NONE).then_some(surfel as usize)
    }

    fn cell_of(&self, p: DVec3) -> Option<usize> {
        let at = (p - self.low) / self.cell;
        let [nx, ny, nz] = self.counts;
        let inside = at.x >= 0.0
            && at.y >= 0.0
            && at.z >= 0.0
            && at.x < nx as f64
            && at.y < ny as f64
            && at.z < nz as f64;
        inside.then(|| at.x as usize + nx * (at.y as usize + ny * at.z as usize))
    }

    fn centre(&self, cell: usize) -> DVec3 {
        let [nx, ny, _] = self.counts;
        let at = DVec3::new(
            (cell % nx) as f64,
            (cell / nx % ny) as f64,
            (cell / nx / ny) as f64,
        );
        self.low + (at + 0.5) * self.cell
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Random;

    /// A square of a side of 100 mm, cut into 2 n^2 triangles, turned.
    fn square(n: u32, turn: glam::DQuat) -> (Vec<DVec3>, Vec<[u32; 3]>) {
        let at = |i: u32| f64::from(i) * 100.0 / f64::from(n) - 50.0;
        let positions = (0..(n + 1) * (n + 1))
            .map(|v| turn * DVec3::new(at(v % (n + 1)), at(v / (n + 1)), 0.0))
            .collect();
        let triangles = (0..n * n)
            .flat_map(|q| {
                let v = q / n * (n + 1) + q % n;
                [[v, v + 1, v + n + 2], [v, v + n + 2, v + n + 1]]
            })
            .collect();
        (positions, triangles)
    }

    #[test]
    fn surfels_lie_on_the_surface_however_it_is_cut() {
        let mut random = Random::new(1);
        for _ in 0..5 {
            let turn = glam::DQuat::from_euler(
                glam::EulerRot::XYZ,
                random.normal(),
                random.normal(),
                random.normal(),
            );
            for n in [1, 40] {
                let (positions, triangles) = square(n, turn);
                let surfels = Surfels::new(&positions, &triangles, 4.0, 2);
                for (p, normal) in surfels.points.iter().zip(&surfels.normals) {
                    // Sums of millimetres and of unit vectors, to rounding.
                    assert!((turn.inverse() * *p).z.abs() < 1e-9);
                    assert!(normal.distance(turn * DVec3::Z) < 1e-9);
                }
                // All of the area is there, in cells that a plane cannot cut more than 2.2 times
                // as large as their side, and hardly smaller than a third of it on average.
                let area: f64 = surfels.areas.iter().sum();
                assert!((area - 1e4).abs() < 1e-6, "{area}");
                let count = surfels.points.len() as f64;
                assert!(
                    (1e4 / 16.0 / 2.2..1e4 / 16.0 * 3.0).contains(&count),
                    "{count}"
                );
            }
        }
    }

    #[test]
    fn a_near_surfel_is_hardly_farther_than_the_nearest() {
        let mut random = Random::new(2);
        let (positions, triangles) = square(30, glam::DQuat::from_rotation_x(0.4));
        let surfels = Surfels::new(&positions, &triangles, 4.0, 5);
        for _ in 0..2000 {
            let p = DVec3::new(random.normal(), random.normal(), random.normal()) * 40.0;
            let nearest = surfels
                .points
                .iter()
                .map(|q| q.distance(p))
                .fold(f64::INFINITY, f64::min);
            match surfels.near(p) {
                // The centre of a cell stands for all of it, half a diagonal off at most, here and
                // in each of the shells between.
                Some(found) => assert!(surfels.points[found].distance(p) < nearest + 2.0 * 6.93),
                None => assert!(nearest > 4.0 * 4.0),
            }
        }
    }

    #[test]
    fn sheets_that_face_each_other_in_one_cell_face_nowhere() {
        let (mut positions, mut triangles) = square(10, glam::DQuat::IDENTITY);
        let n = positions.len() as u32;
        let other: Vec<DVec3> = positions.iter().map(|p| *p + DVec3::Z * 0.2).collect();
        positions.extend(other);
        let turned: Vec<[u32; 3]> = triangles
            .iter()
            .map(|t| [t[0] + n, t[2] + n, t[1] + n])
            .collect();
        triangles.extend(turned);
        assert!(
            Surfels::new(&positions, &triangles, 4.0, 1)
                .points
                .is_empty()
        );
    }
}
