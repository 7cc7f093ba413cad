//! Eyeballs of the generic head.
//!
//! The base mesh only has two coarse helper spheres, too coarse for a crisp iris. An eyeball here
//! is a finer sphere with rings around its forward axis, tied to the helper by an affine map: the
//! least-squares affine map of the helper's vertices is linear in them, so each eyeball vertex is
//! a fixed sum of helper vertices, and targets and gaze expressions carry over.

use glam::{DMat3, DVec2, DVec3};

use super::base_mesh::BaseMesh;
use crate::fit::{FitError, FitResult};

/// Vertices a ring.
const SEGMENTS: usize = 48;

/// Angles of the rings from the forward axis, in degrees: close together where the colour changes
/// (pupil, iris, limbus).
const RINGS: [f64; 19] = [
    4.0, 8.0, 9.6, 11.5, 14.0, 17.0, 20.0, 23.0, 25.2, 27.0, 29.0, 33.0, 39.0, 47.0, 57.0, 70.0,
    90.0, 115.0, 145.0,
];

/// The eyeball's radius relative to the helper's control cage; chosen so that the lids of the rest
/// pose rest on it.
const RADIUS: f64 = 0.955;

/// How far the eyeball lies below the helper's centre (mm), so that the lids of the rest pose, which
/// open a little below it, look straight ahead.
const DROP: f64 = 0.8;

/// Half-width of the square of texture space an eye takes, around the middle of the helper's own.
const UV_RADIUS: f64 = 0.0125;

/// A sphere tied to the helper vertices of an eye.
#[derive(Debug, Clone)]
pub struct Eyeball {
    /// Its centre in the rest pose, mm, in the base mesh's frame.
    pub centre: DVec3,
    /// Its radius in the rest pose, mm.
    pub radius: f64,
    /// Each vertex as weights on base vertices; a row sums to 1.
    pub rows: Vec<Vec<(u32, f64)>>,
    /// Angle of each vertex from the forward axis, radians.
    pub angles: Vec<f64>,
    /// Triangles, counter-clockwise seen from outside.
    pub triangles: Vec<[u32; 3]>,
    /// Texture coordinates.
    pub uvs: Vec<DVec2>,
    /// Triangles as indices into `uvs`.
    pub uv_triangles: Vec<[u32; 3]>,
}

impl Eyeball {
    /// Builds the eyeball of a helper group from the base mesh in its rest pose.
    pub fn new(base: &BaseMesh, rest: &[DVec3], group: &str) -> FitResult<Eyeball> {
        let quads = base.group(group)?;
        let mut helper: Vec<u32> = quads.iter().flat_map(|q| q.vertices).collect();
        helper.sort_unstable();
        helper.dedup();
        let at: Vec<DVec3> = helper.iter().map(|&v| rest[v as usize]).collect();
        let count = at.len() as f64;
        let mean = at.iter().sum::<DVec3>() / count;
        let radius = RADIUS * at.iter().map(|p| p.distance(mean)).sum::<f64>() / count;
        let moment = at.iter().fold(DMat3::ZERO, |sum, p| {
            let d = *p - mean;
            sum + DMat3::from_cols(d * d.x, d * d.y, d * d.z)
        });
        if moment.determinant().abs() < 1e-6 {
            return Err(FitError::Input(format!("{group} of the base mesh is flat")));
        }
        let inverse = moment.inverse();
        let centre = mean - DVec3::Y * DROP;
        let (directions, triangles) = sphere();
        let rows = directions
            .iter()
            .map(|&d| {
                let share = inverse * (centre + d * radius - mean);
                helper
                    .iter()
                    .zip(&at)
                    .map(|(&v, &p)| (v, 1.0 / count + (p - mean).dot(share)))
                    .collect()
            })
            .collect();

        let mut low = DVec2::INFINITY;
        let mut high = DVec2::NEG_INFINITY;
        for uv in quads.iter().flat_map(|q| q.uvs) {
            low = low.min(base.uvs[uv as usize]);
            high = high.max(base.uvs[uv as usize]);
        }
        let (uvs, uv_triangles) = unwrap(&directions, &triangles, (low + high) / 2.0);
        Ok(Eyeball {
            centre,
            radius,
            rows,
            angles: directions
                .iter()
                .map(|d| d.z.clamp(-1.0, 1.0).acos())
                .collect(),
            triangles,
            uvs,
            uv_triangles,
        })
    }

    /// The other eye: the same rows on the mirrored vertices.
    pub fn mirrored(&self, base: &BaseMesh) -> Eyeball {
        let turn = |t: &[u32; 3]| [t[0], t[2], t[1]];
        let mut other = self.clone();
        other.centre.x = -other.centre.x;
        for row in &mut other.rows {
            for (vertex, _) in row.iter_mut() {
                *vertex = base.mirror[*vertex as usize];
            }
        }
        other.triangles = self.triangles.iter().map(turn).collect();
        other.uv_triangles = self.uv_triangles.iter().map(turn).collect();
        // The helper squares of the two eyes lie side by side in texture space.
        let shift = 2.0 * UV_RADIUS + 0.003;
        for uv in &mut other.uvs {
            uv.x += shift;
        }
        other
    }
}

/// Unit directions (+z forward) and triangles: pole, rings, pole.
fn sphere() -> (Vec<DVec3>, Vec<[u32; 3]>) {
    let mut directions = vec![DVec3::Z];
    for ring in RINGS {
        let (sin, cos) = ring.to_radians().sin_cos();
        for segment in 0..SEGMENTS {
            let around = std::f64::consts::TAU * segment as f64 / SEGMENTS as f64;
            directions.push(DVec3::new(sin * around.cos(), sin * around.sin(), cos));
        }
    }
    directions.push(-DVec3::Z);
    let last = directions.len() as u32 - 1;
    let at = |ring: usize, segment: usize| (1 + ring * SEGMENTS + segment % SEGMENTS) as u32;
    let mut triangles = Vec::new();
    for segment in 0..SEGMENTS {
        triangles.push([0, at(0, segment), at(0, segment + 1)]);
        for ring in 0..RINGS.len() - 1 {
            let (a, b) = (at(ring, segment), at(ring, segment + 1));
            let (c, d) = (at(ring + 1, segment), at(ring + 1, segment + 1));
            triangles.push([a, c, d]);
            triangles.push([a, d, b]);
        }
        triangles.push([
            at(RINGS.len() - 1, segment),
            last,
            at(RINGS.len() - 1, segment + 1),
        ]);
    }
    (directions, triangles)
}

/// Azimuthal equidistant texture coordinates around `middle`; the back pole, which is a circle
/// there, has one for each of its triangles.
fn unwrap(
    directions: &[DVec3],
    triangles: &[[u32; 3]],
    middle: DVec2,
) -> (Vec<DVec2>, Vec<[u32; 3]>) {
    let back = directions.len() as u32 - 1;
    let mut uvs: Vec<DVec2> = directions[..back as usize]
        .iter()
        .map(|d| {
            let out = d.z.clamp(-1.0, 1.0).acos() / std::f64::consts::PI;
            let side = DVec2::new(d.x, d.y).normalize_or_zero();
            middle + side * out * UV_RADIUS
        })
        .collect();
    let mut uv_triangles = Vec::new();
    for t in triangles {
        let mut corners = *t;
        if let Some(at) = t.iter().position(|&v| v == back) {
            let (a, b) = (t[(at + 1) % 3], t[(at + 2) % 3]);
            let side = (uvs[a as usize] + uvs[b as usize]) / 2.0 - middle;
            corners[at] = uvs.len() as u32;
            uvs.push(middle + side.normalize_or_zero() * UV_RADIUS);
        }
        uv_triangles.push(corners);
    }
    (uvs, uv_triangles)
}
