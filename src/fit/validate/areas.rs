//! The parts of a head in which errors are counted, and what they are.

use glam::DVec3;
use serde::Serialize;

use crate::fit::FitResult;
use crate::fit::head::template::Template;

/// The visible parts of a head in which errors are counted: each feature's skin, the rest of the
/// skin, and all features together.
pub struct Areas {
    /// Their names.
    pub names: Vec<String>,
    /// The vertices of each, increasing.
    pub vertices: Vec<Vec<u32>>,
    /// All of the skin.
    pub skin: Vec<u32>,
}

/// The name of all features together.
pub const FEATURES: &str = "all features";

impl Areas {
    /// Those of a template.
    ///
    /// # Errors
    /// When it has no skin.
    pub fn new(template: &Template) -> FitResult<Self> {
        let skin = template.part_vertices("skin")?;
        let name_of = |v: u32| {
            let topology = &template.topology;
            topology.region_names[topology.regions[v as usize] as usize].as_str()
        };
        let rules = crate::fit::learn::FEATURES;
        let (mut names, mut vertices) = (Vec::new(), Vec::new());
        for rule in rules {
            names.push(rule.name.to_owned());
            let inside = skin.iter().filter(|&&v| rule.regions.contains(&name_of(v)));
            vertices.push(inside.copied().collect::<Vec<u32>>());
        }
        let mut all: Vec<u32> = vertices.concat();
        all.sort_unstable();
        let rest = skin.iter().filter(|v| all.binary_search(v).is_err());
        vertices.push(rest.copied().collect());
        names.push("head".into());
        vertices.push(all);
        names.push(FEATURES.into());
        Ok(Self {
            names,
            vertices,
            skin,
        })
    }

    /// The diagonal of the bounding box of a head's skin, mm.
    pub fn diameter(&self, head: &[DVec3]) -> f64 {
        let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for &v in &self.skin {
            low = low.min(head[v as usize]);
            high = high.max(head[v as usize]);
        }
        low.distance(high)
    }

    /// The errors of a reconstruction in each area, mm.
    pub fn errors(&self, face: &[DVec3], reconstructed: &[DVec3]) -> Vec<Errors> {
        self.vertices
            .iter()
            .map(|area| Errors::between(area, face, reconstructed))
            .collect()
    }
}

/// Distances between corresponding vertices, mm.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub struct Errors {
    /// The largest.
    pub max: f64,
    /// The mean.
    pub mean: f64,
    /// The root mean square.
    pub rms: f64,
}

impl Errors {
    /// Between two faces, or fields of displacements, on some vertices.
    pub fn between(vertices: &[u32], one: &[DVec3], other: &[DVec3]) -> Self {
        let apart = |&v: &u32| one[v as usize].distance(other[v as usize]);
        Self::of(vertices.iter().map(apart))
    }

    fn of(distances: impl Iterator<Item = f64>) -> Self {
        let (mut count, mut max, mut sum, mut squares) = (0_usize, 0.0_f64, 0.0, 0.0);
        for d in distances {
            count += 1;
            max = max.max(d);
            sum += d;
            squares += d * d;
        }
        let n = count.max(1) as f64;
        Self {
            max,
            mean: sum / n,
            rms: (squares / n).sqrt(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_are_the_largest_the_mean_and_the_root_mean_square() {
        let errors = Errors::of([3.0, 4.0, 0.0, 0.0].into_iter());
        assert_eq!((errors.max, errors.mean, errors.rms), (4.0, 1.75, 2.5));
    }
}
