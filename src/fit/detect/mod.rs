//! Landmarks without a hand: the statistical face is looked for on a scan, and its landmarks are
//! read off (the future work of region morphing).
//!
//! No direction of the scan is taken for up or front, and anything may surround the face. The tip
//! of the mean face's nose is set on every place that stands out enough, in every direction
//! (`search`); the likeliest starts are fitted, first rigidly, then with ever more modes
//! (`fit`); the one with the most evidence wins. Rough questions are put to a grid of small
//! pieces of surface (`surfels`), and only the last ones to the scan itself. Before the modes of
//! the template's prior comes its jaw, from which the last fit also starts when it hangs; behind them come its
//! other expressions, and smooth modes of no particular face (`shape`), so that landmarks reach what the prior
//! has never seen. Edges of shut lips are put to where these meet on the scan (`lips`).

use glam::DVec3;

use crate::fit::head::expression::Expression;
use crate::fit::head::template::Template;
use crate::fit::mesh::surface::{Hit, Surface};
use crate::fit::{FitError, FitResult};

mod fit;
mod lips;
mod search;
mod shape;
mod surfels;
mod units;

use fit::{Fit, Match, Pull, Uncertainty, WORTH, step};
use lips::{LINE_ERROR, Lips};
use search::{Breadth, Lookout, PART, WHOLE, agreement, starts};
use shape::{Shape, visible_face};
use surfels::Surfels;

/// Finds a template's landmarks on scans.
pub struct Detector {
    /// Evenly spread points of the visible face; the first n of them are so too, for any n.
    face: Shape,
    /// The template's landmarks.
    landmarks: Shape,
    /// The tip of the nose.
    tip: Lookout,
    /// Whether the first mode opens the mouth.
    opens: bool,
    lips: Option<Lips>,
}

/// What was found on a scan.
#[derive(Debug, Clone, PartialEq)]
pub struct Detection {
    /// The template's landmarks in their order, mm. Where the scan has no surface they are where the
    /// fitted face has them.
    pub points: Vec<DVec3>,
    /// How likely each point is within [`NEAR`] of where the template's landmark belongs, 0 to 1: by
    /// what the scan leaves open of the fitted face, and by its distance from the scan there. It
    /// is cautious: of simulated people's points with 0.5 to 0.6 five in six are so near.
    pub confidences: Vec<f64>,
    /// How far each point is from where the template's landmark belongs, as a standard deviation, mm.
    pub errors: Vec<f64>,
    /// The evidence for a face, 0 to 1; below [`LEAST_EVIDENCE`] there is none.
    pub evidence: f64,
    /// How far the tips of the noses of other faces on the scan are from this one's, mm: of those that are
    /// among its few likeliest places.
    pub others: Vec<f64>,
}

impl Detection {
    /// The landmarks that are at least so sure: `(index in the template's landmarks, mm)`.
    pub fn landmarks(&self, confidence: f64) -> Vec<(usize, DVec3)> {
        let points = self.points.iter().copied().enumerate();
        points
            .filter(|&(i, _)| self.confidences[i] >= confidence)
            .collect()
    }
}

/// What a confidence is about, mm.
pub const NEAR: f64 = 4.0;

/// What points are off, of what the fit leaves open. It is the least on faces as those that the prior was learned from, 1/3,
/// and the most on others, 1. Faces that are registered by found points drift by 0.70 mm with 1, 0.72 with 0.7, 0.75 with 0.5
/// on the former; on the latter the lids by 1.48, 1.33 and 1.21, the lips by 2.3, 2.15 and 2.0.
const CAUTION: f64 = 0.7;

/// Real and simulated faces have 0.45 and more, also halves, noisy and coarse ones; heads without a
/// face, bodies and simple solids at most 0.25.
pub const LEAST_EVIDENCE: f64 = 0.38;

/// Points of the face that the fit goes by.
const FACE_POINTS: usize = 1500;
/// The most modes of the prior that are used; smooth ones do better than what would follow.
const OWN_MODES: usize = 60;
/// The standard deviation of an expression's strength.
const SHOWN: f64 = 0.3;
/// The expression that opens the mouth, and how far it is open in further starts.
const OPEN: &str = "jawOpen";
const OPENED: [f64; 2] = [0.6, 1.2];
/// A mouth that came of these is open by more than this, with so much of the cost of the fit without. Of simulated people
/// with a jaw that hangs, 0.61 to 0.78; with a beard over the mouth, 0.92.
const HANGS: f64 = 0.3;
const MUCH_MORE: f64 = 0.85;
/// Centres of the smooth modes, their standard deviation an axis and their length, mm.
const CENTRES: usize = 60;
const SMOOTH_SIGMA: f64 = 3.0;
const SMOOTH_LENGTH: f64 = 25.0;

/// Cells of surfels, mm: fine ones for fitting, which reach 20 mm far, rough ones for starts.
const FINE_CELL: f64 = 4.0;
const FINE_REACH: usize = 5;
const ROUGH_CELL: f64 = 10.0;

/// How many are fitted rigidly, roughly, and to the scan itself.
const STARTS: usize = 300;
const CANDIDATES: usize = 24;
const FINALISTS: usize = 4;

/// What a fit may be drawn by, in a stage: the distance within which the scan is seen (mm) of each
/// step, points, modes and the scatter around the fit (mm).
struct Stage {
    gates: &'static [f64],
    points: usize,
    modes: usize,
    sigma: f64,
}

/// To surfels, without shape.
const RIGID: Stage = Stage {
    gates: &[20.0, 20.0, 16.0, 16.0, 12.0, 12.0],
    points: 200,
    modes: 0,
    sigma: 4.0,
};

/// To surfels, with the shape of the head.
const ROUGH: Stage = Stage {
    gates: &[12.0, 12.0, 10.0, 10.0, 8.0, 8.0, 8.0, 8.0],
    points: 400,
    modes: 8,
    sigma: 2.8,
};

/// To the scan itself, with the prior's modes.
const SHAPED: [Stage; 3] = [
    Stage {
        gates: &[8.0, 6.0],
        points: 800,
        modes: 20,
        sigma: 1.0,
    },
    Stage {
        gates: &[6.0, 5.0, 4.0],
        points: 800,
        modes: 40,
        sigma: 1.0,
    },
    Stage {
        gates: &[4.0, 4.0, 4.0],
        points: 800,
        modes: OWN_MODES,
        sigma: 1.0,
    },
];

/// To the scan itself, with an open mouth: mostly the jaw moves.
const OPENING: Stage = Stage {
    gates: &[16.0, 16.0, 14.0, 12.0, 10.0, 8.0],
    points: 800,
    modes: 16,
    sigma: 1.0,
};

/// To the scan itself, with all modes.
const LAST: Stage = Stage {
    gates: &[5.0; 8],
    points: FACE_POINTS,
    modes: usize::MAX,
    sigma: 1.0,
};

impl Stage {
    fn pull(&self) -> Pull {
        Pull {
            points: self.points,
            modes: self.modes,
            sigma: self.sigma,
        }
    }
}

impl Detector {
    /// A detector of the template's landmarks, by its prior. Without one only smooth modes bend the
    /// template's rest pose.
    ///
    /// # Errors
    /// When the template has no tip of a nose (`ibug_30`) or no visible face.
    pub fn new(template: &Template) -> FitResult<Self> {
        let people = template.prior.iter().flat_map(|prior| &prior.modes);
        let shown = |open: bool| {
            let of = move |e: &&Expression| (e.name == OPEN) == open;
            let at_sigma = |e: &Expression| e.displacements.iter().map(|d| *d * SHOWN).collect();
            template.expressions.iter().filter(of).map(at_sigma)
        };
        // Hardly anything moves a face as far as its jaw: that is asked for from the first.
        let mut modes: Vec<Vec<DVec3>> = shown(true).collect();
        let opens = modes.len();
        modes.extend(people.take(OWN_MODES).cloned());
        let own = modes.len();
        modes.extend(shown(false));
        let tip = template.landmarks.iter().position(|l| l.name == "ibug_30");
        let Some(tip) = tip else {
            return Err(FitError::Input(
                "the template has no landmark ibug_30".into(),
            ));
        };
        let tip = template.landmark(tip, &template.positions);
        let triangles = template.triangles();
        let surface = Surface::new(&template.positions, &triangles);
        let vertices: Vec<[(u32, f64); 1]> = visible_face(template, &surface, tip, FACE_POINTS)?
            .into_iter()
            .map(|v| [(v, 1.0)])
            .collect();
        let vertices: Vec<&[(u32, f64)]> = vertices.iter().map(|v| &v[..]).collect();
        let marks: Vec<&[(u32, f64)]> = template.landmarks.iter().map(|l| &l.stencil[..]).collect();
        let mut face = Shape::new(template, &modes, &surface.normals, &vertices);
        face.shown = (0..opens).chain(own..modes.len()).collect();
        let mut landmarks = Shape::new(template, &modes, &surface.normals, &marks);
        let centres = face.mean[..CENTRES].to_vec();
        face.loosen(&centres, SMOOTH_SIGMA, SMOOTH_LENGTH);
        landmarks.loosen(&centres, SMOOTH_SIGMA, SMOOTH_LENGTH);
        let skin = template.part_triangles("skin")?;
        let rough = Surfels::new(&template.positions, &skin, ROUGH_CELL, 0);
        Ok(Self {
            face,
            landmarks,
            tip: Lookout::new(&rough, tip),
            opens: opens > 0,
            lips: Lips::new(template),
        })
    }

    /// Finds the landmarks on a scan: positions in mm, triangles counter-clockwise from outside. Any
    /// pose will do.
    ///
    /// # Errors
    /// When there is no face on the scan.
    pub fn find(&self, positions: &[DVec3], triangles: &[[u32; 3]]) -> FitResult<Detection> {
        let scene = Scene {
            surface: Surface::new(positions, triangles),
            fine: Surfels::new(positions, triangles, FINE_CELL, FINE_REACH),
        };
        let rough = Surfels::new(positions, triangles, ROUGH_CELL, 0);
        let mut most: f64 = 0.0;
        for breadth in [&WHOLE, &PART] {
            let finalists = self.finalists(&scene, &rough, breadth);
            for (_, fit) in &finalists {
                let mut fit = fit.clone();
                self.finish(&mut fit, &scene);
                let evidence = self.evidence(&fit, &scene);
                if evidence >= LEAST_EVIDENCE {
                    return Ok(Detection {
                        others: self.others(&fit, &finalists),
                        ..self.read_off(&fit, &scene, evidence)
                    });
                }
                most = most.max(evidence);
            }
        }
        Err(FitError::Input(format!(
            "no face was found on the scan: the likeliest place has {:.0} % of the evidence that \
             is asked for",
            100.0 * most / LEAST_EVIDENCE
        )))
    }

    /// How far the noses of other faces are: those of the fits that have evidence of their own.
    fn others(&self, fit: &Fit, finalists: &[(f64, Fit)]) -> Vec<f64> {
        let mut tips = vec![fit.place(self.tip.point)];
        for (evidence, other) in finalists {
            let tip = other.place(self.tip.point);
            if *evidence >= LEAST_EVIDENCE && tips.iter().all(|t| t.distance(tip) > APART) {
                tips.push(tip);
            }
        }
        tips[1..].iter().map(|t| t.distance(tips[0])).collect()
    }

    /// The likeliest fits with their evidence, the best first, before the last stage.
    fn finalists(&self, scene: &Scene<'_>, rough: &Surfels, breadth: &Breadth) -> Vec<(f64, Fit)> {
        let near = |p, normal, gate| scene.near(p, normal, gate);
        let mut fits = starts(&self.face, self.tip, rough, &scene.fine, breadth, STARTS);
        for (worth, fit) in &mut fits {
            self.draw(fit, &RIGID, near);
            *worth = agreement(&self.face, fit, 300, &scene.fine, 8.0);
        }
        self.keep_best(&mut fits, CANDIDATES);
        for (worth, fit) in &mut fits {
            self.draw(fit, &ROUGH, near);
            *worth = agreement(&self.face, fit, 400, &scene.fine, 6.0);
        }
        self.keep_best(&mut fits, FINALISTS);
        for (worth, fit) in &mut fits {
            self.shape(fit, scene);
            *worth = self.evidence(fit, scene);
        }
        self.keep_best(&mut fits, FINALISTS);
        fits
    }

    /// Fits the prior's modes to the scan itself.
    fn shape(&self, fit: &mut Fit, scene: &Scene<'_>) {
        for stage in &SHAPED {
            self.draw(fit, stage, |p, n, gate| scene.closest(p, n, gate));
        }
    }

    /// Fits all modes, from the mouth as it is and from open ones, as a jaw that hangs is too far from one that does not for any
    /// step. It is open if that is much more probable: under a beard a mouth may be anything.
    fn finish(&self, fit: &mut Fit, scene: &Scene<'_>) {
        let last = |fit: &mut Fit| {
            self.draw(fit, &LAST, |p, n, gate| scene.closest(p, n, gate));
            self.cost(fit, scene)
        };
        let opened = OPENED.iter().filter(|_| self.opens).map(|strength| {
            let mut open = fit.clone();
            open.coefficients.resize(fit.coefficients.len().max(1), 0.0);
            open.coefficients[0] = strength / SHOWN;
            self.draw(&mut open, &OPENING, |p, n, gate| scene.closest(p, n, gate));
            self.shape(&mut open, scene);
            open
        });
        let opened: Vec<Fit> = opened.collect();
        let mut least = last(fit) * MUCH_MORE;
        for mut open in opened {
            let cost = last(&mut open);
            if cost < least && open.coefficients[0] * SHOWN > HANGS {
                (least, *fit) = (cost, open);
            }
        }
    }

    /// The negative logarithm of how probable a fit is, twice and but for a constant: what [`step`] makes small, with
    /// distances that count as [`FAR`] where the scan is farther, faces elsewhere, or is missing.
    fn cost(&self, fit: &Fit, scene: &Scene<'_>) -> f64 {
        let count = self.face.mean.len();
        let off = |i: usize| {
            let p = fit.point(&self.face, i);
            let on = scene.surface.closest(p, FAR).filter(|hit| {
                let surfel = scene.fine.near(hit.point);
                let normal = surfel.map_or(scene.surface.normal(hit), |s| scene.fine.normals[s]);
                normal.dot(fit.normal(&self.face, i)) > 0.3
            });
            on.map_or(FAR, |hit| hit.distance).powi(2)
        };
        let lies = (0..count).map(off).sum::<f64>() * WORTH / count as f64;
        lies + fit.coefficients.iter().map(|c| c * c).sum::<f64>()
    }

    fn draw(
        &self,
        fit: &mut Fit,
        stage: &Stage,
        find: impl Fn(DVec3, DVec3, f64) -> Option<Match>,
    ) {
        for &gate in stage.gates {
            step(&self.face, fit, stage.pull(), |p, n| find(p, n, gate));
        }
    }

    /// Keeps the best fits, and of those that came to the same place only one.
    fn keep_best(&self, fits: &mut Vec<(f64, Fit)>, most: usize) {
        fits.sort_by(|a, b| b.0.total_cmp(&a.0));
        let mut kept: Vec<(f64, Fit)> = Vec::new();
        for (worth, fit) in fits.drain(..) {
            let tip = fit.place(self.tip.point);
            let same = |other: &Fit| {
                let turn = fit.rotation.transpose() * other.rotation;
                // The cosine of the angle between them is (trace - 1) / 2: within 20 degrees.
                let cosine = (turn.x_axis.x + turn.y_axis.y + turn.z_axis.z - 1.0) / 2.0;
                tip.distance(other.place(self.tip.point)) < 10.0 && cosine > 0.94
            };
            if kept.len() < most && !kept.iter().any(|(_, other)| same(other)) {
                kept.push((worth, fit));
            }
        }
        *fits = kept;
    }

    /// The evidence for a face, 0 to 1: how well the middle of the face lies on the scan where there
    /// is any, how much there is of it and of the whole, and how likely such a face is.
    ///
    /// It is the middle that tells: much that is round can be taken for cheeks and a forehead.
    fn evidence(&self, fit: &Fit, scene: &Scene<'_>) -> f64 {
        // Hardly any adult's or child's face is so large or so small.
        if !(0.6..=1.5).contains(&fit.scale) {
            return 0.0;
        }
        let (mut points, mut covered, mut quality, mut lying) = (0.0, 0.0, 0.0, 0.0);
        for i in 0..self.face.mean.len() {
            let middle = self.face.mean[i].distance(self.tip.point) < MIDDLE;
            points += f64::from(u8::from(middle));
            let p = fit.point(&self.face, i);
            let Some(hit) = scene.surface.closest(p, 10.0) else {
                continue;
            };
            if scene.surface.on_border(&hit) {
                continue;
            }
            // The normal of a surfel is that of the surface without its noise.
            let normal = match scene.fine.near(hit.point) {
                Some(surfel) => scene.fine.normals[surfel],
                None => scene.surface.normal(&hit),
            };
            let facing = normal.dot(fit.normal(&self.face, i));
            lying += f64::from(u8::from(hit.distance < 3.0 && facing > 0.7));
            if middle {
                covered += 1.0;
                quality +=
                    (-0.5 * hit.distance * hit.distance).exp() * ((facing - 0.7) / 0.3).max(0.0);
            }
        }
        if covered == 0.0 {
            return 0.0;
        }
        // A profile shows half of a face; much less is no evidence.
        let middle = (covered / points / 0.5_f64).min(1.0);
        let whole = (lying / self.face.mean.len() as f64 / 0.4).min(1.0);
        // People have about 40 at most, what is bent to fit something else 100 and more.
        let deviance: f64 = fit.coefficients.iter().map(|c| c * c).sum();
        quality / covered * middle * whole * (-deviance / 200.0).exp()
    }

    /// The landmarks of a fit, on the scan where it is near.
    fn read_off(&self, fit: &Fit, scene: &Scene<'_>, evidence: f64) -> Detection {
        let gate = LAST.gates[0];
        let uncertainty = Uncertainty::new(&self.face, fit, LAST.pull(), |p, n| {
            scene.closest(p, n, gate)
        });
        let mut points = Vec::with_capacity(self.landmarks.mean.len());
        let mut errors = Vec::with_capacity(self.landmarks.mean.len());
        for i in 0..self.landmarks.mean.len() {
            let p = fit.point(&self.landmarks, i);
            let normal = fit.normal(&self.landmarks, i);
            let on = |hit: &Hit| {
                // Beside the scan is not on it.
                let beside = scene.surface.on_border(hit) && hit.distance > 1.0;
                // Where lips and lids meet, normals turn within a millimetre.
                let near = hit.distance < 3.0;
                !beside && (near || scene.surface.normal(hit).dot(normal) > 0.0)
            };
            let hit = scene.surface.closest(p, LANDMARK_REACH).filter(on);
            let own = uncertainty.as_ref().map(|u| u.of(&self.landmarks, fit, i));
            let apart = match (hit, own) {
                (Some(hit), Some(own)) => (own * own + hit.distance * hit.distance).sqrt(),
                _ => f64::INFINITY,
            };
            points.push(hit.map_or(p, |hit| hit.point));
            errors.push(CAUTION * apart);
        }
        if let Some(lips) = &self.lips {
            let [up, front] = [fit.rotation.y_axis, fit.rotation.z_axis];
            let met = lips.shut(&mut points, front, up, |p| {
                let from = p + front * MIDDLE;
                Some(scene.surface.cast(from, -front, 2.0 * MIDDLE)?.point)
            });
            for i in met.into_iter().flatten() {
                errors[i] = errors[i].min(LINE_ERROR);
            }
        }
        let confidences = errors
            .iter()
            .map(|error| 1.0 - (-(NEAR * CAUTION / error).powi(2)).exp());
        Detection {
            points,
            confidences: confidences.collect(),
            errors,
            evidence,
            others: Vec::new(),
        }
    }
}

/// Noses of two people are farther apart than this, mm: heads touch before.
const APART: f64 = 80.0;

/// The radius of the middle of the face around the tip of the nose, mm.
const MIDDLE: f64 = 45.0;

/// Where a scan is farther from a fit, mm, it is another thing, or missing: three times the scatter.
const FAR: f64 = 3.0;

/// How far a landmark of the fitted face may be from the scan, mm.
const LANDMARK_REACH: f64 = 6.0;

/// A scan as the fit sees it.
struct Scene<'a> {
    surface: Surface<'a>,
    fine: Surfels,
}

impl Scene<'_> {
    /// What a point of the face is drawn to among surfels.
    fn near(&self, p: DVec3, normal: DVec3, gate: f64) -> Option<Match> {
        let surfel = self.fine.near(p)?;
        let (point, found) = (self.fine.points[surfel], self.fine.normals[surfel]);
        pulled(p, normal, point, found, gate, 0.3)
    }

    /// What a point of the face is drawn to on the scan itself.
    fn closest(&self, p: DVec3, normal: DVec3, gate: f64) -> Option<Match> {
        let hit = self.surface.closest(p, gate)?;
        if self.surface.on_border(&hit) {
            return None;
        }
        let mut found = self.surface.normal(&hit);
        // Half of it without the scan's noise.
        if let Some(surfel) = self.fine.near(hit.point) {
            found = (found + self.fine.normals[surfel]).normalize_or(found);
        }
        pulled(p, normal, hit.point, found, gate, 0.5)
    }
}

/// The match of a point at `p`, weaker with distance and none beyond the gate (mm), weaker too the
/// less normals agree and none where the cosine between them is below `least`.
fn pulled(
    p: DVec3,
    normal: DVec3,
    point: DVec3,
    found: DVec3,
    gate: f64,
    least: f64,
) -> Option<Match> {
    let left = 1.0 - point.distance_squared(p) / (gate * gate);
    let facing = found.dot(normal);
    (left > 0.0 && facing > least).then_some(Match {
        point,
        normal: found,
        weight: left * left * facing,
    })
}
