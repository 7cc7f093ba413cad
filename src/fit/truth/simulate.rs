//! Scan-like, unregistered meshes of people whose true shape is known.
//!
//! A person of [`Ict`] becomes what a scanner might leave: other vertices and triangles on the
//! same surface ([`crate::fit::mesh::resample`]), noise, holes, any pose, landmarks that a hand set nearly
//! right. The truth is kept aside: the seed, the coefficients and the pose.

use std::collections::BTreeSet;
use std::path::Path;

use glam::{DMat3, DVec3};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::ict::{Ict, OTHER_LANDMARKS};
use crate::Random;
use crate::fit::format::files::write_atomically;
use crate::fit::format::ply::{faces, write_mesh};
use crate::fit::mesh::align::Rigid;
use crate::fit::mesh::resample::{Resampler, SurfacePoint};
use crate::fit::mesh::surface::{Surface, border};
use crate::fit::scan::Scan;
use crate::fit::{FitError, FitResult};
use crate::model::{About, Licence};

/// How a scan differs from the person.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Settings {
    /// Standard deviation of the surface noise along the normal, mm; each vertex on its own.
    pub noise: f64,
    /// Mean length of the landmarks' errors, mm; normally distributed, alike in every direction.
    pub jitter: f64,
    /// Whether what scanners do not see is missing: the inside of the nostrils, the back of the
    /// ears, a ragged crown, a slanted end of the neck, and a few small holes anywhere.
    pub holes: bool,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            noise: 0.0,
            jitter: 0.5,
            holes: false,
        }
    }
}

/// What a simulated scan was made from.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Truth {
    /// The person's seed.
    pub seed: u64,
    /// The person's coefficients: [`Ict::coefficients`] of the seed.
    pub coefficients: Vec<f64>,
    /// The motion from ICT's pose to the scan's.
    pub pose: Rigid,
    /// How the scan was made of the person.
    pub settings: Settings,
}

impl Truth {
    /// The person in the scan's pose, in ICT's topology, without noise, whole; mm.
    pub fn positions(&self, ict: &Ict) -> Vec<DVec3> {
        let positions = ict.positions(&self.coefficients);
        positions.into_iter().map(|p| self.pose.apply(p)).collect()
    }
}

/// A simulated scan.
#[derive(Debug, Clone)]
pub struct Simulated {
    /// The scan.
    pub scan: Scan,
    /// The landmarks as they were set, mm, in the scan's pose: `ibug_00` to `ibug_67`, then
    /// [`OTHER_LANDMARKS`].
    pub landmarks: Vec<DVec3>,
    /// What it was made from.
    pub truth: Truth,
}

/// Turns people into scans.
pub struct Simulator<'a> {
    ict: &'a Ict,
    resampler: Resampler<'a>,
    /// The part of the cameras around the head that see each vertex of the mean, 0 to 1.
    seen: Vec<f64>,
}

/// The greatest angles of the random pose, degrees: yaw, pitch, roll.
const POSE: [f64; 3] = [60.0, 30.0, 30.0];

/// The greatest translation along each axis, mm.
const TRANSLATION: f64 = 300.0;

/// A landmark farther than this from the surface, besides its error, is in a hole, mm.
const IN_HOLE: f64 = 3.0;

/// A component of fewer triangles than this is a crumb that scanning programs remove.
const CRUMB: usize = 300;

impl<'a> Simulator<'a> {
    /// Prepares the people of `ict`.
    pub fn new(ict: &'a Ict) -> Self {
        Self {
            ict,
            resampler: Resampler::new(ict.neutral.len(), &ict.triangles),
            seen: seen(ict),
        }
    }

    /// The scan of the person of a seed; everything of it is drawn from that seed.
    pub fn scan(&self, seed: u64, settings: &Settings) -> Simulated {
        let coefficients = self.ict.coefficients(seed);
        let person = self.ict.positions(&coefficients);
        // A stream for each thing, so that a scan with holes is the scan without them, less the
        // holes.
        let stream = |index| Random::stream(seed, index);
        let pose = pose(&mut stream(1));
        let (points, mut triangles) = self.resampler.resample(&person, &mut stream(2));
        let mut positions: Vec<DVec3> = points
            .iter()
            .map(|p| p.on(&person, &self.ict.triangles))
            .collect();
        if settings.noise > 0.0 {
            let normals = crate::fit::mesh::surface::normals(&positions, &triangles);
            let mut random = stream(3);
            for (position, normal) in positions.iter_mut().zip(normals) {
                *position += normal * settings.noise * random.normal();
            }
        }
        if settings.holes {
            let lost = self.lost(&points, &positions, &mut stream(4));
            triangles.retain(|t| t.iter().all(|&v| !lost[v as usize]));
            (positions, triangles) = whole(&positions, triangles);
        }
        for position in &mut positions {
            *position = pose.apply(*position);
        }
        // The mean length of a normal vector in space is sqrt(8 / pi) standard deviations.
        let sigma = settings.jitter / (8.0 / std::f64::consts::PI).sqrt();
        let mut random = stream(5);
        let landmarks = self
            .ict
            .landmarks
            .into_iter()
            .chain(OTHER_LANDMARKS.map(|(_, v)| v))
            .map(|v| {
                let error = DVec3::from_array(std::array::from_fn(|_| random.normal()));
                pose.apply(person[v as usize]) + error * sigma
            })
            .collect();
        Simulated {
            scan: Scan {
                positions,
                triangles,
                scale: 1.0,
                ..Scan::default()
            },
            landmarks,
            truth: Truth {
                seed,
                coefficients,
                pose,
                settings: *settings,
            },
        }
    }

    /// Which vertices of a scan are in its holes.
    fn lost(&self, points: &[SurfacePoint], positions: &[DVec3], random: &mut Random) -> Vec<bool> {
        let between =
            |from: f64, to: f64, random: &mut Random| from + (to - from) * random.uniform();
        let mut wave = || {
            let axis =
                |random: &mut Random| DVec3::from_array(std::array::from_fn(|_| random.normal()));
            // Wavelengths of 20 to 60 mm: a border as hair and shadow leave it.
            let length = between(20.0, 60.0, random);
            let (along, phase) = (axis(random).normalize_or_zero(), random.uniform());
            move |p: DVec3| (std::f64::consts::TAU * (p.dot(along) / length + phase)).sin()
        };
        let waves: Vec<_> = (0..4).map(|_| wave()).collect();
        let ragged = |p: DVec3| waves.iter().map(|wave| wave(p)).sum::<f64>() / waves.len() as f64;

        // Where hair is: around a point of the skull, up and back.
        let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for &p in positions {
            low = low.min(p);
            high = high.max(p);
        }
        let crown = DVec3::new(
            between(-15.0, 15.0, random),
            high.y,
            low.z + (high.z - low.z) * between(0.2, 0.5, random),
        );
        let bald = between(25.0, 70.0, random);
        // Where the neck ends: a plane that leans.
        let end = low.y + between(2.0, 35.0, random);
        let lean = [0; 2].map(|_| between(-0.15, 0.15, random));
        let threshold = between(0.02, 0.07, random);
        let small: Vec<(DVec3, f64)> = (0..3 + random.bits() % 8)
            .map(|_| {
                let vertex = random.bits() % positions.len() as u64;
                (positions[vertex as usize], between(1.0, 4.0, random))
            })
            .collect();
        points
            .iter()
            .zip(positions)
            .map(|(point, &p)| {
                let corners = self.ict.triangles[point.triangle as usize];
                let seen: f64 = (0..3)
                    .map(|i| self.seen[corners[i] as usize] * point.weights[i])
                    .sum();
                let ragged = ragged(p);
                seen < threshold
                    || p.distance(crown) < bald * (1.0 + 0.4 * ragged)
                    || p.y + lean[0] * p.x + lean[1] * p.z < end + 4.0 * ragged
                    || small
                        .iter()
                        .any(|&(centre, radius)| p.distance(centre) < radius * (1.0 + 0.5 * ragged))
            })
            .collect()
    }
}

/// For each vertex of the mean, the part of the cameras that see it: not edge-on, nothing between.
/// The cameras stand where those of scanners stand, around the front and the sides.
fn seen(ict: &Ict) -> Vec<f64> {
    let surface = Surface::new(&ict.neutral, &ict.triangles);
    let cameras: Vec<DVec3> = [-20.0_f64, 10.0, 40.0]
        .into_iter()
        .flat_map(|height| {
            (-5..=5).map(move |i| {
                let (around, up) = ((f64::from(i) * 24.0).to_radians(), height.to_radians());
                DVec3::new(around.sin() * up.cos(), up.sin(), around.cos() * up.cos())
            })
        })
        .collect();
    (0..ict.neutral.len())
        .into_par_iter()
        .map(|v| {
            let normal = surface.normals[v];
            // From just above the skin, or the vertex would hide itself.
            let eye = ict.neutral[v] + normal * 0.05;
            let free = cameras.iter().filter(|&&camera| {
                normal.dot(camera) > 0.17 && surface.cast(eye, camera, 400.0).is_none()
            });
            free.count() as f64 / cameras.len() as f64
        })
        .collect()
}

/// A random pose about ICT's origin, which is inside the head.
fn pose(random: &mut Random) -> Rigid {
    let mut within = |limit: f64| (2.0 * random.uniform() - 1.0) * limit;
    let [yaw, pitch, roll] = POSE.map(|limit| within(limit).to_radians());
    let translation = DVec3::from_array([0; 3].map(|_| within(TRANSLATION)));
    Rigid {
        rotation: DMat3::from_rotation_y(yaw)
            * DMat3::from_rotation_x(pitch)
            * DMat3::from_rotation_z(roll),
        translation,
    }
}

/// Makes a manifold of what holes left: no vertex with two fans, no crumbs, no unused vertices.
fn whole(positions: &[DVec3], mut triangles: Vec<[u32; 3]>) -> (Vec<DVec3>, Vec<[u32; 3]>) {
    loop {
        // At a vertex of one fan, as many edges end as triangles, or one more at the border.
        let open = border(positions.len(), &triangles);
        let mut ends = vec![0_u32; positions.len()];
        let mut halves: Vec<(u32, u32)> = triangles
            .iter()
            .flat_map(|&[a, b, c]| [(a, b), (b, c), (c, a)])
            .collect();
        halves.sort_unstable();
        for &(a, b) in &halves {
            // Leaving a: all that no triangle has the other way round are the border's.
            if halves.binary_search(&(b, a)).is_err() {
                ends[a as usize] += 1;
            }
        }
        let before = triangles.len();
        triangles.retain(|t| {
            t.iter()
                .all(|&v| !open[v as usize] || ends[v as usize] == 1)
        });
        if triangles.len() == before {
            break;
        }
    }
    // Components, by union of the triangles' corners.
    let mut root: Vec<u32> = (0..positions.len() as u32).collect();
    fn find(root: &mut [u32], mut v: u32) -> u32 {
        while root[v as usize] != v {
            root[v as usize] = root[root[v as usize] as usize];
            v = root[v as usize];
        }
        v
    }
    for t in &triangles {
        let a = find(&mut root, t[0]);
        for &v in &t[1..] {
            let b = find(&mut root, v);
            root[b as usize] = a;
        }
    }
    let mut size = vec![0; positions.len()];
    for t in &triangles {
        size[find(&mut root, t[0]) as usize] += 1;
    }
    triangles.retain(|t| size[find(&mut root, t[0]) as usize] >= CRUMB);
    let mut number = vec![u32::MAX; positions.len()];
    let mut kept = Vec::new();
    for vertex in triangles.as_flattened_mut() {
        let slot = &mut number[*vertex as usize];
        if *slot == u32::MAX {
            *slot = kept.len() as u32;
            kept.push(positions[*vertex as usize]);
        }
        *vertex = *slot;
    }
    (kept, triangles)
}

/// What its people are drawn from: a linear model.
pub const SOURCE: &str = "ICT-FaceKit (ICT Face Model Light)";

/// What a model that is learned from such people says of itself.
pub fn about() -> About {
    About {
        title: "phiz adults from ICT-FaceKit".into(),
        population: "Adults drawn from the identity modes of ICT-FaceKit, which are principal \
                     components of light-stage scans of people, each turned into a scan and \
                     registered again."
            .into(),
        caveat: "Who was scanned for ICT-FaceKit is not published. Percentiles say where a face \
                 stands among these samples, nothing about people of any origin, sex or age."
            .into(),
        licences: vec![
            Licence {
                source: SOURCE.into(),
                by: "USC Institute for Creative Technologies, Vision and Graphics Lab; \
                     Copyright (c) 2020"
                    .into(),
                licence: "MIT".into(),
            },
            // The generic head that is registered to them.
            crate::fit::head::base_mesh::licence(),
        ],
        ..About::default()
    }
}

/// What the files of a seed's person are called, but for their endings.
pub fn name(seed: u64) -> String {
    format!("person_{seed:04}")
}

/// Refuses a folder with scans that are none of these people's, made otherwise, or nobody's: who learns from it would
/// learn from all of them, and `about.json` would not be true of some.
///
/// # Errors
/// When there is one, or the folder cannot be read.
pub fn check_folder(dir: &Path, seed: u64, count: u32, settings: &Settings) -> FitResult<()> {
    if !dir.exists() {
        return Ok(());
    }
    let own: BTreeSet<_> = (0..count)
        .map(|i| dir.join(name(seed.wrapping_add(i.into())) + ".ply"))
        .collect();
    let mut others = faces(dir)?;
    others.retain(|scan| !own.contains(scan));
    others.sort();
    // JSON's numbers are read to the last place but one.
    let near = |a: f64, b: f64| (a - b).abs() < 1e-9;
    let same = |a: &Settings, b: &Settings| {
        near(a.noise, b.noise) && near(a.jitter, b.jitter) && a.holes == b.holes
    };
    for scan in others {
        let stem = scan.file_stem().unwrap_or_default();
        let mut truth = dir.join("truth").join(stem).into_os_string();
        truth.push(".json");
        let truth = std::fs::read(truth).ok();
        let truth = truth.and_then(|bytes| serde_json::from_slice::<Truth>(&bytes).ok());
        let cause = match truth {
            Some(truth) if same(&truth.settings, settings) => continue,
            Some(_) => {
                "a person of other noise, errors or holes: these go to a folder of their own"
            }
            None => "is none of these people's scans: they go to a folder of their own",
        };
        return Err(FitError::file(&scan, cause));
    }
    Ok(())
}

/// Writes `count` scans of the seeds from `seed` on: `person_SEED.ply` with the landmarks in
/// `person_SEED.json`, the truth in `truth/person_SEED.json`, and `about.json`, which `train` puts
/// into the model. The 68 iBUG points are written, or with `all_points` the others too, but none in
/// a hole. `done` is
/// called after each. Others of the same settings may be there.
///
/// # Errors
/// Those of [`check_folder`], and when the folder cannot be written to.
pub fn write(
    simulator: &Simulator,
    seed: u64,
    count: u32,
    settings: &Settings,
    all_points: bool,
    dir: &Path,
    done: impl Fn() + Sync,
) -> FitResult<()> {
    check_folder(dir, seed, count, settings)?;
    let truths = dir.join("truth");
    std::fs::create_dir_all(&truths).map_err(|e| FitError::file(&truths, e))?;
    let mut names: Vec<String> = (0..68).map(|i| format!("ibug_{i:02}")).collect();
    if all_points {
        names.extend(OTHER_LANDMARKS.map(|(name, _)| name.to_owned()));
    }
    (0..u64::from(count)).into_par_iter().try_for_each(|i| {
        let seed = seed.wrapping_add(i);
        let person = simulator.scan(seed, settings);
        let name = name(seed);
        // Nobody sets a point in a hole.
        let surface = Surface::new(&person.scan.positions, &person.scan.triangles);
        let landmarks: std::collections::BTreeMap<String, [f64; 3]> = person
            .landmarks
            .iter()
            .zip(&names)
            .filter(|(p, _)| {
                surface
                    .closest(**p, IN_HOLE + 4.0 * settings.jitter)
                    .is_some()
            })
            .map(|(p, name)| (name.clone(), p.to_array()))
            .collect();
        write_json(&dir.join(format!("{name}.json")), &landmarks)?;
        write_json(&truths.join(format!("{name}.json")), &person.truth)?;
        write_mesh(
            &dir.join(format!("{name}.ply")),
            &person.scan.positions,
            &person.scan.triangles,
        )?;
        done();
        FitResult::Ok(())
    })?;
    write_json(&dir.join("about.json"), &about())
}

fn write_json(path: &Path, value: &impl Serialize) -> FitResult<()> {
    let json = serde_json::to_vec_pretty(value).map_err(|e| FitError::file(path, e))?;
    write_atomically(path, &json)
}
