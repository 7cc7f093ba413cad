//! What faces that are not a model's own are in its coefficients: penalised least squares with the model's prior.

use faer::linalg::solvers::Solve;
use faer::{Mat, Side};
use glam::DVec3;
use rayon::prelude::*;

use crate::FaceModel;
use crate::fit::mesh::align::Rigid;
use crate::fit::statistics::gram::{columns, gram};
use crate::fit::statistics::subspace::Subspace;
use crate::fit::{FitError, FitResult};

/// What a model leaves of a face of others is as smooth as faces are: it counts as so many
/// independent errors, and not as one a coordinate.
const INDEPENDENT: f64 = 300.0;

/// Where one face is asked for, more of it is believed: so many. People of ICT-FaceKit whom the default model was not learned from
/// then have coefficients of 1.06 RMS, where people have 1, and a real scan of another scanner keeps its likeness: the model
/// leaves 1.1 to 1.4 mm of eyes, nose and mouth, and 1.5 to 1.9 with the other number.
const INDEPENDENT_OF_ONE: f64 = 1000.0;

/// Of the parts of a face no less than this is taken to be left, mm: less is the rounding of files.
const LEAST_LEFT: f64 = 0.01;

/// What is left of the parts of a face is found in so many steps at most, or when it changes by less than this part of it; and
/// a face is aligned so often at least.
const STEPS: usize = 40;
const SETTLED: f64 = 0.01;
const FEWEST_STEPS: usize = 6;

/// The face of a model that a face is likest.
#[derive(Debug, Clone)]
pub struct Likeness {
    /// The population's coefficients, sigmas.
    pub coefficients: Vec<f64>,
    /// The face (all vertices, mm), moved rigidly to where its likeness is.
    pub aligned: Vec<DVec3>,
    /// What the likeness leaves of its features and of the rest of its skin, mm RMS.
    pub left: [f64; 2],
    /// The same of all of the skin.
    pub left_of_skin: f64,
}

/// A part of the skin that is fitted as closely as it can be.
struct Part {
    vertices: Vec<u32>,
    /// Of each mode, x, y, z a vertex.
    modes: Vec<Vec<f64>>,
    /// Their inner products.
    gram: Mat<f64>,
}

impl Part {
    fn new(modes: &[Vec<DVec3>], vertices: Vec<u32>) -> Self {
        let on = |mode: &Vec<DVec3>| -> Vec<f64> {
            let each = vertices.iter();
            each.flat_map(|&v| mode[v as usize].to_array()).collect()
        };
        let modes: Vec<Vec<f64>> = modes.iter().map(on).collect();
        let gram = gram(3 * vertices.len(), |rows| columns(&modes, rows));
        Self {
            vertices,
            modes,
            gram,
        }
    }

    /// The inner products of a displacement field (all vertices, mm) with the modes.
    fn inner(&self, field: &[DVec3]) -> Vec<f64> {
        let own = self
            .vertices
            .iter()
            .flat_map(|&v| field[v as usize].to_array());
        let own: Vec<f64> = own.collect();
        let modes = self.modes.par_iter();
        modes
            .map(|mode| mode.iter().zip(&own).map(|(a, b)| a * b).sum())
            .collect()
    }

    /// The mean square of what is left of a field, mm^2.
    fn left(&self, field: &[DVec3], shown: &[DVec3]) -> f64 {
        let each = self.vertices.iter().map(|&v| v as usize);
        let sum: f64 = each.map(|v| field[v].distance_squared(shown[v])).sum();
        sum / self.vertices.len().max(1) as f64
    }
}

/// The faces of a model that registered faces are likest.
pub struct Likenesses {
    mean: Vec<DVec3>,
    areas: Vec<f64>,
    skin: Vec<u32>,
    /// Of the population, each a displacement of all vertices, mm a sigma.
    modes: Vec<Vec<DVec3>>,
    /// The features, which a person is known by, and the rest of the skin, of which scans show little.
    parts: [Part; 2],
    /// R^-1.
    precision: Mat<f64>,
}

impl Likenesses {
    /// Of a model, whose vertices count with their `areas` where faces are aligned with it.
    ///
    /// # Errors
    /// When the model does not vary, has no part that is its skin, or its correlation is not definite.
    pub fn new(model: &FaceModel, areas: Vec<f64>) -> FitResult<Self> {
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
        let modes: Vec<Vec<DVec3>> = (0..parts.population())
            .map(|i| rows.iter().map(|row| row[i].as_dvec3()).collect())
            .collect();
        let topology = &parts.topology;
        let is_rest =
            |v: &u32| topology.region_names[usize::from(topology.regions[*v as usize])] == "head";
        let (rest, features): (Vec<u32>, Vec<u32>) = skin.iter().partition(|v| is_rest(v));
        let precision = correlation(model)
            .llt(Side::Lower)
            .map_err(|_| FitError::Input("the model's correlation is not definite".into()))?
            .solve(Mat::<f64>::identity(modes.len(), modes.len()));
        Ok(Self {
            parts: [Part::new(&modes, features), Part::new(&modes, rest)],
            precision,
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

    /// The likeness of one face (all vertices, mm, any pose). How much the prior counts goes by what the model leaves of the
    /// face: of its features, and of the rest of the head, each by itself, in steps between which the face is aligned with
    /// what it is likest. Or by `left`, mm RMS of both.
    ///
    /// # Errors
    /// When the modes are sums of each other.
    pub fn one(&self, face: &[DVec3], left: Option<f64>) -> FitResult<Likeness> {
        let mut squares = [left.map_or(1.0, |left| left.max(LEAST_LEFT).powi(2)); 2];
        let mut shown = self.mean.clone();
        let mut step = 0;
        loop {
            step += 1;
            let found = self.step(face, &shown, squares)?;
            let next = match left {
                Some(_) => squares,
                None => found.left.map(|left| left.max(LEAST_LEFT).powi(2)),
            };
            let change = squares.iter().zip(&next).map(|(a, b)| (a / b).ln().abs());
            let is_settled = change.fold(0.0, f64::max) < SETTLED;
            if step >= STEPS || is_settled && step >= FEWEST_STEPS {
                return Ok(found);
            }
            squares = next;
            shown = self.shown(&found.coefficients);
        }
    }

    /// The likeness of a face that is aligned with one that it is like, where so much is left of its parts, mm^2.
    fn step(&self, face: &[DVec3], like: &[DVec3], squares: [f64; 2]) -> FitResult<Likeness> {
        let vertices = self.skin.len() as f64;
        let mut weights = vec![0.0; self.mean.len()];
        for (part, square) in self.parts.iter().zip(squares) {
            let own = part.vertices.iter().map(|&v| v as usize);
            own.for_each(|v| weights[v] = self.areas[v] / square);
        }
        let motion = Rigid::fit(face, like, &self.skin, &weights);
        let aligned: Vec<DVec3> = face.iter().map(|&p| motion.apply(p)).collect();
        let pairs = aligned.iter().zip(&self.mean);
        let field: Vec<DVec3> = pairs.map(|(&p, m)| p - *m).collect();
        let mut normal = self.precision.clone();
        let mut right = Mat::<f64>::zeros(self.modes.len(), 1);
        for (part, square) in self.parts.iter().zip(squares) {
            let weight = INDEPENDENT_OF_ONE / vertices / square;
            normal += faer::Scale(weight) * &part.gram;
            let inner = part.inner(&field).into_iter().enumerate();
            inner.for_each(|(i, x)| right[(i, 0)] += weight * x);
        }
        let solved = (normal.llt(Side::Lower))
            .map_err(|_| FitError::Input("modes that are sums of each other".into()))?
            .solve(&right);
        let coefficients: Vec<f64> = (0..self.modes.len()).map(|i| solved[(i, 0)]).collect();
        let shown = self.shown(&coefficients);
        let [features, rest] = self
            .parts
            .each_ref()
            .map(|part| part.left(&aligned, &shown));
        let counts = self.parts.each_ref().map(|part| part.vertices.len() as f64);
        Ok(Likeness {
            coefficients,
            aligned,
            left: [features.sqrt(), rest.sqrt()],
            left_of_skin: ((features * counts[0] + rest * counts[1]) / vertices).sqrt(),
        })
    }

    /// The face of coefficients, all vertices, mm.
    fn shown(&self, coefficients: &[f64]) -> Vec<DVec3> {
        let mut face = self.mean.clone();
        for (mode, &c) in self.modes.iter().zip(coefficients) {
            face.iter_mut().zip(mode).for_each(|(p, d)| *p += *d * c);
        }
        face
    }

    /// The population's coefficients of faces (all vertices, mm, any pose), sigmas, and what those leave of their skin,
    /// mm RMS over all of them. How much the prior counts goes by what the model leaves of those that are asked for
    /// together.
    ///
    /// # Errors
    /// When the model's modes are sums of each other.
    pub fn of(&self, faces: &[Vec<DVec3>]) -> FitResult<(Vec<Vec<f64>>, f64)> {
        let moved: Vec<Vec<DVec3>> = (faces.par_iter())
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
            let pairs = nearest.par_iter().zip(&moved);
            // Summed face by face: threads share the work and not the order.
            let squares: Vec<f64> = pairs
                .map(|(a, b)| {
                    let each = self.skin.iter().map(|&v| v as usize);
                    each.map(|v| a[v].distance_squared(b[v])).sum()
                })
                .collect();
            squares.iter().sum::<f64>() / (moved.len() * self.skin.len()) as f64
        };
        let (modes, skin) = (&self.modes, &self.skin);
        let plain = Subspace::new(modes, skin)?;
        let left = off(&plain.coefficients(&moved), &plain);
        let weight = left * skin.len() as f64 / INDEPENDENT;
        let penalty = faer::Scale(weight) * &self.precision;
        let penalised = Subspace::penalised(modes, skin, penalty)?;
        let found = penalised.coefficients(&moved);
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
