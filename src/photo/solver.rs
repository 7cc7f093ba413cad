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
/// The standard deviations of a jaw point that is hidden, across the outline that it stands for and
/// along it, in those of the other points. What level of the cheek somebody marks for it is a guess.
const HIDDEN: [f64; 2] = [4.0 / 3.0, 12.0];
/// The standard deviation along the outline of jaw points that are seen, before anything is known, in
/// those of the other points: 12 px where they have 1.5. Taking them at 1.5 px is worse than leaving
/// them out, when they were marked anywhere along it.
const ALONG: f64 = 8.0;
/// How much that counts against what the residuals say, as so many of them: detectors that keep to
/// the jaw's own points should be believed.
const ALONG_COUNT: f64 = 0.5;
/// Points are distributed as Student's t with so many degrees of freedom: one that is three standard
/// deviations off counts half.
const FREEDOM: f64 = 8.0;
/// The prior of an expression's weight e >= 0 is proportional to (1 + e / b)^(-a b), a generalized Pareto
/// distribution (Armagan, Dunson & Lee 2013, "Generalized double Pareto shrinkage", of which this is the
/// positive half): most expressions are not shown, those that are may be shown wholly. These are a and b.
/// A half-normal one turns on sixteen of them on faces at rest, this one on one; an exponential one (b
/// without limit) that turns on as few shrinks what is shown (40 people of ICT-FaceKit at rest and 40
/// with expressions).
const EXPRESSION: (f64, f64) = (12.0, 0.3);
/// And it is multiplied by a normal one of this standard deviation: without it one of several expressions
/// that look alike takes all, and the smiles of portraits end at its limit.
const EXPRESSION_WIDTH: f64 = 0.4;
/// By what the prior is multiplied of an expression that the photo speaks against. Up to some ten of this a smile
/// still takes a jaw that opens by a centimetre, from there on it takes none: the prior is not convex.
const AGAINST: f64 = 20.0;
/// The precision of coefficients that are known: next to it a photo's points and people tell nothing.
const EXACTLY: f64 = 1e6;
/// Steps along all of the bounded unknowns, at most.
const SWEEPS: usize = 100;
/// These end when no weight moves by more.
const STILL: f64 = 1e-4;
/// Ten are the rule.
const STEPS: usize = 40;
/// A step is halved so many times before it is taken for none.
const HALVINGS: usize = 8;
/// Steps end when none of the unknowns, in their standard deviations, moves by more.
const SETTLED: f64 = 1e-2;

/// What is given of a face.
pub(super) struct Observed<'a> {
    pub points: &'a Points,
    pub paths: &'a [Vec<usize>],
    /// Where the 68 are, px.
    pub seen: &'a [DVec2],
}

/// What other photos tell of the same face, whatever was its pose there, its expression and its light: half the curvature of
/// their energy along the first coefficients, and half the slope where these are 0. To second order about where they put it.
#[derive(Debug, Clone)]
pub(super) struct Known {
    curvature: DMatrix<f64>,
    slope: DVector<f64>,
}

impl Known {
    /// What several photos tell, each of which knows nothing of the others; `None` of none.
    pub fn all<'a>(each: impl Iterator<Item = &'a Self>) -> Option<Self> {
        each.cloned().reduce(|a, b| {
            // Points tell of the first coefficients, pixels of all.
            let (mut sum, less) = match a.slope.len() < b.slope.len() {
                true => (b, a),
                false => (a, b),
            };
            let count = less.slope.len();
            let mut curvature = sum.curvature.view_mut((0, 0), (count, count));
            curvature += less.curvature;
            let mut slope = sum.slope.rows_mut(0, count);
            slope += less.slope;
            sum
        })
    }

    /// That they are these.
    pub fn exactly(z: &[f64]) -> Self {
        Self {
            curvature: DMatrix::identity(z.len(), z.len()) * EXACTLY,
            slope: DVector::from_column_slice(z) * -EXACTLY,
        }
    }

    /// What that is of the first coefficients, `count` of them, when the rest is as it is in people; `None` when it is nothing.
    pub fn of_first(&self, count: usize) -> Option<Self> {
        let rest = self.slope.len().saturating_sub(count);
        if rest == 0 {
            return Some(self.clone());
        }
        let own = self.curvature.view((count, count), (rest, rest));
        let factor = (own + DMatrix::identity(rest, rest)).cholesky()?;
        let mut across = self.curvature.view((count, 0), (rest, count)).into_owned();
        let mut slope = self.slope.rows(count, rest).into_owned();
        factor.l_dirty().solve_lower_triangular_mut(&mut across);
        factor.l_dirty().solve_lower_triangular_mut(&mut slope);
        Some(Self {
            curvature: self.curvature.view((0, 0), (count, count)) - across.tr_mul(&across),
            slope: self.slope.rows(0, count) - across.tr_mul(&slope),
        })
    }

    /// Half the gradient at some coefficients.
    fn gradient(&self, z: &[f64]) -> DVector<f64> {
        &self.curvature * DVector::from_column_slice(&z[..self.slope.len()]) + &self.slope
    }

    /// The energy, 0 at 0.
    fn energy(&self, z: &[f64]) -> f64 {
        let z = DVector::from_column_slice(&z[..self.slope.len()]);
        z.dot(&(&self.curvature * &z)) + 2.0 * self.slope.dot(&z)
    }
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
    /// That of the jaw's points across the outline, px; as that of the others when it is not known.
    pub jaw: Option<f64>,
    /// About how large a mm is at the face, px.
    pub scale: f64,
    /// An expression that the photo speaks against, and how much: 0 is not at all, 1 as much as can be.
    pub against: Option<(usize, f64)>,
    /// What other photos tell.
    pub known: Option<Known>,
    /// Expressions whose weights are known, increasing, and these.
    pub held: Vec<(usize, f64)>,
}

/// Where the solver stands.
#[derive(Debug, Clone)]
pub(super) struct State {
    pub pose: Pose,
    /// Independent coefficients, then weights of expressions.
    pub unknowns: Vec<f64>,
    /// How many of them the points determine, and the pixels if there are any: n_eff.
    pub determined: f64,
    /// How many more other photos do.
    pub known: f64,
    /// How far points are taken to be off.
    pub noise: Noise,
}

impl State {
    /// How large a mm is at the face, px.
    pub fn scale(&self) -> f64 {
        (self.pose.log_focal - self.pose.log_depth).exp()
    }
}

/// A point that is compared: which it stands for, and the directions of its two residuals.
struct Match {
    point: usize,
    axes: [DVec2; 2],
    /// Whether it is hidden, and stands for another point of its path.
    hidden: bool,
}

/// The standard deviations of points, px.
#[derive(Debug, Clone, Copy)]
pub(super) struct Noise {
    /// Of the points inside of the outline, along each axis.
    inner: f64,
    /// Of the jaw's points that are seen, across the outline.
    across: f64,
    /// And along it.
    along: f64,
}

impl Noise {
    #[cfg(test)]
    pub fn none() -> Self {
        Self {
            inner: 1.0,
            across: 1.0,
            along: 1.0,
        }
    }

    /// Along the axes of the match of a point.
    fn of(&self, point: usize, m: &Match) -> [f64; 2] {
        match (point < JAW, m.hidden) {
            (true, true) => {
                let [across, along] = HIDDEN.map(|noise| noise * self.inner);
                [across.max(self.across), along]
            }
            (true, false) => [self.across, self.along],
            (false, _) => [self.inner; 2],
        }
    }
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
                hidden: *k > 0,
            });
        let inner = (JAW..POINTS).map(|point| Match {
            point,
            axes: [DVec2::X, DVec2::Y],
            hidden: false,
        });
        Some(jaw.chain(inner).collect())
    }

    /// From each of the 68 points as given to where it is, px; `None` when a part is behind the camera.
    pub fn residuals(&self, state: &State) -> Option<Vec<DVec2>> {
        let matches = self.matches(state)?;
        let each = matches.iter().zip(self.seen);
        each.map(|(m, &seen)| Some(self.look(m.point, state)?.at - seen))
            .collect()
    }

    /// Residuals along the axes of the matches, px: two of each point.
    fn off(&self, matches: &[Match], state: &State) -> Option<Vec<[f64; 2]>> {
        let each = matches.iter().zip(self.seen).map(|(m, &seen)| {
            let off = self.look(m.point, state)?.at - seen;
            Some(m.axes.map(|axis| off.dot(axis)))
        });
        each.collect()
    }
}

impl Terms {
    pub fn count(&self) -> usize {
        self.coefficients + self.expressions
    }

    /// Whether an unknown is the weight of an expression that is known.
    fn is_held(&self, unknown: usize) -> bool {
        let expression = unknown.checked_sub(self.coefficients);
        expression.is_some_and(|e| self.held.binary_search_by_key(&e, |held| held.0).is_ok())
    }

    /// By what the prior of an expression is multiplied.
    fn tightness(&self, expression: usize) -> f64 {
        match self.against {
            Some((which, much)) if which == expression => 1.0 + much * (AGAINST - 1.0),
            _ => 1.0,
        }
    }

    /// Half the curvature of an expression's energy that a step takes.
    fn curvature(&self, expression: usize) -> f64 {
        self.tightness(expression) * EXPRESSION_WIDTH.powi(-2)
    }

    /// The energy besides the points, with `determined` for n_eff.
    fn prior(&self, state: &State, determined: f64) -> f64 {
        let (z, e) = state.unknowns.split_at(self.coefficients);
        let square = |all: &[f64]| all.iter().map(|x| x * x).sum::<f64>();
        let focal = (state.pose.log_focal - self.focal.0) / self.focal.1;
        let each = e.iter().enumerate();
        let expressed: f64 = each.map(|(i, &e)| self.tightness(i) * expressed(e).0).sum();
        let known = self.known.as_ref().map_or(0.0, |known| known.energy(z));
        square(z) + known + expressed + focal * focal
            - 2.0 * determined * (state.pose.log_depth - state.pose.log_focal)
    }
}

/// The energy of an expression's weight, and half its slope. It is concave but for
/// [`EXPRESSION_WIDTH`], so that it lies under its tangent: of which each step takes the minimum.
fn expressed(weight: f64) -> (f64, f64) {
    let (rate, scale) = EXPRESSION;
    let slope = weight / (EXPRESSION_WIDTH * EXPRESSION_WIDTH);
    (
        slope * weight + 2.0 * rate * scale * (weight / scale).ln_1p(),
        slope + rate * scale / (scale + weight),
    )
}

/// The weight of a point whose residuals are these, in standard deviations.
fn weight([x, y]: [f64; 2]) -> f64 {
    let square = x * x + y * y;
    (FREEDOM + 2.0) / (FREEDOM + square)
}

/// Half the gradient and half the curvature of the energy (Gauss-Newton's), pose last.
pub(super) struct Normal {
    pub curvature: DMatrix<f64>,
    pub gradient: DVector<f64>,
}

impl Normal {
    fn add(&mut self, other: &Self) {
        self.curvature += &other.curvature;
        self.gradient += &other.gradient;
    }

    /// What is known of expressions and the focal length before they are seen.
    fn add_usual(&mut self, terms: &Terms, state: &State) {
        let first = terms.coefficients;
        for (i, &weight) in state.unknowns.iter().enumerate().skip(first) {
            self.curvature[(i, i)] += terms.curvature(i - first);
            self.gradient[i] += terms.tightness(i - first) * expressed(weight).1;
        }
        let focal = terms.count() + POSE - 1;
        self.curvature[(focal, focal)] += terms.focal.1.powi(-2);
        self.gradient[focal] += (state.pose.log_focal - terms.focal.0) / terms.focal.1.powi(2);
    }

    /// The marginal distribution's share in the size of the head's image, with `determined` for n_eff.
    fn add_size(&mut self, terms: &Terms, determined: f64) {
        self.gradient[terms.count() + 5] -= determined;
        self.gradient[terms.count() + 6] += determined;
    }
}

/// What stays as it is while a step is looked for: which points are compared, and how far each is
/// believed. With that the energy of the points is a sum of squares.
struct Held<'a> {
    observed: &'a Observed<'a>,
    terms: &'a Terms,
    matches: Vec<Match>,
    weights: Vec<f64>,
    noise: Noise,
}

impl<'a> Held<'a> {
    /// As things are in a state; `None` when a part is behind the camera.
    fn new(observed: &'a Observed<'a>, terms: &'a Terms, state: &State) -> Option<Self> {
        let mut held = Self {
            observed,
            terms,
            matches: observed.matches(state)?,
            weights: Vec::new(),
            noise: state.noise,
        };
        let residuals = observed.off(&held.matches, state)?;
        let each = residuals.iter().enumerate();
        held.weights = each.map(|r| weight(held.scaled(r))).collect();
        Some(held)
    }

    /// A point's residuals in their standard deviations.
    fn scaled(&self, (point, r): (usize, &[f64; 2])) -> [f64; 2] {
        let noise = self.noise.of(point, &self.matches[point]);
        [r[0] / noise[0], r[1] / noise[1]]
    }

    /// The energy of points and prior, with `determined` for n_eff, as a sum of squares.
    fn squares(&self, state: &State, determined: f64) -> Option<f64> {
        let residuals = self.observed.off(&self.matches, state)?;
        let each = residuals.iter().enumerate().map(|r| self.scaled(r));
        let squares = each.map(|r| r[0] * r[0] + r[1] * r[1]);
        let points: f64 = squares
            .zip(&self.weights)
            .map(|(square, w)| w * square)
            .sum();
        Some(points + self.terms.prior(state, determined))
    }

    /// The energy itself: it lies under the sum of squares where both are equal in the state of the
    /// weights.
    fn energy(&self, state: &State, determined: f64) -> Option<f64> {
        let residuals = self.observed.off(&self.matches, state)?;
        let each = residuals.iter().enumerate().map(|r| self.scaled(r));
        let points: f64 = each
            .map(|r| (FREEDOM + 2.0) * ((r[0] * r[0] + r[1] * r[1]) / FREEDOM).ln_1p())
            .sum();
        Some(points + self.terms.prior(state, determined))
    }

    /// The points' part of the normal equations.
    fn normal(&self, state: &State) -> Option<Normal> {
        let count = self.terms.count();
        let Self {
            observed,
            matches,
            weights,
            noise,
            ..
        } = self;
        normal(observed, matches, weights, *noise, state, count)
    }
}

/// What is compared besides the points.
pub(super) trait Besides {
    /// Its part of the normal equations.
    fn normal(&self) -> &Normal;
    /// Its energy in the state that those are of, or after a part of a step from there.
    fn energy(&self, step: Option<(&State, &DVector<f64>, f64)>) -> Option<f64>;
}

/// A step from a state with something besides the points: where it leads, and the step itself.
/// It is halved until the energy of all of it falls; `None` when it does not.
pub(super) fn step_with(
    observed: &Observed,
    terms: &Terms,
    state: &State,
    besides: &impl Besides,
    most: f64,
) -> Option<(State, DVector<f64>)> {
    let held = Held::new(observed, terms, state)?;
    let (step, [determined, known]) =
        step(terms, held.normal(state)?, Some(besides.normal()), state)?;
    let longest = step.iter().fold(0.0, |most: f64, s| most.max(s.abs()));
    let mut part = (most / longest).min(1.0);
    let before = held.energy(state, determined)? + besides.energy(None)?;
    (0..HALVINGS).find_map(|_| {
        let mut there = moved(state, &step, part, terms);
        (there.determined, there.known) = (determined, known);
        let own = besides.energy(Some((&there, &step, part)))?;
        let after = held.energy(&there, determined)? + own;
        let found = (after <= before).then(|| (there, &step * part));
        part /= 2.0;
        found
    })
}

/// How far the points are off, as a part of what is expected of them: the energy of the points a
/// residual.
pub(super) fn disagreement(observed: &Observed, state: &State) -> Option<f64> {
    let matches = observed.matches(state)?;
    let residuals = observed.off(&matches, state)?;
    let each = residuals.iter().enumerate().map(|(i, r)| {
        let noise = state.noise.of(i, &matches[i]);
        let square = (r[0] / noise[0]).powi(2) + (r[1] / noise[1]).powi(2);
        (FREEDOM + 2.0) * (1.0 + square / FREEDOM).ln()
    });
    Some(each.sum())
}

/// Minimises the energy from a first pose and the mean face on; `None` when the head ends up behind
/// the camera.
pub(super) fn solve(observed: &Observed, terms: &Terms, pose: Pose) -> Option<State> {
    let usual = NOISE * terms.scale;
    let mut state = State {
        pose,
        unknowns: vec![0.0; terms.count()],
        determined: 0.0,
        known: 0.0,
        noise: Noise {
            inner: terms.noise.unwrap_or(usual),
            across: terms.jaw.or(terms.noise).unwrap_or(usual),
            along: ALONG * terms.noise.unwrap_or(usual),
        },
    };
    for &(expression, weight) in &terms.held {
        state.unknowns[terms.coefficients + expression] = weight;
    }
    for _ in 0..STEPS {
        // With weights, outline and n_eff as they are.
        let held = Held::new(observed, terms, &state)?;
        let (step, [determined, known]) = step(terms, held.normal(&state)?, None, &state)?;
        (state.determined, state.known) = (determined, known);
        let energy = |state: &State| held.squares(state, determined);
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
            let residuals = observed.off(&held.matches, &state)?;
            state.noise = estimated(&residuals, &held.weights, &held.matches, determined, usual);
            if let Some(across) = terms.jaw {
                state.noise.across = across;
            }
        }
        if most < SETTLED {
            break;
        }
    }
    Some(state)
}

/// The standard deviations of the points: their most probable values with the priors, `usual` px for
/// those inside, the fit's freedom taken off.
fn estimated(
    residuals: &[[f64; 2]],
    weights: &[f64],
    matches: &[Match],
    determined: f64,
    usual: f64,
) -> Noise {
    let variance = |prior: f64, weight: f64, square: f64, count: f64| {
        (weight * prior * prior + square) / (weight + count)
    };
    let mut squares = residuals
        .iter()
        .zip(weights)
        .map(|(r, w)| r.map(|r| w * r * r));
    let jaw: f64 = squares
        .by_ref()
        .take(JAW)
        .zip(matches)
        .filter(|s| !s.1.hidden)
        .map(|s| s.0[1])
        .sum();
    let shown = matches[..JAW].iter().filter(|m| !m.hidden).count() as f64;
    let inner: f64 = squares.map(|s| s[0] + s[1]).sum();
    let count = 2.0 * (POINTS - JAW) as f64;
    // The jaw takes its share of the freedom.
    let free = (determined + POSE as f64) * count / (2.0 * POINTS as f64);
    let count = (count - free).max(0.0);
    let inner = variance(usual, NOISE_COUNT, inner, count).sqrt();
    Noise {
        inner,
        across: inner,
        along: variance(ALONG * usual, ALONG_COUNT, jaw, shown).sqrt(),
    }
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

/// What the points tell of the coefficients, and something besides, where the solver has ended: to second order, whatever
/// pose and expression are. `None` when they tell nothing.
pub(super) fn told(
    observed: &Observed,
    terms: &Terms,
    state: &State,
    besides: Option<&Normal>,
) -> Option<Known> {
    let held = Held::new(observed, terms, state)?;
    let mut normal = held.normal(state)?;
    if let Some(other) = besides {
        normal.add(other);
    }
    normal.add_usual(terms, state);
    normal.add_size(terms, state.determined);
    let (first, count) = (terms.coefficients, terms.count());
    let others: Vec<usize> = (first..count)
        .filter(|&i| state.unknowns[i] > 0.0 && !terms.is_held(i))
        .chain(count..count + POSE)
        .collect();
    let rows = normal.curvature.select_rows(&others);
    let factor = rows.select_columns(&others).cholesky()?;
    let mut across = rows.columns(0, first).into_owned();
    let mut pull = normal.gradient.select_rows(&others);
    factor.l_dirty().solve_lower_triangular_mut(&mut across);
    factor.l_dirty().solve_lower_triangular_mut(&mut pull);
    let curvature = normal.curvature.view((0, 0), (first, first)) - across.tr_mul(&across);
    let z = DVector::from_column_slice(&state.unknowns[..first]);
    let gradient = match besides {
        Some(_) => normal.gradient.rows(0, first) - across.tr_mul(&pull),
        // The points' own steps end where all of the energy is least, next to which its gradient is 0: what they pull with
        // is the opposite of the rest. Told so, photos that are fitted in turn settle, also where steps end early.
        None => {
            -(terms.known.as_ref()).map_or_else(|| z.clone(), |k| &z + k.gradient(z.as_slice()))
        }
    };
    let slope = gradient - &curvature * z;
    Some(Known { curvature, slope })
}

/// The Gauss-Newton step with what the points tell and something besides, and how many unknowns they
/// determine, and how many more other photos do.
fn step(
    terms: &Terms,
    points: Normal,
    besides: Option<&Normal>,
    state: &State,
) -> Option<(DVector<f64>, [f64; 2])> {
    let count = terms.count();
    let mut normal = points;
    if let Some(other) = besides {
        normal.add(other);
    }
    if let Some(known) = &terms.known {
        let k = known.slope.len();
        let mut own = normal.curvature.view_mut((0, 0), (k, k));
        own += &known.curvature;
        let mut own = normal.gradient.rows_mut(0, k);
        own += known.gradient(&state.unknowns);
    }
    for i in 0..terms.coefficients {
        normal.curvature[(i, i)] += 1.0;
        normal.gradient[i] += state.unknowns[i];
    }
    normal.add_usual(terms, state);
    // Weights that are 0, or known, have no freedom.
    let free: Vec<usize> = (0..count)
        .filter(|&i| i < terms.coefficients || (state.unknowns[i] > 0.0 && !terms.is_held(i)))
        .collect();
    let own = normal.curvature.select_rows(&free).select_columns(&free);
    let factor = own.cholesky()?;
    let inverse = inverse_diagonal(factor.l_dirty(), free.len());
    let tight = |i: usize| match i < terms.coefficients {
        true => 1.0,
        false => terms.curvature(i - terms.coefficients),
    };
    let left: f64 = free.iter().zip(inverse).map(|(&i, d)| tight(i) * d).sum();
    let known = terms.known.as_ref().map_or(0.0, |known| {
        // The trace of the inverse times what is known.
        let k = known.slope.len();
        let mut columns = DMatrix::zeros(free.len(), k);
        columns.rows_mut(0, k).copy_from(&known.curvature);
        factor.solve_mut(&mut columns);
        (0..k).map(|i| columns[(i, i)]).sum()
    });
    let determined = free.len() as f64 - left - known;
    normal.add_size(terms, determined);
    let bounds: Vec<[f64; 2]> = (terms.coefficients..count)
        .map(|i| match terms.is_held(i) {
            true => [0.0; 2],
            false => [-state.unknowns[i], 1.0 - state.unknowns[i]],
        })
        .collect();
    let step = bounded(&normal, terms.coefficients, &bounds)?;
    Some((step, [determined, known]))
}

/// The step to the minimum of a quadratic energy where some unknowns, from `first` on, keep to bounds.
/// All others are eliminated (Schur's complement); what is left is minimised along one of the bounded
/// unknowns after another.
fn bounded(normal: &Normal, first: usize, bounds: &[[f64; 2]]) -> Option<DVector<f64>> {
    let all = normal.gradient.len();
    let after = first + bounds.len();
    let others: Vec<usize> = (0..first).chain(after..all).collect();
    let rows = normal.curvature.select_rows(&others);
    let factor = rows.select_columns(&others).cholesky()?;
    let lower = factor.l_dirty();
    let mut across = rows.columns(first, bounds.len()).into_owned();
    let mut slope = normal.gradient.select_rows(&others);
    lower.solve_lower_triangular_mut(&mut across);
    lower.solve_lower_triangular_mut(&mut slope);
    let mut curvature = normal
        .curvature
        .view((first, first), (bounds.len(), bounds.len()))
        .into_owned();
    curvature -= across.tr_mul(&across);
    // The gradient where the step stands.
    let mut gradient = normal.gradient.rows(first, bounds.len()) - across.tr_mul(&slope);
    let mut within = vec![0.0; bounds.len()];
    for _ in 0..SWEEPS {
        let mut most: f64 = 0.0;
        for i in 0..bounds.len() {
            let [least, greatest] = bounds[i];
            let next = (within[i] - gradient[i] / curvature[(i, i)]).clamp(least, greatest);
            let by = next - within[i];
            if by != 0.0 {
                gradient.axpy(by, &curvature.column(i), 1.0);
                within[i] = next;
                most = most.max(by.abs());
            }
        }
        if most < STILL {
            break;
        }
    }
    let within = DVector::from_vec(within);
    slope += across * &within;
    lower.tr_solve_lower_triangular_mut(&mut slope);
    let mut step = DVector::zeros(all);
    step.rows_mut(first, bounds.len()).copy_from(&within);
    for (&i, s) in others.iter().zip(slope.iter()) {
        step[i] = -s;
    }
    Some(step)
}

/// The points' part of the normal equations.
fn normal(
    observed: &Observed,
    matches: &[Match],
    weights: &[f64],
    noise: Noise,
    state: &State,
    count: usize,
) -> Option<Normal> {
    let all = count + POSE;
    let mut row = vec![0.0; all];
    let mut curvature = DMatrix::zeros(all, all);
    let mut gradient = DVector::zeros(all);
    for (m, (own, &weight)) in matches.iter().zip(weights).enumerate() {
        let seen = observed.look(own.point, state)?;
        let rates = [0, 1, 2].map(|axis| observed.points.along(own.point, axis));
        for i in 0..2 {
            let along = own.axes[i] * (weight.sqrt() / noise.of(m, own)[i]);
            let [x, y, z] = seen.by_point.map(|d| d.dot(along));
            let rates = rates[0].iter().zip(rates[1]).zip(rates[2]);
            for (entry, ((x_rate, y_rate), z_rate)) in row.iter_mut().zip(rates) {
                *entry = x * x_rate + y * y_rate + z * z_rate;
            }
            for (entry, by_pose) in row[count..].iter_mut().zip(&seen.by_pose) {
                *entry = by_pose.dot(along);
            }
            add_row(
                &row,
                (seen.at - observed.seen[m]).dot(along),
                &mut curvature,
                &mut gradient,
            );
        }
    }
    curvature.fill_upper_triangle_with_lower_triangle();
    Some(Normal {
        curvature,
        gradient,
    })
}

/// Adds a residual's part to the normal equations: of the curvature the lower triangle.
fn add_row(row: &[f64], residual: f64, curvature: &mut DMatrix<f64>, gradient: &mut DVector<f64>) {
    let columns = curvature.as_mut_slice().chunks_exact_mut(row.len());
    for (j, (column, &by)) in columns.zip(row).enumerate() {
        if by != 0.0 {
            for (sum, x) in column[j..].iter_mut().zip(&row[j..]) {
                *sum += by * x;
            }
        }
    }
    for (sum, x) in gradient.iter_mut().zip(row) {
        *sum += x * residual;
    }
}

/// The diagonal of the inverse of the first `count` rows and columns of L L', from the lower
/// triangular L: the squared lengths of the columns of its inverse.
fn inverse_diagonal(lower: &DMatrix<f64>, count: usize) -> Vec<f64> {
    let mut column = vec![0.0; count];
    (0..count)
        .map(|i| {
            column.fill(0.0);
            column[i] = 1.0;
            for j in i..count {
                let own = &lower.column(j);
                let (done, rest) = column.split_at_mut(j + 1);
                done[j] /= own[j];
                let x = done[j];
                for (sum, l) in rest.iter_mut().zip(own.iter().take(count).skip(j + 1)) {
                    *sum -= l * x;
                }
            }
            column[i..].iter().map(|x| x * x).sum()
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_bounded_step_is_the_least_within_bounds() {
        let mut random = crate::Random::new(8);
        for _ in 0..20 {
            let rows = DMatrix::from_fn(9, 14, |_, _| random.normal());
            let normal = Normal {
                curvature: &rows * rows.transpose(),
                gradient: DVector::from_fn(9, |_, _| 4.0 * random.normal()),
            };
            let bounds = [[0.0, 0.5], [-0.1, 0.2], [-0.3, 0.0], [-0.4, 0.6]];
            let step = bounded(&normal, 3, &bounds).expect("is definite");
            let slope = &normal.curvature * &step + &normal.gradient;
            for i in 0..9 {
                let [least, greatest] = match i {
                    3..7 => bounds[i - 3],
                    _ => [f64::NEG_INFINITY, f64::INFINITY],
                };
                assert!((least..=greatest).contains(&step[i]));
                // Sweeps end when weights move by 1e-4, of a curvature of some ten.
                let is_least = match step[i] {
                    s if s == least => slope[i] > -1e-2,
                    s if s == greatest => slope[i] < 1e-2,
                    _ => slope[i].abs() < 1e-2,
                };
                assert!(is_least, "{i}: {} {}", step[i], slope[i]);
            }
        }
    }

    #[test]
    fn the_inverse_is_that_of_the_leading_block() {
        let mut random = crate::Random::new(4);
        let rows = DMatrix::from_fn(6, 9, |_, _| random.normal());
        let mut matrix = DMatrix::zeros(6, 6);
        let mut gradient = DVector::zeros(6);
        for row in rows.column_iter() {
            let row: Vec<f64> = row.iter().copied().collect();
            add_row(&row, 2.0, &mut matrix, &mut gradient);
        }
        matrix.fill_upper_triangle_with_lower_triangle();
        assert!((&matrix - &rows * rows.transpose()).amax() < 1e-12);
        assert!((gradient - 2.0 * rows.column_sum()).amax() < 1e-12);
        let inverse = matrix.view((0, 0), (4, 4)).into_owned().try_inverse();
        let inverse = inverse.expect("is definite").diagonal();
        let factor = matrix.cholesky().expect("is definite");
        let found = inverse_diagonal(factor.l_dirty(), 4);
        assert!(
            inverse
                .iter()
                .zip(found)
                .all(|(a, b)| (a - b).abs() < 1e-9 * a)
        );
    }
}
