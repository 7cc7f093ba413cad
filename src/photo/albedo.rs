//! What is expected of the albedo of skin: smooth random fields.
//!
//! The albedo's relative deviation from its mean is a Gaussian process on the face: two fields, of
//! large and of small patches, whose correlation falls with the distance on the mean head. It is
//! told by as many *modes* as there are anchors (Nystrom's approximation; Williams & Seeger 2001), so
//! that it can be eliminated from a least-squares problem with a matrix of that size; what is left of
//! the process at each point counts as noise there (Snelson & Ghahramani 2006, "Sparse Gaussian
//! processes using pseudo-inputs").

use glam::DVec3;
use nalgebra::DMatrix;

use super::knob;

/// The albedo at some points.
#[derive(Debug, Clone)]
pub(super) struct Albedo {
    /// A column a point, a row a mode; the modes' weights are independent and standard normal.
    pub modes: DMatrix<f64>,
    /// The variance at each point that the modes do not tell.
    pub left: Vec<f64>,
}

fn covariance(distance: f64) -> f64 {
    let (s1, l1, s2, l2) = (
        knob("S1", 0.10),
        knob("L1", 35.0),
        knob("S2", 0.05),
        knob("L2", 12.0),
    );
    let gauss = |s: f64, l: f64| s * s * (-0.5 * (distance / l).powi(2)).exp();
    let matern = |s: f64, l: f64| {
        let x = 3f64.sqrt() * distance / l;
        s * s * (1.0 + x) * (-x).exp()
    };
    if knob("MATERN", 0.0) > 0.0 {
        matern(s1, l1) + matern(s2, l2)
    } else {
        gauss(s1, l1) + gauss(s2, l2)
    }
}

impl Albedo {
    /// At points of the mean head (mm), of which the first `anchors` are the anchors.
    pub fn new(points: &[DVec3], anchors: usize) -> Self {
        let anchors = anchors.min(points.len());
        let between = |i: usize, j: usize| covariance(points[i].distance(points[j]));
        let variance = covariance(0.0);
        let mut own = DMatrix::from_fn(anchors, anchors, between);
        for i in 0..anchors {
            // For the factor: a thousandth of the deviation.
            own[(i, i)] += 1e-6 * variance;
        }
        let mut modes = DMatrix::from_fn(anchors, points.len(), between);
        if let Some(factor) = own.cholesky() {
            factor.l_dirty().solve_lower_triangular_mut(&mut modes);
        }
        let left = modes.column_iter().map(|m| (variance - m.norm_squared()).max(0.0));
        Self {
            left: left.collect(),
            modes,
        }
    }
}
