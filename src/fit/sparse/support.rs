//! Where a component may move the face: regions with a band around them, and the distance to a
//! centre.

use glam::DVec3;

use crate::fit::head::region::point;
use crate::fit::head::template::Template;
use crate::fit::mesh::geodesic::Geodesic;
use crate::fit::{FitError, FitResult};

/// A part of the face that has components of its own.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Region {
    /// Its name.
    pub name: String,
    /// Its vertices, increasing; no vertex is in two regions.
    pub vertices: Vec<u32>,
}

/// How far the face reaches around the features, mm along the skin: to the ears, under the jaw and
/// to the hair line. The rest of the head (skull, ears, neck) says little about a face, and scans
/// seldom show it.
const FACE_REACH: f64 = 30.0;

/// What each part of the face is made of: regions of the template, and landmarks from which it
/// reaches into what no feature has. Those of the left are mirrored.
const PARTS: [(&str, &[&str], &[&str]); 5] = [
    ("eyes", &["left eye", "right eye"], &[]),
    ("nose", &["nose"], &[]),
    ("mouth", &["mouth", "chin"], &["ibug_09", "ibug_10"]),
    ("forehead", &["forehead"], &["ibug_26"]),
    (
        "cheeks",
        &[],
        &["cheek left", "ibug_12", "ibug_13", "ibug_14", "ibug_15"],
    ),
];

/// The five parts of the face that the paper's Fig. 1 colours (section 3.2): both eyes, the nose,
/// the mouth with the chin, the forehead with the temples, and the cheeks. They cover the skin
/// within 30 mm of the features. What no feature of the template has goes to the forehead, the
/// mouth or the cheeks, whichever is nearest along the skin. Each part is its own mirror image.
///
/// # Errors
/// When the template lacks its skin, a region or a landmark.
pub fn face_parts(template: &Template) -> FitResult<Vec<Region>> {
    let skin = template.part_vertices("skin")?;
    let triangles = template.part_triangles("skin")?;
    let surface = Geodesic::new(&template.positions, &triangles);
    let topology = &template.topology;
    let mut part_of_region = vec![None; topology.region_names.len()];
    for (part, (_, names, _)) in PARTS.iter().enumerate() {
        for name in *names {
            let found = topology.region_names.iter().position(|n| n == name);
            let Some(region) = found else {
                let cause = format!("the template has no region called {name:?}");
                return Err(FitError::Input(cause));
            };
            part_of_region[region] = Some(part);
        }
    }
    let own = |v: u32| part_of_region[topology.regions[v as usize] as usize];
    let features: Vec<u32> = skin.iter().copied().filter(|&v| own(v).is_some()).collect();
    let reach = surface.distances(&features, FACE_REACH);
    let mut nearest = vec![(f64::INFINITY, None); template.positions.len()];
    for (part, (_, regions, landmarks)) in PARTS.iter().enumerate() {
        if landmarks.is_empty() {
            continue;
        }
        let mut sources: Vec<u32> = match regions.is_empty() {
            true => Vec::new(),
            false => features
                .iter()
                .copied()
                .filter(|&v| own(v) == Some(part))
                .collect(),
        };
        for name in *landmarks {
            let place = point(template, name)?;
            let to = |&v: &u32| template.positions[v as usize].distance_squared(place);
            if let Some(at) = skin.iter().copied().min_by(|a, b| to(a).total_cmp(&to(b))) {
                sources.extend([at, topology.mirror[at as usize]]);
            }
        }
        for (best, d) in nearest
            .iter_mut()
            .zip(surface.distances(&sources, f64::INFINITY))
        {
            if d < best.0 {
                *best = (d, Some(part));
            }
        }
    }
    let mut parts: Vec<Region> = PARTS
        .iter()
        .map(|(name, _, _)| Region {
            name: (*name).into(),
            vertices: Vec::new(),
        })
        .collect();
    for &v in &skin {
        let image = topology.mirror[v as usize];
        // Both or neither of a pair: of the two the lower number decides.
        let decides = v.min(image) as usize;
        if !reach[v as usize].max(reach[image as usize]).is_finite() {
            continue;
        }
        if let Some(part) = own(decides as u32).or(nearest[decides].1) {
            parts[part].vertices.push(v);
        }
    }
    Ok(parts)
}

/// The parts of the face, and everything else of the template as a sixth region, `head`. Eyeballs
/// and cavities go with the part whose feature they belong to.
///
/// # Errors
/// As [`face_parts`].
pub fn head_parts(template: &Template) -> FitResult<Vec<Region>> {
    let mut parts = face_parts(template)?;
    let skin = template.part_vertices("skin")?;
    let mut part_of = vec![None; template.positions.len()];
    for (number, part) in parts.iter().enumerate() {
        for &v in &part.vertices {
            part_of[v as usize] = Some(number);
        }
    }
    let head = parts.len();
    parts.push(Region {
        name: "head".into(),
        vertices: Vec::new(),
    });
    for (v, part) in part_of.iter_mut().enumerate() {
        if skin.binary_search(&(v as u32)).is_err() {
            let region = &template.topology.region_names[template.topology.regions[v] as usize];
            *part = PARTS
                .iter()
                .position(|(_, names, _)| names.contains(&region.as_str()));
        }
    }
    parts.iter_mut().for_each(|part| part.vertices.clear());
    for (v, part) in part_of.iter().enumerate() {
        parts[part.unwrap_or(head)].vertices.push(v as u32);
    }
    Ok(parts)
}

/// How far each region's components reach: 0 in the region, rising smoothly to 1 at the end of the
/// band around it, and infinite beyond. One list a region, an entry for each of `vertices`.
pub(super) fn ramps(
    positions: &[DVec3],
    triangles: &[[u32; 3]],
    vertices: &[u32],
    regions: &[Region],
    band: f64,
) -> Vec<Vec<f64>> {
    let surface = Geodesic::new(positions, triangles);
    regions
        .iter()
        .map(|region| {
            let distance = surface.distances(&region.vertices, band);
            vertices
                .iter()
                .map(|&v| match distance[v as usize] / band {
                    t if t < 1.0 => t * t * (3.0 - 2.0 * t),
                    // A vertex that is exactly at the end of the band, or a band of no width.
                    t if t.is_nan() => 0.0,
                    _ => f64::INFINITY,
                })
                .collect()
        })
        .collect()
}

/// The support map of a component around a centre (Neumann et al. 2013, eq. 6): 0 within `near` mm
/// along the surface, 1 from `far` mm on, linear between. An entry for each of `vertices`.
pub(super) fn distance_map(
    surface: &Geodesic<'_>,
    vertices: &[u32],
    centre: u32,
    [near, far]: [f64; 2],
) -> Vec<f64> {
    let distance = surface.distances(&[centre], far);
    vertices
        .iter()
        .map(|&v| ((distance[v as usize].min(far) - near) / (far - near)).clamp(0.0, 1.0))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_parts_cover_the_face_and_are_their_own_mirror_images() {
        let Some(head) = crate::fit::test_head() else {
            return;
        };
        let parts = face_parts(head).unwrap();
        let names: Vec<&str> = parts.iter().map(|p| p.name.as_str()).collect();
        assert_eq!(names, ["eyes", "nose", "mouth", "forehead", "cheeks"]);
        let mut part_of = vec![None; head.positions.len()];
        for (number, part) in parts.iter().enumerate() {
            assert!(part.vertices.windows(2).all(|w| w[0] < w[1]));
            assert!(part.vertices.len() > 200, "{}", part.name);
            for &v in &part.vertices {
                assert_eq!(part_of[v as usize].replace(number), None);
            }
        }
        for (v, part) in part_of.iter().enumerate() {
            assert_eq!(*part, part_of[head.topology.mirror[v] as usize]);
        }
        // All features, and nothing of the ears.
        let skin = head.part_vertices("skin").unwrap();
        for v in skin {
            let region = &head.topology.region_names[head.topology.regions[v as usize] as usize];
            assert!(region == "head" || part_of[v as usize].is_some());
        }
        for name in ["tragion left", "vertex"] {
            let landmark = head.landmarks.iter().find(|l| l.name == name).unwrap();
            assert!(part_of[landmark.stencil[0].0 as usize].is_none(), "{name}");
        }
        let all = head_parts(head).unwrap();
        let count: usize = all.iter().map(|p| p.vertices.len()).sum();
        assert_eq!(count, head.positions.len());
        for (part, whole) in parts.iter().zip(&all) {
            assert!(
                part.vertices
                    .iter()
                    .all(|v| whole.vertices.binary_search(v).is_ok())
            );
        }
    }

    #[test]
    fn a_ramp_rises_through_its_band_and_no_farther() {
        // A strip of 1 mm steps; the region is its first five vertices.
        let positions: Vec<DVec3> = (0..40)
            .flat_map(|x| [0.0, 1.0].map(|y| DVec3::new(f64::from(x), y, 0.0)))
            .collect();
        let triangles: Vec<[u32; 3]> = (0..39)
            .flat_map(|x| {
                [
                    [2 * x, 2 * x + 2, 2 * x + 1],
                    [2 * x + 1, 2 * x + 2, 2 * x + 3],
                ]
            })
            .collect();
        let vertices: Vec<u32> = (0..80).collect();
        let region = Region {
            name: "start".into(),
            vertices: (0..10).collect(),
        };
        let ramps = ramps(&positions, &triangles, &vertices, &[region], 10.0);
        let along: Vec<f64> = ramps[0].iter().step_by(2).copied().collect();
        assert!(along[..5].iter().all(|&r| r == 0.0));
        assert!(along[4..14].windows(2).all(|w| w[0] < w[1]));
        // Distances take the nearest source for a point; from a straight border they are short by
        // up to a tenth.
        assert!((along[9] - 0.5).abs() < 0.1, "{}", along[9]);
        assert!(along[16..].iter().all(|&r| r == f64::INFINITY));
    }
}
