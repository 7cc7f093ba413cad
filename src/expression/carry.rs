//! How displacements of the mean head are turned and stretched on another face.
//!
//! Around *nodes* some millimetres apart the linear map from the mean to the face is found by
//! moving least squares (Schaefer et al. 2006, eq. 5), held to the scale of the whole head where
//! the surface is flat and says nothing of what is across it. It is linear in the face's vertices,
//! with weights that depend on the mean only, so a face costs a sum a node. A vertex takes the
//! maps of the nodes around it.
//!
//! There are two scales of this. What moves a vertex by a few millimetres, as a lid, follows the
//! shape of the lid; what moves it by centimetres, as a jaw, follows that of the jaw and not the
//! curls of a lip, which would be made larger with it.

use glam::{DMat3, DVec3, Mat3, Mat3A, Vec3, Vec3A};

use crate::model::FaceModel;

/// How far around a vertex the face is asked, mm: for small displacements and for large ones. An
/// open eye is 10 mm high, a mouth 50 wide.
pub const REACHES: [f32; 2] = [12.0, 36.0];
/// How far apart nodes are at least, as a part of their reach.
const SPACING: f32 = 0.5;
/// A node asks about so many of them.
const ASKED: usize = 48;
/// The part of the squared extent of a neighbourhood by which its map is held to a scale.
const HELD: f64 = 0.05;
/// The nodes whose maps a vertex takes.
const NEAR: usize = 4;

#[derive(Debug)]
struct Node {
    /// Vertices and what each adds to the map: its position on the face times this, transposed.
    pulls: Vec<(u32, Vec3)>,
    /// What the scale adds.
    held: Mat3,
}

/// What carries displacements to faces.
#[derive(Debug)]
pub struct Carrier {
    nodes: Vec<Node>,
    /// The nodes around each vertex that any expression moves, with weights that sum to 1.
    around: Vec<[(u32, f32); NEAR]>,
    /// Some vertices of the skin, with their places on the mean about their middle.
    scale: Vec<(u32, Vec3)>,
}

impl Carrier {
    /// For the vertices `moved` (increasing), with maps of a reach (mm).
    // Not inlined, as what only reading needs: the module is downloaded before it runs.
    #[inline(never)]
    pub fn new(model: &FaceModel, moved: &[u32], reach: f32) -> Self {
        let mean = &model.parts().mean;
        let skin = model.parts().topology.part_vertices("skin");
        let mut centres: Vec<Vec3> = Vec::new();
        for &v in skin.iter().filter(|v| moved.binary_search(v).is_ok()) {
            let p = mean[v as usize];
            let far = |c: &Vec3| c.distance(p) > SPACING * reach;
            if centres.iter().all(far) {
                centres.push(p);
            }
        }
        if centres.is_empty() {
            centres.push(Vec3::ZERO);
        }
        let nodes = centres
            .iter()
            .map(|&c| Node::new(c, reach, mean, &skin))
            .collect();
        let around = moved
            .iter()
            .map(|&v| nearest(mean[v as usize], &centres))
            .collect();
        let some: Vec<u32> = skin.iter().copied().step_by(16).collect();
        let middle =
            some.iter().map(|&v| mean[v as usize]).sum::<Vec3>() / some.len().max(1) as f32;
        Self {
            nodes,
            around,
            scale: some
                .iter()
                .map(|&v| (v, mean[v as usize] - middle))
                .collect(),
        }
    }

    /// The linear map at each node, on a face.
    #[inline(never)]
    pub fn at_nodes(&self, face: &[Vec3]) -> Vec<Mat3A> {
        // The face is in the pose of the mean, so what is left of a similarity is its scale.
        let (mut along, mut square) = (0.0, 0.0);
        for &(v, p) in &self.scale {
            along += face[v as usize].dot(p);
            square += p.length_squared();
        }
        let scale = if square > 0.0 { along / square } else { 1.0 };
        let of = |node: &Node| {
            let mut map = Mat3A::from(node.held) * scale;
            for &(v, pull) in &node.pulls {
                let p = Vec3A::from(face[v as usize]);
                map.x_axis += p * pull.x;
                map.y_axis += p * pull.y;
                map.z_axis += p * pull.z;
            }
            map
        };
        self.nodes.iter().map(of).collect()
    }

    /// A displacement of the mean head at the vertex `moved[place]`, on the face of the maps at nodes.
    #[inline(never)]
    pub fn carry(&self, at_nodes: &[Mat3A], place: usize, displacement: Vec3A) -> Vec3A {
        let mut carried = Vec3A::ZERO;
        for &(node, weight) in &self.around[place] {
            carried += at_nodes[node as usize] * (displacement * weight);
        }
        carried
    }
}

impl Node {
    fn new(centre: Vec3, reach: f32, mean: &[Vec3], skin: &[u32]) -> Self {
        let near: Vec<u32> = (skin.iter().copied())
            // Most are too high or too low, which costs less to tell.
            .filter(|&v| (mean[v as usize].y - centre.y).abs() < reach)
            .filter(|&v| mean[v as usize].distance(centre) < reach)
            .collect();
        let every = near.len().div_ceil(ASKED).max(1);
        let asked: Vec<(u32, DVec3, f64)> = near
            .iter()
            .step_by(every)
            .map(|&v| {
                let t = f64::from(mean[v as usize].distance(centre) / reach);
                (v, mean[v as usize].as_dvec3(), (1.0 - t * t).powi(2))
            })
            .collect();
        let total: f64 = asked.iter().map(|a| a.2).sum();
        if total <= 0.0 {
            return Self {
                pulls: Vec::new(),
                held: Mat3::IDENTITY,
            };
        }
        let middle = asked.iter().map(|&(_, p, w)| p * w).sum::<DVec3>() / total;
        let mut square = DMat3::ZERO;
        for &(_, p, w) in &asked {
            let d = p - middle;
            for axis in 0..3 {
                *square.col_mut(axis) += d * (d[axis] * w);
            }
        }
        let trace = square.x_axis.x + square.y_axis.y + square.z_axis.z;
        let held = HELD * (trace + total);
        // Positive definite, so there is an inverse; it is symmetric.
        let inverse = (square + DMat3::IDENTITY * held).inverse();
        Self {
            pulls: asked
                .iter()
                .map(|&(v, p, w)| (v, (inverse * ((p - middle) * w)).as_vec3()))
                .collect(),
            held: (inverse * held).as_mat3(),
        }
    }
}

/// How much of a displacement is carried at the larger of [`REACHES`], for an expression whose
/// largest displacement is given, mm.
pub fn large_part(largest: f32) -> f32 {
    let [small, large] = REACHES;
    let t = ((largest - small) / (large - small)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// The nearest centres to a point, with weights that fade to nothing where another takes over.
fn nearest(p: Vec3, centres: &[Vec3]) -> [(u32, f32); NEAR] {
    let mut best = [(f32::INFINITY, 0_u32); NEAR + 1];
    for (centre, i) in centres.iter().zip(0..) {
        let distance = centre.distance_squared(p);
        if distance < best[NEAR].0 {
            best[NEAR] = (distance, i);
            for at in (1..=NEAR).rev() {
                if best[at].0 < best[at - 1].0 {
                    best.swap(at, at - 1);
                }
            }
        }
    }
    let end = best[NEAR].0.min(1e12).sqrt();
    let weight = |d: f32| (1.0 - d.min(1e12).sqrt() / end.max(1e-6)).max(0.0).powi(2);
    let total: f32 = best[..NEAR].iter().map(|b| weight(b.0)).sum();
    let mut rows = [(0, 0.0); NEAR];
    for (row, &(distance, i)) in rows.iter_mut().zip(&best) {
        *row = (i, weight(distance) / total.max(1e-12));
    }
    if total <= 0.0 {
        rows[0] = (best[0].1, 1.0);
    }
    rows
}
