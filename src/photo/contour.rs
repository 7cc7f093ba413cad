//! The jaw's points, which are where the outline of the face is seen, not where the jaw is.
//!
//! Of a head that is turned, the far half of the jaw is hidden, and those who mark it (people and
//! detectors) mark the cheek's outline instead. So each of the 17 points has a *path* on the mean
//! head from the jaw towards the nose, across the jaw line, and stands for whichever point of the
//! path is seen farthest out: landmark marching (Zhu et al. 2015, "High-fidelity pose and expression
//! normalization", section 3.1). Along the outline a point says little: detectors slide
//! there.

use std::collections::BTreeMap;

use glam::{DVec2, DVec3};

use super::shape::Stencil;
use crate::model::FaceModel;

/// The jaw's points are the first of the 68, from the subject's right ear over the chin to the left.
pub(super) const JAW: usize = 17;
/// The tip of the nose among the 68.
pub(super) const NOSE: usize = 30;
/// A path ends at this part of the way to the tip of the nose: beyond the cheek's outline of a head
/// that is turned 60 degrees, before the nose's.
const REACH: f64 = 0.6;
/// Points of a path are this far apart, mm. What lies between two of them on a cheek, whose radius
/// is some 50 mm, is 0.02 mm farther out.
const SPACING: f64 = 3.0;

/// The path of each jaw point: stencils, of which the first is the point itself.
pub(super) fn paths(model: &FaceModel, points: &[Stencil]) -> Vec<Vec<Stencil>> {
    let parts = model.parts();
    let mean: Vec<DVec3> = parts.mean.iter().map(|p| p.as_dvec3()).collect();
    let place = |stencil: &Stencil| -> DVec3 {
        let corners = stencil.iter();
        corners.map(|&(v, w)| mean[v as usize] * w).sum()
    };
    let jaw: Vec<DVec3> = points[..JAW].iter().map(place).collect();
    let nose = place(&points[NOSE]);
    let all = parts.topology.triangles();
    let skin = parts.topology.parts.iter().filter(|p| p.name == "skin");
    let skin: Vec<[u32; 3]> = skin
        .flat_map(|p| &all[p.first as usize..(p.first + p.count) as usize])
        .copied()
        .collect();
    (0..JAW)
        .map(|i| {
            let along = jaw[(i + 1).min(JAW - 1)] - jaw[i.saturating_sub(1)];
            let slice = Slice::new(&mean, &skin, jaw[i], along);
            let mut path = vec![points[i].clone()];
            path.extend(slice.walk(jaw[i], nose));
            path
        })
        .collect()
}

/// Where a plane cuts the skin: a graph of the edges that it crosses.
struct Slice {
    /// Where each crossed edge is crossed.
    crossings: BTreeMap<[u32; 2], (Stencil, DVec3)>,
    /// The edges that share a triangle with each.
    beside: BTreeMap<[u32; 2], Vec<[u32; 2]>>,
}

impl Slice {
    fn new(mean: &[DVec3], skin: &[[u32; 3]], through: DVec3, normal: DVec3) -> Self {
        let normal = normal.normalize_or_zero();
        let height = |v: u32| (mean[v as usize] - through).dot(normal);
        let mut slice = Self {
            crossings: BTreeMap::new(),
            beside: BTreeMap::new(),
        };
        for &[a, b, c] in skin {
            let edges = [[a, b], [b, c], [c, a]].map(|[a, b]| [a.min(b), a.max(b)]);
            let crossed: Vec<[u32; 2]> = (edges.into_iter())
                .filter(|e| (height(e[0]) < 0.0) != (height(e[1]) < 0.0))
                .collect();
            let [one, other] = crossed[..] else { continue };
            for edge in [one, other] {
                let (from, to) = (height(edge[0]), height(edge[1]));
                let t = from / (from - to);
                let at = mean[edge[0] as usize].lerp(mean[edge[1] as usize], t);
                let stencil = vec![(edge[0], 1.0 - t), (edge[1], t)];
                slice.crossings.insert(edge, (stencil, at));
            }
            slice.beside.entry(one).or_default().push(other);
            slice.beside.entry(other).or_default().push(one);
        }
        slice
    }

    /// The points along the slice from the one nearest `start` in the direction of `end`.
    fn walk(&self, start: DVec3, end: DVec3) -> Vec<Stencil> {
        let distance = |edge: &[u32; 2]| self.crossings[edge].1.distance(start);
        let nearest = self
            .crossings
            .keys()
            .min_by(|a, b| distance(a).total_cmp(&distance(b)));
        let Some(&nearest) = nearest else {
            return Vec::new();
        };
        let reach = REACH * start.distance(end);
        let ahead = (end - start).normalize_or_zero();
        let mut path = Vec::new();
        let mut last = start;
        let mut edge = nearest;
        let mut came_from = None;
        // A slice has fewer edges than this, unless it goes round for ever.
        for _ in 0..self.crossings.len() {
            let (stencil, at) = &self.crossings[&edge];
            if at.distance(start) > reach {
                break;
            }
            if at.distance(last) >= SPACING {
                path.push(stencil.clone());
                last = *at;
            }
            let ways = self.beside[&edge].iter().filter(|e| Some(**e) != came_from);
            let forward = |e: &[u32; 2]| (self.crossings[e].1 - at).dot(ahead);
            let next = match came_from {
                // The first step chooses the direction.
                None => ways.max_by(|a, b| forward(a).total_cmp(&forward(b))),
                Some(_) => ways.min(),
            };
            let Some(&next) = next else { break };
            came_from = Some(edge);
            edge = next;
        }
        path
    }
}

/// Which point of its path each jaw point stands for, from where the paths are seen (px; a path a
/// jaw point), and the outline's direction there, a unit vector.
pub(super) fn outline(paths: &[Vec<DVec2>], nose: DVec2) -> Vec<(usize, DVec2)> {
    let direction = |at: &dyn Fn(usize) -> DVec2, i: usize| {
        (at((i + 1).min(JAW - 1)) - at(i.saturating_sub(1))).normalize_or_zero()
    };
    let jaw = |i: usize| paths[i][0];
    let chosen: Vec<usize> = (0..JAW)
        .map(|i| {
            let along = direction(&jaw, i);
            let out = along.perp();
            let out = out * out.dot(jaw(i) - nose).signum();
            let mut best = (0, 0.0);
            for (k, q) in paths[i].iter().enumerate() {
                let farther = out.dot(*q - paths[i][0]);
                if farther > best.1 {
                    best = (k, farther);
                }
            }
            best.0
        })
        .collect();
    let seen = |i: usize| paths[i][chosen[i]];
    (0..JAW).map(|i| (chosen[i], direction(&seen, i))).collect()
}
