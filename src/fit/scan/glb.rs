//! Scans as binary glTF.

use std::path::Path;

use glam::{DMat4, DVec2, DVec3, Mat4};
use gltf::accessor::{DataType, Dimensions};
use gltf::mesh::Mode;

use super::Texture;
use super::mesh_file::MeshFile;
use crate::fit::{FitError, FitResult};

/// Deeper trees of nodes are taken for cycles.
const DEEPEST: usize = 64;

/// Reads the triangles of all meshes of the default scene, moved by their nodes.
pub(super) fn read(path: &Path) -> FitResult<MeshFile> {
    let fail = |cause: String| FitError::file(path, cause);
    let bytes = std::fs::read(path).map_err(|e| FitError::file(path, e))?;
    if !bytes.starts_with(b"glTF") {
        return Err(fail("does not start with `glTF`: no GLB file".into()));
    }
    // The header says how long the file is; what is cut off would pass as an odd chunk.
    if let Some(length) = bytes.get(8..12).and_then(|b| b.try_into().ok()) {
        let length = u32::from_le_bytes(length) as usize;
        if length > bytes.len() {
            return Err(fail(format!(
                "ends after {} of {length} bytes",
                bytes.len()
            )));
        }
    }
    let glb = gltf::Glb::from_slice(&bytes).map_err(|e| fail(one_line(&e)))?;
    let mut root = gltf::json::Root::from_slice(&glb.json).map_err(|e| fail(one_line(&e)))?;
    mend(&mut root).map_err(fail)?;
    let gltf = gltf::Document::from_json(root).map_err(|e| fail(one_line(&e)))?;
    let blob = glb.bin.map(|bin| bin.into_owned());
    let folder = path.parent().unwrap_or(Path::new(""));
    let buffers = gltf
        .buffers()
        .map(|buffer| match buffer.source() {
            gltf::buffer::Source::Bin => blob
                .clone()
                .ok_or_else(|| fail(format!("buffer {}: no binary chunk", buffer.index()))),
            gltf::buffer::Source::Uri(uri) => std::fs::read(folder.join(uri))
                .map_err(|e| fail(format!("buffer {}: {uri}: {e}", buffer.index()))),
        })
        .collect::<FitResult<Vec<_>>>()?;
    let scene = gltf.default_scene().or_else(|| gltf.scenes().next());
    let scene = scene.ok_or_else(|| fail("no scene".into()))?;
    let mut reader = Reader {
        buffers,
        folder,
        file: MeshFile::default(),
        image: None,
        others: 0,
    };
    for node in scene.nodes() {
        reader.node(&node, DMat4::IDENTITY, 0).map_err(fail)?;
    }
    if let Some((_, name)) = &reader.image {
        reader.file.say_others(reader.others, Path::new(name));
    }
    if reader.file.triangles.is_empty() {
        return Err(fail("no mesh in its scene".into()));
    }
    Ok(reader.file)
}

/// Refuses what the crate's own validation would panic on, and adds what it would miss later.
fn mend(root: &mut gltf::json::Root) -> Result<(), String> {
    for (index, mesh) in root.meshes.iter().enumerate() {
        let accessors = mesh.primitives.iter().flat_map(|p| p.attributes.values());
        if let Some(bad) = accessors
            .map(|a| a.value())
            .find(|&a| a >= root.accessors.len())
        {
            return Err(format!("mesh {index}: no accessor {bad}"));
        }
    }
    for (index, image) in root.images.iter_mut().enumerate() {
        match (&image.buffer_view, &image.uri) {
            (None, None) => return Err(format!("image {index}: neither bytes nor a file")),
            // What the bytes are is seen by themselves.
            (Some(_), _) if image.mime_type.is_none() => {
                image.mime_type = Some(gltf::json::image::MimeType("image/png".into()));
            }
            _ => {}
        }
    }
    Ok(())
}

struct Reader<'a> {
    buffers: Vec<Vec<u8>>,
    folder: &'a Path,
    file: MeshFile,
    /// The image in use, and its name.
    image: Option<(usize, String)>,
    /// Triangles with another image.
    others: usize,
}

impl Reader<'_> {
    fn node(&mut self, node: &gltf::Node, parent: DMat4, depth: usize) -> Result<(), String> {
        if depth > DEEPEST {
            return Err(format!("node {}: its parents go round", node.index()));
        }
        let own = Mat4::from_cols_array_2d(&node.transform().matrix());
        let to_scene = parent * own.as_dmat4();
        if let Some(mesh) = node.mesh() {
            for primitive in mesh.primitives() {
                self.primitive(&primitive, to_scene).map_err(|cause| {
                    format!(
                        "mesh {}, primitive {}: {cause}",
                        mesh.index(),
                        primitive.index()
                    )
                })?;
            }
        }
        for child in node.children() {
            self.node(&child, to_scene, depth + 1)?;
        }
        Ok(())
    }

    fn primitive(&mut self, primitive: &gltf::Primitive, to_scene: DMat4) -> Result<(), String> {
        let mode = primitive.mode();
        if !matches!(
            mode,
            Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan
        ) {
            return Ok(());
        }
        let first = self.file.positions.len() as u32;
        let accessor = primitive
            .get(&gltf::Semantic::Positions)
            .ok_or("no positions")?;
        self.readable(&accessor, Dimensions::Vec3, &[DataType::F32])?;
        let reader = primitive.reader(|buffer| self.buffers.get(buffer.index()).map(Vec::as_slice));
        let positions = reader.read_positions().ok_or("positions are missing")?;
        let positions: Vec<DVec3> = positions
            .map(|p| to_scene.transform_point3(DVec3::from_array(p.map(f64::from))))
            .collect();
        let count = positions.len() as u32;
        let indices: Vec<u32> = match primitive.indices() {
            None => (0..count).collect(),
            Some(accessor) => {
                let types = [DataType::U8, DataType::U16, DataType::U32];
                self.readable(&accessor, Dimensions::Scalar, &types)?;
                let read = reader.read_indices().ok_or("indices are missing")?;
                read.into_u32().collect()
            }
        };
        if let Some(bad) = indices.iter().find(|&&v| v >= count) {
            return Err(format!("index {bad}, and there are {count} vertices"));
        }
        let mut triangles: Vec<[u32; 3]> = match mode {
            Mode::TriangleStrip => indices
                .windows(3)
                .enumerate()
                .map(|(i, t)| match i % 2 {
                    0 => [t[0], t[1], t[2]],
                    _ => [t[1], t[0], t[2]],
                })
                .collect(),
            Mode::TriangleFan => indices
                .get(1..)
                .unwrap_or_default()
                .windows(2)
                .map(|t| [indices[0], t[0], t[1]])
                .collect(),
            _ => indices
                .chunks_exact(3)
                .map(|t| [t[0], t[1], t[2]])
                .collect(),
        };
        // A node that mirrors turns its triangles too (glTF 2.0, 3.7.4).
        if to_scene.determinant() < 0.0 {
            triangles.iter_mut().for_each(|t| t.swap(1, 2));
        }
        let uvs = self.uvs(primitive, count)?;
        let first_uv = self.file.uvs.len() as u32;
        let textured = !uvs.is_empty() && self.takes_image(primitive, triangles.len());
        self.file.positions.extend(positions);
        self.file.uvs.extend(uvs);
        for triangle in triangles {
            self.file.triangles.push(triangle.map(|v| first + v));
            self.file.uv_triangles.push(match textured {
                true => triangle.map(|v| first_uv + v),
                false => Texture::BARE,
            });
        }
        Ok(())
    }

    /// The texture coordinates of the base colour, v up; none where there is none.
    fn uvs(&self, primitive: &gltf::Primitive, count: u32) -> Result<Vec<DVec2>, String> {
        let colour = primitive
            .material()
            .pbr_metallic_roughness()
            .base_color_texture();
        let Some(set) = colour.map(|texture| texture.tex_coord()) else {
            return Ok(Vec::new());
        };
        let Some(accessor) = primitive.get(&gltf::Semantic::TexCoords(set)) else {
            return Ok(Vec::new());
        };
        let types = [DataType::F32, DataType::U8, DataType::U16];
        self.readable(&accessor, Dimensions::Vec2, &types)?;
        let reader = primitive.reader(|buffer| self.buffers.get(buffer.index()).map(Vec::as_slice));
        let uvs = reader
            .read_tex_coords(set)
            .ok_or("texture coordinates are missing")?;
        let uvs: Vec<DVec2> = uvs
            .into_f32()
            .map(|[u, v]| DVec2::new(u.into(), 1.0 - f64::from(v)))
            .collect();
        match uvs.len() == count as usize {
            true => Ok(uvs),
            false => Err(format!(
                "{} texture coordinates, {count} vertices",
                uvs.len()
            )),
        }
    }

    /// Whether the primitive has the image in use; the first there is comes into use.
    fn takes_image(&mut self, primitive: &gltf::Primitive, triangles: usize) -> bool {
        let material = primitive.material();
        let colour = material.pbr_metallic_roughness().base_color_texture();
        let Some(image) = colour.map(|info| info.texture().source()) else {
            return false;
        };
        if let Some((used, _)) = self.image {
            let same = used == image.index();
            self.others += if same { 0 } else { triangles };
            return same;
        }
        let name = format!("image {}", image.index());
        match image.source() {
            gltf::image::Source::View { view, .. } => {
                let range = view.offset()..view.offset().saturating_add(view.length());
                let buffer = self.buffers.get(view.buffer().index());
                match buffer.and_then(|buffer| buffer.get(range)) {
                    Some(bytes) => self.file.decode_image(bytes, &name),
                    None => {
                        let note = format!("no texture: {name} reaches beyond its buffer");
                        self.file.notes.push(note);
                    }
                }
            }
            gltf::image::Source::Uri { uri, .. } => match std::fs::read(self.folder.join(uri)) {
                Ok(bytes) => self.file.decode_image(&bytes, uri),
                Err(e) => self.file.notes.push(format!("no texture: {uri}: {e}")),
            },
        }
        self.image = Some((image.index(), name));
        true
    }

    /// Whether an accessor has elements of a kind and lies within its buffer. The crate's readers
    /// take both on trust.
    fn readable(
        &self,
        accessor: &gltf::Accessor,
        dimensions: Dimensions,
        types: &[DataType],
    ) -> Result<(), String> {
        let index = accessor.index();
        if accessor.dimensions() != dimensions || !types.contains(&accessor.data_type()) {
            return Err(format!(
                "accessor {index}: {:?} of {:?} where {dimensions:?} of {types:?} belong",
                accessor.dimensions(),
                accessor.data_type()
            ));
        }
        let Some(view) = accessor.view().filter(|_| accessor.sparse().is_none()) else {
            return Err(format!("accessor {index}: sparse, which is not read"));
        };
        let size = accessor.size();
        let stride = view.stride().unwrap_or(size).max(size);
        let bytes = accessor
            .count()
            .checked_sub(1)
            .and_then(|steps| steps.checked_mul(stride))
            .and_then(|bytes| bytes.checked_add(size))
            .and_then(|bytes| bytes.checked_add(accessor.offset()));
        let end = view.offset().checked_add(view.length());
        let held = self.buffers.get(view.buffer().index()).map_or(0, Vec::len);
        let inside = bytes.is_some_and(|bytes| bytes <= view.length());
        match inside && end.is_some_and(|end| end <= held) {
            true => Ok(()),
            false if accessor.count() == 0 => Err(format!("accessor {index}: empty")),
            false => Err(format!("accessor {index} reaches beyond its buffer")),
        }
    }
}

fn one_line(error: &dyn std::fmt::Display) -> String {
    error
        .to_string()
        .split_whitespace()
        .collect::<Vec<_>>()
        .join(" ")
}
