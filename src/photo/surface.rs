//! Where the skin of a face is compared with a photo.

use glam::{DVec3, Vec3};

use crate::expression::Expression;
use crate::model::FaceModel;
use super::knob;

/// Samples of the skin, and the vertices that their normals take.
#[derive(Debug, Clone)]
pub(super) struct Surface {
    /// Model's vertices: the samples and their neighbours, increasing.
    pub vertices: Vec<u32>,
    /// Where they are on the mean head, mm.
    mean: Vec<DVec3>,
    /// How they move with each coefficient of the population, mm: all of a vertex together.
    rates: Vec<Vec3>,
    population: usize,
    pub samples: Vec<Sample>,
}

/// A vertex of the skin and its neighbours, as places among the surface's vertices.
#[derive(Debug, Clone)]
pub(super) struct Sample {
    pub own: usize,
    /// Counter-clockwise from outside.
    pub ring: Vec<usize>,
}

impl Surface {
    pub fn new(model: &FaceModel) -> Self {
        let parts = model.parts();
        let colours = &parts.topology.colours;
        let mean: Vec<DVec3> = parts.mean.iter().map(|p| p.as_dvec3()).collect();
        let bare = super::light::bare(model);
        // Plain skin
        let luma = |v: u32| {
            let c = super::light::linear(colours[v as usize]);
            0.2126 * c.x + 0.7152 * c.y + 0.0722 * c.z
        };
        let mut sorted: Vec<f64> = bare.iter().map(|&v| luma(v)).collect();
        sorted.sort_unstable_by(f64::total_cmp);
        let usual = sorted[sorted.len() / 2];
        let (plain, other): (Vec<u32>, Vec<u32>) =
            bare.iter().partition(|&&v| (luma(v) / usual - 1.0).abs() < 0.22);
        let apart = knob("APART", 2.5);
        let grid = |p: DVec3| (p / apart).floor().as_ivec3().to_array();
        let mut cells: std::collections::BTreeMap<[i32; 3], Vec<u32>> = Default::default();
        for &v in &other {
            cells.entry(grid(mean[v as usize])).or_default().push(v);
        }
        let near_other = |v: u32| {
            let p = mean[v as usize];
            let [x, y, z] = grid(p);
            (-1..=1).any(|i| (-1..=1).any(|j| (-1..=1).any(|k| {
                cells.get(&[x + i, y + j, z + k]).is_some_and(|c| c.iter().any(|&o| mean[o as usize].distance(p) < apart))
            })))
        };
        let fans = fans(model);
        let mut candidates: Vec<u32> = plain.into_iter().filter(|&v| !near_other(v) && !fans[v as usize].is_empty()).collect();
        let _ = &mut candidates;
        let chosen = spread(&candidates, &mean, knob("SAMPLES", 1200.0) as usize);
        let mut vertices: Vec<u32> = chosen.iter().flat_map(|&v| fans[v as usize].iter().copied().chain([v])).collect();
        vertices.sort_unstable();
        vertices.dedup();
        let place = |v: u32| vertices.binary_search(&v).unwrap_or_default();
        let samples = chosen.iter().map(|&v| Sample { own: place(v), ring: fans[v as usize].iter().map(|&r| place(r)).collect() }).collect();
        let face = model.face();
        let population = parts.population();
        let mut rates = Vec::with_capacity(population * vertices.len());
        for &v in &vertices {
            rates.extend_from_slice(&face.jacobian(v)[..population]);
        }
        Self { mean: vertices.iter().map(|&v| mean[v as usize]).collect(), vertices, rates, population, samples }
    }

    pub fn rates(&self, place: usize) -> &[Vec3] {
        &self.rates[place * self.population..(place + 1) * self.population]
    }

    /// Positions for coefficients of the population and weights of expressions.
    pub fn positions(&self, coefficients: &[f64], expressions: &[(&Expression, f64)]) -> Vec<DVec3> {
        let mut all: Vec<DVec3> = (0..self.vertices.len()).map(|i| {
            let moved: DVec3 = self.rates(i).iter().zip(coefficients).map(|(r, &c)| r.as_dvec3() * c).sum();
            self.mean[i] + moved
        }).collect();
        for (expression, weight) in expressions {
            for (p, v) in all.iter_mut().zip(&self.vertices) {
                if let Ok(slot) = expression.support.binary_search(v) {
                    *p += expression.displacements[slot].as_dvec3() * *weight;
                }
            }
        }
        all
    }

    /// Where the samples are on the mean head.
    pub fn places(&self) -> Vec<DVec3> {
        self.samples.iter().map(|s| self.mean[s.own]).collect()
    }
}

/// Around each vertex of the skin its neighbours in order; none where the skin ends.
fn fans(model: &FaceModel) -> Vec<Vec<u32>> {
    let topology = &model.parts().topology;
    let all = topology.triangles();
    let mut next: Vec<Vec<[u32; 2]>> = vec![Vec::new(); model.parts().mean.len()];
    for part in topology.parts.iter().filter(|p| p.name == "skin") {
        for &[a, b, c] in &all[part.first as usize..(part.first + part.count) as usize] {
            next[a as usize].push([b, c]);
            next[b as usize].push([c, a]);
            next[c as usize].push([a, b]);
        }
    }
    next.into_iter().map(|edges| {
        let Some(&[first, _]) = edges.first() else { return Vec::new() };
        let mut fan = vec![first];
        loop {
            let last = fan[fan.len() - 1];
            let Some(&[_, on]) = edges.iter().find(|e| e[0] == last) else { return Vec::new() };
            if on == first { break; }
            if fan.len() > edges.len() { return Vec::new(); }
            fan.push(on);
        }
        if fan.len() == edges.len() { fan } else { Vec::new() }
    }).collect()
}

/// As many of the vertices, each as far from those before it as there is one (Gonzalez 1985).
fn spread(vertices: &[u32], mean: &[DVec3], count: usize) -> Vec<u32> {
    let mut distance = vec![f64::INFINITY; vertices.len()];
    let mut chosen = Vec::new();
    let mut last = 0;
    while chosen.len() < count.min(vertices.len()) {
        let at = mean[vertices[last] as usize];
        chosen.push(vertices[last]);
        let mut farthest = (0, 0.0);
        for (i, (&v, d)) in vertices.iter().zip(&mut distance).enumerate() {
            *d = d.min(mean[v as usize].distance_squared(at));
            if *d > farthest.1 { farthest = (i, *d); }
        }
        last = farthest.0;
    }
    chosen
}
