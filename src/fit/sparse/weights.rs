//! The weights' step: block coordinate descent in Gram form.

/// What the weights need to know of the components C (K x 3n) and the samples X (F x 3n), and the
/// objective is made of. Matrices are column-major.
#[derive(Debug, Clone)]
pub(super) struct Moments {
    /// Faces.
    pub f: usize,
    /// Components.
    pub k: usize,
    /// C C', K x K.
    pub outer: Vec<f64>,
    /// X C', F x K.
    pub cross: Vec<f64>,
    /// The penalty of each component, K.
    pub penalty: Vec<f64>,
}

impl Moments {
    /// Nothing yet.
    pub fn new(f: usize, k: usize) -> Self {
        Self {
            f,
            k,
            outer: vec![0.0; k * k],
            cross: vec![0.0; f * k],
            penalty: vec![0.0; k],
        }
    }

    /// `||X - W C||^2 + Omega(C)` from `||X||^2` and the weights, F x K.
    pub fn objective(&self, square: f64, weights: &[f64]) -> f64 {
        let mut fit = square;
        for (w, c) in weights.iter().zip(&self.cross) {
            fit -= 2.0 * w * c;
        }
        for l in 0..self.k {
            for k in 0..self.k {
                let gram: f64 = column(weights, self.f, k)
                    .iter()
                    .zip(column(weights, self.f, l))
                    .map(|(a, b)| a * b)
                    .sum();
                fit += gram * self.outer[l * self.k + k];
            }
        }
        fit + self.penalty.iter().sum::<f64>()
    }

    /// A component becomes `t` times as large.
    fn scale(&mut self, k: usize, t: f64) {
        for l in 0..self.k {
            self.outer[l * self.k + k] *= t;
            self.outer[k * self.k + l] *= t;
        }
        self.cross[k * self.f..(k + 1) * self.f]
            .iter_mut()
            .for_each(|c| *c *= t);
        self.penalty[k] *= t;
    }
}

fn column(matrix: &[f64], rows: usize, k: usize) -> &[f64] {
    &matrix[k * rows..(k + 1) * rows]
}

/// Improves the weights W (F x K) one component after another, under max_f |W_fk| = 1, and returns
/// by how much each component was stretched on the way; `moments` follow.
///
/// With the other components held, the cost of weights w and a component that is stretched by t is
/// `|c_k|^2 ||t w - o||^2 + t P_k` but for a constant, where o are the unconstrained weights and P_k
/// is the component's penalty. Under `|w_f| <= 1` the best weights are o clipped to [-t, t] and
/// divided by t, and what remains is convex in t alone: [`level`]. So the step is the exact minimum
/// over the weights and the size of a component at once, and the objective cannot rise. (The
/// authors' code divides o by its largest entry and leaves the component as it is, which can raise
/// it.)
pub(super) fn update(weights: &mut [f64], moments: &mut Moments, sweeps: usize) -> Vec<f64> {
    let (f, count) = (moments.f, moments.k);
    let mut stretched = vec![1.0; count];
    let mut best = vec![0.0; f];
    for _ in 0..sweeps {
        for k in 0..count {
            let square = moments.outer[k * count + k];
            if square <= 0.0 {
                continue;
            }
            best.copy_from_slice(column(&moments.cross, f, k));
            for l in (0..count).filter(|&l| l != k) {
                let product = moments.outer[k * count + l];
                if product != 0.0 {
                    let other = column(weights, f, l);
                    best.iter_mut()
                        .zip(other)
                        .for_each(|(b, w)| *b -= product * w);
                }
            }
            best.iter_mut().for_each(|b| *b /= square);
            let t = level(&best, square, moments.penalty[k]);
            moments.scale(k, t);
            stretched[k] *= t;
            // A component that is not worth its penalty goes; its weights wait for a better one.
            if t > 0.0 {
                let own = &mut weights[k * f..(k + 1) * f];
                own.iter_mut()
                    .zip(&best)
                    .for_each(|(w, b)| *w = b.clamp(-t, t) / t);
            }
        }
    }
    stretched
}

/// The weights `to + stride (to - from)`, each component's divided by the largest.
pub(super) fn farther(to: &[f64], from: &[f64], f: usize, stride: f64) -> Vec<f64> {
    let mut farther: Vec<f64> = to
        .iter()
        .zip(from)
        .map(|(to, from)| to + stride * (to - from))
        .collect();
    for column in farther.chunks_exact_mut(f) {
        let largest = column.iter().fold(0.0_f64, |m, w| m.max(w.abs()));
        if largest > 0.0 {
            column.iter_mut().for_each(|w| *w /= largest);
        }
    }
    farther
}

/// The t that minimises `square * sum_f max(|o_f| - t, 0)^2 + t * penalty`: the largest |o_f| where
/// nothing is penalised, and 0 where the penalty outweighs everything.
fn level(o: &[f64], square: f64, penalty: f64) -> f64 {
    let mut sizes: Vec<f64> = o.iter().map(|x| x.abs()).collect();
    sizes.sort_by(|a, b| b.total_cmp(a));
    // What rises above t sums up to this where the derivative is nought. The sum above t is the
    // largest over m of what the m largest entries have above t, so t is the largest below.
    let above = penalty / (2.0 * square);
    let mut sum = -above;
    let mut best = 0.0_f64;
    for (count, size) in sizes.iter().enumerate() {
        sum += size;
        best = best.max(sum / (count + 1) as f64);
    }
    best
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_level_is_the_least_of_its_cost() {
        let o = [0.3, -1.4, 0.9, 1.2, -0.1];
        for (square, penalty) in [(1.0, 0.0), (2.0, 0.1), (1.0, 1.0), (0.5, 2.0), (1.0, 50.0)] {
            let cost = |t: f64| {
                let over: f64 = o.iter().map(|x: &f64| (x.abs() - t).max(0.0).powi(2)).sum();
                square * over + t * penalty
            };
            let t = level(&o, square, penalty);
            for other in (0..=2000).map(|i| f64::from(i) / 1000.0) {
                assert!(cost(t) <= cost(other) + 1e-12, "{t} {other}");
            }
        }
        assert_eq!(level(&o, 1.0, 0.0), 1.4);
        assert_eq!(level(&o, 1.0, 50.0), 0.0);
    }
}
