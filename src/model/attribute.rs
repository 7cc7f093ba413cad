//! Attributes: what labels of a population tell of a face.

use nalgebra::DMatrix;

/// A label, such as age, as a linear function of a face's coefficients.
///
/// Coefficients c of the population are normal with correlation R, so one read-out w says all of a
/// label. Where a face stands is `mean + w . c`; the population's people are normal around `mean`
/// with the variance w . R w; and the direction in which a face changes with the label, all else
/// being as it may, is R w / (w . R w) sigmas for one unit of it. Whoever learned the read-out
/// chose it so that this direction is the mean change of the labelled people.
#[derive(Debug, Clone, PartialEq)]
pub struct Attribute {
    /// Its name, unlike every other.
    pub name: String,
    /// What it is and of whom it was learned: not always the people of the model.
    pub description: String,
    /// The unit of the read-out, such as `years`.
    pub unit: String,
    /// Least and greatest of the labels that it was learned from: what may be asked for.
    pub limits: [f32; 2],
    /// The read-out of the mean face.
    pub mean: f32,
    /// The part of the labels' variance that the read-out explains in labelled people whom it was
    /// not learned from, 0..=1.
    pub explained: f32,
    /// How far the read-out goes with one sigma of each coefficient of the population.
    pub reading: Vec<f32>,
}

impl Attribute {
    /// The read-out of a face's coefficients in sigmas. Those of local blocks, which come last, say
    /// nothing.
    pub fn read(&self, coefficients: &[f64]) -> f64 {
        let each = self.reading.iter().zip(coefficients);
        f64::from(self.mean) + each.map(|(&w, c)| f64::from(w) * c).sum::<f64>()
    }

    /// Its numbers as a model's file holds them.
    pub(crate) fn numbers(&self) -> impl Iterator<Item = f32> {
        let few = [self.limits[0], self.limits[1], self.mean, self.explained];
        few.into_iter().chain(self.reading.iter().copied())
    }
}

/// S w for a covariance S and weights w, and the variance w . S w.
#[inline(never)]
pub(crate) fn along(covariance: &DMatrix<f64>, weights: &[f32]) -> (Vec<f64>, f64) {
    let (mut along, mut variance) = (Vec::new(), 0.0);
    for (column, &weight) in covariance.column_iter().zip(weights) {
        let mut sum = 0.0;
        for (s, &w) in column.iter().zip(weights) {
            sum += s * f64::from(w);
        }
        variance += sum * f64::from(weight);
        along.push(sum);
    }
    (along, variance)
}
