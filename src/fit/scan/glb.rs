//! Scans as glTF: binary, or as JSON with its buffers and images in it or beside it.

use std::borrow::Cow;
use std::collections::HashSet;
use std::path::{Path, PathBuf};

use base64ct::{Base64Unpadded, Encoding};
use glam::{DMat4, DVec2, DVec3, Mat4};
use gltf::accessor::{DataType, Dimensions, Item, Iter};
use gltf::json::validation::Checked;
use gltf::mesh::Mode;
use gltf::texture::TextureTransform;

use super::mesh_file::MeshFile;
use crate::fit::format::colours::white;
use crate::fit::format::text::{named, plain};
use crate::fit::{FitError, FitResult};
use crate::srgb;

/// Reads the triangles of all meshes of the default scene, or of all nodes where there is none, moved by their nodes.
pub(super) fn read(path: &Path, pictures: bool) -> FitResult<MeshFile> {
    let fail = |cause: String| FitError::file(path, cause);
    let bytes = std::fs::read(path).map_err(|e| FitError::unread(path, e))?;
    let (json, blob) = chunks(&bytes, path).map_err(fail)?;
    let mut root = parse(&json).map_err(fail)?;
    mend(&mut root).map_err(fail)?;
    let gltf = gltf::Document::from_json(root).map_err(|e| fail(one_line(&e)))?;
    let folder = path.parent().unwrap_or(Path::new(""));
    let buffers = gltf
        .buffers()
        .map(|buffer| match buffer.source() {
            gltf::buffer::Source::Bin => blob
                .clone()
                .ok_or_else(|| fail(format!("buffer {}: no binary chunk", buffer.index()))),
            gltf::buffer::Source::Uri(uri) => load(folder, uri)
                .map(Cow::Owned)
                .map_err(|why| why.of_buffer(path, buffer.index())),
        })
        .collect::<FitResult<Vec<_>>>()?;
    let scene = gltf.default_scene().or_else(|| gltf.scenes().next());
    let roots: Vec<gltf::Node> = match scene {
        Some(scene) => scene.nodes().collect(),
        // Which of its nodes are to be seen a file may leave open: then all are.
        None => {
            let below = gltf.nodes().flat_map(|node| node.children());
            let below: HashSet<usize> = below.map(|node| node.index()).collect();
            let all = gltf.nodes();
            all.filter(|node| !below.contains(&node.index())).collect()
        }
    };
    if roots.is_empty() && gltf.scenes().len() == 0 {
        return Err(fail("no scene".into()));
    }
    let mut reader = Reader {
        buffers,
        folder,
        file: MeshFile {
            beside: beside(&gltf, folder),
            without_pictures: !pictures,
            ..MeshFile::default()
        },
        images: Vec::new(),
        white: 0,
    };
    reader.nodes(roots, gltf.nodes().len()).map_err(fail)?;
    if reader.file.triangles.is_empty() {
        return Err(fail("no mesh in its scene".into()));
    }
    if !reader.file.colours.is_empty() {
        reader.whiten();
    }
    if reader.white > 0 {
        let note = white(reader.white);
        reader.file.notes.push(note);
    }
    Ok(reader.file)
}

/// The JSON, and the bytes that come with it in a binary file.
type Chunks<'a> = (Cow<'a, [u8]>, Option<Cow<'a, [u8]>>);

/// Takes a file apart, as its ending says.
fn chunks<'a>(bytes: &'a [u8], path: &Path) -> Result<Chunks<'a>, String> {
    if path
        .extension()
        .is_some_and(|e| e.eq_ignore_ascii_case("gltf"))
        && !bytes.starts_with(b"glTF")
    {
        return Ok((plain(bytes)?, None));
    }
    if !bytes.starts_with(b"glTF") {
        return Err("does not start with `glTF`: no GLB file".into());
    }
    // The header says how long the file is; what is cut off would pass as an odd chunk.
    if let Some(length) = bytes.get(8..12).and_then(|b| b.try_into().ok()) {
        let length = u32::from_le_bytes(length) as usize;
        if length > bytes.len() {
            return Err(format!("ends after {} of {length} bytes", bytes.len()));
        }
    }
    let glb = gltf::Glb::from_slice(bytes).map_err(|e| one_line(&e))?;
    Ok((glb.json, glb.bin))
}

/// Why a URI stands for nothing: it is none, or the file cannot be read.
enum Unloaded {
    Bad(String),
    Unread(String, std::io::Error),
}

impl Unloaded {
    fn of_buffer(self, gltf: &Path, index: usize) -> FitError {
        match self {
            Unloaded::Bad(cause) => FitError::file(gltf, format!("buffer {index}: {cause}")),
            Unloaded::Unread(uri, e) => {
                let cause = format!("buffer {index}: {uri}: {e}");
                FitError::unread(gltf, std::io::Error::new(e.kind(), cause))
            }
        }
    }
}

impl std::fmt::Display for Unloaded {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Unloaded::Bad(cause) => f.write_str(cause),
            Unloaded::Unread(uri, e) => write!(f, "{uri}: {e}"),
        }
    }
}

/// What a URI of a buffer or an image stands for: data in it, or a file seen from the folder.
fn load(folder: &Path, uri: &str) -> Result<Vec<u8>, Unloaded> {
    if let Some(data) = uri.strip_prefix("data:") {
        let (_, base64) = data
            .split_once(";base64,")
            .ok_or_else(|| Unloaded::Bad("a data URI that is not in base64".into()))?;
        // Not all who write it pad it.
        return Base64Unpadded::decode_vec(base64.trim_end_matches('='))
            .map_err(|e| Unloaded::Bad(format!("a data URI: {e}")));
    }
    if uri.contains("://") {
        return Err(Unloaded::Bad(format!("{uri:.60}: no file beside it")));
    }
    std::fs::read(file(folder, uri)).map_err(|e| Unloaded::Unread(uri.to_owned(), e))
}

/// The file that a URI names.
fn file(folder: &Path, uri: &str) -> PathBuf {
    // Spaces and such are written as %20, though not by everyone.
    let unescaped = named(folder, &unescaped(uri));
    match unescaped.is_file() {
        true => unescaped,
        false => named(folder, uri),
    }
}

/// The files that a document names.
fn beside(gltf: &gltf::Document, folder: &Path) -> Vec<PathBuf> {
    let buffers = gltf.buffers().filter_map(|buffer| match buffer.source() {
        gltf::buffer::Source::Uri(uri) => Some(uri),
        gltf::buffer::Source::Bin => None,
    });
    let images = gltf.images().filter_map(|image| match image.source() {
        gltf::image::Source::Uri { uri, .. } => Some(uri),
        gltf::image::Source::View { .. } => None,
    });
    let in_files = |uri: &&str| !uri.starts_with("data:") && !uri.contains("://");
    let uris = buffers.chain(images).filter(in_files);
    uris.map(|uri| file(folder, uri)).collect()
}

/// A URI with its escaped bytes (`%20`) as they are; what is no text then stays as it was.
fn unescaped(uri: &str) -> Cow<'_, str> {
    let mut bytes = Vec::with_capacity(uri.len());
    let mut rest = uri.as_bytes();
    while let [first, after @ ..] = rest {
        let hex = after.get(..2).and_then(|hex| std::str::from_utf8(hex).ok());
        let byte = hex.and_then(|hex| u8::from_str_radix(hex, 16).ok());
        rest = match byte.filter(|_| *first == b'%') {
            Some(byte) => {
                bytes.push(byte);
                &after[2..]
            }
            None => {
                bytes.push(*first);
                after
            }
        };
    }
    String::from_utf8(bytes).map_or(uri.into(), Cow::Owned)
}

/// Extensions that may be required of who reads a file, but say nothing of its triangles. Of those that
/// begin so, too.
const ASIDE: [&str; 7] = [
    // The crate reads what it allows: integers as positions and texture coordinates.
    "KHR_mesh_quantization",
    "KHR_materials_",
    "KHR_lights_",
    "KHR_texture_basisu",
    "EXT_texture_",
    "KHR_animation_",
    "MSFT_texture_",
];

/// The JSON as the crate has it. Nobody reads animations: what is in them that the crate does not know
/// (channels without a node, pointers) is no reason to refuse a mesh.
fn parse(json: &[u8]) -> Result<gltf::json::Root, String> {
    gltf::json::Root::from_slice(json).or_else(|error| {
        let still = || {
            let mut value: serde_json::Value = serde_json::from_slice(json).ok()?;
            value.as_object_mut()?.remove("animations")?;
            serde_json::from_value(value).ok()
        };
        still().ok_or_else(|| one_line(&error))
    })
}

/// Refuses what the crate's own validation would panic on or does not say in words, and adds what it
/// would miss later.
fn mend(root: &mut gltf::json::Root) -> Result<(), String> {
    let bare = |a: &gltf::json::Accessor| a.buffer_view.is_none() && a.sparse.is_none();
    let mut needed = root.extensions_required.clone();
    // One that is only used has what it stands for beside it; where not, it is required.
    if root.accessors.iter().any(bare) {
        needed.extend(root.extensions_used.iter().cloned());
    }
    for name in &needed {
        let with = match name.as_str() {
            "KHR_draco_mesh_compression" => "Draco",
            "EXT_meshopt_compression" | "KHR_meshopt_compression" => "meshoptimizer",
            _ => continue,
        };
        return Err(format!("compressed with {with}: save it without"));
    }
    root.extensions_required
        .retain(|name| !ASIDE.iter().any(|aside| name.starts_with(aside)));
    let read =
        |name: &&String| !gltf::json::extensions::ENABLED_EXTENSIONS.contains(&name.as_str());
    if let Some(name) = root.extensions_required.iter().find(read) {
        return Err(format!("needs the extension {name}, which is not read"));
    }
    root.animations.clear();
    // Attributes of an application's own (`_NAME`).
    let primitives = root.meshes.iter_mut().flat_map(|m| &mut m.primitives);
    primitives.for_each(|p| p.attributes.retain(|name, _| *name != Checked::Invalid));
    for (index, mesh) in root.meshes.iter().enumerate() {
        let accessors = mesh.primitives.iter().flat_map(|p| p.attributes.values());
        if let Some(bad) = accessors
            .map(|a| a.value())
            .find(|&a| a >= root.accessors.len())
        {
            return Err(format!("mesh {index}: no accessor {bad}"));
        }
    }
    // The bounds of positions, which the crate asks for: not everyone writes them, and nobody here reads them.
    let positions = Checked::Valid(gltf::Semantic::Positions);
    for primitive in root.meshes.iter().flat_map(|m| &m.primitives) {
        if let Some(at) = primitive.attributes.get(&positions) {
            let accessor = &mut root.accessors[at.value()];
            accessor.min = Some(serde_json::json!([0.0, 0.0, 0.0]));
            accessor.max.clone_from(&accessor.min);
        }
    }
    // A texture that is there as WebP alone; where it has another image besides, that shows the same.
    for texture in &mut root.textures {
        let webp = texture.extensions.as_ref();
        let webp = webp.and_then(|all| all.others.get("EXT_texture_webp")?.get("source")?.as_u64());
        if let Some(webp) = webp.and_then(|index| u32::try_from(index).ok())
            && texture.source.value() == u32::MAX as usize
        {
            texture.source = gltf::json::Index::new(webp);
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
    buffers: Vec<Cow<'a, [u8]>>,
    folder: &'a Path,
    file: MeshFile,
    /// The images that were met, with their places in the file where they could be read.
    images: Vec<(usize, Option<usize>)>,
    /// How many vertices are white because they have no colour and others have.
    white: usize,
}

impl Reader<'_> {
    /// Reads the meshes of nodes and of what is below them, of `count` nodes in the file; parents come
    /// first, children in their order. Trees may be as deep as they like, but a node is in one place.
    fn nodes<'n>(&mut self, roots: Vec<gltf::Node<'n>>, count: usize) -> Result<(), String> {
        let mut seen = vec![false; count];
        let roots = roots.into_iter();
        let mut ahead: Vec<(gltf::Node, DMat4)> = roots.map(|n| (n, DMat4::IDENTITY)).collect();
        ahead.reverse();
        let mut skin = None;
        while let Some((node, parent)) = ahead.pop() {
            if std::mem::replace(&mut seen[node.index()], true) {
                return Err(format!(
                    "node {}: in two places, or among its own parents",
                    node.index()
                ));
            }
            let own = Mat4::from_cols_array_2d(&node.transform().matrix());
            let to_scene = parent * own.as_dmat4();
            if let Some(mesh) = node.mesh() {
                skin = skin.or(node.skin().map(|skin| skin.index()));
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
            let children = ahead.len();
            ahead.extend(node.children().map(|child| (child, to_scene)));
            ahead[children..].reverse();
        }
        if let Some(skin) = skin {
            self.file.notes.push(format!(
                "mesh: skin {skin} is there and was not applied: vertices are where they are without joints"
            ));
        }
        Ok(())
    }

    /// Makes the vertices white that have no colour.
    fn whiten(&mut self) {
        let (colours, count) = (&mut self.file.colours, self.file.positions.len());
        self.white += count - colours.len();
        colours.resize(count, [u8::MAX; 3]);
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
        self.readable(&accessor, Dimensions::Vec3, &REALS)?;
        let positions = self.numbers(&accessor, accessor.normalized());
        let positions = positions.ok_or("positions are missing")?;
        let positions: Vec<DVec3> = (positions.into_iter())
            .map(|p| to_scene.transform_point3(DVec3::from_array(p)))
            .collect();
        let count = positions.len() as u32;
        let indices: Vec<u32> = match primitive.indices() {
            None => (0..count).collect(),
            Some(accessor) => {
                let types = [DataType::U8, DataType::U16, DataType::U32];
                self.readable(&accessor, Dimensions::Scalar, &types)?;
                let reader = primitive.reader(|buffer| self.bytes(&buffer));
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
        let picture = match uvs.is_empty() {
            true => None,
            false => self.picture(primitive),
        };
        let colours = self.colours(primitive, count)?;
        // Of meshes that are one scan some may have colours; what has none is white (glTF 2.0, 3.9.2).
        if !colours.is_empty() {
            self.whiten();
            self.file.colours.extend(colours);
        }
        self.file.positions.extend(positions);
        self.file.uvs.extend(uvs);
        for triangle in triangles {
            let uvs = picture.map(|picture| (picture, triangle.map(|v| first_uv + v)));
            self.file.push(triangle.map(|v| first + v), uvs);
        }
        Ok(())
    }

    /// The texture coordinates of the picture, v up; none where there is none.
    fn uvs(&self, primitive: &gltf::Primitive, count: u32) -> Result<Vec<DVec2>, String> {
        let Some(colour) = colour_texture(primitive) else {
            return Ok(Vec::new());
        };
        let moved = colour.texture_transform();
        let set = moved.as_ref().and_then(TextureTransform::tex_coord);
        let set = set.unwrap_or_else(|| colour.tex_coord());
        let Some(accessor) = primitive.get(&gltf::Semantic::TexCoords(set)) else {
            return Ok(Vec::new());
        };
        self.readable(&accessor, Dimensions::Vec2, &REALS)?;
        let uvs = self.numbers(&accessor, accessor.normalized());
        let uvs = uvs.ok_or("texture coordinates are missing")?;
        let uvs: Vec<DVec2> = (uvs.into_iter().map(DVec2::from_array))
            .map(|uv| moved.as_ref().map_or(uv, |moved| transformed(uv, moved)))
            .map(|uv| DVec2::new(uv.x, 1.0 - uv.y))
            .collect();
        match uvs.len() == count as usize {
            true => Ok(uvs),
            false => Err(format!(
                "{} texture coordinates, {count} vertices",
                uvs.len()
            )),
        }
    }

    /// The colours of the vertices; none where there are none.
    fn colours(&self, primitive: &gltf::Primitive, count: u32) -> Result<Vec<[u8; 3]>, String> {
        let Some(accessor) = primitive.get(&gltf::Semantic::Colors(0)) else {
            return Ok(Vec::new());
        };
        let types = [DataType::F32, DataType::U8, DataType::U16];
        // Integers are always parts of all that there is (glTF 2.0, 3.7.2.1), which not everyone writes.
        let colours = match accessor.dimensions() {
            Dimensions::Vec4 => {
                self.readable(&accessor, Dimensions::Vec4, &types)?;
                let colours = self.numbers::<4>(&accessor, true);
                colours.map(|all| all.into_iter().map(|[r, g, b, _]| [r, g, b]).collect())
            }
            _ => {
                self.readable(&accessor, Dimensions::Vec3, &types)?;
                self.numbers::<3>(&accessor, true)
            }
        };
        let colours: Vec<[f64; 3]> = colours.ok_or("colours are missing")?;
        match colours.len() == count as usize {
            // As light, where files of other kinds have sRGB (glTF 2.0, 3.7.2.1).
            true => Ok((colours.into_iter()).map(|c| c.map(srgb::byte)).collect()),
            false => Err(format!("{} colours, {count} vertices", colours.len())),
        }
    }

    /// The primitive's image, among those of the file; the bytes are decoded when it is met first.
    fn picture(&mut self, primitive: &gltf::Primitive) -> Option<usize> {
        if self.file.without_pictures {
            return None;
        }
        let texture = colour_texture(primitive)?.texture();
        let Some(image) = texture.source() else {
            let name = texture.index();
            let note =
                format!("no texture: texture {name} has an image of a kind that is not read");
            if !self.file.notes.contains(&note) {
                self.file.notes.push(note);
            }
            return None;
        };
        let known = self
            .images
            .iter()
            .find(|(index, _)| *index == image.index());
        if let Some((_, picture)) = known {
            return *picture;
        }
        let name = format!("image {}", image.index());
        let picture = match image.source() {
            gltf::image::Source::View { view, .. } => {
                let range = view.offset()..view.offset().saturating_add(view.length());
                let buffer = self.buffers.get(view.buffer().index());
                match buffer.and_then(|buffer| buffer.get(range)) {
                    Some(bytes) => self.file.decode_image(bytes, &name),
                    None => {
                        let note = format!("no texture: {name} reaches beyond its buffer");
                        self.file.notes.push(note);
                        None
                    }
                }
            }
            gltf::image::Source::Uri { uri, .. } => match load(self.folder, uri) {
                Ok(bytes) if uri.starts_with("data:") => self.file.decode_image(&bytes, &name),
                Ok(bytes) => self.file.decode_image(&bytes, uri),
                Err(cause) => {
                    self.file.notes.push(format!("no texture: {cause}"));
                    None
                }
            },
        };
        self.images.push((image.index(), picture));
        picture
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
        let (count, size) = (accessor.count(), accessor.size());
        if count == 0 {
            return Err(format!("accessor {index}: empty"));
        }
        let inside = match accessor.view() {
            Some(view) => self.holds(&view, accessor.offset(), count, size),
            // All zeros but for what is sparse, of which a file could claim any number.
            None => count <= self.buffers.iter().map(|bytes| bytes.len()).sum(),
        };
        let sparse = accessor.sparse().is_none_or(|sparse| {
            let (indices, values) = (sparse.indices(), sparse.values());
            let (count, wide) = (sparse.count(), indices.index_type().size());
            count > 0
                && self.holds(&indices.view(), indices.offset(), count, wide)
                && self.holds(&values.view(), values.offset(), count, size)
        });
        match inside && sparse {
            true => Ok(()),
            false => Err(format!("accessor {index} reaches beyond its buffer")),
        }
    }

    /// Whether a view has so many elements of a size from an offset on, and its buffer has the view.
    fn holds(&self, view: &gltf::buffer::View, offset: usize, count: usize, size: usize) -> bool {
        let stride = view.stride().unwrap_or(size);
        let bytes = (count - 1)
            .checked_mul(stride)
            .and_then(|bytes| bytes.checked_add(size))
            .and_then(|bytes| bytes.checked_add(offset));
        let end = view.offset().checked_add(view.length());
        let held = self.bytes(&view.buffer()).map_or(0, <[u8]>::len);
        // The crate takes it on trust that elements do not overlap.
        stride >= size
            && bytes.is_some_and(|bytes| bytes <= view.length())
            && end.is_some_and(|end| end <= held)
    }

    fn bytes(&self, buffer: &gltf::Buffer) -> Option<&[u8]> {
        self.buffers.get(buffer.index()).map(AsRef::as_ref)
    }

    /// The vectors of an accessor that is [readable](Self::readable), with integers as the file means
    /// them: as they are, or normalised to what 0 to 1 or -1 to 1 is in all of their range.
    fn numbers<const N: usize>(
        &self,
        accessor: &gltf::Accessor,
        normalized: bool,
    ) -> Option<Vec<[f64; N]>>
    where
        [i8; N]: Item,
        [u8; N]: Item,
        [i16; N]: Item,
        [u16; N]: Item,
        [f32; N]: Item,
    {
        let most = match (normalized, accessor.data_type()) {
            (true, DataType::I8) => f64::from(i8::MAX),
            (true, DataType::U8) => f64::from(u8::MAX),
            (true, DataType::I16) => f64::from(i16::MAX),
            (true, DataType::U16) => f64::from(u16::MAX),
            _ => 1.0,
        };
        let integer = |value: f64| match normalized {
            true => (value / most).max(-1.0),
            false => value,
        };
        match accessor.data_type() {
            DataType::I8 => self.each(accessor, |x: i8| integer(x.into())),
            DataType::U8 => self.each(accessor, |x: u8| integer(x.into())),
            DataType::I16 => self.each(accessor, |x: i16| integer(x.into())),
            DataType::U16 => self.each(accessor, |x: u16| integer(x.into())),
            DataType::F32 => self.each(accessor, |x: f32| x.into()),
            DataType::U32 => None,
        }
    }

    fn each<T, const N: usize>(
        &self,
        accessor: &gltf::Accessor,
        number: impl Fn(T) -> f64,
    ) -> Option<Vec<[f64; N]>>
    where
        [T; N]: Item,
    {
        let read = Iter::<[T; N]>::new(accessor.clone(), |buffer| self.bytes(&buffer))?;
        Some(read.map(|vector| vector.map(&number)).collect())
    }
}

/// The picture on a primitive: its base colour, or what that was called before it was in the format itself; or, where
/// vertices have no colours either, the light that it gives off, since many a scan is to be seen as it is, without any
/// other light.
fn colour_texture<'a>(primitive: &gltf::Primitive<'a>) -> Option<gltf::texture::Info<'a>> {
    let material = primitive.material();
    let base = material.pbr_metallic_roughness().base_color_texture();
    let diffuse = || material.pbr_specular_glossiness()?.diffuse_texture();
    let bare = primitive.get(&gltf::Semantic::Colors(0)).is_none();
    let emissive = || material.emissive_texture().filter(|_| bare);
    base.or_else(diffuse).or_else(emissive)
}

/// What positions and texture coordinates may consist of.
const REALS: [DataType; 5] = [
    DataType::F32,
    DataType::I8,
    DataType::U8,
    DataType::I16,
    DataType::U16,
];

/// A texture coordinate, v down, in the part of the picture that is meant (`KHR_texture_transform`). Turning is
/// counter-clockwise as the picture is seen: the extension's first listing had it the other way.
fn transformed(uv: DVec2, to: &TextureTransform) -> DVec2 {
    let (sine, cosine) = f64::from(to.rotation()).sin_cos();
    let pair = |[x, y]: [f32; 2]| DVec2::new(x.into(), y.into());
    let uv = uv * pair(to.scale());
    let turned = DVec2::new(cosine * uv.x + sine * uv.y, cosine * uv.y - sine * uv.x);
    turned + pair(to.offset())
}

fn one_line(error: &dyn std::fmt::Display) -> String {
    error
        .to_string()
        .split_whitespace()
        .collect::<Vec<_>>()
        .join(" ")
}
