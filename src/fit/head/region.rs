//! Divides the generic head into facial features.
//!
//! Each feature has lines drawn between landmarks and a reach in mm. A vertex of the skin belongs
//! to the feature whose lines are nearest along the surface, measured in reaches, if that is
//! below 1; what is left is `head`. Borders are therefore curves at a constant distance from a
//! feature, and where two features meet they meet halfway. Reaches are chosen so that a border
//! runs where the face is smooth: beyond the crease of the nose's wing, below the sulcus under
//! the lower lip, above the brow.

use std::collections::BTreeMap;

use glam::DVec3;

use super::generic_head::{closest, mirror_name};
use super::template::Template;
use crate::fit::mesh::geodesic::{Geodesic, largest_component};
use crate::fit::{FitError, FitResult};

/// The regions, in the order in which vertices are numbered.
pub const NAMES: [&str; 7] = [
    "left eye",
    "right eye",
    "nose",
    "mouth",
    "chin",
    "forehead",
    "head",
];

/// A feature: its region, its lines through landmarks, the share of each piece of a line that is
/// left out at its start, and its reach in mm. Lines of the left eye are mirrored for the right
/// one; those of the forehead start above the brows.
const FEATURES: [(&str, &[&[&str]], f64, f64); 5] = [
    (
        "left eye",
        &[
            &["ibug_22", "ibug_23", "ibug_24", "ibug_25", "ibug_26"],
            &[
                "ibug_42", "ibug_43", "ibug_44", "ibug_45", "ibug_46", "ibug_47", "ibug_42",
            ],
            &["ibug_22", "ibug_42"],
            &["ibug_23", "ibug_43"],
            &["ibug_25", "ibug_44"],
            &["ibug_26", "ibug_45"],
            &["ibug_23", "ibug_44"],
            &["ibug_24", "ibug_43"],
            &["ibug_24", "ibug_45"],
        ],
        0.0,
        11.0,
    ),
    (
        "nose",
        &[
            &["ibug_27", "ibug_28", "ibug_29", "ibug_30", "ibug_33"],
            &[
                "alare right",
                "ibug_31",
                "ibug_32",
                "ibug_33",
                "ibug_34",
                "ibug_35",
                "alare left",
            ],
            &["ibug_28", "alare left"],
            &["ibug_28", "alare right"],
            &["ibug_30", "alare left"],
            &["ibug_30", "alare right"],
        ],
        0.0,
        11.0,
    ),
    (
        "mouth",
        &[
            &[
                "ibug_48", "ibug_49", "ibug_50", "ibug_51", "ibug_52", "ibug_53", "ibug_54",
                "ibug_55", "ibug_56", "ibug_57", "ibug_58", "ibug_59", "ibug_48",
            ],
            &["ibug_60", "ibug_61", "ibug_62", "ibug_63", "ibug_64"],
            &["ibug_64", "ibug_65", "ibug_66", "ibug_67", "ibug_60"],
        ],
        0.0,
        13.0,
    ),
    (
        "chin",
        &[
            &["supramentale", "pogonion", "ibug_08"],
            &["ibug_06", "ibug_07", "ibug_08", "ibug_09", "ibug_10"],
            &["ibug_07", "pogonion", "ibug_09"],
        ],
        0.0,
        22.0,
    ),
    (
        "forehead",
        &[
            &["glabella", "glabella"],
            &["glabella", "trichion"],
            &["ibug_18", "trichion", "ibug_25"],
            &["ibug_19", "trichion", "ibug_24"],
        ],
        0.4,
        24.0,
    ),
];

/// Steps along a line between two landmarks.
const STEPS: usize = 16;

/// Gives each vertex its region; cavities and eyeballs go with their feature.
pub fn assign(template: &mut Template) -> FitResult<()> {
    let triangles = &template.part_triangles("skin")?;
    let index = |name: &str| {
        NAMES
            .iter()
            .position(|n| *n == name)
            .unwrap_or(NAMES.len() - 1)
    };
    let head = index("head");
    let surface = Geodesic::new(&template.positions, triangles);
    let mut score = vec![vec![f64::INFINITY; template.positions.len()]; NAMES.len()];
    score[head].fill(1.0);
    for (name, lines, skipped, reach) in FEATURES {
        let mut sources = Vec::new();
        for line in lines {
            for ends in line.windows(2) {
                let (a, b) = (point(template, ends[0])?, point(template, ends[1])?);
                for step in 0..=STEPS {
                    let along = skipped + (1.0 - skipped) * step as f64 / STEPS as f64;
                    let p = a.lerp(b, along);
                    let on = closest(&template.positions, triangles, p);
                    let foot: DVec3 = on
                        .iter()
                        .map(|&(v, w)| template.positions[v as usize] * w)
                        .sum();
                    let near =
                        |&(v, _): &(u32, f64)| (v, template.positions[v as usize].distance(foot));
                    sources.extend(on.iter().map(near));
                }
            }
        }
        // Both sides alike: a source counts for its mirror image too, but for a paired feature,
        // which is mirrored as a whole.
        let paired = name == "left eye";
        if !paired {
            let images: Vec<_> = sources
                .iter()
                .map(|&(v, d)| (template.topology.mirror[v as usize], d))
                .collect();
            sources.extend(images);
        }
        let distance = surface.distances_from(&sources, f64::INFINITY);
        for (vertex, d) in distance.iter().enumerate() {
            score[index(name)][vertex] = d / reach;
            if paired {
                let image = template.topology.mirror[vertex] as usize;
                score[index("right eye")][image] = d / reach;
            }
        }
    }
    let mut regions: Vec<u8> = (0..template.positions.len())
        .map(|v| {
            let nearest = (0..NAMES.len()).min_by(|&a, &b| score[a][v].total_cmp(&score[b][v]));
            nearest.unwrap_or(head) as u8
        })
        .collect();
    join_islands(triangles, &mut regions);
    // A vertex on the midline may be as near to the left as to the right.
    let eye = index("left eye") as u8;
    for (vertex, region) in regions.iter_mut().enumerate() {
        if template.topology.mirror[vertex] as usize == vertex && *region == eye {
            *region = head as u8;
        }
    }

    let mut on_skin = vec![false; regions.len()];
    for &vertex in triangles.as_flattened() {
        on_skin[vertex as usize] = true;
    }
    for part in &template.topology.parts[1..] {
        for vertex in template.part_vertices(&part.name)? {
            let vertex = vertex as usize;
            if !on_skin[vertex] {
                regions[vertex] = index(match part.name.as_str() {
                    "mouth cavity" => "mouth",
                    _ if template.positions[vertex].x > 0.0 => "left eye",
                    _ => "right eye",
                }) as u8;
            }
        }
    }
    template.topology.region_names = NAMES.map(String::from).to_vec();
    template.topology.regions = regions;
    Ok(())
}

/// Makes each region one piece: a vertex outside its region's largest component takes the region
/// that most of its settled neighbours have.
fn join_islands(triangles: &[[u32; 3]], regions: &mut [u8]) {
    let mut settled = vec![false; regions.len()];
    for region in 0..NAMES.len() as u8 {
        let inside: Vec<bool> = regions.iter().map(|&r| r == region).collect();
        for (vertex, kept) in largest_component(triangles, &inside)
            .into_iter()
            .enumerate()
        {
            settled[vertex] |= kept;
        }
    }
    loop {
        let mut votes: BTreeMap<u32, [usize; NAMES.len()]> = BTreeMap::new();
        for t in triangles {
            for (from, to) in [(0, 1), (1, 2), (2, 0), (1, 0), (2, 1), (0, 2)] {
                let (from, to) = (t[from] as usize, t[to]);
                if settled[from] && !settled[to as usize] {
                    votes.entry(to).or_default()[regions[from] as usize] += 1;
                }
            }
        }
        if votes.is_empty() {
            return;
        }
        for (vertex, votes) in votes {
            let most = (0..NAMES.len()).max_by_key(|&r| votes[r]);
            regions[vertex as usize] = most.unwrap_or(NAMES.len() - 1) as u8;
            settled[vertex as usize] = true;
        }
    }
}

/// The region that a region's mirror image is.
pub fn mirror_region(name: &str) -> String {
    match name.split_once(' ') {
        Some(("left", rest)) => format!("right {rest}"),
        Some(("right", rest)) => format!("left {rest}"),
        _ => mirror_name(name),
    }
}

/// A landmark's place in the rest pose.
pub fn point(template: &Template, name: &str) -> FitResult<DVec3> {
    let index = template.landmarks.iter().position(|l| l.name == name);
    let index = index.ok_or_else(|| FitError::Input(format!("no landmark {name}")))?;
    Ok(template.landmark(index, &template.positions))
}
