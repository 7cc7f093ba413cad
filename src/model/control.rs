//! Controls: what a person moves.

use crate::{Error, Result};

/// A named slider.
///
/// A control has no state. Its value is *read* from the face and put through the quantile table,
/// and moving it adds a multiple of its direction. What is read is a linear function of the
/// coefficients, or, of a semantic control, a measure of the face.
#[derive(Debug, Clone, PartialEq)]
pub struct Control {
    /// Its name, unlike every other.
    pub name: String,
    /// The block it belongs to, for grouping on a page.
    pub group: String,
    /// What it does, in a few words; may be empty.
    pub description: String,
    /// The coefficients that it changes, increasing: `(coefficient, change for one unit of
    /// reading)`.
    pub direction: Vec<(u32, f32)>,
    /// The linear read-out: `(coefficient, weight)`, coefficients increasing. Empty for a semantic
    /// control.
    pub reading: Vec<(u32, f32)>,
    /// What a semantic control reads and sets: an index into the model's measures. Its quantiles
    /// are mm.
    pub measure: Option<u32>,
    /// The read-out at equally spaced percentiles from 0 to 1, strictly increasing: the empirical
    /// distribution over the population, from -3 to +3 standard deviations of it.
    pub quantiles: Vec<f32>,
    /// The percentiles between which a slider of it should stay, 0..=1, increasing. Those of a
    /// semantic control end where the mean face would crumple: no other measure moves with its
    /// own, and people with a mouth so high have a nose that is higher too. Nothing else refuses
    /// what is beyond them.
    pub limits: [f32; 2],
}

impl Control {
    /// The linear read-out's value for a vector of coefficients (sigmas).
    pub fn read(&self, coefficients: &[f32]) -> f32 {
        self.reading
            .iter()
            .map(|&(i, weight)| coefficients[i as usize] * weight)
            .sum()
    }

    /// How far the read-out moves when one unit of the direction is added; never zero.
    pub(crate) fn gain(&self) -> f32 {
        self.direction
            .iter()
            .map(|&(i, change)| {
                let found = self.reading.binary_search_by_key(&i, |r| r.0);
                found.map_or(0.0, |at| change * self.reading[at].1)
            })
            .sum()
    }

    /// The part of the population with a smaller read-out (region morphing, section 7: x = P(a)),
    /// in 0..=1; linear between the table's entries.
    pub fn percentile(&self, reading: f32) -> f32 {
        let table = &self.quantiles;
        let above = table.partition_point(|&q| q <= reading);
        let last = table.len() - 1;
        if above == 0 {
            return 0.0;
        }
        if above > last {
            return 1.0;
        }
        let (low, high) = (table[above - 1], table[above]);
        (above as f32 - 1.0 + (reading - low) / (high - low)) / last as f32
    }

    /// The inverse of [`Control::percentile`].
    ///
    /// # Errors
    /// When `percentile` is not in 0..=1.
    pub fn quantile(&self, percentile: f64) -> Result<f32> {
        if !(0.0..=1.0).contains(&percentile) {
            return Err(Error::Value {
                what: "a percentile",
                wanted: "from 0 to 1".into(),
                got: percentile,
            });
        }
        let last = self.quantiles.len() - 1;
        let at = percentile * last as f64;
        let low = (at as usize).min(last - 1);
        let (from, to) = (self.quantiles[low], self.quantiles[low + 1]);
        Ok(from + (to - from) * (at - low as f64) as f32)
    }

    /// The read-out of the median person.
    pub fn median(&self) -> f32 {
        let last = self.quantiles.len() - 1;
        (self.quantiles[last / 2] + self.quantiles[last.div_ceil(2)]) / 2.0
    }
}
