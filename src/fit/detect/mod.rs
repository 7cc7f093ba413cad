//! Landmarks without a hand: the statistical face is fitted to a scan from many starts, and its
//! landmarks are read off.

use glam::DVec3;

use super::surface::Surface;
use super::template::Template;
use super::{FitError, FitResult};

mod fit;
mod search;
mod surfels;

use fit::{Fit, Match, Pull, Shape, step};
use search::{Lookout, agreement, starts};
use surfels::Surfels;

/// Finds landmarks on scans.
pub struct Detector {
    /// Evenly spread points of the visible face; the first n of them are so too, for any n.
    face: Shape,
    /// The landmarks.
    marks: Shape,
    tip: Lookout,
}

/// What was found on a scan.
#[derive(Debug, Clone, PartialEq)]
pub struct Detection {
    /// The template's landmarks in their order, mm, on the scan where it reaches.
    pub points: Vec<DVec3>,
    /// How sure each of them is, 0 to 1.
    pub confidences: Vec<f64>,
    /// How well the statistical face lies on the scan, 0 to 1.
    pub score: f64,
}

/// Points of the face that the fit goes by.
const FACE_POINTS: usize = 1500;

impl Detector {
    /// A detector of the template's landmarks. `modes` are displacements of its vertices at one
    /// standard deviation each, mm, the largest first.
    ///
    /// # Errors
    /// When the template has no tip of a nose (`ibug_30`) or no visible face.
    pub fn new(template: &Template, modes: &[Vec<DVec3>]) -> FitResult<Self> {
        let shape = |stencils: &[&[(u32, f64)]], normals: Vec<DVec3>| {
            let at = |field: &[DVec3], stencil: &[(u32, f64)]| -> DVec3 {
                stencil.iter().map(|&(v, w)| field[v as usize] * w).sum()
            };
            Shape {
                mean: stencils.iter().map(|s| at(&template.positions, s)).collect(),
                normals,
                modes: stencils
                    .iter()
                    .flat_map(|s| modes.iter().map(|mode| at(mode, s)))
                    .collect(),
                count: modes.len(),
            }
        };
        let landmarks: Vec<&[(u32, f64)]> =
            template.landmarks.iter().map(|l| &l.stencil[..]).collect();
        let tip = template.landmarks.iter().position(|l| l.name == "ibug_30");
        let Some(tip) = tip else {
            return Err(FitError::Input("the template has no landmark ibug_30".into()));
        };
        let tip = template.landmark(tip, &template.positions);
        let triangles = template.triangles();
        let surface = Surface::new(&template.positions, &triangles);
        let chosen = spread(&visible_face(template, &surface)?, template, tip);
        let stencils: Vec<[(u32, f64); 1]> = chosen.iter().map(|&v| [(v, 1.0)]).collect();
        let normals = chosen.iter().map(|&v| surface.normals[v as usize]).collect();
        let face = shape(&stencils.iter().map(|s| &s[..]).collect::<Vec<_>>(), normals);
        let marks_normals = landmarks
            .iter()
            .map(|s| {
                s.iter()
                    .map(|&(v, w)| surface.normals[v as usize] * w)
                    .sum::<DVec3>()
                    .normalize_or(DVec3::Z)
            })
            .collect();
        let skin = template.part_triangles("skin")?;
        let rough = Surfels::new(&template.positions, &skin, ROUGH_CELL, 0)?;
        Ok(Self {
            face,
            marks: shape(&landmarks, marks_normals),
            tip: Lookout::new(&rough, tip),
        })
    }

    /// Finds the landmarks on a scan, in mm, in any pose.
    ///
    /// # Errors
    /// When nothing on the scan is like a face.
    pub fn find(&self, positions: &[DVec3], triangles: &[[u32; 3]]) -> FitResult<Detection> {
        let t0 = std::time::Instant::now();
        let fine = Surfels::new(positions, triangles, FINE_CELL, 5)?;
        let rough = Surfels::new(positions, triangles, ROUGH_CELL, 0)?;
        let t1 = t0.elapsed().as_secs_f64();
        let mut candidates = starts(&self.face, self.tip, &rough, &fine, 300);
        let t2 = t0.elapsed().as_secs_f64();
        eprintln!("surfels {} {}, starts {}; tip height {:.1}", fine.points.len(), rough.points.len(), candidates.len(), self.tip.height);
        eprintln!("first {:?}", candidates.iter().take(5).map(|c| c.0).collect::<Vec<_>>());
        let near = |gate: f64| {
            let fine = &fine;
            move |p: DVec3, normal: DVec3| on_surfels(fine, p, normal, gate)
        };
        for (worth, fit) in &mut candidates {
            let pull = Pull { points: 200, modes: 0, sigma: 3.0, worth: 100.0 };
            for gate in [20.0, 20.0, 16.0, 16.0, 12.0, 12.0] {
                step(&self.face, fit, pull, near(gate));
            }
            *worth = agreement(&self.face, fit, 300, &fine, 8.0);
        }
        self.best(&mut candidates, 24);
        eprintln!("second {:?}", candidates.iter().take(5).map(|c| c.0).collect::<Vec<_>>());
        let t3 = t0.elapsed().as_secs_f64();
        for (worth, fit) in &mut candidates {
            let pull = Pull { points: 400, modes: 8, sigma: 2.0, worth: 100.0 };
            for gate in [12.0, 12.0, 10.0, 10.0, 8.0, 8.0, 8.0, 8.0] {
                step(&self.face, fit, pull, near(gate));
            }
            *worth = agreement(&self.face, fit, 400, &fine, 6.0);
        }
        self.best(&mut candidates, 3);
        eprintln!("third {:?}", candidates.iter().take(5).map(|c| c.0).collect::<Vec<_>>());
        let t4 = t0.elapsed().as_secs_f64();
        let surface = Surface::new(positions, triangles);
        let t5 = t0.elapsed().as_secs_f64();
        for (worth, fit) in &mut candidates {
            for (gate, modes) in [(8.0, 20), (6.0, 20), (6.0, 40), (5.0, 40), (4.0, 40), (4.0, 80), (4.0, 80), (4.0, 80)] {
                let pull = Pull { points: 800, modes, sigma: 1.0, worth: 200.0 };
                step(&self.face, fit, pull, |p, n| on_surface(&surface, p, n, gate));
            }
            *worth = self.score(fit, &surface, 800);
        }
        self.best(&mut candidates, 1);
        let t6 = t0.elapsed().as_secs_f64();
        let (score, mut fit) = candidates.swap_remove(0);
        for _ in 0..6 {
            let pull = Pull { points: 1500, modes: 100, sigma: 1.0, worth: 200.0 };
            let moved = step(&self.face, &mut fit, pull, |p, n| on_surface(&surface, p, n, 3.0));
            eprint!("{moved:.2?} ");
        }
        let score2 = self.score(&fit, &surface, 1500);
        let t7 = t0.elapsed().as_secs_f64();
        eprintln!("surfels {t1:.3} starts {t2:.3} second {t3:.3} third {t4:.3} bvh {t5:.3} surface {t6:.3} all {t7:.3} score {score:.3} {score2:.3} scale {:.3} c2 {:.1}", fit.scale, fit.coefficients.iter().map(|c| c*c).sum::<f64>());
        let points: Vec<DVec3> = (0..self.marks.mean.len())
            .map(|i| {
                let p = fit.point(&self.marks, i);
                let normal = fit.rotation * self.marks.normals[i];
                on_surface(&surface, p, normal, 6.0).map_or(p, |m| m.point)
            })
            .collect();
        let confidences = vec![1.0; points.len()];
        Ok(Detection { points, confidences, score })
    }

    /// The share of the face's points that lie on the surface.
    fn score(&self, fit: &Fit, surface: &Surface, points: usize) -> f64 {
        let points = points.min(self.face.mean.len());
        let sum: f64 = (0..points)
            .map(|i| {
                let p = fit.point(&self.face, i);
                let normal = fit.rotation * self.face.normals[i];
                surface.closest(p, 3.0).map_or(0.0, |hit| {
                    let facing = surface.normal(&hit).dot(normal);
                    (1.0 - hit.distance * hit.distance / 9.0) * ((facing - 0.3) / 0.7).max(0.0)
                })
            })
            .sum();
        sum / points as f64
    }

    /// Keeps the best candidates, of those that came to the same place only one.
    fn best(&self, candidates: &mut Vec<(f64, Fit)>, most: usize) {
        candidates.sort_by(|a, b| b.0.total_cmp(&a.0));
        let mut kept: Vec<(f64, Fit)> = Vec::new();
        for (worth, fit) in candidates.drain(..) {
            let tip = |fit: &Fit| fit.rotation * self.tip.point * fit.scale + fit.translation;
            let same = |other: &Fit| {
                let turn = (fit.rotation.transpose() * other.rotation).col(0).x
                    .min((fit.rotation.transpose() * other.rotation).col(1).y);
                tip(&fit).distance(tip(other)) < 10.0 && turn > 0.95
            };
            if kept.len() < most && !kept.iter().any(|(_, other)| same(other)) {
                kept.push((worth, fit));
            }
        }
        *candidates = kept;
    }
}

const FINE_CELL: f64 = 4.0;
const ROUGH_CELL: f64 = 10.0;

/// What a point of the face is drawn to among surfels.
fn on_surfels(surfels: &Surfels, p: DVec3, normal: DVec3, gate: f64) -> Option<Match> {
    let j = surfels.near(p)?;
    let away = surfels.points[j].distance_squared(p) / (gate * gate);
    let facing = surfels.normals[j].dot(normal);
    (away < 1.0 && facing > 0.3).then(|| Match {
        point: surfels.points[j],
        normal: surfels.normals[j],
        weight: (1.0 - away) * (1.0 - away) * facing,
    })
}

/// What a point of the face is drawn to on the scan itself.
fn on_surface(surface: &Surface, p: DVec3, normal: DVec3, gate: f64) -> Option<Match> {
    let hit = surface.closest(p, gate)?;
    if surface.on_border(&hit) {
        return None;
    }
    let found = surface.normal(&hit);
    let facing = found.dot(normal);
    let away = hit.distance * hit.distance / (gate * gate);
    (facing > 0.5).then(|| Match {
        point: hit.point,
        normal: found,
        weight: (1.0 - away) * (1.0 - away) * facing,
    })
}

/// Vertices of the skin that are near a landmark of the face and seen from in front or from a side.
fn visible_face(template: &Template, surface: &Surface) -> FitResult<Vec<u32>> {
    let marks: Vec<DVec3> = (0..template.landmarks.len())
        .filter(|&i| !FAR.contains(&template.landmarks[i].name.as_str()))
        .map(|i| template.landmark(i, &template.positions))
        .collect();
    let views = [0.0f64, 60.0, -60.0].map(|yaw| {
        let yaw = yaw.to_radians();
        DVec3::new(yaw.sin(), 0.0, yaw.cos())
    });
    let face: Vec<u32> = template
        .part_vertices("skin")?
        .into_iter()
        .filter(|&v| {
            let p = template.positions[v as usize];
            let normal = surface.normals[v as usize];
            let near = marks.iter().any(|m| m.distance(p) < 26.0);
            near && views.iter().any(|&view| {
                // From a little above the skin, past all of the head.
                normal.dot(view) > 0.2 && surface.cast(p + normal * 0.2 + view * 0.2, view, 500.0).is_none()
            })
        })
        .collect();
    if face.len() < 500 {
        return Err(FitError::Input("the template has hardly any visible face".into()));
    }
    Ok(face)
}

/// Landmarks under hair or behind it.
const FAR: [&str; 6] = [
    "vertex",
    "trichion",
    "tragion right",
    "tragion left",
    "gonion right",
    "gonion left",
];

/// Evenly spread vertices, from `first` on always the one that is farthest from all before.
fn spread(vertices: &[u32], template: &Template, first: DVec3) -> Vec<u32> {
    let at = |i: usize| template.positions[vertices[i] as usize];
    let mut distances: Vec<f64> = (0..vertices.len()).map(|i| -at(i).distance(first)).collect();
    let mut chosen = Vec::new();
    while chosen.len() < FACE_POINTS.min(vertices.len()) {
        let next = (0..vertices.len())
            .max_by(|&a, &b| distances[a].total_cmp(&distances[b]))
            .unwrap_or(0);
        if chosen.is_empty() {
            distances.fill(f64::INFINITY);
        }
        chosen.push(vertices[next]);
        for i in 0..vertices.len() {
            distances[i] = distances[i].min(at(i).distance_squared(at(next)));
        }
    }
    chosen
}
