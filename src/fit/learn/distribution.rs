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

/// The correlation of the coefficients, shrunk towards independence by the amount that minimises the expected error
/// (Schaefer and Strimmer 2005, eq. 10), which also makes it positive definite when there are fewer faces than
/// coefficients.
///
/// `population` has a row a face, and where mirror images count, one an image; `people` is how many these are of, by
/// whom chance goes: an image has nothing of its own. `block_of` tells the block of each coefficient, and `odd` the
/// coefficients of which an image has the opposite.
///
/// The principal components of one block are uncorrelated as they are made, and so are the odd and the even ones by the
/// images. Such pairs are 0, and say nothing of chance.
pub(super) fn correlation(
    population: &[Vec<f64>],
    people: usize,
    block_of: &[usize],
    odd: &[bool],
) -> Vec<f32> {
    let c = block_of.len();
    let (sample, shrink) = shrinkage(population, people, block_of, odd);
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

/// The sample's correlation, 0 where it can be nothing else, and the part of it that goes.
fn shrinkage(
    population: &[Vec<f64>],
    people: usize,
    block_of: &[usize],
    odd: &[bool],
) -> (Vec<f64>, f64) {
    let f = population.len() as f64;
    let c = block_of.len();
    let column = |i: usize| -> Vec<f64> {
        let values: Vec<f64> = population.iter().map(|row| row[i]).collect();
        let mean = values.iter().sum::<f64>() / f;
        let length = values
            .iter()
            .map(|v| (v - mean).powi(2))
            .sum::<f64>()
            .sqrt();
        values.iter().map(|v| (v - mean) / length).collect()
    };
    let columns: Vec<Vec<f64>> = (0..c).map(column).collect();
    let freedom = people.saturating_sub(1) as f64;
    let mut sample = vec![0.0; c * c];
    let (mut noise, mut signal) = (0.0, 0.0);
    for i in 0..c {
        for j in 0..i {
            if block_of[i] == block_of[j] || odd[i] != odd[j] {
                continue;
            }
            let r: f64 = columns[i].iter().zip(&columns[j]).map(|(a, b)| a * b).sum();
            sample[i * c + j] = r;
            sample[j * c + i] = r;
            noise += (1.0 - r * r).powi(2) / freedom;
            signal += r * r;
        }
    }
    // Some shrinkage always stays, so that rounding cannot cost definiteness: it moves an
    // eigenvalue by at most half a step of the grid for each of some hundred coefficients.
    (sample, (noise / signal.max(1e-12)).clamp(0.01, 1.0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Random;
    use crate::fit::statistics::pca::Spectrum;
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

    /// Two modes of each of two blocks, the second one odd, as faces that were drawn at random have them: between the
    /// blocks the even ones are correlated by 0.5, and the odd ones by 0.3.
    fn drawn(random: &mut Random, people: usize) -> Vec<Vec<f64>> {
        let one = |_| {
            let mut pair = |r: f64| {
                let (a, b) = (random.normal(), random.normal());
                [a, r * a + (1.0 - r * r).sqrt() * b]
            };
            let ([even, other_even], [odd, other_odd]) = (pair(0.5), pair(0.3));
            vec![even, odd, other_even, other_odd]
        };
        (0..people).map(one).collect()
    }

    const BLOCK_OF: [usize; 4] = [0, 0, 1, 1];
    const ODD: [bool; 4] = [false, true, false, true];

    fn with_images(people: &[Vec<f64>]) -> Vec<Vec<f64>> {
        let images = people.iter().map(|row| {
            let each = row.iter().zip(ODD);
            each.map(|(&x, odd)| if odd { -x } else { x }).collect()
        });
        people.iter().cloned().chain(images).collect()
    }

    /// The shrinkage is on average the one by which samples of these people have the least error.
    #[test]
    fn correlations_are_shrunk_by_what_costs_least() {
        let mut random = Random::new(12);
        let people = 30;
        let truth = [(0, 2, 0.5), (1, 3, 0.3)];
        let (mut both, mut own, mut gone) = (0.0, 0.0, 0.0);
        for _ in 0..10_000 {
            let rows = with_images(&drawn(&mut random, people));
            let (sample, shrink) = shrinkage(&rows, people, &BLOCK_OF, &ODD);
            for (i, j, rho) in truth {
                let r = sample[i * 4 + j];
                both += r * rho;
                own += r * r;
                gone += shrink * r * r;
            }
        }
        // Of the sum of ((1 - s) r - rho)^2 the least is at s = 1 - both / own.
        let (best, said) = (1.0 - both / own, gone / own);
        // Among so many samples the best is known to a twentieth, and what chance is taken to be, of the sample's own
        // correlation, is too much by a tenth. With pairs that are 0 as noise it would be twice as much.
        assert!((said / best - 1.0).abs() < 0.2, "{said} {best}");
    }

    #[test]
    fn images_say_nothing_of_chance_and_what_is_made_uncorrelated_stays_so() {
        let mut random = Random::new(5);
        let rows = drawn(&mut random, 40);
        let (plain, shrink) = shrinkage(&rows, 40, &BLOCK_OF, &ODD);
        let both = with_images(&rows);
        let (mirrored, same) = shrinkage(&both, 40, &BLOCK_OF, &ODD);
        for (i, j) in (0..4).flat_map(|i| (0..4).map(move |j| (i, j))) {
            let (a, b) = (plain[i * 4 + j], mirrored[i * 4 + j]);
            let is_pair = i != j && i % 2 == j % 2;
            assert_eq!(b != 0.0, is_pair);
            // Odd ones are about 0 with images and about their mean without: a fortieth of its square.
            assert!((a - b).abs() < 0.05, "{a} {b}");
        }
        assert!((shrink / same - 1.0).abs() < 0.2, "{shrink} {same}");
        // Twice as many people of the same correlations would be twice as sure.
        let (_, sure) = shrinkage(&both, 79, &BLOCK_OF, &ODD);
        assert!((sure / same - 0.5).abs() < 1e-12);
        let whole = correlation(&both, 40, &BLOCK_OF, &ODD);
        assert!((0..4).all(|i| whole[5 * i] == 1.0 && whole[i] == whole[4 * i]));
        assert_eq!(whole[1], 0.0);
    }

    /// What is left out is nothing in what principal components are, whose odd ones and even ones are told apart.
    #[test]
    fn pairs_that_are_left_out_are_nothing_but_rounding() {
        let mut random = Random::new(3);
        let mirror = [1, 0, 3, 2, 4];
        let mut block = || {
            let rows: Vec<Vec<f64>> = (0..20)
                .map(|_| (0..15).map(|_| random.normal()).collect())
                .collect();
            let spectrum = Spectrum::of_both_sides(rows, mirror.to_vec()).unwrap();
            spectrum.truncate(6)
        };
        let (a, b) = (block(), block());
        let odd = [&a.odd[..], &b.odd].concat();
        let own = (a.coefficients.iter().zip(&b.coefficients)).map(|(a, b)| [&a[..], b].concat());
        let own: Vec<Vec<f64>> = own.collect();
        let images = own.iter().map(|row| -> Vec<f64> {
            let each = row.iter().zip(&odd);
            each.map(|(&x, &odd)| if odd { -x } else { x }).collect()
        });
        let both: Vec<Vec<f64>> = own.iter().cloned().chain(images).collect();
        let block_of: Vec<usize> = (0..12).map(|i| i / 6).collect();
        // Each by itself, none odd: as if all pairs counted.
        let each: Vec<usize> = (0..12).collect();
        let (all, _) = shrinkage(&both, 20, &each, &[false; 12]);
        let (some, _) = shrinkage(&both, 20, &block_of, &odd);
        let mut kept = 0;
        for (a, b) in all.iter().zip(&some) {
            // Sums of forty products.
            assert!((a - b).abs() < 1e-9, "{a} {b}");
            kept += usize::from(*b != 0.0);
        }
        assert!(odd.contains(&true) && odd.contains(&false) && kept > 0);
    }
}
