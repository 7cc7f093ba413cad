//! The mesh that all faces of a model share.

use crate::anatomy::Part;
use crate::blob::{Blob, BlobWriter};
use crate::predict::{Around, Walk};
use crate::quantise::TEXTURE;
use crate::{Error, Result};

/// Triangles, texture coordinates, regions and mirror images of N vertices.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Topology {
    /// Texture coordinates of M >= N corners; the first N belong to the vertices in order, the
    /// others are second coordinates of vertices on a seam.
    pub uvs: Vec<[f32; 2]>,
    /// The vertex of each corner: M entries, `uv_vertices[i] == i` for i < N.
    pub uv_vertices: Vec<u32>,
    /// Triangles as corners, counter-clockwise seen from outside, part by part.
    pub uv_triangles: Vec<[u32; 3]>,
    /// The triangle groups, in order.
    pub parts: Vec<Part>,
    /// The vertex on the other side of the head; an involution.
    pub mirror: Vec<u32>,
    /// The names of the regions.
    pub region_names: Vec<String>,
    /// The region of each vertex.
    pub regions: Vec<u8>,
    /// The prescribed colour of each vertex, sRGB.
    pub colours: Vec<[u8; 3]>,
}

impl Topology {
    /// Triangles as vertices.
    pub fn triangles(&self) -> Vec<[u32; 3]> {
        let vertex = |corner: u32| self.uv_vertices[corner as usize];
        self.uv_triangles.iter().map(|t| t.map(vertex)).collect()
    }

    /// The vertices of a part, increasing; none when there is no such part.
    pub fn part_vertices(&self, name: &str) -> Vec<u32> {
        let mut inside = vec![false; self.regions.len()];
        for part in self.parts.iter().filter(|part| part.name == name) {
            let first = part.first as usize;
            for corner in self.uv_triangles[first..first + part.count as usize].as_flattened() {
                inside[self.uv_vertices[*corner as usize] as usize] = true;
            }
        }
        let all = 0..inside.len() as u32;
        all.filter(|&v| inside[v as usize]).collect()
    }

    /// The walk over the vertices that predicts their numbers.
    pub(crate) fn walk(&self) -> Walk {
        Walk::new(&Around::new(self.regions.len(), &self.triangles()))
    }

    pub(crate) fn write(&self, blob: &mut BlobWriter, walk: &Walk) {
        let n = self.regions.len();
        let corners = self.uv_triangles.as_flattened();
        // Each corner from another of the triangle, the first from the triangle before.
        let from = |i: usize| match i % 3 {
            0 => i.checked_sub(3),
            corner => Some(i - corner),
        };
        let step = |i: usize| corners[i].wrapping_sub(from(i).map_or(0, |j| corners[j])) as i32;
        let by_corner = (0..3).flat_map(|corner| (corner..corners.len()).step_by(3));
        let steps: Vec<i32> = by_corner.map(step).collect();
        blob.planes("triangles", &steps);
        let uvs: Vec<i32> = (self.uvs.iter().flatten())
            .map(|&x| TEXTURE.index(x.into()))
            .collect();
        let (own, further) = uvs.split_at(2 * n);
        let mut residuals = walk.residuals(own, 2);
        for (further, &vertex) in further.chunks_exact(2).zip(&self.uv_vertices[n..]) {
            let own = &own[2 * vertex as usize..];
            residuals.extend(further.iter().zip(own).map(|(a, b)| a.wrapping_sub(*b)));
        }
        blob.planes("uvs", &residuals);
        let seams = self.uv_vertices[n..].iter().map(|&v| v as i32);
        blob.planes("seams", &seams.collect::<Vec<_>>());
        // The second of two mirror images says nothing new.
        let ahead = self.mirror.iter().zip(0..);
        let ahead: Vec<i32> = ahead.map(|(&m, v)| m.saturating_sub(v) as i32).collect();
        blob.planes("mirror", &ahead);
        blob.section("regions", &self.regions);
        let colours: Vec<u8> = self.colours.iter().flatten().copied().collect();
        blob.section("colours", &colours);
    }

    pub(crate) fn read(
        blob: &Blob,
        n: usize,
        corners: usize,
        triangles: usize,
        region_names: Vec<String>,
        parts: Vec<Part>,
    ) -> Result<(Self, Walk, Around)> {
        let bad = |why: &str| Err(Error::Blob(why.into()));
        if corners < n {
            return bad("fewer texture coordinates than vertices");
        }
        let mut uv_vertices: Vec<u32> = (0..n as u32).collect();
        let seams = blob.planes("seams", corners - n)?;
        uv_vertices.extend(seams.into_iter().map(|v| v as u32));
        let regions = blob.bytes("regions", n)?.to_vec();
        let colours = blob.bytes("colours", 3 * n)?;
        let steps = blob.planes("triangles", 3 * triangles)?;
        let mut uv_triangles: Vec<[u32; 3]> = Vec::with_capacity(triangles);
        let mut before = 0_u32;
        for t in 0..triangles {
            let step = |corner: usize| steps[corner * triangles + t] as u32;
            let first = before.wrapping_add(step(0));
            uv_triangles.push([
                first,
                first.wrapping_add(step(1)),
                first.wrapping_add(step(2)),
            ]);
            before = first;
        }
        let there = |numbers: &[u32], end: usize| numbers.iter().all(|&i| (i as usize) < end);
        if !there(&uv_vertices, n) || !there(uv_triangles.as_flattened(), corners) {
            return bad("a triangle has a corner that is not there");
        }
        let vertex_of = |c: u32| uv_vertices[c as usize];
        let on_vertices: Vec<[u32; 3]> = uv_triangles.iter().map(|t| t.map(vertex_of)).collect();
        let around = Around::new(n, &on_vertices);
        let walk = Walk::new(&around);
        let own = walk.restore(blob.in_planes("uvs", 2 * corners)?, 2, 1, &[]);
        let mut uvs: Vec<[i32; 2]> = (own.iter().map(|four| four.to_array()))
            .map(|[u, v, ..]| [u, v])
            .collect();
        let further = &blob.planes("uvs", 2 * corners)?[2 * n..];
        for (further, &vertex) in further.as_chunks::<2>().0.iter().zip(&uv_vertices[n..]) {
            let own = uvs[vertex as usize];
            uvs.push([0, 1].map(|axis| further[axis].wrapping_add(own[axis])));
        }
        let mirror = read_mirror(blob, n)?;
        if regions
            .iter()
            .any(|&r| usize::from(r) >= region_names.len())
        {
            return bad("a vertex lies in no region");
        }
        let mut next = 0_u32;
        for part in &parts {
            if part.first != next {
                next = u32::MAX;
            }
            next = next.saturating_add(part.count);
        }
        if next as usize != triangles {
            return bad("its parts do not cover the mesh");
        }
        let topology = Self {
            uvs: uvs
                .into_iter()
                .map(|c| c.map(|x| TEXTURE.point(x) as f32))
                .collect(),
            uv_vertices,
            uv_triangles,
            parts,
            mirror,
            region_names,
            regions,
            colours: colours.as_chunks().0.to_vec(),
        };
        Ok((topology, walk, around))
    }
}

/// The mirror map from how far ahead the image of a vertex is; 0 for one that is its own, and for
/// one that is the image of an earlier vertex.
fn read_mirror(blob: &Blob, n: usize) -> Result<Vec<u32>> {
    const UNKNOWN: u32 = u32::MAX;
    let mut mirror = vec![UNKNOWN; n];
    for (v, step) in (0_u32..).zip(blob.planes("mirror", n)?) {
        let known = mirror[v as usize] != UNKNOWN;
        if known && step == 0 {
            continue;
        }
        let image = v.checked_add_signed(step).filter(|&m| m >= v && !known);
        match image.filter(|&m| mirror.get(m as usize) == Some(&UNKNOWN)) {
            Some(image) => {
                mirror[v as usize] = image;
                mirror[image as usize] = v;
            }
            None => return Err(Error::Blob("its mirror map is not an involution".into())),
        }
    }
    Ok(mirror)
}
