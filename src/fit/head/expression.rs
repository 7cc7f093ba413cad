//! Expressions of the base mesh on heads of the template's topology.
//!
//! The base mesh has its expressions as displacements (`faceunits01`, CC0, named as ARKit names
//! them). The template's stencils carry them to its vertices; a head that was fitted to a person
//! takes them turned and stretched as that head is where they act, so that a narrow eye closes and
//! does not close twice. Where the skin still folds, as in the corners of eyes, it is evened out,
//! and if that is not enough the expression is lessened there.
//!
//! [`bake`] does this once for the mean head of a model, for [`crate::expression`], which carries
//! the result on to other faces.

use std::collections::VecDeque;
use std::path::Path;

use glam::{DMat3, DVec3};
use rayon::prelude::*;

use super::base_mesh::{BaseMesh, read_target};
use super::template::Template;
use crate::FaceModel;
use crate::expression::STEP;
use crate::fit::head::folds::{Folds, edge_neighbours};
use crate::fit::mesh::align::Rigid;
use crate::fit::{FitError, FitResult};

/// How often displacements are lessened around folds, at most.
const ROUNDS: usize = 60;

/// By what the gain of a vertex in a fold is multiplied.
const CALMER: f64 = 0.9;

/// How much the gains of two neighbours may differ.
const SLOPE: f64 = 0.05;

/// The reach up to which every vertex of the skin is asked, mm: beyond, there are more than a map
/// of nine numbers needs.
const FEW: f64 = 12.0;

/// The part of the squared extent of a neighbourhood by which its linear map is held to that of
/// the whole head.
const HELD: f64 = 0.05;

/// ARKit's names, a left side before its right, but for `tongueOut`: the head has no tongue.
pub const ARKIT: [&str; 51] = [
    "browDownLeft",
    "browDownRight",
    "browInnerUp",
    "browOuterUpLeft",
    "browOuterUpRight",
    "cheekPuff",
    "cheekSquintLeft",
    "cheekSquintRight",
    "eyeBlinkLeft",
    "eyeBlinkRight",
    "eyeLookDownLeft",
    "eyeLookDownRight",
    "eyeLookInLeft",
    "eyeLookInRight",
    "eyeLookOutLeft",
    "eyeLookOutRight",
    "eyeLookUpLeft",
    "eyeLookUpRight",
    "eyeSquintLeft",
    "eyeSquintRight",
    "eyeWideLeft",
    "eyeWideRight",
    "jawForward",
    "jawLeft",
    "jawRight",
    "jawOpen",
    "mouthClose",
    "mouthDimpleLeft",
    "mouthDimpleRight",
    "mouthFrownLeft",
    "mouthFrownRight",
    "mouthFunnel",
    "mouthLeft",
    "mouthRight",
    "mouthLowerDownLeft",
    "mouthLowerDownRight",
    "mouthPressLeft",
    "mouthPressRight",
    "mouthPucker",
    "mouthRollLower",
    "mouthRollUpper",
    "mouthShrugLower",
    "mouthShrugUpper",
    "mouthSmileLeft",
    "mouthSmileRight",
    "mouthStretchLeft",
    "mouthStretchRight",
    "mouthUpperUpLeft",
    "mouthUpperUpRight",
    "noseSneerLeft",
    "noseSneerRight",
];

/// The pairs of landmarks that meet when an eye closes, the upper lid's first: two in the middle of
/// the lids, as the outer ones meet anyway.
const LIDS: [(&str, [[&str; 2]; 2]); 2] = [
    (
        "eyeBlinkLeft",
        [["ibug_43", "ibug_47"], ["ibug_44", "ibug_46"]],
    ),
    (
        "eyeBlinkRight",
        [["ibug_38", "ibug_40"], ["ibug_37", "ibug_41"]],
    ),
];

/// Eyeballs that turn by less than this, radians, do not turn: what a blink does to them is
/// rounding.
const LEAST_TURN: f64 = 0.01;

/// All of [`ARKIT`] on the mean head of a model of this template, alike on both sides.
///
/// # Errors
/// When the model has another mesh than the template, or the base mesh cannot be read.
pub fn bake(
    template: &Template,
    model: &FaceModel,
    data_dir: &Path,
) -> FitResult<Vec<crate::expression::Expression>> {
    let parts = model.parts();
    if parts.topology.uv_triangles != template.topology.uv_triangles {
        return Err(FitError::Input(
            "the model has another mesh than the template".into(),
        ));
    }
    let named: Vec<(&str, &[&str])> = ARKIT.iter().map(alone).collect();
    let expressions = Expressions::read(&named, template, data_dir)?;
    let performer = Performer::new(template, &expressions)?;
    let mean: Vec<DVec3> = parts.mean.iter().map(|p| p.as_dvec3()).collect();
    let balls = [
        template.part_vertices("left eyeball")?,
        template.part_vertices("right eyeball")?,
    ];
    let landmark = |name: &str| -> FitResult<u32> {
        let found = parts.landmarks.iter().position(|l| l.name == name);
        let missing = || FitError::Input(format!("the model has no landmark {name:?}"));
        found.map(|l| l as u32).ok_or_else(missing)
    };
    let lips = Lips::new(template, &mean)?;
    let own: Vec<(Vec<DVec3>, [DVec3; 2])> = (expressions.list.par_iter())
        .map(|expression| {
            let moved = performer.on(&mean, expression);
            let turns = [0, 1].map(|side| {
                let even = vec![1.0; mean.len()];
                let pose = Rigid::fit(&mean, &moved, &balls[side], &even);
                let turn = glam::DQuat::from_mat3(&pose.rotation).to_scaled_axis();
                if turn.length() < LEAST_TURN {
                    DVec3::ZERO
                } else {
                    turn
                }
            });
            let mut moves: Vec<DVec3> = moved.iter().zip(&mean).map(|(p, m)| *p - *m).collect();
            lips.draw(&expression.name, &mean, &mut moves);
            for &v in balls.iter().flatten() {
                moves[v as usize] = DVec3::ZERO;
            }
            (moves, turns)
        })
        .collect();
    let mirror = &template.topology.mirror;
    ARKIT
        .iter()
        .enumerate()
        .map(|(i, &name)| {
            let image = image_of(i);
            let moves: Vec<DVec3> = (0..mean.len())
                .map(|v| {
                    let there = own[image].0[mirror[v] as usize];
                    (own[i].0[v] + DVec3::new(-there.x, there.y, there.z)) / 2.0
                })
                .collect();
            // The mirror image of an axis is a pseudo-vector.
            let turns = [0, 1].map(|side| {
                let there = own[image].1[1 - side];
                ((own[i].1[side] + DVec3::new(there.x, -there.y, -there.z)) / 2.0).as_vec3()
            });
            // What rounds to nothing anyway.
            let support: Vec<u32> = (0..mean.len() as u32)
                .filter(|&v| moves[v as usize].abs().max_element() > 0.5 * f64::from(STEP))
                .collect();
            let lids = LIDS.iter().find(|lids| lids.0 == name);
            let meets = lids.map_or(Ok(Vec::new()), |lids| {
                let pairs = lids.1.iter();
                pairs
                    .map(|pair| Ok([landmark(pair[0])?, landmark(pair[1])?]))
                    .collect::<FitResult<_>>()
            })?;
            Ok(crate::expression::Expression {
                name: name.into(),
                displacements: (support.iter())
                    .map(|&v| moves[v as usize].as_vec3())
                    .collect(),
                support,
                turns,
                meets,
            })
        })
        .collect()
}

/// Expressions that draw the lips against the teeth, of both sides, and by how many mm the upper and the lower lip.
const DRAWN: [(&str, [f64; 2]); 5] = [
    ("mouthSmile", [3.5, 3.5]),
    ("mouthDimple", [1.2, 1.2]),
    ("mouthStretch", [2.5, 2.5]),
    ("mouthUpperUp", [1.5, 0.0]),
    ("mouthLowerDown", [0.0, 1.5]),
];

/// The front teeth stand so far behind where the lips meet, mm, as the page draws them.
const TEETH: f64 = 2.6;
/// Skin is lip up to the first of these distances from the lips' points, mm, and not at all from the second on.
const LIP: [f64; 2] = [4.0, 15.0];
/// One side's muscles draw the other side's lips up to so far from the middle, mm.
const ACROSS: f64 = 14.0;

/// The lips of a head at rest, which become thinner where they are drawn against the teeth. The base mesh's
/// expressions leave them as thick as they are, an empty pouch behind them: from the side, a smile would stand off its
/// teeth.
struct Lips {
    /// How much each vertex is of them.
    share: Vec<f64>,
    /// Where the upper and the lower lip meet, and where teeth stand and lips end, along z.
    line: f64,
    depth: [f64; 2],
}

impl Lips {
    fn new(template: &Template, mean: &[DVec3]) -> FitResult<Self> {
        let point = |i: u32| {
            let name = format!("ibug_{i}");
            let found = template.landmarks.iter().position(|l| l.name == name);
            let missing = || FitError::Input(format!("the head has no landmark {name:?}"));
            Ok(template.landmark(found.ok_or_else(missing)?, mean))
        };
        let points: Vec<DVec3> = (48..68).map(point).collect::<FitResult<_>>()?;
        // 51 and 57 are the middles of the lips' outer edges, 62 and 66 of their inner ones.
        let [upper, lower] = [points[62 - 48], points[66 - 48]];
        let front = points[51 - 48].z.max(points[57 - 48].z);
        let share = mean
            .iter()
            .map(|p| {
                let near = points.iter().map(|q| q.distance(*p));
                let near = near.fold(f64::INFINITY, f64::min);
                let t = ((LIP[1] - near) / (LIP[1] - LIP[0])).clamp(0.0, 1.0);
                t * t * (3.0 - 2.0 * t)
            })
            .collect();
        Ok(Self {
            share,
            line: (upper.y + lower.y) / 2.0,
            depth: [upper.z.min(lower.z) - TEETH, front],
        })
    }

    /// Adds to an expression's displacements of the mean head what draws its lips back.
    fn draw(&self, name: &str, mean: &[DVec3], moves: &mut [DVec3]) {
        let Some((_, [upper, lower])) = DRAWN.iter().find(|d| name.starts_with(d.0)) else {
            return;
        };
        let side = if name.ends_with("Left") { 1.0 } else { -1.0 };
        let [teeth, front] = self.depth;
        for ((p, moved), share) in mean.iter().zip(moves).zip(&self.share) {
            let own = (0.5 + side * p.x / (2.0 * ACROSS)).clamp(0.0, 1.0);
            let by = if p.y > self.line { upper } else { lower };
            // Thinner, not farther back: what is at the teeth stays.
            let thick = ((p.z - teeth) / (front - teeth)).max(0.0);
            moved.z -= share * own * by * thick;
        }
    }
}

/// An expression that is one target, of the same name.
fn alone<'a>(name: &'a &'static str) -> (&'a str, &'a [&'static str]) {
    (name, std::slice::from_ref(name))
}

/// What can be told of a face on a scan: all of [`ARKIT`] but where the eyes look, what shuts lips over
/// an open jaw, and what might as well be the shape of a face, on a template's own rest pose.
///
/// # Errors
/// When the base mesh cannot be read, or has another topology.
pub fn visible(template: &Template, data_dir: &Path) -> FitResult<Vec<Expression>> {
    let shape = ["mouthClose", "cheekPuff", "jawForward"];
    let seen = |name: &&&str| !name.starts_with("eyeLook") && !shape.contains(name);
    let named: Vec<(&str, &[&str])> = ARKIT.iter().filter(seen).map(alone).collect();
    let expressions = Expressions::read(&named, template, data_dir)?;
    let performer = Performer::new(template, &expressions)?;
    let rest = &template.positions;
    Ok(expressions
        .list
        .par_iter()
        .map(|expression| {
            let moved = performer.on(rest, expression);
            Expression {
                name: expression.name.clone(),
                displacements: moved.iter().zip(rest).map(|(m, r)| *m - *r).collect(),
            }
        })
        .collect())
}

/// The place of the mirror image of one of [`ARKIT`].
fn image_of(i: usize) -> usize {
    let name = ARKIT[i];
    if name.ends_with("Left") {
        i + 1
    } else if name.ends_with("Right") {
        i - 1
    } else {
        i
    }
}

/// An expression as the displacement of each of the template's vertices.
#[derive(Debug, Clone, PartialEq)]
pub struct Expression {
    /// Its name: ARKit's, or of a pair ARKit's without the side.
    pub name: String,
    /// Displacements at full strength of the vertices of some head, mm.
    pub displacements: Vec<DVec3>,
}

/// Expressions and the head that they were made for.
#[derive(Debug, Clone, Default)]
pub struct Expressions {
    /// The base mesh as it is in its file, in the template's topology, mm: its lids are as far
    /// open as its eyeBlink closes them. The template's own rest pose is another head.
    pub rest: Vec<DVec3>,
    /// The expressions, on that head.
    pub list: Vec<Expression>,
}

impl Expressions {
    /// Reads expressions from `data_dir`, the base mesh's data folder: each a name and the targets
    /// of `faceunits01` that it is the sum of.
    ///
    /// # Errors
    /// When the base mesh or a target is missing or unreadable.
    pub fn read(
        named: &[(&str, &[&str])],
        template: &Template,
        data_dir: &Path,
    ) -> FitResult<Self> {
        let base = BaseMesh::read(data_dir)?;
        let folder = data_dir.join("faceunits01/targets/faceunits");
        let list = named
            .iter()
            .map(|(name, targets)| {
                let mut moved = vec![DVec3::ZERO; base.positions.len()];
                for target in *targets {
                    let path = folder.join(format!("{target}.target"));
                    for (vertex, displacement) in read_target(&path, base.positions.len())?.entries
                    {
                        moved[vertex as usize] += displacement;
                    }
                }
                Ok(Expression {
                    name: (*name).into(),
                    displacements: template.stencils.apply(&moved),
                })
            })
            .collect::<FitResult<_>>()?;
        Ok(Self {
            rest: template.stencils.apply(&base.positions),
            list,
        })
    }
}

/// Puts expressions on heads.
#[derive(Debug, Clone)]
pub struct Performer<'a> {
    /// What it can put on heads.
    pub expressions: &'a Expressions,
    skin: Vec<u32>,
    /// The pairs of triangles of the skin that should not fold.
    pub folds: Folds,
    neighbours: Vec<Vec<u32>>,
}

impl<'a> Performer<'a> {
    /// Prepares a template.
    ///
    /// # Errors
    /// When it has no skin.
    pub fn new(template: &Template, expressions: &'a Expressions) -> FitResult<Self> {
        Ok(Self {
            expressions,
            skin: template.part_vertices("skin")?,
            folds: Folds::new(&template.positions, template.part_triangles("skin")?),
            neighbours: edge_neighbours(template.positions.len(), &template.triangles()),
        })
    }

    /// An expression on a face (all vertices of the template, mm, in any pose).
    pub fn on(&self, face: &[DVec3], expression: &Expression) -> Vec<DVec3> {
        let moves = self.carried(face, &expression.displacements);
        let mut gains = vec![1.0; face.len()];
        let mut moved = Vec::new();
        for _ in 0..ROUNDS {
            let shares = moves.iter().zip(&gains);
            moved = face
                .iter()
                .zip(shares)
                .map(|(p, (d, g))| *p + *d * *g)
                .collect();
            let folded = self.folds.of(&moved);
            if folded.is_empty() || self.folds.even_out(&mut moved, &self.neighbours) {
                break;
            }
            self.calm(&self.folds.vertices(&folded), &mut gains);
        }
        moved
    }

    /// Lessens the gains of some vertices, and of those around them so that no edge has more than
    /// [`SLOPE`] between its ends.
    fn calm(&self, vertices: &[u32], gains: &mut [f64]) {
        let mut queue: VecDeque<u32> = vertices.iter().copied().collect();
        for &v in vertices {
            gains[v as usize] *= CALMER;
        }
        while let Some(v) = queue.pop_front() {
            let most = gains[v as usize] + SLOPE;
            for &n in &self.neighbours[v as usize] {
                if gains[n as usize] > most {
                    gains[n as usize] = most;
                    queue.push_back(n);
                }
            }
        }
    }
}

impl Performer<'_> {
    /// Displacements of the rest pose on a face: each turned and stretched as the face is around
    /// its vertex, over a distance of the greatest displacement. So lids that have half the way to
    /// go go half the way.
    fn carried(&self, face: &[DVec3], displacements: &[DVec3]) -> Vec<DVec3> {
        let rest = &self.expressions.rest;
        let whole = similarity(rest, face, &self.skin);
        let largest = displacements.iter().map(|d| d.length()).fold(0.0, f64::max);
        let reach = largest.max(1.0);
        // As many vertices are asked at any reach.
        let some = ((reach / FEW).powi(2) as usize).max(1);
        let asked: Vec<u32> = self.skin.iter().copied().step_by(some).collect();
        let near = Cells::new(rest, &asked, reach);
        displacements
            .par_iter()
            .enumerate()
            .map(|(v, &d)| {
                if d == DVec3::ZERO {
                    return d;
                }
                // Weighted least squares for the linear part (moving least squares; Schaefer et
                // al. 2006, eq. 5), held to that of the whole head where the surface is flat.
                let around: Vec<(u32, f64)> = near
                    .around(rest[v])
                    .map(|u| (u, rest[u as usize].distance(rest[v]) / reach))
                    .filter(|n| n.1 < 1.0)
                    .map(|(u, t)| (u, (1.0 - t * t).powi(2)))
                    .collect();
                let total: f64 = around.iter().map(|n| n.1).sum();
                if total == 0.0 {
                    return whole * d;
                }
                let centre = |shape: &[DVec3]| {
                    around
                        .iter()
                        .map(|&(u, w)| shape[u as usize] * w)
                        .sum::<DVec3>()
                        / total
                };
                let (from, to) = (centre(rest), centre(face));
                let (mut across, mut square) = (DMat3::ZERO, DMat3::ZERO);
                for &(u, w) in &around {
                    let p = rest[u as usize] - from;
                    let q = face[u as usize] - to;
                    for axis in 0..3 {
                        *across.col_mut(axis) += q * (p[axis] * w);
                        *square.col_mut(axis) += p * (p[axis] * w);
                    }
                }
                let trace = square.x_axis.x + square.y_axis.y + square.z_axis.z;
                let held = HELD * (trace + total);
                let stretch = (across + whole * held) * (square + DMat3::IDENTITY * held).inverse();
                stretch * d
            })
            .collect()
    }
}

/// Vertices sorted into cubes, to find those near a point.
struct Cells {
    size: f64,
    low: DVec3,
    /// Cube and vertex, sorted.
    rows: Vec<([i32; 3], u32)>,
}

impl Cells {
    fn new(positions: &[DVec3], vertices: &[u32], size: f64) -> Self {
        let low = vertices
            .iter()
            .fold(DVec3::INFINITY, |low, &v| low.min(positions[v as usize]));
        let mut cells = Self {
            size,
            low,
            rows: Vec::new(),
        };
        cells.rows = vertices
            .iter()
            .map(|&v| (cells.cube(positions[v as usize]), v))
            .collect();
        cells.rows.sort_unstable();
        cells
    }

    fn cube(&self, p: DVec3) -> [i32; 3] {
        ((p - self.low) / self.size)
            .to_array()
            .map(|x| x.floor() as i32)
    }

    /// The vertices in the cube of a point and those around it: all within [`Cells::size`], and
    /// some more.
    fn around(&self, p: DVec3) -> impl Iterator<Item = u32> + '_ {
        let [x, y, z] = self.cube(p);
        let columns = (-1..=1).flat_map(move |i| (-1..=1).map(move |j| (x + i, y + j)));
        columns.flat_map(move |(x, y)| {
            let first = self.rows.partition_point(|row| row.0 < [x, y, z - 1]);
            let end = self.rows.partition_point(|row| row.0 < [x, y, z + 2]);
            self.rows[first..end].iter().map(|row| row.1)
        })
    }
}

/// The rotation and scale from one shape to another over some vertices (Umeyama 1991).
pub fn similarity(from: &[DVec3], to: &[DVec3], vertices: &[u32]) -> DMat3 {
    let even = vec![1.0; from.len()];
    let pose = Rigid::fit(from, to, vertices, &even);
    let centre = |points: &[DVec3]| {
        vertices.iter().map(|&v| points[v as usize]).sum::<DVec3>() / vertices.len().max(1) as f64
    };
    let (from_centre, to_centre) = (centre(from), centre(to));
    let (mut along, mut square) = (0.0, 0.0);
    for &v in vertices {
        let p = from[v as usize] - from_centre;
        along += (pose.rotation * p).dot(to[v as usize] - to_centre);
        square += p.length_squared();
    }
    if square > 0.0 {
        pose.rotation * (along / square)
    } else {
        pose.rotation
    }
}
