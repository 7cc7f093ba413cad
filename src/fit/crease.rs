//! The crease measure: how sharply a deformation bends the surface where a region ends.

use glam::DVec3;

use super::geodesic::Geodesic;
use super::surround::border;

/// The edges of the band around a region's border, on the skin.
pub struct BorderBand {
    /// `[edge start, edge end, apex, other apex]`.
    hinges: Vec<[u32; 4]>,
    rest: Vec<f64>,
}

impl BorderBand {
    /// The edges with both ends within `width` mm (along the surface) of the border of the region
    /// `inside`, of the triangles given. `rest` is the face from which changes are measured.
    pub fn new(
        rest: &[DVec3],
        triangles: &[[u32; 3]],
        graph: &Geodesic,
        inside: &[bool],
        width: f64,
    ) -> Self {
        let near = graph.distances(&border(triangles, inside), width);
        let mut across = std::collections::BTreeMap::new();
        let mut hinges = Vec::new();
        for triangle in triangles {
            for corner in 0..3 {
                let [apex, a, b] = [0, 1, 2].map(|i| triangle[(corner + i) % 3]);
                // The neighbour sees the edge the other way round.
                if let Some(other) = across.remove(&(b, a)) {
                    if near[a as usize].is_finite() && near[b as usize].is_finite() {
                        hinges.push([a, b, apex, other]);
                    }
                } else {
                    across.insert((a, b), apex);
                }
            }
        }
        let mut band = Self {
            hinges,
            rest: Vec::new(),
        };
        band.rest = band
            .hinges
            .iter()
            .map(|&hinge| dihedral(rest, hinge))
            .collect();
        band
    }

    /// How many edges there are.
    pub fn edges(&self) -> usize {
        self.hinges.len()
    }

    /// The largest change of a dihedral angle in the band, degrees, and the edge it is at.
    pub fn largest_change(&self, face: &[DVec3]) -> (f64, [u32; 2]) {
        let mut largest = (0.0, [0, 0]);
        for (&hinge, rest) in self.hinges.iter().zip(&self.rest) {
            let change = (dihedral(face, hinge) - rest).abs();
            let change = change.min(std::f64::consts::TAU - change).to_degrees();
            if change > largest.0 {
                largest = (change, [hinge[0], hinge[1]]);
            }
        }
        largest
    }
}

/// The signed angle between the normals of the two triangles on an edge, radians; 0 when flat.
fn dihedral(positions: &[DVec3], [a, b, apex, other]: [u32; 4]) -> f64 {
    let [a, b, apex, other] = [a, b, apex, other].map(|v| positions[v as usize]);
    let edge = b - a;
    let one = edge.cross(apex - a);
    let two = (other - a).cross(edge);
    f64::atan2(one.cross(two).dot(edge) / edge.length(), one.dot(two))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_fold_of_thirty_degrees_is_thirty_degrees() {
        let flat = [[0., 0., 0.], [0., 1., 0.], [-1., 0., 0.], [1., 0., 0.]].map(DVec3::from_array);
        let mut folded = flat;
        folded[3] = DVec3::new(30_f64.to_radians().cos(), 0.0, 30_f64.to_radians().sin());
        let hinge = [0, 1, 2, 3];
        assert!(dihedral(&flat, hinge).abs() < 1e-12);
        assert!((dihedral(&folded, hinge).abs().to_degrees() - 30.0).abs() < 1e-9);
    }
}
