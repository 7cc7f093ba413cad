//! Polygons into triangles.

use glam::{DVec2, DVec3};

/// Cuts a polygon into triangles, as indices of its corners, with its own orientation.
///
/// Ears are cut off in the polygon's mean plane, so concave corners stay outside; a quadrilateral
/// is split along its shorter diagonal where both lie inside. Fewer than three corners give none.
pub(super) fn triangulate(points: &[DVec3]) -> Vec<[usize; 3]> {
    match points.len() {
        0..=2 => return Vec::new(),
        3 => return vec![[0, 1, 2]],
        _ => {}
    }
    // Newell's normal: the area vector, whatever the shape.
    let normal = (0..points.len())
        .map(|i| points[i].cross(points[(i + 1) % points.len()]))
        .sum::<DVec3>()
        .normalize_or(DVec3::Z);
    let across = normal.any_orthonormal_vector();
    let up = normal.cross(across);
    let flat: Vec<DVec2> = points
        .iter()
        .map(|&p| DVec2::new((p - points[0]).dot(across), (p - points[0]).dot(up)))
        .collect();
    let mut left: Vec<usize> = (0..points.len()).collect();
    let mut triangles = Vec::with_capacity(points.len() - 2);
    while left.len() > 3 {
        let n = left.len();
        let ear = |i: usize| [left[(i + n - 1) % n], left[i], left[(i + 1) % n]];
        let turn = |[a, b, c]: [usize; 3]| (flat[b] - flat[a]).perp_dot(flat[c] - flat[b]);
        let inside = |[a, b, c]: [usize; 3]| {
            left.iter().any(|&p| {
                p != a
                    && p != b
                    && p != c
                    && turn([a, b, p]) >= 0.0
                    && turn([b, c, p]) >= 0.0
                    && turn([c, a, p]) >= 0.0
            })
        };
        let cut = |t: [usize; 3]| points[t[0]].distance_squared(points[t[2]]);
        let best = (0..n)
            .filter(|&i| turn(ear(i)) > 0.0 && !inside(ear(i)))
            .min_by(|&i, &j| cut(ear(i)).total_cmp(&cut(ear(j))))
            // A polygon that crosses itself or has no area has no ear; any cut is as good.
            .unwrap_or(1);
        triangles.push(ear(best));
        left.remove(best);
    }
    triangles.push([left[0], left[1], left[2]]);
    triangles
}

#[cfg(test)]
mod tests {
    use super::*;

    fn area(points: &[DVec3], triangles: &[[usize; 3]]) -> f64 {
        triangles
            .iter()
            .map(|t| {
                let [a, b, c] = t.map(|i| points[i]);
                (b - a).cross(c - a).z / 2.0
            })
            .sum()
    }

    #[test]
    fn a_concave_polygon_keeps_its_area_with_no_triangle_turned() {
        // An arrow head, from each of its corners, and a comb.
        let arrow = [(0.0, 0.0), (4.0, -3.0), (1.0, 0.0), (4.0, 3.0)];
        let comb = [
            (0.0, 0.0),
            (5.0, 0.0),
            (5.0, 3.0),
            (4.0, 1.0),
            (3.0, 3.0),
            (2.0, 1.0),
            (1.0, 3.0),
        ];
        for (shape, expected) in [(&arrow[..], 3.0), (&comb[..], 9.5)] {
            for start in 0..shape.len() {
                let points: Vec<DVec3> = (0..shape.len())
                    .map(|i| shape[(start + i) % shape.len()])
                    .map(|(x, y)| DVec3::new(x, y, 0.0))
                    .collect();
                let triangles = triangulate(&points);
                assert_eq!(triangles.len(), points.len() - 2);
                assert!(
                    (area(&points, &triangles) - expected).abs() < 1e-12,
                    "{shape:?}"
                );
                assert!(triangles.iter().all(|&t| area(&points, &[t]) >= 0.0));
            }
        }
    }
}
