//! Points of a face as linear functions of what is unknown of it.

use glam::DVec3;
use nalgebra::DMatrix;

use crate::anatomy::Landmark;
use crate::expression::Expression;
use crate::model::FaceModel;
use crate::{Error, Expressions, Face, Result};

/// A point of the surface, as vertices with weights that sum to 1.
pub(super) type Stencil = Vec<(u32, f64)>;

/// An axis is left out when one standard deviation of it moves all points together, the 68 and those of
/// the paths, by less than this (the root of the sum of their squares), mm. A point then moves by 0.04
/// mm, where it is seen to 0.75. It makes fits twice as fast, and no worse by a tenth of a per cent.
const FELT: f64 = 0.7;
/// People vary less than the registered faces that a model is learned from, which have the noise of
/// registration besides: by this factor. Without it heads are fitted 1.2 % too large; at 0.85 they are
/// 0.6 %, and shape and pose are best (150 people of ICT-FaceKit).
pub(super) const SPREAD: f64 = 0.85;

/// Points of a face.
///
/// What a face is follows from its independent coefficients z, which are standard normal: those of
/// the model (in sigmas, normal with the population's correlation C) are B z with B B' = C. Of such
/// bases one is taken whose axes move the points independently of each other, so that those that
/// hardly move any can be left out. Expressions are taken as they are on the mean head.
#[derive(Debug, Clone)]
pub(super) struct Points {
    /// Where they are on the mean head, mm.
    pub mean: Vec<DVec3>,
    /// How they move, mm: three columns a point, a row an independent coefficient and then one an
    /// expression at full weight.
    pub rates: DMatrix<f64>,
    /// B: a row a coefficient of the population, a column an independent one.
    pub basis: DMatrix<f64>,
}

impl Points {
    /// Of some stencils on the model's mesh: first with the axes that move them, then with all,
    /// which begin with those.
    pub fn new(
        model: &FaceModel,
        expressions: Option<&Expressions>,
        stencils: &[Stencil],
    ) -> [Self; 2] {
        let parts = model.parts();
        let population = parts.population();
        let face = model.face();
        let mean: Vec<DVec3> = stencils
            .iter()
            .map(|stencil| {
                let corners = stencil.iter();
                corners
                    .map(|&(v, w)| parts.mean[v as usize].as_dvec3() * w)
                    .sum()
            })
            .collect();
        let mut rates = DMatrix::zeros(population, 3 * stencils.len());
        for (i, stencil) in stencils.iter().enumerate() {
            for &(vertex, weight) in stencil {
                add_rates(&face, vertex, weight, i, &mut rates);
            }
        }
        let cholesky = &model.derived.cholesky * SPREAD;
        let whitened = cholesky.tr_mul(&rates);
        let axes = (&whitened * whitened.transpose()).symmetric_eigen();
        let is_felt = |k: &usize| axes.eigenvalues[*k] > FELT * FELT;
        let (felt, rest): (Vec<usize>, Vec<usize>) = (0..population).partition(is_felt);
        let all: Vec<usize> = felt.iter().chain(&rest).copied().collect();
        let list = expressions.map_or(&[][..], |e| e.list());
        let expressed = expressed(list, stencils);
        [felt, all].map(|kept| {
            let axes = axes.eigenvectors.select_columns(&kept);
            let mut rates = axes.tr_mul(&whitened);
            rates = rates.insert_rows(kept.len(), list.len(), 0.0);
            rates.rows_mut(kept.len(), list.len()).copy_from(&expressed);
            Self {
                mean: mean.clone(),
                rates,
                basis: &cholesky * axes,
            }
        })
    }

    /// Where point `i` is for these independent coefficients and expression weights, mm.
    pub fn place(&self, i: usize, unknowns: &[f64]) -> DVec3 {
        let row = |axis: usize| -> f64 {
            let rates = self.along(i, axis);
            rates.iter().zip(unknowns).map(|(r, u)| r * u).sum()
        };
        self.mean[i] + DVec3::new(row(0), row(1), row(2))
    }

    /// How point `i` moves along an axis of the head with each unknown, mm.
    pub fn along(&self, i: usize, axis: usize) -> &[f64] {
        let unknowns = self.rates.nrows();
        let first = (3 * i + axis) * unknowns;
        &self.rates.as_slice()[first..first + unknowns]
    }
}

/// How some points move with expressions, mm: a row an expression at full weight, three columns a
/// point.
fn expressed(list: &[Expression], stencils: &[Stencil]) -> DMatrix<f64> {
    let mut rates = DMatrix::zeros(list.len(), 3 * stencils.len());
    for (e, expression) in list.iter().enumerate() {
        for (i, stencil) in stencils.iter().enumerate() {
            for &(vertex, weight) in stencil {
                let Ok(slot) = expression.support.binary_search(&vertex) else {
                    continue;
                };
                let moved = expression.displacements[slot].as_dvec3() * weight;
                for axis in 0..3 {
                    rates[(e, 3 * i + axis)] += moved[axis];
                }
            }
        }
    }
    rates
}

/// Adds how a vertex moves with each coefficient of the population, times a weight, to the columns
/// of point `i`.
fn add_rates(face: &Face, vertex: u32, weight: f64, i: usize, rates: &mut DMatrix<f64>) {
    for (k, rate) in face.jacobian(vertex).iter().enumerate().take(rates.nrows()) {
        for axis in 0..3 {
            rates[(k, 3 * i + axis)] += f64::from(rate[axis]) * weight;
        }
    }
}

/// The stencils of the 68 points of iBUG (Sagonas et al. 2013), in their order.
pub(super) fn ibug(model: &FaceModel) -> Result<Vec<Stencil>> {
    let landmarks = &model.parts().landmarks;
    (0..super::POINTS)
        .map(|i| {
            let name = format!("ibug_{i:02}");
            let found = landmarks.iter().find(|l: &&Landmark| l.name == name);
            found.map(|l| l.stencil.clone()).ok_or(Error::Unknown {
                kind: "landmark",
                name,
            })
        })
        .collect()
}
