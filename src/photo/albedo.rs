//! What is expected of the albedo of skin: smooth random fields.
//!
//! The relative deviation of the albedo from its mean is a Gaussian process on the face: large and
//! small patches, whose correlation falls with the distance on the mean head. It is told by as many
//! *modes* as there are anchors (Nystrom's approximation; Williams & Seeger 2001, "Using the Nystrom
//! method to speed up kernel machines"), so that it can be eliminated from a least-squares problem
//! with a matrix of that size. What is left of the process at each point counts as noise there
//! (Snelson & Ghahramani 2006, "Sparse Gaussian processes using pseudo-inputs").

use glam::DVec3;
use nalgebra::DMatrix;

/// The standard deviations of the two fields, and the distances (mm) at which their correlation has
/// fallen to exp(-1/2): tan, flush and shine; freckles, stubble and pores.
const FIELDS: [(f64, f64); 2] = [(0.10, 60.0), (0.05, 12.0)];

/// The albedo at some points.
#[derive(Debug, Clone)]
pub(super) struct Albedo {
    /// A row a mode, a column a point; the modes' weights are independent and standard normal.
    pub modes: DMatrix<f64>,
    /// The variance at each point that the modes do not tell.
    pub left: Vec<f64>,
}

/// The covariance of the albedo at two points that are so many mm apart.
fn covariance(distance: f64) -> f64 {
    let fields = FIELDS.iter();
    fields
        .map(|(sigma, length)| sigma * sigma * (-0.5 * (distance / length).powi(2)).exp())
        .sum()
}

/// The variance of the albedo.
pub(super) fn variance() -> f64 {
    covariance(0.0)
}

impl Albedo {
    /// At points of the mean head (mm), of which the first ones are the anchors.
    pub fn new(points: &[DVec3], anchors: usize) -> Self {
        let anchors = anchors.min(points.len());
        let between = |i: usize, j: usize| covariance(points[i].distance(points[j]));
        let mut own = DMatrix::from_fn(anchors, anchors, between);
        for i in 0..anchors {
            // So that it has a factor: a thousandth of the deviation.
            own[(i, i)] += 1e-6 * variance();
        }
        let mut modes = DMatrix::from_fn(anchors, points.len(), between);
        match own.cholesky() {
            Some(factor) => {
                factor.l_dirty().solve_lower_triangular_mut(&mut modes);
            }
            // Nothing is told, all of it is noise.
            None => modes.fill(0.0),
        }
        let columns = modes.column_iter();
        let left = columns.map(|m| (variance() - m.norm_squared()).max(0.0));
        Self {
            left: left.collect(),
            modes,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn modes_tell_the_process_between_anchors_and_nothing_far_from_them() {
        let mut points: Vec<DVec3> = (0..64)
            .map(|i| DVec3::new(f64::from(i % 8), f64::from(i / 8), 0.0) * 8.0)
            .collect();
        points.push(DVec3::new(12.0, 20.0, 0.0));
        points.push(DVec3::new(17.0, 27.0, 0.0));
        points.push(DVec3::new(500.0, 0.0, 0.0));
        let albedo = Albedo::new(&points, 64);
        let column = |i: usize| albedo.modes.column(i);
        // Between anchors that are as close together as two thirds of the shorter length, a per cent
        // of the variance is not told.
        for (i, j) in [(64, 64), (64, 65), (3, 64), (10, 30)] {
            let told = column(i).dot(&column(j));
            let expected = covariance(points[i].distance(points[j]));
            assert!((told - expected).abs() < 0.01 * variance(), "{i} {j}");
        }
        assert!(albedo.left[64] < 0.01 * variance());
        assert!((albedo.left[66] - variance()).abs() < 1e-9);
    }
}
