//! One mesh is read from every format, whichever program wrote it.

use std::fs;

use base64ct::{Base64, Encoding};
use glam::DVec3;
use phiz::fit::scan::Scan;

use crate::scan_files::{
    FACES, egg, glb, glb_triangle, gltf_triangle, obj, one_line, ply_header, stl, triangle_bytes,
};

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
