//! What heads of this topology look like before a scan is seen: a PCA of whole faces.
//!
//! The template carries it, so that registration and landmark finding start from a likely face
//! and not from the mean (DESIGN, "local deformation").

use glam::DVec3;
use rayon::prelude::*;

use crate::fit::FitResult;
use crate::fit::head::template::Template;
use crate::fit::mesh::align::procrustes;
use crate::fit::mesh::mirror::{even, with_mirror_images};
use crate::fit::statistics::pca::Pca;

/// The most modes that are kept: more than people's heads are known to need at the noise of a
/// scan, few enough that a fit of all of them takes milliseconds.
const MODES: usize = 90;

/// The part of the variance that the modes keep.
const TAU: f64 = 0.9995;

/// A Gaussian of whole faces around the template's rest pose.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ShapePrior {
    /// Displacements of all template vertices at one standard deviation, mm; mode by mode.
    pub modes: Vec<Vec<DVec3>>,
}

impl ShapePrior {
    /// Learns mean and prior from registered faces, each taken once as it is and once mirrored,
    /// so that both are symmetric. Faces are moved rigidly onto `template`'s rest pose.
    ///
    /// # Errors
    /// When there are too few faces, or they do not vary.
    pub fn learn(template: &Template, faces: &[Vec<DVec3>]) -> FitResult<(Vec<DVec3>, Self)> {
        let mirror = &template.topology.mirror;
        let mut both = with_mirror_images(faces, mirror);
        let skin = template.part_vertices("skin")?;
        let areas =
            crate::fit::mesh::align::vertex_areas(&template.positions, &template.triangles());
        let mean = procrustes(&mut both, &template.positions, &skin, &areas, None);
        // Numbers far below a micrometre must not tell left from right.
        let mean = even(&mean, mirror);
        let prior = Self::of(&both, &mean, TAU, MODES)?;
        Ok((mean, prior))
    }

    /// The principal components of whole faces (in one pose; their displacements from `mean`): the
    /// fewest that hold `tau` of the variance, but not more than `most`.
    ///
    /// # Errors
    /// Those of [`Pca::learn`].
    pub fn of(faces: &[Vec<DVec3>], mean: &[DVec3], tau: f64, most: usize) -> FitResult<Self> {
        let samples: Vec<Vec<f64>> = faces
            .par_iter()
            .map(|face| {
                face.iter()
                    .zip(mean)
                    .flat_map(|(p, m)| (*p - *m).to_array())
                    .collect()
            })
            .collect();
        let pca = Pca::learn(samples, tau)?;
        let modes = pca
            .modes
            .par_iter()
            .zip(&pca.sigmas)
            .take(most)
            .map(|(mode, sigma)| {
                mode.chunks_exact(3)
                    .map(|d| DVec3::from_slice(d) * *sigma)
                    .collect()
            })
            .collect();
        Ok(Self { modes })
    }

    /// A face: the rest pose and the modes, each times its coefficient in standard deviations.
    pub fn face(&self, rest: &[DVec3], coefficients: &[f64]) -> Vec<DVec3> {
        let mut face = rest.to_vec();
        for (mode, &c) in self.modes.iter().zip(coefficients) {
            face.iter_mut().zip(mode).for_each(|(p, d)| *p += *d * c);
        }
        face
    }
}
