//! Where the skin of a face is compared with a photo.

use std::collections::BTreeMap;

use glam::{DVec3, Vec3};

use super::albedo::Albedo;
use super::light::bare;
use crate::expression::Expression;
use crate::model::FaceModel;
use crate::srgb::{BRIGHTNESS, linear};

/// The levels of comparison, from coarse to fine: into how many patches the face is divided, and how
/// many modes its albedo has. At the last a patch is 5 mm wide, the albedo is told to some 30 mm.
const LEVELS: [(usize, usize); 3] = [(300, 60), (700, 100), (1500, 150)];
/// Skin whose colour on the mean head is farther off the usual than this part of its brightness is
/// lips, brows, lashes or nostrils, whose albedo is another.
const PLAIN: f64 = 0.22;
/// So near to those, mm, nothing is compared: photos blur, and fits are off.
const APART: f64 = 2.5;

/// The samples of the skin, and the vertices that their normals take.
#[derive(Debug, Clone)]
pub(super) struct Surface {
    /// The model's vertices: samples and their neighbours, increasing.
    pub vertices: Vec<u32>,
    /// Where they are on the mean head, mm.
    mean: Vec<DVec3>,
    /// How they move with each coefficient of the population, mm; all of a vertex together.
    rates: Vec<Vec3>,
    /// How many of them a vertex has.
    population: usize,
    pub samples: Vec<Sample>,
    /// From coarse to fine.
    pub levels: Vec<Level>,
}

/// A vertex of the skin.
#[derive(Debug, Clone)]
pub(super) struct Sample {
    /// Its place among the surface's vertices.
    pub own: usize,
    /// Its neighbours', counter-clockwise from outside.
    pub ring: Vec<usize>,
    /// How much of the mean head's skin is its own, mm^2.
    pub area: f64,
}

/// Samples in patches.
#[derive(Debug, Clone)]
pub(super) struct Level {
    /// The patch of each sample: that of the nearest middle.
    pub patch: Vec<usize>,
    /// At the middles of the patches.
    pub albedo: Albedo,
}

impl Surface {
    pub fn new(model: &FaceModel) -> Self {
        let parts = model.parts();
        let mean: Vec<DVec3> = parts.mean.iter().map(|p| p.as_dvec3()).collect();
        let fans = fans(model);
        let mut chosen = plain(model, &mean);
        chosen.retain(|&v| !fans[v as usize].is_empty());
        let fans: Vec<&[u32]> = chosen.iter().map(|&v| &fans[v as usize][..]).collect();
        let mut vertices: Vec<u32> = fans.concat();
        vertices.extend(&chosen);
        vertices.sort_unstable();
        vertices.dedup();
        // All are there.
        let place = |v: u32| vertices.binary_search(&v).unwrap_or_default();
        let at = |v: u32| mean[v as usize];
        let each = chosen.iter().zip(&fans);
        let samples: Vec<Sample> = each
            .map(|(&v, fan)| Sample {
                own: place(v),
                ring: fan.iter().map(|&r| place(r)).collect(),
                area: around(fan.len())
                    .map(|[i, j]| (at(fan[i]) - at(v)).cross(at(fan[j]) - at(v)).length() / 6.0)
                    .sum(),
            })
            .collect();
        let points: Vec<DVec3> = chosen.iter().map(|&v| at(v)).collect();
        let levels = levels(&points);
        let face = model.face();
        let population = parts.population();
        let rates = vertices.iter();
        let rates = rates.flat_map(|&v| face.jacobian(v).into_iter().take(population));
        Self {
            rates: rates.collect(),
            mean: vertices.iter().map(|&v| at(v)).collect(),
            vertices,
            population,
            samples,
            levels,
        }
    }

    /// The model's vertex that a sample is.
    pub fn vertex(&self, sample: usize) -> usize {
        self.vertices[self.samples[sample].own] as usize
    }

    /// How a vertex moves with each coefficient of the population, mm.
    pub fn rates(&self, place: usize) -> &[Vec3] {
        &self.rates[place * self.population..(place + 1) * self.population]
    }

    /// How a vertex moves with an expression at full weight, mm.
    pub fn expressed(&self, place: usize, expression: &Expression) -> DVec3 {
        let slot = expression.support.binary_search(&self.vertices[place]);
        slot.map_or(DVec3::ZERO, |slot| {
            expression.displacements[slot].as_dvec3()
        })
    }

    /// Where the vertices are for coefficients of the population and weights of expressions, mm.
    pub fn positions(
        &self,
        coefficients: &[f64],
        expressions: &[(&Expression, f64)],
    ) -> Vec<DVec3> {
        let mut positions = self.motion(coefficients, expressions);
        for (p, &mean) in positions.iter_mut().zip(&self.mean) {
            *p += mean;
        }
        positions
    }

    /// By how much these move the vertices, mm.
    pub fn motion(&self, coefficients: &[f64], expressions: &[(&Expression, f64)]) -> Vec<DVec3> {
        let each = (0..self.mean.len()).map(|i| {
            let moved = self.rates(i).iter().zip(coefficients);
            let moved: DVec3 = moved.map(|(r, &c)| r.as_dvec3() * c).sum();
            let expressed = expressions.iter();
            let expressed: DVec3 = expressed.map(|(e, w)| self.expressed(i, e) * *w).sum();
            moved + expressed
        });
        each.collect()
    }

    /// The sum of the facets around a sample, twice their area long.
    pub fn facets(&self, sample: &Sample, positions: &[DVec3]) -> DVec3 {
        let from = positions[sample.own];
        let corner = |i: usize| positions[sample.ring[i]] - from;
        let facets = around(sample.ring.len()).map(|[i, j]| corner(i).cross(corner(j)));
        facets.sum()
    }
}

/// Each place of a ring and the next.
fn around(count: usize) -> impl Iterator<Item = [usize; 2]> {
    (0..count).map(move |i| [i, (i + 1) % count])
}

/// The vertices of plain skin on the mean head, away from what is none.
fn plain(model: &FaceModel, mean: &[DVec3]) -> Vec<u32> {
    let colours = &model.parts().topology.colours;
    let skin = bare(model);
    let brightness = |v: u32| linear(colours[v as usize]).dot(BRIGHTNESS);
    let mut sorted: Vec<f64> = skin.iter().map(|&v| brightness(v)).collect();
    sorted.sort_unstable_by(f64::total_cmp);
    let usual = sorted.get(sorted.len() / 2).copied().unwrap_or(1.0);
    let (plain, other): (Vec<u32>, Vec<u32>) = skin
        .iter()
        .partition(|&&v| (brightness(v) - usual).abs() < PLAIN * usual);
    let cell = |p: DVec3| (p / APART).floor().as_ivec3().to_array();
    let mut cells: BTreeMap<[i32; 3], Vec<DVec3>> = BTreeMap::new();
    for v in other {
        let p = mean[v as usize];
        cells.entry(cell(p)).or_default().push(p);
    }
    let is_near = |p: DVec3| {
        let [x, y, z] = cell(p);
        (0..27).any(|i| {
            let there = cells.get(&[x + i % 3 - 1, y + i / 3 % 3 - 1, z + i / 9 - 1]);
            there.is_some_and(|all| all.iter().any(|q| q.distance(p) < APART))
        })
    };
    let far = plain.into_iter();
    far.filter(|&v| !is_near(mean[v as usize])).collect()
}

/// The neighbours of each vertex of the skin, in order; none where the skin ends, and none of other
/// vertices.
fn fans(model: &FaceModel) -> Vec<Vec<u32>> {
    let topology = &model.parts().topology;
    let all = topology.triangles();
    let mut edges: Vec<Vec<[u32; 2]>> = vec![Vec::new(); model.parts().mean.len()];
    for part in topology.parts.iter().filter(|p| p.name == "skin") {
        for &[a, b, c] in &all[part.first as usize..(part.first + part.count) as usize] {
            edges[a as usize].push([b, c]);
            edges[b as usize].push([c, a]);
            edges[c as usize].push([a, b]);
        }
    }
    edges
        .iter()
        .map(|edges| fan(edges).unwrap_or_default())
        .collect()
}

/// The one closed way along the edges opposite of a vertex.
fn fan(edges: &[[u32; 2]]) -> Option<Vec<u32>> {
    let mut fan = vec![edges.first()?[0]];
    while fan.len() <= edges.len() {
        let last = fan[fan.len() - 1];
        let [_, next] = edges.iter().find(|edge| edge[0] == last)?;
        if *next == fan[0] {
            break;
        }
        fan.push(*next);
    }
    (fan.len() == edges.len()).then_some(fan)
}

/// The levels of some points. Middles are chosen one after another, each as far from those before it
/// as there is a point (Gonzalez 1985), so that those of a coarse level are the first of a fine one.
fn levels(points: &[DVec3]) -> Vec<Level> {
    let mut distance = vec![f64::INFINITY; points.len()];
    let mut patch = vec![0; points.len()];
    let mut middles: Vec<DVec3> = Vec::new();
    let mut next = 0;
    let mut levels = Vec::new();
    for (count, modes) in LEVELS {
        let count = count.min(points.len());
        while middles.len() < count {
            let middle = points[next];
            let mut farthest = -1.0;
            for (i, &p) in points.iter().enumerate() {
                let there = p.distance_squared(middle);
                if there < distance[i] {
                    distance[i] = there;
                    patch[i] = middles.len();
                }
                if distance[i] > farthest {
                    farthest = distance[i];
                    next = i;
                }
            }
            middles.push(middle);
        }
        levels.push(Level {
            patch: patch.clone(),
            albedo: Albedo::new(&middles, modes),
        });
    }
    levels
}
