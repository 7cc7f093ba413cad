//! Gauss-Newton steps on iteratively reweighted least squares.

use glam::{DVec2, DVec3};
use nalgebra::{DMatrix, DVector};

use super::POINTS;
use super::camera::{POSE, Pose, Seen};
use super::contour::{self, JAW};
use super::shape::Points;

/// The standard deviation of a point along each axis, as a length at the face, mm, before anything
/// is known of them: 1.5 px of a face 300 px wide.
const NOISE: f64 = 0.75;
/// How much that counts against what the residuals say: as so many of them (the prior of the
/// variance is inverse gamma).
const NOISE_COUNT: f64 = 40.0;
/// A jaw point's standard deviation across the outline and along it, in those of the other points:
/// 2 px and 12 px where they have 1.5. Taking them at 1.5 px is worse than leaving them out.
const JAW_NOISE: [f64; 2] = [2.0 / 1.5, 12.0 / 1.5];
/// Points are distributed as Student's t with so many degrees of freedom: one that is three standard
/// deviations off counts half.
const FREEDOM: f64 = 8.0;
/// The standard deviation of an expression's weight, of which only the positive half is there.
const EXPRESSION: f64 = 0.3;
/// Ten are the rule.
const STEPS: usize = 40;
/// A step is halved so many times before it is taken for none.
const HALVINGS: usize = 8;
/// Steps end when none of the unknowns, in their standard deviations, moves by more.
const SETTLED: f64 = 3e-3;

/// What is given of a face.
pub(super) struct Observed<'a> {
    pub points: &'a Points,
    pub paths: &'a [Vec<usize>],
    /// Where the 68 are, px.
    pub seen: &'a [DVec2],
}

/// The terms of the energy, besides the points.
pub(super) struct Terms {
    /// How many unknowns are independent coefficients.
    pub coefficients: usize,
    /// How many are weights of expressions, after those.
    pub expressions: usize,
    /// The mean and standard deviation of the logarithm of the focal length in px.
    pub focal: (f64, f64),
    /// The standard deviation of a point along each axis, px, if it is known.
    pub noise: Option<f64>,
    /// About how large a mm is at the face, px.
    pub scale: f64,
}

/// Where the solver stands.
#[derive(Debug, Clone)]
pub(super) struct State {
    pub pose: Pose,
    /// Independent coefficients, then weights of expressions.
    pub unknowns: Vec<f64>,
    /// How many of them the points determine.
    pub determined: f64,
}

/// A point that is compared: which it stands for, and the directions of its two residuals.
struct Match {
    point: usize,
    axes: [DVec2; 2],
    /// The standard deviations along the axes, in that of an inner point.
    noise: [f64; 2],
}

impl Observed<'_> {
    fn place(&self, point: usize, state: &State) -> DVec3 {
        self.points.place(point, &state.unknowns)
    }

    fn look(&self, point: usize, state: &State) -> Option<Seen> {
        state.pose.see(self.place(point, state))
    }

    /// What each of the 68 stands for as things are; `None` when a part is behind the camera.
    fn matches(&self, state: &State) -> Option<Vec<Match>> {
        let at = |point: usize| Some(self.look(point, state)?.at);
        let paths: Option<Vec<Vec<DVec2>>> = (self.paths.iter())
            .map(|path| path.iter().map(|&p| at(p)).collect())
            .collect();
        let outline = contour::outline(&paths?, at(contour::NOSE)?);
        let jaw = outline
            .iter()
            .zip(self.paths)
            .map(|((k, along), path)| Match {
                point: path[*k],
                axes: [along.perp(), *along],
                noise: JAW_NOISE,
            });
        let inner = (JAW..POINTS).map(|point| Match {
            point,
            axes: [DVec2::X, DVec2::Y],
            noise: [1.0; 2],
        });
        Some(jaw.chain(inner).collect())
    }

    /// From each point as given to where it is, px.
    pub fn residuals(&self, state: &State) -> Vec<DVec2> {
        let matches = self.matches(state).unwrap_or_default();
        let each = matches.iter().zip(self.seen).map(|(m, &seen)| {
            let there = self.look(m.point, state);
            there.map_or(DVec2::INFINITY, |there| there.at - seen)
        });
        each.collect()
    }

    /// Residuals in an inner point's standard deviations of 1 px: two of each point.
    fn scaled(&self, matches: &[Match], state: &State) -> Option<Vec<[f64; 2]>> {
        let each = matches.iter().zip(self.seen).map(|(m, &seen)| {
            let off = self.look(m.point, state)?.at - seen;
            Some([0, 1].map(|i| off.dot(m.axes[i]) / m.noise[i]))
        });
        each.collect()
    }
}

impl Terms {
    fn count(&self) -> usize {
        self.coefficients + self.expressions
    }

    /// The energy besides the points, with `determined` for n_eff.
    fn prior(&self, state: &State, determined: f64) -> f64 {
        let (z, e) = state.unknowns.split_at(self.coefficients);
        let square = |all: &[f64]| all.iter().map(|x| x * x).sum::<f64>();
        let focal = (state.pose.log_focal - self.focal.0) / self.focal.1;
        square(z) + square(e) / (EXPRESSION * EXPRESSION) + focal * focal
            - 2.0 * determined * (state.pose.log_depth - state.pose.log_focal)
    }
}

/// The weight of a point whose residuals are these, in standard deviations.
fn weight(residual: &[f64; 2]) -> f64 {
    let square = residual.iter().map(|r| r * r).sum::<f64>();
    (FREEDOM + 2.0) / (FREEDOM + square)
}

/// Half the gradient and half the curvature of the energy (Gauss-Newton's), pose last.
struct Normal {
    curvature: DMatrix<f64>,
    gradient: DVector<f64>,
}

/// Minimises the energy from a first pose and the mean face on; `None` when the head ends up behind
/// the camera.
pub(super) fn solve(observed: &Observed, terms: &Terms, pose: Pose) -> Option<State> {
    let mut state = State {
        pose,
        unknowns: vec![0.0; terms.count()],
        determined: 0.0,
    };
    let mut noise = terms.noise.unwrap_or(NOISE * terms.scale);
    for _ in 0..STEPS {
        let matches = observed.matches(&state)?;
        let residuals = observed.scaled(&matches, &state)?;
        let in_noise = |r: &[f64; 2]| r.map(|r| r / noise);
        let weights: Vec<f64> = residuals.iter().map(|r| weight(&in_noise(r))).collect();
        let (step, determined) = step(observed, terms, &matches, &weights, noise, &state)?;
        state.determined = determined;
        // With weights, outline and n_eff as they are.
        let energy = |state: &State| {
            let residuals = observed.scaled(&matches, state)?;
            let points: f64 = residuals
                .iter()
                .zip(&weights)
                .map(|(r, w)| {
                    let r = in_noise(r);
                    w * (r[0] * r[0] + r[1] * r[1])
                })
                .sum();
            Some(points + terms.prior(state, determined))
        };
        let before = energy(&state)?;
        let mut part = 1.0;
        let better = (0..HALVINGS).find_map(|_| {
            let there = moved(&state, &step, part, terms);
            part /= 2.0;
            (energy(&there)? <= before).then_some(there)
        });
        let Some(there) = better else { break };
        let most = step.iter().fold(0.0, |most: f64, s| most.max(s.abs()));
        state = there;
        if terms.noise.is_none() {
            let residuals = observed.scaled(&matches, &state)?;
            noise = estimated(&residuals, &weights, determined, terms.scale);
        }
        if most < SETTLED {
            break;
        }
    }
    Some(state)
}

/// The standard deviation of the points, px: its most probable value with the prior, the fit's
/// freedom taken off.
fn estimated(residuals: &[[f64; 2]], weights: &[f64], determined: f64, scale: f64) -> f64 {
    let inner = residuals.iter().zip(weights).skip(JAW);
    let square: f64 = inner.map(|(r, w)| w * (r[0] * r[0] + r[1] * r[1])).sum();
    let count = 2.0 * (POINTS - JAW) as f64;
    // The jaw takes its share of the freedom.
    let free = (determined + POSE as f64) * count / (2.0 * POINTS as f64);
    let prior = NOISE_COUNT * (NOISE * scale).powi(2);
    ((prior + square) / (NOISE_COUNT + (count - free).max(0.0))).sqrt()
}

fn moved(state: &State, step: &DVector<f64>, part: f64, terms: &Terms) -> State {
    let count = terms.count();
    let mut there = state.clone();
    for (i, x) in there.unknowns.iter_mut().enumerate() {
        *x += part * step[i];
        if i >= terms.coefficients {
            *x = x.clamp(0.0, 1.0);
        }
    }
    let turn: Vec<f64> = step.rows(count, POSE).iter().map(|s| part * s).collect();
    there.pose = state.pose.moved(&turn);
    there
}

/// The Gauss-Newton step, and how many unknowns the points determine.
fn step(
    observed: &Observed,
    terms: &Terms,
    matches: &[Match],
    weights: &[f64],
    noise: f64,
    state: &State,
) -> Option<(DVector<f64>, f64)> {
    let count = terms.count();
    let mut normal = normal(observed, matches, weights, noise, state, count)?;
    let tight = |i: usize| {
        if i < terms.coefficients {
            1.0
        } else {
            EXPRESSION.powi(-2)
        }
    };
    for i in 0..count {
        normal.curvature[(i, i)] += tight(i);
        normal.gradient[i] += tight(i) * state.unknowns[i];
    }
    let focal = count + POSE - 1;
    normal.curvature[(focal, focal)] += terms.focal.1.powi(-2);
    normal.gradient[focal] += (state.pose.log_focal - terms.focal.0) / terms.focal.1.powi(2);
    // Weights at a bound that the energy pushes them against stay there.
    for i in terms.coefficients..count {
        let (weight, slope) = (state.unknowns[i], normal.gradient[i]);
        if (weight <= 0.0 && slope > 0.0) || (weight >= 1.0 && slope < 0.0) {
            normal.curvature.row_mut(i).fill(0.0);
            normal.curvature.column_mut(i).fill(0.0);
            normal.curvature[(i, i)] = tight(i);
            normal.gradient[i] = 0.0;
        }
    }
    let factor = normal.curvature.cholesky()?;
    // The factor begins with that of the unknowns without the pose.
    let own = factor.l_dirty().view((0, 0), (count, count));
    let mut inverse = DMatrix::identity(count, count);
    own.solve_lower_triangular_mut(&mut inverse);
    let left: f64 = (0..count)
        .map(|i| tight(i) * inverse.column(i).norm_squared())
        .sum();
    let determined = count as f64 - left;
    normal.gradient[count + 5] -= determined;
    normal.gradient[count + 6] += determined;
    let step = factor.solve(&-normal.gradient);
    Some((step, determined))
}

/// The points' part of the normal equations.
fn normal(
    observed: &Observed,
    matches: &[Match],
    weights: &[f64],
    noise: f64,
    state: &State,
    count: usize,
) -> Option<Normal> {
    let all = count + POSE;
    let mut rows = DMatrix::zeros(all, 2 * matches.len());
    let mut off = DVector::zeros(2 * matches.len());
    for (m, (own, &weight)) in matches.iter().zip(weights).enumerate() {
        let seen = observed.look(own.point, state)?;
        let rates = [0, 1, 2].map(|axis| observed.points.along(own.point, axis));
        for i in 0..2 {
            let scale = weight.sqrt() / (own.noise[i] * noise);
            let along = own.axes[i] * scale;
            let [x, y, z] = seen.by_point.map(|d| d.dot(along));
            let mut row = rows.column_mut(2 * m + i);
            for (u, entry) in row.iter_mut().take(count).enumerate() {
                *entry = x * rates[0][u] + y * rates[1][u] + z * rates[2][u];
            }
            for (p, by_pose) in seen.by_pose.iter().enumerate() {
                row[count + p] = by_pose.dot(along);
            }
            off[2 * m + i] = (seen.at - observed.seen[m]).dot(along);
        }
    }
    Some(Normal {
        curvature: &rows * rows.transpose(),
        gradient: rows * off,
    })
}
