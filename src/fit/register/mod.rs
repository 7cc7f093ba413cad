//! Registration: the generic head moved onto a scan (region morphing, section 4; DESIGN, "local
//! deformation").
//!
//! The scan is brought into the template's frame by the landmarks. With a prior, its coefficients
//! are fitted first ([`statistical`]); without one the landmarks warp the head
//! ([`warp`](crate::fit::warp)). Then an elastic [`sheet`] is drawn onto the scan, stiff at first
//! and softer level by level, by [`correspondence`]s to closest points of the scan. Last, vertices
//! that have a point on the scan are set on it.

pub mod correspondence;
pub mod sheet;
pub mod statistical;

use glam::DVec3;

use self::correspondence::{Admission, correspond};
use self::sheet::{Pull, Sheet};
use self::statistical::Shape;
use super::FitResult;
use super::align::Rigid;
use super::render::normals;
use super::scan::Scan;
use super::surface::Surface;
use super::template::Template;
use super::warp::{Kernel, Warp};

/// Landmarks of a scan: place in the template's list, position in mm.
pub type Pulls = Vec<(usize, DVec3)>;

/// How a scan is registered.
#[derive(Debug, Clone, PartialEq)]
pub struct Settings {
    /// Whether the template's prior is used where it has one.
    pub prior: bool,
}

impl Default for Settings {
    fn default() -> Self {
        Self { prior: true }
    }
}

/// A registered face.
#[derive(Debug, Clone)]
pub struct Registered {
    /// All vertices of the template in the scan's pose, mm.
    pub positions: Vec<DVec3>,
    /// Whether each vertex lies on the scan; the others were carried along.
    pub covered: Vec<bool>,
}

/// Stiffnesses of the sheet, mm; the first are for a start without a prior.
const LENGTHS: [f64; 5] = [30.0, 14.0, 7.0, 4.0, 2.5];

/// How often closest points are looked for at each stiffness.
const ROUNDS: [usize; 5] = [2, 2, 2, 2, 2];

/// Conjugate-gradient steps between two looks for closest points.
const STEPS: usize = 5;

/// What registers scans to a template: everything that does not depend on the scan.
pub struct Registrar<'a> {
    template: &'a Template,
    triangles: Vec<[u32; 3]>,
    /// The vertices of skin and cavities, which are one connected sheet.
    soft: Vec<u32>,
    /// The sheet's own numbering of its triangles.
    soft_triangles: Vec<[u32; 3]>,
    sheet: Sheet,
    /// How open each soft vertex lies to a scanner, 0 to 1; cavities not at all.
    open: Vec<f64>,
    /// Area times openness, of all vertices.
    weights: Vec<f64>,
    eyes: Vec<Eye>,
}

/// An eyeball and what carries it.
struct Eye {
    vertices: Vec<u32>,
    /// The soft vertices around it.
    around: Vec<u32>,
}

impl<'a> Registrar<'a> {
    /// Prepares a template.
    ///
    /// # Errors
    /// When the template lacks its parts, or its mesh is degenerate.
    pub fn new(template: &'a Template) -> FitResult<Self> {
        let n = template.positions.len();
        let triangles = template.triangles();
        let mut soft_triangles = template.part_triangles("skin")?;
        let skin = template.part_vertices("skin")?;
        soft_triangles.extend(template.part_triangles("mouth cavity")?);
        soft_triangles.extend(template.part_triangles("eye cavities")?);
        let mut soft = soft_triangles.as_flattened().to_vec();
        soft.sort_unstable();
        soft.dedup();
        let mut slot = vec![u32::MAX; n];
        (0..).zip(&soft).for_each(|(i, &v)| slot[v as usize] = i);
        for corner in soft_triangles.as_flattened_mut() {
            *corner = slot[*corner as usize];
        }
        let rest: Vec<DVec3> = soft
            .iter()
            .map(|&v| template.positions[v as usize])
            .collect();
        let openness = openness(&template.positions, &triangles, &skin);
        let mut open = vec![0.0; soft.len()];
        for (&v, o) in skin.iter().zip(openness) {
            open[slot[v as usize] as usize] = o;
        }
        let points = template
            .landmarks
            .iter()
            .map(|l| {
                l.stencil
                    .iter()
                    .map(|&(v, w)| (slot[v as usize], w))
                    .collect()
            })
            .collect();
        let sheet = Sheet::new(&rest, &soft_triangles, &open, points, &LENGTHS)?;
        let mut weights = vec![0.0; n];
        for (i, &v) in soft.iter().enumerate() {
            weights[v as usize] = open[i] * sheet.areas[i];
        }
        let eyes = ["left eyeball", "right eyeball"]
            .iter()
            .map(|part| {
                let vertices = template.part_vertices(part)?;
                let at = |v: u32| template.positions[v as usize];
                let centre = vertices.iter().map(|&v| at(v)).sum::<DVec3>() / vertices.len() as f64;
                let radius = vertices
                    .iter()
                    .map(|&v| at(v).distance(centre))
                    .sum::<f64>()
                    / vertices.len() as f64;
                // The lids and what is behind them.
                let near = |v: &u32| at(*v).distance(centre) < 1.35 * radius;
                Ok(Eye {
                    vertices,
                    around: soft.iter().copied().filter(near).collect(),
                })
            })
            .collect::<FitResult<_>>()?;
        Ok(Self {
            template,
            triangles,
            soft,
            soft_triangles,
            sheet,
            open,
            weights,
            eyes,
        })
    }

    /// Registers one scan by its landmarks (place in the template's list, position in mm).
    ///
    /// # Errors
    /// With fewer than four landmarks, or when they do not fix a pose.
    pub fn register(
        &self,
        scan: &Scan,
        points: &[(usize, DVec3)],
        settings: &Settings,
    ) -> FitResult<Registered> {
        let template = self.template;
        let from: Vec<DVec3> = points
            .iter()
            .map(|&(l, _)| template.landmark(l, &template.positions))
            .collect();
        let to: Vec<DVec3> = points.iter().map(|p| p.1).collect();
        let all: Vec<u32> = (0..points.len() as u32).collect();
        let pose = Rigid::fit(&to, &from, &all, &vec![1.0; to.len()]);
        let moved: Vec<DVec3> = scan.positions.iter().map(|&p| pose.apply(p)).collect();
        let points: Pulls = points.iter().map(|&(l, p)| (l, pose.apply(p))).collect();
        let surface = Surface::new(&moved, &scan.triangles);

        let prior = template.prior.as_ref().filter(|_| settings.prior);
        let (start, first) = match prior {
            Some(prior) => {
                let stencils: Vec<&[(u32, f64)]> =
                    template.landmarks.iter().map(|l| &l.stencil[..]).collect();
                let shape = Shape {
                    rest: &template.positions,
                    triangles: &self.triangles,
                    prior,
                    weights: &self.weights,
                    stencils: &stencils,
                };
                let still = Rigid {
                    rotation: glam::DMat3::IDENTITY,
                    translation: DVec3::ZERO,
                };
                let fit = statistical::fit(&shape, &surface, still, &points, 2.0);
                let face = prior.face(&template.positions, &fit.coefficients);
                (
                    face.iter().map(|&p| fit.pose.apply(p)).collect::<Vec<_>>(),
                    1,
                )
            }
            None => {
                let to: Vec<DVec3> = points.iter().map(|p| p.1).collect();
                let warp = Warp::fit(&from, &to, Kernel::Biharmonic, 0.0)?;
                (warp.apply_all(&template.positions), 0)
            }
        };
        let base: Vec<DVec3> = self.soft.iter().map(|&v| start[v as usize]).collect();
        let mut moves = vec![DVec3::ZERO; base.len()];
        let every: Vec<u32> = (0..base.len() as u32)
            .filter(|&i| self.open[i as usize] > 0.0)
            .collect();
        let mut reach = 15.0;
        for level in first..LENGTHS.len() {
            for _ in 0..ROUNDS[level] {
                let now: Vec<DVec3> = base.iter().zip(&moves).map(|(b, u)| *b + *u).collect();
                let facing = normals(&now, &self.soft_triangles);
                let cosine = if level < 2 { 0.5 } else { 0.65 };
                let found = correspond(
                    &surface,
                    &now,
                    &facing,
                    &every,
                    &Admission { reach, cosine },
                );
                let mut pull = Pull {
                    targets: moves.clone(),
                    normals: facing,
                    weights: vec![0.0; base.len()],
                    along: 0.0,
                    points: points
                        .iter()
                        .map(|&(l, p)| {
                            let stencil = &template.landmarks[l].stencil;
                            let at: DVec3 =
                                stencil.iter().map(|&(v, w)| start[v as usize] * w).sum();
                            (l, p - at, 50.0)
                        })
                        .collect(),
                };
                let mut distances: Vec<f64> = found.iter().flatten().map(|c| c.distance).collect();
                distances.sort_unstable_by(f64::total_cmp);
                let typical = distances.get(distances.len() / 2).copied().unwrap_or(reach);
                for c in found.iter().flatten() {
                    let v = c.vertex as usize;
                    pull.targets[v] = c.point - base[v];
                    pull.normals[v] = c.normal;
                    pull.weights[v] = self.open[v];
                }
                self.sheet.relax(level, &pull, &mut moves, STEPS);
                reach = (8.0 * typical).clamp(2.0, reach);
            }
        }
        let mut positions = start;
        let now: Vec<DVec3> = base.iter().zip(&moves).map(|(b, u)| *b + *u).collect();
        let mut covered = vec![false; positions.len()];
        let facing = normals(&now, &self.soft_triangles);
        let admission = Admission {
            reach: 1.0,
            cosine: 0.7,
        };
        for (&v, p) in self.soft.iter().zip(&now) {
            positions[v as usize] = *p;
        }
        for c in correspond(&surface, &now, &facing, &every, &admission)
            .iter()
            .flatten()
        {
            let v = self.soft[c.vertex as usize] as usize;
            covered[v] = true;
            positions[v] = c.point;
        }
        self.carry_eyes(&mut positions);
        let back = pose.inverse();
        positions.iter_mut().for_each(|p| *p = back.apply(*p));
        Ok(Registered { positions, covered })
    }

    /// Moves the eyeballs, each rigidly, with what is around them.
    fn carry_eyes(&self, positions: &mut [DVec3]) {
        let rest = &self.template.positions;
        let even = vec![1.0; rest.len()];
        for eye in &self.eyes {
            let motion = Rigid::fit(rest, positions, &eye.around, &even);
            for &v in &eye.vertices {
                positions[v as usize] = motion.apply(rest[v as usize]);
            }
        }
    }
}

/// Rays a vertex when its openness is asked.
const RAYS: usize = 24;

/// How far something must be to not hide a vertex, mm.
const HIDES_WITHIN: f64 = 60.0;

/// How open some vertices of a mesh lie, 0 to 1: by the part of the rays around the normal that
/// meet nothing near. Where a scanner cannot look, a scan has a hole or worse.
fn openness(positions: &[DVec3], triangles: &[[u32; 3]], vertices: &[u32]) -> Vec<f64> {
    use rayon::prelude::*;
    let surface = Surface::new(positions, triangles);
    vertices
        .par_iter()
        .map(|&v| {
            let normal = surface.normals[v as usize];
            let (across, up) = normal.any_orthonormal_pair();
            let origin = positions[v as usize] + normal * 0.05;
            let free = (0..RAYS)
                .filter(|&ray| {
                    // A spiral over the cap, cosine-weighted.
                    let part = (ray as f64 + 0.5) / RAYS as f64;
                    let (sine, cosine) = (2.399_963_229_728_653 * ray as f64).sin_cos();
                    let direction =
                        (across * cosine + up * sine) * part.sqrt() + normal * (1.0 - part).sqrt();
                    surface.cast(origin, direction, HIDES_WITHIN).is_none()
                })
                .count();
            let free = free as f64 / RAYS as f64;
            // A flat place has 1, a crease at a right angle one half.
            let t = ((free - 0.15) / 0.3).clamp(0.0, 1.0);
            t * t * (3.0 - 2.0 * t)
        })
        .collect()
}
