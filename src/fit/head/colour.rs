//! The prescribed colours of the generic head.
//!
//! Colours are a vertex's own, so every border is a soft step a little wider than the mesh.

use glam::{DVec3, Vec3};

use super::eyeball::Eyeball;
use super::region::point;
use super::template::Template;
use crate::anatomy::brow_hair;
use crate::fit::FitResult;
use crate::fit::mesh::surface::normals;

type Rgb = [f64; 3];

const SKIN: Rgb = [221.0, 176.0, 150.0];
const FLUSH: Rgb = [214.0, 140.0, 122.0];
const LIP: Rgb = [178.0, 98.0, 94.0];
const INNER_LIP: Rgb = [140.0, 62.0, 64.0];
const BROW: Rgb = [92.0, 66.0, 52.0];
const LASH: Rgb = [74.0, 50.0, 44.0];
const CARUNCLE: Rgb = [214.0, 132.0, 122.0];
const NOSTRIL: Rgb = [92.0, 44.0, 38.0];
const CAVITY: Rgb = [88.0, 30.0, 32.0];
const SCLERA: Rgb = [236.0, 230.0, 224.0];
const SCLERA_EDGE: Rgb = [214.0, 176.0, 164.0];
const LIMBUS: Rgb = [44.0, 36.0, 32.0];
const IRIS_OUTER: Rgb = [84.0, 62.0, 42.0];
const IRIS_INNER: Rgb = [134.0, 98.0, 60.0];
const PUPIL: Rgb = [12.0, 10.0, 10.0];

/// Paints skin, lips, brows, lash lines, nostrils, cavities and eyes.
pub fn paint(template: &mut Template, eye: &Eyeball) -> FitResult<()> {
    let positions = template.positions.clone();
    let mut colours = vec![SKIN; positions.len()];
    let outer_lip = closed(template, "ibug_", &(48..60).collect::<Vec<_>>())?;
    let inner_lip = closed(template, "ibug_", &(60..68).collect::<Vec<_>>())?;
    let mouth = point(template, "ibug_62")?;
    let brows = brows(template)?;
    let flushed = [
        (point(template, "cheek left")?, 26.0, 0.35),
        (point(template, "cheek right")?, 26.0, 0.35),
        (point(template, "ibug_30")?, 13.0, 0.35),
        (
            point(template, "tragion left")? + DVec3::new(8.0, 0.0, -14.0),
            26.0,
            0.4,
        ),
        (
            point(template, "tragion right")? + DVec3::new(-8.0, 0.0, -14.0),
            26.0,
            0.4,
        ),
        (point(template, "pogonion")?, 14.0, 0.18),
    ];
    let parts = Parts::new(template)?;
    let dark = nostrils(template, point(template, "ibug_33")?)?;
    for (vertex, &p) in positions.iter().enumerate() {
        let mut colour = SKIN;
        for (at, reach, strength) in flushed {
            let x = p.distance(at) / reach;
            colour = mix(colour, FLUSH, strength * (-x * x).exp());
        }
        for brow in &brows {
            let (distance, along) = from_curve(brow, p);
            // Full at the inner end, thin at the outer.
            let half = 3.6 - 2.0 * along;
            let ends = step(-0.06, 0.14, along) * (1.0 - 0.4 * step(0.85, 1.0, along));
            colour = mix(
                colour,
                BROW,
                0.72 * ends * (1.0 - step(half - 1.8, half + 1.8, distance)),
            );
        }
        // Lips are seen from the front; nothing behind the mouth's corners is lip.
        if p.z > mouth.z - 30.0 {
            let inside = signed(&outer_lip, p);
            colour = mix(colour, LIP, 0.85 * step(-0.9, 0.9, inside));
            colour = mix(
                colour,
                INNER_LIP,
                0.7 * step(-1.2, 0.8, signed(&inner_lip, p)),
            );
        }
        colour = mix(colour, NOSTRIL, dark[vertex]);
        if parts.eye_distance[vertex] < 6.0 {
            let d = parts.eye_distance[vertex];
            let corner = ["ibug_39", "ibug_42"]
                .iter()
                .filter_map(|name| point(template, name).ok())
                .map(|c| c.distance(p))
                .fold(f64::INFINITY, f64::min);
            let upper = if parts.upper_lid[vertex] { 0.75 } else { 0.3 };
            let lash = upper * step(2.0, 6.0, corner) * (1.0 - step(0.4, 1.9, d));
            colour = mix(colour, LASH, lash);
            colour = mix(colour, CARUNCLE, 0.8 * (1.0 - step(1.0, 3.5, corner)));
        }
        if parts.in_mouth[vertex] {
            let depth = mouth.distance(p);
            colour = mix(colour, CAVITY, step(6.0, 14.0, depth));
        }
        if parts.in_eye[vertex] {
            colour = mix(CARUNCLE, CAVITY, step(1.0, 5.0, parts.eye_distance[vertex]));
        }
        colours[vertex] = colour;
    }
    for (angle, vertex) in parts.eyeballs.iter().flat_map(|ball| {
        // An eyeball's vertices are found again by their angle from the forward axis.
        let centre: DVec3 = eye_centre(ball, &positions, eye);
        ball.iter().map(move |&v| (v, centre)).map(|(v, c)| {
            let out = (positions[v as usize] - c).normalize_or(DVec3::Z);
            (out.z.clamp(-1.0, 1.0).acos().to_degrees(), v)
        })
    }) {
        let around = positions[vertex as usize];
        // Streaks of the iris: a fixed pattern of the place.
        let streak = 0.5 + 0.5 * (around.x * 9.1 + around.y * 13.7).sin();
        let iris = mix(
            IRIS_INNER,
            IRIS_OUTER,
            step(10.0, 22.0, angle) * 0.8 + 0.2 * streak,
        );
        let mut colour = mix(PUPIL, iris, step(8.5, 9.5, angle));
        colour = mix(colour, LIMBUS, 0.7 * step(19.5, 23.0, angle));
        colour = mix(colour, SCLERA, step(23.2, 25.8, angle));
        colour = mix(colour, SCLERA_EDGE, step(40.0, 75.0, angle));
        colours[vertex as usize] = colour;
    }
    template.topology.colours = colours
        .iter()
        .map(|c| c.map(|x| x.clamp(0.0, 255.0).round() as u8))
        .collect();
    Ok(())
}

fn eye_centre(ball: &[u32], positions: &[DVec3], eye: &Eyeball) -> DVec3 {
    let mut low = DVec3::INFINITY;
    let mut high = DVec3::NEG_INFINITY;
    for &v in ball {
        low = low.min(positions[v as usize]);
        high = high.max(positions[v as usize]);
    }
    // The foremost point is the pole; x and y are symmetric about the axis.
    DVec3::new(
        (low.x + high.x) / 2.0,
        (low.y + high.y) / 2.0,
        high.z - eye.radius,
    )
}

/// Which vertices lie in which part, and where the lids' rims are.
struct Parts {
    in_mouth: Vec<bool>,
    in_eye: Vec<bool>,
    upper_lid: Vec<bool>,
    /// Distance to the nearest lid rim, mm.
    eye_distance: Vec<f64>,
    eyeballs: Vec<Vec<u32>>,
}

impl Parts {
    fn new(template: &Template) -> FitResult<Parts> {
        let n = template.positions.len();
        let vertices = |name: &str| -> FitResult<Vec<bool>> {
            let mut mask = vec![false; n];
            for v in template.part_vertices(name)? {
                mask[v as usize] = true;
            }
            Ok(mask)
        };
        let (skin, mouth, eyes) = (
            vertices("skin")?,
            vertices("mouth cavity")?,
            vertices("eye cavities")?,
        );
        let rim: Vec<usize> = (0..n).filter(|&v| skin[v] && eyes[v]).collect();
        // The corners of an eye part upper from lower lid.
        let corners: Vec<[DVec3; 2]> = [("ibug_42", "ibug_45"), ("ibug_39", "ibug_36")]
            .iter()
            .filter_map(|(a, b)| Some([point(template, a).ok()?, point(template, b).ok()?]))
            .collect();
        let upper = |p: DVec3| {
            corners.iter().any(|[a, b]| {
                let t = (p.x - a.x) / (b.x - a.x);
                (-0.1..=1.1).contains(&t) && p.y > a.lerp(*b, t).y
            })
        };
        let at = &template.positions;
        Ok(Parts {
            eye_distance: (0..n)
                .map(|v| {
                    rim.iter()
                        .map(|&r| at[r].distance(at[v]))
                        .fold(f64::INFINITY, f64::min)
                })
                .collect(),
            upper_lid: at.iter().map(|&p| upper(p)).collect(),
            in_mouth: (0..n).map(|v| mouth[v] && !skin[v]).collect(),
            in_eye: (0..n).map(|v| eyes[v] && !skin[v]).collect(),
            eyeballs: vec![
                template.part_vertices("left eyeball")?,
                template.part_vertices("right eyeball")?,
            ],
        })
    }
}

/// How deep a vertex lies in a nostril, 0 to 1: the share of directions around its normal in which
/// the nose itself is met within 14 mm, above what an open crease has.
fn nostrils(template: &Template, base: DVec3) -> FitResult<Vec<f64>> {
    let skin = template.part_triangles("skin")?;
    let at = &template.positions;
    let near = |p: DVec3| p.distance(base) < 26.0;
    let walls: Vec<[DVec3; 3]> = skin
        .iter()
        .map(|t| t.map(|v| at[v as usize]))
        .filter(|t| t.iter().all(|&p| p.distance(base) < 34.0))
        .collect();
    let normal = normals(at, &skin);
    // 24 directions, even over the sphere (Fibonacci lattice); those outward of a normal count.
    let directions: Vec<DVec3> = (0..24)
        .map(|i| {
            let z = 1.0 - (2.0 * f64::from(i) + 1.0) / 24.0;
            let (sin, cos) = (f64::from(i) * 2.399_963_229_728_653).sin_cos();
            let r = (1.0 - z * z).sqrt();
            DVec3::new(r * cos, r * sin, z)
        })
        .collect();
    let mut dark: Vec<f64> = (0..at.len())
        .map(|v| {
            // Seen on the nose only: not on the lips below.
            if !near(at[v]) || normal[v] == DVec3::ZERO || at[v].y < base.y - 4.0 {
                return 0.0;
            }
            let origin = at[v] + normal[v] * 0.2;
            let (mut met, mut all) = (0.0, 0.0);
            for &direction in &directions {
                let cosine = direction.dot(normal[v]);
                if cosine > 0.1 {
                    all += cosine;
                    if walls.iter().any(|t| hits(t, origin, direction, 14.0)) {
                        met += cosine;
                    }
                }
            }
            0.9 * step(0.25, 0.55, met / f64::max(all, 1e-9))
        })
        .collect();
    // The few directions leave grain: two rounds of averaging over neighbours.
    for _ in 0..2 {
        let mut sums = vec![(0.0, 0.0); at.len()];
        for t in &skin {
            for (from, to) in [(0, 1), (1, 2), (2, 0)] {
                for (from, to) in [(t[from], t[to]), (t[to], t[from])] {
                    sums[to as usize].0 += dark[from as usize];
                    sums[to as usize].1 += 1.0;
                }
            }
        }
        for (value, (sum, count)) in dark.iter_mut().zip(sums) {
            if count > 0.0 {
                *value = 0.5 * (*value + sum / count);
            }
        }
    }
    Ok(dark)
}

/// Moeller and Trumbore's test of a ray against a triangle, 1997.
fn hits(&[a, b, c]: &[DVec3; 3], origin: DVec3, direction: DVec3, reach: f64) -> bool {
    let (ab, ac) = (b - a, c - a);
    let cross = direction.cross(ac);
    let determinant = ab.dot(cross);
    if determinant.abs() < 1e-12 {
        return false;
    }
    let from = (origin - a) / determinant;
    let u = from.dot(cross);
    let across = from.cross(ab);
    let v = direction.dot(across);
    let distance = ac.dot(across);
    u >= 0.0 && v >= 0.0 && u + v <= 1.0 && distance > 1e-6 && distance < reach
}

fn mix(a: Rgb, b: Rgb, t: f64) -> Rgb {
    [0, 1, 2].map(|i| a[i] + (b[i] - a[i]) * t.clamp(0.0, 1.0))
}

/// Smooth step from 0 at `low` to 1 at `high`.
fn step(low: f64, high: f64, x: f64) -> f64 {
    let t = ((x - low) / (high - low)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// A Catmull-Rom spline through points, 8 pieces a span; the ends are repeated when open.
fn spline(points: &[DVec3], closed: bool) -> Vec<DVec3> {
    let n = points.len();
    let at = |i: isize| {
        if closed {
            points[i.rem_euclid(n as isize) as usize]
        } else {
            points[i.clamp(0, n as isize - 1) as usize]
        }
    };
    let spans = if closed { n } else { n - 1 };
    let mut curve = Vec::new();
    for span in 0..spans as isize {
        let [a, b, c, d] = [-1, 0, 1, 2].map(|o| at(span + o));
        for piece in 0..8 {
            let t = f64::from(piece) / 8.0;
            curve.push(
                0.5 * (2.0 * b
                    + (c - a) * t
                    + (2.0 * a - 5.0 * b + 4.0 * c - d) * t * t
                    + (3.0 * b - a - 3.0 * c + d) * t * t * t),
            );
        }
    }
    curve.push(at(spans as isize));
    curve
}

fn closed(template: &Template, prefix: &str, numbers: &[u32]) -> FitResult<Vec<DVec3>> {
    let points: FitResult<Vec<DVec3>> = numbers
        .iter()
        .map(|n| point(template, &format!("{prefix}{n:02}")))
        .collect();
    Ok(spline(&points?, true))
}

/// The lines along which brows grow, left and right, from the nose outwards.
fn brows(template: &Template) -> FitResult<[Vec<DVec3>; 2]> {
    let mut points = [Vec3::ZERO; 10];
    for (i, of) in points.iter_mut().enumerate() {
        *of = point(template, &format!("ibug_{:02}", 17 + i))?.as_vec3();
    }
    let positions: Vec<Vec3> = template.positions.iter().map(|p| p.as_vec3()).collect();
    let hair = brow_hair(points, &positions).map(|p| p.as_dvec3());
    let right: Vec<DVec3> = hair[..5].iter().rev().copied().collect();
    Ok([spline(&hair[5..], false), spline(&right, false)])
}

/// Distance to a curve, and how far along it (0 to 1) the nearest point is.
fn from_curve(curve: &[DVec3], p: DVec3) -> (f64, f64) {
    let mut best = (f64::INFINITY, 0.0);
    for (i, ends) in curve.windows(2).enumerate() {
        let edge = ends[1] - ends[0];
        let t = ((p - ends[0]).dot(edge) / edge.length_squared().max(1e-12)).clamp(0.0, 1.0);
        let d = p.distance(ends[0] + edge * t);
        if d < best.0 {
            best = (d, (i as f64 + t) / (curve.len() - 1) as f64);
        }
    }
    best
}

/// Distance to a closed curve seen from the front (x, y), positive inside.
fn signed(curve: &[DVec3], p: DVec3) -> f64 {
    let mut inside = false;
    let mut distance = f64::INFINITY;
    for ends in curve.windows(2) {
        let (a, b) = (ends[0].truncate(), ends[1].truncate());
        let q = p.truncate();
        if (a.y > q.y) != (b.y > q.y) && q.x < a.x + (b.x - a.x) * (q.y - a.y) / (b.y - a.y) {
            inside = !inside;
        }
        let edge = b - a;
        let t = ((q - a).dot(edge) / edge.length_squared().max(1e-12)).clamp(0.0, 1.0);
        distance = distance.min(q.distance(a + edge * t));
    }
    if inside { distance } else { -distance }
}
