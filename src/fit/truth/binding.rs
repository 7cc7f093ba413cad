//! Where on ICT's skin each vertex of the template belongs: the truth of a registration.

use glam::DVec3;
use rayon::prelude::*;

use crate::fit::FitResult;
use crate::fit::head::template::Template;
use crate::fit::mesh::resample::SurfacePoint;
use crate::fit::mesh::surface::Surface;
use crate::fit::mesh::surface::normals;
use crate::fit::truth::ict::{Ict, NARROW_FACE};

/// How far a vertex of the reference may be off ICT's mean and still be held to a spot of it, mm.
/// Beyond this the closest point is an accident.
const NEAR: f64 = 1.0;

/// The least cosine between the normals of a bound vertex and of its spot: the two lips face each
/// other across less than [`NEAR`].
const FACING: f64 = 0.5;

/// The template's skin bound to ICT's mean head, and through ICT's topology to every person.
#[derive(Debug, Clone)]
pub struct Binding {
    /// The vertices of the template's skin, increasing; what follows has one entry a vertex.
    pub vertices: Vec<u32>,
    /// The spot on ICT's mean that is closest to the vertex.
    pub spots: Vec<SurfacePoint>,
    /// Whether the spot is the vertex's own: near it, facing the same way, and not the end of
    /// ICT's skin. The inner lips, the back of the lids and whatever the reference does not reach
    /// have none.
    pub bound: Vec<bool>,
    /// Whether the spot is in the face area, which is what ICT calls the narrow face: from the
    /// hairline to the throat and to before the ears.
    pub face: Vec<bool>,
}

impl Binding {
    /// Binds a template whose skin, moved to `reference` (all vertices, mm, in ICT's pose), is
    /// ICT's mean head.
    ///
    /// # Errors
    /// When the template has no skin.
    pub fn new(template: &Template, reference: &[DVec3], ict: &Ict) -> FitResult<Self> {
        let vertices = template.part_vertices("skin")?;
        let facing = normals(reference, &template.part_triangles("skin")?);
        let mean = Surface::new(&ict.neutral, &ict.triangles);
        let found: Vec<_> = vertices
            .par_iter()
            .map(|&v| {
                let (p, normal) = (reference[v as usize], facing[v as usize]);
                let nearest = mean.closest(p, f64::INFINITY);
                let facing_alike = |t: u32| mean.facets[t as usize].dot(normal) > FACING;
                let own = mean.closest_where(p, NEAR, facing_alike);
                let hit = own.or(nearest);
                let spot = hit.map_or(
                    SurfacePoint {
                        triangle: 0,
                        weights: [1.0, 0.0, 0.0],
                    },
                    |hit| SurfacePoint {
                        triangle: hit.triangle,
                        weights: hit.weights,
                    },
                );
                let beyond = hit.is_none_or(|hit| mean.on_border(&hit));
                let face = ict.triangles[spot.triangle as usize]
                    .iter()
                    .all(|&v| v < NARROW_FACE);
                (spot, own.is_some() && !beyond, face)
            })
            .collect();
        Ok(Self {
            vertices,
            spots: found.iter().map(|f| f.0).collect(),
            bound: found.iter().map(|f| f.1).collect(),
            face: found.iter().map(|f| f.2).collect(),
        })
    }

    /// Where each of the [`Binding::vertices`] belongs on a person with these ICT vertices.
    pub fn truth(&self, person: &[DVec3], ict: &Ict) -> Vec<DVec3> {
        self.spots
            .iter()
            .map(|spot| spot.on(person, &ict.triangles))
            .collect()
    }
}
