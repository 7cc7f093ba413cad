//! Scans and their landmarks for these tests, as programs write them, and how they are read and refused.

use std::path::Path;

use glam::DVec3;
use phiz::fit::FitResult;
use phiz::fit::head::template::{Landmark, Template};
use phiz::fit::scan::{Scan, check, landmarks};
use phiz::mesh::Topology;

/// A head for these tests: an egg with a nose, 150 x 220 x 190 mm.
pub fn egg() -> (Vec<DVec3>, Vec<[u32; 3]>) {
    const ROWS: u32 = 40;
    const COLUMNS: u32 = 48;
    let mut positions = vec![DVec3::new(0.0, -110.0, 0.0)];
    for row in 1..ROWS {
        let latitude = f64::from(row) / f64::from(ROWS) * std::f64::consts::PI;
        for column in 0..COLUMNS {
            let longitude = f64::from(column) / f64::from(COLUMNS) * std::f64::consts::TAU;
            let ring = latitude.sin();
            let mut p = DVec3::new(
                75.0 * ring * longitude.sin(),
                -110.0 * latitude.cos(),
                95.0 * ring * longitude.cos(),
            );
            if p.z > 0.0 {
                let from_nose = (p.x / 12.0).powi(2) + ((p.y - 5.0) / 20.0).powi(2);
                p.z += 22.0 * (-from_nose).exp();
            }
            positions.push(p);
        }
    }
    positions.push(DVec3::new(0.0, 110.0, 0.0));
    let at = |row: u32, column: u32| match row {
        0 => 0,
        ROWS => (ROWS - 1) * COLUMNS + 1,
        _ => (row - 1) * COLUMNS + column % COLUMNS + 1,
    };
    let mut triangles = Vec::new();
    for row in 0..ROWS {
        for column in 0..COLUMNS {
            let [a, b] = [at(row, column), at(row, column + 1)];
            let [c, d] = [at(row + 1, column), at(row + 1, column + 1)];
            if row > 0 {
                triangles.push([a, b, d]);
            }
            if row + 1 < ROWS {
                triangles.push([a, d, c]);
            }
        }
    }
    (positions, triangles)
}

/// The egg as a generic head, with 68 points on its front.
pub fn template() -> Template {
    let (positions, triangles) = egg();
    let mut front: Vec<u32> = (0..positions.len() as u32)
        .filter(|&v| {
            let p = positions[v as usize];
            p.z > 30.0 && p.y.abs() < 70.0 && v % 3 == 0
        })
        .collect();
    front.truncate(68);
    assert_eq!(front.len(), 68);
    let landmarks = front
        .iter()
        .enumerate()
        .map(|(i, &v)| Landmark {
            name: format!("ibug_{i:02}"),
            stencil: vec![(v, 1.0)],
        })
        .collect();
    Template {
        topology: Topology {
            uvs: vec![[0.0; 2]; positions.len()],
            uv_vertices: (0..positions.len() as u32).collect(),
            uv_triangles: triangles,
            ..Topology::default()
        },
        positions,
        landmarks,
        ..Template::default()
    }
}

pub fn points(template: &Template) -> Vec<DVec3> {
    (0..template.landmarks.len())
        .map(|i| template.landmark(i, &template.positions))
        .collect()
}

pub fn obj(positions: &[DVec3], triangles: &[[u32; 3]]) -> String {
    let mut text = String::new();
    for p in positions {
        text += &format!("v {} {} {}\n", p.x, p.y, p.z);
    }
    for t in triangles {
        text += &format!("f {} {} {}\n", t[0] + 1, t[1] + 1, t[2] + 1);
    }
    text
}

pub fn ply_header(format: &str, vertices: &str, rest: &str) -> String {
    format!(
        "ply\nformat {format} 1.0\nelement vertex {vertices}\nproperty float x\n\
         property float y\nproperty float z\n{rest}end_header\n"
    )
}

pub const FACES: &str = "element face 1\nproperty list uchar int vertex_indices\n";

pub fn json(points: &[DVec3]) -> String {
    let members: Vec<String> = points
        .iter()
        .enumerate()
        .map(|(i, p)| format!("\"ibug_{i:02}\": [{}, {}, {}]", p.x, p.y, p.z))
        .collect();
    format!("{{\n{}\n}}", members.join(",\n"))
}

/// Points as MeshLab saves those that were picked.
pub fn picked(points: &[DVec3], name: impl Fn(usize) -> String) -> String {
    let mut text = "<!DOCTYPE PickedPoints>\n<PickedPoints>\n <DocumentData>\n  <DataFileName name=\"a.obj\"/>\n\
                    \x20 <templateName name=\"\"/>\n </DocumentData>\n"
        .to_owned();
    for (i, p) in points.iter().enumerate() {
        let name = name(i);
        text += &format!(
            " <point x=\"{}\" active=\"1\" name=\"{name}\" y=\"{}\" z=\"{}\"/>\n",
            p.x, p.y, p.z
        );
    }
    text + "</PickedPoints>\n"
}

/// A GLB file of a JSON chunk and a binary one, whose header may claim another length.
pub fn glb(json: &str, binary: &[u8]) -> Vec<u8> {
    let mut json = json.as_bytes().to_vec();
    json.resize(json.len().next_multiple_of(4), b' ');
    let mut chunks = (json.len() as u32).to_le_bytes().to_vec();
    chunks.extend(b"JSON");
    chunks.extend(&json);
    if !binary.is_empty() {
        let padded = binary.len().next_multiple_of(4);
        chunks.extend((padded as u32).to_le_bytes());
        chunks.extend(b"BIN\0");
        chunks.extend(binary);
        chunks.resize(chunks.len() + padded - binary.len(), 0);
    }
    let mut file = b"glTF".to_vec();
    file.extend(2u32.to_le_bytes());
    file.extend((chunks.len() as u32 + 12).to_le_bytes());
    file.extend(chunks);
    file
}

/// The buffer of one triangle of 100 mm: positions and indices.
pub fn triangle_bytes(indices: [u16; 3]) -> Vec<u8> {
    let mut binary: Vec<u8> = [0f32, 0.0, 0.0, 0.1, 0.0, 0.0, 0.0, 0.1, 0.0]
        .iter()
        .flat_map(|x| x.to_le_bytes())
        .collect();
    binary.extend(indices.iter().flat_map(|i| i.to_le_bytes()));
    binary
}

/// One triangle of 100 mm with indices `indices`, in a buffer of `bytes` at `uri`.
pub fn glb_triangle(indices: [u16; 3], bytes: usize, uri: &str) -> Vec<u8> {
    let mut binary = triangle_bytes(indices);
    binary.truncate(bytes);
    let json = format!(
        r#"{{"asset":{{"version":"2.0"}},"scene":0,"scenes":[{{"nodes":[0]}}],
        "nodes":[{{"mesh":0,"translation":[0,1,0]}}],
        "meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}},"indices":1}}]}}],
        "accessors":[{{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3",
        "min":[0,0,0],"max":[0.1,0.1,0]}},
        {{"bufferView":1,"componentType":5123,"count":3,"type":"SCALAR"}}],
        "bufferViews":[{{"buffer":0,"byteLength":36}},
        {{"buffer":0,"byteOffset":36,"byteLength":6}}],
        "buffers":[{{{uri}"byteLength":42}}]}}"#
    );
    glb(&json, &binary)
}

/// A GLB that cannot be read without an extension.
pub fn glb_extended(name: &str) -> Vec<u8> {
    let json = format!(
        r#"{{"asset":{{"version":"2.0"}},"extensionsUsed":["{name}"],"extensionsRequired":["{name}"]}}"#
    );
    glb(&json, &[])
}

/// The triangle as glTF in JSON, whose buffer is at `uri`.
pub fn gltf_triangle(uri: &str) -> Vec<u8> {
    let glb = glb_triangle([0, 1, 2], 0, &format!(r#""uri":"{uri}","#));
    glb[20..].trim_ascii_end().to_vec()
}

/// A binary STL of so many of the egg's triangles.
pub fn stl(triangles: usize) -> Vec<u8> {
    let (positions, all) = egg();
    // Many a binary file begins as one in text.
    let mut bytes = b"solid".to_vec();
    bytes.resize(80, b' ');
    bytes.extend((triangles as u32).to_le_bytes());
    for t in &all[..triangles] {
        bytes.extend([0; 12]);
        let corners = t.map(|v| positions[v as usize].as_vec3().to_array());
        bytes.extend(corners.as_flattened().iter().flat_map(|x| x.to_le_bytes()));
        bytes.extend([0; 2]);
    }
    bytes
}

/// Reads a scan and its landmarks as `register` does; the notes.
pub fn read(
    template: &Template,
    scan: &Path,
    points: Option<&Path>,
) -> FitResult<(Scan, Vec<String>)> {
    let mut scan = Scan::read(scan, None)?;
    let mut notes = Vec::new();
    if let Some(points) = points {
        let points = landmarks::read(points, &mut scan, template)?.points;
        notes = check(&mut scan, &points, template)?;
    }
    notes.extend(scan.notes.clone());
    Ok((scan, notes))
}

pub fn one_line(kind: &str, message: &str, file: &Path, says: &[&str]) {
    println!("{kind:28} {message}");
    assert!(!message.contains('\n'), "{kind}: {message}");
    assert!(message.len() < 400, "{kind}: {message}");
    let start = format!("{}: ", file.display());
    assert!(message.starts_with(&start), "{kind}: {message}");
    for part in says {
        assert!(message.contains(part), "{kind}: no `{part}` in: {message}");
    }
}
