//! The scan's image on the registered head (region morphing, section 4.2).
//!
//! A vertex that lies on the scan takes the scan's texture coordinate there
//! ([`coordinates`]). That is a picture per vertex of an atlas that is the scan's own; to show,
//! keep and compare heads, [`bake`] samples the scan's image once a texel of the template's own
//! layout. Where there is no scan the head's painted colours are taken, in the tone that the
//! surround asks for: the logarithm of (scan's colour / painted colour) is continued by a
//! membrane over the mesh, so it knows nothing of the layout's seams, and nostrils stay dark.

use std::borrow::Cow;
use std::path::Path;

use faer::Side;
use faer::linalg::solvers::Solve;
use faer::sparse::{SparseColMat, Triplet};
use glam::{DVec2, DVec3, Vec4};
use rayon::prelude::*;

use crate::fit::head::template::Template;
use crate::fit::mesh::align::vertex_areas;
use crate::fit::mesh::cotangent::cotangent_edges;
use crate::fit::mesh::surface::normals;
use crate::fit::mesh::surface::{Hit, Surface};
use crate::fit::picture::render::write_png;
use crate::fit::scan::{Scan, Texture};
use crate::fit::{FitError, FitResult};

/// A texel takes its colour from the scan within this distance, mm: vertices that are on the scan
/// are joined by triangles that leave it by less.
const REACH: f64 = 2.0;
/// ... and where the two surfaces face the same way, within 60 degrees.
const FACING: f64 = 0.5;
/// Over this length, mm, the tone of a hole goes from its rim's to the usual one: the back of a
/// head that was scanned from the front is no smear of its ears.
const FADE: f64 = 80.0;
/// No tone is further than this factor from the painted colours.
const LARGEST_TONE: f64 = 20.0;
/// Within a triangle a picture repeats no more often, to either side: more is no picture of a face.
const MOST_REPEATS: f64 = 4.0;
/// A side of a baked image, texels: beyond 8192 no browser shows it.
const SIZES: std::ops::RangeInclusive<usize> = 16..=8192;

/// The scan's texture coordinate at each vertex of a registered head; none for vertices that are
/// not `covered`, and where the scan has no texture.
///
/// # Errors
/// When the numbers of vertices differ.
pub fn coordinates(
    positions: &[DVec3],
    covered: &[bool],
    scan: &Scan,
) -> FitResult<Vec<Option<DVec2>>> {
    same_count(positions.len(), covered.len())?;
    let Some(texture) = &scan.texture else {
        return Ok(vec![None; positions.len()]);
    };
    let surface = Surface::new(&scan.positions, &scan.triangles);
    let textured = |t: u32| texture.triangles[t as usize] != Texture::BARE;
    Ok(positions
        .par_iter()
        .zip(covered)
        .map(|(&p, covered)| {
            let hit = covered.then(|| surface.closest_where(p, REACH, textured))??;
            Some(texture.coordinate(&hit))
        })
        .collect())
}

impl Texture {
    /// The texture coordinate at a point of the mesh.
    pub fn coordinate(&self, hit: &Hit) -> DVec2 {
        let corners = self.triangles[hit.triangle as usize];
        (0..3)
            .map(|i| self.uvs[corners[i] as usize] * hit.weights[i])
            .sum()
    }

    /// Writes the picture as a PNG, whole or not at all.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn save(&self, path: &Path) -> FitResult<()> {
        write_png(path, [self.width, self.height], &self.pixels)
    }

    /// The colour at a texture coordinate, interpolated between the four nearest pixels; sRGB, 0
    /// to 255. Coordinates beyond the picture repeat it.
    pub fn sample(&self, uv: DVec2) -> DVec3 {
        bilinear([self.width, self.height], uv, |at| (self.pixels[at], 1.0))
    }
}

/// Interpolates between the four pixels around a texture coordinate, each with its colour and
/// weight; where they have none, as if all had.
fn bilinear(
    [width, height]: [usize; 2],
    uv: DVec2,
    pixel: impl Fn(usize) -> ([u8; 3], f64),
) -> DVec3 {
    // An edge of exactly one is the edge, not the other side.
    let within = |x: f64| match (0.0..=1.0).contains(&x) {
        true => x,
        false => x.rem_euclid(1.0),
    };
    let place = |x: f64, count: usize| {
        let x = (x * count as f64 - 0.5).clamp(0.0, (count - 1) as f64);
        (x as usize, (x as usize + 1).min(count - 1), x.fract())
    };
    let (left, right, fx) = place(within(uv.x), width);
    let (top, bottom, fy) = place(1.0 - within(uv.y), height);
    let (mut sum, mut weight, mut plain) = (DVec3::ZERO, 0.0, DVec3::ZERO);
    for (y, wy) in [(top, 1.0 - fy), (bottom, fy)] {
        for (x, wx) in [(left, 1.0 - fx), (right, fx)] {
            let (colour, w) = pixel(y * width + x);
            let colour = DVec3::from_array(colour.map(f64::from));
            plain += colour * wx * wy;
            sum += colour * wx * wy * w;
            weight += wx * wy * w;
        }
    }
    match weight > 1e-9 {
        true => sum / weight,
        false => plain,
    }
}

/// The scan's colours in the template's layout: `size` x `size` texels, with the template's
/// texture coordinates.
///
/// `positions` are the registered head's vertices in the scan's pose, mm; `covered` says which of
/// them lie on the scan. Eyeballs, mouth and eye cavities keep the template's painted colours, as
/// dark as the skin's usual tone is. The same on any number of threads.
///
/// # Errors
/// When the scan has neither a texture nor colours of its vertices, the size is not between 16
/// and 8192, or numbers of vertices differ.
pub fn bake(
    template: &Template,
    positions: &[DVec3],
    covered: &[bool],
    scan: &Scan,
    size: usize,
) -> FitResult<Texture> {
    same_count(template.positions.len(), positions.len())?;
    same_count(template.positions.len(), covered.len())?;
    if !SIZES.contains(&size) {
        let cause = format!("a texture of {size} x {size}, not between 16 and 8192");
        return Err(FitError::Input(cause));
    }
    let topology = &template.topology;
    let triangles = template.triangles();
    let skin = template.part_vertices("skin")?;
    let mut is_skin = vec![false; positions.len()];
    skin.iter().for_each(|&v| is_skin[v as usize] = true);
    let source = Source::new(scan)?;
    let facing = normals(positions, &triangles);

    // What the scan says at the vertices, blurred to the distance between them.
    let edge = mean_edge(positions, &triangles);
    let seen: Vec<Option<DVec3>> = (0..positions.len())
        .into_par_iter()
        .map(|v| {
            let on = covered[v] && is_skin[v];
            on.then(|| source.colour(positions[v], facing[v], edge))?
        })
        .collect();
    let tones = tones(template, &skin, &seen)?;
    let painted: Vec<DVec3> = topology
        .colours
        .iter()
        .zip(&tones)
        .map(|(c, tone)| DVec3::from_array(c.map(f64::from)) * tone.map(f64::exp))
        .collect();

    let owners = owners(topology, size);
    // A smooth colour for each texel of the layout, and what the scan has on top of that; the
    // fourth number is 1 where it is known. Single precision: an image has a lot of texels.
    let (base, over): (Vec<Vec4>, Vec<Vec4>) = owners
        .par_iter()
        .enumerate()
        .map(|(at, &owner)| {
            let Some(t) = (owner != u32::MAX).then_some(owner as usize) else {
                return (Vec4::ZERO, Vec4::ZERO);
            };
            let centre = DVec2::new((at % size) as f64 + 0.5, (at / size) as f64 + 0.5);
            let uvs = layout(topology, t, size);
            let weights = barycentric(uvs, centre);
            let corners = triangles[t].map(|v| v as usize);
            let mix = |of: &[DVec3]| -> DVec3 { (0..3).map(|i| of[corners[i]] * weights[i]).sum() };
            let base = mix(&painted);
            let smooth = base.as_vec3().extend(1.0);
            if !corners.iter().all(|&v| is_skin[v]) {
                return (smooth, Vec4::W);
            }
            let on: f64 = (0..3)
                .map(|i| f64::from(u8::from(covered[corners[i]])) * weights[i])
                .sum();
            let found = (on > 0.5).then(|| {
                let [a, b, c] = corners.map(|v| positions[v]);
                let area = (b - a).cross(c - a).length();
                let texel = (area / (uvs[1] - uvs[0]).perp_dot(uvs[2] - uvs[0]).abs()).sqrt();
                source.colour(mix(positions), mix(&facing).normalize_or_zero(), texel)
            });
            let over = found.flatten().map(|colour| (colour - base).as_vec3());
            (smooth, over.map_or(Vec4::ZERO, |over| over.extend(1.0)))
        })
        .unzip();
    Ok(Texture {
        uvs: topology
            .uvs
            .iter()
            .map(|uv| DVec2::new(uv[0].into(), uv[1].into()))
            .collect(),
        triangles: topology.uv_triangles.clone(),
        width: size,
        height: size,
        pixels: filled(base, over, size),
    })
}

fn same_count(expected: usize, found: usize) -> FitResult<()> {
    match expected == found {
        true => Ok(()),
        false => Err(FitError::Input(format!(
            "{found} vertices of a registered head, where there should be {expected}"
        ))),
    }
}

fn mean_edge(positions: &[DVec3], triangles: &[[u32; 3]]) -> f64 {
    let sum: f64 = triangles
        .iter()
        .map(|t| positions[t[0] as usize].distance(positions[t[1] as usize]))
        .sum();
    sum / triangles.len() as f64
}

/// The colours of a scan's surface.
struct Source<'a> {
    scan: &'a Scan,
    surface: Surface<'a>,
    /// The image, and it halved once, twice and so on.
    pyramid: Vec<Level<'a>>,
    /// Pixels a mm on each triangle.
    density: Vec<f64>,
}

impl<'a> Source<'a> {
    fn new(scan: &'a Scan) -> FitResult<Self> {
        let surface = Surface::new(&scan.positions, &scan.triangles);
        let Some(texture) = &scan.texture else {
            if scan.colours.len() != scan.positions.len() {
                let cause = "neither a texture nor colours of its vertices";
                return Err(FitError::file(&scan.path, cause));
            }
            return Ok(Self {
                scan,
                surface,
                pyramid: Vec::new(),
                density: Vec::new(),
            });
        };
        let size = DVec2::new(texture.width as f64, texture.height as f64);
        let density = scan
            .triangles
            .iter()
            .zip(&texture.triangles)
            .map(|(triangle, uvs)| {
                if *uvs == Texture::BARE {
                    return 0.0;
                }
                let [a, b, c] = triangle.map(|v| scan.positions[v as usize]);
                let [d, e, f] = uvs.map(|uv| texture.uvs[uv as usize] * size);
                let pixels = (e - d).perp_dot(f - d).abs();
                (pixels / (b - a).cross(c - a).length()).sqrt()
            })
            .collect();
        let mut pyramid = vec![Level::of(texture)];
        while let Some(level) = pyramid.last().filter(|l| l.size.iter().all(|&s| s > 1)) {
            pyramid.push(level.halved());
        }
        Ok(Self {
            scan,
            surface,
            pyramid,
            density,
        })
    }

    /// The colour near a point that faces some way, over a patch of a width in mm; nothing where
    /// the scan has no such place, or only its ragged border.
    fn colour(&self, p: DVec3, facing: DVec3, width: f64) -> Option<DVec3> {
        let texture = self.scan.texture.as_ref();
        let hit = self.surface.closest_where(p, REACH, |t| {
            texture.is_none_or(|texture| texture.triangles[t as usize] != Texture::BARE)
                && self.surface.facets[t as usize].dot(facing) > FACING
        })?;
        if self.surface.on_border(&hit) {
            return None;
        }
        let Some(texture) = texture else {
            let corners = self.scan.triangles[hit.triangle as usize];
            let colour = |i: usize| self.scan.colours[corners[i] as usize].map(f64::from);
            return Some(
                (0..3)
                    .map(|i| DVec3::from_array(colour(i)) * hit.weights[i])
                    .sum(),
            );
        };
        let pixels = (width * self.density[hit.triangle as usize]).max(1.0);
        let level = (pixels.log2().round() as usize).min(self.pyramid.len() - 1);
        let level = &self.pyramid[level];
        let weight = |at: usize| f64::from(u8::from(level.inside[at]));
        Some(bilinear(level.size, texture.coordinate(&hit), |at| {
            (level.pixels[at], weight(at))
        }))
    }
}

/// A scan's image, or a smaller one of it.
struct Level<'a> {
    size: [usize; 2],
    pixels: Cow<'a, [[u8; 3]]>,
    /// Whether each pixel belongs to a triangle: what lies between the charts of an atlas, often
    /// black, must not come in when the image is made smaller.
    inside: Vec<bool>,
}

impl<'a> Level<'a> {
    fn of(texture: &'a Texture) -> Self {
        let size = [texture.width, texture.height];
        let mut inside = vec![false; size[0] * size[1]];
        let scale = DVec2::new(size[0] as f64, size[1] as f64);
        for uvs in texture.triangles.iter().filter(|t| **t != Texture::BARE) {
            let corners = uvs.map(|uv| {
                let uv = texture.uvs[uv as usize];
                DVec2::new(uv.x, 1.0 - uv.y)
            });
            // The picture repeats: what is beyond it is in it again.
            let first = corners[0].min(corners[1]).min(corners[2]).floor();
            let corners = corners.map(|corner| corner - first);
            let end = corners[0].max(corners[1]).max(corners[2]).ceil();
            let [columns, rows] = end.min(DVec2::splat(MOST_REPEATS)).to_array();
            for tile in (0..rows as usize).flat_map(|y| (0..columns as usize).map(move |x| [x, y]))
            {
                let tile = DVec2::new(tile[0] as f64, tile[1] as f64);
                let own = corners.map(|corner| (corner - tile) * scale);
                cells(own, size, |at| inside[at] = true);
            }
        }
        Self {
            size,
            pixels: Cow::Borrowed(&texture.pixels),
            inside,
        }
    }

    /// The image of half the size, each pixel the mean of those of four that are inside.
    fn halved(&self) -> Self {
        let [width, height] = self.size;
        let size = [width.div_ceil(2), height.div_ceil(2)];
        let (pixels, inside) = (0..size[0] * size[1])
            .into_par_iter()
            .map(|at| {
                let (x, y) = (at % size[0] * 2, at / size[0] * 2);
                let mut sums = [[0_u32; 4]; 2];
                for y in y..(y + 2).min(height) {
                    for place in y * width + x..y * width + (x + 2).min(width) {
                        let [r, g, b] = self.pixels[place].map(u32::from);
                        let sum = &mut sums[usize::from(self.inside[place])];
                        *sum = [sum[0] + r, sum[1] + g, sum[2] + b, sum[3] + 1];
                    }
                }
                let inside = sums[1][3] > 0;
                let [r, g, b, count] = sums[usize::from(inside)];
                ([r, g, b].map(|c| ((c + count / 2) / count) as u8), inside)
            })
            .unzip();
        Self {
            size,
            pixels: Cow::Owned(pixels),
            inside,
        }
    }
}

/// The logarithm of (colour / painted colour) at each vertex: what was seen where it was, over
/// the rest of the skin a membrane through it that is drawn to the median with distance, and off
/// the skin the median's darkness: eyes in the scan's exposure.
fn tones(template: &Template, skin: &[u32], seen: &[Option<DVec3>]) -> FitResult<Vec<DVec3>> {
    let mut tones = vec![DVec3::ZERO; seen.len()];
    let limit = LARGEST_TONE.ln();
    let mut known: [Vec<f64>; 3] = Default::default();
    for (v, colour) in seen.iter().enumerate() {
        if let Some(colour) = colour {
            let painted = DVec3::from_array(template.topology.colours[v].map(f64::from));
            // One step of 255 keeps black from being infinitely far.
            let tone = ((*colour + 1.0) / (painted + 1.0)).map(f64::ln);
            tones[v] = tone.clamp(DVec3::splat(-limit), DVec3::splat(limit));
            let channels = tones[v].to_array();
            known.iter_mut().zip(channels).for_each(|(k, c)| k.push(c));
        }
    }
    let usual = DVec3::from_array(known.each_mut().map(|channel| {
        channel.sort_unstable_by(f64::total_cmp);
        channel.get(channel.len() / 2).copied().unwrap_or(0.0)
    }));
    let exposure = DVec3::splat((usual.element_sum() / 3.0).min(0.0));
    let mut on_skin = vec![false; seen.len()];
    skin.iter().for_each(|&v| on_skin[v as usize] = true);
    for (tone, _) in tones.iter_mut().zip(on_skin).filter(|(_, on)| !on) {
        *tone = exposure;
    }
    let mut slots = vec![usize::MAX; seen.len()];
    let open: Vec<usize> = skin
        .iter()
        .map(|&v| v as usize)
        .filter(|&v| seen[v].is_none())
        .collect();
    open.iter().enumerate().for_each(|(i, &v)| slots[v] = i);
    if open.is_empty() {
        return Ok(tones);
    }
    let triangles = template.part_triangles("skin")?;
    let areas = vertex_areas(&template.positions, &triangles);
    let mut diagonal: Vec<f64> = open.iter().map(|&v| areas[v] / (FADE * FADE)).collect();
    let mut right = faer::Mat::from_fn(open.len(), 3, |i, channel| diagonal[i] * usual[channel]);
    let mut triplets = Vec::new();
    for (a, b, weight) in cotangent_edges(&template.positions, &triangles) {
        let ends = [a as usize, b as usize];
        for [v, w] in [ends, [ends[1], ends[0]]] {
            let i = slots[v];
            if i == usize::MAX {
                continue;
            }
            diagonal[i] += weight;
            match slots[w] {
                usize::MAX => (0..3).for_each(|c| right[(i, c)] += weight * tones[w][c]),
                j => triplets.push(Triplet::new(i, j, -weight)),
            }
        }
    }
    triplets.extend((0..open.len()).map(|i| Triplet::new(i, i, diagonal[i])));
    let fail = |what: &str| FitError::Input(format!("the texture's membrane: {what}"));
    let matrix = SparseColMat::try_new_from_triplets(open.len(), open.len(), &triplets)
        .map_err(|e| fail(&format!("{e:?}")))?;
    let factor = matrix
        .sp_cholesky(Side::Lower)
        .map_err(|e| fail(&format!("{e:?}")))?;
    let solved = factor.solve(&right);
    for (i, &v) in open.iter().enumerate() {
        tones[v] = DVec3::new(solved[(i, 0)], solved[(i, 1)], solved[(i, 2)]);
    }
    Ok(tones)
}

/// Corners of a triangle in texels from the top left.
fn layout(topology: &crate::mesh::Topology, triangle: usize, size: usize) -> [DVec2; 3] {
    topology.uv_triangles[triangle].map(|corner| {
        let [u, v] = topology.uvs[corner as usize].map(f64::from);
        DVec2::new(u, 1.0 - v) * size as f64
    })
}

fn barycentric([a, b, c]: [DVec2; 3], p: DVec2) -> [f64; 3] {
    let area = (b - a).perp_dot(c - a);
    let wa = (b - p).perp_dot(c - p) / area;
    let wb = (c - p).perp_dot(a - p) / area;
    [wa, wb, 1.0 - wa - wb]
}

/// The triangle in whose layout each texel's centre lies, `u32::MAX` for none.
fn owners(topology: &crate::mesh::Topology, size: usize) -> Vec<u32> {
    let mut owners = vec![u32::MAX; size * size];
    for t in 0..topology.uv_triangles.len() {
        // On a shared edge both triangles give the same colour.
        let corners = layout(topology, t, size);
        cells(corners, [size; 2], |at| owners[at] = t as u32);
    }
    owners
}

/// Calls `visit` with each cell of a grid whose centre lies in a triangle.
fn cells(corners: [DVec2; 3], [width, height]: [usize; 2], mut visit: impl FnMut(usize)) {
    let low = corners[0].min(corners[1]).min(corners[2]);
    let high = corners[0].max(corners[1]).max(corners[2]);
    let range = |low: f64, high: f64, count: usize| {
        let first = (low - 0.5).ceil().clamp(0.0, count as f64) as usize;
        let end = (high - 0.5).floor().clamp(-1.0, count as f64 - 1.0) + 1.0;
        first..end as usize
    };
    for y in range(low.y, high.y, height) {
        for x in range(low.x, high.x, width) {
            let centre = DVec2::new(x as f64 + 0.5, y as f64 + 0.5);
            if barycentric(corners, centre).iter().all(|&w| w >= -1e-9) {
                visit(y * width + x);
            }
        }
    }
}

/// The image: holes continue what the scan has on top of the smooth colours, more blurred with
/// distance, and what lies between the charts continues them, so that no border shows however the
/// image is filtered.
fn filled(base: Vec<Vec4>, over: Vec<Vec4>, size: usize) -> Vec<[u8; 3]> {
    let over = push_pull(over, size);
    let mut colours = base;
    colours
        .par_iter_mut()
        .zip(over)
        .filter(|(base, _)| base.w > 0.0)
        .for_each(|(base, over)| *base += over.truncate().extend(0.0));
    push_pull(colours, size)
        .into_iter()
        .map(|colour| {
            colour
                .truncate()
                .to_array()
                .map(|c| c.clamp(0.0, 255.0).round() as u8)
        })
        .collect()
}

/// Fills the pixels of weight 0 (the fourth number) from ever coarser means of the others
/// (Gortler et al. 1996, "The lumigraph", push and pull); the others stay.
fn push_pull(mut image: Vec<Vec4>, size: usize) -> Vec<Vec4> {
    if size == 1 {
        return image;
    }
    let half = size.div_ceil(2);
    let coarse: Vec<Vec4> = (0..half * half)
        .into_par_iter()
        .map(|at| {
            let (x, y) = (at % half * 2, at / half * 2);
            let mut sum = Vec4::ZERO;
            for y in y..(y + 2).min(size) {
                for pixel in &image[y * size + x..y * size + (x + 2).min(size)] {
                    sum += (pixel.truncate() * pixel.w).extend(pixel.w);
                }
            }
            match sum.w > 0.0 {
                true => (sum.truncate() / sum.w).extend(sum.w.min(1.0)),
                false => Vec4::ZERO,
            }
        })
        .collect();
    let coarse = push_pull(coarse, half);
    image.par_iter_mut().enumerate().for_each(|(at, pixel)| {
        if pixel.w > 0.0 {
            return;
        }
        let place = |x: usize| {
            let x = (x as f32 / 2.0 - 0.25).clamp(0.0, (half - 1) as f32);
            (x as usize, (x as usize + 1).min(half - 1), x.fract())
        };
        let (left, right, fx) = place(at % size);
        let (top, bottom, fy) = place(at / size);
        let row = |y: usize| coarse[y * half + left].lerp(coarse[y * half + right], fx);
        *pixel = row(top).lerp(row(bottom), fy).truncate().extend(0.0);
    });
    image
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fit::mesh::surface;
    use crate::fit::test_head;

    /// A picture that changes slowly, and the colour that it has at a point of the head.
    const SIZE: usize = 512;

    fn planar(p: DVec3) -> DVec2 {
        (p.truncate() + DVec2::splat(200.0)) / 400.0
    }

    fn colour(uv: DVec2) -> DVec3 {
        DVec3::new(
            40.0 + 150.0 * uv.x,
            200.0 - 120.0 * uv.y,
            90.0 + 60.0 * uv.x * uv.y,
        )
    }

    /// The generic head as a scan of itself, with a texture seen from the front.
    fn scan(template: &Template) -> Scan {
        let triangles = template.part_triangles("skin").expect("has skin");
        let pixels = (0..SIZE * SIZE)
            .map(|at| {
                let uv = DVec2::new((at % SIZE) as f64 + 0.5, (at / SIZE) as f64 + 0.5);
                let uv = uv / SIZE as f64;
                colour(DVec2::new(uv.x, 1.0 - uv.y))
                    .to_array()
                    .map(|c| c.round() as u8)
            })
            .collect();
        Scan {
            positions: template.positions.clone(),
            texture: Some(Texture {
                uvs: template.positions.iter().map(|&p| planar(p)).collect(),
                triangles: triangles.clone(),
                width: SIZE,
                height: SIZE,
                pixels,
            }),
            triangles,
            ..Scan::default()
        }
    }

    fn corner(template: &Template, corner: usize) -> DVec2 {
        let [u, v] = template.topology.uvs[corner];
        DVec2::new(u.into(), v.into())
    }

    #[test]
    fn a_head_has_the_colours_of_its_scan_and_its_own_where_there_is_none() {
        let Some(template) = test_head() else {
            return;
        };
        let scan = scan(template);
        let n = template.positions.len();
        let mut covered = vec![false; n];
        for v in template.part_vertices("skin").expect("has skin") {
            covered[v as usize] = true;
        }
        let nose = template
            .landmarks
            .iter()
            .position(|l| l.name == "ibug_30")
            .map(|i| template.landmark(i, &template.positions))
            .expect("a nose");
        let hole = |v: usize| template.positions[v].distance(nose) < 12.0;
        (0..n).filter(|&v| hole(v)).for_each(|v| covered[v] = false);
        let found = coordinates(&template.positions, &covered, &scan).expect("coordinates");
        for v in 0..n {
            assert_eq!(found[v].is_some(), covered[v]);
            // Where two sheets nearly touch (lips, lids) the other may be nearer by rounding.
            if let Some(uv) = found[v] {
                assert!(uv.distance(planar(template.positions[v])) < 1e-5);
            }
        }
        let baked = bake(template, &template.positions, &covered, &scan, 512).expect("bakes");
        // The border of a scan is not used, and texels are wide beside lids and lips.
        let border = surface::border(n, &scan.triangles);
        let mut ragged = vec![false; n];
        for triangle in scan
            .triangles
            .iter()
            .filter(|t| t.iter().any(|&v| border[v as usize]))
        {
            triangle.iter().for_each(|&v| ragged[v as usize] = true);
        }
        let (mut seams, mut inside, mut far, mut all) = (0, 0, 0, 0);
        for (c, &v) in template.topology.uv_vertices.iter().enumerate() {
            let v = v as usize;
            let texel = baked.sample(corner(template, c));
            let expected = colour(planar(template.positions[v]));
            if covered[v] && !ragged[v] {
                // A texel is some 2 mm of the head wide here, 1/200 of the picture: one of its
                // 150 steps, and two for rounding twice. Lids and nostrils are so narrow in the
                // layout that it is 10 mm there.
                let off = (texel - expected).abs().max_element();
                assert!(off < 15.0, "{v}: {texel} and {expected}");
                far += usize::from(off > 3.0);
                all += 1;
                seams += usize::from(c >= n);
            } else if hole(v) {
                // The tip of a nose differs from its surround by 24 mm of the picture.
                let off = (texel - expected).abs().max_element();
                assert!(off < 40.0, "{v}: {texel} and {expected}");
                inside += 1;
            }
        }
        assert!(seams > 20 && inside > 100);
        assert!(far * 50 < all, "{far} of {all}");
        let bad = bake(template, &template.positions, &covered, &scan, 4);
        assert!(bad.is_err_and(|e| e.to_string().contains("4 x 4")));
        let bare = Scan {
            texture: None,
            ..scan.clone()
        };
        assert!(bake(template, &template.positions, &covered, &bare, 64).is_err());
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(1)
            .build()
            .expect("a pool");
        let alone = pool.install(|| bake(template, &template.positions, &covered, &scan, 512));
        assert_eq!(alone.expect("bakes").pixels, baked.pixels);
    }

    #[test]
    fn filling_keeps_what_is_known_and_invents_no_extremes() {
        let mut random = crate::Random::new(5);
        for size in [1, 2, 7, 32] {
            let image: Vec<Vec4> = (0..size * size)
                .map(|_| match random.uniform() < 0.1 {
                    true => Vec4::new(random.uniform() as f32, 0.5, 0.0, 1.0),
                    false => Vec4::ZERO,
                })
                .collect();
            let filled = push_pull(image.clone(), size);
            let any = image.iter().any(|p| p.w > 0.0);
            for (before, after) in image.iter().zip(&filled) {
                if before.w > 0.0 {
                    assert_eq!(before, after);
                } else if any {
                    assert!((0.0..=1.0).contains(&after.x));
                    // Means of equal numbers, rounded some times.
                    assert!((after.y - 0.5).abs() < 1e-5);
                }
            }
        }
    }

    #[test]
    fn what_lies_between_charts_stays_out_of_smaller_images() {
        // A chart of 100 over a quarter of a black picture; its edge crosses pixels of all levels.
        let chart = |x: usize, y: usize| x < 21 && y < 21;
        let texture = Texture {
            uvs: vec![
                DVec2::Y,
                DVec2::new(21.0 / 64.0, 1.0),
                DVec2::new(0.0, 43.0 / 64.0),
                DVec2::new(21.0, 43.0) / 64.0,
            ],
            triangles: vec![[0, 2, 1], [1, 2, 3]],
            width: 64,
            height: 64,
            pixels: (0..64 * 64)
                .map(|at| [if chart(at % 64, at / 64) { 100 } else { 0 }; 3])
                .collect(),
        };
        let mut level = Level::of(&texture);
        while level.size[0] > 1 {
            for (at, (pixel, inside)) in level.pixels.iter().zip(&level.inside).enumerate() {
                assert_eq!(
                    *pixel,
                    [if *inside { 100 } else { 0 }; 3],
                    "{at} of {:?}",
                    level.size
                );
            }
            level = level.halved();
        }
        assert_eq!(level.pixels[0], [100; 3]);
    }

    #[test]
    fn what_is_beyond_the_picture_is_in_it_again() {
        // The chart from above, elsewhere, and a triangle that goes over the edge of the picture.
        let level = |uvs: [DVec2; 3]| {
            let texture = Texture {
                uvs: uvs.to_vec(),
                triangles: vec![[0, 1, 2]],
                width: 16,
                height: 16,
                pixels: vec![[0; 3]; 16 * 16],
            };
            Level::of(&texture).inside
        };
        let chart = [(0.1, 0.2), (0.9, 0.3), (0.4, 0.8)].map(DVec2::from);
        let here = level(chart);
        assert!(here.iter().filter(|inside| **inside).count() > 30);
        for shift in [(1.0, 0.0), (-3.0, 7.0), (1e6, -1e6)].map(DVec2::from) {
            assert_eq!(level(chart.map(|uv| uv + shift)), here, "{shift}");
        }
        let over = level(chart.map(|uv| uv + DVec2::new(0.5, 0.0)));
        let halves = |row: &[bool]| [&row[8..], &row[..8]].concat();
        let moved: Vec<bool> = here.chunks(16).flat_map(halves).collect();
        assert_eq!(over, moved);
    }

    #[test]
    fn a_picture_is_read_from_its_lower_left_and_repeats() {
        let texture = Texture {
            width: 2,
            height: 2,
            pixels: vec![[10, 0, 0], [20, 0, 0], [30, 0, 0], [40, 0, 0]],
            ..Texture::default()
        };
        for (u, v, red) in [
            (0.0, 0.0, 30.0),
            (1.0, 0.0, 40.0),
            (0.0, 1.0, 10.0),
            (0.5, 0.5, 25.0),
            (1.25, -0.75, 30.0),
        ] {
            assert_eq!(texture.sample(DVec2::new(u, v)).x, red);
        }
    }
}
