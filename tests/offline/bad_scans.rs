//! Bad scans and landmarks, each kind with the one clear line that it gets, and odd ones that are
//! read all the same and said.

use std::fs;
use std::path::PathBuf;

use base64ct::{Base64, Encoding};
use glam::DVec3;
use phiz::fit::scan::{Scan, landmarks};

use crate::scan_files::{
    FACES, egg, glb, glb_extended, glb_triangle, gltf_triangle, json, obj, one_line, picked,
    ply_header, points, read, stl, template, triangle_bytes,
};

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
