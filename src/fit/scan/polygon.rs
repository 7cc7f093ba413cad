//! Polygons into triangles.

use glam::{DVec2, DVec3};

/// Polygons of more corners than this are cut as fast as may be: each step then looks anew only at the two
/// corners beside the one that goes. Of a polygon that does not touch itself no other one can change.
const FEW: usize = 64;

/// Polygons of more corners than this are no faces of a scan, and fans of triangles from their first corner.
const MOST: usize = 10_000;

/// Cuts a polygon into triangles, as indices of its corners, with its own orientation.
///
/// Ears are cut off in the polygon's mean plane, so concave corners stay outside; a quadrilateral
/// is split along its shorter diagonal where both lie inside. Fewer than three corners give none.
pub(super) fn triangulate(points: &[DVec3]) -> Vec<[usize; 3]> {
    match points.len() {
        0..=2 => return Vec::new(),
        3 => return vec![[0, 1, 2]],
        n if n > MOST => return (2..n).map(|i| [0, i - 1, i]).collect(),
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
    // What each corner would be cut off with, squared, where that leaves an ear.
    let mut cuts: Vec<f64> = (0..points.len())
        .map(|i| cut(points, &flat, &left, i))
        .collect();
    let mut triangles = Vec::with_capacity(points.len() - 2);
    while left.len() > 3 {
        let best = (0..left.len())
            .filter(|&i| cuts[i].is_finite())
            .min_by(|&i, &j| cuts[i].total_cmp(&cuts[j]))
            // A polygon that crosses itself or has no area has no ear; any cut is as good.
            .unwrap_or(1);
        triangles.push(corners(&left, best));
        left.remove(best);
        cuts.remove(best);
        let n = left.len();
        if n == 3 {
            break;
        }
        let anew = |i: usize| cuts[i] = cut(points, &flat, &left, i);
        match points.len() <= FEW {
            true => (0..n).for_each(anew),
            false => [(best + n - 1) % n, best % n].into_iter().for_each(anew),
        }
    }
    triangles.push([left[0], left[1], left[2]]);
    triangles
}

/// A corner of what is left of a polygon, between its neighbours.
fn corners(left: &[usize], i: usize) -> [usize; 3] {
    let n = left.len();
    [left[(i + n - 1) % n], left[i], left[(i + 1) % n]]
}

/// The square of the length of the edge that cuts a corner off; infinite where it is concave or others lie
/// in it.
fn cut(points: &[DVec3], flat: &[DVec2], left: &[usize], i: usize) -> f64 {
    let turn = |[a, b, c]: [usize; 3]| (flat[b] - flat[a]).perp_dot(flat[c] - flat[b]);
    let ear @ [a, b, c] = corners(left, i);
    let [low, high] = [
        flat[a].min(flat[b]).min(flat[c]),
        flat[a].max(flat[b]).max(flat[c]),
    ];
    let inside = |&p: &usize| {
        // Nearly all are far away.
        flat[p].cmpge(low).all()
            && flat[p].cmple(high).all()
            && p != a
            && p != b
            && p != c
            && turn([a, b, p]) >= 0.0
            && turn([b, c, p]) >= 0.0
            && turn([c, a, p]) >= 0.0
    };
    match turn(ear) > 0.0 && !left.iter().any(inside) {
        true => points[a].distance_squared(points[c]),
        false => f64::INFINITY,
    }
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
    #[test]
    fn a_polygon_of_thousands_of_corners_is_cut_at_once() {
        // A gear, whose every other corner is concave, and one that is too large to be one.
        let gear = |n: usize| -> Vec<DVec3> {
            let corner = |i: usize| {
                let (sine, cosine) = (i as f64 / n as f64 * std::f64::consts::TAU).sin_cos();
                DVec3::new(cosine, sine, 0.0) * [100.0, 90.0][i % 2]
            };
            (0..n).map(corner).collect()
        };
        let points = gear(5000);
        let expected = 2500.0 * 100.0 * 90.0 * (std::f64::consts::TAU / 5000.0).sin();
        let started = std::time::Instant::now();
        let triangles = triangulate(&points);
        let seconds = started.elapsed().as_secs_f64();
        println!("{seconds:.3} s");
        // Where each corner is looked at in each step it is hundreds of times the work.
        assert!(seconds < 5.0, "{seconds} s");
        assert_eq!(triangles.len(), 4998);
        assert!(triangles.iter().all(|&t| area(&points, &[t]) >= 0.0));
        let found = area(&points, &triangles);
        assert!((found / expected - 1.0).abs() < 1e-9, "{found} {expected}");
        assert_eq!(triangulate(&gear(1_000_000)).len(), 999_998);
    }
}
