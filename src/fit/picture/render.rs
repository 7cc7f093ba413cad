//! Draws meshes without a GPU: for pictures of docs and reports.
//!
//! A z-buffer rasteriser in perspective with smooth normals, a colour a vertex or a texture, three
//! lights and supersampling. Light is summed linearly and written as sRGB.

use crate::fit::mesh::surface::normals;
use std::path::Path;

use glam::{DMat3, DVec3};
use rayon::prelude::*;

use image::ImageEncoder;

use crate::fit::format::files::write_atomically;
use crate::fit::head::template::Part;
use crate::fit::scan::Texture;
use crate::fit::{FitError, FitResult};
use crate::srgb;

/// Where a picture is taken from.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Camera {
    /// Position, mm.
    pub eye: DVec3,
    /// The point in the picture's middle, mm.
    pub target: DVec3,
    /// Height of the picture as an angle, degrees.
    pub field_of_view: f64,
}

impl Camera {
    /// A camera at a distance (mm) from `target`, turned to the subject's left by `yaw` and up by
    /// `pitch`, in degrees; a yaw of 0 looks into the face.
    pub fn around(target: DVec3, distance: f64, yaw: f64, pitch: f64) -> Camera {
        let (yaw, pitch) = (yaw.to_radians(), pitch.to_radians());
        let out = DVec3::new(
            yaw.sin() * pitch.cos(),
            pitch.sin(),
            yaw.cos() * pitch.cos(),
        );
        Camera {
            eye: target + out * distance,
            target,
            field_of_view: 22.0,
        }
    }

    /// Columns: right, up and towards the camera.
    fn axes(&self) -> DMat3 {
        let back = (self.eye - self.target).normalize_or(DVec3::Z);
        let right = DVec3::Y.cross(back).normalize_or(DVec3::X);
        DMat3::from_cols(right, back.cross(right), back)
    }

    /// Where a point is in a picture, in pixels from the top left, and 1 / depth; nothing for a
    /// point behind the camera.
    pub fn project(&self, p: DVec3, width: usize, height: usize) -> Option<DVec3> {
        let seen = self.axes().transpose() * (p - self.eye);
        let depth = -seen.z;
        let scale = 0.5 * height as f64 / (0.5 * self.field_of_view.to_radians()).tan();
        (depth > 1e-6 * self.eye.distance(self.target)).then(|| {
            DVec3::new(
                0.5 * width as f64 + scale * seen.x / depth,
                0.5 * height as f64 - scale * seen.y / depth,
                1.0 / depth,
            )
        })
    }
}

/// A mesh to draw.
#[derive(Debug, Clone, Copy)]
pub struct Mesh<'a> {
    /// Vertices, mm.
    pub positions: &'a [DVec3],
    /// Counter-clockwise seen from outside; back faces are not drawn.
    pub triangles: &'a [[u32; 3]],
    /// sRGB, one a vertex.
    pub colours: &'a [[u8; 3]],
    /// What covers the colours where it has coordinates.
    pub texture: Option<&'a Texture>,
    /// Strength of the highlight, 0 to 1.
    pub shine: f64,
}

/// How to draw.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Options {
    /// Width in pixels.
    pub width: usize,
    /// Height in pixels.
    pub height: usize,
    /// Samples along each side of a pixel.
    pub samples: usize,
    /// sRGB.
    pub background: [u8; 3],
    /// The point of view.
    pub camera: Camera,
}

impl Options {
    /// A picture by a camera, 3 x 3 samples, on light grey.
    pub fn new(width: usize, height: usize, camera: Camera) -> Options {
        Options {
            width,
            height,
            samples: 3,
            background: [236, 236, 238],
            camera,
        }
    }
}

/// An sRGB picture, row by row from the top.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Image {
    /// Width in pixels.
    pub width: usize,
    /// Height in pixels.
    pub height: usize,
    /// `width * height` pixels.
    pub pixels: Vec<[u8; 3]>,
}

/// A light at infinity: where it is (from the subject, turned with the camera) and how bright.
const LIGHTS: [([f64; 3], f64); 3] = [
    ([-0.55, 0.65, 0.75], 0.95),
    ([0.85, 0.15, 0.55], 0.34),
    ([0.45, 0.6, -0.8], 0.45),
];

/// Light from everywhere: from below, and what comes on top of that from above.
const AMBIENT: [f64; 2] = [0.10, 0.16];

/// How much of our light falls on a texture: a photograph brings its own along.
const ON_TEXTURE: f64 = 0.35;

/// Draws meshes, the nearest surface in front.
pub fn render(meshes: &[Mesh<'_>], options: &Options) -> Image {
    let samples = options.samples.max(1);
    let (width, height) = (options.width * samples, options.height * samples);
    let axes = options.camera.axes();
    let lights = LIGHTS.map(|(from, power)| {
        let from = axes * DVec3::from_array(from);
        (from.normalize(), power)
    });
    let band = BAND * samples;
    let prepared: Vec<Prepared> = meshes
        .iter()
        .map(|mesh| Prepared::new(mesh, &options.camera, width, height, band))
        .collect();

    let background = options.background.map(srgb::light);
    let rows: Vec<Vec<[u8; 3]>> = (0..options.height)
        .into_par_iter()
        .map(|row| {
            let top = row * samples;
            let mut depth = vec![0.0f64; width * samples];
            let mut light = vec![background; width * samples];
            for (mesh, prepared) in meshes.iter().zip(&prepared) {
                for &triangle in &prepared.rows[top / band] {
                    let share = if textured(mesh, triangle) {
                        ON_TEXTURE
                    } else {
                        1.0
                    };
                    let shade = |at: DVec3, normal: DVec3, colour: DVec3| {
                        let normal = normal.normalize_or_zero();
                        let out = (options.camera.eye - at).normalize();
                        let mut sum = AMBIENT[0] + AMBIENT[1] * (0.5 + 0.5 * normal.y);
                        let mut highlight = 0.0;
                        for (from, power) in lights {
                            // Wrapped a little: skin lets light through.
                            sum += power * ((normal.dot(from) + 0.15) / 1.15).max(0.0);
                            let half = (from + out).normalize_or_zero();
                            highlight += power * normal.dot(half).max(0.0).powi(60);
                        }
                        let sum = 1.0 + share * (sum - 1.0);
                        (colour * sum + DVec3::splat(share * highlight * mesh.shine)).to_array()
                    };
                    prepared.scan(mesh, triangle, top, samples, &mut depth, &mut light, shade);
                }
            }
            (0..options.width)
                .map(|x| {
                    let mut sum = [0.0; 3];
                    for y in 0..samples {
                        for sx in 0..samples {
                            let sample = light[y * width + x * samples + sx];
                            for channel in 0..3 {
                                sum[channel] += sample[channel];
                            }
                        }
                    }
                    sum.map(|s| srgb::byte(s / (samples * samples) as f64))
                })
                .collect()
        })
        .collect();
    Image {
        width: options.width,
        height: options.height,
        pixels: rows.concat(),
    }
}

/// Rows of pixels that share a list of triangles.
const BAND: usize = 8;

struct Prepared {
    /// Vertices in samples from the top left, and 1 / depth; no place when behind the camera.
    screen: Vec<Option<DVec3>>,
    normals: Vec<DVec3>,
    colours: Vec<DVec3>,
    /// The triangles that touch each band.
    rows: Vec<Vec<usize>>,
}

impl Prepared {
    fn new(mesh: &Mesh<'_>, camera: &Camera, width: usize, height: usize, band: usize) -> Prepared {
        let screen: Vec<Option<DVec3>> = mesh
            .positions
            .iter()
            .map(|&p| camera.project(p, width, height))
            .collect();
        let bands = height.div_ceil(band).max(1);
        let mut rows = vec![Vec::new(); bands];
        for (index, triangle) in mesh.triangles.iter().enumerate() {
            let [Some(a), Some(b), Some(c)] = triangle.map(|v| screen[v as usize]) else {
                continue;
            };
            // y runs down on screen, so front faces turn the other way.
            if (b - a).truncate().perp_dot((c - a).truncate()) >= 0.0 {
                continue;
            }
            let low = a.y.min(b.y).min(c.y).max(0.0);
            let high = a.y.max(b.y).max(c.y).min(height as f64 - 1.0);
            if low > high {
                continue;
            }
            for list in &mut rows[low as usize / band..=high as usize / band] {
                list.push(index);
            }
        }
        Prepared {
            screen,
            normals: normals(mesh.positions, mesh.triangles),
            colours: mesh.colours.iter().map(|c| srgb::linear(*c)).collect(),
            rows,
        }
    }

    /// Draws a triangle's samples of the rows `top..top + samples`.
    #[allow(clippy::too_many_arguments)]
    fn scan(
        &self,
        mesh: &Mesh<'_>,
        triangle: usize,
        top: usize,
        samples: usize,
        depth: &mut [f64],
        light: &mut [[f64; 3]],
        shade: impl Fn(DVec3, DVec3, DVec3) -> [f64; 3],
    ) {
        let width = depth.len() / samples;
        let corners = mesh.triangles[triangle].map(|v| v as usize);
        let [Some(a), Some(b), Some(c)] = corners.map(|v| self.screen[v]) else {
            return;
        };
        let textured = textured(mesh, triangle);
        let area = (b - a).truncate().perp_dot((c - a).truncate());
        let left = a.x.min(b.x).min(c.x).max(0.0) as usize;
        let right = (a.x.max(b.x).max(c.x) + 1.0).clamp(0.0, width as f64) as usize;
        for row in 0..samples {
            for x in left..right {
                let p = glam::DVec2::new(x as f64 + 0.5, (top + row) as f64 + 0.5);
                let wa = (b.truncate() - p).perp_dot(c.truncate() - p) / area;
                let wb = (c.truncate() - p).perp_dot(a.truncate() - p) / area;
                let wc = 1.0 - wa - wb;
                if wa < 0.0 || wb < 0.0 || wc < 0.0 {
                    continue;
                }
                // 1 / depth is linear on screen; what belongs to the surface is so after division.
                let nearness = wa * a.z + wb * b.z + wc * c.z;
                let sample = row * width + x;
                if nearness <= depth[sample] {
                    continue;
                }
                depth[sample] = nearness;
                let weights = [wa * a.z, wb * b.z, wc * c.z].map(|w| w / nearness);
                let mix = |of: &[DVec3]| -> DVec3 {
                    corners.iter().zip(weights).map(|(&v, w)| of[v] * w).sum()
                };
                let colour = match mesh.texture.filter(|_| textured) {
                    None => mix(&self.colours),
                    Some(texture) => {
                        let at = texture.triangles[triangle];
                        let uv = (0..3)
                            .map(|i| texture.uvs[at[i] as usize] * weights[i])
                            .sum();
                        texture.sample(uv).map(|c| srgb::decode(c / 255.0))
                    }
                };
                light[sample] = shade(mix(mesh.positions), mix(&self.normals), colour);
            }
        }
    }
}

/// Whether a triangle has a texture.
fn textured(mesh: &Mesh<'_>, triangle: usize) -> bool {
    mesh.texture
        .is_some_and(|texture| texture.triangles[triangle] != Texture::BARE)
}

impl Image {
    /// Draws a dot, even where a surface hides the point; outside the picture nothing happens.
    pub fn dot(&mut self, camera: &Camera, p: DVec3, radius: f64, colour: [u8; 3]) {
        let Some(at) = camera.project(p, self.width, self.height) else {
            return;
        };
        for y in (at.y - radius).floor().max(0.0) as usize..self.height {
            if y as f64 > at.y + radius {
                break;
            }
            for x in (at.x - radius).floor().max(0.0) as usize..self.width {
                if x as f64 > at.x + radius {
                    break;
                }
                if (x as f64 + 0.5 - at.x).hypot(y as f64 + 0.5 - at.y) <= radius {
                    self.pixels[y * self.width + x] = colour;
                }
            }
        }
    }

    /// Lays pictures of one size out in rows of `columns`; the last row is filled with white.
    pub fn grid(images: &[Image], columns: usize) -> FitResult<Image> {
        let first = images
            .first()
            .filter(|_| columns > 0)
            .ok_or_else(|| FitError::Input("a grid of no pictures".into()))?;
        if images
            .iter()
            .any(|i| (i.width, i.height) != (first.width, first.height))
        {
            return Err(FitError::Input(
                "a grid of pictures of several sizes".into(),
            ));
        }
        let (width, height) = (
            first.width * columns,
            first.height * images.len().div_ceil(columns),
        );
        let mut pixels = vec![[255; 3]; width * height];
        for (index, image) in images.iter().enumerate() {
            let (x, y) = (
                index % columns * first.width,
                index / columns * first.height,
            );
            for row in 0..first.height {
                let from = &image.pixels[row * first.width..(row + 1) * first.width];
                let at = (y + row) * width + x;
                pixels[at..at + first.width].copy_from_slice(from);
            }
        }
        Ok(Image {
            width,
            height,
            pixels,
        })
    }

    /// Writes a PNG, whole or not at all.
    pub fn save(&self, path: &Path) -> FitResult<()> {
        write_png(path, [self.width, self.height], &self.pixels)
    }
}

/// Writes sRGB pixels, row by row from the top, as a PNG, whole or not at all.
///
/// # Errors
/// When the file cannot be written.
pub fn write_png(path: &Path, size: [usize; 2], pixels: &[[u8; 3]]) -> FitResult<()> {
    let bytes = png(size, pixels).map_err(|e| FitError::file(path, e))?;
    write_atomically(path, &bytes)
}

/// The bytes of a PNG of sRGB pixels, row by row from the top.
///
/// # Errors
/// When there are other than `width * height` pixels.
pub fn png([width, height]: [usize; 2], pixels: &[[u8; 3]]) -> image::ImageResult<Vec<u8>> {
    let mut bytes = Vec::new();
    image::codecs::png::PngEncoder::new(&mut bytes).write_image(
        pixels.as_flattened(),
        width as u32,
        height as u32,
        image::ExtendedColorType::Rgb8,
    )?;
    Ok(bytes)
}

/// The meshes of a head of the template: skin and cavities matt, with a texture in the template's
/// layout if there is one, and eyeballs wet.
pub fn head<'a>(
    triangles: &'a [[u32; 3]],
    parts: &[Part],
    positions: &'a [DVec3],
    colours: &'a [[u8; 3]],
    texture: Option<&'a Texture>,
) -> [Mesh<'a>; 2] {
    let first = parts.iter().find(|p| p.name.ends_with("eyeball"));
    let at = first.map_or(triangles.len(), |p| p.first as usize);
    let mesh = |triangles, texture, shine| Mesh {
        positions,
        triangles,
        colours,
        texture,
        shine,
    };
    [
        mesh(&triangles[..at], texture, 0.05),
        mesh(&triangles[at..], None, 0.7),
    ]
}

/// A face of the template in given colours: skin and cavities matt, eyeballs wet.
pub fn face(
    triangles: &[[u32; 3]],
    parts: &[Part],
    positions: &[DVec3],
    colours: &[[u8; 3]],
    options: &Options,
) -> Image {
    render(&head(triangles, parts, positions, colours, None), options)
}

#[cfg(test)]
mod tests {
    use super::*;

    const SQUARE: [[u32; 3]; 2] = [[0, 1, 2], [0, 2, 3]];

    fn square(side: f64, z: f64) -> Vec<DVec3> {
        [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)]
            .map(|(x, y)| DVec3::new(x * side, y * side, z))
            .to_vec()
    }

    fn camera() -> Camera {
        Camera::around(DVec3::ZERO, 100.0, 0.0, 0.0)
    }

    #[test]
    fn the_nearer_surface_hides_the_farther_in_either_order() {
        let (near, far) = (square(2.0, 10.0), square(10.0, 0.0));
        let red = Mesh {
            positions: &near,
            triangles: &SQUARE,
            colours: &[[200, 0, 0]; 4],
            texture: None,
            shine: 0.0,
        };
        let blue = Mesh {
            positions: &far,
            colours: &[[0, 0, 200]; 4],
            ..red
        };
        let options = Options::new(40, 40, camera());
        let image = render(&[red, blue], &options);
        assert_eq!(image, render(&[blue, red], &options));
        let [r, _, b] = image.pixels[20 * 40 + 20];
        assert!(r > 100 && b == 0, "red in the middle");
        let [r, _, b] = image.pixels[20 * 40 + 12];
        assert!(b > 100 && r == 0, "blue around it");
        assert_eq!(image.pixels[0], options.background);
    }

    #[test]
    fn back_faces_are_not_drawn() {
        let positions = square(10.0, 0.0);
        let mesh = Mesh {
            positions: &positions,
            triangles: &SQUARE.map(|[a, b, c]| [a, c, b]),
            colours: &[[200, 0, 0]; 4],
            texture: None,
            shine: 0.0,
        };
        let options = Options::new(20, 20, camera());
        let image = render(&[mesh], &options);
        assert!(image.pixels.iter().all(|p| *p == options.background));
    }

    #[test]
    fn a_dot_falls_where_the_surface_is_drawn() {
        // The height of the view at 100 mm is 2 * 100 * tan(11 degrees): half of it is the edge.
        let edge = 100.0 * 11f64.to_radians().tan();
        let at = camera()
            .project(DVec3::new(0.0, edge, 0.0), 40, 40)
            .unwrap();
        assert!((at.x - 20.0).abs() < 1e-9 && at.y.abs() < 1e-9);
        assert!(camera().project(DVec3::Z * 200.0, 40, 40).is_none());
    }

    #[test]
    fn a_grid_wants_pictures_of_one_size() {
        let image = |width| Image {
            width,
            height: 1,
            pixels: vec![[7; 3]; width],
        };
        let grid = Image::grid(&[image(2), image(2), image(2)], 2).unwrap();
        assert_eq!((grid.width, grid.height), (4, 2));
        assert_eq!(grid.pixels[6], [255; 3]);
        assert!(Image::grid(&[image(2), image(3)], 2).is_err());
        assert!(Image::grid(&[], 2).is_err());
    }
}
