//! Lips that went through each other are parted.
//!
//! The lips of a scan touch, and where its own surface goes through itself the sheet follows. What
//! crosses is moved apart along the face's vertical, upper lip up and lower lip down, until nothing
//! does; the parting fades out around it and towards the corners of the mouth, where both lips are
//! one.

use glam::DVec3;

use crate::fit::FitResult;
use crate::fit::head::folds::{Crossings, edge_neighbours};
use crate::fit::head::region::point;
use crate::fit::head::template::Template;
use crate::fit::mesh::geodesic::Geodesic;

/// How far a lip reaches from its inner edge along the surface, mm; beyond nothing is moved.
const REACH: f64 = 25.0;

/// Differences of the distances to the two lips' edges over which one becomes the other, mm.
const CORNER: f64 = 3.0;

/// How far crossing vertices are moved in a round, mm.
const STEP: f64 = 0.12;

/// What of a vertex's motion its neighbours take.
const SPREAD: f64 = 0.8;

/// How many neighbours away the motion is carried.
const RINGS: usize = 6;

/// Rounds at most: more than three millimetres are no lips any more.
const ROUNDS: usize = 24;

/// The lips of a template.
pub struct Lips {
    crossings: Crossings,
    /// Each vertex from -1, the lower lip, to 1, the upper; 0 away from both.
    side: Vec<f64>,
    neighbours: Vec<Vec<u32>>,
}

impl Lips {
    /// Prepares a template.
    ///
    /// # Errors
    /// When it lacks its parts or the landmarks of the mouth.
    pub fn new(template: &Template) -> FitResult<Self> {
        let crossings = Crossings::new(template)?;
        let n = template.positions.len();
        let mut triangles = template.part_triangles("skin")?;
        triangles.extend(template.part_triangles("mouth cavity")?);
        let graph = Geodesic::new(&template.positions, &triangles);
        let edge = |points: [u32; 3]| -> FitResult<Vec<f64>> {
            let mut sources = Vec::new();
            for p in points {
                let at = point(template, &format!("ibug_{p:02}"))?;
                let distance = |v: u32| template.positions[v as usize].distance_squared(at);
                let corners = triangles.as_flattened().iter().copied();
                sources.extend(corners.min_by(|&a, &b| distance(a).total_cmp(&distance(b))));
            }
            Ok(graph.distances(&sources, REACH + 10.0))
        };
        let (upper, lower) = (edge([61, 62, 63])?, edge([65, 66, 67])?);
        let side = (0..n)
            .map(|v| {
                let (up, down) = (upper[v], lower[v]);
                let nearest = up.min(down);
                if !(nearest < REACH) {
                    return 0.0;
                }
                let difference = (down.min(2.0 * REACH) - up.min(2.0 * REACH)) / CORNER;
                difference.clamp(-1.0, 1.0) * (1.0 - nearest / REACH)
            })
            .collect();
        Ok(Self {
            crossings,
            side,
            neighbours: edge_neighbours(n, &triangles),
        })
    }

    /// Parts the lips of a face in the template's frame (all vertices, mm).
    pub fn part(&self, face: &mut [DVec3]) {
        for _ in 0..ROUNDS {
            let pairs = self.crossings.of(face);
            if pairs.is_empty() {
                return;
            }
            let mut share = vec![0.0; face.len()];
            let mut front = Vec::new();
            for &t in pairs.as_flattened() {
                for v in self.crossings.triangles()[t as usize] {
                    if self.side[v as usize] != 0.0 && share[v as usize] == 0.0 {
                        share[v as usize] = 1.0;
                        front.push(v);
                    }
                }
            }
            for ring in 1..=RINGS {
                let strength = SPREAD.powi(ring as i32);
                let mut next = Vec::new();
                for &v in &front {
                    for &n in &self.neighbours[v as usize] {
                        if share[n as usize] == 0.0 {
                            share[n as usize] = strength;
                            next.push(n);
                        }
                    }
                }
                front = next;
            }
            for (v, p) in face.iter_mut().enumerate() {
                p.y += STEP * share[v] * self.side[v];
            }
        }
    }
}
