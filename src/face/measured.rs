//! Measures that are set and held: the coefficients that give a face some lengths.
//!
//! Landmarks move linearly with the coefficients and measures do nearly, so a few steps of Newton's
//! method find them; among all changes that do, the one of least Mahalanobis length is taken, as
//! the population would.

use glam::DVec3;
use nalgebra::DMatrix;

use super::anchor::Anchor;
use super::probable::{product, solve};
use super::{FARTHEST, Face};
use crate::error::Number;
use crate::model::Control;
use crate::quantise::PER_SIGMA;
use crate::{Error, Result};

/// A held measure is off by no more than this, mm. Positions of 100 mm are f32 with a step of
/// 0.000008 mm.
const HELD: f64 = 1e-4;
/// A measure that is set is met to this, mm.
const MET: f64 = 0.01;
/// Measures are so nearly linear that three steps are the rule.
const STEPS: usize = 30;
/// A step that makes things worse is halved so many times before there is no way.
const HALVINGS: usize = 20;

/// What may change to meet a measure.
enum Unknowns {
    /// One number: an amount of a control's direction.
    Along(Control),
    /// These coefficients, as the population would have it.
    Coefficients(Vec<usize>),
}

/// A face as it was.
pub(super) struct Before {
    pub state: Vec<i32>,
    pub held: Vec<(usize, f64)>,
    pub anchors: Vec<Anchor>,
}

/// Landmarks as a linear function of some unknowns.
struct Landmarks(Vec<MovingLandmark>);

struct MovingLandmark {
    index: u32,
    start: DVec3,
    /// How it moves with each unknown.
    rates: Vec<DVec3>,
}

impl Landmarks {
    fn place(&self, landmark: u32, unknowns: &[f64]) -> DVec3 {
        // Whoever asks has named it in [`Face::landmarks`].
        let Some(known) = self.of(landmark) else {
            return DVec3::ZERO;
        };
        let moved = known.rates.iter().zip(unknowns.iter());
        known.start + moved.map(|(rate, y)| *rate * *y).sum::<DVec3>()
    }

    fn of(&self, landmark: u32) -> Option<&MovingLandmark> {
        self.0.iter().find(|l| l.index == landmark)
    }
}

/// Gives a measure a length in a list of those that are wanted, mm, or takes it out.
// Not inlined: the module is downloaded before it runs.
#[inline(never)]
fn want(list: &mut Vec<(usize, f64)>, measure: usize, mm: Option<f64>) {
    list.retain(|wanted| wanted.0 != measure);
    list.extend(mm.map(|mm| (measure, mm)));
}

impl Face {
    /// A measure of the face, mm.
    ///
    /// # Errors
    /// When no measure has that name.
    pub fn measure(&self, name: &str) -> Result<f64> {
        Ok(self.measured(self.measure_index(name)?))
    }

    /// Gives a measure a length in mm, to 0.01 mm. Where a semantic control has that measure it is
    /// moved, however far beyond its limits; otherwise it is the most probable change of the
    /// regions that are not locked.
    ///
    /// # Errors
    /// When no measure has that name, or the face cannot have that length; it then stays as it was.
    pub fn set_measure(&mut self, name: &str, mm: f64) -> Result<()> {
        let measure = self.measure_index(name)?;
        let controls = &self.model.parts().controls;
        let control = controls.iter().find(|c| c.measure == Some(measure as u32));
        match control.cloned() {
            Some(control) => self.set_along(&control, measure, mm),
            None => {
                let free = self.free(None)?;
                let before = self.before();
                self.changed = 0..0;
                // With what is held: brought back afterwards it would take a part of this back.
                let mut wanted = self.held.clone();
                want(&mut wanted, measure, Some(mm));
                self.solve(&wanted, Unknowns::Coefficients(free), MET)?;
                self.keep(measure, &[], before)
            }
        }
    }

    /// Undoes what a control did: its coefficients are those of the median person again, for a
    /// semantic control none. No other control is touched.
    ///
    /// # Errors
    /// When no control has that name, or a held measure cannot be held without it.
    pub fn clear(&mut self, control: &str) -> Result<()> {
        let control = self.model.control(control)?.clone();
        let before = self.before();
        let mut state = self.state.clone();
        for &(i, _) in &control.direction {
            state[i as usize] = self.model.derived.median[i as usize];
        }
        self.replace(state);
        self.hold_beside(&control, before)
    }

    /// Holds a measure where it is, to 0.0001 mm: whatever changes the face, what is free follows
    /// as the population would have it. Setting the measure itself moves it still.
    ///
    /// # Errors
    /// When no measure has that name.
    pub fn lock_measure(&mut self, name: &str) -> Result<()> {
        let measure = self.measure_index(name)?;
        self.hold_measure(measure);
        Ok(())
    }

    pub(super) fn hold_measure(&mut self, measure: usize) {
        let mm = self.measured(measure);
        want(&mut self.held, measure, Some(mm));
    }

    /// Undoes [`Face::lock_measure`].
    ///
    /// # Errors
    /// When no measure has that name.
    pub fn unlock_measure(&mut self, name: &str) -> Result<()> {
        let measure = self.measure_index(name)?;
        want(&mut self.held, measure, None);
        Ok(())
    }

    /// The names of the measures that are held.
    pub fn locked_measures(&self) -> impl Iterator<Item = &str> {
        let measures = &self.model.parts().measures;
        self.held.iter().map(|held| measures[held.0].name.as_str())
    }

    fn measure_index(&self, name: &str) -> Result<usize> {
        let found = (self.model.parts().measures.iter()).position(|m| m.name == name);
        found.ok_or_else(|| Error::Unknown {
            kind: "measure",
            name: name.to_owned(),
        })
    }

    pub(super) fn measured(&self, measure: usize) -> f64 {
        let parts = self.model.parts();
        parts.measures[measure].of(&parts.landmarks, self.positions())
    }

    /// Moves a semantic control until its measure has a length.
    pub(super) fn set_along(&mut self, control: &Control, measure: usize, mm: f64) -> Result<()> {
        let before = self.before();
        self.changed = 0..0;
        self.solve(&[(measure, mm)], Unknowns::Along(control.clone()), MET)?;
        let own: Vec<usize> = control.direction.iter().map(|t| t.0 as usize).collect();
        self.keep(measure, &own, before)
    }

    /// After `measure` was set by moving `own` coefficients: the others that are held are brought
    /// back while it stays as it is now, and from now on if it was held.
    fn keep(&mut self, measure: usize, own: &[usize], before: Before) -> Result<()> {
        let all = self.held.len();
        self.hold_measure(measure);
        let kept = match self.held.len() {
            1 => Ok(()),
            _ => self.hold_without(own, before),
        };
        self.held.truncate(all);
        kept
    }

    /// Brings held measures back after a control was moved, without moving it.
    pub(super) fn hold_beside(&mut self, control: &Control, before: Before) -> Result<()> {
        let own: Vec<usize> = control.direction.iter().map(|t| t.0 as usize).collect();
        self.hold_without(&own, before)
    }

    /// Brings held measures back without touching `own` coefficients: by their semantic controls,
    /// which touch little else, where all have one; else by whatever is not locked. What is locked is moved
    /// by its own alone.
    pub(super) fn hold_without(&mut self, own: &[usize], before: Before) -> Result<()> {
        if self.held.is_empty() {
            return Ok(());
        }
        let parts = self.model.parts();
        let mut free = self.free(None)?;
        let open = self.edits(None)?;
        let is_own = own
            .first()
            .is_some_and(|i| !free.contains(i) && !open.contains(i));
        let control = |held: &(usize, f64)| {
            let mut controls = parts.controls.iter();
            controls.find(|c| c.measure == Some(held.0 as u32))
        };
        let semantic: Option<Vec<&Control>> = self.held.iter().map(control).collect();
        let mut edits: Vec<usize> = Vec::new();
        for &(i, _) in semantic
            .unwrap_or_default()
            .iter()
            .flat_map(|c| &c.direction)
        {
            let i = i as usize;
            if !own.contains(&i) && !edits.contains(&i) && (is_own || open.contains(&i)) {
                edits.push(i);
            }
        }
        free.retain(|i| !own.contains(i));
        self.hold(&[edits, free], before)
    }

    /// Brings held measures back by the first of `choices` of coefficients that can; where nothing may move, they have to be
    /// where they were.
    ///
    /// # Errors
    /// When none can: the face is then as `before`.
    pub(super) fn hold(&mut self, choices: &[Vec<usize>], before: Before) -> Result<()> {
        let held = self.held.clone();
        if held.is_empty() {
            return Ok(());
        }
        let mut failed = Ok(());
        for free in choices {
            failed = self.solve(&held, Unknowns::Coefficients(free.clone()), HELD);
            if failed.is_ok() {
                return Ok(());
            }
        }
        if failed.is_err() {
            self.put_back(before);
        }
        failed
    }

    /// Finds coefficients with which measures have lengths (mm), within a tolerance.
    ///
    /// # Errors
    /// When there are none; the face stays as it was.
    fn solve(&mut self, wanted: &[(usize, f64)], unknowns: Unknowns, tolerance: f64) -> Result<()> {
        let refused = |face: &Face| {
            let measures = &face.model.parts().measures;
            let list = wanted.iter().map(|&(m, mm)| {
                let Some(measure) = measures.get(m) else {
                    return String::new();
                };
                let mm = Number((mm * 100.0).round() / 100.0);
                format!("{} of {mm} mm", measure.name)
            });
            let list: Vec<String> = list.collect();
            Error::Mismatch(format!("this face cannot have a {}", list.join(" and a ")))
        };
        if wanted.iter().any(|w| !w.1.is_finite()) {
            return Err(refused(self));
        }
        let start = (self.state.clone(), self.changed.clone());
        let covariance = match &unknowns {
            Unknowns::Along(_) => DMatrix::identity(1, 1),
            Unknowns::Coefficients(free) => self.model.conditional_covariance(free),
        };
        // Once more where rounding to f32 and to the grid of coefficients was too coarse.
        for _ in 0..3 {
            let amounts = self.newton(wanted, &unknowns, &covariance);
            let mut coefficients = self.sigmas();
            match &unknowns {
                Unknowns::Along(control) => (control.direction.iter()).for_each(|&(i, change)| {
                    coefficients[i as usize] += amounts[0] * f64::from(change);
                }),
                Unknowns::Coefficients(free) => (free.iter().zip(amounts.iter()))
                    .for_each(|(&i, amount)| coefficients[i] += amount),
            }
            if !coefficients.iter().all(|c| c.abs() <= f64::from(FARTHEST)) {
                break;
            }
            let earlier = self.changed.clone();
            let on_grid = coefficients.iter().map(|c| (c * PER_SIGMA).round() as i32);
            self.replace(on_grid.collect());
            if !earlier.is_empty() && !self.changed.is_empty() {
                let (a, b) = (earlier, &self.changed);
                self.changed = a.start.min(b.start)..a.end.max(b.end);
            } else if self.changed.is_empty() {
                self.changed = earlier;
            }
            let off = |&(m, mm): &(usize, f64)| (self.measured(m) - mm).abs();
            if wanted.iter().all(|w| off(w) <= 0.5 * tolerance) {
                return Ok(());
            }
        }
        let off = |&(m, mm): &(usize, f64)| (self.measured(m) - mm).abs();
        if wanted.iter().all(|w| off(w) <= tolerance) {
            return Ok(());
        }
        let why = refused(self);
        self.replace(start.0);
        self.changed = start.1;
        Err(why)
    }

    /// The amounts of the unknowns that bring the measures to their lengths, as far as they go.
    fn newton(
        &self,
        wanted: &[(usize, f64)],
        unknowns: &Unknowns,
        covariance: &DMatrix<f64>,
    ) -> Vec<f64> {
        let measures = &self.model.parts().measures;
        let landmarks = self.landmarks(wanted.iter().map(|w| w.0), unknowns);
        let q = covariance.nrows();
        let observe = |amounts: &[f64]| {
            let place = |l: u32| landmarks.place(l, amounts);
            let each = (wanted.iter()).map(|&(m, _)| measures[m].quantity.measure(&place));
            each.collect::<Vec<_>>()
        };
        let missing = |observed: &[(f64, Vec<(u32, DVec3)>)]| {
            let each: Vec<f64> = (wanted.iter().zip(observed))
                .map(|(w, o)| w.1 - o.0)
                .collect();
            DMatrix::from_column_slice(wanted.len(), 1, &each)
        };
        let mut amounts = vec![0.0; q];
        let mut observed = observe(&amounts);
        for _ in 0..STEPS {
            let left = missing(&observed);
            if left.amax() < 1e-9 {
                break;
            }
            let mut jacobian = DMatrix::zeros(wanted.len(), q);
            for (row, (_, gradient)) in observed.iter().enumerate() {
                for (landmark, g) in gradient {
                    let rates = landmarks.of(*landmark).map_or(&[][..], |l| &l.rates);
                    for (column, rate) in rates.iter().enumerate() {
                        jacobian[(row, column)] += g.dot(*rate);
                    }
                }
            }
            let spread = product(covariance, &jacobian.transpose());
            let mut gram = product(&jacobian, &spread);
            // Measures may say the same thing twice (two eyes, and their mean): the ridge keeps the
            // matrix definite, and costs a part of a billion of each step.
            let ridge = 1e-9 * gram.trace() + 1e-18;
            (0..wanted.len()).for_each(|i| gram[(i, i)] += ridge);
            let Some(pull) = solve(gram, &left) else {
                break;
            };
            let step = product(&spread, &pull);
            let mut whole = 1.0;
            let better = (0..HALVINGS).find_map(|_| {
                let there: Vec<f64> = (amounts.iter().zip(step.iter()))
                    .map(|(a, s)| a + whole * s)
                    .collect();
                let seen = observe(&there);
                let closer = missing(&seen).norm() < left.norm();
                whole *= 0.5;
                closer.then_some((there, seen))
            });
            let Some((there, seen)) = better else {
                break;
            };
            (amounts, observed) = (there, seen);
        }
        amounts
    }

    /// Where the landmarks of some measures are, and how they move with the unknowns.
    fn landmarks(&self, measures: impl Iterator<Item = usize>, unknowns: &Unknowns) -> Landmarks {
        let parts = self.model.parts();
        let mut found = Landmarks(Vec::new());
        for measure in measures {
            // The gradient names every landmark, whatever its value is here.
            let terms = parts.measures[measure].quantity.terms();
            let named = terms.into_iter().flat_map(|term| {
                let anywhere = |l: u32| DVec3::splat(f64::from(l));
                term.measure(&anywhere).1
            });
            for (landmark, _) in named {
                if found.of(landmark).is_some() {
                    continue;
                }
                let point = &parts.landmarks[landmark as usize];
                let mut each = vec![DVec3::ZERO; self.state.len()];
                for &(vertex, weight) in &point.stencil {
                    for (sum, rate) in each.iter_mut().zip(self.jacobian(vertex)) {
                        *sum += rate.as_dvec3() * weight;
                    }
                }
                let rates = match unknowns {
                    Unknowns::Along(control) => {
                        let along = control.direction.iter();
                        vec![
                            along
                                .map(|&(i, change)| each[i as usize] * f64::from(change))
                                .sum(),
                        ]
                    }
                    Unknowns::Coefficients(free) => free.iter().map(|&i| each[i]).collect(),
                };
                found.0.push(MovingLandmark {
                    index: landmark,
                    start: point.place(self.positions()),
                    rates,
                });
            }
        }
        found
    }
}
