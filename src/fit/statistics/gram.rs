//! Products of tall matrices, the same bits on any number of threads.

use std::ops::Range;

use faer::{Mat, MatRef};
use rayon::prelude::*;

/// Rows a chunk: with 300 columns, 7 MB, of which each thread has one at a time. The split must not
/// depend on the number of threads, since sums would round differently.
const ROWS: usize = 3072;

/// A^T A of the matrix A with `rows` rows, of which `fill` gives any range.
pub fn gram(rows: usize, fill: impl Fn(Range<usize>) -> Mat<f64> + Sync) -> Mat<f64> {
    // faer would split sums by the number of threads.
    faer::set_global_parallelism(faer::Par::Seq);
    let parts: Vec<Mat<f64>> = chunks(rows)
        .into_par_iter()
        .map(|range| {
            let part = fill(range);
            part.transpose() * &part
        })
        .collect();
    let mut parts = parts.into_iter();
    let first = parts
        .next()
        .unwrap_or_else(|| fill(0..0).transpose() * fill(0..0));
    parts.fold(first, |sum, part| sum + part)
}

/// Some rows of the matrix that has the fields as columns.
pub fn columns(fields: &[impl AsRef<[f64]>], rows: Range<usize>) -> Mat<f64> {
    let mut part = Mat::zeros(rows.len(), fields.len());
    for (column, field) in part.col_iter_mut().zip(fields) {
        let some = &field.as_ref()[rows.clone()];
        column.iter_mut().zip(some).for_each(|(to, x)| *to = *x);
    }
    part
}

/// What each of the fields has of each mode: their inner products, a row a mode, a column a field.
pub fn inner(modes: &[impl AsRef<[f64]> + Sync], fields: &[impl AsRef<[f64]> + Sync]) -> Mat<f64> {
    faer::set_global_parallelism(faer::Par::Seq);
    let rows = fields.first().map_or(0, |field| field.as_ref().len());
    let parts: Vec<Mat<f64>> = chunks(rows)
        .into_par_iter()
        .map(|rows| columns(modes, rows.clone()).transpose() * columns(fields, rows))
        .collect();
    let none = Mat::zeros(modes.len(), fields.len());
    parts.into_iter().fold(none, |sum, part| sum + part)
}

/// Sums of modes, one for each column of `amounts`, which has a row a mode.
pub fn sums(modes: &[impl AsRef<[f64]> + Sync], amounts: MatRef<'_, f64>) -> Vec<Vec<f64>> {
    faer::set_global_parallelism(faer::Par::Seq);
    let rows = modes.first().map_or(0, |mode| mode.as_ref().len());
    let mut sums = vec![Vec::with_capacity(rows); amounts.ncols()];
    // Some at a time: all parts together are as large as the sums.
    for some in chunks(rows).chunks(4) {
        let parts: Vec<Mat<f64>> = (some.par_iter())
            .map(|rows| columns(modes, rows.clone()) * amounts)
            .collect();
        for part in &parts {
            for (sum, column) in sums.iter_mut().zip(part.col_iter()) {
                sum.extend(column.iter());
            }
        }
    }
    sums
}

/// The ranges of rows that are worked on at once; each is of whole vertices.
pub fn chunks(rows: usize) -> Vec<Range<usize>> {
    (0..rows.div_ceil(ROWS))
        .map(|i| i * ROWS..((i + 1) * ROWS).min(rows))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn chunks_sum_to_the_whole() {
        let rows = 2 * ROWS + 77;
        let number = |i: usize, j: usize| ((i * 31 + j * 17) % 101) as f64 / 50.0 - 1.0;
        let whole = Mat::from_fn(rows, 5, number);
        let expected = whole.transpose() * &whole;
        let fill = |r: Range<usize>| Mat::from_fn(r.len(), 5, |i, j| number(r.start + i, j));
        let got = gram(rows, fill);
        for i in 0..5 {
            for j in 0..5 {
                // Sums of six thousand numbers below 1, in another order.
                assert!((got[(i, j)] - expected[(i, j)]).abs() < 1e-10);
            }
        }
        assert_eq!(gram(0, |_| Mat::zeros(0, 5))[(4, 4)], 0.0);
    }
}
