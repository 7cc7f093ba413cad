//! Motion that is known in places, everywhere: the smoothest that passes through what is known.
//!
//! Over the cells of a grid the sum of w |d - D|^2 over the cells and of |d_i - d_j|^2 over the pairs
//! of neighbours is least, where D is known as well as the weight w says. Where w is large d is D, where
//! it is 0 d is harmonic, and in between a jump of D is spread over 1 / sqrt(w) cells. Solved by full
//! multigrid (Briggs, Henson & McCormick 2000, "A multigrid tutorial", chapter 3): the work is that of
//! some sweeps over the grid.

/// Numbers of a cell: motion along x and y, and three more that follow them.
pub(super) const CHANNELS: usize = 5;

/// A number a channel.
pub(super) type Cell = [f32; CHANNELS];

/// What is known.
#[derive(Debug, Clone, Default)]
pub(super) struct Known {
    pub columns: usize,
    pub rows: usize,
    /// Of each cell, row by row.
    pub weights: Vec<f32>,
    /// Each already times the cell's weight.
    pub values: Vec<Cell>,
}

/// Sweeps before and after the coarser grids' correction.
const SWEEPS: [usize; 2] = [1, 2];
/// Corrections by the coarser grids on each grid. After one what is left of the error is some fiftieth of
/// what is known, at most, and smooth.
const CYCLES: usize = 1;
/// A grid with fewer cells along an axis has no coarser one: it is solved by so many sweeps.
const COARSEST: usize = 6;
const COARSEST_SWEEPS: usize = 40;

impl Known {
    pub fn new(columns: usize, rows: usize) -> Self {
        Self {
            columns,
            rows,
            weights: vec![0.0; columns * rows],
            values: vec![[0.0; CHANNELS]; columns * rows],
        }
    }

    /// The smoothest numbers that are as known.
    pub fn extend(self) -> Vec<Cell> {
        let mut levels = vec![self];
        while let Some(coarser) = levels.last().and_then(Self::coarser) {
            levels.push(coarser);
        }
        let mut found: Vec<Cell> = Vec::new();
        for level in (0..levels.len()).rev() {
            let here = &levels[level];
            found = match levels.get(level + 1) {
                Some(coarser) => here.finer(&found, coarser),
                None => vec![[0.0; CHANNELS]; here.weights.len()],
            };
            for _ in 0..CYCLES {
                cycle(&levels[level..], &here.values, &mut found);
            }
        }
        found
    }

    /// The same on cells of twice the size. In two dimensions the smoothness of a motion does not depend
    /// on the size of cells; what is known of four counts for the one.
    fn coarser(&self) -> Option<Self> {
        if self.columns.min(self.rows) < COARSEST {
            return None;
        }
        let mut coarser = Self::new(self.columns.div_ceil(2), self.rows.div_ceil(2));
        for (at, weight) in self.weights.iter().enumerate() {
            coarser.weights[self.parent(at, coarser.columns)] += weight;
        }
        coarser.values = self.gather(&self.values, &coarser);
        Some(coarser)
    }

    fn parent(&self, at: usize, columns: usize) -> usize {
        at / self.columns / 2 * columns + at % self.columns / 2
    }

    /// Sums over the cells of each coarser one.
    fn gather(&self, cells: &[Cell], coarser: &Self) -> Vec<Cell> {
        let mut sums = vec![[0.0; CHANNELS]; coarser.weights.len()];
        for (at, cell) in cells.iter().enumerate() {
            let sum = &mut sums[self.parent(at, coarser.columns)];
            for (sum, value) in sum.iter_mut().zip(cell) {
                *sum += value;
            }
        }
        sums
    }

    /// Interpolates between the middles of coarser cells.
    fn finer(&self, cells: &[Cell], coarser: &Self) -> Vec<Cell> {
        // A cell is a quarter of a coarser one away from the middle of its own.
        let beside = |i: usize, most: usize| {
            let own = i / 2;
            let other = match i % 2 {
                0 => own.saturating_sub(1),
                _ => (own + 1).min(most - 1),
            };
            [own, other]
        };
        let mut finer = Vec::with_capacity(self.weights.len());
        for y in 0..self.rows {
            let [near, far] = beside(y, coarser.rows).map(|row| row * coarser.columns);
            for x in 0..self.columns {
                let [left, right] = beside(x, coarser.columns);
                let corners = [near + left, near + right, far + left, far + right];
                let [a, b, c, d] = corners.map(|at| &cells[at]);
                finer.push(std::array::from_fn(|k| {
                    0.5625 * a[k] + 0.1875 * (b[k] + c[k]) + 0.0625 * d[k]
                }));
            }
        }
        finer
    }

    /// One sweep of Gauss and Seidel.
    fn sweep(&self, right: &[Cell], found: &mut [Cell]) {
        for y in 0..self.rows {
            for x in 0..self.columns {
                let at = y * self.columns + x;
                let (sum, count) = self.around(found, at, x, y);
                let scale = 1.0 / (self.weights[at] + count);
                found[at] = std::array::from_fn(|k| (right[at][k] + sum[k]) * scale);
            }
        }
    }

    /// The sum of a cell's neighbours, and how many there are.
    #[inline(always)]
    fn around(&self, cells: &[Cell], at: usize, x: usize, y: usize) -> (Cell, f32) {
        let columns = self.columns;
        let inside = x > 0 && x + 1 < columns && y > 0 && y + 1 < self.rows;
        if inside && let Some(near) = cells.get(at - columns..=at + columns) {
            let [a, b, c, d] = [0, columns - 1, columns + 1, 2 * columns].map(|i| &near[i]);
            return (std::array::from_fn(|k| a[k] + b[k] + c[k] + d[k]), 4.0);
        }
        let beside = [
            (x > 0).then(|| at - 1),
            (x + 1 < columns).then_some(at + 1),
            (y > 0).then(|| at - columns),
            (y + 1 < self.rows).then_some(at + columns),
        ];
        let mut sum = [0.0; CHANNELS];
        let mut count = 0.0;
        for neighbour in beside.into_iter().flatten() {
            for (sum, value) in sum.iter_mut().zip(&cells[neighbour]) {
                *sum += value;
            }
            count += 1.0;
        }
        (sum, count)
    }

    /// What the equations lack.
    fn residual(&self, right: &[Cell], found: &[Cell]) -> Vec<Cell> {
        let mut residual = Vec::with_capacity(found.len());
        for y in 0..self.rows {
            for x in 0..self.columns {
                let at = y * self.columns + x;
                let (sum, count) = self.around(found, at, x, y);
                let own = self.weights[at] + count;
                residual.push(std::array::from_fn(|k| {
                    right[at][k] + sum[k] - own * found[at][k]
                }));
            }
        }
        residual
    }
}

/// A V-cycle on the first of some grids, each of half the resolution of the one before.
fn cycle(levels: &[Known], right: &[Cell], found: &mut [Cell]) {
    let here = &levels[0];
    let Some(coarser) = levels.get(1) else {
        for _ in 0..COARSEST_SWEEPS {
            here.sweep(right, found);
        }
        return;
    };
    for _ in 0..SWEEPS[0] {
        here.sweep(right, found);
    }
    let residual = here.gather(&here.residual(right, found), coarser);
    let mut correction = vec![[0.0; CHANNELS]; residual.len()];
    cycle(&levels[1..], &residual, &mut correction);
    for (found, correction) in found.iter_mut().zip(here.finer(&correction, coarser)) {
        for (found, correction) in found.iter_mut().zip(correction) {
            *found += correction;
        }
    }
    for _ in 0..SWEEPS[1] {
        here.sweep(right, found);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A frame that is held, and what a value in its middle does.
    fn pulled(columns: usize, rows: usize) -> Known {
        let mut known = Known::new(columns, rows);
        for at in 0..columns * rows {
            let (x, y) = (at % columns, at / columns);
            if x == 0 || y == 0 || x + 1 == columns || y + 1 == rows {
                known.weights[at] = 1e3;
            } else if x.abs_diff(columns / 2) < 9 && y.abs_diff(rows / 2) < 7 {
                known.weights[at] = 2.0;
                known.values[at] = [2.0 * 8.0, 2.0 * -3.0, 0.0, 2.0 * 0.1, 2.0];
            }
        }
        known
    }

    #[test]
    fn the_equations_are_solved() {
        for (columns, rows) in [(90, 71), (64, 64), (40, 133)] {
            let known = pulled(columns, rows);
            let found = known.clone().extend();
            // Thousands of sweeps more change it by little, where no grain of the photo shows it.
            let mut settled = found.clone();
            for _ in 0..2000 {
                known.sweep(&known.values, &mut settled);
            }
            let off = found.iter().zip(&settled);
            let off = off.map(|(a, b)| (a[0] - b[0]).abs()).fold(0.0, f32::max);
            assert!(off < 8.0 / 40.0, "{columns} x {rows}: {off}");
        }
    }

    #[test]
    fn nothing_is_larger_than_what_is_known() {
        let found = pulled(90, 71).extend();
        // Harmonic functions have their extremes at the border; the cycles err by little.
        for cell in &found {
            assert!(cell[0] > -0.2 && cell[0] < 8.2 && cell[1] > -3.1 && cell[1] < 0.1);
            assert_eq!(cell[2], 0.0, "what is known as zero is zero");
        }
    }
}
