//! What mesh files say, before it is a scan.

use std::collections::{BTreeSet, HashMap};
use std::io::Cursor;
use std::path::{Path, PathBuf};

use glam::{DVec2, DVec3};
use image::{DynamicImage, ImageFormat, ImageReader, ImageResult, Limits, RgbImage, imageops};

use super::polygon::triangulate;
use super::{Scan, Texture};
use crate::fit::format::obj::{self, Obj};
use crate::fit::format::text::named;
use crate::fit::format::{colours, ply, stl};
use crate::fit::{FitError, FitResult};

/// A triangle mesh in the units and with the vertices of its file.
#[derive(Default)]
pub(super) struct MeshFile {
    pub positions: Vec<DVec3>,
    /// One a vertex, or none.
    pub colours: Vec<[u8; 3]>,
    pub triangles: Vec<[u32; 3]>,
    pub uvs: Vec<DVec2>,
    /// One a triangle, [`Texture::BARE`] where no image is on it.
    pub uv_triangles: Vec<[u32; 3]>,
    pub images: Vec<RgbImage>,
    /// How often the images were halved so that all of them are not too many pixels.
    pub halvings: u32,
    /// Which of the images is on each triangle; any where none is.
    pub image_of: Vec<usize>,
    pub notes: Vec<String>,
    /// Whether images are left closed, as nobody looks at them.
    pub without_pictures: bool,
    /// What it consists of besides the file itself.
    pub beside: Vec<PathBuf>,
}

/// Reads an OBJ file and what it refers to.
pub(super) fn obj(path: &Path, pictures: bool) -> FitResult<MeshFile> {
    let obj = Obj::read(path)?;
    let mut file = MeshFile {
        notes: obj.notes.clone(),
        without_pictures: !pictures,
        ..MeshFile::default()
    };
    let mut images = obj_images(path, &obj, &mut file);
    file.beside
        .extend(images.iter().map(|(_, image)| image.clone()));
    let ends = obj.runs.iter().skip(1).map(|next| next.first);
    let used = obj.runs.iter().zip(ends.chain([obj.polygons()]));
    let used = used.filter(|(run, end)| run.first < *end);
    let used: BTreeSet<&str> = used.map(|(run, _)| run.material.as_str()).collect();
    let there = images.iter().filter(|(_, image)| image.is_file());
    let there: BTreeSet<&PathBuf> = there.map(|(_, image)| image).collect();
    // Many a scan is passed on without its materials, but with its image; and in some materials have other names than
    // in the file of them.
    let instead = if obj.uvs.is_empty() {
        None
    } else if there.is_empty() {
        file.image_beside(path)
    } else if there.len() == 1 && !images.iter().any(|(m, _)| used.contains(&**m)) {
        there.first().map(|only| {
            let only = (*only).clone();
            let note = format!("texture: {}, because it is the only one", only.display());
            file.notes.push(note);
            only
        })
    } else {
        None
    };
    if let Some(image) = instead {
        images = used
            .iter()
            .map(|m| ((*m).to_owned(), image.clone()))
            .collect();
    }
    // An image is opened when a polygon has it.
    let mut opened: HashMap<PathBuf, Option<usize>> = HashMap::new();
    let mut cut = 0;
    let mut lines = 0;
    let mut points = Vec::new();
    let mut tiled = HashMap::new();
    for (run, polygons) in obj.polygons_of_runs() {
        let named = images
            .iter()
            .find(|(material, _)| *material == run.material);
        let named = named.filter(|_| !polygons.is_empty());
        let named = named.map(|(_, name)| name);
        let is_tiled = named.is_some_and(|name| {
            let known = tiled.entry(name);
            *known.or_insert_with(|| file.is_tiled(path, &obj, &images, name))
        });
        let mut image = None;
        let mut tiles = HashMap::new();
        if let Some(name) = named.filter(|_| !is_tiled) {
            image = file.open_once(name, &mut opened);
        }
        for index in polygons {
            let polygon = obj.polygon(index);
            if let Some(first) = named.filter(|_| is_tiled) {
                image = tile_of(&obj, polygon).and_then(|tile| {
                    *tiles.entry(tile).or_insert_with(|| {
                        let image = obj::tile_image(first, tile);
                        let name = first.display();
                        let note = format!("no texture: some faces are in no tile of {name}");
                        if image.is_none() && !file.notes.contains(&note) {
                            file.notes.push(note);
                        }
                        file.open_once(&image?, &mut opened)
                    })
                });
            }
            lines += usize::from(polygon.len() < 3);
            cut += usize::from(polygon.len() > 3);
            points.clear();
            points.extend(polygon.iter().map(|c| obj.positions[c[0] as usize]));
            for triangle in triangulate(&points) {
                let corners = triangle.map(|i| polygon[i]);
                let uvs = corners.map(|c| c[1]);
                let textured = image.filter(|_| !uvs.contains(&obj::NONE));
                file.push(corners.map(|c| c[0]), textured.map(|image| (image, uvs)));
            }
        }
    }
    file.say_polygons(cut, lines);
    file.colours = obj.colours.iter().copied().map(colours::bytes).collect();
    file.positions = obj.positions;
    file.uvs = obj.uvs;
    Ok(file)
}

/// In which tile of its picture a polygon is, counted to the right and upwards; nothing where a corner has no place.
fn tile_of(obj: &Obj, polygon: &[[u32; 2]]) -> Option<[i64; 2]> {
    let places = polygon.iter().map(|&[_, uv]| obj.uvs.get(uv as usize));
    let sum: DVec2 = places.sum::<Option<DVec2>>()?;
    let middle = sum / polygon.len() as f64;
    let tile = middle.floor();
    middle.is_finite().then_some([tile.x as i64, tile.y as i64])
}

/// The images of an OBJ file's materials. What cannot be read is noted: a scan without its
/// picture is still a scan.
fn obj_images(path: &Path, obj: &Obj, scan: &mut MeshFile) -> Vec<(String, PathBuf)> {
    let folder = path.parent().unwrap_or(Path::new(""));
    let mut images = Vec::new();
    for line in &obj.libraries {
        for file in libraries(folder, line) {
            match obj::read_images(&file) {
                Ok(more) => images.extend(more),
                Err(error) => scan.notes.push(format!("no materials: {error}")),
            }
            scan.beside.push(file);
        }
    }
    images
}

/// The files that a line of libraries names: one whose name may have spaces, or, where that is none, those
/// between the spaces, if any of them is there.
fn libraries(folder: &Path, line: &str) -> Vec<PathBuf> {
    let whole = named(folder, line);
    let parts = || line.split_whitespace().map(|name| named(folder, name));
    match !whole.is_file() && parts().any(|file| file.is_file()) {
        true => parts().collect(),
        false => vec![whole],
    }
}

/// Reads a PLY file and the image that it names.
pub(super) fn ply(path: &Path, pictures: bool) -> FitResult<MeshFile> {
    let ply = ply::read_mesh(path)?;
    let mut file = MeshFile {
        notes: ply.notes,
        without_pictures: !pictures,
        ..MeshFile::default()
    };
    let by_vertex = ply.uvs.len() == ply.positions.len();
    let (mut cut, mut lines) = (0, 0);
    let mut points = Vec::new();
    let has_uvs = by_vertex || ply.faces.iter().any(|face| !face.uvs.is_empty());
    file.uvs = ply.uvs;
    file.triangles.reserve(ply.faces.len());
    let folder = path.parent().unwrap_or(Path::new(""));
    let mut names: Vec<PathBuf> = ply.images.iter().map(|name| named(folder, name)).collect();
    if has_uvs && names.len() < 2 && !names.iter().any(|name| name.is_file()) {
        let beside = file.image_beside(path);
        names = beside.map_or(names, |image| vec![image]);
    }
    // An image is opened when a face has it.
    let mut opened: Vec<Option<Option<usize>>> = vec![None; names.len()];
    for face in &ply.faces {
        lines += usize::from(face.vertices.len() < 3);
        cut += usize::from(face.vertices.len() > 3);
        points.clear();
        points.extend(face.vertices.iter().map(|&v| ply.positions[v as usize]));
        let own = face.uvs.len() == 2 * face.vertices.len() && !face.uvs.is_empty();
        let first = file.uvs.len() as u32;
        if own {
            let uvs = face.uvs.chunks_exact(2).map(DVec2::from_slice);
            file.uvs.extend(uvs);
        }
        let number = usize::try_from(face.image.max(0)).unwrap_or(usize::MAX);
        let image = match names.get(number).filter(|_| own || by_vertex) {
            Some(name) => *opened[number].get_or_insert_with(|| file.open_image(name)),
            None => None,
        };
        for triangle in triangulate(&points) {
            let corners = triangle.map(|i| face.vertices[i]);
            let uvs = match own {
                true => triangle.map(|i| first + i as u32),
                false => corners,
            };
            file.push(corners, image.map(|image| (image, uvs)));
        }
    }
    file.say_polygons(cut, lines);
    file.positions = ply.positions;
    file.colours = ply.colours;
    Ok(file)
}

/// Reads an STL file.
pub(super) fn stl(path: &Path) -> FitResult<MeshFile> {
    let triangles = stl::read(path)?;
    let mut file = MeshFile::default();
    for first in (0..triangles.len() as u32).map(|t| 3 * t) {
        file.push([first, first + 1, first + 2], None);
    }
    file.positions = triangles.into_iter().flatten().collect();
    Ok(file)
}

/// Of a surface with two sides, which faces nowhere, keeps the first of the triangles that have the same corners, in
/// whatever order. How many went: none where it is not most of the surface that has two sides.
fn one_sided(triangles: &mut Vec<[u32; 3]>, uv_triangles: &mut Vec<[u32; 3]>) -> usize {
    let mut order: Vec<([u32; 3], u32)> = (triangles.iter().zip(0..))
        .map(|(&triangle, at)| {
            let mut corners = triangle;
            corners.sort_unstable();
            (corners, at)
        })
        .collect();
    order.sort_unstable();
    let mut again = vec![false; triangles.len()];
    for pair in order.windows(2) {
        again[pair[1].1 as usize] = pair[0].0 == pair[1].0;
    }
    let doubled = again.iter().filter(|&&again| again).count();
    if 4 * doubled < 3 * (triangles.len() - doubled) {
        return 0;
    }
    for list in [&mut *triangles, uv_triangles] {
        let mut again = again.iter();
        list.retain(|_| again.next() == Some(&false));
    }
    doubled
}

/// An image, and images that are one together, have at most so many pixels (400 MB); they are halved until they
/// do.
const MOST_PIXELS: u64 = 1 << 27;

/// An image may take so many bytes as it is decoded: 16384 x 16384 pixels, which scanners write, take 0.8 GB, and
/// 1.1 GB with alpha. Beside that are its file and, for a moment, the half of its sides (0.2 GB), or with alpha what
/// it is without (0.8 GB): 2 GB at the most, of which 0.4 GB stay.
const MOST_BYTES: u64 = (1 << 30) + (1 << 28);

/// Decodes an image of a kind.
fn decoded(bytes: &[u8], kind: ImageFormat) -> ImageResult<DynamicImage> {
    let mut reader = ImageReader::with_format(Cursor::new(bytes), kind);
    let mut limits = Limits::default();
    limits.max_alloc = Some(MOST_BYTES);
    reader.limits(limits);
    reader.decode()
}

/// An image of half the sides.
fn half(image: &RgbImage) -> RgbImage {
    let [width, height] = [image.width(), image.height()].map(|side| side.div_ceil(2));
    imageops::thumbnail(image, width, height)
}

/// An image of at most so many pixels, and how often it was halved for that.
fn within(mut image: RgbImage, most: u64) -> (RgbImage, u32) {
    let mut times = 0;
    while u64::from(image.width()) * u64::from(image.height()) > most {
        image = half(&image);
        times += 1;
    }
    (image, times)
}

/// The size of images above each other, pixels.
fn column(images: &[RgbImage]) -> (u32, u32) {
    let width = images.iter().map(RgbImage::width).max().unwrap_or(0);
    (width, images.iter().map(RgbImage::height).sum())
}

impl MeshFile {
    fn say_polygons(&mut self, cut: usize, lines: usize) {
        if cut > 0 {
            let note = format!("triangles: {cut} polygons were cut into triangles");
            self.notes.push(note);
        }
        if lines > 0 {
            let note = format!("triangles: {lines} faces of fewer than three corners left out");
            self.notes.push(note);
        }
    }

    /// Adds a triangle, with one of the images and its corners' texture coordinates where it has them.
    pub fn push(&mut self, triangle: [u32; 3], textured: Option<(usize, [u32; 3])>) {
        self.triangles.push(triangle);
        let (image, uvs) = textured.unwrap_or((0, Texture::BARE));
        self.image_of.push(image);
        self.uv_triangles.push(uvs);
    }

    /// The image beside a scan that has the scan's name, which is said.
    fn image_beside(&mut self, path: &Path) -> Option<PathBuf> {
        let found = ["jpg", "jpeg", "png", "webp", "tif", "tiff", "bmp", "tga"]
            .iter()
            .flat_map(|ending| [(*ending).to_owned(), ending.to_uppercase()])
            .map(|ending| path.with_extension(ending))
            .find(|image| image.is_file())?;
        let note = format!(
            "texture: {}, because it has the scan's name",
            found.display()
        );
        self.notes.push(note);
        Some(found)
    }

    /// Whether an image is the first of several tiles, by its name and by what is there of those that polygons are in. A
    /// scan that has such a number itself is one of many, and what has the next is another's.
    fn is_tiled(
        &mut self,
        scan: &Path,
        obj: &Obj,
        images: &[(String, PathBuf)],
        first: &Path,
    ) -> bool {
        if obj::tile_image(first, [0, 0]).is_none() || obj::tile_image(scan, [0, 0]).is_some() {
            return false;
        }
        let is_on = |material: &str| images.iter().find(|(m, _)| m == material);
        let mut tiles = BTreeSet::new();
        for (run, polygons) in obj.polygons_of_runs() {
            if is_on(&run.material).is_some_and(|(_, image)| image == first) {
                let polygons = polygons.map(|index| obj.polygon(index));
                tiles.extend(polygons.filter_map(|polygon| tile_of(obj, polygon)));
            }
        }
        tiles.remove(&[0, 0]);
        let others = tiles
            .iter()
            .filter_map(|&tile| obj::tile_image(first, tile));
        let others: Vec<PathBuf> = others.collect();
        let is_tiled = others.iter().any(|image| image.is_file());
        if let Some(missing) = others.first().filter(|_| !is_tiled) {
            let (first, missing) = (first.display(), missing.display());
            let note = format!("texture: {first} is repeated, as {missing} is not there");
            self.notes.push(note);
        }
        is_tiled
    }

    /// The same once for each image.
    fn open_once(
        &mut self,
        name: &Path,
        opened: &mut HashMap<PathBuf, Option<usize>>,
    ) -> Option<usize> {
        if let Some(&image) = opened.get(name) {
            return image;
        }
        let image = self.open_image(name);
        opened.insert(name.to_owned(), image);
        image
    }

    /// Opens an image: its place among the scan's. Where that fails it has none and says so.
    fn open_image(&mut self, name: &Path) -> Option<usize> {
        self.beside.push(name.to_owned());
        if self.without_pictures {
            return None;
        }
        match std::fs::read(name) {
            Ok(bytes) => self.decode_image(&bytes, &name.display().to_string()),
            Err(e) => {
                let note = format!("no texture: {}: {e}", name.display());
                self.notes.push(note);
                None
            }
        }
    }

    /// Decodes an image, PNG, JPEG, WebP, TIFF or BMP, or TGA by the ending of its name: its place among the scan's.
    pub fn decode_image(&mut self, bytes: &[u8], name: &str) -> Option<usize> {
        let kind = image::guess_format(bytes).or_else(|e| {
            // A TGA file does not say that it is one.
            let tga = Path::new(name).extension();
            let tga = tga.is_some_and(|ending| ending.eq_ignore_ascii_case("tga"));
            tga.then_some(ImageFormat::Tga).ok_or(e)
        });
        match kind.and_then(|kind| decoded(bytes, kind)) {
            Ok(image) => {
                let (width, height) = (image.width(), image.height());
                let (image, times) = within(image.into_rgb8(), MOST_PIXELS);
                if times > 0 {
                    let by = 1 << times;
                    let note = format!(
                        "texture: {name}: {width} x {height} pixels, sides divided by {by}"
                    );
                    self.notes.push(note);
                }
                Some(self.take_image(image, MOST_PIXELS))
            }
            Err(e) => {
                self.notes.push(format!("no texture: {name}: {e}"));
                None
            }
        }
    }

    /// Takes one more image: its place among them, which are halved alike until they have at most so many
    /// pixels together.
    fn take_image(&mut self, image: RgbImage, most: u64) -> usize {
        let image = (0..self.halvings).fold(image, |image, _| half(&image));
        self.images.push(image);
        let pixels = |images: &[RgbImage]| -> u64 {
            let (width, height) = column(images);
            u64::from(width) * u64::from(height)
        };
        while pixels(&self.images) > most {
            for image in &mut self.images {
                *image = half(image);
            }
            self.halvings += 1;
        }
        self.images.len() - 1
    }

    /// Puts several images above each other into one. What repeats an image within a triangle ends at
    /// its edge.
    fn join_images(&mut self) {
        if self.images.len() < 2 {
            return;
        }
        let mut note = format!("texture: {} images as one", self.images.len());
        if self.halvings > 0 {
            note += &format!(", sides divided by {}", 1_u64 << self.halvings);
        }
        self.notes.push(note);
        let (width, height) = column(&self.images);
        let mut joined = RgbImage::new(width, height);
        let mut tops = Vec::with_capacity(self.images.len());
        let mut top = 0;
        for image in &self.images {
            tops.push(top);
            imageops::replace(&mut joined, image, 0, i64::from(top));
            top += image.height();
        }
        let all = DVec2::new(width.into(), height.into());
        for (uvs, &image) in self.uv_triangles.iter_mut().zip(&self.image_of) {
            let corners = uvs.map(|uv| self.uvs.get(uv as usize).copied());
            let [Some(a), Some(b), Some(c)] = corners else {
                *uvs = Texture::BARE;
                continue;
            };
            // Images repeat, and numbers of some images begin at others than 0. By the middle, which no rounding moves
            // into the tile beside.
            let tile = ((a + b + c) / 3.0).floor();
            let size = DVec2::new(
                self.images[image].width().into(),
                self.images[image].height().into(),
            );
            let lowest = all.y - f64::from(tops[image]) - size.y;
            let first = self.uvs.len() as u32;
            self.uvs.extend([a, b, c].map(|uv| {
                let own = (uv - tile).clamp(DVec2::ZERO, DVec2::ONE);
                (own * size + DVec2::new(0.0, lowest)) / all
            }));
            *uvs = [first, first + 1, first + 2];
        }
        self.images = vec![joined];
    }

    /// A scan in the file's units: vertices at the same place are one, all of them are used, every
    /// triangle has an area, a surface has one side, and there is one image at most.
    ///
    /// # Errors
    /// When there are no vertices or no triangles with an area, or a triangle has a vertex that is not finite.
    pub fn weld(mut self, path: &Path) -> FitResult<Scan> {
        let fail = |cause: &str| Err(FitError::file(path, cause));
        if self.positions.is_empty() {
            return fail("no vertices");
        }
        if self.triangles.is_empty() {
            return fail("no faces: a cloud of points is no scan");
        }
        let corners = || self.triangles.iter().flatten();
        let broken = |v: &&u32| !self.positions[**v as usize].is_finite();
        if let Some(bad) = corners().find(broken) {
            return fail(&format!("vertex {bad} is not finite"));
        }
        self.join_images();
        let beside = std::mem::take(&mut self.beside);
        let mut scan = Scan {
            path: path.to_owned(),
            scale: 1.0,
            beside,
            ..Scan::default()
        };
        let mut used = vec![false; self.positions.len()];
        let mut uv_triangles = Vec::with_capacity(self.triangles.len());
        for (triangle, uvs) in self.triangles.iter().zip(&self.uv_triangles) {
            let [a, b, c] = triangle.map(|v| self.positions[v as usize]);
            let longest = (b - a)
                .length_squared()
                .max((c - b).length_squared())
                .max((a - c).length_squared());
            // Far below what rounding to single precision does to three points on a line.
            if (b - a).cross(c - a).length() <= 1e-9 * longest {
                continue;
            }
            triangle.iter().for_each(|&v| used[v as usize] = true);
            scan.triangles.push(*triangle);
            uv_triangles.push(*uvs);
        }
        if scan.triangles.is_empty() {
            return fail("no triangle has an area");
        }
        let flat = self.triangles.len() - scan.triangles.len();
        let unused = used.iter().filter(|&&used| !used).count();
        let coloured = self.colours.len() == self.positions.len();
        let mut places = HashMap::with_capacity(self.positions.len());
        let mut merged = 0;
        let taken: Vec<u32> = (0..self.positions.len())
            .map(|v| {
                if !used[v] {
                    return u32::MAX;
                }
                // Adding zero makes the two zeros one.
                let p = self.positions[v] + 0.0;
                let new = scan.positions.len() as u32;
                let place = *places.entry(p.to_array().map(f64::to_bits)).or_insert(new);
                if place == new {
                    scan.positions.push(p);
                    scan.colours.extend(coloured.then(|| self.colours[v]));
                } else {
                    merged += 1;
                }
                place
            })
            .collect();
        for triangle in &mut scan.triangles {
            *triangle = triangle.map(|v| taken[v as usize]);
        }
        let doubled = one_sided(&mut scan.triangles, &mut uv_triangles);
        for (count, what) in [
            (flat, "triangles without area left out"),
            (
                doubled,
                "triangles left out that were there twice, or as their other side",
            ),
            (unused, "vertices without triangles left out"),
            (merged, "vertices merged with another at the same place"),
        ] {
            if count > 0 {
                self.notes.push(format!("mesh: {count} {what}"));
            }
        }
        // Texture coordinates that are no number are as good as none.
        for uvs in &mut uv_triangles {
            let sound = |uv: &u32| self.uvs.get(*uv as usize).is_some_and(|uv| uv.is_finite());
            if !uvs.iter().all(sound) {
                *uvs = Texture::BARE;
            }
        }
        let covered = uv_triangles.iter().any(|uvs| *uvs != Texture::BARE);
        let image = self.images.into_iter().next();
        scan.texture = image.filter(|_| covered).map(|image| Texture {
            uvs: self.uvs,
            triangles: uv_triangles,
            width: image.width() as usize,
            height: image.height() as usize,
            pixels: image.pixels().map(|p| p.0).collect(),
        });
        scan.notes = self.notes;
        Ok(scan)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn many_images_are_halved_alike_as_they_come() {
        let mut file = MeshFile::default();
        for (count, halvings) in [(1, 0), (2, 0), (3, 1), (8, 1), (9, 2)] {
            while file.images.len() < count {
                let place = file.images.len();
                let image = RgbImage::from_pixel(8, 8, image::Rgb([place as u8; 3]));
                assert_eq!(file.take_image(image, 2 * 8 * 8), place);
            }
            assert_eq!(file.halvings, halvings, "{count} images");
            for (place, image) in file.images.iter().enumerate() {
                assert_eq!(image.dimensions(), (8 >> halvings, 8 >> halvings));
                assert_eq!(image.get_pixel(0, 0).0, [place as u8; 3]);
            }
        }
        file.join_images();
        assert_eq!(file.images[0].dimensions(), (2, 18));
        assert_eq!(file.notes, ["texture: 9 images as one, sides divided by 4"]);
    }

    #[test]
    fn a_large_image_is_halved_and_not_refused() {
        let image = RgbImage::from_pixel(65, 40, image::Rgb([10, 20, 30]));
        let (small, times) = within(image.clone(), 700);
        assert_eq!((small.dimensions(), times), ((33, 20), 1));
        assert_eq!(small.get_pixel(32, 19).0, [10, 20, 30]);
        assert_eq!(within(image, 65 * 40).1, 0);
        // Of an image that is all head: what is wrong is that no pixels follow, not how many would.
        let mut bytes = Vec::new();
        let pixel = RgbImage::new(1, 1);
        let to = &mut Cursor::new(&mut bytes);
        pixel.write_to(to, ImageFormat::Bmp).expect("writes");
        let said = |side: i32| {
            let mut bytes = bytes.clone();
            bytes[18..22].copy_from_slice(&side.to_le_bytes());
            bytes[22..26].copy_from_slice(&side.to_le_bytes());
            let mut file = MeshFile::default();
            assert_eq!(file.decode_image(&bytes, "skin.bmp"), None);
            file.notes.concat().to_lowercase()
        };
        assert!(!said(16384).contains("limit"), "{}", said(16384));
        assert!(said(32768).contains("limit"), "{}", said(32768));
    }
}
