//! A photo of a face, as if the face had another shape (semantic reshaping, section 4.2).
//!
//! Every spot of the skin that is seen before and after the change moves in the photo as the surface
//! does, and its light changes as its normal does: by the ratio of the new shading to the old, so that
//! pores, beard and make-up stay what they are. What moves is told backwards, for each place of the new
//! photo where in the old one it comes from. Round the face, in hair, background, and what a head hides
//! of itself, the motion fades out smoothly ([`membrane`]), so that nothing tears and nothing is seen
//! twice. Light does so in hair; what is read from behind the person keeps its own, or the person would
//! have a halo. Mouths and eyes that open and shut show what nobody saw ([`openings`]), and nothing comes from outside
//! of the photo ([`border`]).

mod border;
mod membrane;
mod openings;
mod render;

use glam::{DVec2, DVec3, Vec3};

use super::light::bare;
use super::raster::{NOTHING, Raster, barycentric};
use super::sight::BEHIND;
use super::skin::Skin;
use super::{Camera, Detail, Image, Light, Looks, Texture, View, check_mesh};
use crate::{Error, FaceModel, Result};
use border::stay_within;
use membrane::{CHANNELS, Cell, Known};
use openings::{Eye, Mouth, Openings};

/// How a photo changes: on the nodes of a regular grid, linear in between, nothing outside.
#[derive(Debug, Clone, PartialEq)]
pub struct Field {
    /// Where the first node is in the photo, px.
    pub origin: DVec2,
    /// How far apart nodes are, px.
    pub step: f64,
    /// Nodes along x.
    pub columns: usize,
    /// Nodes along y.
    pub rows: usize,
    /// From each node, row by row, to where the photo is read for it, px.
    pub motion: Vec<[f32; 2]>,
    /// By what red, green and blue are multiplied there, in linear light.
    pub gain: Vec<[f32; 3]>,
}

/// Cells along the longer side of the face. A mouth has some 35, an eye 22.
const CELLS: f64 = 130.0;
/// What is farther away from the skin that is known to move than this part of the face's longer side
/// never moves. It is half a head's width.
const REACH: f64 = 0.45;
/// Of background, what is farther away from the person than this never moves.
const BACKGROUND_REACH: f64 = 0.12;
/// Beyond the person light fades out within so many cells: a person's edge in a mask is off by as much.
const HALO: f32 = 3.0;
/// Skin is trusted where the cosine of the angle at which it is seen is above the first, wholly above the
/// second.
const FACING: [f64; 2] = [0.3, 0.5];
/// Cells from the edge of what is trusted to where it is wholly.
const EDGE: f32 = 4.0;
/// The weight of what is trusted wholly: jumps are spread over half a cell.
const TRUST: f32 = 4.0;
/// The weight of what must not move.
const HELD: f32 = 1e3;
/// The weight of the inside of the mouth, which moves as a whole: over some six cells it gives way to
/// what lips do.
const INSIDE: f32 = 0.03;
/// The weight of what is in an opening that opens or shuts: it gives way over a cell or two.
const OPENING: f32 = 0.5;
/// The least and the greatest factor of light: what is beyond is a wrong normal, not a shape.
const GAIN: [f64; 2] = [0.75, 1.0 / 0.75];
/// Shadows are never wholly black: a part of the light from the front that is everywhere.
const FILL: f64 = 0.1;
/// Farther than anything is, fifths of a cell.
const FARTHEST: u16 = u16::MAX / 2;
/// Motion below this, px, is none.
const STILL: f32 = 1e-3;

/// A photo of a face whose shape can be changed.
#[derive(Debug, Clone)]
pub struct Edit {
    model: FaceModel,
    /// The photo's, px.
    size: [u32; 2],
    /// The photo's.
    camera: Camera,
    /// One whose pixels are the cells.
    own: Camera,
    light: Option<Light>,
    /// The face in the photo.
    positions: Vec<DVec3>,
    normals: Vec<Vec3>,
    /// Where its vertices are, cells.
    seen: Vec<DVec2>,
    triangles: Vec<[u32; 3]>,
    /// Of each triangle.
    kinds: Vec<Kind>,
    openings: Openings,
    grid: Grid,
    /// What is seen of the face in the photo, cell by cell.
    raster: Raster,
    reached: Reached,
    /// The same while nobody tells the background.
    untold: Reached,
}

/// What a change reaches, cell by cell.
#[derive(Debug, Clone)]
struct Reached {
    /// The cells that never move.
    far: Vec<bool>,
    /// How much of a change of light each cell of the photo takes, 0 to 1.
    lit: Vec<f32>,
}

/// What a triangle is for an edit.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Kind {
    /// Skin that is not under hair.
    Bare,
    /// The same of lids.
    Lid,
    /// The inside of the mouth.
    Mouth,
    Eyeball,
    /// What is behind lids, and their rims.
    Socket,
    Other,
}

/// Where cells are in the photo: the middle of cell (0, 0) is at `origin`, px.
#[derive(Debug, Clone, Copy)]
struct Grid {
    origin: DVec2,
    step: f64,
    columns: usize,
    rows: usize,
}

impl Grid {
    /// Around a face, within a photo.
    fn new(low: DVec2, high: DVec2, size: DVec2) -> Option<Self> {
        let extent = (high - low).max_element();
        if !(extent > 0.0 && extent.is_finite()) {
            return None;
        }
        let step = extent / CELLS;
        // Half a cell more than the photo, so that all of its pixels are between nodes.
        let low = (low - REACH * extent).max(DVec2::splat(-0.5 * step));
        let high = (high + REACH * extent).min(size + 0.5 * step);
        let count = ((high - low) / step).ceil();
        (count.min_element() > 1.0).then(|| Self {
            origin: low,
            step,
            columns: count.x as usize + 1,
            rows: count.y as usize + 1,
        })
    }

    /// The middle of a cell, in cells.
    fn cell(&self, at: usize) -> DVec2 {
        DVec2::new((at % self.columns) as f64, (at / self.columns) as f64) + 0.5
    }

    /// A camera whose pixels are the cells.
    fn camera(&self, camera: &Camera) -> Camera {
        Camera {
            focal: camera.focal / self.step,
            centre: (camera.centre - self.origin) / self.step + 0.5,
            ..*camera
        }
    }
}

impl Edit {
    /// Of a photo of `size` px and the face in it (positions in mm, unit normals, as the camera of the
    /// fit sees them); without light only the shape changes.
    ///
    /// # Errors
    /// When the mesh is not the model's, the face is not in the photo, or no camera or light has these numbers: a
    /// focal length above 0, a rotation, and none that is not finite.
    pub fn new(
        model: &FaceModel,
        camera: &Camera,
        size: [u32; 2],
        light: Option<Light>,
        positions: &[Vec3],
        normals: &[Vec3],
    ) -> Result<Self> {
        let parts = model.parts();
        check_mesh(positions.len(), normals.len(), parts.mean.len())?;
        camera.check()?;
        let mut lights = light.iter().flat_map(|l| l.coefficients.as_flattened());
        if !lights.all(|c| c.is_finite()) {
            return Err(Error::Mismatch("a light has only finite numbers".into()));
        }
        let topology = &parts.topology;
        let triangles = topology.triangles();
        let bare = bare(model);
        let mut on_face = vec![false; positions.len()];
        bare.iter().for_each(|&v| on_face[v as usize] = true);
        let openings = Openings::of(model);
        let mut kinds = vec![Kind::Other; triangles.len()];
        for part in &topology.parts {
            let range = part.first as usize..(part.first + part.count) as usize;
            for (kind, corners) in kinds[range.clone()].iter_mut().zip(&triangles[range]) {
                let all = |which: &[bool]| corners.iter().all(|&v| which[v as usize]);
                *kind = match part.name.as_str() {
                    "skin" if all(&on_face) && all(&openings.lids) => Kind::Lid,
                    "skin" if all(&on_face) => Kind::Bare,
                    "mouth cavity" => Kind::Mouth,
                    "left eyeball" | "right eyeball" => Kind::Eyeball,
                    "eye cavities" => Kind::Socket,
                    _ => Kind::Other,
                };
            }
        }
        let positions: Vec<DVec3> = positions.iter().map(|p| p.as_dvec3()).collect();
        let (mut low, mut high) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
        for &v in &bare {
            let at = camera.project(positions[v as usize]);
            (low, high) = (low.min(at), high.max(at));
        }
        let extent = DVec2::new(f64::from(size[0]), f64::from(size[1]));
        let grid = Grid::new(low, high, extent)
            .ok_or_else(|| Error::Mismatch("no face is seen in the photo".into()))?;
        let own = grid.camera(camera);
        let raster = Raster::new(&own, [grid.columns, grid.rows], &positions, &triangles);
        let face = |at: usize| {
            let triangle = raster.triangles[at];
            triangle != NOTHING && matches!(kinds[triangle as usize], Kind::Bare | Kind::Lid)
        };
        let away = distances(grid.columns, grid.rows, face);
        // Hair stands farther out, so this is for a photo of which nobody tells the background.
        let on_head = distances(grid.columns, grid.rows, |at| {
            raster.triangles[at] != NOTHING
        });
        let reach = (5.0 * REACH * CELLS) as u16;
        let untold = Reached {
            far: away.into_iter().map(|away| away >= reach).collect(),
            lit: on_head.into_iter().map(lit).collect(),
        };
        Ok(Self {
            reached: untold.clone(),
            untold,
            seen: positions.iter().map(|&p| own.project(p)).collect(),
            raster,
            model: model.clone(),
            size,
            camera: *camera,
            own,
            light,
            positions,
            normals: normals.to_vec(),
            triangles,
            kinds,
            openings,
            grid,
        })
    }

    /// Tells what is background, by an image of the size that the photo was opened with: then only what is
    /// near the person moves, and all of the person is lit as the face is. What an earlier image told is forgotten.
    ///
    /// # Errors
    /// When the image has another size.
    pub fn set_background(&mut self, image: &Image) -> Result<()> {
        image.check_size(self.size)?;
        let Grid {
            origin,
            step,
            columns,
            rows,
        } = self.grid;
        let away = distances(columns, rows, |at| {
            let cell = DVec2::new((at % columns) as f64, (at / columns) as f64);
            image.pixel(origin + cell * step).is_some()
        });
        let reach = (5.0 * BACKGROUND_REACH * CELLS) as u16;
        self.reached = self.untold.clone();
        // Where there is nobody the image tells nothing.
        if away.contains(&0) {
            for (far, &away) in self.reached.far.iter_mut().zip(&away) {
                *far |= away >= reach;
            }
            self.reached.lit = away.into_iter().map(lit).collect();
        }
        Ok(())
    }

    /// How the photo changes when the face has another shape; `None` when it has not.
    ///
    /// # Errors
    /// When the mesh is not the model's.
    pub fn field(&self, positions: &[Vec3], normals: &[Vec3]) -> Result<Option<Field>> {
        check_mesh(positions.len(), normals.len(), self.positions.len())?;
        let moved: Vec<DVec3> = positions.iter().map(|p| p.as_dvec3()).collect();
        if moved == self.positions {
            return Ok(None);
        }
        let mut cells = self.known(&moved, normals).extend();
        self.stay_in_photo(&mut cells);
        self.keep_background(&mut cells);
        Ok(self.field_of(cells))
    }

    /// The colours of the head in the photo, as its light shows them, with a side of `size` texels: in finer
    /// pixels where there are some.
    ///
    /// # Errors
    /// When no light is known, the image is not of the photo's size, or the texture's is not from 64 to 4096.
    pub fn texture(&self, image: &Image, detail: Option<&Detail>, size: usize) -> Result<Texture> {
        self.texture_with(image, detail, &[], size)
    }

    /// The same with other photos of the person, which are seen where they show the skin better.
    ///
    /// # Errors
    /// As of [`Edit::texture`], and as of [`Texture::of`] for the others.
    pub fn texture_with(
        &self,
        image: &Image,
        detail: Option<&Detail>,
        others: &[View],
        size: usize,
    ) -> Result<Texture> {
        image.check_size(self.size)?;
        let view = View {
            camera: &self.camera,
            light: self.light()?,
            positions: &self.positions,
            normals: &self.normals,
            image: *image,
            detail: detail.copied(),
        };
        Texture::of(&self.model, &view, others, size)
    }

    /// What the photo tells of the person beside the shape; `irises` are the middles of those of the subject's right and left eye, px, if
    /// they are known.
    ///
    /// # Errors
    /// When no light is known.
    pub fn looks(&self, image: &Image, irises: Option<[DVec2; 2]>) -> Result<Looks> {
        image.check_size(self.size)?;
        let mesh = (&self.positions[..], &self.normals[..]);
        Looks::of(
            &self.model,
            &self.camera,
            self.light()?,
            mesh,
            image,
            irises,
        )
    }

    /// The albedo that a photo of the size that this one has shows at mixes of three vertices, linear light in its white
    /// balance, and how well that is seen, 0 to 1: 0 behind the head, glasses, a mask or hair.
    ///
    /// # Errors
    /// When no light is known, or there is no such vertex.
    pub fn albedos(&self, image: &Image, places: &[([u32; 3], [f64; 3])]) -> Result<Vec<[f64; 4]>> {
        image.check_size(self.size)?;
        let count = self.positions.len();
        if let Some(v) = (places.iter().flat_map(|p| p.0)).find(|&v| v as usize >= count) {
            return Err(Error::Mismatch(format!("there is no vertex {v}")));
        }
        let mesh = (&self.positions[..], &self.normals[..]);
        let skin = Skin::new(&self.model, &self.camera, self.light()?, mesh, image)?;
        let each = places.iter().map(|&(corners, shares)| {
            let (albedo, sight) = skin.shown(corners.map(|v| v as usize), shares);
            let [r, g, b] = albedo.to_array();
            [r, g, b, sight]
        });
        Ok(each.collect())
    }

    fn light(&self) -> Result<&Light> {
        self.light.as_ref().ok_or_else(|| {
            Error::Mismatch("without the light on it nobody knows a face's colours".into())
        })
    }

    /// What is known of the cells' motion and of the logarithm of their gain.
    fn known(&self, moved: &[DVec3], normals: &[Vec3]) -> Known {
        let Grid { columns, rows, .. } = self.grid;
        let seen: Vec<DVec2> = moved.iter().map(|&p| self.own.project(p)).collect();
        let raster = Raster::new(&self.own, [columns, rows], moved, &self.triangles);
        let mouth = self.openings.mouth(&self.own, &self.positions, moved);
        let eyes = self.openings.eyes(&self.own, &self.positions, moved);
        let eye = self.camera.position();
        let mut known = Known::new(columns, rows);
        for at in 0..columns * rows {
            let triangle = raster.triangles[at];
            if triangle == NOTHING {
                continue;
            }
            let corners = self.triangles[triangle as usize].map(|v| v as usize);
            let here = self.grid.cell(at);
            let kind = self.kinds[triangle as usize];
            (known.weights[at], known.values[at]) = match kind {
                Kind::Other | Kind::Socket => continue,
                Kind::Mouth => match &mouth {
                    Some(mouth) => inside(mouth, here),
                    None => continue,
                },
                Kind::Eyeball => eyeball(nearest(&eyes, here)),
                Kind::Bare | Kind::Lid => {
                    let share = barycentric(here, corners.map(|v| seen[v]));
                    let blend = |from: &[DVec3]| mix(share, corners.map(|v| from[v]));
                    let before = blend(&self.positions);
                    let after = blend(moved);
                    let old = mix(share, corners.map(|v| self.normals[v].as_dvec3()));
                    let new = mix(share, corners.map(|v| normals[v].as_dvec3()));
                    let facing =
                        |n: DVec3, p: DVec3| n.normalize_or_zero().dot((eye - p).normalize());
                    let trust =
                        |least: f64| ((least - FACING[0]) / (FACING[1] - FACING[0])).min(1.0);
                    let motion =
                        (0..3).map(|i| (self.seen[corners[i]] - seen[corners[i]]) * share[i]);
                    let mut motion: DVec2 = motion.sum();
                    let lid = match kind {
                        Kind::Lid => nearest(&eyes, here).filter(|eye| eye.shut > 0.0),
                        _ => None,
                    };
                    let mut line = 0.0;
                    if let Some(eye) = lid {
                        (motion, line) = eye.lid(here, motion);
                    }
                    let depth = self.own.to_camera(before).z;
                    let is_behind = depth > self.raster.depth(here + motion) + BEHIND;
                    let now = facing(new, after);
                    let both = trust(now.min(facing(old, before)));
                    let (trust, gain) = match lid {
                        _ if both > 0.0 && !is_behind => {
                            let [old, new] = [old, new].map(DVec3::normalize_or_zero);
                            (both, self.gain(old, new))
                        }
                        // What was folded away is read from the skin that it was folded into.
                        Some(eye) => (trust(now).max(eye.shut), DVec3::ZERO),
                        None => continue,
                    };
                    let gain = gain + line;
                    let value = [motion.x, motion.y, gain.x, gain.y, gain.z];
                    ((f64::from(TRUST) * trust) as f32, value.map(|x| x as f32))
                }
            };
        }
        self.soften(&mut known, &raster, &eyes);
        known
    }

    /// The logarithm of the new shading over the old.
    fn gain(&self, old: DVec3, new: DVec3) -> DVec3 {
        let Some(light) = &self.light else {
            return DVec3::ZERO;
        };
        let fill = light.coefficients.map(|c| FILL * c[0].abs().max(1e-6));
        let shade = |normal: DVec3| light.shade(normal) + DVec3::from_array(fill);
        let ratio = shade(new) / shade(old);
        ratio
            .clamp(DVec3::splat(GAIN[0]), DVec3::splat(GAIN[1]))
            .ln()
    }

    /// Trust grows from the edges of what is trusted; far away from it nothing moves.
    fn soften(&self, known: &mut Known, raster: &Raster, eyes: &[Eye]) {
        let Grid { columns, rows, .. } = self.grid;
        let trusted: Vec<bool> = known.weights.iter().map(|&w| w > INSIDE).collect();
        let inside = distances(columns, rows, |at| !trusted[at]);
        // The edge itself is mixed with what is beside it.
        let grown = |inside: u16| ((f32::from(inside) / 5.0 - 1.0) / EDGE).clamp(0.0, 1.0);
        let kind = |at: usize| self.kinds.get(raster.triangles[at] as usize);
        // Lids that meet have no edge between them.
        let shut = eyes.iter().any(|eye| eye.shut > 0.0).then(|| {
            distances(columns, rows, |at| {
                !trusted[at] && !matches!(kind(at), Some(Kind::Lid | Kind::Socket | Kind::Eyeball))
            })
        });
        for at in 0..columns * rows {
            if trusted[at] {
                let mut trust = grown(inside[at]);
                if let (Some(shut), Some(Kind::Lid)) = (&shut, kind(at))
                    && let Some(eye) = nearest(eyes, self.grid.cell(at))
                {
                    trust += eye.shut as f32 * (grown(shut[at]) - trust);
                }
                known.weights[at] *= trust;
            } else if self.reached.far[at] {
                known.weights[at] = HELD;
                known.values[at] = [0.0; CHANNELS];
            }
            for value in &mut known.values[at] {
                *value *= known.weights[at];
            }
        }
    }

    /// Nothing is read from outside of the photo.
    fn stay_in_photo(&self, cells: &mut [Cell]) {
        let Grid {
            origin,
            step,
            columns,
            rows,
        } = self.grid;
        let size = DVec2::from(self.size.map(f64::from));
        let edges = [DVec2::ZERO, size].map(|at| ((at - origin) / step).as_vec2().to_array());
        stay_within(cells, [columns, rows], edges, &self.reached.far);
    }

    /// What is read from behind the person keeps its light.
    fn keep_background(&self, cells: &mut [Cell]) {
        let Grid { columns, rows, .. } = self.grid;
        let most = [columns - 1, rows - 1];
        for (at, cell) in cells.iter_mut().enumerate() {
            let here = [at % columns, at / columns];
            let from: [f32; 2] =
                std::array::from_fn(|i| (here[i] as f32 + cell[i]).clamp(0.0, most[i] as f32));
            let near = from.map(|x| x as usize);
            let next: [usize; 2] = std::array::from_fn(|i| (near[i] + 1).min(most[i]));
            let [right, down] = std::array::from_fn(|i| from[i] - near[i] as f32);
            let along = |y: usize| {
                let [left, other] = [near[0], next[0]].map(|x| self.reached.lit[y * columns + x]);
                left + right * (other - left)
            };
            let [upper, lower] = [near[1], next[1]].map(along);
            let lit = upper + down * (lower - upper);
            cell[2..].iter_mut().for_each(|gain| *gain *= lit);
        }
    }

    /// The field of what cells do; `None` when none does anything.
    fn field_of(&self, cells: Vec<Cell>) -> Option<Field> {
        let Grid { columns, rows, .. } = self.grid;
        let step = self.grid.step as f32;
        let still = |cell: &Cell| {
            let motion = cell[0].abs().max(cell[1].abs()) * step;
            let gain = cell[2..].iter().fold(0.0_f32, |most, g| most.max(g.abs()));
            // A five hundredth of light is half a step of a byte.
            motion < STILL && gain < 2e-3
        };
        if cells.iter().all(still) {
            return None;
        }
        let each = cells.iter().map(|cell| match still(cell) {
            true => ([0.0; 2], [1.0; 3]),
            false => (
                [cell[0] * step, cell[1] * step],
                [cell[2].exp(), cell[3].exp(), cell[4].exp()],
            ),
        });
        let (motion, gain) = each.unzip();
        Some(Field {
            origin: self.grid.origin,
            step: self.grid.step,
            columns,
            rows,
            motion,
            gain,
        })
    }
}

/// How a cell of the inside of the mouth is known: it moves as a whole, unless lips part.
fn inside(mouth: &Mouth, here: DVec2) -> (f32, Cell) {
    let (motion, gain) = mouth.read(here);
    let open = mouth.open;
    let motion = mouth.hold().lerp(motion, open).as_vec2();
    let gain = (gain * open) as f32;
    let weight = INSIDE + open as f32 * (OPENING - INSIDE);
    (weight, [motion.x, motion.y, gain, gain, gain])
}

/// The eye that a place is of.
fn nearest(eyes: &[Eye], here: DVec2) -> Option<&Eye> {
    let away = |eye: &&Eye| eye.middle().distance_squared(here);
    eyes.iter().min_by(|a, b| away(a).total_cmp(&away(b)))
}

/// How a cell of an eyeball is known: where lids go over it, it stays.
fn eyeball(eye: Option<&Eye>) -> (f32, Cell) {
    eye.map_or((0.0, [0.0; CHANNELS]), |eye| {
        let motion = eye.motion().as_vec2();
        let weight = OPENING * eye.shut as f32;
        (weight, [motion.x, motion.y, 0.0, 0.0, 0.0])
    })
}

/// How much of a change of light is taken so far from a person, fifths of a cell.
fn lit(away: u16) -> f32 {
    let t = (1.0 - f32::from(away) / (5.0 * HALO)).max(0.0);
    t * t * (3.0 - 2.0 * t)
}

fn mix(share: [f64; 3], corners: [DVec3; 3]) -> DVec3 {
    corners[0] * share[0] + corners[1] * share[1] + corners[2] * share[2]
}

/// The distance of each cell to the nearest of some, fifths of a cell, to within a twentieth (chamfer of
/// 5 and 7, Borgefors 1986); [`FARTHEST`] when there are none.
fn distances(columns: usize, rows: usize, is_one: impl Fn(usize) -> bool) -> Vec<u16> {
    // A border of its own, so that every cell has all of its neighbours.
    let width = columns + 2;
    let mut far = vec![FARTHEST; width * (rows + 2)];
    for y in 0..rows {
        for x in 0..columns {
            if is_one(y * columns + x) {
                far[(y + 1) * width + x + 1] = 0;
            }
        }
    }
    let steps = [(1, 5), (width + 1, 7), (width, 5), (width - 1, 7)];
    let inner = || (1..=rows).flat_map(|y| (1..=columns).map(move |x| y * width + x));
    for at in inner() {
        let least = steps.map(|(back, length)| far[at - back] + length);
        far[at] = least.into_iter().fold(far[at], u16::min);
    }
    for at in inner().rev() {
        let least = steps.map(|(ahead, length)| far[at + ahead] + length);
        far[at] = least.into_iter().fold(far[at], u16::min);
    }
    inner().map(|at| far[at]).collect()
}
