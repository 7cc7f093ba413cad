//! Faces as binary glTF 2.0. (Scans that come as GLB are read in [`scan`](crate::fit::scan).)

use std::path::Path;

use glam::Vec3;
use serde_json::json;

use super::files::write_atomically;
use crate::Face;
use crate::fit::{FitError, FitResult};

const FLOAT: u32 = 5126;
const UNSIGNED_INT: u32 = 5125;
const UNSIGNED_SHORT: u32 = 5123;

/// Bytes of a buffer, and where what lies in it.
#[derive(Default)]
struct Buffer {
    bytes: Vec<u8>,
    views: Vec<serde_json::Value>,
}

impl Buffer {
    /// Adds the bytes of one accessor and gives its view.
    fn view(&mut self, bytes: &[u8]) -> usize {
        let offset = self.bytes.len();
        self.bytes.extend_from_slice(bytes);
        // Accessors start at multiples of their component's size.
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        self.views
            .push(json!({ "buffer": 0, "byteOffset": offset, "byteLength": bytes.len() }));
        self.views.len() - 1
    }
}

/// Writes a face as a GLB: one mesh in metres with normals, texture coordinates (v down, as glTF
/// has it) and the prescribed colours, whose vertices are the texture corners.
///
/// # Errors
/// When the file cannot be written.
pub fn write_face(path: &Path, face: &Face) -> FitResult<()> {
    let parts = face.model().parts();
    let topology = &parts.topology;
    let at = |of: &[Vec3]| -> Vec<[f32; 3]> {
        let corners = topology.uv_vertices.iter();
        corners.map(|&v| of[v as usize].to_array()).collect()
    };
    let positions: Vec<[f32; 3]> = at(face.positions())
        .iter()
        .map(|p| p.map(|mm| mm / 1000.0))
        .collect();
    let bound = |pick: fn(f32, f32) -> f32| {
        let each = positions.iter().copied();
        each.reduce(|a, b| [0, 1, 2].map(|i| pick(a[i], b[i])))
    };
    let uvs: Vec<[f32; 2]> = topology.uvs.iter().map(|&[u, v]| [u, 1.0 - v]).collect();
    // glTF's colours are linear: with 16 bits dark tones stay apart.
    let colours: Vec<[u16; 4]> = (topology.uv_vertices.iter())
        .map(|&v| {
            let [r, g, b] = topology.colours[v as usize].map(linear);
            [r, g, b, u16::MAX]
        })
        .collect();
    let corners = positions.len();
    let mut buffer = Buffer::default();
    let views = [
        buffer.view(bytemuck::cast_slice(&positions)),
        buffer.view(bytemuck::cast_slice(&at(face.normals()))),
        buffer.view(bytemuck::cast_slice(&uvs)),
        buffer.view(bytemuck::cast_slice(&colours)),
        buffer.view(bytemuck::cast_slice(&topology.uv_triangles)),
    ];
    let root = json!({
        "asset": {
            "version": "2.0",
            "generator": concat!("phiz ", env!("CARGO_PKG_VERSION")),
            "extras": { "model": parts.about.title, "code": face.code() },
        },
        "scene": 0,
        "scenes": [{ "nodes": [0] }],
        "nodes": [{ "mesh": 0, "name": "face" }],
        "meshes": [{
            "name": "face",
            "primitives": [{
                "attributes": { "POSITION": 0, "NORMAL": 1, "TEXCOORD_0": 2, "COLOR_0": 3 },
                "indices": 4,
                "material": 0,
            }],
        }],
        "materials": [{
            "name": "skin",
            "pbrMetallicRoughness": { "metallicFactor": 0.0, "roughnessFactor": 0.6 },
        }],
        "accessors": [
            {
                "bufferView": views[0], "componentType": FLOAT, "count": corners, "type": "VEC3",
                "min": bound(f32::min), "max": bound(f32::max),
            },
            { "bufferView": views[1], "componentType": FLOAT, "count": corners, "type": "VEC3" },
            { "bufferView": views[2], "componentType": FLOAT, "count": corners, "type": "VEC2" },
            {
                "bufferView": views[3], "componentType": UNSIGNED_SHORT, "normalized": true,
                "count": corners, "type": "VEC4",
            },
            {
                "bufferView": views[4], "componentType": UNSIGNED_INT,
                "count": 3 * topology.uv_triangles.len(), "type": "SCALAR",
            },
        ],
        "bufferViews": buffer.views,
        "buffers": [{ "byteLength": buffer.bytes.len() }],
    });
    let text = serde_json::to_vec(&root).map_err(|e| FitError::file(path, e))?;
    let glb = gltf::Glb {
        header: gltf::binary::Header {
            magic: *b"glTF",
            version: 2,
            length: 0, // `to_vec` sets it.
        },
        json: text.into(),
        bin: Some(buffer.bytes.into()),
    };
    let bytes = glb.to_vec().map_err(|e| FitError::file(path, e))?;
    write_atomically(path, &bytes)
}

/// A channel of sRGB as a linear 16-bit one.
fn linear(channel: u8) -> u16 {
    (crate::srgb::light(channel) * f64::from(u16::MAX)).round() as u16
}
