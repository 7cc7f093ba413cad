//! Semantic controls: named edits that change one measure of a face and leave the others
//! (semantic reshaping, section 3.3).
//!
//! A sparse basis ([`sparse`]) gives each part of the face components of its own. A control's
//! direction is a combination of those of its part, scaled so that its measure moves by one standard
//! deviation of the population. There are three ways to find it ([`Method`]); what each of them does
//! to the measures of the other controls is in its [`Table`], which is the truth about a "semantic"
//! basis.
//!
//! Both eyes move together in some controls and alone in others: components are learned from people
//! and their mirror images, a direction of one eye is faded out across the midline, and that of the
//! other is its mirror image. Where people differ on one side only, images do not count, and each eye has a direction of
//! its own; what moves both sides moves them alike all the same.

use std::collections::BTreeMap;

use glam::{DVec3, Vec3};
use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;
use serde::Serialize;

use super::measures::{self, GUARDED, MEASURES, SEMANTIC};
use super::quantiles;
use crate::anatomy::{Landmark, Measure};
use crate::fit::head::folds::{Stretches, edge_neighbours};
use crate::fit::head::template::Template;
use crate::fit::mesh::align::vertex_areas;
use crate::fit::mesh::geodesic::Geodesic;
use crate::fit::mesh::mirror::mirrored;
use crate::fit::sparse::{self, Region, SparseBasis, head_parts};
use crate::fit::{FitError, FitResult};
use crate::model::{Block, Control, LIMIT, ModelParts, Modes};
use crate::quantise::Quantised;

/// How the directions of controls are found.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Method {
    /// The paper's: regress the measures on the components' weights, [1 | W] -> L; a control's
    /// direction is its row of the regression. From the one with the largest row on, each is made
    /// orthogonal to those before it (Gram and Schmidt), but for those that are computed from the
    /// same lengths.
    Regression,
    /// The mean change of the weights with a measure while the others stay, Cov(W, L) Cov(L)^-1: the
    /// inverse of the controls' covariance, as FaceGen has it.
    InverseCovariance,
    /// The most probable weights (of least Mahalanobis length) that move one measure and no other.
    Constrained,
}

impl Method {
    /// All of them.
    pub const ALL: [Self; 3] = [
        Method::Regression,
        Method::InverseCovariance,
        Method::Constrained,
    ];
}

/// Components of the sparse basis over the features and their surround.
const COMPONENTS: usize = 100;
/// The band around a part in which its components end, mm along the surface.
pub const BAND: f64 = 22.0;
/// Across the midline, a direction of one eye fades out over this to both sides, mm.
const MIDLINE: f64 = 8.0;
/// The step of a local block's modes, mm a standard deviation of the measure: rounding moves a
/// vertex by no more than 0.02 mm at 2 of them, which is a tenth of what rounds a pore.
const STEP: f32 = 0.02;
/// A measure that a component moves by less than this, in standard deviations of both, is not one
/// of its part.
const NEGLIGIBLE: f64 = 1e-3;

/// What differs by less, mm a standard deviation, is the same for all: the rest is rounding, which would be magnified to
/// something that others must not change.
const SAME: f64 = 1e-3;

/// What other measures may change by while a constrained control moves its own by one standard
/// deviation, about, in theirs: holding them altogether would take faces that nobody has, where two
/// parts meet or a part has too few components.
const LEEWAY: f64 = 0.006;

/// How much a rough field counts beside an unusual one, 1 / mm^2: the sum over vertices of the
/// squared distance (mm) between a vertex's displacement and its neighbours' mean, at one standard
/// deviation. Of the directions that the constraints leave, the most probable is one of wrinkles
/// wherever wrinkles are what people differ in; a person who asks for a longer nose wants none.
const ROUGHNESS: f64 = 200.0;

/// The control that people take far beyond its limits (Fig. 9), and how much roughness counts in it:
/// what is no wrinkle at 2 mm is one at 40. It still changes other measures by hardly a hundredth of
/// their standard deviation; others would by a tenth to a third.
const TAKEN_FAR: (&str, f64) = ("nose length", 4000.0);

/// A control's slider ends where some triangle of the mean head is this much narrower along some
/// direction: lips or lids that are squeezed more look crumpled. Where a neighbour leaves no room, a
/// part cannot go as far as people do, who have the neighbour elsewhere too.
const NARROWEST: f64 = 0.4;
/// The steps in which ends are looked for, in standard deviations.
const END_STEP: f64 = 0.05;
/// Smaller triangles of the mean head tell nothing, mm^2: those of the corners of eyes and nostrils.
const SEEN: f64 = 0.025;

/// What a control's field does under reflection.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Symmetry {
    /// It is its own mirror image.
    Even,
    /// It is the opposite of its mirror image.
    Odd,
    /// It is of the left side alone.
    Left,
    /// It is of the right side alone: the mirror image of a control of the left side, where images count.
    Right,
}

impl Symmetry {
    fn of(measure: &str) -> Self {
        match measure {
            name if name.contains("lateral") => Symmetry::Odd,
            name if name.starts_with("left") => Symmetry::Left,
            name if name.starts_with("right") => Symmetry::Right,
            _ => Symmetry::Even,
        }
    }
}

/// What moving each control by some standard deviations of its measure does to all of theirs.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Table {
    /// How the directions were found.
    pub method: Method,
    /// Names of the controls, which are those of their measures.
    pub controls: Vec<String>,
    /// For +1, -1, +2 and -2 standard deviations: a row a control that was moved, of what each
    /// measure changed by, in its standard deviations.
    pub moved: Vec<(f64, Vec<Vec<f64>>)>,
    /// The standard deviation of each measure, mm.
    pub sigmas: Vec<f64>,
    /// The Mahalanobis length of each direction: how unusual a face is with one standard deviation
    /// more.
    pub lengths: Vec<f64>,
    /// For each control, the others that are computed from the same lengths.
    pub tied: Vec<Vec<usize>>,
}

impl Table {
    /// The largest change of a measure that was not asked for, in standard deviations, with the
    /// control that was moved and the measure; of measures that are not tied.
    pub fn worst(&self) -> (f64, usize, usize) {
        let mut worst = (0.0, 0, 0);
        for (_, rows) in &self.moved {
            for (i, row) in rows.iter().enumerate() {
                for (j, change) in row.iter().enumerate() {
                    if i != j && !self.tied[i].contains(&j) && change.abs() > worst.0 {
                        worst = (change.abs(), i, j);
                    }
                }
            }
        }
        worst
    }

    /// The root mean square of the changes that were not asked for, in standard deviations.
    pub fn rms(&self) -> f64 {
        let (mut sum, mut count) = (0.0, 0);
        for (_, rows) in &self.moved {
            for (i, row) in rows.iter().enumerate() {
                for (j, change) in row.iter().enumerate() {
                    if i != j && !self.tied[i].contains(&j) {
                        sum += change * change;
                        count += 1;
                    }
                }
            }
        }
        (sum / f64::from(count.max(1))).sqrt()
    }
}

/// Whether one of two measures is computed from lengths of the other.
pub fn tied(a: &Measure, b: &Measure) -> bool {
    let (a, b) = (a.quantity.terms(), b.quantity.terms());
    a.iter().any(|term| b.contains(term))
}

/// What was learned: the parts that a model gets, and a table a method.
#[derive(Debug, Clone)]
pub struct Semantics {
    /// Local blocks, one a part of the face.
    pub blocks: Vec<Block>,
    /// The controls.
    pub controls: Vec<Control>,
    /// Cross-talk of each method.
    pub tables: Vec<Table>,
}

/// A control's field over the whole head: how each vertex moves with one standard deviation of its
/// measure, mm.
type Field = Vec<DVec3>;

/// A part's components, faded out in its band, in standard deviations.
struct Candidates {
    /// All vertices, one field a component.
    fields: Vec<Field>,
    /// F rows of what the faces have of each, sigmas.
    weights: Vec<Vec<f64>>,
}

struct Population<'a> {
    template: &'a Template,
    mean: &'a [DVec3],
    landmarks: &'a [Landmark],
    /// Those of the controls, then those that are guarded.
    measures: Vec<Measure>,
    /// Rows of what each face measures, mm; then those of the mirror images, where these count.
    lengths: Vec<Vec<f64>>,
    /// How many faces there are, without images.
    faces: usize,
    means: Vec<f64>,
    /// Their standard deviations, mm, [`SAME`] at least.
    sigmas: Vec<f64>,
    /// The vertices beside each vertex.
    neighbours: Vec<Vec<u32>>,
    /// How triangles of a head are stretched beside those of the mean head.
    stretches: Stretches,
}

/// Learns semantic controls from faces in the pose of `parts` (all vertices, mm), whose blocks and
/// measures are there already; from their mirror images too, if `both_sides` count.
///
/// A control that nothing in its part can move, because there are too few faces, is left out, and one of what is the same for
/// all faces, as how far to a side is for faces whose sides are alike.
///
/// # Errors
/// When the template lacks a part, or the sparse basis cannot be learned.
pub fn learn(
    template: &Template,
    faces: &[Vec<DVec3>],
    parts: &ModelParts,
    both_sides: bool,
    method: Method,
) -> FitResult<Semantics> {
    let mean: Vec<DVec3> = parts.mean.iter().map(|p| p.as_dvec3()).collect();
    let triangles = template.triangles();
    let surface = Geodesic::new(&mean, &triangles);
    let features = features(template, parts, &surface)?;
    let fades: Vec<Vec<f64>> = (features.par_iter())
        .map(|feature| fade(&surface, feature))
        .collect();
    let areas = vertex_areas(&mean, &triangles);
    let smooth: Vec<Smooth> = (features.par_iter())
        .map(|feature| Smooth::new(&mean, &surface, &feature.vertices, &areas))
        .collect::<FitResult<_>>()?;
    let population = Population::new(template, &mean, parts, faces, both_sides)?;
    let images = if both_sides { 2 } else { 1 };
    // The faces, then their mirror images where they count. Of all of them at once only how the modelled vertices
    // are off the mean is kept, in f32 (a part of ten million of a few mm).
    let modelled: Vec<u32> = features.iter().flat_map(|f| &f.vertices).copied().collect();
    let (off, amounts): (Vec<Vec<Vec3>>, Vec<_>) = (0..images * faces.len())
        .into_par_iter()
        .map(|i| {
            let (placed, amounts) = match i.checked_sub(faces.len()) {
                None => in_place(&faces[i], &mean, &smooth, &fades),
                Some(i) => in_place(&population.mirror_image(&faces[i]), &mean, &smooth, &fades),
            };
            let off = |&v: &u32| (placed[v as usize] - mean[v as usize]).as_vec3();
            (modelled.iter().map(off).collect::<Vec<_>>(), amounts)
        })
        .unzip();
    let (count, average) = (off.len(), mean.clone());
    let placed = move |i: usize| {
        let mut face = average.clone();
        let each = modelled.iter().zip(&off[i]);
        each.for_each(|(&v, d)| face[v as usize] += d.as_dvec3());
        face
    };
    let settings = sparse::Settings {
        components: COMPONENTS.min(images * (faces.len() - 1)),
        // Controls are combinations of them: how sparse exactly they are is not seen.
        tolerance: 5e-3,
        residual: 1e-2,
        ..sparse::Settings::default()
    };
    let basis = sparse::learn_from(count, placed, &triangles, &features, &settings)?;
    let basis = basis.in_sigmas();
    let mut candidates = BTreeMap::new();
    for (place, feature) in features.iter().enumerate() {
        let own: Vec<&[f64]> = (amounts.iter())
            .map(|each: &Vec<Vec<f64>>| &each[place][..])
            .collect();
        let fields = smooth[place].fields(&mean, &fades[place]);
        let found = Candidates::new(&basis, &feature.name, &fades[place], &fields, &own);
        candidates.insert(feature.name.clone(), found);
    }
    let mut tables = Vec::new();
    let mut kept: Vec<(usize, Field)> = Vec::new();
    for tried in Method::ALL {
        let found = population.fields(&candidates, tried)?;
        tables.push(population.table(tried, &found));
        if tried == method {
            kept = found.into_iter().map(|(i, field, _)| (i, field)).collect();
        }
    }
    let (blocks, controls) = population.bake(&kept, parts);
    Ok(Semantics {
        blocks,
        controls,
        tables,
    })
}

/// The features, and the vertices that follow them as one more. The forehead is the wide one of the
/// paper's parts, with the temples: the feature of a model is hardly as wide as it is high.
fn features(
    template: &Template,
    parts: &ModelParts,
    surface: &Geodesic<'_>,
) -> FitResult<Vec<Region>> {
    let wide = head_parts(template)?;
    let mut left = vec![true; parts.mean.len()];
    let mut features = Vec::new();
    let mut blocks: Vec<&Block> = parts
        .blocks
        .iter()
        .filter(|b| b.surround.is_some())
        .collect();
    // The wide forehead takes what the others leave.
    blocks.sort_by_key(|b| b.name == "forehead");
    for block in blocks {
        let mut vertices = block.support.clone();
        if let Some(part) = wide
            .iter()
            .find(|p| p.name == "forehead" && p.name == block.name)
        {
            vertices.clone_from(&part.vertices);
        }
        vertices.retain(|&v| std::mem::replace(&mut left[v as usize], false));
        features.push(Region {
            name: block.name.clone(),
            vertices,
        });
    }
    let taken: Vec<u32> = features.iter().flat_map(|f| &f.vertices).copied().collect();
    let distance = surface.distances(&taken, BAND);
    let around = (0..parts.mean.len() as u32)
        .filter(|&v| left[v as usize] && distance[v as usize] < BAND)
        .collect();
    features.push(Region {
        name: "rest".into(),
        vertices: around,
    });
    Ok(features)
}

/// How much of a feature's motion each vertex follows: 1 in it, sinking smoothly to 0 through its
/// band.
fn fade(surface: &Geodesic<'_>, feature: &Region) -> Vec<f64> {
    let distance = surface.distances(&feature.vertices, BAND);
    let each = distance.iter().map(|d| 1.0 - step((d / BAND).min(1.0)));
    each.collect()
}

/// How a feature is placed, proportioned and bent: smooth fields. Affine ones reach as far as the
/// feature is followed, and [`without_proportions`](crate::fit::mesh::align::without_proportions) takes those
/// of a whole head out likewise; quadratic ones end at the feature's border, so that it can change
/// without pulling at what is around it.
struct Smooth<'a> {
    vertices: &'a [u32],
    centre: DVec3,
    /// How much each of the vertices has of the quadratic fields: none at the border.
    within: Vec<f64>,
    /// Weighted pseudo-inverses: amounts from displacements of the vertices.
    solve: [DMatrix<f64>; 2],
}

/// The length by which coordinates are divided, about a feature's half width, mm.
const REACH: f64 = 30.0;

/// So far from a feature's border, mm along the surface, quadratic fields are what they are.
const WITHIN: f64 = 14.0;

/// Functions of [`affine`] and of [`quadratic`].
const AFFINE: usize = 4;
const QUADRATIC: usize = 10;

impl<'a> Smooth<'a> {
    fn new(
        mean: &[DVec3],
        surface: &Geodesic<'_>,
        vertices: &'a [u32],
        areas: &[f64],
    ) -> FitResult<Self> {
        let total: f64 = vertices.iter().map(|&v| areas[v as usize]).sum();
        let weighted = vertices
            .iter()
            .map(|&v| mean[v as usize] * areas[v as usize]);
        let centre = weighted.sum::<DVec3>() / total;
        let mut inside = vec![false; mean.len()];
        vertices.iter().for_each(|&v| inside[v as usize] = true);
        let outside: Vec<u32> = (0..mean.len() as u32)
            .filter(|&v| !inside[v as usize])
            .collect();
        let distance = surface.distances(&outside, WITHIN);
        let within: Vec<f64> = (vertices.iter())
            .map(|&v| step((distance[v as usize] / WITHIN).min(1.0)))
            .collect();
        let share = |i: usize| areas[vertices[i] as usize] / total;
        let place = |i: usize| mean[vertices[i] as usize];
        let n = vertices.len();
        let affine = DMatrix::from_fn(n, AFFINE, |i, j| affine(place(i), centre)[j]);
        let quadratic = DMatrix::from_fn(n, QUADRATIC, |i, j| {
            quadratic(place(i), centre)[j] * within[i]
        });
        let solve = [
            pseudo_inverse(&affine, share)?,
            pseudo_inverse(&quadratic, share)?,
        ];
        Ok(Self {
            vertices,
            centre,
            within,
            solve,
        })
    }

    /// Of a face's feature, mm: for x, then y, then z the amounts of the affine functions; then
    /// those of the quadratic ones in what is left.
    fn of(&self, face: &[DVec3], mean: &[DVec3]) -> Vec<f64> {
        let mut moved = DMatrix::from_fn(self.vertices.len(), 3, |i, axis| {
            let v = self.vertices[i] as usize;
            face[v][axis] - mean[v][axis]
        });
        let whole = &self.solve[0] * &moved;
        for (i, &v) in self.vertices.iter().enumerate() {
            let taken = self.affine(whole.as_slice(), mean[v as usize]);
            (0..3).for_each(|axis| moved[(i, axis)] -= taken[axis]);
        }
        let inner = &self.solve[1] * moved;
        whole.iter().chain(inner.iter()).copied().collect()
    }

    /// What the affine part of amounts moves a point of the mean by, mm.
    fn affine(&self, amounts: &[f64], p: DVec3) -> DVec3 {
        sum_of(&amounts[..3 * AFFINE], &affine(p, self.centre))
    }

    /// What the quadratic part of amounts moves vertex i of the feature by, mm.
    fn quadratic(&self, amounts: &[f64], i: usize, p: DVec3) -> DVec3 {
        sum_of(&amounts[3 * AFFINE..], &quadratic(p, self.centre)) * self.within[i]
    }

    /// The field of each amount, of 1 mm; `fade` is how much each vertex follows the feature.
    fn fields(&self, mean: &[DVec3], fade: &[f64]) -> Vec<Field> {
        let field = |k: usize| {
            let mut amounts = vec![0.0; 3 * (AFFINE + QUADRATIC)];
            amounts[k] = 1.0;
            if k < 3 * AFFINE {
                let each = mean.iter().zip(fade);
                return each.map(|(&p, f)| self.affine(&amounts, p) * *f).collect();
            }
            let mut field = vec![DVec3::ZERO; mean.len()];
            for (i, &v) in self.vertices.iter().enumerate() {
                field[v as usize] = self.quadratic(&amounts, i, mean[v as usize]);
            }
            field
        };
        (0..3 * (AFFINE + QUADRATIC)).map(field).collect()
    }
}

/// How much roughness counts in a control.
fn roughness(control: usize) -> f64 {
    let (name, far) = TAKEN_FAR;
    if MEASURES[control].name == name {
        far
    } else {
        ROUGHNESS
    }
}

/// From 0 to 1, level at both.
fn step(t: f64) -> f64 {
    t * t * (3.0 - 2.0 * t)
}

/// Coordinates about a centre, and 1.
fn affine(p: DVec3, centre: DVec3) -> [f64; AFFINE] {
    let about = (p - centre) / REACH;
    [about.x, about.y, about.z, 1.0]
}

/// The same, and their products.
fn quadratic(p: DVec3, centre: DVec3) -> [f64; QUADRATIC] {
    let [x, y, z, one] = affine(p, centre);
    [x, y, z, one, x * x, y * y, z * z, x * y, y * z, z * x]
}

/// A displacement whose coordinates are sums of functions, those of x first.
fn sum_of(amounts: &[f64], functions: &[f64]) -> DVec3 {
    let along = |axis: usize| {
        let own = &amounts[axis * functions.len()..];
        functions.iter().zip(own).map(|(f, a)| f * a).sum()
    };
    DVec3::new(along(0), along(1), along(2))
}

/// The amounts of some functions (columns) by weighted least squares.
fn pseudo_inverse(
    functions: &DMatrix<f64>,
    weight: impl Fn(usize) -> f64,
) -> FitResult<DMatrix<f64>> {
    let mut weighted = functions.transpose();
    for (i, mut column) in weighted.column_iter_mut().enumerate() {
        column.scale_mut(weight(i));
    }
    let mut normal = &weighted * functions;
    // A feature that is flat in some direction has no proportion along it.
    (0..normal.nrows()).for_each(|i| normal[(i, i)] += 1e-6);
    match normal.cholesky() {
        Some(factor) => Ok(factor.solve(&weighted)),
        None => Err(FitError::Input("a feature has no extent".into())),
    }
}

/// A face with every feature placed, proportioned and bent as the mean's; between features what that
/// takes blends. Components that had places and proportions too would end in a step; so these have
/// smooth fields of their own. Returns the face, and the amounts of each feature's.
fn in_place(
    face: &[DVec3],
    mean: &[DVec3],
    features: &[Smooth<'_>],
    fades: &[Vec<f64>],
) -> (Vec<DVec3>, Vec<Vec<f64>>) {
    let amounts: Vec<Vec<f64>> = features.iter().map(|f| f.of(face, mean)).collect();
    let mut placed: Vec<DVec3> = (0..face.len())
        .map(|v| {
            let total: f64 = fades.iter().map(|fade| fade[v]).sum();
            if total == 0.0 {
                return face[v];
            }
            let taken = features
                .iter()
                .zip(&amounts)
                .zip(fades)
                .map(|((f, a), fade)| f.affine(a, mean[v]) * (fade[v] / total));
            face[v] - taken.sum::<DVec3>()
        })
        .collect();
    for (feature, amounts) in features.iter().zip(&amounts) {
        for (i, &v) in feature.vertices.iter().enumerate() {
            placed[v as usize] -= feature.quadratic(amounts, i, mean[v as usize]);
        }
    }
    (placed, amounts)
}

impl Candidates {
    /// The components of a feature, and its smooth fields as one more each, of which each face has
    /// `amounts` (mm).
    fn new(
        basis: &SparseBasis,
        feature: &str,
        fade: &[f64],
        smooth: &[Field],
        amounts: &[&[f64]],
    ) -> Self {
        let own: Vec<usize> = (0..basis.components.len())
            .filter(|&k| basis.components[k].region.as_deref() == Some(feature))
            .collect();
        let mut weights: Vec<Vec<f64>> = (basis.weights.iter())
            .map(|row| own.iter().map(|&k| row[k]).collect())
            .collect();
        let mut fields: Vec<Field> = (own.iter())
            .map(|&k| {
                let mut field = vec![DVec3::ZERO; fade.len()];
                let component = &basis.components[k];
                for (&v, &d) in component.support.iter().zip(&component.displacements) {
                    field[v as usize] = d * fade[v as usize];
                }
                field
            })
            .collect();
        for (i, field) in smooth.iter().enumerate() {
            let along: Vec<f64> = amounts.iter().map(|a| a[i]).collect();
            let square: f64 = along.iter().map(|m| m * m).sum();
            let sigma = (square / (along.len() - 1) as f64).sqrt();
            if sigma > SAME {
                fields.push(field.iter().map(|d| *d * sigma).collect());
                let rows = weights.iter_mut().zip(&along);
                rows.for_each(|(row, m)| row.push(m / sigma));
            }
        }
        Self { fields, weights }
    }
}

impl<'a> Population<'a> {
    fn new(
        template: &'a Template,
        mean: &'a [DVec3],
        parts: &'a ModelParts,
        faces: &[Vec<DVec3>],
        both_sides: bool,
    ) -> FitResult<Self> {
        let landmarks = &parts.landmarks[..];
        let mut measures = measures::on(landmarks, &MEASURES[..SEMANTIC])?;
        measures.extend(measures::on(landmarks, &GUARDED)?);
        let mirror = &template.topology.mirror;
        let mut lengths: Vec<Vec<f64>> = (faces.par_iter())
            .map(|face| measure(face, landmarks, &measures))
            .collect();
        let images = if both_sides { faces } else { &[] };
        lengths.par_extend(
            (images.par_iter()).map(|face| measure(&mirrored(face, mirror), landmarks, &measures)),
        );
        let count = lengths.len() as f64;
        let column = |m: usize| lengths.iter().map(move |row| row[m]);
        let means: Vec<f64> = (0..measures.len())
            .map(|m| column(m).sum::<f64>() / count)
            .collect();
        let sigmas = (0..measures.len())
            .map(|m| {
                let squares: f64 = column(m).map(|l| (l - means[m]).powi(2)).sum();
                (squares / (count - 1.0)).sqrt().max(SAME)
            })
            .collect();
        Ok(Self {
            template,
            mean,
            landmarks,
            measures,
            lengths,
            faces: faces.len(),
            means,
            sigmas,
            neighbours: edge_neighbours(mean.len(), &template.triangles()),
            stretches: Stretches::new(mean, &template.triangles(), SEEN),
        })
    }

    /// How each measure changes with a field, to first order, in standard deviations.
    fn rates(&self, field: &[DVec3]) -> Vec<f64> {
        let at = |l: u32, some: &[DVec3]| -> DVec3 {
            let stencil = self.landmarks[l as usize].stencil.iter();
            stencil.map(|&(v, w)| some[v as usize] * w).sum()
        };
        let rate = |(m, sigma): (&Measure, &f64)| {
            let (_, gradient) = m.quantity.measure(&|l| at(l, self.mean));
            gradient
                .iter()
                .map(|(l, g)| g.dot(at(*l, field)))
                .sum::<f64>()
                / sigma
        };
        self.measures.iter().zip(&self.sigmas).map(rate).collect()
    }

    /// Whether mirror images count.
    fn both_sides(&self) -> bool {
        self.lengths.len() > self.faces
    }

    fn mirror_image(&self, field: &[DVec3]) -> Field {
        mirrored(field, &self.template.topology.mirror)
    }

    /// The part of a field that a control of some symmetry may have.
    fn symmetrised(&self, field: &[DVec3], symmetry: Symmetry) -> Field {
        let with = |sign: f64| {
            let both = field.iter().zip(self.mirror_image(field));
            both.map(|(f, m)| 0.5 * (*f + sign * m)).collect()
        };
        match symmetry {
            Symmetry::Even => with(1.0),
            Symmetry::Odd => with(-1.0),
            Symmetry::Left | Symmetry::Right => field
                .iter()
                .zip(self.mean)
                .map(|(f, p)| {
                    let x = if symmetry == Symmetry::Left {
                        p.x
                    } else {
                        -p.x
                    };
                    let t = ((x + MIDLINE) / (2.0 * MIDLINE)).clamp(0.0, 1.0);
                    *f * (t * t * (3.0 - 2.0 * t))
                })
                .collect(),
        }
    }

    /// The field of every control that can be made, with the Mahalanobis length of its direction.
    fn fields(
        &self,
        candidates: &BTreeMap<String, Candidates>,
        method: Method,
    ) -> FitResult<Vec<(usize, Field, f64)>> {
        let mut found: Vec<(usize, Field, f64)> = Vec::new();
        for (part, own) in candidates {
            let controls: Vec<usize> = (0..SEMANTIC)
                .filter(|&m| MEASURES[m].feature == part && self.sigmas[m] > SAME)
                .collect();
            if own.fields.is_empty() || controls.is_empty() {
                continue;
            }
            let covariance = covariance(&own.weights);
            let orthogonal = match method {
                Method::Regression => self.regression(own, &controls),
                _ => BTreeMap::new(),
            };
            for &control in &controls {
                let symmetry = Symmetry::of(MEASURES[control].name);
                if symmetry == Symmetry::Right && self.both_sides() {
                    continue;
                }
                let fields: Vec<Field> = (own.fields.par_iter())
                    .map(|field| self.symmetrised(field, symmetry))
                    .collect();
                let rates: Vec<Vec<f64>> = fields.par_iter().map(|f| self.rates(f)).collect();
                let jacobian =
                    DMatrix::from_fn(self.measures.len(), fields.len(), |m, k| rates[k][m]);
                let direction = match method {
                    Method::Regression => orthogonal[&control].clone(),
                    Method::InverseCovariance => self.inverse_covariance(own, control, &controls),
                    Method::Constrained => {
                        let smooth = self.smoothed(&covariance, &fields, roughness(control))?;
                        self.constrained(&jacobian, &smooth, control)
                    }
                };
                let gain = (jacobian.row(control) * &direction)[0];
                if !(gain.abs() > NEGLIGIBLE) {
                    continue;
                }
                let direction = direction / gain;
                let mut field = vec![DVec3::ZERO; self.mean.len()];
                for (component, d) in fields.iter().zip(direction.iter()) {
                    field
                        .iter_mut()
                        .zip(component)
                        .for_each(|(f, c)| *f += *c * *d);
                }
                let length = match covariance.clone().cholesky() {
                    Some(factor) => direction.dot(&factor.solve(&direction)).sqrt(),
                    None => return Err(FitError::Input("the faces hardly vary".into())),
                };
                if symmetry == Symmetry::Left && self.both_sides() {
                    let name = MEASURES[control].name.replace("left", "right");
                    let twin = MEASURES.iter().position(|m| m.name == name);
                    found.extend(twin.map(|twin| (twin, self.mirror_image(&field), length)));
                }
                found.push((control, field, length));
            }
        }
        found.sort_by_key(|f| f.0);
        Ok(found)
    }

    /// The covariance of weights, with what makes fields rough less probable.
    fn smoothed(
        &self,
        covariance: &DMatrix<f64>,
        fields: &[Field],
        roughness: f64,
    ) -> FitResult<DMatrix<f64>> {
        let neighbours = &self.neighbours;
        let rough: Vec<Field> = (fields.par_iter())
            .map(|field| {
                let each = field.iter().zip(neighbours);
                each.map(|(d, around)| {
                    let sum: DVec3 = around.iter().map(|&n| field[n as usize]).sum();
                    *d - sum / around.len().max(1) as f64
                })
                .collect()
            })
            .collect();
        let unlikely = FitError::Input("the faces hardly vary".into());
        let Some(factor) = covariance.clone().cholesky() else {
            return Err(unlikely);
        };
        let mut precision = factor.inverse();
        let rows: Vec<Vec<f64>> = (rough.par_iter())
            .map(|a| {
                let with = |b: &Field| a.iter().zip(b).map(|(p, q)| p.dot(*q)).sum::<f64>();
                rough.iter().map(with).collect()
            })
            .collect();
        for (i, row) in rows.iter().enumerate() {
            for (j, product) in row.iter().enumerate() {
                precision[(i, j)] += roughness * product;
            }
        }
        match precision.cholesky() {
            Some(factor) => Ok(factor.inverse()),
            None => Err(unlikely),
        }
    }

    /// [`Method::Constrained`].
    fn constrained(
        &self,
        jacobian: &DMatrix<f64>,
        covariance: &DMatrix<f64>,
        control: usize,
    ) -> DVector<f64> {
        let own = &self.measures[control];
        let rows: Vec<usize> = (0..self.measures.len())
            .filter(|&m| m == control || !tied(own, &self.measures[m]))
            .filter(|&m| m == control || jacobian.row(m).norm() > NEGLIGIBLE)
            .collect();
        let wanted = rows.iter().map(|&m| f64::from(u8::from(m == control)));
        let wanted = DVector::from_iterator(rows.len(), wanted);
        let among = jacobian.select_rows(&rows);
        let spread = covariance * among.transpose();
        let mut gram = &among * &spread;
        for (i, &m) in rows.iter().enumerate() {
            gram[(i, i)] += if m == control { 1e-12 } else { LEEWAY * LEEWAY };
        }
        match gram.cholesky() {
            Some(factor) => spread * factor.solve(&wanted),
            None => DVector::zeros(covariance.nrows()),
        }
    }

    /// [`Method::InverseCovariance`] among the controls of a part.
    fn inverse_covariance(
        &self,
        own: &Candidates,
        control: usize,
        controls: &[usize],
    ) -> DVector<f64> {
        let others: Vec<usize> = (controls.iter().copied())
            .filter(|&m| m == control || !tied(&self.measures[control], &self.measures[m]))
            .collect();
        let lengths = self.normal(&others);
        let count = lengths.nrows() as f64;
        let weights = centred(&own.weights);
        let across = weights.transpose() * &lengths / count;
        let mut among = lengths.transpose() * &lengths / count;
        (0..others.len()).for_each(|i| among[(i, i)] += 1e-9);
        let place = others.iter().position(|&m| m == control).unwrap_or(0);
        let mut unit = DVector::zeros(others.len());
        unit[place] = 1.0;
        match among.cholesky() {
            Some(factor) => across * factor.solve(&unit),
            None => DVector::zeros(weights.ncols()),
        }
    }

    /// [`Method::Regression`] among the controls of a part.
    fn regression(&self, own: &Candidates, controls: &[usize]) -> BTreeMap<usize, DVector<f64>> {
        let weights = centred(&own.weights);
        let lengths = self.normal(controls);
        let mut normal = weights.transpose() * &weights;
        let ridge = 1e-9 * normal.trace();
        (0..normal.nrows()).for_each(|i| normal[(i, i)] += ridge);
        let zero = || DMatrix::zeros(weights.ncols(), controls.len());
        let right = weights.transpose() * &lengths;
        let rows = normal.cholesky().map_or_else(zero, |f| f.solve(&right));
        let mut order: Vec<usize> = (0..controls.len()).collect();
        order.sort_by(|&a, &b| rows.column(b).norm().total_cmp(&rows.column(a).norm()));
        let mut done: BTreeMap<usize, DVector<f64>> = BTreeMap::new();
        for c in order {
            let mut direction = rows.column(c).into_owned();
            // Tied ones among those before are no orthogonal set: once more takes out what the
            // first pass put back.
            for _ in 0..2 {
                for (&other, before) in &done {
                    if !tied(&self.measures[controls[c]], &self.measures[other]) {
                        let along = direction.dot(before) / before.norm_squared().max(1e-30);
                        direction -= before * along;
                    }
                }
            }
            done.insert(controls[c], direction);
        }
        done
    }

    /// Some measures of all faces about their means, in standard deviations.
    fn normal(&self, some: &[usize]) -> DMatrix<f64> {
        DMatrix::from_fn(self.lengths.len(), some.len(), |f, i| {
            (self.lengths[f][some[i]] - self.means[some[i]]) / self.sigmas[some[i]]
        })
    }

    fn table(&self, method: Method, found: &[(usize, Field, f64)]) -> Table {
        let rest = measure(self.mean, self.landmarks, &self.measures);
        let row = |amount: f64, field: &Field| {
            let moved = self.mean.iter().zip(field);
            let moved: Vec<DVec3> = moved.map(|(p, d)| *p + amount * *d).collect();
            let there = measure(&moved, self.landmarks, &self.measures);
            (found.iter())
                .map(|&(m, ..)| (there[m] - rest[m]) / self.sigmas[m])
                .collect()
        };
        let ties = |i: usize| {
            let one = &self.measures[found[i].0];
            let other = |&j: &usize| j != i && tied(one, &self.measures[found[j].0]);
            (0..found.len()).filter(other).collect()
        };
        Table {
            method,
            controls: found.iter().map(|f| MEASURES[f.0].name.into()).collect(),
            moved: [1.0, -1.0, 2.0, -2.0]
                .map(|amount| {
                    let rows = found.par_iter().map(|(_, field, _)| row(amount, field));
                    (amount, rows.collect())
                })
                .into(),
            sigmas: found.iter().map(|f| self.sigmas[f.0]).collect(),
            lengths: found.iter().map(|f| f.2).collect(),
            tied: (0..found.len()).map(ties).collect(),
        }
    }

    /// Local blocks and controls of fields.
    fn bake(&self, kept: &[(usize, Field)], parts: &ModelParts) -> (Vec<Block>, Vec<Control>) {
        let mut blocks: Vec<Block> = Vec::new();
        let mut controls = Vec::new();
        let mut next = parts.coefficients();
        for block in &parts.blocks {
            let own: Vec<&(usize, Field)> = (kept.iter())
                .filter(|(m, _)| MEASURES[*m].feature == block.name)
                .collect();
            // Less than half a step in each coordinate is nothing.
            let seen = |d: DVec3| d.abs().max_element() >= f64::from(STEP) / 2.0;
            let support: Vec<u32> = (0..self.mean.len() as u32)
                .filter(|&v| own.iter().any(|(_, field)| seen(field[v as usize])))
                .collect();
            if support.is_empty() {
                continue;
            }
            let first_coefficient = next;
            let mut values = Vec::new();
            for (measure, field) in &own {
                values.extend(support.iter().flat_map(|&v| field[v as usize].to_array()));
                let definition = &MEASURES[*measure];
                let mut control = Control {
                    name: definition.name.into(),
                    group: block.name.clone(),
                    description: definition.more_and_less[0].into(),
                    direction: vec![(next as u32, 1.0)],
                    reading: Vec::new(),
                    measure: Some(*measure as u32),
                    quantiles: self.quantiles(*measure),
                    limits: [0.0, 1.0],
                };
                control.limits = self.limits(&control, *measure, field);
                controls.push(control);
                next += 1;
            }
            blocks.push(Block {
                name: format!("local {}", block.name),
                regions: block.regions.clone(),
                support,
                modes: Modes::of(&Quantised::new(&values, STEP), own.len()),
                sigmas: own.iter().map(|(m, _)| self.sigmas[*m] as f32).collect(),
                first_coefficient,
                surround: None,
                local_to: Some(block.name.clone()),
            });
        }
        (blocks, controls)
    }

    /// The percentiles at which a control's slider ends: where the mean head is still whole.
    fn limits(&self, control: &Control, measure: usize, field: &[DVec3]) -> [f32; 2] {
        let moved = |amount: f64| -> Field {
            let each = self.mean.iter().zip(field);
            each.map(|(p, d)| *p + amount * *d).collect()
        };
        let steps = (f64::from(LIMIT) / END_STEP).round() as usize;
        let end = |sign: f64, whole: f32| {
            let crumpled = (1..=steps).find(|&step| {
                let face = moved(sign * END_STEP * step as f64);
                self.stretches.least(&face) < NARROWEST
            });
            crumpled.map_or(whole, |step| {
                let face = moved(sign * END_STEP * (step - 1) as f64);
                let own = &self.measures[measure..=measure];
                control.percentile(self::measure(&face, self.landmarks, own)[0] as f32)
            })
        };
        [end(-1.0, 0.0), end(1.0, 1.0)]
    }

    /// The distribution of a measure in mm, with the limits of a control at its ends.
    fn quantiles(&self, measure: usize) -> Vec<f32> {
        let (mean, sigma) = (self.means[measure], self.sigmas[measure]);
        // An image measures the same of what is the same on both sides: once more it would make stairs of the table.
        let rows = match Symmetry::of(MEASURES[measure].name) {
            Symmetry::Even => &self.lengths[..self.faces],
            _ => &self.lengths[..],
        };
        let normal = rows.iter().map(|row| (row[measure] - mean) / sigma);
        let table = quantiles(normal.collect());
        debug_assert_eq!(table[0], -LIMIT);
        table
            .iter()
            .map(|&q| (mean + sigma * f64::from(q)) as f32)
            .collect()
    }
}

/// What a face measures, mm.
fn measure(face: &[DVec3], landmarks: &[Landmark], measures: &[Measure]) -> Vec<f64> {
    let place = |l: u32| -> DVec3 {
        let stencil = landmarks[l as usize].stencil.iter();
        stencil.map(|&(v, w)| face[v as usize] * w).sum()
    };
    let each = measures.iter().map(|m| m.quantity.measure(&place).0);
    each.collect()
}

/// Rows about their mean.
fn centred(rows: &[Vec<f64>]) -> DMatrix<f64> {
    let (f, k) = (rows.len(), rows[0].len());
    let mut matrix = DMatrix::from_fn(f, k, |i, j| rows[i][j]);
    for mut column in matrix.column_iter_mut() {
        let mean = column.mean();
        column.add_scalar_mut(-mean);
    }
    matrix
}

/// The covariance of rows, with a hundredth of its mean variance on the diagonal: weights that the
/// faces have too few of to tell apart stay apart.
fn covariance(rows: &[Vec<f64>]) -> DMatrix<f64> {
    let centred = centred(rows);
    let mut covariance = centred.transpose() * &centred / (rows.len() - 1) as f64;
    let k = covariance.nrows();
    let ridge = 0.01 * covariance.trace() / k as f64 + 1e-12;
    (0..k).for_each(|i| covariance[(i, i)] += ridge);
    covariance
}
