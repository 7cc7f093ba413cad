//! The crease measure: how sharply a deformation bends the surface where a region ends.

use glam::DVec3;
use rayon::prelude::*;
use serde::Serialize;

use super::FEATURES;
use super::surround::border;
use crate::Random;
use crate::fit::FitResult;
use crate::fit::head::template::Template;
use crate::fit::mesh::geodesic::Geodesic;
use crate::model::FaceModel;

/// The edges of the band around a region's border, on the skin.
pub struct BorderBand {
    /// `[edge start, edge end, apex, other apex]`.
    hinges: Vec<[u32; 4]>,
    rest: Vec<f64>,
}

impl BorderBand {
    /// The edges with both ends within `width` mm (along the surface) of the border of the region
    /// `inside`, of the triangles given. `rest` is the face from which changes are measured.
    pub fn new(
        rest: &[DVec3],
        triangles: &[[u32; 3]],
        graph: &Geodesic,
        inside: &[bool],
        width: f64,
    ) -> Self {
        let near = graph.distances(&border(triangles, inside), width);
        let mut across = std::collections::BTreeMap::new();
        let mut hinges = Vec::new();
        for triangle in triangles {
            for corner in 0..3 {
                let [apex, a, b] = [0, 1, 2].map(|i| triangle[(corner + i) % 3]);
                // The neighbour sees the edge the other way round.
                if let Some(other) = across.remove(&(b, a)) {
                    if near[a as usize].is_finite() && near[b as usize].is_finite() {
                        hinges.push([a, b, apex, other]);
                    }
                } else {
                    across.insert((a, b), apex);
                }
            }
        }
        let mut band = Self {
            hinges,
            rest: Vec::new(),
        };
        band.rest = band
            .hinges
            .iter()
            .map(|&hinge| dihedral(rest, hinge))
            .collect();
        band
    }

    /// How many edges there are.
    pub fn edges(&self) -> usize {
        self.hinges.len()
    }

    /// The largest change of a dihedral angle in the band, degrees, and the edge it is at.
    pub fn largest_change(&self, face: &[DVec3]) -> (f64, [u32; 2]) {
        let mut largest = (0.0, [0, 0]);
        for (&hinge, rest) in self.hinges.iter().zip(&self.rest) {
            let change = (dihedral(face, hinge) - rest).abs();
            let change = change.min(std::f64::consts::TAU - change).to_degrees();
            if change > largest.0 {
                largest = (change, [hinge[0], hinge[1]]);
            }
        }
        largest
    }
}

/// How clean the seam of one feature is: the largest change of a dihedral angle near its border,
/// beside the same for a PCA of whole faces, which has no seams. Degrees.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Seam {
    /// The feature.
    pub feature: String,
    /// How far from the border edges count, mm.
    pub width: f64,
    /// The sharpest of the feature's modes at +-2 sigma.
    pub modes: f64,
    /// Where that is, on the mean, mm.
    pub sharpest: DVec3,
    /// The sharpest of the whole-face modes at +-2 sigma.
    pub whole_modes: f64,
    /// The median of random faces on which only this feature varies.
    pub random: f64,
    /// The median of random faces of the whole-face PCA.
    pub whole_random: f64,
}

impl Seam {
    /// The larger of the two ratios to whole faces.
    pub fn ratio(&self) -> f64 {
        (self.modes / self.whole_modes).max(self.random / self.whole_random)
    }
}

/// Random faces of each kind: the median of an odd number is one of them.
const RANDOM_FACES: usize = 101;

/// Looks at the seams of every feature of a model of `template`, within the blending distance of
/// the border and within one and a half of it. `whole` are the modes of a PCA of whole faces of the
/// same population: displacements of all vertices, mm a sigma. The model's faces are looked at as
/// `seen` gives them, for whole faces that are known only on a coarser mesh.
///
/// # Errors
/// When the template has no skin, or the model has other coefficients than its blocks say.
pub fn seams(
    template: &Template,
    model: &FaceModel,
    whole: &[Vec<DVec3>],
    seen: &(dyn Fn(Vec<DVec3>) -> Vec<DVec3> + Sync),
) -> FitResult<Vec<Seam>> {
    let mean: Vec<DVec3> = model.parts().mean.iter().map(|p| p.as_dvec3()).collect();
    let triangles = template.triangles();
    let graph = Geodesic::new(&mean, &triangles);
    let skin = template.part_triangles("skin")?;
    let total = model.parts().coefficients();
    let region_face = |coefficients: &[f64]| -> FitResult<Vec<DVec3>> {
        let mut face = model.face();
        let coefficients: Vec<f32> = coefficients.iter().map(|&c| c as f32).collect();
        face.set_coefficients(&coefficients)?;
        Ok(seen(
            face.positions().iter().map(|p| p.as_dvec3()).collect(),
        ))
    };
    let whole_face = |coefficients: &[f64]| -> Vec<DVec3> {
        let mut face = mean.clone();
        for (mode, c) in whole.iter().zip(coefficients) {
            face.iter_mut().zip(mode).for_each(|(p, d)| *p += *d * *c);
        }
        face
    };
    let only = |i: usize, c: f64, count: usize| {
        let mut coefficients = vec![0.0; count];
        coefficients[i] = c;
        coefficients
    };
    let both = [-2.0, 2.0];
    let whole_modes: Vec<Vec<DVec3>> = (0..whole.len())
        .flat_map(|k| both.map(|c| whole_face(&only(k, c, whole.len()))))
        .collect();
    let mut random = Random::new(2024);
    let whole_random: Vec<Vec<DVec3>> = (0..RANDOM_FACES)
        .map(|_| whole_face(&whole.iter().map(|_| random.normal()).collect::<Vec<_>>()))
        .collect();
    let alpha = f64::from(model.parts().blending.alpha);
    let mut seams = Vec::new();
    for (rule, block) in FEATURES.iter().zip(&model.parts().blocks) {
        let modes = block
            .coefficients()
            .flat_map(|i| both.map(|c| region_face(&only(i, c, total))))
            .collect::<FitResult<Vec<_>>>()?;
        let own_random = (0..RANDOM_FACES)
            .map(|_| {
                let mut c = vec![0.0; total];
                block.coefficients().for_each(|i| c[i] = random.normal());
                region_face(&c)
            })
            .collect::<FitResult<Vec<_>>>()?;
        let inside: Vec<bool> = template
            .topology
            .regions
            .iter()
            .map(|&r| {
                rule.regions
                    .contains(&template.topology.region_names[r as usize].as_str())
            })
            .collect();
        for width in [alpha, 1.5 * alpha] {
            let band = BorderBand::new(&mean, &skin, &graph, &inside, width);
            let changes = |faces: &[Vec<DVec3>]| -> Vec<(f64, [u32; 2])> {
                faces
                    .par_iter()
                    .map(|face| band.largest_change(face))
                    .collect()
            };
            let sharpest = |faces: &[Vec<DVec3>]| {
                let all = changes(faces).into_iter();
                all.max_by(|a, b| a.0.total_cmp(&b.0)).unwrap_or_default()
            };
            let median = |faces: &[Vec<DVec3>]| {
                let mut all: Vec<f64> = changes(faces).iter().map(|c| c.0).collect();
                all.sort_by(f64::total_cmp);
                all[RANDOM_FACES / 2]
            };
            let (of_modes, at) = sharpest(&modes);
            seams.push(Seam {
                feature: rule.name.into(),
                width,
                modes: of_modes,
                sharpest: mean[at[0] as usize],
                whole_modes: sharpest(&whole_modes).0,
                random: median(&own_random),
                whole_random: median(&whole_random),
            });
        }
    }
    Ok(seams)
}

/// The signed angle between the normals of the two triangles on an edge, radians; 0 when flat.
fn dihedral(positions: &[DVec3], [a, b, apex, other]: [u32; 4]) -> f64 {
    let [a, b, apex, other] = [a, b, apex, other].map(|v| positions[v as usize]);
    let edge = b - a;
    let one = edge.cross(apex - a);
    let two = (other - a).cross(edge);
    f64::atan2(one.cross(two).dot(edge) / edge.length(), one.dot(two))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_fold_of_thirty_degrees_is_thirty_degrees() {
        let flat = [[0., 0., 0.], [0., 1., 0.], [-1., 0., 0.], [1., 0., 0.]].map(DVec3::from_array);
        let mut folded = flat;
        folded[3] = DVec3::new(30_f64.to_radians().cos(), 0.0, 30_f64.to_radians().sin());
        let hinge = [0, 1, 2, 3];
        assert!(dihedral(&flat, hinge).abs() < 1e-12);
        assert!((dihedral(&folded, hinge).abs().to_degrees() - 30.0).abs() < 1e-9);
    }
}
