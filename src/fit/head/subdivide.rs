//! One step of Catmull-Clark subdivision as a linear operator.
//!
//! Catmull & Clark, "Recursively generated B-spline surfaces on arbitrary topological meshes",
//! 1978; at open boundaries the cubic B-spline rule of Hoppe et al., 1994, so that a boundary is
//! a curve of its own and does not depend on what lies inside.

use std::collections::HashMap;

use glam::DVec2;

use super::base_mesh::Quad;

/// Where a subdivided vertex comes from, in the coarse mesh's numbering.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Origin {
    /// A coarse vertex.
    Vertex(u32),
    /// A coarse edge, smaller vertex first.
    Edge(u32, u32),
    /// A coarse face, by its index in the input.
    Face(u32),
}

/// A subdivided mesh: four quads for each coarse one.
#[derive(Debug, Clone, Default)]
pub struct Subdivision {
    /// Each fine vertex as weights on coarse vertices; a row sums to 1.
    pub rows: Vec<Vec<(u32, f64)>>,
    /// What each fine vertex was made from.
    pub origins: Vec<Origin>,
    /// Fine quads; those of coarse quad `i` are `4 * i..4 * i + 4`.
    pub quads: Vec<[u32; 4]>,
    /// Texture coordinates of each fine quad's corners, as indices into `uvs`.
    pub uv_quads: Vec<[u32; 4]>,
    /// Texture coordinates, subdivided linearly so that charts keep their outline.
    pub uvs: Vec<DVec2>,
}

fn edge(a: u32, b: u32) -> (u32, u32) {
    (a.min(b), a.max(b))
}

/// Subdivides `quads` once.
///
/// The order of the fine vertices is: coarse vertices by number, edges by first use, faces.
pub fn catmull_clark(quads: &[Quad], uvs: &[DVec2]) -> Subdivision {
    let mut edge_faces: HashMap<(u32, u32), Vec<u32>> = HashMap::new();
    let mut edges = Vec::new();
    let mut vertices: Vec<u32> = quads.iter().flat_map(|q| q.vertices).collect();
    vertices.sort_unstable();
    vertices.dedup();
    let mut faces_of: HashMap<u32, Vec<u32>> = HashMap::new();
    let mut edges_of: HashMap<u32, Vec<(u32, u32)>> = HashMap::new();
    for (face, quad) in quads.iter().enumerate() {
        for corner in 0..4 {
            let (a, b) = (quad.vertices[corner], quad.vertices[(corner + 1) % 4]);
            let key = edge(a, b);
            let faces = edge_faces.entry(key).or_default();
            if faces.is_empty() {
                edges.push(key);
                edges_of.entry(a).or_default().push(key);
                edges_of.entry(b).or_default().push(key);
            }
            faces.push(face as u32);
            faces_of.entry(a).or_default().push(face as u32);
        }
    }

    let mut fine = Subdivision::default();
    let mut vertex_index = HashMap::new();
    let mut edge_index = HashMap::new();
    for &vertex in &vertices {
        let mut row = Row::default();
        let boundary: Vec<_> = edges_of[&vertex]
            .iter()
            .filter(|e| edge_faces[e].len() == 1)
            .collect();
        if boundary.is_empty() {
            // (F + 2 R + (n - 3) P) / n with F the mean of the face points and R of the edge
            // midpoints around P.
            let n = faces_of[&vertex].len() as f64;
            for &face in &faces_of[&vertex] {
                for corner in quads[face as usize].vertices {
                    row.add(corner, 0.25 / (n * n));
                }
            }
            for &(a, b) in &edges_of[&vertex] {
                row.add(a, 1.0 / (n * n));
                row.add(b, 1.0 / (n * n));
            }
            row.add(vertex, (n - 3.0) / n);
        } else {
            row.add(vertex, 0.75);
            let share = 0.25 / boundary.len() as f64;
            for &&(a, b) in &boundary {
                row.add(if a == vertex { b } else { a }, share);
            }
        }
        vertex_index.insert(vertex, fine.rows.len() as u32);
        fine.rows.push(row.weights());
        fine.origins.push(Origin::Vertex(vertex));
    }
    for &(a, b) in &edges {
        let mut row = Row::default();
        let faces = &edge_faces[&(a, b)];
        let own = if faces.len() == 1 { 0.5 } else { 0.25 };
        row.add(a, own);
        row.add(b, own);
        if faces.len() > 1 {
            let share = 0.5 / (4.0 * faces.len() as f64);
            for &face in faces {
                for corner in quads[face as usize].vertices {
                    row.add(corner, share);
                }
            }
        }
        edge_index.insert((a, b), fine.rows.len() as u32);
        fine.rows.push(row.weights());
        fine.origins.push(Origin::Edge(a, b));
    }

    let mut uv_index: HashMap<Origin, u32> = HashMap::new();
    for (face, quad) in quads.iter().enumerate() {
        let centre = fine.rows.len() as u32;
        fine.rows.push(quad.vertices.map(|v| (v, 0.25)).to_vec());
        fine.origins.push(Origin::Face(face as u32));
        let mut uv = |origin: Origin| {
            let at = |i: u32| uvs[i as usize];
            *uv_index.entry(origin).or_insert_with(|| {
                fine.uvs.push(match origin {
                    Origin::Vertex(a) => at(a),
                    Origin::Edge(a, b) => (at(a) + at(b)) / 2.0,
                    Origin::Face(_) => quad.uvs.iter().map(|&i| at(i)).sum::<DVec2>() / 4.0,
                });
                fine.uvs.len() as u32 - 1
            })
        };
        for corner in 0..4 {
            let (previous, next) = ((corner + 3) % 4, (corner + 1) % 4);
            let v = quad.vertices;
            let t = quad.uvs;
            fine.quads.push([
                vertex_index[&v[corner]],
                edge_index[&edge(v[corner], v[next])],
                centre,
                edge_index[&edge(v[previous], v[corner])],
            ]);
            let uv_edge = |a, b| {
                let (a, b) = edge(a, b);
                Origin::Edge(a, b)
            };
            fine.uv_quads.push([
                uv(Origin::Vertex(t[corner])),
                uv(uv_edge(t[corner], t[next])),
                uv(Origin::Face(face as u32)),
                uv(uv_edge(t[previous], t[corner])),
            ]);
        }
    }
    fine
}

/// A sparse row under construction.
#[derive(Default)]
struct Row(std::collections::BTreeMap<u32, f64>);

impl Row {
    fn add(&mut self, vertex: u32, weight: f64) {
        *self.0.entry(vertex).or_default() += weight;
    }

    fn weights(self) -> Vec<(u32, f64)> {
        self.0.into_iter().filter(|&(_, w)| w != 0.0).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    fn quads(faces: &[[u32; 4]]) -> Vec<Quad> {
        faces
            .iter()
            .map(|&f| Quad {
                vertices: f,
                uvs: f,
            })
            .collect()
    }

    const CUBE: [[u32; 4]; 6] = [
        [0, 2, 3, 1],
        [4, 5, 7, 6],
        [0, 1, 5, 4],
        [2, 6, 7, 3],
        [0, 4, 6, 2],
        [1, 3, 7, 5],
    ];

    #[test]
    fn a_cube_becomes_the_published_one() {
        let corner = |i: u32| {
            DVec3::new(f64::from(i & 1), f64::from(i >> 1 & 1), f64::from(i >> 2)) * 2.0 - 1.0
        };
        let base: Vec<DVec3> = (0..8).map(corner).collect();
        let fine = catmull_clark(&quads(&CUBE), &[DVec2::ZERO; 8]);
        assert_eq!((fine.rows.len(), fine.quads.len()), (8 + 12 + 6, 24));
        for (row, origin) in fine.rows.iter().zip(&fine.origins) {
            let p: DVec3 = row.iter().map(|&(v, w)| base[v as usize] * w).sum();
            // A cube of half side 1: corner 5/9, edge point 3/4, face point 1 along their axes.
            let expected = match *origin {
                Origin::Vertex(v) => base[v as usize] * (5.0 / 9.0),
                Origin::Edge(a, b) => (base[a as usize] + base[b as usize]) / 2.0 * 0.75,
                Origin::Face(f) => {
                    CUBE[f as usize]
                        .iter()
                        .map(|&v| base[v as usize])
                        .sum::<DVec3>()
                        / 4.0
                }
            };
            assert!(
                p.distance(expected) < 1e-12,
                "{origin:?}: {p} is not {expected}"
            );
        }
    }

    #[test]
    fn a_boundary_depends_on_the_boundary_alone() {
        // 0-1-2 is the boundary of two quads over 3-4-5.
        let fine = catmull_clark(&quads(&[[0, 1, 4, 3], [1, 2, 5, 4]]), &[DVec2::ZERO; 6]);
        let row = |origin| {
            let at = fine.origins.iter().position(|o| *o == origin).unwrap();
            fine.rows[at].clone()
        };
        assert_eq!(row(Origin::Vertex(1)), [(0, 0.125), (1, 0.75), (2, 0.125)]);
        assert_eq!(row(Origin::Edge(0, 1)), [(0, 0.5), (1, 0.5)]);
        for row in &fine.rows {
            assert!((row.iter().map(|r| r.1).sum::<f64>() - 1.0).abs() < 1e-12);
        }
    }
}
