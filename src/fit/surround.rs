//! What follows a region, and how (region morphing, section 6.2, eqs. 11 and 12).

use std::collections::BTreeMap;

use glam::DVec3;
use rayon::prelude::*;

use super::geodesic::Geodesic;
use crate::model::{Surround, falloff};

/// How many sources a vertex follows. The sharpest crease at the border of nose and forehead, as
/// a multiple of a whole-face PCA's (`tests/learning.rs`): 2.7 and 2.1 with the single nearest of
/// eq. 11, 1.9 and 1.9 with 4, 0.7 and 1.1 with 8, 0.7 and 0.6 with 12, which cost half as many
/// bytes again.
const SOURCES: usize = 8;

/// The vertices of a region with a neighbour outside of it.
pub fn border(triangles: &[[u32; 3]], inside: &[bool]) -> Vec<u32> {
    let mut on_border = vec![false; inside.len()];
    for triangle in triangles {
        if triangle.iter().any(|&v| !inside[v as usize]) {
            triangle
                .iter()
                .filter(|&&v| inside[v as usize])
                .for_each(|&v| on_border[v as usize] = true);
        }
    }
    (0..inside.len() as u32)
        .filter(|&v| on_border[v as usize])
        .collect()
}

/// Builds the surround of a region.
///
/// `support` are the region's vertices (increasing); `loose` are sets of vertices that hang
/// together with nothing by triangles (eyeballs), each with the vertices (lids) that it follows as
/// a whole. Vertices farther than `reach` mm along the surface do not follow.
pub fn build(
    graph: &Geodesic<'_>,
    triangles: &[[u32; 3]],
    vertices: usize,
    support: &[u32],
    loose: &[(Vec<u32>, Vec<u32>)],
    reach: f64,
) -> Surround {
    let mut inside = vec![false; vertices];
    support.iter().for_each(|&v| inside[v as usize] = true);
    let border = border(triangles, &inside);
    let nearest = graph.distances(&border, reach);
    // Farther than the nearest source there must be enough others to blend with.
    let from_each: Vec<Vec<f64>> = border
        .par_iter()
        .map(|&source| graph.distances(&[source], reach + 30.0))
        .collect();
    let mut rows: BTreeMap<u32, (f64, Vec<(u32, f64)>)> = BTreeMap::new();
    for v in (0..vertices).filter(|&v| !inside[v] && nearest[v].is_finite()) {
        let mut sources: Vec<(u32, f64)> = border
            .iter()
            .zip(&from_each)
            .filter(|(_, distances)| distances[v].is_finite())
            .map(|(&source, distances)| (source, distances[v]))
            .collect();
        sources.sort_by(|a, b| a.1.total_cmp(&b.1).then(a.0.cmp(&b.0)));
        rows.insert(v as u32, (nearest[v], vanishing_weights(&sources)));
    }
    for (members, leaders) in loose {
        let led: Vec<_> = leaders
            .iter()
            .filter_map(|leader| rows.get(leader))
            .collect();
        // Leaders inside the region carry the loose part with it by its own modes.
        if led.is_empty() || members.iter().any(|&m| inside[m as usize]) {
            continue;
        }
        let distance = led.iter().map(|row| row.0).sum::<f64>() / led.len() as f64;
        let mut sum: BTreeMap<u32, f64> = BTreeMap::new();
        for (source, weight) in led.iter().flat_map(|row| &row.1) {
            *sum.entry(*source).or_default() += weight;
        }
        let mut sources: Vec<(u32, f64)> = sum.into_iter().collect();
        sources.sort_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
        sources.truncate(SOURCES);
        members.iter().for_each(|&m| {
            rows.insert(m, (distance, sources.clone()));
        });
    }
    pack(rows, support)
}

/// Weights of the nearest sources that sink to zero where a source drops out of the set, so that
/// neighbours with other sets agree (the modified Shepard weights of Renka 1988).
fn vanishing_weights(sources: &[(u32, f64)]) -> Vec<(u32, f64)> {
    let horizon = match sources.get(SOURCES) {
        Some(&(_, next)) => next,
        None => sources.last().map_or(1.0, |s| s.1) * 1.2,
    };
    sources
        .iter()
        .take(SOURCES)
        .map(|&(source, distance)| {
            let distance = distance.max(1e-6);
            (
                source,
                (1.0 / distance - 1.0 / horizon).max(0.0).powi(2) + 1e-12,
            )
        })
        .collect()
}

/// Rows as the model keeps them: weights in units of 1/65535 that sum to one.
fn pack(rows: BTreeMap<u32, (f64, Vec<(u32, f64)>)>, support: &[u32]) -> Surround {
    let mut surround = Surround {
        targets: Vec::new(),
        distances: Vec::new(),
        sources_each: SOURCES,
        sources: Vec::new(),
        weights: Vec::new(),
    };
    for (target, (distance, sources)) in rows {
        let total: f64 = sources.iter().map(|s| s.1).sum();
        let mut weights: Vec<u16> = sources
            .iter()
            .map(|s| (s.1 / total * 65_535.0).floor() as u16)
            .collect();
        let missing = 65_535 - weights.iter().map(|&w| u32::from(w)).sum::<u32>();
        let largest = (0..weights.len()).max_by_key(|&i| weights[i]).unwrap_or(0);
        weights[largest] += missing as u16;
        weights.resize(SOURCES, 0);
        surround.targets.push(target);
        surround.distances.push(distance as f32);
        surround.weights.extend(weights);
        let slots = sources
            .iter()
            .map(|s| support.partition_point(|&v| v < s.0) as u32);
        surround
            .sources
            .extend(slots.chain(std::iter::repeat(0)).take(SOURCES));
    }
    surround
}

/// A displacement field of the support (x, y, z a vertex) spread over the whole mesh.
pub fn spread(
    field: &[f64],
    support: &[u32],
    surround: &Surround,
    alpha: f32,
    vertices: usize,
) -> Vec<DVec3> {
    let mut whole = vec![DVec3::ZERO; vertices];
    let own: Vec<DVec3> = field.chunks_exact(3).map(DVec3::from_slice).collect();
    support
        .iter()
        .zip(&own)
        .for_each(|(&v, &d)| whole[v as usize] = d);
    let each = surround.sources_each;
    for (t, &target) in surround.targets.iter().enumerate() {
        let pulled: DVec3 = (t * each..(t + 1) * each)
            .map(|i| own[surround.sources[i] as usize] * f64::from(surround.weights[i]))
            .sum();
        let fade = f64::from(falloff(surround.distances[t] / alpha));
        whole[target as usize] = pulled * (fade / 65_535.0);
    }
    whole
}
