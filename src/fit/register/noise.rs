//! How noisy a scan is, and what is left when the noise is taken off.

use glam::DVec3;

/// A scan's vertices with their neighbours along edges.
pub struct Neighbours {
    starts: Vec<u32>,
    of: Vec<u32>,
}

impl Neighbours {
    /// Of a mesh.
    pub fn new(vertices: usize, triangles: &[[u32; 3]]) -> Self {
        // Both directions of every side: inside the mesh each appears once from each triangle.
        let mut edges: Vec<u64> = Vec::with_capacity(6 * triangles.len());
        for &[a, b, c] in triangles {
            for (a, b) in [(a, b), (b, c), (c, a)] {
                edges.push(u64::from(a) << 32 | u64::from(b));
                edges.push(u64::from(b) << 32 | u64::from(a));
            }
        }
        edges.sort_unstable();
        edges.dedup();
        let mut starts = vec![0; vertices + 1];
        for edge in &edges {
            starts[(edge >> 32) as usize + 1] += 1;
        }
        for v in 0..vertices {
            starts[v + 1] += starts[v];
        }
        Self {
            starts,
            of: edges.into_iter().map(|edge| edge as u32).collect(),
        }
    }

    fn around(&self, vertex: usize) -> &[u32] {
        &self.of[self.starts[vertex] as usize..self.starts[vertex + 1] as usize]
    }

    /// The vector from each vertex to the mean of its neighbours.
    fn differences(&self, positions: &[DVec3]) -> Vec<DVec3> {
        (0..positions.len())
            .map(|v| {
                let around = self.around(v);
                if around.is_empty() {
                    return DVec3::ZERO;
                }
                let sum: DVec3 = around.iter().map(|&n| positions[n as usize]).sum();
                sum / around.len() as f64 - positions[v]
            })
            .collect()
    }
}

/// The standard deviation of the noise along the normals of a mesh, mm: by how far vertices stand off the mean of their
/// neighbours, beyond what these do of theirs. Robust against creases, and blind to what is smooth on the scale of a few
/// edges, and to how a surface is curved, which a coarse mesh has between its vertices.
pub fn noise(positions: &[DVec3], normals: &[DVec3], neighbours: &Neighbours) -> f64 {
    let differences = neighbours.differences(positions).into_iter();
    let off: Vec<f64> = differences.zip(normals).map(|(d, n)| d.dot(*n)).collect();
    let beyond = |v: usize| {
        let around = neighbours.around(v);
        let sum: f64 = around.iter().map(|&n| off[n as usize]).sum();
        (off[v] - sum / around.len().max(1) as f64).abs()
    };
    let mut beyond: Vec<f64> = (0..off.len()).map(beyond).collect();
    if beyond.is_empty() {
        return 0.0;
    }
    beyond.sort_unstable_by(f64::total_cmp);
    // Among triangles of six a corner, independent noise of variance 1 comes through with what a vertex has of itself,
    // 1 + 6 / 36, of each neighbour, -2 / 6 + 2 / 36, and of the twelve around them, six times 1 / 36 and six times 2 / 36.
    let gain = (7.0_f64 / 6.0).powi(2) + 6.0 * (5.0_f64 / 18.0).powi(2) + 30.0 / 36.0_f64.powi(2);
    // 1.4826 makes a median a deviation.
    1.4826 * beyond[beyond.len() / 2] / gain.sqrt()
}

/// Takes noise off: rounds of smoothing that shrink nothing but what is as fine as the edges
/// (Taubin 1995).
pub fn smooth(positions: &mut [DVec3], neighbours: &Neighbours, rounds: usize) {
    // His pass-band of a tenth: 1 / 0.5 - 1 / 0.53 is near 0.11.
    for share in std::iter::repeat_n([0.5, -0.53], rounds).flatten() {
        let differences = neighbours.differences(positions);
        for (p, d) in positions.iter_mut().zip(differences) {
            *p += d * share;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Random;

    /// A dome of radius 80 mm, about 1.5 mm an edge, with noise.
    fn dome(sigma: f64) -> (Vec<DVec3>, Vec<DVec3>, Neighbours) {
        dome_of(60, 1.5, sigma)
    }

    /// A dome of radius 80 mm, n x n vertices, about so many mm an edge, with noise.
    fn dome_of(n: u32, edge: f64, sigma: f64) -> (Vec<DVec3>, Vec<DVec3>, Neighbours) {
        let middle = f64::from(n - 1) / 2.0;
        let mut random = Random::new(9);
        let clean: Vec<DVec3> = (0..n * n)
            .map(|i| {
                let (x, y) = (f64::from(i % n) - middle, f64::from(i / n) - middle);
                let jitter = DVec3::new(random.uniform(), random.uniform(), 0.0) - 0.5;
                let p = DVec3::new(x, y, 0.0) * edge + jitter.with_z(0.0) * edge * 0.53;
                p.with_z((6400.0 - p.x * p.x - p.y * p.y).sqrt())
            })
            .collect();
        let normals: Vec<DVec3> = clean.iter().map(|p| p.normalize()).collect();
        let noisy = clean
            .iter()
            .map(|p| *p + p.normalize() * random.normal() * sigma)
            .collect();
        let triangles: Vec<[u32; 3]> = (0..(n - 1) * (n - 1))
            .flat_map(|i| {
                let v = i / (n - 1) * n + i % (n - 1);
                [[v, v + 1, v + n], [v + 1, v + n + 1, v + n]]
            })
            .collect();
        (
            noisy,
            normals,
            Neighbours::new((n * n) as usize, &triangles),
        )
    }

    #[test]
    fn the_noise_is_found() {
        for sigma in [0.1, 0.3] {
            let (positions, normals, neighbours) = dome(sigma);
            let found = noise(&positions, &normals, &neighbours);
            // 3,600 samples leave two per cent, jitter along the surface and its curvature more.
            assert!((found / sigma - 1.0).abs() < 0.15, "{sigma}: {found}");
        }
        // Of a smooth dome every vertex stands off its neighbours' mean, by about edge^2 / (2 radius): 0.25 mm on a coarse
        // one, of which the unevenness of the edges leaves half.
        let found = [1.5, 6.0].map(|edge| {
            let (positions, normals, neighbours) = dome_of((84.0 / edge) as u32, edge, 0.0);
            noise(&positions, &normals, &neighbours)
        });
        assert!(found[0] < 0.01 && found[1] < 0.15, "{found:?}");
    }

    #[test]
    fn smoothing_takes_most_of_the_noise_off_and_leaves_the_dome() {
        let (mut positions, normals, neighbours) = dome(0.3);
        smooth(&mut positions, &neighbours, 8);
        // The border has fewer neighbours; look inside.
        let inside = |i: &usize| (i % 60).abs_diff(30) < 20 && (i / 60).abs_diff(30) < 20;
        let off: Vec<f64> = (0..3600)
            .filter(inside)
            .map(|i| positions[i].length() - 80.0)
            .collect();
        let mean = off.iter().sum::<f64>() / off.len() as f64;
        let rms = (off.iter().map(|d| d * d).sum::<f64>() / off.len() as f64).sqrt();
        assert!(mean.abs() < 0.03, "shrinks by {mean}");
        assert!(rms < 0.14, "{rms} left");
        assert_eq!(normals.len(), positions.len());
    }
}
