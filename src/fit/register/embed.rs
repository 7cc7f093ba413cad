//! The last step: vertices that have a point on the scan are set on it.

use glam::DVec3;

use super::correspondence::Correspondence;

/// Vertices less open than this stay where the sheet put them.
const OPEN: f64 = 0.2;

/// Two neighbouring triangles, or one before and after, that turn against each other by more than
/// this angle's cosine (60 degrees) were torn by the step.
const TURN: f64 = 0.5;

/// Rounds of giving way; a vertex that gives way takes its neighbours half the way with it.
const ROUNDS: usize = 12;

/// Sets vertices on their points, but for those where that would fold the surface: they and what
/// is around them keep their places, gradually.
pub fn embed(
    positions: &[DVec3],
    triangles: &[[u32; 3]],
    open: &[f64],
    found: &[Option<Correspondence>],
) -> Vec<DVec3> {
    let mut targets = positions.to_vec();
    let mut share = vec![0.0; positions.len()];
    for c in found.iter().flatten() {
        let v = c.vertex as usize;
        if open[v] >= OPEN {
            targets[v] = c.point;
            share[v] = 1.0;
        }
    }
    let facet = |p: &[DVec3], t: &[u32; 3]| {
        let [a, b, c] = t.map(|v| p[v as usize]);
        (b - a).cross(c - a).normalize_or_zero()
    };
    let before: Vec<DVec3> = triangles.iter().map(|t| facet(positions, t)).collect();
    let neighbours = neighbouring(triangles);
    let place = |share: &[f64]| -> Vec<DVec3> {
        (0..positions.len())
            .map(|v| {
                if share[v] == 1.0 {
                    targets[v]
                } else {
                    positions[v].lerp(targets[v], share[v])
                }
            })
            .collect()
    };
    for _ in 0..ROUNDS {
        let set = place(&share);
        let after: Vec<DVec3> = triangles.iter().map(|t| facet(&set, t)).collect();
        let mut torn: Vec<usize> = (0..triangles.len())
            .filter(|&t| after[t].dot(before[t]) < TURN)
            .collect();
        for &(a, b) in &neighbours {
            let (a, b) = (a as usize, b as usize);
            let (now, then) = (after[a].dot(after[b]), before[a].dot(before[b]));
            // What was sharp before may stay so; it must not become much sharper.
            if now < TURN && now < then - 0.3 {
                torn.extend([a, b]);
            }
        }
        if torn.is_empty() {
            return set;
        }
        let mut give = vec![false; positions.len()];
        for t in torn {
            triangles[t].iter().for_each(|&v| give[v as usize] = true);
        }
        let mut around = vec![false; positions.len()];
        for t in triangles
            .iter()
            .filter(|t| t.iter().any(|&v| give[v as usize]))
        {
            t.iter().for_each(|&v| around[v as usize] = true);
        }
        for v in 0..share.len() {
            if give[v] {
                share[v] *= 0.3;
            } else if around[v] {
                share[v] *= 0.8;
            }
        }
    }
    place(&share)
}

/// Pairs of triangles that share an edge.
fn neighbouring(triangles: &[[u32; 3]]) -> Vec<(u32, u32)> {
    let mut edges: Vec<(u32, u32, u32)> = (0..)
        .zip(triangles)
        .flat_map(|(t, &[a, b, c])| [(a, b, t), (b, c, t), (c, a, t)])
        .map(|(a, b, t)| (a.min(b), a.max(b), t))
        .collect();
    edges.sort_unstable();
    edges
        .chunk_by(|a, b| (a.0, a.1) == (b.0, b.1))
        .filter(|run| run.len() == 2)
        .map(|run| (run[0].2, run[1].2))
        .collect()
}
