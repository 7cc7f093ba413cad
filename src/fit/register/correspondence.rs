//! Which point of the scan a vertex of the template belongs to, and when to none.

use glam::DVec3;

use crate::fit::mesh::surface::Surface;

/// A vertex and its point on the scan.
#[derive(Debug, Clone, Copy)]
pub struct Correspondence {
    /// The template's vertex.
    pub vertex: u32,
    /// Its point on the scan, mm.
    pub point: DVec3,
    /// The scan's unit normal there.
    pub normal: DVec3,
    /// Its distance, mm.
    pub distance: f64,
}

/// What a correspondence must fulfil.
#[derive(Debug, Clone, Copy)]
pub struct Admission {
    /// The farthest point, mm.
    pub reach: f64,
    /// The least cosine between the normals of template and scan.
    pub cosine: f64,
}

/// The closest point of the scan for each of some vertices; none where it is too far, faces
/// another way, or lies on the scan's border (where a hole begins: the true point may be missing).
///
/// Only triangles that face the vertex's way are looked at, so that a lip does not find the other.
pub fn correspond(
    scan: &Surface<'_>,
    positions: &[DVec3],
    normals: &[DVec3],
    vertices: &[u32],
    admission: &Admission,
) -> Vec<Option<Correspondence>> {
    vertices
        .iter()
        .map(|&vertex| {
            let (p, n) = (positions[vertex as usize], normals[vertex as usize]);
            let hit =
                scan.closest_where(p, admission.reach, |t| scan.facets[t as usize].dot(n) > 0.0)?;
            let normal = scan.normal(&hit);
            let admitted = normal.dot(n) >= admission.cosine && !scan.on_border(&hit);
            admitted.then_some(Correspondence {
                vertex,
                point: hit.point,
                normal,
                distance: hit.distance,
            })
        })
        .collect()
}
