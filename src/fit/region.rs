//! Divides the generic head into facial features.

use super::FitResult;
use super::base_mesh::BaseMesh;
use super::template::Template;

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

/// Gives each vertex its region.
pub fn assign(template: &mut Template, _base: &BaseMesh) -> FitResult<()> {
    template.region_names = NAMES.map(String::from).to_vec();
    let anchors: Vec<(u8, glam::DVec3, f64)> = (0..template.landmarks.len())
        .filter_map(|i| {
            let l = &template.landmarks[i];
            let p = template.landmark(i, &template.positions);
            let n: u32 = l
                .name
                .strip_prefix("ibug_")
                .and_then(|n| n.parse().ok())
                .unwrap_or(99);
            let r = match n {
                17..=21 | 36..=41 => 1,
                22..=26 | 42..=47 => 0,
                27..=35 => 2,
                48..=67 => 3,
                6..=10 => 4,
                _ => match l.name.as_str() {
                    "pogonion" | "supramentale" => 4,
                    "alare left" | "alare right" => 2,
                    "trichion" | "glabella" => 5,
                    _ => return None,
                },
            };
            Some((r, p, if r == 5 { 45.0 } else { 18.0 }))
        })
        .collect();
    template.regions = template
        .positions
        .iter()
        .map(|p| {
            anchors
                .iter()
                .map(|a| (a.0, a.1.distance(*p), a.2))
                .filter(|a| a.1 < a.2)
                .min_by(|a, b| a.1.total_cmp(&b.1))
                .map_or(6, |a| a.0)
        })
        .collect();
    Ok(())
}
