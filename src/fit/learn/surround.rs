//! What follows a region, and how (region morphing, section 6.2, eqs. 11 and 12).

use std::collections::BTreeMap;

use glam::{DVec3, Vec3};

use crate::fit::FitResult;
use crate::fit::mesh::geodesic::{Geodesic, largest_component};
use crate::mesh::Topology;
use crate::model::{Nearest, Rigid, SOURCES, Surround, falloff};
use crate::quantise::DISTANCES;

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

/// A part that hangs together with nothing by triangles (an eyeball) and follows as a whole.
#[derive(Debug, Clone, PartialEq)]
pub struct Loose {
    /// The part, an index into the topology's parts.
    pub part: u32,
    /// Its vertices.
    pub members: Vec<u32>,
    /// The vertices (lids) that it follows.
    pub leaders: Vec<u32>,
}

/// Builds the surround of a region.
///
/// `mean` is the mean face of `graph`, `support` are the region's vertices (increasing). Vertices
/// farther than `reach` mm along the surface do not follow.
///
/// # Errors
/// When the region has no border.
pub fn build(
    graph: &Geodesic<'_>,
    mean: &[Vec3],
    topology: &Topology,
    support: &[u32],
    loose: &[Loose],
    reach: f64,
) -> FitResult<Surround> {
    let vertices = mean.len();
    let mut inside = vec![false; vertices];
    support.iter().for_each(|&v| inside[v as usize] = true);
    let triangles = topology.triangles();
    let from_border = distances(graph, &triangles, &inside, reach);
    let mut distances: BTreeMap<u32, f64> = (0..vertices)
        .filter(|&v| !inside[v] && from_border[v].is_finite())
        .map(|v| (v as u32, from_border[v]))
        .collect();
    let mut nearest = Nearest::new(mean, topology, support);
    let mut rigid = Vec::new();
    let mut followed = Vec::new();
    for Loose {
        part,
        members,
        leaders,
    } in loose
    {
        let led: Vec<u32> = (leaders.iter().copied())
            .filter(|leader| distances.contains_key(leader))
            .collect();
        // Leaders inside the region carry the loose part with it by its own modes.
        if led.is_empty() || members.iter().any(|&m| inside[m as usize]) {
            continue;
        }
        let distance = led.iter().map(|v| distances[v]).sum::<f64>() / led.len() as f64;
        let mut sum: BTreeMap<u32, f64> = BTreeMap::new();
        let mut own = [(0, 0); SOURCES];
        for &v in &led {
            nearest.row(mean[v as usize], &mut own);
            for (source, weight) in own {
                *sum.entry(source).or_default() += f64::from(weight);
            }
        }
        let mut sources: Vec<(u32, f64)> = sum.into_iter().collect();
        sources.sort_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
        rigid.push(row(*part, &sources));
        followed.extend(members.iter().map(|&m| (m, distance)));
    }
    distances.extend(followed);
    let on_grid = |d: &f64| DISTANCES.nearest(*d) as f32;
    let surround = Surround::new(
        mean,
        topology,
        support,
        distances.keys().copied().collect(),
        distances.values().map(on_grid).collect(),
        rigid,
    );
    Ok(surround?)
}

/// The distance of every vertex from a region, mm along the surface; infinite beyond `reach`.
///
/// Of a region in pieces (the eyes) it is (sum 1 / d^3)^(-1/3) of the distances d from them: the
/// shortest of them has a ridge half way, and the fall-off along that was a crease down the glabella
/// of 29 degrees when both brows come forward; this way it is 13, where whole faces have 11.
fn distances(
    graph: &Geodesic<'_>,
    triangles: &[[u32; 3]],
    inside: &[bool],
    reach: f64,
) -> Vec<f64> {
    let mut left = inside.to_vec();
    let all = border(triangles, inside);
    let mut nearness = vec![0.0; inside.len()];
    while all.iter().any(|&v| left[v as usize]) {
        let piece = largest_component(triangles, &left);
        let own: Vec<u32> = (all.iter().copied())
            .filter(|&v| piece[v as usize])
            .collect();
        left.iter_mut().zip(&piece).for_each(|(l, p)| *l &= !p);
        if own.is_empty() {
            continue;
        }
        // From farther away than the reach a piece still bends what another one leads.
        for (near, d) in nearness.iter_mut().zip(graph.distances(&own, 3.0 * reach)) {
            *near += d.max(1e-9).powi(-3);
        }
    }
    let distance = |near: f64| {
        if near > 0.0 {
            near.cbrt().recip()
        } else {
            f64::INFINITY
        }
    };
    let within = |d: f64| if d <= reach { d } else { f64::INFINITY };
    nearness
        .into_iter()
        .map(|near| within(distance(near)))
        .collect()
}

/// The first sources, of which the first has the most, with weights in units of 1/65535 that sum
/// to one.
fn row(part: u32, sources: &[(u32, f64)]) -> Rigid {
    let sources = &sources[..sources.len().min(SOURCES)];
    let total: f64 = sources.iter().map(|s| s.1).sum();
    let mut rigid = Rigid {
        part,
        sources: [0; SOURCES],
        weights: [0; SOURCES],
    };
    for (i, (place, weight)) in sources.iter().enumerate() {
        rigid.sources[i] = *place;
        rigid.weights[i] = (weight / total * 65_535.0).floor() as u16;
    }
    rigid.weights[0] += 65_535 - rigid.weights.iter().sum::<u16>();
    rigid
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
    let all: Vec<usize> = (0..surround.targets.len()).collect();
    let rows = surround.rows(&all);
    for (t, &target) in surround.targets.iter().enumerate() {
        let pulled: DVec3 = (rows[t].iter())
            .map(|&(place, weight)| own[place as usize] * f64::from(weight))
            .sum();
        let fade = f64::from(falloff(surround.distances[t] / alpha));
        whole[target as usize] = pulled * (fade / 65_535.0);
    }
    whole
}
