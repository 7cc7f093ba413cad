//! How good a registration is, measured on people whose truth is known.
//!
//! The distance to the scan says little, any shrink-wrap makes it small. What counts is *drift*:
//! whether the same vertex of the template lands on the same spot of every person. It is measured
//! through the topology that all people of [`Ict`] share, in two ways:
//! - against a reference: the template registered to ICT's mean head without noise binds each
//!   vertex to a spot of ICT's skin ([`Binding`]); on a person the error is the distance from the
//!   registered vertex to that spot;
//! - without one: where a vertex lands on each person is carried to ICT's mean head; the error is
//!   the distance from the mean of these spots over the people.

pub mod exchange;

use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Instant;

use glam::DVec3;
use serde::Serialize;

use crate::fit::head::expression::{Expressions, Performer};
use crate::fit::head::folds::{Crossings, Folds};
use crate::fit::head::template::Template;
use crate::fit::mesh::resample::SurfacePoint;
use crate::fit::mesh::surface::Surface;
use crate::fit::truth::binding::Binding;
use crate::fit::truth::ict::Ict;
use crate::fit::truth::simulate::{Settings, Simulated, Simulator, Truth};
use crate::fit::{FitError, FitResult};

/// Mean, root mean square, 95th percentile and maximum of some lengths, mm.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub struct Lengths {
    /// The mean.
    pub mean: f64,
    /// The root mean square.
    pub rms: f64,
    /// What 95 in a hundred are below.
    pub percentile_95: f64,
    /// The greatest.
    pub max: f64,
}

impl Lengths {
    /// Of these lengths; zeros of none.
    pub fn of(mut lengths: Vec<f64>) -> Self {
        lengths.sort_unstable_by(f64::total_cmp);
        let Some(&max) = lengths.last() else {
            return Self::default();
        };
        let n = lengths.len() as f64;
        Self {
            mean: lengths.iter().sum::<f64>() / n,
            rms: (lengths.iter().map(|d| d * d).sum::<f64>() / n).sqrt(),
            percentile_95: lengths[(lengths.len() - 1) * 95 / 100],
            max,
        }
    }
}

/// What was measured on one person.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Measured {
    /// From each bound vertex of the face area to where it belongs, mm.
    pub drift: Vec<f64>,
    /// From each vertex of the face area to the scan, mm.
    pub face_to_scan: Vec<f64>,
    /// From each vertex of the whole head to the scan, mm.
    pub head_to_scan: Vec<f64>,
    /// From each vertex of the face area to the person's skin without noise, mm.
    pub face_to_skin: Vec<f64>,
    /// Folded pairs of triangles in the face area.
    pub folds: usize,
    /// Pairs of triangles through each other at lips and lids.
    pub crossings: usize,
    /// Folded pairs of triangles of the skin with each expression.
    pub expressions: Vec<usize>,
    /// Where each bound vertex of the face area lands, carried to ICT's mean head, mm; in the
    /// order of the binding, `None` where the scan has a hole.
    pub spots: Vec<Option<DVec3>>,
}

/// Measures registrations to one template.
pub struct Evaluator<'a> {
    ict: &'a Ict,
    /// Where the template's vertices belong.
    pub binding: Binding,
    face_folds: Folds,
    performer: Performer<'a>,
    crossings: Crossings,
}

impl<'a> Evaluator<'a> {
    /// Prepares a template; `reference` is the template registered to ICT's mean head (all
    /// vertices, mm, in ICT's pose).
    ///
    /// # Errors
    /// When the template lacks parts or landmarks, or the reference is of another topology.
    pub fn new(
        template: &'a Template,
        reference: &[DVec3],
        ict: &'a Ict,
        expressions: &'a Expressions,
    ) -> FitResult<Self> {
        if reference.len() != template.positions.len() {
            let cause = format!(
                "a reference of {} vertices for a template of {}",
                reference.len(),
                template.positions.len()
            );
            return Err(FitError::Input(cause));
        }
        let binding = Binding::new(template, reference, ict)?;
        let mut in_face = vec![false; reference.len()];
        for (&v, &face) in binding.vertices.iter().zip(&binding.face) {
            in_face[v as usize] = face;
        }
        let skin = template.part_triangles("skin")?;
        let face: Vec<[u32; 3]> = skin
            .iter()
            .filter(|t| t.iter().all(|&v| in_face[v as usize]))
            .copied()
            .collect();
        Ok(Self {
            ict,
            binding,
            face_folds: Folds::new(&template.positions, face),
            performer: Performer::new(template, expressions)?,
            crossings: Crossings::new(template)?,
        })
    }

    /// The names of the expressions, in the order of [`Measured::expressions`].
    pub fn expression_names(&self) -> Vec<String> {
        let list = &self.performer.expressions.list;
        list.iter().map(|e| e.name.clone()).collect()
    }

    /// Measures the template registered to a simulated scan (all vertices, mm, in the scan's
    /// pose).
    ///
    /// A vertex counts only where it has a spot of its own on ICT's skin, which the inside of
    /// nostrils and lips and the back of the lids have not, and where the scan shows that spot.
    pub fn measure(&self, person: &Simulated, registered: &[DVec3]) -> Measured {
        let truth = person.truth.positions(self.ict);
        let scan = Surface::new(&person.scan.positions, &person.scan.triangles);
        let skin = Surface::new(&truth, &self.ict.triangles);
        let spots = self.binding.truth(&truth, self.ict);
        // Noise, and that triangles cut corners, keep the scan from being at the spot itself.
        let settings = &person.truth.settings;
        let near = 0.8 + 4.0 * settings.noise;
        let mut measured = Measured::default();
        for (i, &v) in self.binding.vertices.iter().enumerate() {
            let (p, spot) = (registered[v as usize], spots[i]);
            let (face, bound) = (self.binding.face[i], self.binding.bound[i]);
            let seen = !settings.holes
                || scan
                    .closest(spot, near)
                    .is_some_and(|hit| !scan.on_border(&hit));
            if face && bound {
                measured
                    .spots
                    .push(if seen { self.carry(&skin, p) } else { None });
                if seen {
                    measured.drift.push(p.distance(spot));
                }
            }
            if !bound || !seen {
                continue;
            }
            let to_scan = distance(&scan, p);
            measured.head_to_scan.push(to_scan);
            if face {
                measured.face_to_scan.push(to_scan);
                measured.face_to_skin.push(distance(&skin, p));
            }
        }
        measured.folds = self.face_folds.of(registered).len();
        measured.crossings = self.crossings.of(registered).len();
        measured.expressions = self
            .performer
            .expressions
            .list
            .iter()
            .map(|e| {
                self.performer
                    .folds
                    .of(&self.performer.on(registered, e))
                    .len()
            })
            .collect();
        measured
    }

    /// From each vertex of the face area to where it belongs, mm, holes of the scan included;
    /// `registered` as in [`Evaluator::measure`].
    pub fn drift(&self, truth: &Truth, registered: &[DVec3]) -> Vec<f64> {
        let spots = self.binding.truth(&truth.positions(self.ict), self.ict);
        (self.binding.vertices.iter().enumerate())
            .filter(|(i, _)| self.binding.face[*i] && self.binding.bound[*i])
            .map(|(i, &v)| registered[v as usize].distance(spots[i]))
            .collect()
    }

    /// The spot of a person's skin that is closest to `p`, on ICT's mean head.
    fn carry(&self, skin: &Surface, p: DVec3) -> Option<DVec3> {
        let hit = skin.closest(p, f64::INFINITY)?;
        let spot = SurfacePoint {
            triangle: hit.triangle,
            weights: hit.weights,
        };
        Some(spot.on(&self.ict.neutral, &self.ict.triangles))
    }
}

fn distance(surface: &Surface, p: DVec3) -> f64 {
    surface
        .closest(p, f64::INFINITY)
        .map_or(f64::INFINITY, |hit| hit.distance)
}

/// What was measured on some people under one setting.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Report {
    /// What the setting is called.
    pub setting: String,
    /// How the scans were made.
    pub scans: Settings,
    /// The people measured.
    pub people: usize,
    /// The people that could not be registered: seed and cause.
    pub failed: Vec<(u64, String)>,
    /// Drift in the face area against the reference.
    pub drift: Lengths,
    /// The greatest mean drift of a person.
    pub worst_person_drift: f64,
    /// Drift in the face area around the mean spots, on ICT's mean head.
    pub scatter: Lengths,
    /// From vertices of the face area to the scan.
    pub face_to_scan: Lengths,
    /// From vertices of the face area to the skin without noise.
    pub face_to_skin: Lengths,
    /// From vertices of the head to the scan.
    pub head_to_scan: Lengths,
    /// Folded pairs of triangles in the face area, over all people.
    pub folds: usize,
    /// People with any.
    pub people_with_folds: usize,
    /// Pairs of triangles through each other at lips and lids, over all people.
    pub crossings: usize,
    /// People with any.
    pub people_with_crossings: usize,
    /// Expressions, with the folded pairs in the skin over all people.
    pub expressions: Vec<(String, usize)>,
    /// Mean time of a registration on one thread, seconds.
    pub seconds: f64,
    /// The seeds of the people with the greatest drift, worst first.
    pub worst: Vec<u64>,
}

/// What was measured on a person, and the seconds that the registration took; or why there is none.
type Outcome = FitResult<(Measured, f64)>;

/// Simulates `count` people from `seed` on, registers each with `register` and measures.
///
/// Each registration runs on one thread; as many people are under way as there are threads in the
/// current pool. Only the times depend on that. `done` is called after each person.
///
/// # Errors
/// When no thread can be started, or all registrations fail: then with the first cause.
pub fn evaluate(
    evaluator: &Evaluator,
    simulator: &Simulator,
    (name, settings): (&str, &Settings),
    seed: u64,
    count: usize,
    register: impl Fn(&Simulated) -> FitResult<Vec<DVec3>> + Sync,
    done: impl Fn() + Sync,
) -> FitResult<Report> {
    let next = AtomicUsize::new(0);
    let results: Mutex<Vec<Option<Outcome>>> = Mutex::new((0..count).map(|_| None).collect());
    let one = |index: usize| {
        let person = simulator.scan(seed.wrapping_add(index as u64), settings);
        let started = Instant::now();
        let registered = register(&person)?;
        let seconds = started.elapsed().as_secs_f64();
        Ok((evaluator.measure(&person, &registered), seconds))
    };
    let pools: Vec<rayon::ThreadPool> = (0..rayon::current_num_threads())
        .map(|_| rayon::ThreadPoolBuilder::new().num_threads(1).build())
        .collect::<Result<_, _>>()
        .map_err(|e| FitError::Input(format!("no thread: {e}")))?;
    std::thread::scope(|scope| {
        for pool in &pools {
            scope.spawn(|| {
                loop {
                    let index = next.fetch_add(1, Ordering::Relaxed);
                    if index >= count {
                        return;
                    }
                    let result = pool.install(|| one(index));
                    if let Ok(mut results) = results.lock() {
                        results[index] = Some(result);
                    }
                    done();
                }
            });
        }
    });
    let results = results.into_inner().unwrap_or_default();
    let mut failed = Vec::new();
    let mut people = Vec::new();
    for (index, result) in results.into_iter().enumerate() {
        let seed = seed.wrapping_add(index as u64);
        match result {
            Some(Ok((measured, seconds))) => people.push((seed, measured, seconds)),
            Some(Err(e)) => failed.push((seed, e.to_string())),
            None => failed.push((seed, "was not reached".into())),
        }
    }
    if let (true, Some((seed, cause))) = (people.is_empty(), failed.first()) {
        return Err(FitError::Input(format!("person {seed}: {cause}")));
    }
    Ok(summarise(evaluator, name, settings, &people, failed))
}

fn summarise(
    evaluator: &Evaluator,
    name: &str,
    settings: &Settings,
    people: &[(u64, Measured, f64)],
    failed: Vec<(u64, String)>,
) -> Report {
    let all = |of: fn(&Measured) -> &Vec<f64>| {
        Lengths::of(people.iter().flat_map(|p| of(&p.1)).copied().collect())
    };
    let total = |of: fn(&Measured) -> usize| people.iter().map(|p| of(&p.1)).sum();
    let any = |of: fn(&Measured) -> usize| people.iter().filter(|p| of(&p.1) > 0).count();
    let mean = |d: &[f64]| d.iter().sum::<f64>() / d.len().max(1) as f64;
    let mut drifts: Vec<(f64, u64)> = people.iter().map(|p| (mean(&p.1.drift), p.0)).collect();
    drifts.sort_by(|a, b| b.0.total_cmp(&a.0));
    Report {
        setting: name.into(),
        scans: *settings,
        people: people.len(),
        failed,
        drift: all(|m| &m.drift),
        worst_person_drift: drifts.first().map_or(0.0, |d| d.0),
        scatter: Lengths::of(scatter(people.iter().map(|p| &p.1.spots[..]))),
        face_to_scan: all(|m| &m.face_to_scan),
        face_to_skin: all(|m| &m.face_to_skin),
        head_to_scan: all(|m| &m.head_to_scan),
        folds: total(|m| m.folds),
        people_with_folds: any(|m| m.folds),
        crossings: total(|m| m.crossings),
        people_with_crossings: any(|m| m.crossings),
        expressions: evaluator
            .expression_names()
            .into_iter()
            .enumerate()
            .map(|(i, name)| (name, people.iter().map(|p| p.1.expressions[i]).sum()))
            .collect(),
        seconds: people.iter().map(|p| p.2).sum::<f64>() / people.len().max(1) as f64,
        worst: drifts.iter().take(5).map(|d| d.1).collect(),
    }
}

/// The distances of spots from their means over the people, of which there must be two or more.
fn scatter<'a>(people: impl Iterator<Item = &'a [Option<DVec3>]>) -> Vec<f64> {
    let people: Vec<_> = people.collect();
    let vertices = people.first().map_or(0, |spots| spots.len());
    let mut distances = Vec::new();
    for vertex in 0..vertices {
        let spots: Vec<DVec3> = people.iter().filter_map(|spots| spots[vertex]).collect();
        if spots.len() > 1 {
            let mean = spots.iter().sum::<DVec3>() / spots.len() as f64;
            distances.extend(spots.iter().map(|s| s.distance(mean)));
        }
    }
    distances
}
