//! Registration: the generic head moved onto a scan (region morphing, section 4; DESIGN, "local
//! deformation").
//!
//! The scan is brought into the template's frame by the landmarks. With a prior, its coefficients
//! are fitted first ([`statistical`]), and how strongly the face shows the template's expressions, by
//! bare skin before the rest ([`hair`]); without one the
//! landmarks warp the head ([`warp`]), and [`space`] is bent until the surface
//! agrees too. Then an elastic [`sheet`] is drawn onto the scan, stiff at first and softer level by
//! level, by [`correspondence`]s to closest points of the scan. Last, vertices that have a point on
//! the scan are set on it ([`embed`]), lips that went through each other are parted ([`lips`]),
//! folds evened out, and the eyeballs carried along. [`batch`] does a folder.
//!
//! # What drift is left
//!
//! Mean drift on the face ([`evaluate`](mod@crate::fit::evaluate)) of 300 people without noise is
//! 0.54 mm. Regressed on the people's true coefficients, 88 % of its variance is explained in
//! people who were left out; without that part the mean is 0.17 mm. So what is left is hardly noise:
//! it is a slide that goes with shape, and a prior learned from such registrations repeats it. It
//! grows with the distance to the nearest landmark: 0.23 mm within 1.5 mm, 0.40 at 3 to 6, 0.67 at
//! 10 to 15, 0.89 at 20 to 30, 1.6 beyond (a fiftieth of the face). What was tried against it, and
//! did not help:
//! - a prior from 716 people in place of 200: 0.545 in place of 0.554 on twelve people, for three
//!   and a half times the work;
//! - bending space round the prior's fit by what is left at the landmarks, or at landmarks and
//!   surface: 0.555 in place of 0.550;
//! - matching curvature, normals, strain or bending: all of them vary more over people at the true
//!   spots than where vertices land (10 mm and more from landmarks: strain by 4 %, normals by 6 to
//!   8 %, curvature by 14 to 19 %, bending by 26 %), so less of them is not less drift.

pub mod batch;
pub mod correspondence;
pub mod embed;
pub mod hair;
pub mod lips;
pub mod noise;
pub mod sheet;
pub mod space;
pub mod statistical;
pub mod texture;
pub mod warp;

use std::sync::OnceLock;

use glam::DVec3;

use self::correspondence::{Admission, Correspondence, correspond};
use self::lips::Lips;
use self::noise::Neighbours;
use self::sheet::{Pull, Sheet};
use self::space::{Bending, Observation};
use self::statistical::Shape;
use self::warp::{Kernel, Warp};
use crate::fit::detect::Detector;
use crate::fit::head::folds::{Folds, edge_neighbours};
use crate::fit::head::template::Template;
use crate::fit::mesh::align::Rigid;
use crate::fit::mesh::surface::Surface;
use crate::fit::mesh::surface::normals;
use crate::fit::scan::{Scan, spread};
use crate::fit::{FitError, FitResult};

/// Landmarks of a scan: place in the template's list, position in mm.
pub type Pulls = Vec<(usize, DVec3)>;

/// How a scan is registered.
#[derive(Debug, Clone, PartialEq)]
pub struct Settings {
    /// Whether the template's prior is used where it has one.
    pub prior: bool,
    /// The landmarks' errors, by their places in the template's list, where they are known to be larger
    /// than how far all lie off the surface tells, mm. Those of a list that ends sooner are not.
    pub point_errors: Vec<f64>,
    /// Whether [`batch`] writes faces as they are without the expression that they show.
    pub neutral: bool,
    /// Whether [`batch`] opens the images of scans.
    pub pictures: bool,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            prior: true,
            point_errors: Vec::new(),
            neutral: false,
            pictures: true,
        }
    }
}

/// A registered face.
#[derive(Debug, Clone)]
pub struct Registered {
    /// All vertices of the template in the scan's pose, mm.
    pub positions: Vec<DVec3>,
    /// Whether each vertex lies on the scan; the others were carried along.
    pub covered: Vec<bool>,
    /// The template's expressions that the face shows, and how strongly; none without a prior.
    pub expressions: Vec<(String, f64)>,
    /// Landmarks that were set wrong, and how far from where the surface and the others have them, mm: they were left out.
    pub strays: Vec<(String, f64)>,
    /// How far those that are told moved each vertex, mm, in the scan's pose.
    moved: Vec<DVec3>,
}

/// Weaker expressions are not told, and not taken off: they are how a face without any differs from the prior.
const TOLD: f64 = 0.2;

/// Which of a face's expressions it shows: those that are told, and the weaker halves of them, without which what is
/// taken off would be more on one side than on the other.
fn shown(expressions: &[(String, f64)]) -> impl Iterator<Item = &(String, f64)> {
    let whole = |name: &str| {
        let half = name.strip_suffix("Left").or(name.strip_suffix("Right"));
        half.unwrap_or(name).to_owned()
    };
    let told = expressions.iter().filter(|e| e.1 >= TOLD);
    let told: Vec<String> = told.map(|e| whole(&e.0)).collect();
    let is_shown = move |e: &&(String, f64)| told.contains(&whole(&e.0));
    expressions.iter().filter(is_shown)
}

impl Registered {
    /// All vertices of the face without the expression that it shows, mm; a face that is told to show none is as it is.
    /// Where lids were shut or lips apart it is a guess.
    pub fn neutral(&self) -> Vec<DVec3> {
        let moves = self.positions.iter().zip(&self.moved);
        moves.map(|(p, m)| *p - *m).collect()
    }

    /// The scan's landmarks where they would be without the expression.
    pub fn neutral_points(&self, template: &Template, points: &[(usize, DVec3)]) -> Pulls {
        let points = points.iter();
        points
            .map(|&(l, p)| (l, p - template.landmark(l, &self.moved)))
            .collect()
    }

    /// In words, for who ran it.
    pub fn summary(&self) -> String {
        let covered = self.covered.iter().filter(|c| **c).count();
        let mut told: Vec<_> = self.expressions.iter().filter(|e| e.1 >= TOLD).collect();
        told.sort_by(|a, b| b.1.total_cmp(&a.1));
        let told: Vec<String> = told.iter().map(|(n, s)| format!("{n} {s:.2}")).collect();
        let shows = match told.is_empty() {
            true => String::new(),
            false => format!("; the face shows {}", told.join(", ")),
        };
        format!(
            "{covered} of {} vertices lie on the scan, the others were carried along{shows}",
            self.covered.len()
        )
    }
}

/// Stiffnesses of the sheet, mm, from stiff to soft.
const LENGTHS: [f64; 3] = [7.0, 4.0, 2.0];

/// How often closest points are looked for at each stiffness.
const ROUNDS: [usize; 3] = [1, 1, 2];

/// A scan with less noise than this is taken as it is, mm: one that was meant to be followed to the
/// last tenth has less.
const CLEAN: f64 = 0.1;

/// Vertices at which the surface pulls when space is bent.
const BENT: usize = 1200;

/// How closely the surface is followed, round by round.
const SLACKS: [f64; 5] = [10.0, 3.0, 1.0, 0.5, 0.3];

/// Rounds of smoothing of a noisy scan.
const SMOOTHING: usize = 8;

/// A vertex this near to its point on the scan counts as lying on it, mm; three times the scan's
/// noise may be more.
const COVERED: f64 = 0.05;

/// How much a landmark pulls at the sheet, mm^2 of surface, when it was set exactly.
const POINT_PULL: f64 = 50.0;

/// Landmarks are never trusted beyond this, mm: people differ in where a point is.
const POINT_SCATTER: f64 = 0.3;

/// The same against the prior, which knows only so much of where landmarks are, mm.
const POINT_ERROR: f64 = 1.0;

/// Trust in points that slide on smooth skin, while the template's are where a hand put them and
/// not yet where people set them.
const LOOSE: f64 = 0.05;

/// What lies farther than this from where the surface and all other landmarks have it, is another spot, mm: of the corners
/// of an eye one for the other. What prior and expressions do not know of people is half of that.
const STRAY: f64 = 20.0;

/// The slack of exact landmarks where space is bent.
const POINT_SLACK: f64 = 0.1;

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
    /// Which vertices are skin on everybody.
    bare: Vec<bool>,
    eyes: Vec<Eye>,
    lips: Lips,
    /// The pairs of the skin's triangles that should not fold.
    folds: Folds,
    /// Each vertex's neighbours along edges.
    neighbours: Vec<Vec<u32>>,
    /// Made when a scan without landmarks comes.
    detector: OnceLock<Detector>,
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
            soft,
            soft_triangles,
            sheet,
            open,
            weights,
            bare: hair::bare(template),
            eyes,
            lips: Lips::new(template)?,
            folds: Folds::new(&template.positions, template.part_triangles("skin")?),
            neighbours: edge_neighbours(n, &triangles),
            detector: OnceLock::new(),
            triangles,
        })
    }

    /// What finds the template's landmarks.
    ///
    /// # Errors
    /// When the template has no face to look for.
    pub fn detector(&self) -> FitResult<&Detector> {
        if let Some(detector) = self.detector.get() {
            return Ok(detector);
        }
        let made = Detector::new(self.template)?;
        Ok(self.detector.get_or_init(|| made))
    }

    /// The template's triangles.
    pub fn triangles(&self) -> &[[u32; 3]] {
        &self.triangles
    }

    /// Registers one scan by its landmarks (place in the template's list, position in mm).
    ///
    /// # Errors
    /// With fewer than four landmarks, when they do not fix a pose, and without triangles.
    pub fn register(
        &self,
        scan: &Scan,
        points: &[(usize, DVec3)],
        settings: &Settings,
    ) -> FitResult<Registered> {
        if points.len() < 4 {
            let cause = format!("{} landmarks, where a pose needs four", points.len());
            return Err(FitError::Input(cause));
        }
        spread(points).map_err(FitError::Input)?;
        if scan.triangles.is_empty() {
            return Err(FitError::Input("the scan has no triangles".into()));
        }
        let template = self.template;
        let from: Vec<DVec3> = points
            .iter()
            .map(|&(l, _)| template.landmark(l, &template.positions))
            .collect();
        let to: Vec<DVec3> = points.iter().map(|p| p.1).collect();
        let all: Vec<u32> = (0..points.len() as u32).collect();
        let pose = Rigid::fit(&to, &from, &all, &vec![1.0; to.len()]);
        let mut seen: Vec<DVec3> = scan.positions.iter().map(|&p| pose.apply(p)).collect();
        let points: Pulls = points.iter().map(|&(l, p)| (l, pose.apply(p))).collect();
        let neighbours = Neighbours::new(seen.len(), &scan.triangles);
        let facing = normals(&seen, &scan.triangles);
        let noise = noise::noise(&seen, &facing, &neighbours);
        // One coordinate of three.
        let off = off_surface(&points, &seen, &facing);
        let offs: Vec<f64> = (points.iter())
            .map(|&(l, _)| {
                settings
                    .point_errors
                    .get(l)
                    .map_or(off, |e| off.max(e / 3.0_f64.sqrt()))
            })
            .collect();
        if noise > CLEAN {
            noise::smooth(&mut seen, &neighbours, SMOOTHING);
        }
        let surface = Surface::new(&seen, &scan.triangles);

        let prior = template.prior.as_ref().filter(|_| settings.prior);
        let mut expressions = Vec::new();
        let mut moved = vec![DVec3::ZERO; template.positions.len()];
        let start = match prior {
            Some(prior) => {
                let stencils: Vec<&[(u32, f64)]> =
                    template.landmarks.iter().map(|l| &l.stencil[..]).collect();
                let shape = Shape {
                    rest: &template.positions,
                    triangles: &self.triangles,
                    prior,
                    expressions: &template.expressions,
                    weights: &self.weights,
                    bare: &self.bare,
                    stencils: &stencils,
                };
                let errors: Vec<f64> = (offs.iter())
                    .map(|off| (POINT_ERROR * POINT_ERROR + 3.0 * off * off).sqrt())
                    .collect();
                let fit = statistical::fit(&shape, &surface, &points, &errors);
                let face = shape.face(&fit.coefficients, &fit.strengths);
                for (expression, &strength) in template.expressions.iter().zip(&fit.strengths) {
                    if strength > 0.0 {
                        expressions.push((expression.name.clone(), strength));
                    }
                }
                for (name, strength) in shown(&expressions) {
                    let own = template.expressions.iter().find(|e| e.name == *name);
                    let turned = fit.pose.rotation * *strength;
                    let moves = own.into_iter().flat_map(|e| &e.displacements);
                    let moves = moved.iter_mut().zip(moves);
                    moves.for_each(|(m, d)| *m += turned * *d);
                }
                face.iter().map(|&p| fit.pose.apply(p)).collect()
            }
            None => {
                let to: Vec<DVec3> = points.iter().map(|p| p.1).collect();
                let warp = Warp::fit(&from, &to, Kernel::Biharmonic, 0.0)?;
                self.bend(&surface, &points, warp.apply_all(&template.positions))
            }
        };
        // Where a jaw may hang, and nobody knows how it does, all that is on it may be far away.
        let tells = prior.is_some() && !template.expressions.is_empty();
        let mut strays: Vec<(usize, f64)> = (points.iter().zip(&offs).filter(|_| tells))
            .map(|(&(l, p), off)| (l, template.landmark(l, &start).distance(p), off))
            .filter(|&(l, far, off)| {
                far > STRAY.max(5.0 * off) && !loose(&template.landmarks[l].name)
            })
            .map(|(l, far, _)| (l, far))
            .collect();
        // Of many it is rather the fit that went wrong.
        if 4 * strays.len() > points.len() {
            strays.clear();
        }
        let is_stray = |l: usize| strays.iter().any(|&(stray, _)| stray == l);
        let base: Vec<DVec3> = self.soft.iter().map(|&v| start[v as usize]).collect();
        let mut moves = vec![DVec3::ZERO; base.len()];
        let every: Vec<u32> = (0..base.len() as u32)
            .filter(|&i| self.open[i as usize] > 0.0)
            .collect();
        let outward = normals(&base, &self.soft_triangles);
        let skin = |c: &Correspondence| {
            let v = c.vertex as usize;
            match prior {
                Some(_) if !self.bare[self.soft[v] as usize] => {
                    hair::skin(outward[v].dot(c.point - base[v]))
                }
                _ => 1.0,
            }
        };
        let mut reach = 15.0;
        // The softest sheet would follow what is left of the noise.
        let last = LENGTHS.len() - usize::from(noise > CLEAN);
        for (level, &rounds) in ROUNDS[..last].iter().enumerate() {
            for _ in 0..rounds {
                let now: Vec<DVec3> = base.iter().zip(&moves).map(|(b, u)| *b + *u).collect();
                let facing = normals(&now, &self.soft_triangles);
                let cosine = 0.65;
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
                    points: (points.iter().zip(&offs))
                        .filter(|&(&(l, _), _)| !is_stray(l))
                        .map(|(&(l, p), off)| {
                            let at = template.landmark(l, &start);
                            let scatter = POINT_SCATTER * POINT_SCATTER;
                            let pull = POINT_PULL * scatter / (scatter + off * off);
                            (l, p - at, self.trust(l) * pull)
                        })
                        .collect(),
                };
                let on_skin = found.iter().flatten().filter(|c| skin(c) > 0.0);
                let mut distances: Vec<f64> = on_skin.map(|c| c.distance).collect();
                distances.sort_unstable_by(f64::total_cmp);
                let typical = distances.get(distances.len() / 2).copied().unwrap_or(reach);
                for c in found.iter().flatten() {
                    let v = c.vertex as usize;
                    pull.targets[v] = c.point - base[v];
                    pull.normals[v] = c.normal;
                    pull.weights[v] = self.open[v] * skin(c);
                }
                self.sheet.relax(level, &pull, &mut moves, STEPS);
                reach = (8.0 * typical).clamp(2.0, reach);
            }
        }
        let now: Vec<DVec3> = base.iter().zip(&moves).map(|(b, u)| *b + *u).collect();
        let facing = normals(&now, &self.soft_triangles);
        let admission = Admission {
            reach: 1.0,
            cosine: 0.7,
        };
        let found = correspond(&surface, &now, &facing, &every, &admission);
        let set = if noise > CLEAN {
            now.clone()
        } else {
            embed::embed(&now, &self.soft_triangles, &self.open, &found)
        };
        let mut positions = start;
        for (&v, p) in self.soft.iter().zip(&set) {
            positions[v as usize] = *p;
        }
        let mut covered = vec![false; positions.len()];
        for c in found.iter().flatten() {
            let reached = set[c.vertex as usize].distance(c.point);
            covered[self.soft[c.vertex as usize] as usize] = reached <= (3.0 * noise).max(COVERED);
        }
        self.lips.part(&mut positions);
        self.folds.even_out(&mut positions, &self.neighbours);
        self.carry_eyes(&mut positions);
        let back = pose.inverse();
        positions.iter_mut().for_each(|p| *p = back.apply(*p));
        moved.iter_mut().for_each(|m| *m = back.rotation * *m);
        Ok(Registered {
            positions,
            covered,
            expressions,
            strays: (strays.iter())
                .map(|&(l, far)| (template.landmarks[l].name.clone(), far))
                .collect(),
            moved,
        })
    }

    /// How much a landmark is trusted, 0 to 1.
    fn trust(&self, landmark: usize) -> f64 {
        let learned = self.template.prior.is_some();
        if !learned && loose(&self.template.landmarks[landmark].name) {
            LOOSE
        } else {
            1.0
        }
    }

    /// Bends space around a first guess until landmarks and surface agree ([`space`]).
    fn bend(&self, surface: &Surface<'_>, points: &Pulls, first: Vec<DVec3>) -> Vec<DVec3> {
        let template = self.template;
        let rest = &template.positions;
        let open: Vec<u32> = (0..rest.len() as u32)
            .filter(|&v| self.weights[v as usize] > 0.0)
            .collect();
        let stride = (open.len() / BENT).max(1);
        let sample: Vec<u32> = open.into_iter().step_by(stride).collect();
        let mut face = first;
        for slack in SLACKS {
            let facing = normals(&face, &self.triangles);
            let admission = Admission {
                reach: 15.0,
                cosine: 0.6,
            };
            let found = correspond(surface, &face, &facing, &sample, &admission);
            let surface = found.iter().flatten().map(|c| {
                let place = rest[c.vertex as usize];
                Observation {
                    place,
                    direction: c.normal,
                    displacement: c.normal.dot(c.point - place),
                    slack,
                }
            });
            let landmarks = points.iter().flat_map(|&(l, p)| {
                let place = template.landmark(l, rest);
                DVec3::AXES.map(|direction| Observation {
                    place,
                    direction,
                    displacement: direction.dot(p - place),
                    slack: POINT_SLACK / self.trust(l),
                })
            });
            let observations: Vec<Observation> = surface.chain(landmarks).collect();
            let Some(bending) = Bending::fit(&observations) else {
                break;
            };
            face = rest.iter().map(|&p| p + bending.at(p)).collect();
        }
        face
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

/// Whether a point lies on smooth skin and slides: two people would not set it on the same spot.
fn loose(name: &str) -> bool {
    let jaw_or_brow = name
        .strip_prefix("ibug_")
        .and_then(|n| n.parse::<u32>().ok())
        .is_some_and(|n| n < 27 && n != 8);
    let drawn = ["trichion", "vertex", "cheek", "gonion", "tragion"];
    jaw_or_brow || drawn.iter().any(|d| name.starts_with(d))
}

/// How far landmarks lie off the surface, root mean square, mm: the part of their error that can be
/// seen, a third of the square of all of it when they were set in space and not on the surface.
fn off_surface(points: &[(usize, DVec3)], positions: &[DVec3], normals: &[DVec3]) -> f64 {
    let squares = points.iter().map(|&(_, p)| {
        let nearest = (0..positions.len())
            .min_by(|&a, &b| {
                let distance = |v: usize| positions[v].distance_squared(p);
                distance(a).total_cmp(&distance(b))
            })
            .unwrap_or(0);
        normals[nearest].dot(p - positions[nearest]).powi(2)
    });
    (squares.sum::<f64>() / points.len() as f64).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_halves_of_what_is_told_are_shown_and_nothing_weak_else() {
        let all = [
            ("jawOpen", 0.1),
            ("mouthSmileLeft", 0.25),
            ("mouthSmileRight", 0.15),
            ("browDownLeft", 0.19),
        ];
        let all = all.map(|(name, strength)| (name.to_owned(), strength));
        let names: Vec<&str> = shown(&all).map(|e| &*e.0).collect();
        assert_eq!(names, ["mouthSmileLeft", "mouthSmileRight"]);
        assert_eq!(shown(&all[3..]).count(), 0);
    }
}
