//! What mesh files say, before it is a scan.

use std::collections::HashMap;
use std::path::{Path, PathBuf};

use glam::{DVec2, DVec3};

use super::polygon::triangulate;
use super::{Scan, Texture};
use crate::fit::format::obj::{self, Obj};
use crate::fit::format::text::named;
use crate::fit::format::{ply, stl};
use crate::fit::{FitError, FitResult};

/// A triangle mesh in the units and with the vertices of its file.
#[derive(Default)]
pub(super) struct MeshFile {
    pub positions: Vec<DVec3>,
    /// One a vertex, or none.
    pub colours: Vec<[u8; 3]>,
    pub triangles: Vec<[u32; 3]>,
    pub uvs: Vec<DVec2>,
    /// One a triangle, [`Texture::BARE`] where the image is not on it.
    pub uv_triangles: Vec<[u32; 3]>,
    pub image: Option<image::RgbImage>,
    pub notes: Vec<String>,
}

/// Reads an OBJ file and what it refers to.
pub(super) fn obj(path: &Path) -> FitResult<MeshFile> {
    let obj = Obj::read(path)?;
    let mut file = MeshFile::default();
    let mut images = obj_images(path, &obj, &mut file.notes);
    // Many a scan is passed on without its materials, but with its image.
    let beside = match images.is_empty() && !obj.uvs.is_empty() {
        true => file.image_beside(path),
        false => None,
    };
    if let Some(image) = beside {
        let mut materials: Vec<&str> = obj.runs.iter().map(|r| r.material.as_str()).collect();
        materials.sort_unstable();
        materials.dedup();
        images = materials
            .iter()
            .map(|m| ((*m).to_owned(), image.clone()))
            .collect();
    }
    // The first image on any polygon is the scan's; polygons with another are bare.
    let mut chosen: Option<&PathBuf> = None;
    let mut others = 0;
    let mut cut = 0;
    let mut lines = 0;
    let mut points = Vec::new();
    for (r, run) in obj.runs.iter().enumerate() {
        let end = obj
            .runs
            .get(r + 1)
            .map_or(obj.polygons(), |next| next.first);
        let image = images
            .iter()
            .find(|(material, _)| *material == run.material)
            .map(|(_, file)| file);
        if run.first < end && image.is_some() {
            chosen = chosen.or(image);
        }
        let covered = image.is_some() && image == chosen;
        for index in run.first..end {
            let polygon = obj.polygon(index);
            lines += usize::from(polygon.len() < 3);
            cut += usize::from(polygon.len() > 3);
            points.clear();
            points.extend(polygon.iter().map(|c| obj.positions[c[0] as usize]));
            for triangle in triangulate(&points) {
                let corners = triangle.map(|i| polygon[i]);
                file.triangles.push(corners.map(|c| c[0]));
                let uvs = corners.map(|c| c[1]);
                let textured = covered && !uvs.contains(&obj::NONE);
                others += usize::from(image.is_some() && !covered);
                file.uv_triangles
                    .push(if textured { uvs } else { Texture::BARE });
            }
        }
    }
    file.say_polygons(cut, lines);
    if let Some(name) = chosen {
        file.open_image(name);
        file.say_others(others, name);
    }
    file.colours = obj.colours.iter().map(|c| rgb(*c)).collect();
    file.positions = obj.positions;
    file.uvs = obj.uvs;
    Ok(file)
}

/// The images of an OBJ file's materials. What cannot be read is noted: a scan without its
/// picture is still a scan.
fn obj_images(path: &Path, obj: &Obj, notes: &mut Vec<String>) -> Vec<(String, PathBuf)> {
    let folder = path.parent().unwrap_or(Path::new(""));
    let mut images = Vec::new();
    for name in &obj.libraries {
        match obj::read_images(&named(folder, name)) {
            Ok(more) => images.extend(more),
            Err(error) => notes.push(format!("no materials: {error}")),
        }
    }
    images
}

/// Reads a PLY file and the image that it names.
pub(super) fn ply(path: &Path) -> FitResult<MeshFile> {
    let ply = ply::read_mesh(path)?;
    let mut file = MeshFile::default();
    let by_vertex = ply.uvs.len() == ply.positions.len();
    let (mut cut, mut lines, mut others) = (0, 0, 0);
    let mut points = Vec::new();
    file.uvs = ply.uvs;
    file.triangles.reserve(ply.faces.len());
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
        for triangle in triangulate(&points) {
            let corners = triangle.map(|i| face.vertices[i]);
            file.triangles.push(corners);
            others += usize::from(face.image > 0);
            file.uv_triangles.push(match () {
                () if face.image > 0 => Texture::BARE,
                () if own => triangle.map(|i| first + i as u32),
                () if by_vertex => corners,
                () => Texture::BARE,
            });
        }
    }
    file.say_polygons(cut, lines);
    let name = match ply.images.first() {
        Some(name) => Some(named(path.parent().unwrap_or(Path::new("")), name)),
        None if !file.uvs.is_empty() => file.image_beside(path),
        None => None,
    };
    if let Some(name) = name {
        file.open_image(&name);
        file.say_others(others, &name);
    }
    file.positions = ply.positions;
    file.colours = ply.colours;
    Ok(file)
}

/// Reads an STL file.
pub(super) fn stl(path: &Path) -> FitResult<MeshFile> {
    let triangles = stl::read(path)?;
    let corners = (0..triangles.len() as u32).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]);
    Ok(MeshFile {
        triangles: corners.collect(),
        uv_triangles: vec![Texture::BARE; triangles.len()],
        positions: triangles.into_iter().flatten().collect(),
        ..MeshFile::default()
    })
}

fn rgb(colour: DVec3) -> [u8; 3] {
    (colour * 255.0)
        .to_array()
        .map(|c| c.clamp(0.0, 255.0).round() as u8)
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

    pub fn say_others(&mut self, others: usize, name: &Path) {
        if others > 0 && self.image.is_some() {
            let note = format!(
                "texture: only {} is used; {others} triangles have another image",
                name.display()
            );
            self.notes.push(note);
        }
    }

    /// The image beside a scan that has the scan's name, which is said.
    fn image_beside(&mut self, path: &Path) -> Option<PathBuf> {
        let found = ["jpg", "jpeg", "png", "JPG", "JPEG", "PNG"]
            .iter()
            .map(|ending| path.with_extension(ending))
            .find(|image| image.is_file())?;
        let note = format!(
            "texture: {}, because it has the scan's name",
            found.display()
        );
        self.notes.push(note);
        Some(found)
    }

    /// Opens the image; where that fails the scan has none and says so.
    fn open_image(&mut self, name: &Path) {
        match std::fs::read(name) {
            Ok(bytes) => self.decode_image(&bytes, &name.display().to_string()),
            Err(e) => self
                .notes
                .push(format!("no texture: {}: {e}", name.display())),
        }
    }

    /// Decodes a PNG or JPEG image.
    pub fn decode_image(&mut self, bytes: &[u8], name: &str) {
        match image::load_from_memory(bytes) {
            Ok(image) => self.image = Some(image.into_rgb8()),
            Err(e) => self.notes.push(format!("no texture: {name}: {e}")),
        }
    }

    /// A scan in the file's units: vertices at the same place are one, all of them are used, and
    /// every triangle has an area.
    ///
    /// # Errors
    /// When there are no vertices or no triangles with an area, or a vertex is not finite.
    pub fn weld(mut self, path: &Path) -> FitResult<Scan> {
        let fail = |cause: &str| Err(FitError::file(path, cause));
        if self.positions.is_empty() {
            return fail("no vertices");
        }
        if self.triangles.is_empty() {
            return fail("no faces: a cloud of points is no scan");
        }
        if let Some(bad) = self.positions.iter().position(|p| !p.is_finite()) {
            return fail(&format!("vertex {bad} is not finite"));
        }
        let mut scan = Scan {
            path: path.to_owned(),
            scale: 1.0,
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
        for (count, what) in [
            (flat, "triangles without area left out"),
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
        scan.texture = self.image.filter(|_| covered).map(|image| Texture {
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
