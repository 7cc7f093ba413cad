//! Weights of edges by which the Laplacian of a mesh is that of its surface.

use glam::DVec3;

/// Cotangent weights of the edges of a mesh: `(vertex, vertex, weight)` with the first smaller.
///
/// Negative ones, of obtuse triangles, are cut off at a hundredth: the smoothing must not
/// amplify anything.
pub fn cotangent_edges(positions: &[DVec3], triangles: &[[u32; 3]]) -> Vec<(u32, u32, f64)> {
    let mut edges = std::collections::BTreeMap::new();
    for triangle in triangles {
        for corner in 0..3 {
            let [apex, a, b] = [0, 1, 2].map(|i| triangle[(corner + i) % 3]);
            let (u, v) = (
                positions[a as usize] - positions[apex as usize],
                positions[b as usize] - positions[apex as usize],
            );
            // Half the cotangent of the angle opposite of the edge, from each side of it.
            let cotangent = 0.5 * u.dot(v) / u.cross(v).length().max(1e-12);
            *edges.entry((a.min(b), a.max(b))).or_insert(0.0) += cotangent;
        }
    }
    edges
        .into_iter()
        .map(|((a, b), w)| (a, b, f64::max(w, 0.01)))
        .collect()
}
