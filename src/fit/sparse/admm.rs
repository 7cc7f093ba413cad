//! The components' step: ADMM on the group l1/l2 penalty (Neumann et al. 2013, section 4.2; Boyd
//! et al. 2011, section 6.4), in Gram form, one block of vertices after another.
//!
//! With the weights W held, `||X - W C||^2 + Omega(C)` falls apart into one small problem a vertex,
//! which knows the faces only through W'W (K x K) and W'X (K x 3). A block of vertices that fits
//! in cache is taken through all its steps before the next is looked at, and what the weights'
//! step needs (C C', X C') is summed while the block's samples are still at hand: the samples are
//! read from memory once an iteration. Where the penalty is infinite a component is not there at
//! all: vertices that the same components reach are kept together, and only those are solved for.

use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, MatMut, MatRef, Par, Side};
use rayon::prelude::*;

use super::weights::Moments;
use crate::fit::{FitError, FitResult};

/// The penalty parameter of the augmented Lagrangian, in faces: the weights' Gram matrix has a
/// tenth to a third of the number of faces on its diagonal.
const RHO: f64 = 0.1;

/// Over-relaxation (Boyd et al. 2011, section 3.4.3).
const RELAXATION: f64 = 1.6;

/// Rounds of steps at most, where a block's objective would be higher than before.
const ROUNDS: usize = 10;

/// Numbers of samples in a block: with its components they stay within the second-level cache.
const BLOCK: usize = 38_400;

/// Blocks whose sums are kept at once, before they are added up in order.
const AT_ONCE: usize = 32;

/// How accurately the components are solved for.
#[derive(Debug, Clone, Copy)]
pub(super) struct Effort {
    /// Steps at most.
    pub steps: usize,
    /// Primal and dual residual at which a block is done, relative to its components.
    pub tolerance: f64,
}

/// The samples and components, vertices in groups that the same components reach.
pub(super) struct Blocks {
    f: usize,
    k: usize,
    /// F x 3n, column-major, vertices in the order of the blocks.
    samples: Vec<f64>,
    /// The components that each group of vertices has.
    groups: Vec<Vec<usize>>,
    blocks: Vec<Block>,
}

struct Block {
    group: usize,
    /// The first vertex, in the order of the blocks.
    first: usize,
    /// How many vertices.
    count: usize,
    /// The penalty of each component of the group at each vertex, components fast.
    lambda: Vec<f64>,
    /// Components x 3 count, column-major.
    components: Vec<f64>,
    /// Scaled dual variable, as `components`.
    dual: Vec<f64>,
}

/// What a pass came to.
pub(super) struct Passed {
    pub moments: Moments,
    /// Primal and dual residual of the worse kind, relative to the components.
    pub residual: f64,
}

/// What all blocks of a group share.
struct Shared {
    /// F x components.
    weights: Mat<f64>,
    gram: Mat<f64>,
    inverse: Mat<f64>,
}

struct Sums {
    outer: Mat<f64>,
    cross: Mat<f64>,
    penalty: Vec<f64>,
    primal: f64,
    dual: f64,
    size: f64,
}

impl Blocks {
    /// `samples` are F x 3n column-major, in an order of vertices in which those with the same
    /// `reached` (the components with a finite penalty there) follow each other; `components`
    /// are rows of 3n.
    pub fn new(
        f: usize,
        samples: Vec<f64>,
        reached: &[Vec<usize>],
        components: &[Vec<f64>],
    ) -> Self {
        let most = (BLOCK / (3 * f)).max(8);
        let mut groups: Vec<Vec<usize>> = Vec::new();
        let mut blocks = Vec::new();
        let mut first = 0;
        for run in reached.chunk_by(|a, b| a == b) {
            groups.push(run[0].clone());
            let active = &run[0];
            for part in run.chunks(most) {
                let count = part.len();
                let values = (3 * first..3 * (first + count))
                    .flat_map(|column| active.iter().map(move |&k| components[k][column]))
                    .collect();
                blocks.push(Block {
                    group: groups.len() - 1,
                    first,
                    count,
                    lambda: vec![0.0; active.len() * count],
                    components: values,
                    dual: vec![0.0; active.len() * 3 * count],
                });
                first += count;
            }
        }
        Self {
            f,
            k: components.len(),
            samples,
            groups,
            blocks,
        }
    }

    /// The squared length of all samples.
    pub fn square(&self) -> f64 {
        let columns = self.samples.chunks_exact(self.f);
        columns.map(|c| c.iter().map(|x| x * x).sum::<f64>()).sum()
    }

    /// Sets the penalties; `lambda(k, i)` is that of component k at vertex i in the order of the
    /// blocks.
    pub fn penalise(&mut self, lambda: impl Fn(usize, usize) -> f64 + Sync) {
        let groups = &self.groups;
        self.blocks.par_iter_mut().for_each(|block| {
            let active = &groups[block.group];
            for (i, row) in block
                .lambda
                .chunks_exact_mut(active.len().max(1))
                .enumerate()
            {
                for (value, &k) in row.iter_mut().zip(active) {
                    *value = lambda(k, block.first + i);
                }
            }
        });
    }

    /// Makes each component so many times as large.
    pub fn stretch(&mut self, factors: &[f64]) {
        let groups = &self.groups;
        self.blocks.par_iter_mut().for_each(|block| {
            let active = &groups[block.group];
            for column in block.components.chunks_exact_mut(active.len().max(1)) {
                for (value, &k) in column.iter_mut().zip(active) {
                    *value *= factors[k];
                }
            }
        });
    }

    /// Components and duals, to come back to.
    pub fn state(&self) -> Vec<[Vec<f64>; 2]> {
        let of = |block: &Block| [block.components.clone(), block.dual.clone()];
        self.blocks.iter().map(of).collect()
    }

    /// Goes back to a former state.
    pub fn restore(&mut self, state: Vec<[Vec<f64>; 2]>) {
        for (block, [components, dual]) in self.blocks.iter_mut().zip(state) {
            (block.components, block.dual) = (components, dual);
        }
    }

    /// All components, rows of 3n in the order of the blocks.
    pub fn components(&self) -> Vec<Vec<f64>> {
        let columns = self.samples.len() / self.f;
        let mut rows = vec![vec![0.0; columns]; self.k];
        for block in &self.blocks {
            let active = &self.groups[block.group];
            for (at, values) in block
                .components
                .chunks_exact(active.len().max(1))
                .enumerate()
            {
                for (&k, &value) in active.iter().zip(values) {
                    rows[k][3 * block.first + at] = value;
                }
            }
        }
        rows
    }

    /// Solves for the components by at most `effort.steps` steps; with none
    /// it only sums. `weights` are F x K, column-major.
    pub fn pass(&mut self, weights: &[f64], effort: Effort) -> FitResult<Passed> {
        let rho = RHO * self.f as f64;
        let shared: Vec<Shared> = self
            .groups
            .iter()
            .map(|active| Shared::new(weights, self.f, active, rho))
            .collect::<FitResult<_>>()?;
        let mut moments = Moments::new(self.f, self.k);
        let (mut primal, mut dual, mut size) = (0.0, 0.0, 0.0);
        let (f, samples, groups) = (self.f, &self.samples, &self.groups);
        for some in self.blocks.chunks_mut(AT_ONCE) {
            let sums: Vec<Sums> = some
                .par_iter_mut()
                .map(|block| {
                    let range = 3 * f * block.first..3 * f * (block.first + block.count);
                    let x = MatRef::from_column_major_slice(&samples[range], f, 3 * block.count);
                    block.solve(x, &shared[block.group], rho, effort)
                })
                .collect();
            // Sums are added in the order of the blocks, however many threads made them.
            for (block, sums) in some.iter().zip(&sums) {
                let active = &groups[block.group];
                for (j, &l) in active.iter().enumerate() {
                    for (i, &k) in active.iter().enumerate() {
                        moments.outer[l * self.k + k] += sums.outer[(i, j)];
                    }
                    let own = &mut moments.cross[l * f..(l + 1) * f];
                    for (to, from) in own.iter_mut().zip(sums.cross.col(j).iter()) {
                        *to += from;
                    }
                    moments.penalty[l] += sums.penalty[j];
                }
                primal += sums.primal;
                dual += sums.dual;
                size += sums.size;
            }
        }
        Ok(Passed {
            moments,
            residual: (f64::max(primal, dual) / size.max(f64::MIN_POSITIVE)).sqrt(),
        })
    }
}

impl Shared {
    fn new(weights: &[f64], f: usize, active: &[usize], rho: f64) -> FitResult<Self> {
        let count = active.len();
        let weights = Mat::from_fn(f, count, |face, i| weights[active[i] * f + face]);
        let mut gram = Mat::zeros(count, count);
        let transposed = weights.transpose();
        matmul(
            &mut gram,
            Accum::Replace,
            transposed,
            &weights,
            1.0,
            Par::Seq,
        );
        let shifted = Mat::from_fn(count, count, |i, j| {
            2.0 * gram[(i, j)] + if i == j { rho } else { 0.0 }
        });
        let factor = shifted
            .llt(Side::Lower)
            .map_err(|_| FitError::Input("the weights are no numbers: are the faces?".into()))?;
        let inverse = faer::linalg::solvers::DenseSolveCore::inverse(&factor);
        Ok(Self {
            weights,
            gram,
            inverse,
        })
    }
}

impl Block {
    /// Minimises `sum_i <c_i, G c_i> - 2 <c_i, b_i> + sum_k lambda_ki |c_ki|` over the block's
    /// vertices i, b = W'X.
    fn solve(&mut self, x: MatRef<'_, f64>, shared: &Shared, rho: f64, effort: Effort) -> Sums {
        let (rows, columns) = (shared.gram.nrows(), 3 * self.count);
        let mut residual = [0.0; 2];
        if rows > 0 && effort.steps > 0 {
            let mut products = Mat::<f64>::zeros(rows, columns);
            let transposed = shared.weights.transpose();
            matmul(&mut products, Accum::Replace, transposed, x, 1.0, Par::Seq);
            let before = self.objective(&self.components, &products, shared);
            let former = self.components.clone();
            for round in 0.. {
                residual = self.steps(&products, shared, rho, effort);
                let now = self.objective(&self.components, &products, shared);
                if now <= before {
                    break;
                }
                // ADMM does not descend step by step; it has to get below where it began.
                if round + 1 == ROUNDS {
                    self.components = former;
                    break;
                }
            }
        }
        let c = MatRef::from_column_major_slice(&self.components, rows, columns);
        let mut outer = Mat::zeros(rows, rows);
        let mut cross = Mat::zeros(x.nrows(), rows);
        matmul(&mut outer, Accum::Replace, c, c.transpose(), 1.0, Par::Seq);
        matmul(&mut cross, Accum::Replace, x, c.transpose(), 1.0, Par::Seq);
        let mut penalty = vec![0.0; rows];
        self.penalties(&self.components, |k, value| penalty[k] += value);
        Sums {
            outer,
            cross,
            penalty,
            primal: residual[0],
            dual: residual[1],
            size: self.components.iter().map(|c| c * c).sum(),
        }
    }

    /// ADMM; returns the squared primal and dual residual of the last step, in the unit of the
    /// components' square.
    fn steps(
        &mut self,
        products: &Mat<f64>,
        shared: &Shared,
        rho: f64,
        effort: Effort,
    ) -> [f64; 2] {
        let (rows, columns) = (products.nrows(), products.ncols());
        let mut right = vec![0.0; rows * columns];
        let mut free = vec![0.0; rows * columns];
        let mut residual = [0.0; 2];
        for _ in 0..effort.steps {
            for (column, to) in right.chunks_exact_mut(rows).enumerate() {
                let from = rows * column..rows * (column + 1);
                let (z, u) = (&self.components[from.clone()], &self.dual[from]);
                let b = products.col_as_slice(column);
                for i in 0..rows {
                    to[i] = 2.0 * b[i] + rho * (z[i] - u[i]);
                }
            }
            matmul(
                MatMut::from_column_major_slice_mut(&mut free, rows, columns),
                Accum::Replace,
                &shared.inverse,
                MatRef::from_column_major_slice(&right, rows, columns),
                1.0,
                Par::Seq,
            );
            residual = [0.0; 2];
            let mut size = 0.0;
            for i in 0..self.count {
                let at = 3 * rows * i..3 * rows * (i + 1);
                let lambda = &self.lambda[rows * i..rows * (i + 1)];
                let c = &free[at.clone()];
                let (z, u) = (&mut self.components[at.clone()], &mut self.dual[at]);
                let (zx, rest) = z.split_at_mut(rows);
                let (zy, zz) = rest.split_at_mut(rows);
                let (ux, rest) = u.split_at_mut(rows);
                let (uy, uz) = rest.split_at_mut(rows);
                let (cx, cy, cz) = (&c[..rows], &c[rows..2 * rows], &c[2 * rows..]);
                for k in 0..rows {
                    let old = [zx[k], zy[k], zz[k]];
                    let relaxed = |c: f64, old: f64| RELAXATION * c + (1.0 - RELAXATION) * old;
                    let v = [
                        relaxed(cx[k], old[0]) + ux[k],
                        relaxed(cy[k], old[1]) + uy[k],
                        relaxed(cz[k], old[2]) + uz[k],
                    ];
                    let length = (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]).sqrt();
                    // The proximal map of the group's length; nothing over nothing stays nothing.
                    let left = (1.0 - lambda[k] / (rho * length).max(f64::MIN_POSITIVE)).max(0.0);
                    let new = v.map(|v| left * v);
                    for (a, b) in [(cx[k], new[0]), (cy[k], new[1]), (cz[k], new[2])] {
                        residual[0] += (a - b) * (a - b);
                        size += b * b;
                    }
                    for (a, b) in old.iter().zip(&new) {
                        residual[1] += (a - b) * (a - b);
                    }
                    (zx[k], zy[k], zz[k]) = (new[0], new[1], new[2]);
                    (ux[k], uy[k], uz[k]) = (v[0] - new[0], v[1] - new[1], v[2] - new[2]);
                }
            }
            if residual[0].max(residual[1]) <= effort.tolerance * effort.tolerance * size {
                break;
            }
        }
        residual
    }

    fn objective(&self, components: &[f64], products: &Mat<f64>, shared: &Shared) -> f64 {
        let (rows, columns) = (products.nrows(), products.ncols());
        let c = MatRef::from_column_major_slice(components, rows, columns);
        let mut image = Mat::<f64>::zeros(rows, columns);
        matmul(&mut image, Accum::Replace, &shared.gram, c, 1.0, Par::Seq);
        let mut value = 0.0;
        for column in 0..columns {
            let c = &components[rows * column..rows * (column + 1)];
            let (image, b) = (image.col_as_slice(column), products.col_as_slice(column));
            for i in 0..rows {
                value += c[i] * (image[i] - 2.0 * b[i]);
            }
        }
        self.penalties(components, |_, penalty| value += penalty);
        value
    }

    /// The penalty of each group of three numbers, with the component's place in the group of
    /// vertices.
    fn penalties(&self, components: &[f64], mut add: impl FnMut(usize, f64)) {
        let rows = self.lambda.len() / self.count.max(1);
        for i in 0..self.count {
            let c = &components[3 * rows * i..3 * rows * (i + 1)];
            for k in 0..rows {
                let [x, y, z] = [c[k], c[rows + k], c[2 * rows + k]];
                add(
                    k,
                    self.lambda[rows * i + k] * (x * x + y * y + z * z).sqrt(),
                );
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Random;

    /// At the minimum the gradient of the squares is against the pull of each group's penalty, and
    /// no stronger than it where the group is nothing.
    #[test]
    fn components_fulfil_the_conditions_of_the_minimum() {
        let mut random = Random::new(5);
        let (f, k, n) = (12, 5, 40);
        let x: Vec<f64> = (0..f * 3 * n).map(|_| random.normal()).collect();
        let weights: Vec<f64> = (0..f * k).map(|_| 2.0 * random.uniform() - 1.0).collect();
        // Two groups of vertices: the second half lacks the last component.
        let reached: Vec<Vec<usize>> = (0..n)
            .map(|i| (0..if i < n / 2 { k } else { k - 1 }).collect())
            .collect();
        let start = vec![vec![0.0; 3 * n]; k];
        let mut blocks = Blocks::new(f, x.clone(), &reached, &start);
        let lambda = |k: usize, i: usize| ((7 * k + 3 * i) % 10) as f64;
        blocks.penalise(lambda);
        let effort = Effort {
            steps: 5000,
            tolerance: 1e-13,
        };
        let passed = blocks.pass(&weights, effort).unwrap();
        assert!(passed.residual < 1e-12, "{}", passed.residual);
        let c = blocks.components();
        let mut zeros = 0;
        for i in 0..n {
            for &own in &reached[i] {
                let gradient: [f64; 3] = std::array::from_fn(|axis| {
                    let column = 3 * i + axis;
                    (0..f)
                        .map(|face| {
                            let there: f64 =
                                (0..k).map(|l| weights[l * f + face] * c[l][column]).sum();
                            2.0 * weights[own * f + face] * (there - x[column * f + face])
                        })
                        .sum()
                });
                let group: [f64; 3] = std::array::from_fn(|axis| c[own][3 * i + axis]);
                let length = |v: [f64; 3]| v.iter().map(|x| x * x).sum::<f64>().sqrt();
                if length(group) > 0.0 {
                    for (g, c) in gradient.iter().zip(&group) {
                        let pull = lambda(own, i) * c / length(group);
                        assert!((g + pull).abs() < 1e-8, "{g} {pull}");
                    }
                } else {
                    zeros += 1;
                    assert!(length(gradient) <= lambda(own, i) + 1e-8);
                }
            }
            assert!(i < n / 2 || c[k - 1][3 * i..3 * i + 3] == [0.0; 3]);
        }
        // Some groups vanish and some do not, or nothing was tested.
        assert!(zeros > 10 && zeros < 170, "{zeros}");
    }

    #[test]
    fn the_objective_from_sums_is_the_objective() {
        let mut random = Random::new(6);
        let (f, k, n) = (7, 3, 9);
        let x: Vec<f64> = (0..f * 3 * n).map(|_| random.normal()).collect();
        let weights: Vec<f64> = (0..f * k).map(|_| random.normal()).collect();
        let c: Vec<Vec<f64>> = (0..k)
            .map(|_| (0..3 * n).map(|_| random.normal()).collect())
            .collect();
        let reached = vec![(0..k).collect::<Vec<_>>(); n];
        let mut blocks = Blocks::new(f, x.clone(), &reached, &c);
        blocks.penalise(|k, i| (k + i) as f64);
        let none = Effort {
            steps: 0,
            tolerance: 0.0,
        };
        let passed = blocks.pass(&weights, none).unwrap();
        let mut meant = 0.0;
        for column in 0..3 * n {
            for face in 0..f {
                let there: f64 = (0..k).map(|k| weights[k * f + face] * c[k][column]).sum();
                meant += (x[column * f + face] - there).powi(2);
            }
        }
        for (k, row) in c.iter().enumerate() {
            for (i, d) in row.chunks_exact(3).enumerate() {
                meant += (k + i) as f64 * d.iter().map(|x| x * x).sum::<f64>().sqrt();
            }
        }
        let got = passed.moments.objective(blocks.square(), &weights);
        assert!((got - meant).abs() < 1e-9 * meant, "{got} {meant}");
    }
}
