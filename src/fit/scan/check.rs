//! Whether a scan and its landmarks belong together and are a face's.

use glam::{DMat3, DVec3};
use nalgebra::Matrix3;

use super::{Scan, TURNED_BY_POINTS};
use crate::fit::head::template::Template;
use crate::fit::mesh::align::Rigid;
use crate::fit::mesh::surface::closest_on_triangle;
use crate::fit::mesh::surface::normals;
use crate::fit::{FitError, FitResult};

/// The farthest that a landmark may lie off the surface, mm.
const FARTHEST: f64 = 20.0;
/// The farthest that a landmark may lie from where the others put it, mm: twice what an open
/// mouth moves the chin.
const MISPLACED: f64 = 60.0;
/// A landmark set this much flatter than it is long is a line, or a plane.
const FLAT: f64 = 1e-3;
/// How much worse the face must fit than its mirror image to be called mirrored. On people it is
/// some three times better; with four points in nearly a plane the two are alike.
const MIRRORED: f64 = 1.3;

/// Where the generic head stands by some landmarks: the similarity that brings its landmarks
/// closest to them.
pub(in crate::fit) struct Placement {
    /// Lengths there in lengths of the template.
    pub scale: f64,
    /// The template's turn.
    pub rotation: DMat3,
    /// How far each landmark is from the template's, in lengths there.
    pub residuals: Vec<f64>,
}

impl Placement {
    /// The placement by points; `mirrored` places the template's mirror image. Nothing where the
    /// points are at one place.
    pub fn of(points: &[(usize, DVec3)], template: &Template, mirrored: bool) -> Option<Self> {
        let to: Vec<DVec3> = points.iter().map(|&(_, p)| p).collect();
        let from: Vec<DVec3> = points
            .iter()
            .map(|&(index, _)| template.landmark(index, &template.positions))
            .map(|p| {
                if mirrored {
                    DVec3::new(-p.x, p.y, p.z)
                } else {
                    p
                }
            })
            .collect();
        let all: Vec<u32> = (0..to.len() as u32).collect();
        let rotation = Rigid::fit(&from, &to, &all, &vec![1.0; to.len()]).rotation;
        let mean = |points: &[DVec3]| points.iter().sum::<DVec3>() / points.len() as f64;
        let (from_centre, to_centre) = (mean(&from), mean(&to));
        let (mut along, mut size) = (0.0, 0.0);
        for (&a, &b) in from.iter().zip(&to) {
            along += (rotation * (a - from_centre)).dot(b - to_centre);
            size += (a - from_centre).length_squared();
        }
        let scale = along / size;
        let residuals = from
            .iter()
            .zip(&to)
            .map(|(&a, &b)| (rotation * (a - from_centre) * scale).distance(b - to_centre))
            .collect();
        (scale.is_finite() && scale > 0.0).then_some(Self {
            scale,
            rotation,
            residuals,
        })
    }

    fn rms(&self) -> f64 {
        let sum: f64 = self.residuals.iter().map(|r| r * r).sum();
        (sum / self.residuals.len() as f64).sqrt()
    }
}

/// Whether a scan fits its landmarks, `(index in the template's landmarks, point in mm)`, and both
/// are a face's. Returns what is worth saying, a line each.
///
/// A surface that is inside out by its landmarks is turned. Any pose is fine, as the result keeps
/// the scan's; one that is upside down is said.
///
/// # Errors
/// With the scan's file: landmarks at one place, on a line or in a plane; more than 20 mm off the
/// surface; more than 60 mm from where the others put them; left and right swapped, or a
/// mirrored scan.
pub fn check(
    scan: &mut Scan,
    points: &[(usize, DVec3)],
    template: &Template,
) -> FitResult<Vec<String>> {
    let path = scan.path.clone();
    let fail = |cause: String| FitError::file(&path, cause);
    let name = |at: usize| template.landmarks[points[at].0].name.as_str();
    spread(points).map_err(fail)?;
    let (Some(placed), Some(mirrored)) = (
        Placement::of(points, template, false),
        Placement::of(points, template, true),
    ) else {
        return Err(fail("its landmarks are not arranged as a face's".into()));
    };
    if placed.rms() > MIRRORED * mirrored.rms() {
        return Err(fail(
            "mirrored: its landmarks fit a face only with left and right swapped; either the \
             scan is a mirror image or the names of left and right landmarks are exchanged"
                .into(),
        ));
    }
    let outward = normals(&scan.positions, &scan.triangles);
    let template_outward = normals(&template.positions, &template.triangles());
    let mut agreement = 0.0;
    for (at, &(index, p)) in points.iter().enumerate() {
        let (nearest, distance) = nearest_vertex(scan, p);
        if distance > FARTHEST && to_surface(scan, p) > FARTHEST {
            return Err(fail(format!(
                "landmark `{}` is {:.1} mm off the surface, more than {FARTHEST} mm",
                name(at),
                to_surface(scan, p)
            )));
        }
        let stencil = &template.landmarks[index].stencil;
        let normal: DVec3 = stencil
            .iter()
            .map(|&(v, weight)| template_outward[v as usize] * weight)
            .sum();
        agreement += (placed.rotation * normal).dot(outward[nearest]);
    }
    let mut notes = Vec::new();
    if agreement < 0.0 {
        // With points in nearly a plane a mirrored face fits as well, turned around.
        if mirrored.rms() < MIRRORED * placed.rms() {
            return Err(fail(
                "its landmarks fit a face only from behind: either the scan is a mirror image, \
                 or left and right landmarks are exchanged, or its triangles are inside out"
                    .into(),
            ));
        }
        scan.turn_inside_out();
        scan.say_turned(TURNED_BY_POINTS);
    }
    let worst =
        (0..points.len()).max_by(|&a, &b| placed.residuals[a].total_cmp(&placed.residuals[b]));
    if let Some(at) = worst.filter(|&at| placed.residuals[at] > MISPLACED) {
        return Err(fail(format!(
            "landmark `{}` is {:.0} mm from where the other landmarks put it",
            name(at),
            placed.residuals[at]
        )));
    }
    let up = placed.rotation * DVec3::Y;
    if up.y < -0.5 {
        let angle = up.angle_between(DVec3::Y).to_degrees();
        notes.push(format!(
            "pose: the head is upside down in its file (turned by {angle:.0} degrees); the \
             result is too"
        ));
    }
    Ok(notes)
}

/// Whether landmarks span space: a warp is not determined by points in a plane.
pub(in crate::fit) fn spread(points: &[(usize, DVec3)]) -> Result<(), String> {
    let mean = points.iter().map(|&(_, p)| p).sum::<DVec3>() / points.len() as f64;
    let mut scatter = Matrix3::zeros();
    for &(_, p) in points {
        let d = p - mean;
        let d = nalgebra::Vector3::new(d.x, d.y, d.z);
        scatter += d * d.transpose();
    }
    let mut axes: Vec<f64> = scatter
        .symmetric_eigenvalues()
        .iter()
        .map(|l| l.max(0.0).sqrt())
        .collect();
    axes.sort_by(|a, b| b.total_cmp(a));
    let size = points.iter().map(|&(_, p)| p.length()).fold(0.0, f64::max);
    let shape = match axes[..] {
        // Rounding of the mean.
        [longest, ..] if !(longest > 1e-9 * size) => "all at one place",
        [longest, second, _] if second < FLAT * longest => "all on one line",
        [longest, _, third] if third < FLAT * longest => "all in one plane",
        _ => return Ok(()),
    };
    Err(format!("the {} landmarks are {shape}", points.len()))
}

fn nearest_vertex(scan: &Scan, p: DVec3) -> (usize, f64) {
    let mut best = (0, f64::INFINITY);
    for (v, q) in scan.positions.iter().enumerate() {
        let distance = q.distance_squared(p);
        if distance < best.1 {
            best = (v, distance);
        }
    }
    (best.0, best.1.sqrt())
}

/// The distance of a point to the surface. Few points come here, so no hierarchy is built.
fn to_surface(scan: &Scan, p: DVec3) -> f64 {
    scan.triangles
        .iter()
        .map(|t| {
            let corners = t.map(|v| scan.positions[v as usize]);
            let weights = closest_on_triangle(corners, p);
            let q: DVec3 = (0..3).map(|i| corners[i] * weights[i]).sum();
            q.distance(p)
        })
        .fold(f64::INFINITY, f64::min)
}
