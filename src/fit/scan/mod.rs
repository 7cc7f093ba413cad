//! Scans: unregistered meshes of one person, as other programs write them.

use glam::{DVec2, DVec3};

/// A scan: one person's surface, in mm.
#[derive(Debug, Clone, Default)]
pub struct Scan {
    /// Vertices, mm, in the scan's own pose.
    pub positions: Vec<DVec3>,
    /// Triangles, counter-clockwise from outside.
    pub triangles: Vec<[u32; 3]>,
    /// Texture coordinates and image, where the file has both.
    pub texture: Option<Texture>,
    /// Millimetres in one unit of the file: what its landmarks are multiplied with too.
    pub scale: f64,
    /// What the reader decided by itself, a line each ("units: metres, by the size of ...").
    pub notes: Vec<String>,
}

/// A picture on a mesh.
#[derive(Debug, Clone, Default)]
pub struct Texture {
    /// Texture coordinates, (0, 0) at the lower left of the picture.
    pub uvs: Vec<DVec2>,
    /// The texture coordinates of each triangle's corners.
    pub triangles: Vec<[u32; 3]>,
    /// Pixels a row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// sRGB, row by row from the top.
    pub pixels: Vec<[u8; 3]>,
}
