//! What faces that are not a model's own are in its coefficients: penalised least squares with the model's prior.

use faer::linalg::solvers::Solve;
use faer::{Mat, Side};
use glam::DVec3;
use rayon::prelude::*;

use crate::FaceModel;
use crate::fit::mesh::align::Rigid;
use crate::fit::statistics::subspace::Subspace;
use crate::fit::{FitError, FitResult};

/// What a model leaves of a face of others is as smooth as faces are: it counts as so many
/// independent errors, and not as one a coordinate.
const INDEPENDENT: f64 = 300.0;

/// The faces of a model that registered faces are likest.
pub struct Likenesses<'a> {
    model: &'a FaceModel,
    mean: Vec<DVec3>,
    areas: Vec<f64>,
    skin: Vec<u32>,
    /// Of the population, each a displacement of all vertices, mm a sigma.
    modes: Vec<Vec<DVec3>>,
}

impl<'a> Likenesses<'a> {
    /// Of a model, whose vertices count with their `areas` where faces are aligned with it.
    ///
    /// # Errors
    /// When the model does not vary, or has no part that is its skin.
    pub fn new(model: &'a FaceModel, areas: Vec<f64>) -> FitResult<Self> {
        let parts = model.parts();
        let skin = parts.topology.part_vertices("skin");
        if parts.population() == 0 || skin.is_empty() {
            let cause = "the model has one face, or no part called \"skin\"";
            return Err(FitError::Input(cause.into()));
        }
        let shown = model.face();
        let rows: Vec<_> = (0..parts.mean.len() as u32)
            .into_par_iter()
            .map(|v| shown.jacobian(v))
            .collect();
        let modes = (0..parts.population())
            .map(|i| rows.iter().map(|row| row[i].as_dvec3()).collect())
            .collect();
        Ok(Self {
            model,
            mean: parts.mean.iter().map(|p| p.as_dvec3()).collect(),
            areas,
            skin,
            modes,
        })
    }

    /// A face (all vertices, mm, any pose) moved rigidly to where the model's faces are.
    pub fn align(&self, face: &[DVec3]) -> Vec<DVec3> {
        let motion = Rigid::fit(face, &self.mean, &self.skin, &self.areas);
        face.iter().map(|&p| motion.apply(p)).collect()
    }

    /// The population's coefficients of faces (all vertices, mm, any pose), sigmas, and what those leave of their skin,
    /// mm RMS over all of them. How much the prior counts goes by what the model leaves of the faces that are asked
    /// for together.
    ///
    /// # Errors
    /// When the model's correlation is not definite, or its modes are sums of each other.
    pub fn of(&self, faces: &[Vec<DVec3>]) -> FitResult<(Vec<Vec<f64>>, f64)> {
        let fields: Vec<Vec<DVec3>> = (faces.par_iter())
            .map(|face| {
                let aligned = self.align(face);
                aligned
                    .iter()
                    .zip(&self.mean)
                    .map(|(&p, m)| p - *m)
                    .collect()
            })
            .collect();
        let off = |found: &[Vec<f64>], subspace: &Subspace| {
            let nearest = subspace.fields(found);
            let pairs = nearest.par_iter().zip(&fields);
            // Summed face by face: threads share the work and not the order.
            let squares: Vec<f64> = pairs
                .map(|(a, b)| {
                    let each = self.skin.iter().map(|&v| v as usize);
                    each.map(|v| a[v].distance_squared(b[v])).sum()
                })
                .collect();
            squares.iter().sum::<f64>() / (fields.len() * self.skin.len()) as f64
        };
        let (modes, skin) = (&self.modes, &self.skin);
        let plain = Subspace::new(modes, skin)?;
        let left = off(&plain.coefficients(&fields), &plain);
        let inverse = correlation(self.model)
            .llt(Side::Lower)
            .map_err(|_| FitError::Input("the model's correlation is not definite".into()))?
            .solve(Mat::<f64>::identity(modes.len(), modes.len()));
        let weight = left * skin.len() as f64 / INDEPENDENT;
        let penalised = Subspace::penalised(modes, skin, inverse * faer::Scale(weight))?;
        let found = penalised.coefficients(&fields);
        let left = off(&found, &penalised).sqrt();
        Ok((found, left))
    }
}

/// The correlation of the population's coefficients.
pub(in crate::fit) fn correlation(model: &FaceModel) -> Mat<f64> {
    let parts = model.parts();
    let k = parts.population();
    Mat::from_fn(k, k, |i, j| f64::from(parts.correlation[i * k + j]))
}
