//! Reader of ICT-FaceKit (USC Institute for Creative Technologies, MIT licence): people in one
//! known topology, to simulate scans from and to measure registration against.
//!
//! A person is the neutral mesh plus a sum of normally distributed coefficients times the 100
//! identity modes, which are principal components of light-stage scans, scaled to one standard
//! deviation (Li et al. 2020, "Learning Formation of Physically-Based Face Attributes"). Only the
//! skin is read: the parts "Face" and "Head and Neck". The files are in centimetres; everything is
//! in millimetres once read; y up, z out of the face, x to the subject's left, as here.

use std::path::Path;

use glam::DVec3;
use rayon::prelude::*;

use crate::Random;
use crate::fit::format::obj::Obj;
use crate::fit::{FitError, FitResult};

/// Millimetres in ICT's unit, the centimetre.
const UNIT_MM: f64 = 10.0;

/// Vertices `0..SKIN` are the face, the head and the neck (ICT's README, "Face Model Topology").
const SKIN: usize = 11_248;

/// Polygons `0..SKIN_QUADS` are theirs.
const SKIN_QUADS: usize = 11_144;

/// Vertices `0..NARROW_FACE` are what ICT's README calls the narrow face area.
pub const NARROW_FACE: u32 = 6_706;

/// How many identity modes there are.
const MODES: usize = 100;

/// The vertices of the 68 Multi-PIE (iBUG) points (ICT's README, "Facial Landmarks").
const LANDMARKS: [u32; 68] = [
    1225, 1888, 1052, 367, 1719, 1722, 2199, 1447, 966, 3661, 4390, 3927, 3924, 2608, 3272, 4088,
    3443, 268, 493, 1914, 2044, 1401, 3615, 4240, 4114, 2734, 2509, 978, 4527, 4942, 4857, 1140,
    2075, 1147, 4269, 3360, 1507, 1542, 1537, 1528, 1518, 1511, 3742, 3751, 3756, 3721, 3725, 3732,
    5708, 5695, 2081, 0, 4275, 6200, 6213, 6346, 6461, 5518, 5957, 5841, 5702, 5711, 5533, 6216,
    6207, 6470, 5517, 5966,
];

/// The vertices of the template's other points: of the skull, the nose and the ears. Set by hand.
pub const OTHER_LANDMARKS: [(&str, u32); 27] = [
    ("glabella", 1398),
    ("pogonion", 968),
    ("supramentale", 7),
    ("trichion", 8253),
    ("vertex", 10527),
    ("alare right", 64),
    ("alare left", 2305),
    ("tragion right", 7467),
    ("tragion left", 6740),
    ("gonion right", 1834),
    ("gonion left", 4036),
    ("cheek right", 2151),
    ("cheek left", 4344),
    ("postaurale right", 7949),
    ("postaurale left", 7222),
    ("helix root right", 8155),
    ("helix root left", 7428),
    ("crus helicis right", 7532),
    ("crus helicis left", 6805),
    ("intertragic notch right", 7785),
    ("intertragic notch left", 7058),
    ("superaurale right", 7571),
    ("superaurale left", 6844),
    ("subaurale right", 7852),
    ("subaurale left", 7125),
    ("lower helix right", 7584),
    ("lower helix left", 6857),
];

/// The skin of ICT's face model.
#[derive(Debug, Clone, PartialEq)]
pub struct Ict {
    /// The mean head: 11,248 vertices, mm. The origin is inside the head, below the eyes.
    pub neutral: Vec<DVec3>,
    /// The displacement of each vertex by one standard deviation of each identity mode, mm.
    pub modes: Vec<Vec<DVec3>>,
    /// 22,288 triangles, counter-clockwise from outside. Open at the eyes, the mouth and the neck.
    pub triangles: Vec<[u32; 3]>,
    /// The vertex of each landmark, `ibug_00` to `ibug_67`.
    pub landmarks: [u32; 68],
}

impl Ict {
    /// Reads `FaceXModel/generic_neutral_mesh.obj` and `identity000.obj` to `identity099.obj` in
    /// `dir`.
    ///
    /// # Errors
    /// When a file is missing, is no OBJ file, or does not hold the vertices and polygons that ICT's
    /// README tells of.
    pub fn read(dir: &Path) -> FitResult<Self> {
        let folder = dir.join("FaceXModel");
        let mean = read_obj(&folder.join("generic_neutral_mesh.obj"))?;
        let skin = |obj: &Obj| -> Vec<DVec3> {
            obj.positions[..SKIN].iter().map(|&p| p * UNIT_MM).collect()
        };
        let neutral = skin(&mean);
        let modes = (0..MODES)
            .into_par_iter()
            .map(|mode| {
                let moved = read_obj(&folder.join(format!("identity{mode:03}.obj")))?;
                let pairs = skin(&moved).into_iter().zip(&neutral);
                Ok(pairs.map(|(m, n)| m - n).collect())
            })
            .collect::<FitResult<_>>()?;
        // A quad is not flat: which diagonal divides it is part of what the surface is. The
        // shorter one on the mean head, for everybody.
        let triangles = (0..SKIN_QUADS)
            .flat_map(|quad| {
                let corners = mean.polygon(quad);
                let [a, b, c, d] = [0, 1, 2, 3].map(|i| corners[i][0]);
                let length =
                    |from: u32, to: u32| neutral[from as usize].distance(neutral[to as usize]);
                if length(a, c) <= length(b, d) {
                    [[a, b, c], [a, c, d]]
                } else {
                    [[a, b, d], [b, c, d]]
                }
            })
            .collect();
        Ok(Self {
            neutral,
            modes,
            triangles,
            landmarks: LANDMARKS,
        })
    }

    /// The coefficients of a person: one a mode, independent and standard normal, the same for
    /// the same seed.
    pub fn coefficients(&self, seed: u64) -> Vec<f64> {
        let mut random = Random::stream(seed, 0);
        self.modes.iter().map(|_| random.normal()).collect()
    }

    /// The vertices of the person with these coefficients (at most as many as there are modes),
    /// mm.
    pub fn positions(&self, coefficients: &[f64]) -> Vec<DVec3> {
        let mut positions = self.neutral.clone();
        for (mode, &coefficient) in self.modes.iter().zip(coefficients) {
            for (position, displacement) in positions.iter_mut().zip(mode) {
                *position += *displacement * coefficient;
            }
        }
        positions
    }

    /// The vertices of the person of a seed, mm.
    pub fn person(&self, seed: u64) -> Vec<DVec3> {
        self.positions(&self.coefficients(seed))
    }
}

/// One of ICT's meshes, with at least the skin.
fn read_obj(path: &Path) -> FitResult<Obj> {
    let obj = Obj::read(path)?;
    let quads = obj.polygons() >= SKIN_QUADS
        && (0..SKIN_QUADS).all(|q| {
            let corners = obj.polygon(q);
            corners.len() == 4 && corners.iter().all(|c| (c[0] as usize) < SKIN)
        });
    if obj.positions.len() < SKIN || !quads {
        let cause = format!(
            "does not begin with the {SKIN} vertices and {SKIN_QUADS} quads of the skin: not a \
             mesh of ICT-FaceKit"
        );
        return Err(FitError::file(path, cause));
    }
    Ok(obj)
}
