//! How the coefficients are distributed over the population.

use crate::model::{Block, Control, LIMIT};
use crate::quantise::CORRELATIONS;

/// Percentiles in steps of 1/64: with the 300 faces of a small population finer steps are noise.
const QUANTILES: usize = 65;
/// Neighbouring table entries differ by at least this many sigmas, so that the table can be
/// inverted.
const QUANTILE_GAP: f64 = 1e-4;

/// One control a mode, called after its block and number, with the distribution of the faces' `coefficients` (a row
/// each): of `odd` modes with those of their mirror images. Of the others an image has the same, which once more would
/// make stairs of the table of few faces.
pub(super) fn controls(blocks: &[Block], coefficients: &[Vec<f64>], odd: &[bool]) -> Vec<Control> {
    let values = |i: usize| -> Vec<f64> {
        let own = coefficients.iter().map(|row| row[i]);
        match odd[i] {
            true => own.clone().chain(own.map(|c| -c)).collect(),
            false => own.collect(),
        }
    };
    let of_block = |block: &Block| {
        let name = block.name.clone();
        block
            .coefficients()
            .enumerate()
            .map(move |(k, i)| (name.clone(), k, i))
            .collect::<Vec<_>>()
    };
    blocks
        .iter()
        .flat_map(of_block)
        .map(|(group, k, i)| Control {
            name: format!("{group} {}", k + 1),
            description: String::new(),
            direction: vec![(i as u32, 1.0)],
            reading: vec![(i as u32, 1.0)],
            measure: None,
            quantiles: quantiles(values(i)),
            limits: [0.0, 1.0],
            group,
        })
        .collect()
}

/// The empirical quantiles at equally spaced percentiles (linear between order statistics), with
/// the limits at both ends and a least gap between neighbours.
pub(crate) fn quantiles(mut values: Vec<f64>) -> Vec<f32> {
    values.sort_by(f64::total_cmp);
    let last = QUANTILES - 1;
    let limit = f64::from(LIMIT);
    let mut table: Vec<f64> = (0..QUANTILES)
        .map(|q| {
            let at = q as f64 / last as f64 * (values.len() - 1) as f64;
            let low = (at as usize).min(values.len() - 2);
            values[low] + (values[low + 1] - values[low]) * (at - low as f64)
        })
        .collect();
    (table[0], table[last]) = (-limit, limit);
    // Inner entries beyond a limit or too close to their neighbours are pressed into order from
    // both ends.
    for q in 1..last {
        table[q] = table[q].max(table[q - 1] + QUANTILE_GAP);
    }
    for q in (1..last).rev() {
        table[q] = table[q].min(table[q + 1] - QUANTILE_GAP);
    }
    table.iter().map(|&q| q as f32).collect()
}

/// The correlation of the coefficients, shrunk towards independence by the amount that minimises
/// the expected error (Schaefer and Strimmer 2005, eq. 10), which also makes it positive definite
/// when there are fewer faces than coefficients.
pub(super) fn correlation(coefficients: &[Vec<f64>]) -> Vec<f32> {
    let f = coefficients.len() as f64;
    let c = coefficients[0].len();
    let column = |i: usize| -> Vec<f64> {
        let values: Vec<f64> = coefficients.iter().map(|row| row[i]).collect();
        let mean = values.iter().sum::<f64>() / f;
        let length = values
            .iter()
            .map(|v| (v - mean).powi(2))
            .sum::<f64>()
            .sqrt();
        values.iter().map(|v| (v - mean) / length).collect()
    };
    let columns: Vec<Vec<f64>> = (0..c).map(column).collect();
    let mut sample = vec![0.0; c * c];
    let (mut noise, mut signal) = (0.0, 0.0);
    for i in 0..c {
        for j in 0..i {
            let r: f64 = columns[i].iter().zip(&columns[j]).map(|(a, b)| a * b).sum();
            sample[i * c + j] = r;
            sample[j * c + i] = r;
            noise += (1.0 - r * r).powi(2) / (f - 1.0);
            signal += r * r;
        }
    }
    // Some shrinkage always stays, so that rounding cannot cost definiteness: it moves an
    // eigenvalue by at most half a step of the grid for each of some hundred coefficients.
    let shrink = (noise / signal.max(1e-12)).clamp(0.01, 1.0);
    (0..c * c)
        .map(|at| {
            if at / c == at % c {
                1.0
            } else {
                CORRELATIONS.nearest(sample[at] * (1.0 - shrink)) as f32
            }
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::Modes;
    use crate::quantise::Quantised;

    #[test]
    fn the_table_of_few_faces_has_no_stairs() {
        let block = Block {
            name: "nose".into(),
            regions: Vec::new(),
            support: Vec::new(),
            modes: Modes::of(&Quantised::new(&[], 1.0), 0),
            sigmas: vec![1.0; 2],
            first_coefficient: 0,
            surround: None,
            local_to: None,
        };
        let rows: Vec<Vec<f64>> = [-1.5, -0.4, 0.1, 0.5, 1.3].map(|c| vec![c, c]).to_vec();
        let [even, odd] = &controls(&[block], &rows, &[false, true])[..] else {
            panic!("two modes");
        };
        // Five faces: sixteen steps from each to the next, of which the least is 0.4 sigmas wide.
        let steps = even.quantiles.windows(2).map(|q| q[1] - q[0]);
        let least = steps.fold(f32::INFINITY, f32::min);
        assert!(least > 0.4 / 16.0 - 1e-5, "{least}");
        assert_eq!(even.quantiles[32], 0.1);
        // What one person has on the left another has on the right.
        let reversed: Vec<f32> = odd.quantiles.iter().rev().map(|q| -q).collect();
        assert_eq!(odd.quantiles, reversed);
    }
}
