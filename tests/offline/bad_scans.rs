//! Bad scans and landmarks, each kind with the one clear line that it gets, and odd ones that are
//! read all the same and said.

use std::fs;
use std::path::{Path, PathBuf};

use base64ct::{Base64, Encoding};
use glam::DVec3;
use phiz::fit::FitResult;
use phiz::fit::head::template::{Landmark, Template};
use phiz::fit::scan::{Scan, check, landmarks};
use phiz::mesh::Topology;

/// A head for these tests: an egg with a nose, 150 x 220 x 190 mm.
fn egg() -> (Vec<DVec3>, Vec<[u32; 3]>) {
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
fn template() -> Template {
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

fn points(template: &Template) -> Vec<DVec3> {
    (0..template.landmarks.len())
        .map(|i| template.landmark(i, &template.positions))
        .collect()
}

fn obj(positions: &[DVec3], triangles: &[[u32; 3]]) -> String {
    let mut text = String::new();
    for p in positions {
        text += &format!("v {} {} {}\n", p.x, p.y, p.z);
    }
    for t in triangles {
        text += &format!("f {} {} {}\n", t[0] + 1, t[1] + 1, t[2] + 1);
    }
    text
}

fn ply_header(format: &str, vertices: &str, rest: &str) -> String {
    format!(
        "ply\nformat {format} 1.0\nelement vertex {vertices}\nproperty float x\n\
         property float y\nproperty float z\n{rest}end_header\n"
    )
}

const FACES: &str = "element face 1\nproperty list uchar int vertex_indices\n";

fn json(points: &[DVec3]) -> String {
    let members: Vec<String> = points
        .iter()
        .enumerate()
        .map(|(i, p)| format!("\"ibug_{i:02}\": [{}, {}, {}]", p.x, p.y, p.z))
        .collect();
    format!("{{\n{}\n}}", members.join(",\n"))
}

/// Points as MeshLab saves those that were picked.
fn picked(points: &[DVec3], name: impl Fn(usize) -> String) -> String {
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
fn glb(json: &str, binary: &[u8]) -> Vec<u8> {
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
fn triangle_bytes(indices: [u16; 3]) -> Vec<u8> {
    let mut binary: Vec<u8> = [0f32, 0.0, 0.0, 0.1, 0.0, 0.0, 0.0, 0.1, 0.0]
        .iter()
        .flat_map(|x| x.to_le_bytes())
        .collect();
    binary.extend(indices.iter().flat_map(|i| i.to_le_bytes()));
    binary
}

/// One triangle of 100 mm with indices `indices`, in a buffer of `bytes` at `uri`.
fn glb_triangle(indices: [u16; 3], bytes: usize, uri: &str) -> Vec<u8> {
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
fn glb_extended(name: &str) -> Vec<u8> {
    let json = format!(
        r#"{{"asset":{{"version":"2.0"}},"extensionsUsed":["{name}"],"extensionsRequired":["{name}"]}}"#
    );
    glb(&json, &[])
}

/// The triangle as glTF in JSON, whose buffer is at `uri`.
fn gltf_triangle(uri: &str) -> Vec<u8> {
    let glb = glb_triangle([0, 1, 2], 0, &format!(r#""uri":"{uri}","#));
    glb[20..].trim_ascii_end().to_vec()
}

/// A binary STL of so many of the egg's triangles.
fn stl(triangles: usize) -> Vec<u8> {
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
fn read(template: &Template, scan: &Path, points: Option<&Path>) -> FitResult<(Scan, Vec<String>)> {
    let mut scan = Scan::read(scan, None)?;
    let mut notes = Vec::new();
    if let Some(points) = points {
        let points = landmarks::read(points, &mut scan, template)?.points;
        notes = check(&mut scan, &points, template)?;
    }
    notes.extend(scan.notes.clone());
    Ok((scan, notes))
}

struct Case {
    kind: &'static str,
    /// The file that is at fault, and what is in it.
    name: &'static str,
    content: Vec<u8>,
    /// What the message says, beside that file's name.
    says: &'static [&'static str],
}

fn case(
    kind: &'static str,
    name: &'static str,
    content: impl Into<Vec<u8>>,
    says: &'static [&'static str],
) -> Case {
    Case {
        kind,
        name,
        content: content.into(),
        says,
    }
}

fn one_line(kind: &str, message: &str, file: &Path, says: &[&str]) {
    println!("{kind:28} {message}");
    assert!(!message.contains('\n'), "{kind}: {message}");
    assert!(message.len() < 400, "{kind}: {message}");
    let start = format!("{}: ", file.display());
    assert!(message.starts_with(&start), "{kind}: {message}");
    for part in says {
        assert!(message.contains(part), "{kind}: no `{part}` in: {message}");
    }
}

#[test]
fn bad_scans_get_one_clear_line() {
    let (positions, triangles) = egg();
    let template = template();
    let v = "v 0 0 0\nv 100 0 0\nv 0 100 0\n";
    let flat = [DVec3::ZERO, DVec3::X * 90.0, DVec3::X * 100.0];
    let vertices: Vec<u8> = [0f32, 0., 0., 100., 0., 0., 0., 100., 0.]
        .iter()
        .flat_map(|x| x.to_le_bytes())
        .collect();
    let mut nan = vertices.clone();
    nan[16..20].copy_from_slice(&f32::NAN.to_le_bytes());
    nan.extend([3, 0, 0, 0, 0, 1, 0, 0, 0, 2, 0, 0, 0]);
    let binary = |header: String, payload: &[u8]| [header.as_bytes(), payload].concat();
    let little = "binary_little_endian";
    let cases = [
        case("empty OBJ", "a.obj", "", &["is empty"]),
        case("empty PLY", "a.ply", "", &["is empty"]),
        case("empty GLB", "a.glb", "", &["is empty"]),
        case("no faces", "a.obj", v, &["no faces"]),
        case("no vertices", "a.obj", "# nothing\n", &["no vertices"]),
        case(
            "NaN",
            "a.obj",
            format!("{v}v 0 nan 0\nf 1 2 4\n"),
            &["line 4", "`nan` is not finite"],
        ),
        case(
            "infinite",
            "a.obj",
            format!("{v}v 0 0 1e999\nf 1 2 4\n"),
            &["line 4", "not finite"],
        ),
        case(
            "text for a number",
            "a.obj",
            "v 0 zero 0\n",
            &["line 1", "`zero` is no number"],
        ),
        case(
            "two numbers",
            "a.obj",
            "v 0 0\n",
            &["line 1", "too few numbers"],
        ),
        case(
            "index out of range",
            "a.obj",
            format!("{v}f 1 2 4\n"),
            &["line 4", "vertex 4"],
        ),
        case(
            "negative index",
            "a.obj",
            format!("{v}f -1 -2 -4\n"),
            &["line 4", "vertex -4"],
        ),
        case(
            "texture index out of range",
            "a.obj",
            format!("{v}f 1/-9 2/1 3/1\n"),
            &["line 4", "texture coordinate -9"],
        ),
        case(
            "faces of two corners",
            "a.obj",
            format!("{v}f 1 2\n"),
            &["no faces"],
        ),
        case(
            "triangles without area",
            "a.obj",
            obj(&flat, &[[0, 1, 2], [0, 0, 1]]),
            &["no triangle has an area"],
        ),
        case(
            "far too small",
            "a.obj",
            obj(
                &[DVec3::ZERO, DVec3::X * 1e-3, DVec3::Y * 1e-3],
                &[[0, 1, 2]],
            ),
            &["1.0000 mm across", "too small"],
        ),
        case(
            "far too large",
            "a.obj",
            obj(
                &[DVec3::ZERO, DVec3::X * 9000.0, DVec3::Y * 9000.0],
                &[[0, 1, 2]],
            ),
            &["too large", "guessed (millimetres", "--unit"],
        ),
        case(
            "garbage",
            "a.obj",
            (0..=255u8).cycle().take(4000).collect::<Vec<_>>(),
            &["line "],
        ),
        case("wrong magic", "a.ply", "solid cube\n", &["no PLY file"]),
        case(
            "bad header",
            "a.ply",
            "ply\nformat ascii 1.0\nelement\nend_header\n",
            &["header"],
        ),
        case(
            "no x",
            "a.ply",
            ply_header("ascii", "1", FACES).replace("float x", "float w") + "1 2 3\n3 0 0 0\n",
            &["element `vertex`", "no property `x`"],
        ),
        case(
            "absurd count",
            "a.ply",
            ply_header(little, "99999999999", FACES),
            &["element `vertex`", "99999999999 of them"],
        ),
        case(
            "cut off among vertices",
            "a.ply",
            binary(ply_header(little, "3", FACES), &vertices[..20]),
            &["element `vertex`", "ends in the middle"],
        ),
        case(
            "cut off among faces",
            "a.ply",
            binary(
                ply_header(little, "3", FACES),
                &[&vertices[..], &[3, 0, 0, 0, 0, 1]].concat(),
            ),
            &["element `face`", "ends in the middle"],
        ),
        case(
            "a list longer than the file",
            "a.ply",
            binary(
                ply_header(little, "3", &FACES.replace("uchar", "uint")),
                &[&vertices[..], &[255; 4]].concat(),
            ),
            &["element `face`"],
        ),
        case(
            "PLY index out of range",
            "a.ply",
            ply_header("ascii", "3", FACES) + "0 0 0\n100 0 0\n0 100 0\n3 0 1 -7\n",
            &["face 0 has vertex -7, of 3"],
        ),
        case(
            "PLY NaN",
            "a.ply",
            ply_header("ascii", "3", FACES) + "0 0 0\n100 nan 0\n0 100 0\n3 0 1 2\n",
            &["vertex 1 is not finite"],
        ),
        case(
            "PLY text for a number",
            "a.ply",
            ply_header("ascii", "3", FACES) + "0 0 0\n100 zero 0\n0 100 0\n3 0 1 2\n",
            &["line 11", "no row of numbers"],
        ),
        case(
            "binary PLY NaN",
            "a.ply",
            binary(ply_header(little, "3", FACES), &nan),
            &["vertex 1 is not finite"],
        ),
        case(
            "PLY points",
            "a.ply",
            ply_header("ascii", "1", "") + "0 0 0\n",
            &["no faces"],
        ),
        case(
            "PLY without vertices",
            "a.ply",
            "ply\nformat ascii 1.0\nelement face 0\nproperty list uchar int vertex_indices\nend_header\n",
            &["no element `vertex`"],
        ),
        case("no GLB", "a.glb", "glTFgarbage here", &["a.glb: "]),
        case(
            "GLB cut off",
            "a.glb",
            glb_triangle([0, 1, 2], 42, "")[..200].to_vec(),
            &["ends after 200 of"],
        ),
        case(
            "GLB without mesh",
            "a.glb",
            glb(
                r#"{"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[]}]}"#,
                &[],
            ),
            &["no mesh"],
        ),
        case(
            "GLB without scene",
            "a.glb",
            glb(r#"{"asset":{"version":"2.0"}}"#, &[]),
            &["no scene"],
        ),
        case(
            "GLB's buffer missing",
            "a.glb",
            glb_triangle([0, 1, 2], 42, r#""uri":"gone.bin","#),
            &["gone.bin", "buffer 0"],
        ),
        case(
            "GLB's buffer short",
            "a.glb",
            glb_triangle([0, 1, 2], 40, ""),
            &["accessor 1 reaches beyond its buffer"],
        ),
        case(
            "GLB index out of range",
            "a.glb",
            glb_triangle([0, 1, 3], 42, ""),
            &["mesh 0, primitive 0", "index 3"],
        ),
        case(
            "Draco",
            "a.glb",
            glb_extended("KHR_draco_mesh_compression"),
            &["compressed with Draco: save it without"],
        ),
        case(
            "meshopt",
            "a.glb",
            glb_extended("EXT_meshopt_compression"),
            &["compressed with meshoptimizer: save it without"],
        ),
        case(
            "an extension of nobody's",
            "a.glb",
            glb_extended("ACME_folding"),
            &["needs the extension ACME_folding"],
        ),
        case("glTF's JSON broken", "a.gltf", "{\"asset\":", &["line 1"]),
        case(
            "glTF's buffer elsewhere",
            "a.gltf",
            gltf_triangle("https://host/a.bin"),
            &["buffer 0", "https://host/a.bin: no file beside it"],
        ),
        case(
            "glTF's data broken",
            "a.gltf",
            gltf_triangle("data:;base64,AAA!"),
            &["buffer 0", "data URI"],
        ),
        case("no STL", "a.stl", "cube", &["no STL file"]),
        case(
            "STL cut off",
            "a.stl",
            stl(2)[..184 - 50].to_vec(),
            &["ends after 1 of 2 triangles"],
        ),
        case(
            "STL text cut off",
            "a.stl",
            "solid\nvertex 0 0 0\nvertex 1 0 0\n",
            &["in the middle of a triangle"],
        ),
        case(
            "STL text for a number",
            "a.stl",
            "solid\nvertex 0 zero 0\n",
            &["line 2", "`zero` is no number"],
        ),
        case(
            "PLY strip out of range",
            "a.ply",
            ply_header("ascii", "3", FACES).replace("face 1", "tristrips 1")
                + "0 0 0\n100 0 0\n0 100 0\n4 0 1 2 9\n",
            &["vertex 9, of 3"],
        ),
        case(
            "half of UTF-16",
            "a.obj",
            vec![0xff, 0xfe, b'v'],
            &["UTF-16"],
        ),
        case(
            "unknown ending",
            "a.fbx",
            "solid",
            &[".obj, .ply, .glb, .gltf and .stl"],
        ),
        case(
            "no ending",
            "a",
            "v 0 0 0",
            &[".obj, .ply, .glb, .gltf and .stl"],
        ),
    ];
    let folder = tempfile::tempdir().expect("a folder");
    for Case {
        kind,
        name,
        content,
        says,
    } in &cases
    {
        let file = folder.path().join(name);
        fs::write(&file, content).expect("written");
        let error = read(&template, &file, None).map(|_| ()).expect_err(kind);
        one_line(kind, &error.to_string(), &file, says);
    }
    let missing = folder.path().join("none.ply");
    let error = Scan::read(&missing, None).expect_err("missing");
    one_line("missing", &error.to_string(), &missing, &["No such file"]);
    let is_folder = folder.path().join("folder.obj");
    fs::create_dir(&is_folder).expect("made");
    let error = Scan::read(&is_folder, None).expect_err("a folder");
    one_line("a folder", &error.to_string(), &is_folder, &["a folder"]);
    assert!(cases.len() + 2 >= 30);
    // The same reader takes what is not bad.
    let file = folder.path().join("a.obj");
    fs::write(&file, obj(&positions, &triangles)).expect("written");
    assert_eq!(
        read(&template, &file, None).expect("reads").0.triangles,
        triangles
    );
}

#[test]
fn bad_landmarks_get_one_clear_line() {
    let template = template();
    let (positions, triangles) = egg();
    let right = points(&template);
    let lines: Vec<String> = right
        .iter()
        .map(|p| format!("{} {} {}", p.x, p.y, p.z))
        .collect();
    let mapped = |f: &dyn Fn(usize, DVec3) -> DVec3| -> String {
        json(
            &right
                .iter()
                .enumerate()
                .map(|(i, &p)| f(i, p))
                .collect::<Vec<_>>(),
        )
    };
    let with = |member: &str| json(&right[..60]).replacen('{', &format!("{{{member},\n"), 1);
    let l = "l.json";
    let cases = [
        case("not JSON", l, "hello", &["line 1 column 1"]),
        case(
            "a JSON list",
            l,
            "[1, 2]",
            &["name -> [x, y, z]", "expected an object at line 1"],
        ),
        case("cut off", l, &json(&right)[..400], &["line "]),
        case(
            "fewer than four",
            l,
            json(&right[..3]),
            &["3 landmarks", "4 are the fewest"],
        ),
        case(
            "unknown name",
            l,
            with("\"ibug_6\": [0, 0, 0]"),
            &["`ibug_6`", "nearest name is `ibug_0"],
        ),
        case(
            "two numbers",
            l,
            with("\"ibug_67\": [0, 0]"),
            &["`ibug_67` has 2 numbers"],
        ),
        case(
            "five numbers",
            l,
            with("\"ibug_67\": [0, 0, 1, 1, 1]"),
            &["`ibug_67` has 5 numbers"],
        ),
        case(
            "less than no error",
            l,
            with("\"ibug_67\": [0, 0, 1, -1]"),
            &["`ibug_67` has an error of -1"],
        ),
        case(
            "text for a number",
            l,
            with("\"ibug_67\": [0, 0, \"x\"]"),
            &["line 1"],
        ),
        case("NaN", l, with("\"ibug_67\": [0, NaN, 0]"), &["line 1"]),
        case(
            "too large a number",
            l,
            with("\"ibug_67\": [0, 1e999, 0]"),
            &["line 1"],
        ),
        case(
            "twice",
            l,
            with("\"ibug_05\": [0, 0, 0]"),
            &["`ibug_05` is there twice"],
        ),
        case(
            "67 lines",
            "l.txt",
            lines[..67].join("\n"),
            &["67 points", "68 iBUG"],
        ),
        case(
            "a bad line",
            "l.txt",
            lines.join("\n").replacen(' ', " x", 1),
            &["line 1", "is no number"],
        ),
        case(
            "two words",
            "l.txt",
            lines.join("\n") + "\n1 2",
            &["line 69", "2 words"],
        ),
        case(
            "NaN in text",
            "l.txt",
            lines.join("\n") + "\n1 2 nan",
            &["line 69", "`nan` is not finite"],
        ),
        case("no text", "l.txt", vec![0xff, 0xfe, 0], &["no text"]),
        case("zeros", "l.txt", vec![0; 40], &["no text"]),
        case(
            "another scheme of menpo's",
            "l.ljson",
            r#"{"version":2,"landmarks":{"points":[[0,0,0]]}}"#,
            &["1 points, not the 68 iBUG points"],
        ),
        case("no ljson", "l.ljson", "{}", &["no landmarks"]),
        case(
            "MeshLab's cut off",
            "l.pp",
            &picked(&right, |i| format!("ibug_{i:02}"))[..400],
            &["no landmarks: ", ":"],
        ),
        case(
            "XML of nobody's",
            "l.pp",
            "<html><body/></html>",
            &["<html>, not <PickedPoints>"],
        ),
        case(
            "picked without a number",
            "l.pp",
            "<PickedPoints>\n<point x=\"1\" y=\"one\" z=\"1\" name=\"ibug_30\"/></PickedPoints>",
            &["line 2: landmark `ibug_30`: `one` is no number"],
        ),
        case(
            "picked without z",
            "l.pp",
            "<PickedPoints>\n<point x=\"1\" y=\"1\" name=\"ibug_30\"/></PickedPoints>",
            &["line 2: landmark `ibug_30` has no z"],
        ),
        case(
            "picked and called anyhow",
            "l.pp",
            picked(&right, |i| format!("nose {i}")),
            &["no landmark is called `nose 0`"],
        ),
        case(
            "picked and some numbered",
            "l.pp",
            picked(&right[..20], |i| i.to_string()),
            &["20 points called 0 to 19", "the 68 iBUG points"],
        ),
        case(
            "in metres",
            l,
            mapped(&|_, p| p / 1000.0),
            &["not in the same units"],
        ),
        case(
            "no face's size",
            l,
            mapped(&|_, p| p * 4.0),
            &["times as far apart"],
        ),
        case(
            "off the surface",
            "a.obj",
            mapped(&|i, p| if i == 30 { p + p.normalize() * 45.0 } else { p }),
            &["`ibug_30`", "mm off the surface"],
        ),
        case(
            "left and right swapped",
            "a.obj",
            mapped(&|_, p| p * DVec3::new(-1.0, 1.0, 1.0)),
            &["mirrored", "left and right"],
        ),
        case(
            "misplaced",
            "a.obj",
            mapped(&|i, p| if i == 30 { -p } else { p }),
            &["`ibug_30`", "from where the other landmarks put it"],
        ),
        case(
            "at one place",
            l,
            mapped(&|_, _| right[0]),
            &["all at one place"],
        ),
        case(
            "on a line",
            l,
            mapped(&|i, _| right[0] + DVec3::Y * i as f64),
            &["on one line"],
        ),
        case(
            "in a plane",
            l,
            mapped(&|_, p| DVec3::new(p.x, p.y, 60.0)),
            &["in one plane"],
        ),
    ];
    let folder = tempfile::tempdir().expect("a folder");
    let scan = folder.path().join("a.obj");
    fs::write(&scan, obj(&positions, &triangles)).expect("written");
    let try_points = |name: &str, content: &[u8]| {
        let file = folder.path().join(name);
        fs::write(&file, content).expect("written");
        read(&template, &scan, Some(&file))
    };
    for Case {
        kind,
        name,
        content,
        says,
    } in &cases
    {
        // What is wrong between scan and landmarks names the scan.
        let file = if *name == "a.obj" { l } else { name };
        let error = try_points(file, content).map(|_| ()).expect_err(kind);
        one_line(kind, &error.to_string(), &folder.path().join(name), says);
    }
    let missing = folder.path().join("none.json");
    let error = read(&template, &scan, Some(&missing))
        .map(|_| ())
        .expect_err("missing");
    one_line("missing", &error.to_string(), &missing, &["No such file"]);
    try_points(l, json(&right).as_bytes()).expect("the right ones are taken");
    try_points("l.txt", lines.join("\n").as_bytes()).expect("as text too");
    // As other programs write them: with marks, letters and ends of lines of other systems, as iBUG and
    // menpo do.
    let marked = |text: &str| [b"\xef\xbb\xbf", text.as_bytes()].concat();
    let wide = json(&right).encode_utf16().collect::<Vec<_>>();
    let wide = [0xfeff].iter().chain(&wide).flat_map(|u| u.to_le_bytes());
    let pts = format!("version: 1\nn_points:  68\n{{\n{}\n}}\n", lines.join("\n"));
    let list: Vec<[f64; 3]> = right.iter().map(DVec3::to_array).collect();
    let old = serde_json::json!({ "version": 2, "landmarks": { "points": list } });
    let mut group = serde_json::json!({ "landmarks": { "points": list } });
    // One that nobody has set.
    group["landmarks"]["points"][3] = serde_json::json!([null, null, null]);
    let new = serde_json::json!({ "version": 3, "groups": { "LJSON": group } });
    let by_name = picked(&right, |i| format!("ibug_{i:02}"));
    let not_picked = by_name.replacen("active=\"1\"", "active=\"0\"", 2);
    let open = by_name.replace(" active=\"1\"", "");
    for (name, content, points) in [
        ("l.pp", by_name.into_bytes(), 68),
        ("l.pp", not_picked.into_bytes(), 66),
        ("l.PP", open.into_bytes(), 68),
        ("l.pp", picked(&right, |i| i.to_string()).into_bytes(), 68),
        (
            "l.pp",
            picked(&right, |i| (i + 1).to_string()).into_bytes(),
            68,
        ),
        (l, marked(&json(&right)), 68),
        (l, wide.collect(), 68),
        ("l.txt", marked(&lines.join("\r\n")), 68),
        (
            "l.txt",
            [b"# f\xfcr uns\r", lines.join("\r").as_bytes()].concat(),
            68,
        ),
        ("l.pts", pts.into_bytes(), 68),
        ("l.ljson", old.to_string().into_bytes(), 68),
        ("l.ljson", new.to_string().into_bytes(), 67),
    ] {
        try_points(name, &content).unwrap_or_else(|e| panic!("{e}"));
        let mut scan = Scan::read(&scan, None).expect("reads");
        let read = landmarks::read(&folder.path().join(name), &mut scan, &template);
        let read = read.expect("reads");
        assert_eq!(read.points.len(), points, "{name}");
        let is_right = |&(i, p): &(usize, DVec3)| p.distance(right[i]) < 1e-9;
        assert!(read.points.iter().all(is_right), "{name}");
        assert!(read.errors.is_empty(), "{name}");
    }
    // A mirrored scan: its points are where they belong on it.
    let mirror = DVec3::new(-1.0, 1.0, 1.0);
    let mirrored: Vec<DVec3> = positions.iter().map(|&p| p * mirror).collect();
    fs::write(&scan, obj(&mirrored, &triangles)).expect("written");
    let error = try_points(l, mapped(&|_, p| p * mirror).as_bytes()).map(|_| ());
    let error = error.expect_err("mirrored").to_string();
    one_line("mirrored", &error, &scan, &["mirrored", "left and right"]);
}

#[test]
fn odd_scans_are_read_and_said() {
    let template = template();
    let (positions, triangles) = egg();
    let right = points(&template);
    let folder = tempfile::tempdir().expect("a folder");
    let path = |name: &str| folder.path().join(name);
    let write = |name: &str, content: &[u8]| -> PathBuf {
        fs::write(path(name), content).expect("written");
        path(name)
    };
    let scaled = |points: &[DVec3], by: f64| points.iter().map(|&p| p * by).collect::<Vec<_>>();
    let said = |notes: &[String], part: &str| notes.iter().any(|note| note.contains(part));

    for (by, unit) in [
        (1e-3, "metres"),
        (0.1, "centimetres"),
        (1.0 / 25.4, "inches"),
        (3.0, "its own, of 0.3333 mm"),
        (0.02, "its own, of 50.0000 mm"),
        (5e-3, "its own, of 200.0000 mm"),
    ] {
        let scan = write("u.obj", obj(&scaled(&positions, by), &triangles).as_bytes());
        let points = write("u.json", json(&scaled(&right, by)).as_bytes());
        let (scan, notes) = read(&template, &scan, Some(&points)).expect(unit);
        assert!(said(&notes, &format!("units: {unit}")), "{notes:?}");
        assert!((scan.scale * by - 1.0).abs() < 1e-12);
        for (p, q) in scan.positions.iter().zip(&positions) {
            assert!(p.distance(*q) < 1e-9, "in mm");
        }
    }

    // Without landmarks, too small in centimetres and too large in metres: as long as a head with its neck.
    let between = write(
        "b.obj",
        obj(&scaled(&positions, 0.02), &triangles).as_bytes(),
    );
    let scan = Scan::read(&between, None).expect("reads");
    assert!(said(&scan.notes, "units: its own, of "), "{:?}", scan.notes);

    let turned: Vec<DVec3> = positions
        .iter()
        .map(|p| DVec3::new(-p.x, -p.y, p.z))
        .collect();
    let turned_points: Vec<DVec3> = right.iter().map(|p| DVec3::new(-p.x, -p.y, p.z)).collect();
    let scan = write("t.obj", obj(&turned, &triangles).as_bytes());
    let points = write("t.json", json(&turned_points).as_bytes());
    let (_, notes) = read(&template, &scan, Some(&points)).expect("any pose is fine");
    assert!(said(&notes, "upside down"), "{notes:?}");

    let inside_out = triangles
        .iter()
        .map(|&[a, b, c]| [a, c, b])
        .collect::<Vec<_>>();
    let scan = write("i.obj", obj(&positions, &inside_out).as_bytes());
    let points = write("i.json", json(&right).as_bytes());
    let (scan, notes) = read(&template, &scan, Some(&points)).expect("turned");
    assert!(said(&notes, "inside out"), "{notes:?}");
    assert_eq!(scan.triangles.len(), triangles.len());
    let volume = |t: &[u32; 3]| {
        let [a, b, c] = t.map(|v| scan.positions[v as usize]);
        a.dot(b.cross(c))
    };
    assert!(
        scan.triangles.iter().all(|t| volume(t) > 0.0),
        "seen from the middle"
    );

    // What is larger than the head and inside out tells the volume, and landmarks better: all is as in the file.
    let mut with_box = positions.clone();
    let first = positions.len() as u32;
    with_box.extend((0..8).map(|i| {
        let side = |axis: i32| f64::from((i >> axis) & 1) * 400.0 - 200.0;
        DVec3::new(side(0), side(1) - 350.0, side(2))
    }));
    let sides = [
        [0, 1, 3, 2],
        [4, 6, 7, 5],
        [0, 4, 5, 1],
        [2, 3, 7, 6],
        [0, 2, 6, 4],
        [1, 5, 7, 3],
    ];
    let inwards = sides
        .iter()
        .flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]);
    let all: Vec<[u32; 3]> = (triangles.iter().copied())
        .chain(inwards.map(|t| t.map(|v| first + v)))
        .collect();
    let scan = write("f.obj", obj(&with_box, &all).as_bytes());
    let (read_alone, _) = read(&template, &scan, None).expect("reads");
    assert!(
        said(&read_alone.notes, "all turned"),
        "{:?}",
        read_alone.notes
    );
    let points = write("f.json", json(&right).as_bytes());
    let (scan, notes) = read(&template, &scan, Some(&points)).expect("turned back");
    assert!(!said(&notes, "turned"), "{notes:?}");
    assert_eq!(scan.triangles, all);

    let soup: String = triangles
        .iter()
        .flatten()
        .map(|&v| positions[v as usize])
        .map(|p| format!("v {} {} {}\n", p.x, p.y, p.z))
        .chain(
            (0..triangles.len()).map(|t| format!("f {} {} {}\n", 3 * t + 1, 3 * t + 2, 3 * t + 3)),
        )
        .collect();
    let (scan, notes) = read(&template, &write("s.obj", soup.as_bytes()), None).expect("welded");
    assert_eq!(scan.positions.len(), positions.len());
    assert!(said(&notes, "merged"), "{notes:?}");

    let extra = obj(&positions, &triangles) + "v 1 2 3\nf 1 1 2\nf 1 2\nl 1 2\n";
    let (scan, notes) = read(&template, &write("e.obj", extra.as_bytes()), None).expect("cleaned");
    assert_eq!(
        (scan.positions.len(), scan.triangles.len()),
        (positions.len(), triangles.len())
    );
    for part in [
        "1 triangles without area",
        "1 vertices without triangles",
        "fewer than three",
    ] {
        assert!(said(&notes, part), "{notes:?}");
    }

    // Seen from both sides, and a triangle once more: what came first stays.
    let both: Vec<[u32; 3]> = (triangles.iter())
        .flat_map(|&[a, b, c]| [[a, b, c], [b, a, c]])
        .chain([triangles[7]])
        .collect();
    let (scan, notes) = read(
        &template,
        &write("b.obj", obj(&positions, &both).as_bytes()),
        None,
    )
    .expect("one-sided");
    assert_eq!(scan.triangles, triangles);
    let part = format!(
        "{} triangles left out that were there twice",
        triangles.len() + 1
    );
    assert!(said(&notes, &part), "{notes:?}");

    // A scan without its picture is a scan all the same.
    let uv = "vt 0 0\nvt 1 0\nvt 0 1\nusemtl skin\nf 1/1 2/2 3/3\n";
    let with = |library: &str| format!("mtllib {library}\n{}{uv}", obj(&positions, &triangles));
    let material = |image: &str| format!("newmtl skin\nmap_Kd {image}\n");
    write("no image.mtl", material("gone.png").as_bytes());
    write("bad image.mtl", material("bad.png").as_bytes());
    write("bad.png", b"\x89PNG\r\n\x1a\nbroken");
    for (library, part) in [
        ("gone.mtl", "gone.mtl"),
        ("no image.mtl", "gone.png"),
        ("bad image.mtl", "bad.png"),
    ] {
        let scan = write("p.obj", with(library).as_bytes());
        let (scan, notes) = read(&template, &scan, None).expect(library);
        assert!(scan.texture.is_none());
        assert!(said(&notes, "no ") && said(&notes, part), "{notes:?}");
    }
    // What is not to be seen is not opened, but belongs to the scan all the same.
    let scan = Scan::read_shape(&path("p.obj"), None).expect("reads");
    assert_eq!(scan.triangles.len(), triangles.len() + 1);
    assert!(!said(&scan.notes, "texture"), "{:?}", scan.notes);
    assert!(scan.beside.contains(&path("bad.png")), "{:?}", scan.beside);
    // An image of the scan's name stands in for materials that are missing.
    write("p.png", b"broken too");
    let scan = write("p.obj", with("gone.mtl").as_bytes());
    let (_, notes) = read(&template, &scan, None).expect("with what is beside it");
    assert!(
        said(&notes, "p.png, because it has the scan's name"),
        "{notes:?}"
    );
    let colours = [[200, 10, 20], [30, 140, 50], [60, 70, 180], [9, 8, 7]];
    let mut png = Vec::new();
    image::RgbImage::from_fn(2, 2, |x, y| image::Rgb(colours[(2 * y + x) as usize]))
        .write_to(&mut std::io::Cursor::new(&mut png), image::ImageFormat::Png)
        .expect("encodes");
    write("my face.png", &png);
    write("good.mtl", material("my face.png").as_bytes());
    let scan = write("p.obj", with("good.mtl").as_bytes());
    let (scan, _) = read(&template, &scan, None).expect("with its picture");
    assert!(
        Scan::read_shape(&path("p.obj"), None)
            .expect("reads")
            .texture
            .is_none(),
        "nobody looks at it"
    );
    let texture = scan.texture.expect("a picture");
    assert_eq!((texture.width, texture.height), (2, 2));
    assert_eq!(texture.pixels, colours);
    let covered = |t: &&[u32; 3]| **t != phiz::fit::scan::Texture::BARE;
    assert_eq!(texture.triangles.iter().filter(covered).count(), 1);
}

/// A picture is found though materials are called otherwise, have it under another keyword, or name what is gone.
#[test]
fn the_picture_of_a_scan_is_found() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = |name: &str| folder.path().join(name);
    for (name, grey) in [("skin.png", 1), ("light.png", 2), ("m.png", 3)] {
        let image = image::RgbImage::from_pixel(2, 2, image::Rgb([grey; 3]));
        image.save(path(name)).expect("written");
    }
    let mesh = "v 0 0 0\nv 100 0 0\nv 0 100 0\nvt 0 0\nvt 1 0\nvt 0 1\nf 1/1 2/2 3/3\n";
    let read = |use_of: &str, material: &str| {
        fs::write(path("m.obj"), format!("mtllib m.mtl\n{use_of}\n{mesh}")).expect("written");
        fs::write(path("m.mtl"), material).expect("written");
        let scan = Scan::read(&path("m.obj"), None).expect("reads");
        (scan.texture.map(|texture| texture.pixels[0][0]), scan.notes)
    };
    let skin = "newmtl skin\nmap_Kd skin.png\n";
    for (use_of, material, expected, note) in [
        ("usemtl skin", skin.to_owned(), Some(1), ""),
        ("", skin.to_owned(), Some(1), "because it is the only one"),
        (
            "usemtl Skin.001",
            skin.to_owned(),
            Some(1),
            "skin.png, because it is the only one",
        ),
        // Which of two it is, nobody knows.
        (
            "",
            format!("{skin}newmtl eyes\nmap_Kd light.png\n"),
            None,
            "",
        ),
        (
            "usemtl skin",
            "newmtl skin\nmap_Ka light.png\n".into(),
            Some(2),
            "",
        ),
        (
            "usemtl skin",
            "newmtl skin\nmap_Ke light.png\n".into(),
            Some(2),
            "",
        ),
        (
            "usemtl skin",
            format!("newmtl skin\nmap_Ka light.png\n{}", &skin[12..]),
            Some(1),
            "",
        ),
        (
            "usemtl skin",
            "newmtl skin\nmap_Kd gone.png\n".into(),
            Some(3),
            "m.png, because it has",
        ),
    ] {
        let (found, notes) = read(use_of, &material);
        assert_eq!(found, expected, "{use_of} {material}: {notes:?}");
        assert!(
            notes.iter().any(|n| n.contains(note)),
            "{use_of} {material}: {notes:?}"
        );
    }
    let ply = ply_header(
        "ascii",
        "3",
        &format!("property float s\nproperty float t\n{FACES}"),
    )
    .replace("1.0\n", "1.0\ncomment TextureFile gone.png\n")
        + "0 0 0 0 0\n100 0 0 1 0\n0 100 0 0 1\n3 0 1 2\n";
    fs::write(path("m.ply"), ply).expect("written");
    let scan = Scan::read(&path("m.ply"), None).expect("reads");
    assert_eq!(scan.texture.map(|texture| texture.pixels[0][0]), Some(3));
}

/// A corner without a place in the picture costs the picture of its triangles, and no more.
#[test]
fn texture_coordinates_that_are_no_number_are_missing_there_alone() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = |name: &str| folder.path().join(name);
    image::RgbImage::new(2, 2)
        .save(path("m.png"))
        .expect("written");
    let obj = "v 0 0 0\nv 100 0 0\nv 0 100 0\nv 100 100 0\nvt 0 0\nvt 1 0\nvt 0 1\nvt -nan(ind) nan\n\
               f 1/1 2/2 3/3\nf 2/2 4/4 3/3\n";
    let rest = "property float s\nproperty float t\n".to_owned() + FACES;
    let ply = ply_header("ascii", "4", &rest.replace("face 1", "face 2"))
        + "0 0 0 0 0\n100 0 0 1 0\n0 100 0 0 1\n100 100 0 nan nan\n3 0 1 2\n3 1 3 2\n";
    for (name, content) in [("m.obj", obj), ("m.ply", &ply)] {
        fs::write(path(name), content).expect("written");
        let scan = Scan::read(&path(name), None).unwrap_or_else(|e| panic!("{e}"));
        let texture = scan
            .texture
            .unwrap_or_else(|| panic!("{name}: {:?}", scan.notes));
        let bare = texture
            .triangles
            .iter()
            .map(|t| *t == phiz::fit::scan::Texture::BARE);
        assert_eq!(bare.collect::<Vec<_>>(), [false, true], "{name}");
    }
}

/// PLY with what other programs have in it, as numbers in text and as bytes.
#[test]
fn ply_is_read_as_programs_write_it() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("m.ply");
    let read = |content: &[u8]| {
        fs::write(&file, content).expect("written");
        let scan = Scan::read(&file, None).unwrap_or_else(|e| panic!("{e}"));
        (scan.positions, scan.triangles)
    };
    let positions = [DVec3::ZERO, DVec3::X * 100.0, DVec3::Y * 100.5];
    let expected = (positions.to_vec(), vec![[0, 1, 2]]);
    // Names of CloudCompare's and of nobody's, and one that is there twice.
    let more = "property float scalar_Roughness_(0.1)\nproperty float scalar field\nproperty float 2nd\n\
                property float q\nproperty float q\n";
    let rest = more.to_owned() + FACES;
    let rows = ["0 0 0", "100 0 0", "0 100.5 0"];
    for end in ["\n", "\r\n"] {
        let text = rows.map(|row| format!("{row} 1 2 3 4 5\n")).concat() + "3 0 1 2\n";
        let text = ply_header("ascii", "3", &rest) + &text;
        assert_eq!(read(text.replace('\n', end).as_bytes()), expected);
    }
    let mut bytes = ply_header("binary_little_endian", "3", &rest).into_bytes();
    for p in positions {
        let numbers = p
            .as_vec3()
            .to_array()
            .into_iter()
            .chain([1.0, 2.0, 3.0, 4.0, 5.0]);
        bytes.extend(numbers.flat_map(f32::to_le_bytes));
    }
    bytes.extend([3, 0, 0, 0, 0, 1, 0, 0, 0, 2, 0, 0, 0]);
    assert_eq!(read(&bytes), expected);
    // Normals and vertices of nothing that was seen, short numbers, and rows apart.
    let rest = "property float nx\nproperty uchar red\n".to_owned() + FACES;
    for end in ["\n", "\r\n"] {
        let text = ply_header("ascii", "4", &rest)
            + "0. 0 -.0 nan 1\n100 0 0 -nan(ind) 2\n\n0 1.005e2 0 -1.#IND 3\nnan -nan inf 1 4\n\n3 0 1 2\n";
        assert_eq!(read(text.replace('\n', end).as_bytes()), expected);
    }
}

/// Text as Windows' programs and old ones write it is text all the same, and no vertex is lost.
#[test]
fn text_of_other_systems_is_read() {
    let (positions, triangles) = egg();
    let folder = tempfile::tempdir().expect("a folder");
    let path = |name: &str| folder.path().join(name);
    let plain = obj(&positions, &triangles);
    let wide: Vec<u16> = plain.encode_utf16().collect();
    let wide = [0xfeff].iter().chain(&wide).flat_map(|u| u.to_be_bytes());
    let rest = plain.as_bytes();
    for (kind, content) in [
        ("UTF-8's mark", [b"\xef\xbb\xbf", rest].concat()),
        ("UTF-16", wide.collect()),
        (
            "Latin-1",
            [b"# M\xfcller, \xff\xfe\no Gr\xfc\xdfe\n", rest].concat(),
        ),
        ("UTF-8", ["# Müller\n".as_bytes(), rest].concat()),
        ("CR LF", plain.replace('\n', "\r\n").into_bytes()),
        ("CR", plain.replace('\n', "\r").into_bytes()),
        (
            "continued",
            format!("# C:\\scans\\\n{}", plain.replacen(' ', " \\\n", 1)).into_bytes(),
        ),
    ] {
        fs::write(path("t.obj"), content).expect("written");
        let scan = Scan::read(&path("t.obj"), None).unwrap_or_else(|e| panic!("{kind}: {e}"));
        assert_eq!(scan.positions.len(), positions.len(), "{kind}");
        assert_eq!(scan.triangles.len(), triangles.len(), "{kind}");
    }
    // Names of files in either encoding, of files in either encoding.
    let mut png = Vec::new();
    image::RgbImage::new(2, 2)
        .write_to(&mut std::io::Cursor::new(&mut png), image::ImageFormat::Png)
        .expect("encodes");
    let uv = "vt 0 0\nvt 1 0\nvt 0 1\nusemtl skin\nf 1/1 2/2 3/3\n";
    let latin = |text: &str| -> Vec<u8> { text.chars().map(|c| c as u8).collect() };
    let utf = |text: &str| text.as_bytes().to_vec();
    type Written<'a> = &'a dyn Fn(&str) -> Vec<u8>;
    let kinds: [(&str, Written); 2] = [("Latin-1", &latin), ("UTF-8", &utf)];
    for (kind, written) in kinds {
        for (named, bytes) in kinds {
            let name = |text: &str| {
                use std::os::unix::ffi::OsStringExt;
                folder
                    .path()
                    .join(std::ffi::OsString::from_vec(bytes(text)))
            };
            let library = written("newmtl skin\nmap_Kd Fotos\\Müller.png\n");
            fs::write(name("Müller.mtl"), library).expect("written");
            fs::write(name("Müller.png"), &png).expect("written");
            let content = written(&format!("mtllib Müller.mtl\n{plain}{uv}"));
            fs::write(path("m.obj"), content).expect("written");
            let scan = Scan::read(&path("m.obj"), None).expect("reads");
            assert!(
                scan.texture.is_some(),
                "{named} in {kind}: {:?}",
                scan.notes
            );
            for file in ["Müller.mtl", "Müller.png"] {
                fs::remove_file(name(file)).expect("goes");
            }
        }
    }
    // A header in Latin-1, and a mark.
    let ply = ply_header("ascii", "3", FACES).replace("1.0\n", "1.0\ncomment von Müller\n")
        + "0 0 0\n100 0 0\n0 100 0\n3 0 1 2\n";
    for content in [
        latin(&ply),
        utf(&ply),
        [b"\xef\xbb\xbf", ply.as_bytes()].concat(),
    ] {
        fs::write(path("m.ply"), content).expect("written");
        Scan::read(&path("m.ply"), None).expect("reads");
    }
}

/// Strips and loose triangles: STL of both kinds, and PLY with `tristrips`.
#[test]
fn strips_and_loose_triangles_are_meshes() {
    let (positions, triangles) = egg();
    let folder = tempfile::tempdir().expect("a folder");
    let read = |name: &str, content: &[u8]| {
        let file = folder.path().join(name);
        fs::write(&file, content).expect("written");
        Scan::read(&file, None).expect(name)
    };
    let corner = |v: u32| positions[v as usize].as_vec3();
    let text: String = (triangles.iter())
        .map(|t| {
            let corners = t
                .map(corner)
                .map(|p| format!("vertex {} {} {}\n", p.x, p.y, p.z));
            format!(
                "facet normal 0 0 0\nouter loop\n{}endloop\nendfacet\n",
                corners.concat()
            )
        })
        .collect();
    let text = format!("solid egg\n{text}endsolid egg\n");
    for content in [stl(triangles.len()), text.into_bytes()] {
        let scan = read("e.stl", &content);
        assert_eq!(scan.positions.len(), positions.len());
        assert_eq!(scan.triangles.len(), triangles.len());
    }
    // A square as a strip, and one triangle that a strip of its own turns.
    let strips = ply_header("ascii", "4", FACES).replace("face 1", "tristrips 1")
        + "0 0 0\n100 0 0\n0 100 0\n100 100 0\n9 0 1 2 3 -1 2 2 1 3\n";
    let scan = read("s.ply", strips.as_bytes());
    assert_eq!(scan.triangles, [[0, 1, 2], [2, 1, 3], [1, 2, 3]]);
}

/// What glTF allows beside plain floats: integers, sparse accessors, a part of a picture, JSON.
#[test]
fn every_kind_of_gltf_is_read() {
    let folder = tempfile::tempdir().expect("a folder");
    let read = |name: &str, content: &[u8]| {
        let file = folder.path().join(name);
        fs::write(&file, content).expect("written");
        Scan::read(&file, None).unwrap_or_else(|e| panic!("{e}"))
    };
    // The buffer in the file, beside it, and beside it with a space.
    let plain = read("t.glb", &glb_triangle([0, 1, 2], 42, ""));
    let buffer = triangle_bytes([0, 1, 2]);
    for name in ["t.bin", "my scan.bin"] {
        fs::write(folder.path().join(name), &buffer).expect("written");
    }
    let base64 = Base64::encode_string(&buffer);
    for uri in [
        "t.bin",
        "my%20scan.bin",
        "my scan.bin",
        &format!("data:application/octet-stream;base64,{base64}"),
    ] {
        let scan = read("t.gltf", &gltf_triangle(uri));
        assert_eq!(scan.positions, plain.positions, "{uri}");
        assert_eq!(scan.triangles, plain.triangles, "{uri}");
    }

    // A triangle of 100 mm of one integer type after the other, as they are and normalised.
    let (i8s, u8s) = ([0i8, 0, 0, 0, 127, 0, 0, 0, 0, 127, 0, 0], 127u8);
    let integers: [(u32, f64, Vec<u8>); 4] = [
        (5120, 127.0, i8s.iter().map(|&x| x as u8).collect()),
        (
            5121,
            255.0,
            i8s.iter().map(|&x| if x > 0 { u8s } else { 0 }).collect(),
        ),
        (
            5122,
            32767.0,
            i8s.iter()
                .flat_map(|&x| i16::from(x).to_le_bytes())
                .collect(),
        ),
        (
            5123,
            65535.0,
            i8s.iter()
                .flat_map(|&x| u16::from(x as u8).to_le_bytes())
                .collect(),
        ),
    ];
    for (kind, most, bytes) in integers {
        for normalised in [false, true] {
            let scale = 0.1 / 127.0 * if normalised { most } else { 1.0 };
            let stride = bytes.len() / 3;
            let json = format!(
                r#"{{"asset":{{"version":"2.0"}},"scene":0,"scenes":[{{"nodes":[0]}}],
                "extensionsUsed":["KHR_mesh_quantization"],
                "extensionsRequired":["KHR_mesh_quantization"],
                "nodes":[{{"mesh":0,"scale":[{scale},{scale},{scale}]}}],
                "meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}}}}]}}],
                "accessors":[{{"bufferView":0,"componentType":{kind},"count":3,"type":"VEC3",
                "normalized":{normalised},"min":[0,0,0],"max":[127,127,0]}}],
                "bufferViews":[{{"buffer":0,"byteLength":{},"byteStride":{stride}}}],
                "buffers":[{{"byteLength":{}}}]}}"#,
                bytes.len(),
                bytes.len()
            );
            let scan = read("q.glb", &glb(&json, &bytes));
            for (p, q) in scan.positions.iter().zip(&plain.positions) {
                let q = *q - plain.positions[0];
                assert!(p.distance(q) < 1e-3, "{kind}, {normalised}: {p}");
            }
        }
    }

    // All zeros but two, and one of three replaced.
    let floats = |x: &[f32]| x.iter().flat_map(|x| x.to_le_bytes()).collect::<Vec<u8>>();
    let base = floats(&[0.0, 0.0, 0.0, 0.1, 0.0, 0.0, 7.0, 7.0, 7.0]);
    let values = floats(&[0.1, 0.0, 0.0, 0.0, 0.1, 0.0]);
    let indices = [1u16, 2].map(u16::to_le_bytes).concat();
    let bytes = [base, values, indices].concat();
    for (view, count, first) in [("", 2, 0), (r#""bufferView":0,"#, 1, 1)] {
        let json = |count: usize| {
            format!(
                r#"{{"asset":{{"version":"2.0"}},"scene":0,"scenes":[{{"nodes":[0]}}],"nodes":[{{"mesh":0}}],
                "meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}}}}]}}],
                "accessors":[{{{view}"componentType":5126,"count":3,"type":"VEC3",
                "min":[0,0,0],"max":[0.1,0.1,0],"sparse":{{"count":{count},
                "indices":{{"bufferView":2,"byteOffset":{},"componentType":5123}},
                "values":{{"bufferView":1,"byteOffset":{}}}}}}}],
                "bufferViews":[{{"buffer":0,"byteLength":36}},
                {{"buffer":0,"byteOffset":36,"byteLength":24}},
                {{"buffer":0,"byteOffset":60,"byteLength":4}}],"buffers":[{{"byteLength":64}}]}}"#,
                2 * first,
                12 * first
            )
        };
        let scan = read("s.glb", &glb(&json(count), &bytes));
        assert_eq!(scan.positions.len(), 3);
        for (p, q) in scan.positions.iter().zip(&plain.positions) {
            assert!(p.distance(*q - plain.positions[0]) < 1e-3, "{view}: {p}");
        }
        // More than there are, and none.
        for count in [3, 0] {
            let file = folder.path().join("s.glb");
            fs::write(&file, glb(&json(count), &bytes)).expect("written");
            let error = Scan::read(&file, None).map(|_| ()).expect_err("no");
            one_line(
                "sparse",
                &error.to_string(),
                &file,
                &["reaches beyond its buffer"],
            );
        }
    }

    // A quarter turn counter-clockwise on the picture, of half its width, from the middle; another set.
    let mut png = Vec::new();
    image::RgbImage::new(2, 2)
        .write_to(&mut std::io::Cursor::new(&mut png), image::ImageFormat::Png)
        .expect("encodes");
    let corners = floats(&[0.0, 0.0, 0.0, 0.1, 0.0, 0.0, 0.0, 0.1, 0.0]);
    let bytes = [
        corners,
        floats(&[9.0; 6]),
        [0u16, 0, 65535, 0, 0, 65535].map(u16::to_le_bytes).concat(),
        png.clone(),
    ]
    .concat();
    let json = format!(
        r#"{{"asset":{{"version":"2.0"}},"scene":0,"scenes":[{{"nodes":[0]}}],"nodes":[{{"mesh":0}}],
        "extensionsUsed":["KHR_texture_transform"],"extensionsRequired":["KHR_texture_transform"],
        "meshes":[{{"primitives":[{{"material":0,
        "attributes":{{"POSITION":0,"TEXCOORD_0":1,"TEXCOORD_1":2}}}}]}}],
        "materials":[{{"pbrMetallicRoughness":{{"baseColorTexture":{{"index":0,"texCoord":0,
        "extensions":{{"KHR_texture_transform":{{"offset":[0.5,0.5],"rotation":1.5707963,
        "scale":[0.5,1],"texCoord":1}}}}}}}}}}],
        "textures":[{{"source":0}}],"images":[{{"bufferView":3}}],
        "accessors":[{{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3",
        "min":[0,0,0],"max":[0.1,0.1,0]}},
        {{"bufferView":1,"componentType":5126,"count":3,"type":"VEC2"}},
        {{"bufferView":2,"componentType":5123,"normalized":true,"count":3,"type":"VEC2"}}],
        "bufferViews":[{{"buffer":0,"byteLength":36}},{{"buffer":0,"byteOffset":36,"byteLength":24}},
        {{"buffer":0,"byteOffset":60,"byteLength":12}},
        {{"buffer":0,"byteOffset":72,"byteLength":{}}}],"buffers":[{{"byteLength":{}}}]}}"#,
        png.len(),
        bytes.len()
    );
    let texture = read("p.glb", &glb(&json, &bytes))
        .texture
        .expect("a picture");
    // v is up here: what went right goes up, by the half; what went down goes right.
    let expected = [(0.5, 0.5), (0.5, 1.0), (1.5, 0.5)].map(glam::DVec2::from);
    for (uv, expected) in texture.uvs.iter().zip(expected) {
        assert!(uv.distance(expected) < 1e-6, "{uv}");
    }
    // An image of a kind that is not read leaves a scan.
    let json = json.replace(r#"[{"source":0}]"#, r#"[{}]"#);
    let scan = read("p.glb", &glb(&json, &bytes));
    assert!(scan.texture.is_none());
    assert!(
        scan.notes.iter().any(|note| note.contains("no texture")),
        "{:?}",
        scan.notes
    );
}

#[test]
fn one_mesh_is_the_same_in_every_format() {
    let (positions, triangles) = egg();
    // As single precision has them, for all formats.
    let positions: Vec<DVec3> = positions.iter().map(|p| p.as_vec3().as_dvec3()).collect();
    let folder = tempfile::tempdir().expect("a folder");
    let header = |format: &str| {
        format!(
            "ply\nformat {format} 1.0\ncomment TextureFile none.png\nelement camera 1\n\
             property double f\nelement vertex {}\nproperty float nx\nproperty float x\n\
             property float y\nproperty float z\nproperty uchar red\nproperty uchar green\n\
             property uchar blue\nelement face {}\nproperty uchar flags\n\
             property list uchar uint vertex_index\nend_header\n",
            positions.len(),
            triangles.len()
        )
    };
    let mut files = vec![("m.obj", obj(&positions, &triangles).into_bytes())];
    let mut ascii = header("ascii") + "1.5\n";
    for p in &positions {
        ascii += &format!("0 {} {} {} 1 2 3\n", p.x, p.y, p.z);
    }
    for t in &triangles {
        ascii += &format!("7 3 {} {} {}\n", t[0], t[1], t[2]);
    }
    files.push(("ascii.ply", ascii.into_bytes()));
    for little in [true, false] {
        let order = |bytes: &mut [u8]| {
            if !little {
                bytes.reverse();
            }
        };
        let float = |x: f64| {
            let mut bytes = (x as f32).to_le_bytes();
            order(&mut bytes);
            bytes
        };
        let format = ["binary_big_endian", "binary_little_endian"][usize::from(little)];
        let mut bytes = header(format).into_bytes();
        bytes.extend([0; 8]);
        for p in &positions {
            bytes.extend([0.0, p.x, p.y, p.z].iter().flat_map(|&x| float(x)));
            bytes.extend([1, 2, 3]);
        }
        for t in &triangles {
            bytes.extend([7, 3]);
            for v in t {
                let mut v = v.to_le_bytes();
                order(&mut v);
                bytes.extend(v);
            }
        }
        files.push((["big.ply", "little.ply"][usize::from(little)], bytes));
    }
    let mut binary: Vec<u8> = positions
        .iter()
        .flat_map(|p| p.as_vec3().to_array())
        .flat_map(f32::to_le_bytes)
        .collect();
    let indices = binary.len();
    binary.extend(triangles.iter().flatten().flat_map(|v| v.to_le_bytes()));
    files.push((
        "m.glb",
        glb(
            &format!(
                r#"{{"asset":{{"version":"2.0"}},"scene":0,"scenes":[{{"nodes":[0]}}],
                "nodes":[{{"children":[1]}},{{"mesh":0}}],
                "meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}},"indices":1}}]}}],
                "accessors":[{{"bufferView":0,"componentType":5126,"count":{},"type":"VEC3",
                "min":[-75,-110,-95],"max":[75,110,120]}},
                {{"bufferView":1,"componentType":5125,"count":{},"type":"SCALAR"}}],
                "bufferViews":[{{"buffer":0,"byteLength":{indices}}},
                {{"buffer":0,"byteOffset":{indices},"byteLength":{}}}],
                "buffers":[{{"byteLength":{}}}]}}"#,
                positions.len(),
                3 * triangles.len(),
                12 * triangles.len(),
                binary.len()
            ),
            &binary,
        ),
    ));
    let scans: Vec<Scan> = files
        .iter()
        .map(|(name, bytes)| {
            let file = folder.path().join(name);
            fs::write(&file, bytes).expect("written");
            Scan::read(&file, None).expect(name)
        })
        .collect();
    for (scan, (name, _)) in scans.iter().zip(&files) {
        assert_eq!(scan.positions, scans[0].positions, "{name}");
        assert_eq!(scan.triangles, scans[0].triangles, "{name}");
        let coloured = name.ends_with("ply");
        assert_eq!(
            scan.colours.first(),
            coloured.then_some(&[1, 2, 3]),
            "{name}"
        );
    }
    assert_eq!(scans[0].positions.len(), positions.len());
}

/// Whatever a few wrong bytes do to a file, it is read or refused with one line.
#[test]
fn a_damaged_file_is_no_panic() {
    let corners = [
        DVec3::ZERO,
        DVec3::X * 100.0,
        DVec3::Y * 100.0,
        DVec3::Z * 100.0,
    ];
    let faces = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
    let textured = obj(&corners, &faces)
        + "vt 0 0\nvt 1 0\nvt 0 1\ng a\nusemtl b\nf 1/1 2/2 3/3\nf -1/-1 -2/-2/1 -3//2 -4\n";
    let lists = "element face 1\nproperty list uchar int vertex_indices\n\
                 property list uchar float texcoord\nproperty int texnumber\n";
    let ascii =
        ply_header("ascii", "3", lists) + "0 0 0\n100 0 0\n0 100 0\n3 0 1 2 6 0 0 1 0 0 1 0\n";
    let mut binary = ply_header("binary_little_endian", "3", FACES).into_bytes();
    binary.extend(
        corners
            .iter()
            .take(3)
            .flat_map(|p| p.as_vec3().to_array())
            .flat_map(f32::to_le_bytes),
    );
    binary.extend([3, 0, 0, 0, 0, 1, 0, 0, 0, 2, 0, 0, 0]);
    let template = template();
    let right: Vec<DVec3> = points(&template);
    let folder = tempfile::tempdir().expect("a folder");
    let scan = folder.path().join("egg.obj");
    let (positions, triangles) = egg();
    fs::write(&scan, obj(&positions, &triangles)).expect("written");
    let egg = Scan::read(&scan, None).expect("reads");
    let base64 = Base64::encode_string(&triangle_bytes([0, 1, 2]));
    let lines = right.iter().map(|p| format!("{} {} {}\n", p.x, p.y, p.z));
    let pts = format!(
        "version: 1\nn_points: 68\n{{\n{}}}\n",
        lines.collect::<String>()
    );
    let mut random = phiz::Random::new(11);
    for (name, content) in [
        ("d.obj", textured.into_bytes()),
        ("ascii.ply", ascii.into_bytes()),
        ("binary.ply", binary),
        ("d.glb", glb_triangle([0, 1, 2], 42, "")),
        ("d.gltf", gltf_triangle(&format!("data:;base64,{base64}"))),
        ("d.stl", stl(20)),
        ("d.pts", pts.into_bytes()),
        (
            "d.pp",
            picked(&right[..20], |i| format!("ibug_{i:02}")).into_bytes(),
        ),
        ("d.json", json(&right[..20]).into_bytes()),
    ] {
        let file = folder.path().join(name);
        let read = || match ["json", "pts", "pp"]
            .iter()
            .any(|ending| name.ends_with(ending))
        {
            true => landmarks::read(&file, &mut egg.clone(), &template).map(|_| ()),
            false => Scan::read(&file, None).map(|_| ()),
        };
        fs::write(&file, &content).expect("written");
        read().unwrap_or_else(|e| panic!("{name} undamaged: {e}"));
        let mut refused = 0;
        for _ in 0..400 {
            let mut damaged = content.clone();
            for _ in 0..1 + random.bits() % 3 {
                let at = random.bits() as usize % damaged.len();
                match random.bits() % 4 {
                    0 => damaged[at] = random.bits() as u8,
                    // Digits and signs get further than noise does.
                    1 => damaged[at] = b"0123456789-.e "[random.bits() as usize % 14],
                    2 => damaged.truncate(at.max(1)),
                    _ => damaged.insert(at, b"0123456789-/ \n"[random.bits() as usize % 14]),
                }
            }
            fs::write(&file, &damaged).expect("written");
            if let Err(error) = read() {
                let error = error.to_string();
                assert!(!error.contains('\n'), "{error}");
                refused += 1;
            }
        }
        assert!(refused > 50, "{name}: {refused}");
    }
}

/// A square of 100 mm with a picture of four pixels, as each format says it.
#[test]
fn textures_come_the_same_way_up_from_every_format() {
    let colours = [[200, 10, 20], [30, 140, 50], [60, 70, 180], [9, 8, 7]];
    let mut png = Vec::new();
    image::RgbImage::from_fn(2, 2, |x, y| image::Rgb(colours[(2 * y + x) as usize]))
        .write_to(&mut std::io::Cursor::new(&mut png), image::ImageFormat::Png)
        .expect("encodes");
    let folder = tempfile::tempdir().expect("a folder");
    let write = |name: &str, content: &[u8]| {
        let file = folder.path().join(name);
        fs::write(&file, content).expect("written");
        file
    };
    write("my face.png", &png);
    write(
        "s.mtl",
        b"newmtl skin\nKd 1 1 1\nmap_Kd -s 1 1 1 C:\\scans\\my face.png\n",
    );
    let obj = "mtllib s.mtl\nv 0 0 0\nv 100 0 0\nv 100 100 0\nv 0 100 0\n\
               vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nusemtl skin\nf 1/1 2/2 3/3 4/4\n";
    let corners = "0 0 0 0 0\n100 0 0 1 0\n100 100 0 1 1\n0 100 0 0 1\n";
    let header = |vertex: &str, face: &str| {
        ply_header(
            "ascii",
            "4",
            &format!("{vertex}element face 1\nproperty list uchar int vertex_indices\n{face}"),
        )
        .replace("1.0\n", "1.0\ncomment TextureFile my face.png\n")
    };
    let by_vertex = header("property float s\nproperty float t\n", "") + corners + "4 0 1 2 3\n";
    let by_face = header("", "property list uchar float texcoord\n")
        + "0 0 0\n100 0 0\n100 100 0\n0 100 0\n4 0 1 2 3 8 0 0 1 0 1 1 0 1\n";
    // In glTF v runs down. A strip, under a node that mirrors it: its x is negative.
    let strip = [
        [-0.1f32, 0.0, 0.0],
        [0.0, 0.0, 0.0],
        [-0.1, 0.1, 0.0],
        [0.0, 0.1, 0.0],
    ];
    let mut binary: Vec<u8> = strip
        .as_flattened()
        .iter()
        .flat_map(|x| x.to_le_bytes())
        .collect();
    let uvs = [1f32, 1.0, 0.0, 1.0, 1.0, 0.0, 0.0, 0.0];
    binary.extend(uvs.iter().flat_map(|x| x.to_le_bytes()));
    binary.extend(&png);
    let json = format!(
        r#"{{"asset":{{"version":"2.0"}},"scene":0,"scenes":[{{"nodes":[0]}}],
        "nodes":[{{"mesh":0,"scale":[-1,1,1]}}],
        "meshes":[{{"primitives":[{{"mode":5,"material":0,
        "attributes":{{"POSITION":0,"TEXCOORD_0":1}}}}]}}],
        "materials":[{{"pbrMetallicRoughness":{{"baseColorTexture":{{"index":0}}}}}}],
        "textures":[{{"source":0}}],"images":[{{"bufferView":2}}],
        "accessors":[{{"bufferView":0,"componentType":5126,"count":4,"type":"VEC3",
        "min":[-0.1,0,0],"max":[0,0.1,0]}},
        {{"bufferView":1,"componentType":5126,"count":4,"type":"VEC2"}}],
        "bufferViews":[{{"buffer":0,"byteLength":48}},
        {{"buffer":0,"byteOffset":48,"byteLength":32}},
        {{"buffer":0,"byteOffset":80,"byteLength":{}}}],
        "buffers":[{{"byteLength":{}}}]}}"#,
        png.len(),
        binary.len()
    );
    // The picture where an older extension has it, and as light alone.
    let base = r#""pbrMetallicRoughness":{"baseColorTexture":{"index":0}}"#;
    let of = |other: &str| json.replacen(base, other, 1);
    let glossy = of(
        r#""extensions":{"KHR_materials_pbrSpecularGlossiness":{"diffuseTexture":{"index":0}}}"#,
    );
    let emissive = of(r#""emissiveTexture":{"index":0}"#);
    // And as WebP alone: what its bytes are, they say.
    let webp = json.replacen(
        r#"[{"source":0}]"#,
        r#"[{"extensions":{"EXT_texture_webp":{"source":0}}}],"extensionsRequired":["EXT_texture_webp"]"#,
        1,
    );
    assert!(glossy != json && emissive != json && webp != json);
    for (name, content) in [
        ("s.obj", obj.as_bytes()),
        ("vertex.ply", by_vertex.as_bytes()),
        ("face.ply", by_face.as_bytes()),
        ("s.glb", &glb(&json, &binary)[..]),
        ("glossy.glb", &glb(&glossy, &binary)[..]),
        ("emissive.glb", &glb(&emissive, &binary)[..]),
        ("webp.glb", &glb(&webp, &binary)[..]),
    ] {
        let scan = Scan::read(&write(name, content), None).expect(name);
        assert_eq!(scan.triangles.len(), 2, "{name}");
        let texture = scan
            .texture
            .as_ref()
            .unwrap_or_else(|| panic!("{name}: {:?}", scan.notes));
        for (triangle, uvs) in scan.triangles.iter().zip(&texture.triangles) {
            let [a, b, c] = triangle.map(|v| scan.positions[v as usize]);
            assert!((b - a).cross(c - a).z > 0.0, "{name}: faces us");
            for (&v, &uv) in triangle.iter().zip(uvs) {
                let p = scan.positions[v as usize] / 100.0;
                // Single precision of 0.1 m.
                assert!(
                    p.truncate().distance(texture.uvs[uv as usize]) < 1e-6,
                    "{name}"
                );
            }
        }
        for (u, v, expected) in [(0.0, 1.0, 0), (1.0, 1.0, 1), (0.0, 0.0, 2), (1.0, 0.0, 3)] {
            let colour = texture.sample(glam::DVec2::new(u, v));
            assert_eq!(
                colour.to_array(),
                colours[expected].map(f64::from),
                "{name}"
            );
        }
    }
}

#[test]
fn a_scan_with_several_images_has_the_colours_of_all() {
    let folder = tempfile::tempdir().expect("a folder");
    // Of different sizes, each in two halves.
    let colours = [
        [[200, 10, 20], [30, 140, 50]],
        [[60, 70, 180], [9, 8, 7]],
        [[250, 251, 1], [1, 99, 2]],
    ];
    let names = ["a.webp", "b b.tif", "c.TGA"];
    for ((name, halves), [width, height]) in
        names.iter().zip(colours).zip([[8, 4], [32, 16], [4, 64]])
    {
        image::RgbImage::from_fn(width, height, |x, _| {
            image::Rgb(halves[usize::from(2 * x >= width)])
        })
        .save(folder.path().join(name))
        .expect("written");
    }
    // Quadrilaterals of two halves; the second image's is numbered as the second tile, the last has none.
    let mut obj = String::from("mtllib s.mtl\n");
    let mut ply = String::new();
    for (i, tile) in [0.0, 1.0, 0.0, 0.0].into_iter().enumerate() {
        let first = 4 * i;
        obj += &format!("usemtl m{i}\n");
        for (u, v) in [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)] {
            let (x, y) = (100.0 * (u + i as f64), 100.0 * v);
            obj += &format!("v {x} {y} 0\nvt {} {v}\n", u + tile);
            ply += &format!("{x} {y} 0 {} {v}\n", u + tile);
        }
        let corners: Vec<String> = (1..5).map(|c| format!("{0}/{0}", first + c)).collect();
        obj += &format!("f {}\n", corners.join(" "));
    }
    for i in 0..4 {
        let first = 4 * i;
        ply += &format!(
            "4 {} {} {} {} {i}\n",
            first,
            first + 1,
            first + 2,
            first + 3
        );
    }
    let mtl: String = (0..3)
        .map(|i| format!("newmtl m{i}\nmap_Kd {}\n", names[i]))
        .collect();
    let header = ply_header(
        "ascii",
        "16",
        "property float s\nproperty float t\nelement face 4\nproperty list uchar int vertex_indices\n\
         property int texnumber\n",
    );
    let comments: String = names
        .map(|name| format!("comment TextureFile {name}\n"))
        .concat();
    let header = header.replace("1.0\n", &format!("1.0\n{comments}"));
    fs::write(folder.path().join("s.mtl"), mtl).expect("written");
    for (name, content) in [("s.obj", obj), ("s.ply", header + &ply)] {
        let file = folder.path().join(name);
        fs::write(&file, content).expect("written");
        let scan = Scan::read(&file, None).expect("reads");
        let texture = scan.texture.as_ref();
        let texture = texture.unwrap_or_else(|| panic!("{name}: {:?}", scan.notes));
        assert!(
            scan.notes
                .iter()
                .any(|note| note.contains("3 images as one")),
            "{:?}",
            scan.notes
        );
        assert_eq!(scan.triangles.len(), 8);
        for (triangle, uvs) in scan.triangles.iter().zip(&texture.triangles) {
            let middle = triangle
                .iter()
                .map(|&v| scan.positions[v as usize])
                .sum::<DVec3>()
                / 300.0;
            let image = middle.x as usize;
            let Some(halves) = colours.get(image) else {
                assert_eq!(*uvs, phiz::fit::scan::Texture::BARE, "{name}");
                continue;
            };
            let uv = uvs
                .iter()
                .map(|&uv| texture.uvs[uv as usize])
                .sum::<glam::DVec2>()
                / 3.0;
            let expected = halves[usize::from(middle.x.fract() > 0.5)];
            let apart = texture
                .sample(uv)
                .distance(DVec3::from_array(expected.map(f64::from)));
            assert!(apart < 1e-6, "{name} {image}: {apart}");
        }
    }
}

/// A picture in tiles, and one that is repeated beside itself.
#[test]
fn texture_coordinates_beyond_the_picture_are_in_other_tiles_or_in_it_again() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = |name: &str| folder.path().join(name);
    let paint = |name: &str, grey: u8| {
        let image = image::RgbImage::from_pixel(8, 8, image::Rgb([grey; 3]));
        image.save(path(name)).expect("written");
    };
    paint("skin.1001.png", 10);
    // Squares in the first tile, right of it, above it, two to the right, and left of all.
    let mut mesh = String::from("mtllib s.mtl\nusemtl skin\n");
    for (i, (right, up)) in [(0, 0), (1, 0), (0, 1), (2, 0), (-1, 0)].iter().enumerate() {
        for (u, v) in [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)] {
            let (x, y) = (100.0 * (u + i as f64), 100.0 * v);
            mesh += &format!(
                "v {x} {y} 0\nvt {} {}\n",
                u + f64::from(*right),
                v + f64::from(*up)
            );
        }
        let corners: Vec<String> = (1..5).map(|c| format!("{0}/{0}", 4 * i + c)).collect();
        mesh += &format!("f {}\n", corners.join(" "));
    }
    let read = |scan: &str, image: &str| {
        let mtl = format!("newmtl skin\nmap_Kd {image}\n");
        fs::write(path("s.mtl"), mtl).expect("written");
        fs::write(path(scan), &mesh).expect("written");
        let scan = Scan::read(&path(scan), None).expect("reads");
        let texture = scan.texture.expect("a picture");
        let mut greys = [None; 5];
        for (triangle, uvs) in scan.triangles.iter().zip(&texture.triangles) {
            let middle: f64 = triangle.iter().map(|&v| scan.positions[v as usize].x).sum();
            let uvs = uvs.map(|uv| texture.uvs.get(uv as usize));
            if let [Some(&a), Some(&b), Some(&c)] = uvs {
                let colour = texture.sample((a + b + c) / 3.0);
                greys[(middle / 300.0) as usize] = Some(colour.x.round() as u8);
            }
        }
        (greys, scan.notes)
    };
    let said = |notes: &[String], part: &str| notes.iter().any(|note| note.contains(part));
    let (greys, notes) = read("s.obj", "skin.<UDIM>.png");
    assert_eq!(greys, [Some(10); 5]);
    assert!(said(&notes, "skin.1001.png is repeated, as "), "{notes:?}");
    paint("skin.1002.png", 20);
    paint("skin.1011.png", 30);
    for image in ["skin.<UDIM>.png", "skin.1001.png"] {
        let (greys, notes) = read("s.obj", image);
        assert_eq!(greys, [Some(10), Some(20), Some(30), None, None], "{image}");
        assert!(said(&notes, "no texture: ") && said(&notes, "skin.1003.png"));
        assert!(
            said(&notes, "some faces are in no tile of "),
            "{image}: {notes:?}"
        );
    }
    // The next number is another person's.
    let (greys, _) = read("skin.1001.obj", "skin.1001.png");
    assert_eq!(greys, [Some(10); 5]);
}

#[test]
fn colours_of_vertices_are_read_as_programs_write_them() {
    let folder = tempfile::tempdir().expect("a folder");
    let read = |name: &str, content: &[u8]| {
        let file = folder.path().join(name);
        fs::write(&file, content).expect("written");
        Scan::read(&file, None).unwrap_or_else(|e| panic!("{e}"))
    };
    let colours = [[255, 0, 0], [0, 188, 0], [0, 0, 10]];
    // Depth cameras have vertices where they saw nothing.
    let corners = [
        [0.0f32, 0.0, 0.0],
        [100.0, 0.0, 0.0],
        [0.0, 100.0, 0.0],
        [f32::NAN; 3],
    ];
    for names in [
        ["red", "green", "blue"],
        ["diffuse_red", "diffuse_green", "diffuse_blue"],
        ["r", "g", "b"],
    ] {
        for kind in ["uchar", "ushort", "float"] {
            let rest: String = names
                .map(|name| format!("property {kind} {name}\n"))
                .concat();
            let rest = rest + "element face 1\nproperty list uchar int vertex_indices\n";
            let mut bytes = ply_header("binary_little_endian", "4", &rest).into_bytes();
            for (corner, colour) in corners.iter().zip(colours.iter().chain([&[1; 3]])) {
                bytes.extend(corner.iter().flat_map(|x| x.to_le_bytes()));
                for &value in colour {
                    match kind {
                        "uchar" => bytes.push(value),
                        "ushort" => bytes.extend((u16::from(value) * 257).to_le_bytes()),
                        _ => bytes.extend((f32::from(value) / 255.0).to_le_bytes()),
                    }
                }
            }
            bytes.extend([3, 0, 0, 0, 0, 1, 0, 0, 0, 2, 0, 0, 0]);
            let scan = read("c.ply", &bytes);
            assert_eq!(scan.colours, colours, "{names:?} {kind}");
        }
    }
    // glTF has light there: 188 is half of it, 10 a 329th.
    let light = [
        [1.0f32, 0.0, 0.0],
        [0.0, 0.502_886, 0.0],
        [0.0, 0.0, 0.003_035_27],
    ];
    let positions: Vec<u8> = corners[..3]
        .as_flattened()
        .iter()
        .flat_map(|x| (x / 1000.0).to_le_bytes())
        .collect();
    let floats: Vec<u8> = light
        .as_flattened()
        .iter()
        .flat_map(|x| x.to_le_bytes())
        .collect();
    let shorts: Vec<u8> = (light.iter())
        .flat_map(|c| [c[0], c[1], c[2], 0.5])
        .flat_map(|x| ((x * 65535.0).round() as u16).to_le_bytes())
        .collect();
    // Integers are parts of a whole whether that is written or not; nor are bounds by everyone.
    let said = r#""normalized":true,"#;
    for (kind, vector, bytes, normalized, bounds) in [
        (5126, 3, floats, "", r#","min":[0,0,0],"max":[0.1,0.1,0]"#),
        (5123, 4, shorts.clone(), said, r#","min":[null,0,0]"#),
        (5123, 4, shorts, "", ""),
    ] {
        let json = format!(
            r#"{{"asset":{{"version":"2.0"}},"scene":0,"scenes":[{{"nodes":[0]}}],"nodes":[{{"mesh":0}}],
            "meshes":[{{"primitives":[{{"attributes":{{"POSITION":0,"COLOR_0":1}}}}]}}],
            "accessors":[{{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"{bounds}}},
            {{"bufferView":1,"componentType":{kind},{normalized}"count":3,"type":"VEC{vector}"}}],
            "bufferViews":[{{"buffer":0,"byteLength":36}},{{"buffer":0,"byteOffset":36,"byteLength":{}}}],
            "buffers":[{{"byteLength":{}}}]}}"#,
            bytes.len(),
            36 + bytes.len()
        );
        let scan = read("c.glb", &glb(&json, &[positions.clone(), bytes].concat()));
        assert_eq!(scan.colours, colours, "{kind}");
    }
    // Where faces alone have colours, a vertex has the mean of those around it.
    let of_faces = FACES.replace("face 1", "face 2")
        + "property uchar red\nproperty uchar green\nproperty uchar blue\n";
    let rows = "0 0 0\n100 0 0\n0 100 0\n100 100 0\n3 0 1 2 255 0 0\n3 1 3 2 0 40 100\n";
    let scan = read(
        "f.ply",
        (ply_header("ascii", "4", &of_faces) + rows).as_bytes(),
    );
    let mean = [128, 20, 50];
    assert_eq!(scan.colours, [[255, 0, 0], mean, mean, [0, 40, 100]]);
    assert!(scan.notes.iter().any(|note| note.contains("of faces")));
}

#[test]
fn colours_in_numbers_of_any_kind_are_read() {
    let folder = tempfile::tempdir().expect("a folder");
    let read = |name: &str, content: &[u8]| {
        let file = folder.path().join(name);
        fs::write(&file, content).expect("written");
        Scan::read(&file, None).unwrap_or_else(|e| panic!("{e}"))
    };
    let said = |scan: &Scan| scan.notes.iter().any(|note| note.contains("from 0 to 255"));
    let corners = ["0 0 0", "100 0 0", "0 100 0"];
    let ply = |kind: &str, colours: [&str; 3]| {
        let rest = ["red", "green", "blue"].map(|c| format!("property {kind} {c}\n"));
        let rows: String = corners
            .iter()
            .zip(colours)
            .map(|(p, c)| format!("{p} {c}\n"))
            .collect();
        ply_header("ascii", "3", &(rest.concat() + FACES)) + &rows + "3 0 1 2\n"
    };
    // Integers of any size are those of bytes, floats too where they are above 1.
    for (kind, most) in [
        ("int", 255),
        ("uint", 255),
        ("short", 255),
        ("char", 127),
        ("float", 255),
    ] {
        let bright = format!("{most} 100 0");
        let scan = read("c.ply", ply(kind, [&bright, "1 1 1", "0 0 10"]).as_bytes());
        assert_eq!(
            scan.colours,
            [[most, 100, 0], [1, 1, 1], [0, 0, 10]],
            "{kind}"
        );
        assert_eq!(said(&scan), kind == "float", "{:?}", scan.notes);
    }
    let scan = read(
        "c.ply",
        ply("int", ["300 -5 7", "0 0 0", "0 0 0"]).as_bytes(),
    );
    assert_eq!(scan.colours[0], [255, 0, 7]);
    // A little more than white is white.
    let scan = read(
        "c.ply",
        ply("float", ["1.02 0.2 0", "1 1 1", "0 0 0"]).as_bytes(),
    );
    assert_eq!(scan.colours, [[255, 51, 0], [255; 3], [0; 3]]);
    assert!(!said(&scan));
    let obj = |colours: [&str; 3]| -> String {
        let rows = corners
            .iter()
            .zip(colours)
            .map(|(p, c)| format!("v {p} {c}\n"));
        rows.collect::<String>() + "f 1 2 3\n"
    };
    let scan = read("c.obj", obj(["255 100 0", "1 1 1", "0 0 10"]).as_bytes());
    assert_eq!(scan.colours, [[255, 100, 0], [1, 1, 1], [0, 0, 10]]);
    assert!(said(&scan), "{:?}", scan.notes);
}

#[test]
fn vertices_without_a_colour_among_others_are_white() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = |name: &str| folder.path().join(name);
    let (red, white) = ([255, 0, 0], [255; 3]);
    let text = "v 0 0 0\nv 100 0 0 1 0 0\nv 0 100 0\nf 1 2 3\n";
    fs::write(file("c.obj"), text).expect("written");
    // Two triangles, of which either has colours.
    let floats = |x: &[f32]| x.iter().flat_map(|x| x.to_le_bytes()).collect::<Vec<u8>>();
    let first = floats(&[0.0, 0.0, 0.0, 0.1, 0.0, 0.0, 0.0, 0.1, 0.0]);
    let second = floats(&[0.0, 0.0, 0.1, 0.1, 0.0, 0.1, 0.0, 0.1, 0.1]);
    let bytes = [first, second, floats(&[1.0, 0.0, 0.0].repeat(3))].concat();
    for (name, coloured) in [("0.glb", 0), ("1.glb", 1)] {
        let primitive = |i: usize| {
            let colour = if i == coloured { r#","COLOR_0":2"# } else { "" };
            format!(r#"{{"attributes":{{"POSITION":{i}{colour}}}}}"#)
        };
        let views =
            [0, 36, 72].map(|at| format!(r#"{{"buffer":0,"byteOffset":{at},"byteLength":36}}"#));
        let accessors = [0, 1, 2].map(|view| {
            format!(
                r#"{{"bufferView":{view},"componentType":5126,"count":3,"type":"VEC3","min":[0,0,0],"max":[1,1,1]}}"#
            )
        });
        let json = format!(
            r#"{{"asset":{{"version":"2.0"}},"scene":0,"scenes":[{{"nodes":[0]}}],"nodes":[{{"mesh":0}}],
            "meshes":[{{"primitives":[{},{}]}}],"accessors":[{}],"bufferViews":[{}],
            "buffers":[{{"byteLength":108}}]}}"#,
            primitive(0),
            primitive(1),
            accessors.join(","),
            views.join(",")
        );
        fs::write(file(name), glb(&json, &bytes)).expect("written");
    }
    for (name, expected, count) in [
        ("c.obj", vec![white, red, white], 2),
        ("0.glb", [[red; 3], [white; 3]].concat(), 3),
        ("1.glb", [[white; 3], [red; 3]].concat(), 3),
    ] {
        let scan = Scan::read(&file(name), None).unwrap_or_else(|e| panic!("{e}"));
        assert_eq!(scan.colours, expected, "{name}");
        let note = format!("colours: {count} vertices without one are white");
        assert!(scan.notes.contains(&note), "{name}: {:?}", scan.notes);
    }
}

#[test]
fn materials_are_in_all_the_files_of_a_line() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = |name: &str| folder.path().join(name);
    image::RgbImage::new(2, 2)
        .save(path("skin.png"))
        .expect("written");
    let material = "newmtl skin\nmap_Kd skin.png\n";
    let mesh =
        "v 0 0 0\nv 100 0 0\nv 0 100 0\nvt 0 0\nvt 1 0\nvt 0 1\nusemtl skin\nf 1/1 2/2 3/3\n";
    let read = |line: &str| {
        fs::write(path("m.obj"), format!("mtllib {line}\n{mesh}")).expect("written");
        Scan::read(&path("m.obj"), None).expect("reads")
    };
    fs::write(path("eyes.mtl"), "newmtl eyes\n").expect("written");
    fs::write(path("skin.mtl"), material).expect("written");
    let scan = read("eyes.mtl skin.mtl");
    assert!(scan.texture.is_some(), "{:?}", scan.notes);
    // A name with a space is one name, and stays one in words where it is not there.
    let scan = read("my skin.obj.mtl");
    let gone = |note: &String| note.contains("my skin.obj.mtl: ");
    assert!(scan.notes.iter().any(gone), "{:?}", scan.notes);
    fs::write(path("eyes.mtl skin.mtl"), "newmtl other\n").expect("written");
    assert!(read("eyes.mtl skin.mtl").texture.is_none());
}

/// What a file has beside its meshes is no reason to refuse these.
#[test]
fn gltf_with_more_than_meshes_is_read() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("t.gltf");
    let data = format!(
        "data:;base64,{}",
        Base64::encode_string(&triangle_bytes([0, 1, 2]))
    );
    let plain = String::from_utf8(gltf_triangle(&data)).expect("text");
    let read = |json: &str| {
        fs::write(&file, json).expect("written");
        Scan::read(&file, None)
    };
    let same = |json: &str| {
        assert_ne!(json, plain);
        let scan = read(json).unwrap_or_else(|e| panic!("{e}"));
        assert_eq!(scan.positions.len(), 3);
        scan.notes
    };
    same(&plain.replace(r#""POSITION":0"#, r#""POSITION":0,"_SCALE":0,"_ID":1"#));
    // What is to be seen may be left open.
    same(&plain.replace(r#""scene":0,"scenes":[{"nodes":[0]}],"#, ""));
    let sampler = r#""samplers":[{"input":0,"output":0}]"#;
    for target in [
        r#"{"path":"pointer","extensions":{"KHR_animation_pointer":{"pointer":"/nodes/0/scale"}}}"#,
        r#"{"path":"translation"}"#,
        r#"{"node":7,"path":"scale"}"#,
    ] {
        let animation = format!(r#"{{"channels":[{{"sampler":0,"target":{target}}}],{sampler}}}"#);
        same(&plain.replacen('{', &format!(r#"{{"animations":[{animation}],"#), 1));
    }
    let notes = same(
        &plain
            .replace(r#""mesh":0"#, r#""mesh":0,"skin":0"#)
            .replacen('{', r#"{"skins":[{"joints":[0]}],"#, 1),
    );
    let skin = notes
        .iter()
        .filter(|note| note.contains("skin 0 is there and was not applied"));
    assert_eq!(skin.count(), 1, "{notes:?}");

    // Nodes in a chain as deep as it likes; but each in one place, or there were 2^60 triangles.
    let (before, after) = plain
        .split_once(r#""nodes":[{"mesh":0,"translation":[0,1,0]}]"#)
        .expect("a node");
    let chain = |count: usize, children: fn(usize) -> String| {
        let nodes: Vec<String> = (1..count)
            .map(|next| format!(r#"{{"children":[{}]}}"#, children(next)))
            .collect();
        format!(
            r#"{before}"nodes":[{},{{"mesh":0}}]{after}"#,
            nodes.join(",")
        )
    };
    same(&chain(20_000, |next| next.to_string()));
    for json in [
        chain(60, |next| format!("{next},{next}")),
        chain(3, |next| (next - 1).to_string()),
    ] {
        let error = read(&json).map(|_| ()).expect_err("no tree").to_string();
        one_line(
            "nodes",
            &error,
            &file,
            &["in two places, or among its own parents"],
        );
    }
}

#[test]
fn landmarks_of_which_nobody_knows_how_far_they_are_off_are_written_without_that() {
    let template = template();
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("l.json");
    let points: Vec<(usize, DVec3)> = points(&template).into_iter().enumerate().collect();
    let mut errors = vec![0.5; points.len()];
    errors[..3].copy_from_slice(&[f64::INFINITY, f64::NAN, 0.0]);
    landmarks::write(&file, &points, &errors, 1.0, &template).expect("written");
    let bytes = fs::read(&file).expect("reads");
    let json: serde_json::Value = serde_json::from_slice(&bytes).expect("JSON");
    let numbers = |i: usize| json[format!("ibug_{i:02}")].as_array().map_or(0, Vec::len);
    assert_eq!([0, 1, 2, 3].map(numbers), [4, 3, 3, 4]);
    // What the scan does not show may be anywhere, and is no landmark that a hand has set.
    let scan = folder.path().join("a.obj");
    for (by, unit) in [(1.0, 1.0), (0.1, 10.0)] {
        let (positions, triangles) = egg();
        let positions: Vec<DVec3> = positions.iter().map(|p| *p * by).collect();
        fs::write(&scan, obj(&positions, &triangles)).expect("written");
        landmarks::write(&file, &points, &errors, unit, &template).expect("written");
        let mut scan = Scan::read(&scan, None).expect("reads");
        let read = landmarks::read(&file, &mut scan, &template).expect("reads");
        let places: Vec<usize> = read.points.iter().map(|p| p.0).collect();
        assert_eq!(places, (1..68).collect::<Vec<_>>());
    }
    errors[..65].fill(f64::INFINITY);
    landmarks::write(&file, &points, &errors, 10.0, &template).expect("written");
    let mut scan = Scan::read(&scan, None).expect("reads");
    let error = landmarks::read(&file, &mut scan, &template).expect_err("too few");
    one_line(
        "anywhere",
        &error.to_string(),
        &file,
        &["3 landmarks that are not off by 100 mm"],
    );
}

#[test]
fn a_scan_says_which_files_belong_to_it() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = |name: &str| folder.path().join(name);
    let write = |name: &str, bytes: &[u8]| std::fs::write(at(name), bytes).expect("writes");
    let (positions, triangles) = egg();
    let mesh = obj(&positions, &triangles);
    write(
        "a.obj",
        format!("mtllib a.mtl\nmtllib gone.mtl\n{mesh}").as_bytes(),
    );
    write("a.mtl", b"newmtl skin\nmap_Kd skin.png\n");
    let scan = Scan::read(&at("a.obj"), None).expect("reads");
    for name in ["a.mtl", "gone.mtl", "skin.png"] {
        assert!(scan.beside.contains(&at(name)), "{name}: {:?}", scan.beside);
    }
    write("a.gltf", &gltf_triangle("my%20buffer.bin"));
    write("my buffer.bin", &triangle_bytes([0, 1, 2]));
    let scan = Scan::read(&at("a.gltf"), Some(phiz::fit::scan::Unit::Metre)).expect("reads");
    assert_eq!(scan.beside, [at("my buffer.bin")]);
}
