//! Faces in a mirror: x is to the subject's left, and a `mirror` map names the vertex on the other side of each.

use glam::DVec3;

/// The mirror image of a point.
pub fn flip(point: DVec3) -> DVec3 {
    DVec3::new(-point.x, point.y, point.z)
}

/// The mirror image of a face, or of a field over one.
pub fn mirrored(face: &[DVec3], mirror: &[u32]) -> Vec<DVec3> {
    mirror.iter().map(|&v| flip(face[v as usize])).collect()
}

/// The faces, followed by the mirror image of each. What is learned from both knows no side: with each of its
/// directions the mirror image is in its span.
pub fn with_mirror_images(faces: &[Vec<DVec3>], mirror: &[u32]) -> Vec<Vec<DVec3>> {
    let images = faces.iter().map(|face| mirrored(face, mirror));
    faces.iter().cloned().chain(images).collect()
}

/// The part of a face, or of a field over one, that is the same on both sides.
pub fn even(face: &[DVec3], mirror: &[u32]) -> Vec<DVec3> {
    let both = face.iter().zip(mirrored(face, mirror));
    both.map(|(p, image)| (*p + image) / 2.0).collect()
}

/// The mirror map among some `vertices` (increasing): where in them the image of each is. None when one has
/// its image outside.
pub fn among(vertices: &[u32], mirror: &[u32]) -> Option<Vec<u32>> {
    let image = |&v: &u32| vertices.binary_search(&mirror[v as usize]).ok();
    vertices
        .iter()
        .map(|v| image(v).map(|at| at as u32))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn mirror_images_are_on_the_other_side() {
        let face = vec![DVec3::new(1.0, 2.0, 3.0), DVec3::new(-4.0, 5.0, 6.0)];
        let both = with_mirror_images(std::slice::from_ref(&face), &[1, 0]);
        assert_eq!(both[0], face);
        let image = [DVec3::new(4.0, 5.0, 6.0), DVec3::new(-1.0, 2.0, 3.0)];
        assert_eq!(both[1], image);
        let even = even(&face, &[1, 0]);
        assert_eq!(mirrored(&even, &[1, 0]), even);
        assert_eq!(even[0], (face[0] + image[0]) / 2.0);
    }

    #[test]
    fn some_vertices_have_a_mirror_map_of_their_own() {
        let mirror = [1, 0, 2, 4, 3];
        assert_eq!(among(&[0, 1, 2], &mirror), Some(vec![1, 0, 2]));
        assert_eq!(among(&[2, 3, 4], &mirror), Some(vec![0, 2, 1]));
        assert_eq!(among(&[0, 2], &mirror), None);
    }
}
