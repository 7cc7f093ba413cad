//! The first fit: pose and the coefficients of the template's prior, before anything else may bend.

use faer::linalg::solvers::Solve;
use glam::{DMat3, DVec3};

use super::Pulls;
use super::correspondence::{Admission, correspond};
use crate::fit::head::expression::Expression;
use crate::fit::head::prior::ShapePrior;
use crate::fit::mesh::align::Rigid;
use crate::fit::mesh::surface::Surface;
use crate::fit::mesh::surface::normals;

/// One measurement of the surface, with an error of [`SURFACE_ERROR`], is taken to be independent
/// of the next over this area, mm^2: what faces leave unexplained by a prior is smooth.
const INDEPENDENT_AREA: f64 = 60.0;

/// What the prior leaves unexplained of a surface, mm.
const SURFACE_ERROR: f64 = 0.5;

/// How much less likely a face is for each expression at full strength that it shows, as a natural
/// logarithm; besides, strengths have a standard deviation of 1. Far more than people's expressions
/// would ask for: an expression explains what a prior of shapes leaves as well as anything else, and a
/// face that shows none should stay where it is. On faces of the default model that show one, drift is
/// 0.76 mm with 30, 0.79 with 50 and 0.81 with 70, where it is 0.98 without expressions.
///
/// Where the prior leaves more unexplained than [`SURFACE_ERROR`], evidence is weaker than it looks, and more of it is
/// asked for ([`DOUBT`]).
const UNLIKELY: f64 = 50.0;

/// The power of what is left unexplained, as a multiple of [`SURFACE_ERROR`], by which expressions become less likely. Of the
/// base mesh's own people, who differ from the prior's, expressions that they do not show are told with strengths of 1.35
/// altogether with 0, 0.55 with 1, 0.32 with 1.5 and 0.15 with 2, as the independence of errors would have it; but smiles of
/// 0.8 that they do show then become 0.6.
const DOUBT: f64 = 1.5;

/// Some people go beyond what the base mesh's expressions call 1.
const STRONGEST: f64 = 1.1;

/// Rounds over all expressions in which the best strength of each is looked for while the others
/// stay.
const SWEEPS: usize = 100;

/// A round of Gauss-Newton; each looks for closest points anew.
struct Round {
    /// The least cosine between normals: few agree while the face is still the wrong one.
    cosine: f64,
    /// The farthest point, mm; later as the bare skin of the round before has it.
    reach: Option<f64>,
    /// What is believed where hair grows; nothing is, while the bare skin is not found.
    hairy: Option<Hairy>,
}

/// What a scan shows where hair grows is skin, or hair above it.
struct Hairy {
    /// What lies higher above the face that the bare skin asks for is hair, mm. It sinks as skin
    /// that is seen takes part: a skull that no prior knows rises gradually, hair in a step.
    above: f64,
    /// Up to here distances are errors of a guess that is still coarse, mm.
    scale: f64,
}

/// By bare skin alone.
const fn by_bare_skin(cosine: f64, reach: f64) -> Round {
    Round {
        cosine,
        reach: Some(reach),
        hairy: None,
    }
}

/// By all that is taken for skin.
const fn by_all_skin(reach: Option<f64>, above: f64, scale: f64) -> Round {
    Round {
        cosine: 0.7,
        reach,
        hairy: Some(Hairy { above, scale }),
    }
}

const ROUNDS: [Round; 7] = [
    by_bare_skin(0.5, 30.0),
    by_bare_skin(0.5, 20.0),
    by_bare_skin(0.5, 20.0),
    by_all_skin(Some(20.0), 10.0, 6.0),
    by_all_skin(Some(20.0), 8.0, 4.0),
    by_all_skin(None, 6.0, 2.5),
    by_all_skin(None, 5.0, 0.0),
];

/// Vertices that are compared with the scan: every vertex would only cost time.
const SAMPLE: usize = 2500;

/// A fit of the prior to a scan.
pub struct StatisticalFit {
    /// From the template's frame to the scan's.
    pub pose: Rigid,
    /// Coefficients in standard deviations.
    pub coefficients: Vec<f64>,
    /// How strongly each of the template's expressions shows.
    pub strengths: Vec<f64>,
}

/// The template as the fit sees it.
pub struct Shape<'a> {
    /// Rest pose.
    pub rest: &'a [DVec3],
    /// Its triangles.
    pub triangles: &'a [[u32; 3]],
    /// Its prior.
    pub prior: &'a ShapePrior,
    /// What it can show.
    pub expressions: &'a [Expression],
    /// How much each vertex counts: its area times how open it lies to a scanner, mm^2.
    pub weights: &'a [f64],
    /// Which vertices are skin on everybody ([`bare`](super::hair::bare)).
    pub bare: &'a [bool],
    /// The landmarks as weights on vertices.
    pub stencils: &'a [&'a [(u32, f64)]],
}

impl Shape<'_> {
    /// A face in the template's frame: its coefficients in standard deviations, and how strongly it
    /// shows each expression.
    pub fn face(&self, coefficients: &[f64], strengths: &[f64]) -> Vec<DVec3> {
        let mut face = self.prior.face(self.rest, coefficients);
        for (expression, &strength) in self.expressions.iter().zip(strengths) {
            if strength > 0.0 {
                let moves = face.iter_mut().zip(&expression.displacements);
                moves.for_each(|(p, d)| *p += *d * strength);
            }
        }
        face
    }
}

/// Fits pose, coefficients and expression by Gauss-Newton on point-to-plane distances and landmarks
/// (iterated closest points; the regulariser is the prior's own Mahalanobis length, and in
/// proportion to the strengths of expressions).
///
/// The scan is near the rest pose already; `points` are landmarks (place in
/// `stencils`, position) whose errors are about `point_errors`, mm, in the same order.
pub fn fit(
    shape: &Shape<'_>,
    scan: &Surface<'_>,
    points: &Pulls,
    point_errors: &[f64],
) -> StatisticalFit {
    let people = shape.prior.modes.iter();
    let shown = shape.expressions.iter().map(|e| &e.displacements);
    let modes: Vec<&[DVec3]> = people.chain(shown).map(|m| &m[..]).collect();
    let sample = sample(shape.weights);
    let mut coefficients = vec![0.0; shape.prior.modes.len()];
    let mut strengths = vec![0.0; shape.expressions.len()];
    let mut pose = Rigid {
        rotation: DMat3::IDENTITY,
        translation: DVec3::ZERO,
    };
    let bare: Vec<u32> = (sample.iter().copied())
        .filter(|&v| shape.bare[v as usize])
        .collect();
    let share = shape.weights.len() as f64 / sample.len() as f64;
    let mut typical = 1.0;
    for round in &ROUNDS {
        let local = shape.face(&coefficients, &strengths);
        let face: Vec<DVec3> = local.iter().map(|&p| pose.apply(p)).collect();
        let face_normals = normals(&face, shape.triangles);
        let admission = Admission {
            reach: (round.reach).unwrap_or((8.0_f64 * typical).clamp(4.0, 20.0)),
            cosine: round.cosine,
        };
        let looked_at = if round.hairy.is_some() {
            &sample
        } else {
            &bare
        };
        let found = correspond(scan, &face, &face_normals, looked_at, &admission);
        let mut system = System::new(modes.len());
        let mut residuals: Vec<f64> = found
            .iter()
            .flatten()
            .filter(|c| shape.bare[c.vertex as usize])
            .map(|c| c.normal.dot(c.point - face[c.vertex as usize]).abs())
            .collect();
        residuals.sort_unstable_by(f64::total_cmp);
        typical = residuals.get(residuals.len() / 2).copied().unwrap_or(1.0);
        let unexplained = (1.4826 * typical).max(SURFACE_ERROR);
        let scale = 3.0 * unexplained;
        for c in found.iter().flatten() {
            let v = c.vertex as usize;
            let residual = c.normal.dot(c.point - face[v]);
            let scale = match &round.hairy {
                Some(hairy) if !shape.bare[v] => {
                    // However little it counted, there is much of it.
                    if residual > hairy.above {
                        continue;
                    }
                    scale.max(hairy.scale)
                }
                _ => scale,
            };
            // Geman and McClure: what lies far off is a collar or the wrong place.
            let robust = 1.0 / (1.0 + (residual / scale).powi(2)).powi(2);
            let weight = robust * shape.weights[v] * share
                / (INDEPENDENT_AREA * SURFACE_ERROR * SURFACE_ERROR);
            let direction = pose.rotation.transpose() * c.normal;
            system.add(
                weight,
                residual,
                face[v].cross(c.normal),
                c.normal,
                modes.iter().map(|m| m[v].dot(direction)),
            );
        }
        let place = |point: usize| -> DVec3 {
            let stencil = shape.stencils[point].iter();
            stencil.map(|&(v, w)| face[v as usize] * w).sum()
        };
        for (&(point, target), &point_error) in points.iter().zip(point_errors) {
            let stencil = shape.stencils[point];
            let at = place(point);
            let off = target - at;
            let scale = 4.0 * point_error;
            let robust = 1.0 / (1.0 + (off.length() / scale).powi(2)).powi(2);
            let weight = robust / (point_error * point_error);
            for axis in [DVec3::X, DVec3::Y, DVec3::Z] {
                let direction = pose.rotation.transpose() * axis;
                let moved = modes.iter().map(|m| {
                    let d: DVec3 = stencil.iter().map(|&(v, w)| m[v as usize] * w).sum();
                    d.dot(direction)
                });
                system.add(weight, off.dot(axis), at.cross(axis), axis, moved);
            }
        }
        let unlikely = UNLIKELY * (unexplained / SURFACE_ERROR).powf(DOUBT);
        let Some(step) = system.solve(&coefficients, &strengths, unlikely) else {
            break;
        };
        let turn = DVec3::new(step[0], step[1], step[2]);
        let shift = DVec3::new(step[3], step[4], step[5]);
        let rotation = DMat3::from_quat(glam::DQuat::from_scaled_axis(turn));
        pose = Rigid {
            rotation: rotation * pose.rotation,
            translation: rotation * pose.translation + shift,
        };
        coefficients
            .iter_mut()
            .chain(&mut strengths)
            .zip(step.iter().skip(6))
            .for_each(|(c, d)| *c += d);
    }
    StatisticalFit {
        pose,
        coefficients,
        strengths,
    }
}

/// About [`SAMPLE`] vertices, evenly over those that count, always the same.
fn sample(weights: &[f64]) -> Vec<u32> {
    let counting: Vec<u32> = (0..weights.len() as u32)
        .filter(|&v| weights[v as usize] > 0.0)
        .collect();
    let stride = counting.len().div_ceil(SAMPLE).max(1);
    counting.into_iter().step_by(stride).collect()
}

/// Normal equations of pose (turn, shift) and coefficients, gathered row by row.
struct System {
    /// Rows times the roots of their weights, one after the other.
    rows: Vec<f64>,
    residuals: Vec<f64>,
    unknowns: usize,
}

impl System {
    fn new(modes: usize) -> Self {
        Self {
            rows: Vec::new(),
            residuals: Vec::new(),
            unknowns: modes + 6,
        }
    }

    /// A residual and how it falls with turn, shift and coefficients.
    fn add(
        &mut self,
        weight: f64,
        residual: f64,
        turn: DVec3,
        shift: DVec3,
        modes: impl Iterator<Item = f64>,
    ) {
        let root = weight.sqrt();
        let pose = turn.to_array().into_iter().chain(shift.to_array());
        self.rows.extend(pose.chain(modes).map(|a| a * root));
        self.residuals.push(residual * root);
    }

    /// The step, with the prior's pull towards zero coefficients and that of what is `unlikely` ([`UNLIKELY`])
    /// towards no expression; strengths stay within 0 and [`STRONGEST`].
    fn solve(self, coefficients: &[f64], strengths: &[f64], unlikely: f64) -> Option<Vec<f64>> {
        faer::set_global_parallelism(faer::Par::Seq);
        let count = self.residuals.len();
        let rows = faer::MatRef::from_row_major_slice(&self.rows, count, self.unknowns);
        let residuals = faer::MatRef::from_column_major_slice(&self.residuals, count, 1);
        let mut matrix = rows.transpose() * rows;
        let mut right = rows.transpose() * residuals;
        for (i, &c) in coefficients.iter().chain(strengths).enumerate() {
            matrix[(6 + i, 6 + i)] += 1.0;
            right[(6 + i, 0)] -= c;
        }
        let (free, bounded) = (self.unknowns - strengths.len(), strengths.len());
        // What the free ones answer when no bounded one moves, and to each of these.
        let inner = matrix.get(..free, ..free).llt(faer::Side::Lower).ok()?;
        let coupling = matrix.get(..free, free..);
        let alone = inner.solve(right.get(..free, ..));
        let answers = inner.solve(coupling);
        let reduced = matrix.get(free.., free..) - coupling.transpose() * &answers;
        let pull = right.get(free.., ..) - coupling.transpose() * &alone;
        let mut moved = vec![0.0; bounded];
        for _ in 0..SWEEPS {
            for (i, &strength) in strengths.iter().enumerate() {
                let others: f64 = (0..bounded).map(|j| reduced[(i, j)] * moved[j]).sum();
                let best = moved[i] + (pull[(i, 0)] - unlikely - others) / reduced[(i, i)];
                moved[i] = best.clamp(-strength, STRONGEST - strength);
            }
        }
        let answered = (0..free).map(|u| {
            let answer = |j: usize| answers[(u, j)] * moved[j];
            alone[(u, 0)] - (0..bounded).map(answer).sum::<f64>()
        });
        Some(answered.chain(moved.iter().copied()).collect())
    }
}
