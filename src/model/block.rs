//! Blocks: a basis, where it acts, and how it fades.

use crate::quantise::Quantised;

/// A basis with its vertex support.
///
/// With coefficients c in sigmas, support vertex i moves by
/// `step * sum_k c_k * integers[k][i]` mm: the standard deviations are folded into the modes.
#[derive(Debug, Clone, PartialEq)]
pub struct Block {
    /// Its name (`nose`), which is also the group of its controls.
    pub name: String,
    /// The regions that it covers, as indices into the model's regions; empty for all vertices.
    pub regions: Vec<u8>,
    /// The vertices it moves, increasing.
    pub support: Vec<u32>,
    /// The modes, one after the other: mode k is `3 * support.len()` numbers from
    /// `3 * support.len() * k`, as x, y, z a vertex.
    pub modes: Quantised,
    /// The standard deviation of each mode's coefficient in the population: the square root of
    /// the PCA's eigenvalue, mm.
    pub sigmas: Vec<f32>,
    /// The place of its first coefficient in the face's vector.
    pub first_coefficient: usize,
    /// How the vertices around follow; `None` for a block that moves every vertex.
    pub surround: Option<Surround>,
}

impl Block {
    /// The block's coefficients in the face's vector.
    pub fn coefficients(&self) -> std::ops::Range<usize> {
        self.first_coefficient..self.first_coefficient + self.sigmas.len()
    }
}

/// The vertices around a region and what they follow (region morphing, section 6.2).
///
/// Target t moves by `falloff(distance_t / alpha)` times the weighted mean of its sources'
/// displacements. Eq. 11's single nearest vertex creases where neighbours have far-apart nearest
/// vertices, so there are several sources with weights that sum to 1; distances run along the
/// surface, so the upper lip does not pull the lower.
#[derive(Debug, Clone, PartialEq)]
pub struct Surround {
    /// The vertices that follow, increasing; none of the support.
    pub targets: Vec<u32>,
    /// Distance of each target from the region along the undeformed surface, mm.
    pub distances: Vec<f32>,
    /// How many sources a target has.
    pub sources_each: usize,
    /// `sources_each` places in the support (not vertex numbers) a target.
    pub sources: Vec<u32>,
    /// Their weights in units of 1/65535; those of a target sum to 65535.
    pub weights: Vec<u16>,
}

/// Where the fall-off reaches zero, in units of alpha.
pub const FALLOFF_REACH: f32 = 3.0;

/// The fall-off of blending at `t` = distance / alpha: (1 - r)^4 (4 r + 1) with r = t / 3, and 0
/// from r = 1 on (Wendland 1995).
///
/// Eq. 12 has exp(-t), whose slope of -1/alpha at the border is itself a crease, and which never
/// ends. This one starts without slope and ends smoothly at 3 alpha, so that what is farther away
/// never moves; the area under the two is the same, so alpha means the same.
pub fn falloff(t: f32) -> f32 {
    let r = (t / FALLOFF_REACH).min(1.0);
    (1.0 - r).powi(4) * (4.0 * r + 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_fall_off_is_flat_at_both_ends_and_has_the_area_of_exp() {
        assert_eq!(falloff(0.0), 1.0);
        assert_eq!(falloff(3.0), 0.0);
        assert_eq!(falloff(50.0), 0.0);
        // Slopes by differences of 0.001: second order in it, so below 0.01.
        assert!((falloff(0.001) - 1.0).abs() < 1e-5);
        assert!(falloff(2.999) < 1e-5);
        let area: f32 = (0..3000)
            .map(|i| falloff((i as f32 + 0.5) / 1000.0) / 1000.0)
            .sum();
        assert!((area - 1.0).abs() < 1e-3, "{area}");
    }
}
