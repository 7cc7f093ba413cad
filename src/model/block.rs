//! Blocks: a basis, where it acts, and how it fades.

use super::surround::Surround;
use crate::kernel::Modes;

/// A basis with its vertex support.
///
/// With coefficients c in sigmas, support vertex i moves by
/// `sum_k c_k * modes.displacement(k, i)` mm: the standard deviations are folded into the modes.
#[derive(Debug, Clone, PartialEq)]
pub struct Block {
    /// Its name (`nose`), which is also the group of its controls.
    pub name: String,
    /// The regions that it covers, as indices into the model's regions; empty for all vertices.
    pub regions: Vec<u8>,
    /// The vertices it moves, increasing.
    pub support: Vec<u32>,
    /// The modes: x, y, z a support vertex.
    pub modes: Modes,
    /// The standard deviation of each mode's coefficient in the population: the square root of
    /// the PCA's eigenvalue, mm.
    pub sigmas: Vec<f32>,
    /// The place of its first coefficient in the face's vector.
    pub first_coefficient: usize,
    /// How the vertices around follow; `None` for a block that moves every vertex, and for a local
    /// one, whose modes end by themselves.
    pub surround: Option<Surround>,
    /// A local block holds edits on top of a person: the name of the block whose region they are
    /// part of. Its coefficients are zero for all people of the population. `None` for the blocks
    /// that describe people, which come first.
    pub local_to: Option<String>,
}

impl Block {
    /// The region by which a face locks, blends and resets the block.
    pub fn region(&self) -> &str {
        self.local_to.as_deref().unwrap_or(&self.name)
    }

    /// The block's coefficients in the face's vector.
    pub fn coefficients(&self) -> std::ops::Range<usize> {
        self.first_coefficient..self.first_coefficient + self.sigmas.len()
    }
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
