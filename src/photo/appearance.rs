//! What the pixels of a face tell of its shape (E_c).
//!
//! Skin that turns towards the light is brighter, so that brightness tells normals. The surface is
//! compared in *patches*: of each the residual is the area's mean over its samples (vertices) of
//!
//! r = log I(x) - log S(n) - a,
//!
//! with I the photo's brightness in linear light where a sample is seen, S the shading of its normal
//! n (`light`, nine harmonics, times the mean albedo), and a the logarithm of the albedo over its mean
//! (`albedo`). Of logarithms because light and albedo are a product: (I - S a) / S is smaller the
//! brighter the light, so that with hair in the face the light doubles and the albedo halves.
//!
//! Unknown are, besides pose and shape, the light and the modes of the albedo. These are as many as they
//! are because unmodelled albedo decides everything: with the pixels' own noise most fits come out worse
//! than from landmarks alone. Both are eliminated from each Gauss-Newton step (Schur's complement), so
//! that the step is that of the marginal over them; it is halved until the energy of points and pixels
//! falls. Photos differ in how much of them is not of the model: when residuals and albedo together are
//! larger than their variances say, all of the pixels count less by that factor.
//!
//! The residual moves with the shape in two ways: by the normals, and by where in the photo a sample
//! lands. The photo's slope for the latter is that of a larger square than its light, so that the
//! pixels' noise does not make up slopes. What is behind a mask, glasses or hair is not compared (`skin`), and
//! patches that are off are believed less (Student's t): hands and shadows are none of the model's.
//!
//! Colour is left out: of faces under lamps of different colours the three channels together told the
//! shape no better than brightness alone, because what the model cannot say of a shape is wrong
//! in all of them alike.

use std::cell::OnceCell;

use glam::{DVec2, DVec3, Vec3};
use nalgebra::{Cholesky, DMatrix, DVector, Dyn};

use super::camera::POSE;
use super::light::{HARMONICS, Image, Light, harmonics};
use super::pixels::Pixels;
use super::sight::Sight;
use super::solver::{self, Normal, Observed, State, Terms};
use super::surface::{Level, Surface};
use super::{albedo, expression_shown, skin};
use crate::expression::Expression;
use crate::face::Face;
use crate::model::FaceModel;

/// Steps at each level. One more at the first and the last leave the mean error of 24 people as it is.
const STEPS: [usize; 3] = [2, 2, 2];
/// Steps of reweighting for the first light, of the given face and the mean albedo.
const LIGHT_STEPS: usize = 6;
/// Half the side of the square in which a sample's light is, and of that in which the photo's slope
/// there is, mm at the face. Larger squares see nostrils and folds that the sample's normal is not
/// of: with sides of 8 mm fits are worse than from landmarks.
const REACH: [f64; 2] = [0.6, 2.0];
/// The least that a patch is off by, as a part of its light, besides albedo: by what is missing
/// from the model's shapes. The normals of its best fit to a person are 5 degrees off, which under
/// usual lights is this much.
const NOISE: f64 = 0.07;
/// That is for a patch of so many mm^2; what is missing is independent in larger ones.
const NOISE_AREA: f64 = 16.0;
/// What is told counts this part of it. What is missing of the shape lies in larger patches, too. Of 24
/// people some 3 in a hundred come out worse than from landmarks (of 50 others 6); when it counts wholly
/// it is 14, and the mean error is a hundredth larger.
const BELIEF: f64 = 0.45;
/// Patches are distributed as Student's t with so many degrees of freedom.
const FREEDOM: f64 = 4.0;
/// The standard deviations of the light's harmonics of degree 1 and 2, as parts of that of degree 0.
const VARIATION: [f64; 2] = [1.0, 0.5];
/// A shading below this part of the mean counts as that: there, shadows and noise are all.
const DARKEST: f64 = 0.15;
/// Photos of faces that are darker than this part of white, in linear light, tell nothing.
const BLACK: f64 = 1e-3;
/// Nor do faces whose brightness varies (one standard deviation) by less than this part of it: no
/// light makes a face as even as that, a drawing does.
const FLAT: f64 = 0.01;
/// Fewer samples do not tell the light.
const FEWEST: usize = 200;
/// No unknown moves farther in a step, standard deviations.
const LONGEST: f64 = 1.0;
/// What is off by more than this part of its light is no skin: portraits are off by 0.10, a wall by 0.21.
const MOST_OFF: f64 = 0.17;
/// The landmarks still agree when minus twice the logarithm of their probability grows by no more.
/// Of 24 people it grew by at most 22, of 12 with expressions, which fit the points' noise, too, by
/// 16 to 39; it grows by some 60 when the points' errors become a fifth larger than they were.
const AGREEMENT: f64 = 60.0;

/// What is asked of a photo: everything that a step needs.
pub(super) struct Comparison<'a> {
    pub model: &'a FaceModel,
    pub surface: &'a Surface,
    pub observed: &'a Observed<'a>,
    pub terms: &'a Terms,
    /// From independent coefficients to the population's.
    pub basis: &'a DMatrix<f64>,
    pub expressions: &'a [Expression],
}

/// What the pixels made of a face.
pub(super) struct Refined {
    pub state: State,
    /// What the pixels tell there of the unknowns and the pose, whatever light and albedo are; `None` when that was not asked.
    pub told: Option<Normal>,
    /// The root mean square of the residuals that are left, albedo taken off.
    pub rms: f64,
    /// How many patches were seen.
    pub patches: usize,
}

/// A sample that is seen.
struct Look {
    sample: usize,
    normal: DVec3,
    /// How long the sum of its facets is.
    length: f64,
    /// The photo's brightness, and how it changes, a px.
    light: f64,
    slope: DVec2,
    seen: super::camera::Seen,
}

/// The light times the mean albedo, and the weights of the albedo's modes.
struct Skin {
    light: [f64; HARMONICS],
    modes: DVector<f64>,
}

/// Residuals in patches: a column a patch, scaled by its standard deviation.
struct Rows {
    /// The column of each look, and its share of the patch.
    shares: Vec<(usize, f64)>,
    /// The patch of each column, and the variance of its residual.
    patches: Vec<usize>,
    variances: Vec<f64>,
    /// By the light, the coefficients of the population, the expressions that are shown, and the
    /// pose.
    rates: DMatrix<f64>,
    /// By the albedo's modes, but for the sign.
    modes: DMatrix<f64>,
    residuals: DVector<f64>,
    /// The root mean square of the residuals, weighted, unscaled.
    rms: f64,
}

/// What pixels tell of a step: the normal equations without light and albedo, which follow it.
struct Told<'a> {
    comparison: &'a Comparison<'a>,
    level: &'a Level,
    pixels: &'a Pixels,
    looks: &'a [Look],
    positions: &'a [DVec3],
    rows: Rows,
    shown: &'a [usize],
    skin: &'a Skin,
    /// By how much a whole step moves the vertices, once that is asked.
    motion: OnceCell<Vec<DVec3>>,
    /// The mean shading, for the light's prior, and the least that counts.
    mean: f64,
    darkest: f64,
    /// How far pixels are believed: less when they are farther off than was expected.
    trust: f64,
    normal: Normal,
    /// By how much the light moves without a step, and less of it by one.
    light: DVector<f64>,
    by_step: DMatrix<f64>,
    equations: Equations,
}

/// The normal equations of the light and the rest, without the albedo.
struct Equations {
    /// The least sum of squares that the albedo can leave.
    left: f64,
    curvature: DMatrix<f64>,
    gradient: DVector<f64>,
    /// For the albedo: the factor of its own curvature, that across, and its gradient.
    factor: Cholesky<f64, Dyn>,
    across: DMatrix<f64>,
    own: DVector<f64>,
}

impl Skin {
    fn shade(&self, normal: DVec3) -> f64 {
        let harmonics = harmonics(normal).into_iter();
        harmonics.zip(self.light).map(|(h, l)| h * l).sum()
    }

    /// How the shading changes with the normal, along the sphere.
    fn slope(&self, n: DVec3) -> DVec3 {
        let l = self.light;
        let slope = DVec3::new(
            l[1] + l[4] * n.y + l[6] * n.z + 2.0 * l[7] * n.x,
            l[2] + l[4] * n.x + l[5] * n.z - 2.0 * l[7] * n.y,
            l[3] + l[5] * n.y + l[6] * n.x + 6.0 * l[8] * n.z,
        );
        slope - n * slope.dot(n)
    }

    /// The mean shading of what is seen.
    fn mean(&self, looks: &[Look]) -> f64 {
        let all: f64 = looks.iter().map(|look| self.shade(look.normal)).sum();
        all / looks.len() as f64
    }

    fn add(&mut self, step: &[f64]) {
        self.light.iter_mut().zip(step).for_each(|(l, s)| *l += s);
    }
}

/// The logarithm of what is seen over what the shading is, of which none is taken for less than the
/// darkest.
fn ratio(seen: f64, shade: f64, darkest: f64) -> f64 {
    (seen.max(darkest) / shade.max(darkest)).ln()
}

/// The weight of a residual whose square is this, in variances.
fn weight(square: f64) -> f64 {
    (FREEDOM + 1.0) / (FREEDOM + square)
}

/// The precision of each of the light's harmonics where the mean shading is this.
fn precisions(mean: f64) -> impl Iterator<Item = f64> {
    (0..HARMONICS).map(move |h| match h {
        0 => 0.0,
        _ => (VARIATION[usize::from(h > 3)] * mean).powi(-2),
    })
}

impl Comparison<'_> {
    /// The face that points and pixels tell, from the one that the points do; `None` when pixels do
    /// not tell any, or one that the points disagree with. `told` hears which part of the steps is done,
    /// what the points took counts as one. `asked` is whether to say what the pixels tell.
    pub fn refine(
        &self,
        image: &Image,
        start: &State,
        asked: bool,
        told: &mut dyn FnMut(f64),
    ) -> Option<Refined> {
        let all = 1 + STEPS.iter().sum::<usize>();
        let mut done = 1;
        told(done as f64 / all as f64);
        let mut state = start.clone();
        let shown = expression_shown(&state.unknowns[self.terms.coefficients..]);
        let mut pixels = None;
        let mut skin: Option<Skin> = None;
        let mut last = None;
        let hidden = self.hidden(image, &state, &shown);
        for (level, steps) in self.surface.levels.iter().zip(STEPS) {
            let (visible, corners) = self.visible(&state, &shown, hidden.as_deref())?;
            if pixels.is_none() {
                pixels = Pixels::new(image, corners);
            }
            let end = done + steps;
            while done < end {
                let positions = self.positions(&state, &shown);
                let looks = self.looks(pixels.as_ref()?, &state, &visible, &positions);
                if looks.len() < FEWEST {
                    return None;
                }
                let own = match skin.as_mut() {
                    Some(skin) => skin,
                    None => skin.insert(first_light(&looks)?),
                };
                let modes = level.albedo.modes.nrows();
                // Those of a coarse level are the first of a fine one.
                own.modes.resize_vertically_mut(modes, 0.0);
                let pixels = pixels.as_ref()?;
                let known = self.known(level, pixels, (&looks, &positions), own, &shown)?;
                last = Some((known.rows.rms, known.rows.residuals.len()));
                let found = solver::step_with(self.observed, self.terms, &state, &known, LONGEST);
                done = match found {
                    Some((there, step)) => {
                        let after = known.skin(&step);
                        state = there;
                        *own = after;
                        done + 1
                    }
                    // Nothing is better than this at this level.
                    None => end,
                };
                told(done as f64 / all as f64);
            }
        }
        let (rms, patches) = last.filter(|l| l.0 <= MOST_OFF)?;
        let before = solver::disagreement(self.observed, start)?;
        let after = solver::disagreement(self.observed, &state)?;
        if !(after - before <= AGREEMENT) {
            return None;
        }
        let told = match asked {
            true => {
                let level = self.surface.levels.last()?;
                let (visible, _) = self.visible(&state, &shown, hidden.as_deref())?;
                let positions = self.positions(&state, &shown);
                let pixels = pixels.as_ref()?;
                let looks = self.looks(pixels, &state, &visible, &positions);
                let looked = (&looks[..], &positions[..]);
                let known = self.known(level, pixels, looked, skin.as_ref()?, &shown)?;
                Some(known.normal)
            }
            false => None,
        };
        Some(Refined {
            state,
            told,
            rms,
            patches,
        })
    }

    fn coefficients(&self, state: &State) -> Vec<f64> {
        let z = DVector::from_column_slice(&state.unknowns[..self.terms.coefficients]);
        (self.basis * z).iter().copied().collect()
    }

    fn weighted(&self, state: &State, shown: &[usize]) -> Vec<(&Expression, f64)> {
        let weights = &state.unknowns[self.terms.coefficients..];
        let each = shown.iter();
        each.map(|&e| (&self.expressions[e], weights[e])).collect()
    }

    /// Where the surface's vertices are, mm.
    fn positions(&self, state: &State, shown: &[usize]) -> Vec<DVec3> {
        let expressions = self.weighted(state, shown);
        self.surface
            .positions(&self.coefficients(state), &expressions)
    }

    /// Whether a mask, glasses or hair are before each vertex; `None` when nobody knows.
    fn hidden(&self, image: &Image, state: &State, shown: &[usize]) -> Option<Vec<bool>> {
        let (face, places) = self.head(state, shown)?;
        let camera = state.pose.camera();
        let positions: Vec<Vec3> = places.iter().map(|p| p.as_vec3()).collect();
        let normals = face.normals();
        let light = Light::on(self.model, [&positions, normals], &camera, image).ok()?;
        let skin = skin::Skin::new(self.model, &camera, &light, (&places, normals), image).ok()?;
        Some(skin.hidden)
    }

    /// The whole head: the face without expressions, and where its vertices are with them, mm.
    fn head(&self, state: &State, shown: &[usize]) -> Option<(Face, Vec<DVec3>)> {
        let mut face = self.model.face();
        let mut all = vec![0.0_f32; self.model.parts().coefficients()];
        let farthest = f64::from(crate::face::FARTHEST);
        for (to, from) in all.iter_mut().zip(self.coefficients(state)) {
            *to = from.clamp(-farthest, farthest) as f32;
        }
        face.set_coefficients(&all).ok()?;
        let mut positions: Vec<DVec3> = face.positions().iter().map(|p| p.as_dvec3()).collect();
        for (expression, weight) in self.weighted(state, shown) {
            let moved = expression.support.iter().zip(&expression.displacements);
            moved.for_each(|(&v, d)| positions[v as usize] += d.as_dvec3() * weight);
        }
        Some((face, positions))
    }

    /// The samples that are seen, and the corners of the head's part of the image, px.
    fn visible(
        &self,
        state: &State,
        shown: &[usize],
        hidden: Option<&[bool]>,
    ) -> Option<(Vec<usize>, [DVec2; 2])> {
        let (face, positions) = self.head(state, shown)?;
        let triangles = self.model.parts().topology.triangles();
        let seen = Sight::new(&state.pose.camera(), &positions, &triangles)?;
        let surface = self.surface;
        let visible = (0..surface.samples.len()).filter(|&i| {
            let v = surface.vertex(i);
            let is_hidden = hidden.is_some_and(|hidden| hidden[v]);
            !is_hidden && seen.sees(positions[v], face.normals()[v].as_dvec3())
        });
        Some((visible.collect(), seen.corners))
    }

    fn looks(
        &self,
        pixels: &Pixels,
        state: &State,
        visible: &[usize],
        positions: &[DVec3],
    ) -> Vec<Look> {
        let each = visible.iter();
        each.filter_map(|&i| self.look(pixels, state, i, positions))
            .collect()
    }

    fn look(
        &self,
        pixels: &Pixels,
        state: &State,
        sample: usize,
        positions: &[DVec3],
    ) -> Option<Look> {
        let [near, wide] = REACH.map(|reach| reach * state.scale());
        let own = &self.surface.samples[sample];
        let facets = self.surface.facets(own, positions);
        let length = facets.length();
        let seen = state.pose.see(positions[own.own])?;
        Some(Look {
            sample,
            normal: (length > 0.0).then(|| facets / length)?,
            length,
            light: pixels.light(seen.at, near)?,
            slope: pixels.slope(seen.at, wide)?,
            seen,
        })
    }

    fn rows(
        &self,
        level: &Level,
        looks: &[Look],
        positions: &[DVec3],
        skin: &Skin,
        shown: &[usize],
    ) -> Rows {
        let surface = self.surface;
        let area = |look: &Look| surface.samples[look.sample].area;
        let mut areas = vec![0.0; level.albedo.left.len()];
        for look in looks {
            areas[level.patch[look.sample]] += area(look);
        }
        let seen: Vec<usize> = (0..areas.len()).filter(|&p| areas[p] > 0.0).collect();
        let mut column = vec![0; areas.len()];
        seen.iter()
            .zip(0..)
            .for_each(|(&patch, i)| column[patch] = i);
        let modes = level.albedo.modes.select_columns(&seen);
        let albedo = modes.tr_mul(&skin.modes);
        let darkest = DARKEST * skin.mean(looks);
        let population = self.basis.nrows();
        let unknowns = HARMONICS + population + shown.len() + POSE;
        let mut rates = DMatrix::zeros(unknowns, seen.len());
        let mut residuals = DVector::zeros(seen.len());
        let mut shares = Vec::with_capacity(looks.len());
        for look in looks {
            let patch = level.patch[look.sample];
            let i = column[patch];
            let shade = skin.shade(look.normal);
            let scale = area(look) / areas[patch];
            shares.push((i, scale));
            residuals[i] += (ratio(look.light, shade, darkest) - albedo[i]) * scale;
            let [by_shade, by_seen] = [shade, look.light].map(|light| match light > darkest {
                true => scale / light,
                false => 0.0,
            });
            // How that moves with the light, the facets, and the place in the image.
            let mut row = rates.column_mut(i);
            let (by_light, rest) = row.as_mut_slice().split_at_mut(HARMONICS);
            let harmonics = harmonics(look.normal).into_iter();
            by_light
                .iter_mut()
                .zip(harmonics)
                .for_each(|(to, h)| *to -= h * by_shade);
            let by_facets = skin.slope(look.normal) * (-by_shade / look.length);
            let by_place = look.slope * by_seen;
            let sample = &surface.samples[look.sample];
            let (by_shape, by_pose) = rest.split_at_mut(population + shown.len());
            let mut move_with = |place: usize, by: DVec3| {
                let (by_mode, by_expression) = by_shape.split_at_mut(population);
                let by_f32 = by.as_vec3();
                for (to, rate) in by_mode.iter_mut().zip(surface.rates(place)) {
                    *to += f64::from(rate.dot(by_f32));
                }
                for (to, &e) in by_expression.iter_mut().zip(shown) {
                    *to += surface.expressed(place, &self.expressions[e]).dot(by);
                }
            };
            let by_point = look.seen.by_point.map(|d| d.dot(by_place));
            move_with(sample.own, DVec3::from_array(by_point));
            // The sum of p_j x p_j+1 over the ring moves by dp_j x (p_j+1 - p_j-1).
            let count = sample.ring.len();
            for j in 0..count {
                let [before, after] = [count - 1, 1].map(|to| sample.ring[(j + to) % count]);
                let along = positions[after] - positions[before];
                move_with(sample.ring[j], along.cross(by_facets));
            }
            for (to, d) in by_pose.iter_mut().zip(&look.seen.by_pose) {
                *to += d.dot(by_place);
            }
        }
        let mut modes = modes;
        let mut variances = vec![0.0; seen.len()];
        let (mut squares, mut total) = (0.0, 0.0);
        for (i, &patch) in seen.iter().enumerate() {
            let independent = (NOISE_AREA / areas[patch]).max(0.5);
            let variance = NOISE * NOISE * independent + level.albedo.left[patch];
            let square = residuals[i] * residuals[i];
            let weight = weight(square / variance);
            squares += weight * square;
            total += weight;
            let root = (weight * BELIEF / variance).sqrt();
            variances[i] = variance;
            residuals[i] *= root;
            rates.column_mut(i).scale_mut(root);
            modes.column_mut(i).scale_mut(root);
        }
        Rows {
            shares,
            patches: seen,
            variances,
            rates,
            modes,
            residuals,
            rms: (squares / total.max(f64::MIN_POSITIVE)).sqrt(),
        }
    }

    /// The normal equations of the rows: those of the albedo are minus its modes.
    fn equations(&self, rows: &Rows, skin: &Skin, mean: f64, shown: &[usize]) -> Option<Equations> {
        let across = rows.rates.transpose();
        let mut curvature = &rows.rates * &across;
        let mut gradient = &rows.rates * &rows.residuals;
        let mut own = &rows.modes * rows.modes.transpose();
        for i in 0..own.nrows() {
            own[(i, i)] += BELIEF;
        }
        let factor = own.cholesky()?;
        let across = -(&rows.modes * across);
        let own = &skin.modes * BELIEF - &rows.modes * &rows.residuals;
        let mut left = rows.residuals.norm_squared() + BELIEF * skin.modes.norm_squared();
        let (mut half, mut half_own) = (across.clone(), own.clone());
        factor.l_dirty().solve_lower_triangular_mut(&mut half);
        factor.l_dirty().solve_lower_triangular_mut(&mut half_own);
        left -= half_own.norm_squared();
        let half_turned = half.transpose();
        curvature -= &half_turned * half;
        gradient -= half_turned * half_own;
        for (h, precision) in precisions(mean).enumerate() {
            curvature[(h, h)] += precision * BELIEF;
            gradient[h] += precision * BELIEF * skin.light[h];
        }
        let map = self.map(shown);
        let turned = map.transpose();
        Some(Equations {
            left,
            curvature: &turned * (curvature * &map),
            gradient: turned * gradient,
            across: across * map,
            factor,
            own,
        })
    }

    /// From light, unknowns and pose to what the rows have.
    fn map(&self, shown: &[usize]) -> DMatrix<f64> {
        let (population, coefficients) = self.basis.shape();
        let columns = HARMONICS + self.terms.count() + POSE;
        let rows = HARMONICS + population + shown.len() + POSE;
        let mut map = DMatrix::zeros(rows, columns);
        map.view_mut((0, 0), (HARMONICS, HARMONICS))
            .fill_with_identity();
        map.view_mut((HARMONICS, HARMONICS), (population, coefficients))
            .copy_from(self.basis);
        for (i, &e) in shown.iter().enumerate() {
            map[(HARMONICS + population + i, HARMONICS + coefficients + e)] = 1.0;
        }
        let pose = (rows - POSE, columns - POSE);
        map.view_mut(pose, (POSE, POSE)).fill_with_identity();
        map
    }

    /// What looks tell of a step; `None` when they do not tell the light.
    fn known<'a>(
        &'a self,
        level: &'a Level,
        pixels: &'a Pixels,
        (looks, positions): (&'a [Look], &'a [DVec3]),
        skin: &'a Skin,
        shown: &'a [usize],
    ) -> Option<Told<'a>> {
        let rows = self.rows(level, looks, positions, skin, shown);
        let mean = skin.mean(looks);
        let equations = self.equations(&rows, skin, mean, shown)?;
        let rest = equations.gradient.len() - HARMONICS;
        let curvature = &equations.curvature;
        let light = curvature.view((0, 0), (HARMONICS, HARMONICS)).into_owned();
        let light = light.cholesky()?;
        let across = curvature.view((0, HARMONICS), (HARMONICS, rest));
        let by_step = light.solve(&across.into_owned());
        let own = equations.gradient.rows(0, HARMONICS).into_owned();
        let count = rows.residuals.len() as f64;
        let trust = (BELIEF * count / equations.left).min(1.0);
        let curvature =
            curvature.view((HARMONICS, HARMONICS), (rest, rest)) - across.transpose() * &by_step;
        let gradient = equations.gradient.rows(HARMONICS, rest) - by_step.tr_mul(&own);
        let normal = Normal {
            curvature: curvature * trust,
            gradient: gradient * trust,
        };
        Some(Told {
            comparison: self,
            level,
            pixels,
            looks,
            positions,
            rows,
            shown,
            skin,
            motion: OnceCell::new(),
            mean,
            darkest: DARKEST * mean,
            trust,
            normal,
            light: -light.solve(&own),
            by_step,
            equations,
        })
    }
}

impl Told<'_> {
    /// Where the vertices are after a part of a step: they move by as much of its motion.
    fn moved(&self, step: &DVector<f64>, part: f64) -> Vec<DVec3> {
        let motion = self.motion.get_or_init(|| {
            let comparison = self.comparison;
            let count = comparison.terms.coefficients;
            let z = comparison.basis * step.rows(0, count);
            let weights = self.shown.iter();
            let expressions: Vec<(&Expression, f64)> = weights
                .map(|&e| (&comparison.expressions[e], step[count + e]))
                .collect();
            comparison.surface.motion(z.as_slice(), &expressions)
        });
        let each = self.positions.iter().zip(motion);
        each.map(|(p, m)| p + m * part).collect()
    }

    /// Light and albedo after a step.
    fn skin(&self, step: &DVector<f64>) -> Skin {
        let equations = &self.equations;
        let by_light = &self.light - &self.by_step * step;
        let mut all = DVector::zeros(HARMONICS + step.len());
        all.rows_mut(0, HARMONICS).copy_from(&by_light);
        all.rows_mut(HARMONICS, step.len()).copy_from(step);
        let right = &equations.own + &equations.across * all;
        let mut skin = Skin {
            light: self.skin.light,
            modes: &self.skin.modes - equations.factor.solve(&right),
        };
        skin.add(by_light.as_slice());
        skin
    }
}

impl solver::Besides for Told<'_> {
    fn normal(&self) -> &Normal {
        &self.normal
    }

    fn energy(&self, step: Option<(&State, &DVector<f64>, f64)>) -> Option<f64> {
        let own = &self.level.albedo.modes;
        let still = DVector::zeros(self.by_step.ncols());
        let skin = self.skin(&step.map_or(still, |(_, step, part)| step * part));
        let there = step.map(|(there, step, part)| (there, self.moved(step, part)));
        let mut residuals: Vec<f64> = (self.rows.patches.iter())
            .map(|&patch| -own.column(patch).dot(&skin.modes))
            .collect();
        for (look, &(column, share)) in self.looks.iter().zip(&self.rows.shares) {
            // What leaves the image is as it was: to leave is neither better nor worse.
            let after = there.as_ref().and_then(|(state, positions)| {
                let sample = &self.comparison.surface.samples[look.sample];
                let facets = self.comparison.surface.facets(sample, positions);
                let seen = state.pose.see(positions[sample.own])?;
                let light = self.pixels.light(seen.at, REACH[0] * state.scale())?;
                Some((facets.try_normalize()?, light))
            });
            let (normal, light) = after.unwrap_or((look.normal, look.light));
            residuals[column] += ratio(light, skin.shade(normal), self.darkest) * share;
        }
        let patches: f64 = (residuals.iter().zip(&self.rows.variances))
            .map(|(r, variance)| (FREEDOM + 1.0) * (r * r / (FREEDOM * variance)).ln_1p())
            .sum();
        let light: f64 = (precisions(self.mean).zip(skin.light))
            .map(|(precision, l)| precision * l * l)
            .sum();
        Some(self.trust * BELIEF * (patches + skin.modes.norm_squared() + light))
    }
}

/// The light on samples whose albedo is the mean, which a few of them are not.
fn first_light(looks: &[Look]) -> Option<Skin> {
    let mean = looks.iter().map(|look| look.light).sum::<f64>() / looks.len() as f64;
    let squares = looks.iter().map(|look| (look.light - mean).powi(2));
    let spread = (squares.sum::<f64>() / looks.len() as f64).sqrt();
    if !(mean > BLACK && spread > FLAT * mean) {
        return None;
    }
    let mut skin = Skin {
        light: [0.0; HARMONICS],
        modes: DVector::zeros(0),
    };
    skin.light[0] = mean;
    for _ in 0..LIGHT_STEPS {
        let mut square = DMatrix::zeros(HARMONICS, HARMONICS);
        let mut right = DVector::zeros(HARMONICS);
        let darkest = DARKEST * skin.mean(looks);
        for look in looks {
            let row = DVector::from_column_slice(&harmonics(look.normal));
            let shade = skin.shade(look.normal);
            let scale = shade.max(darkest);
            let off = ((look.light - shade) / scale).powi(2) / albedo::variance();
            let weight = weight(off) / (scale * scale);
            square += &row * row.transpose() * weight;
            right += row * (weight * look.light);
        }
        // The large stains of the albedo are a few dozen, however many samples they have.
        let least = albedo::variance() * looks.len() as f64 / 30.0;
        for (h, precision) in precisions(mean).enumerate() {
            square[(h, h)] += precision * least;
        }
        let found = square.cholesky()?.solve(&right);
        skin.light.copy_from_slice(found.as_slice());
    }
    (skin.mean(looks) > BLACK).then_some(skin)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::photo::{Camera, Fitter, SHOWN, camera::Pose};
    use crate::{Expressions, Random};

    fn read(name: &str) -> Vec<u8> {
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/www/public/").to_owned() + name;
        std::fs::read(path).unwrap()
    }

    /// Before a photo whose brightness rises evenly, so that its slope is the same everywhere.
    #[test]
    fn the_derivatives_are_those_of_the_residuals() {
        let model = FaceModel::parse(&read("model.phiz")).unwrap();
        let expressions = Expressions::parse(&read("expressions.phiz"), &model).unwrap();
        let fitter = Fitter::new(&model, Some(&expressions)).unwrap();
        let surface = Surface::new(&model);
        let coefficients = fitter.whole.basis.ncols();
        let terms = Terms {
            coefficients,
            expressions: expressions.list().len(),
            focal: (7.0, 0.3),
            jaw: None,
            noise: None,
            scale: 1.0,
            against: None,
            known: None,
            held: Vec::new(),
        };
        let comparison = Comparison {
            model: &model,
            surface: &surface,
            observed: &fitter.observed(&fitter.whole, &[]),
            terms: &terms,
            basis: &fitter.whole.basis,
            expressions: expressions.list(),
        };
        let mut random = Random::new(5);
        let mut unknowns: Vec<f64> = (0..coefficients).map(|_| 0.5 * random.normal()).collect();
        unknowns.resize(terms.count(), 0.0);
        let smile = coefficients + expressions.find("mouthSmileLeft").unwrap();
        unknowns[smile] = 0.4 + SHOWN;
        let pose = Pose {
            rotation: Camera::turned([0.3, 0.1, -0.1]),
            place: DVec2::new(0.02, 0.01),
            log_depth: 700_f64.ln(),
            // Squares are as wide as two pixels: means of whole ones rise evenly.
            log_focal: (700.0 / REACH[0]).ln(),
            pivot: fitter.pivot,
            centre: DVec2::splat(400.0),
        };
        let state = State {
            pose,
            unknowns,
            determined: 0.0,
            known: 0.0,
            noise: solver::Noise::none(),
        };
        let shown = expression_shown(&state.unknowns[coefficients..]);
        let pixels = Pixels::of(DVec2::ZERO, 1.0, [800, 800], |x, y| {
            0.2 + 1e-3 * x as f64 - 4e-4 * y as f64
        });
        let level = &surface.levels[0];
        let mut skin = Skin {
            light: [0.5, 0.1, 0.2, 0.2, 0.03, -0.04, 0.05, 0.02, 0.03],
            modes: DVector::from_fn(level.albedo.modes.nrows(), |_, _| 0.3 * random.normal()),
        };
        let (visible, _) = comparison.visible(&state, &shown, None).unwrap();
        // What is off in the first place is taken off, as the scale is meant to stand still.
        let look = |state: &State| {
            let positions = comparison.positions(state, &shown);
            let looks = comparison.looks(&pixels, state, &visible, &positions);
            assert_eq!(looks.len(), visible.len());
            (looks, positions)
        };
        let (mut looks, positions) = look(&state);
        let albedo = |i: usize, skin: &Skin| {
            let patch = level.patch[visible[i]];
            level.albedo.modes.column(patch).dot(&skin.modes)
        };
        let off: Vec<f64> = (looks.iter_mut().enumerate())
            .map(|(i, look)| {
                let light = skin.shade(look.normal) * albedo(i, &skin).exp();
                let off = look.light - light;
                look.light = light;
                off
            })
            .collect();
        let rows = comparison.rows(level, &looks, &positions, &skin, &shown);
        assert!(rows.residuals.amax() < 1e-12);
        let slopes = comparison.map(&shown).transpose() * &rows.rates;
        let residuals = |state: &State, skin: &Skin| {
            let (mut looks, positions) = look(state);
            looks
                .iter_mut()
                .zip(&off)
                .for_each(|(look, off)| look.light -= off);
            comparison
                .rows(level, &looks, &positions, skin, &shown)
                .residuals
        };
        let h = 1e-4;
        let check = |row: usize, ahead: DVector<f64>, behind: DVector<f64>| {
            let found = (ahead - behind) / (2.0 * h);
            let told = slopes.row(row).transpose();
            // Rates are f32; the squares of slopes are of no whole pixels.
            let apart = (&found - &told).norm();
            assert!(
                apart < 1e-2 * told.norm() + 1e-6,
                "{row}: {apart} of {}",
                told.norm()
            );
        };
        for k in [0, 1, 5, 20, 60, coefficients - 1, smile] {
            let by = |h: f64| {
                let mut there = state.clone();
                there.unknowns[k] += h;
                residuals(&there, &skin)
            };
            check(HARMONICS + k, by(h), by(-h));
        }
        for k in 0..POSE {
            let by = |h: f64| {
                let mut there = state.clone();
                let mut step = [0.0; POSE];
                step[k] = h;
                there.pose = there.pose.moved(&step);
                residuals(&there, &skin)
            };
            check(HARMONICS + terms.count() + k, by(h), by(-h));
        }
        for k in 0..HARMONICS {
            let mut by = |h: f64| {
                skin.light[k] += h;
                let there = residuals(&state, &skin);
                skin.light[k] -= h;
                there
            };
            check(k, by(h), by(-h));
        }
    }
}
