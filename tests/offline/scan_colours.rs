//! Pictures and colours of scans, from every format.

use std::fs;

use glam::DVec3;
use phiz::fit::scan::Scan;

use crate::scan_files::{FACES, glb, ply_header};

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
