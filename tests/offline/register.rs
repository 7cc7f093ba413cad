//! Registration: what is known of the truth comes out, and what must not matter does not.

use std::path::PathBuf;
use std::sync::OnceLock;

use glam::{DMat3, DVec3};
use phiz::Random;
use phiz::fit::evaluate::Evaluator;
use phiz::fit::format::ply::write_mesh;
use phiz::fit::head::expression::{Expressions, Performer};
use phiz::fit::head::template::Template;
use phiz::fit::mesh::align::Rigid;
use phiz::fit::mesh::mirror::flip;
use phiz::fit::mesh::surface::normals;
use phiz::fit::register::batch::{Job, prepare, register_scan};
use phiz::fit::register::{Pulls, Registered, Registrar, Settings};
use phiz::fit::scan::{Scan, landmarks};
use phiz::fit::truth::simulate::{self, Simulator};

use crate::{base_mesh, heads, ict, james};

/// A bent head, the scan of it and what became of that, once for all tests.
struct Given {
    template: &'static Template,
    registrar: &'static Registrar<'static>,
    head: Vec<DVec3>,
    scan: Scan,
    points: Pulls,
    registered: Registered,
}

fn given() -> Option<&'static Given> {
    static GIVEN: OnceLock<Option<Given>> = OnceLock::new();
    GIVEN
        .get_or_init(|| {
            let (template, registrar) = (heads::template()?, heads::registrar()?);
            let head = heads::bent(template, 1);
            let scan = heads::scan(template, &head, 2);
            let points = heads::points(template, &head);
            let registered = registrar.register(&scan, &points, &Settings::default());
            Some(Given {
                registered: registered.expect("registers"),
                template,
                registrar,
                head,
                scan,
                points,
            })
        })
        .as_ref()
}

impl Given {
    /// Some of the landmarks.
    fn named(&self, names: &[&str]) -> Pulls {
        let wanted = |l: usize| names.contains(&&self.template.landmarks[l].name[..]);
        let points = self.points.iter().filter(|p| wanted(p.0));
        points.copied().collect()
    }

    /// Mean distance of the features' covered vertices from where they belong, mm.
    fn drift(&self, registered: &Registered, truth: &[DVec3]) -> f64 {
        let lengths: Vec<f64> = features(self.template)
            .filter(|&v| registered.covered[v])
            .map(|v| registered.positions[v].distance(truth[v]))
            .collect();
        // Most of the features is where scanners look.
        assert!(4 * lengths.len() > 3 * features(self.template).count());
        lengths.iter().sum::<f64>() / lengths.len() as f64
    }
}

/// The vertices of the skin of eyes, nose, mouth, chin and forehead.
fn features(template: &Template) -> impl Iterator<Item = usize> {
    let topology = &template.topology;
    let skin = template.part_vertices("skin").expect("it has skin");
    let region = |v: usize| &topology.region_names[topology.regions[v] as usize];
    skin.into_iter()
        .map(|v| v as usize)
        .filter(move |&v| region(v) != "head")
}

/// The greatest distance between the same vertices of two heads, mm.
fn farthest(one: &[DVec3], other: &[DVec3]) -> f64 {
    assert_eq!(one.len(), other.len());
    let apart = one.iter().zip(other).map(|(a, b)| a.distance(*b));
    apart.fold(0.0, |most, d| if d > most || d.is_nan() { d } else { most })
}

/// Numbers all over, and eyeballs as hard as they are.
fn sound(template: &Template, positions: &[DVec3]) {
    assert_eq!(positions.len(), template.positions.len());
    assert!(positions.iter().all(|p| p.is_finite()));
    for eye in ["left eyeball", "right eyeball"] {
        let eye = template.part_vertices(eye).expect("it has eyes");
        let rigid = Rigid::fit(
            &template.positions,
            positions,
            &eye,
            &vec![1.0; positions.len()],
        );
        for v in eye {
            let meant = rigid.apply(template.positions[v as usize]);
            assert!(meant.distance(positions[v as usize]) < 1e-9);
        }
    }
}

#[test]
fn a_bent_head_is_found_again() {
    let Some(given) = given() else { return };
    let registered = &given.registered;
    sound(given.template, &registered.positions);
    let drift = given.drift(registered, &given.head);
    println!("drift {drift:.3} mm");
    // What is measured is 0.46 mm, most of it along the skin of a shape that no person has.
    assert!(drift < 0.5, "{drift}");
    // What no scanner sees goes along. The waves bend it otherwise than the skin around it tells,
    // by about their height of 3 mm.
    for part in [
        "mouth cavity",
        "eye cavities",
        "left eyeball",
        "right eyeball",
    ] {
        let vertices = given.template.part_vertices(part).expect(part);
        let apart = vertices.iter().map(|&v| {
            let v = v as usize;
            registered.positions[v].distance(given.head[v])
        });
        let mean = apart.sum::<f64>() / vertices.len() as f64;
        println!("{part}: {mean:.3} mm");
        assert!(mean < 4.0, "{part}: {mean}");
    }
}

#[test]
fn where_the_scan_is_does_not_matter() {
    let Some(given) = given() else { return };
    let motion = Rigid {
        rotation: DMat3::from_rotation_y(1.1) * DMat3::from_rotation_x(-2.0),
        translation: DVec3::new(310.0, -120.0, 75.0),
    };
    let mut scan = given.scan.clone();
    scan.positions
        .iter_mut()
        .for_each(|p| *p = motion.apply(*p));
    let points: Pulls = given
        .points
        .iter()
        .map(|&(l, p)| (l, motion.apply(p)))
        .collect();
    let moved = given
        .registrar
        .register(&scan, &points, &Settings::default());
    let moved = moved.expect("registers").positions;
    let meant: Vec<DVec3> = given
        .registered
        .positions
        .iter()
        .map(|&p| motion.apply(p))
        .collect();
    let apart = farthest(&moved, &meant);
    println!("{apart:.2e} mm apart");
    // Rounding; no decision hangs on it.
    assert!(apart < 1e-6, "{apart}");
}

#[test]
fn the_order_of_vertices_and_triangles_does_not_matter() {
    let Some(given) = given() else { return };
    let mut random = Random::new(3);
    let mut shuffled = |n: usize| {
        let mut order: Vec<(u64, u32)> = (0..n as u32).map(|i| (random.bits(), i)).collect();
        order.sort_unstable();
        order.into_iter().map(|o| o.1 as usize).collect::<Vec<_>>()
    };
    let (vertices, triangles) = (
        shuffled(given.scan.positions.len()),
        shuffled(given.scan.triangles.len()),
    );
    let mut number = vec![0; vertices.len()];
    (0..).zip(&vertices).for_each(|(i, &v)| number[v] = i);
    let scan = Scan {
        positions: vertices.iter().map(|&v| given.scan.positions[v]).collect(),
        triangles: triangles
            .iter()
            .map(|&t| {
                let [a, b, c] = given.scan.triangles[t].map(|v| number[v as usize]);
                [b, c, a]
            })
            .collect(),
        ..given.scan.clone()
    };
    let points: Pulls = given.points.iter().rev().copied().collect();
    let other = given
        .registrar
        .register(&scan, &points, &Settings::default());
    let apart = farthest(
        &other.expect("registers").positions,
        &given.registered.positions,
    );
    println!("{apart:.2e} mm apart");
    // Rounding; no decision hangs on it.
    assert!(apart < 1e-6, "{apart}");
}

#[test]
fn threads_and_repetition_do_not_matter() {
    let Some(given) = given() else { return };
    for threads in [1, 4] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        let register = || {
            let settings = Settings::default();
            given
                .registrar
                .register(&given.scan, &given.points, &settings)
        };
        let again = pool.expect("threads").install(register).expect("registers");
        assert_eq!(again.positions, given.registered.positions);
        assert_eq!(again.covered, given.registered.covered);
    }
}

#[test]
fn a_symmetric_scan_gives_a_symmetric_face() {
    let Some(given) = given() else { return };
    let rest = &given.template.positions;
    // The shape is symmetric, the triangles are not.
    let scan = heads::scan(given.template, rest, 4);
    let points = heads::points(given.template, rest);
    let registered = given
        .registrar
        .register(&scan, &points, &Settings::default());
    let registered = registered.expect("registers");
    let mirror = &given.template.topology.mirror;
    let uneven: Vec<f64> = features(given.template)
        .map(|v| {
            let other = flip(registered.positions[mirror[v] as usize]);
            registered.positions[v].distance(other)
        })
        .collect();
    let mean = uneven.iter().sum::<f64>() / uneven.len() as f64;
    let drift = given.drift(&registered, rest);
    println!("uneven by {mean:.3} mm, drift {drift:.3} mm");
    // Edges cut corners on the two sides in different places; measured is 0.014 mm.
    assert!(mean < 0.04, "{mean}");
    assert!(drift < 0.08, "{drift}");
}

#[test]
fn the_template_stays_on_itself() {
    let Some(given) = given() else { return };
    let rest = &given.template.positions;
    let scan = heads::skin(given.template, rest);
    let points = heads::points(given.template, rest);
    let registered = given
        .registrar
        .register(&scan, &points, &Settings::default());
    let drift = given.drift(&registered.expect("registers"), rest);
    println!("drift {drift:.4} mm");
    // Twice what is measured: the fit starts from the prior, not from the rest pose.
    assert!(drift < 0.05, "{drift}");
}

/// Someone whom the prior can tell, and what became of their scan when `raise` lifts what lies so
/// high above the tip of the nose and so far behind it (mm) by so much (mm). The truth comes with
/// how high and how far behind each vertex lies.
fn raised(
    given: &Given,
    raise: impl Fn(f64, f64) -> f64,
) -> (Vec<DVec3>, Vec<(f64, f64)>, Registered) {
    let prior = given.template.prior.as_ref().expect("it has a prior");
    let mut random = Random::new(5);
    let usual: Vec<f64> = prior.modes.iter().map(|_| random.normal()).collect();
    let head = prior.face(&given.template.positions, &usual);
    let points = heads::points(given.template, &head);
    let names = |p: &&(usize, DVec3)| given.template.landmarks[p.0].name == "ibug_30";
    let tip = points.iter().find(names).expect("it has a nose").1;
    let from_tip = |p: &DVec3| (p.y - tip.y, tip.z - p.z);
    let mut scan = heads::scan(given.template, &head, 6);
    let facing = normals(&scan.positions, &scan.triangles);
    for (p, normal) in scan.positions.iter_mut().zip(facing) {
        let (above, behind) = from_tip(p);
        *p += normal * raise(above, behind);
    }
    let registered = (given.registrar).register(&scan, &points, &Settings::default());
    let places = head.iter().map(from_tip).collect();
    (head, places, registered.expect("registers"))
}

#[test]
fn hair_is_not_taken_for_a_larger_head() {
    let Some(given) = given() else { return };
    // 0 to 1: above the brows and behind the ears.
    let hair = |above: f64, behind: f64| {
        let crown = (above - 85.0) / 10.0;
        let back = ((behind - 95.0) / 12.0).min((above + 90.0) / 20.0);
        crown.max(back).clamp(0.0, 1.0)
    };
    let skin = given.template.part_vertices("skin").expect("it has skin");
    let off = |thick: f64| {
        let (head, places, registered) = raised(given, |above, behind| thick * hair(above, behind));
        let mean = |wanted: &dyn Fn(f64, f64) -> bool| {
            let lengths: Vec<f64> = (skin.iter().map(|&v| v as usize))
                .filter(|&v| wanted(places[v].0, places[v].1))
                .map(|v| registered.positions[v].distance(head[v]))
                .collect();
            lengths.iter().sum::<f64>() / lengths.len() as f64
        };
        let face = mean(&|above, behind| behind < 60.0 && hair(above, behind) == 0.0);
        let skull = mean(&|above, behind| hair(above, behind) == 1.0);
        println!("{thick} mm of hair: face {face:.2} mm, skull {skull:.2} mm");
        (face, skull)
    };
    let (face, skull) = off(0.0);
    assert!(face < 0.06 && skull < 0.25, "{face} {skull}");
    // Measured are 0.17 and 6.0 mm, and 0.43 and 15.8 where hair is taken for skin.
    let (face, skull) = off(20.0);
    assert!(face < 0.3 && skull < 10.0, "{face} {skull}");
}

#[test]
fn a_large_skull_is_no_hair() {
    let Some(given) = given() else { return };
    // 15 mm at the crown, over 60.
    let rise = |above: f64, behind: f64| {
        let t = (0.8 * (above - 60.0) + 0.6 * (behind - 100.0) + 10.0) / 60.0;
        let t = t.clamp(0.0, 1.0);
        15.0 * t * t * (3.0 - 2.0 * t)
    };
    let (_, places, registered) = raised(given, rise);
    let skin = given.template.part_vertices("skin").expect("it has skin");
    let crown = |v: &&u32| {
        let (above, behind) = places[**v as usize];
        rise(above, behind) == 15.0
    };
    let crown: Vec<&u32> = skin.iter().filter(crown).collect();
    let followed = crown.iter().filter(|v| registered.covered[***v as usize]);
    let followed = followed.count() as f64 / crown.len() as f64;
    println!("{followed:.3} of {} vertices", crown.len());
    // Measured are all.
    assert!(followed > 0.95, "{followed}");
}

#[test]
fn holes_are_bridged_and_said() {
    let Some(given) = given() else { return };
    let at = |name: &str| {
        let place = given.template.landmarks.iter().position(|l| l.name == name);
        given.template.landmark(place.expect(name), &given.head)
    };
    // A cheek, the tip of the nose, and all that is behind the ears.
    let discs = [(at("cheek left"), 15.0), (at("ibug_30"), 6.0)];
    let back = at("tragion left").z - 30.0;
    let inside = |p: DVec3, grown: f64| {
        p.z < back + grown || discs.iter().any(|&(c, r)| p.distance(c) < r + grown)
    };
    let mut scan = given.scan.clone();
    scan.triangles.retain(|t| {
        !t.iter()
            .any(|&v| inside(given.scan.positions[v as usize], 0.0))
    });
    let mut number = vec![u32::MAX; scan.positions.len()];
    let mut kept = Vec::new();
    for corner in scan.triangles.as_flattened_mut() {
        let slot = &mut number[*corner as usize];
        if *slot == u32::MAX {
            *slot = kept.len() as u32;
            kept.push(given.scan.positions[*corner as usize]);
        }
        *corner = *slot;
    }
    scan.positions = kept;
    let registered = given
        .registrar
        .register(&scan, &given.points, &Settings::default());
    let registered = registered.expect("registers");
    sound(given.template, &registered.positions);
    let apart = |v: usize| registered.positions[v] - given.registered.positions[v];
    let (mut counted, mut lost, mut wrong) = (0, 0, 0);
    let (mut on_face, mut behind) = (0.0_f64, 0.0_f64);
    for v in given.template.part_vertices("skin").expect("it has skin") {
        let v = v as usize;
        let truth = given.head[v];
        // Edges of the scan are 1.5 mm long, so the hole's border is known to 2 mm.
        if inside(truth, -2.0) {
            // Where it is now, not where it belongs: a vertex may slide out over the border.
            let within = inside(registered.positions[v], -2.0);
            wrong += usize::from(within && registered.covered[v]);
            let most = if truth.z > back {
                &mut on_face
            } else {
                &mut behind
            };
            *most = most.max(apart(v).length());
        } else if !inside(truth, 6.0) && given.registered.covered[v] {
            counted += 1;
            lost += usize::from(!registered.covered[v]);
        }
    }
    println!("{wrong} covered in the hole, {lost} of {counted} uncovered elsewhere");
    println!("moved by {on_face:.2} mm in the face, {behind:.2} mm behind");
    assert_eq!(wrong, 0);
    assert!(100 * lost < counted, "{lost} of {counted}");
    // The skin goes over a cheek and the tip of a nose as people's do; the back of a head that is
    // seen from before the ears is a guess.
    assert!(on_face < 1.5 && behind < 20.0, "{on_face} {behind}");
    // Smoothly: no edge changes by as much as its length, or as half a millimetre where lids have
    // edges of a tenth.
    let skin = given.template.part_triangles("skin").expect("it has skin");
    let edges = skin.iter().flat_map(|&[a, b, c]| [(a, b), (b, c), (c, a)]);
    let stretch = edges.map(|(a, b)| {
        let (a, b) = (a as usize, b as usize);
        (apart(a) - apart(b)).length() / given.head[a].distance(given.head[b]).max(0.5)
    });
    let stretch = stretch.fold(0.0, f64::max);
    println!("edges stretch by {stretch:.2}");
    assert!(stretch < 1.0, "{stretch}");
}

/// What a head shows here, how strongly.
const SHOWN: [(&str, f64); 3] = [
    ("mouthSmileLeft", 0.8),
    ("mouthSmileRight", 0.8),
    ("jawOpen", 0.4),
];

#[test]
fn an_expression_is_told_helps_and_is_taken_off() {
    let Some(given) = given() else { return };
    let template = given.template;
    let folder = base_mesh::folder().expect("the template is made of it");
    let files = SHOWN.map(|(name, _)| [name]);
    let named: Vec<(&str, &[&str])> = files.iter().map(|f| (f[0], f.as_slice())).collect();
    let expressions = Expressions::read(&named, template, &folder).expect("reads");
    let performer = Performer::new(template, &expressions).expect("has skin");
    // As that head shows them, which is not quite as the rest pose does.
    let mut head = given.head.clone();
    for (expression, (_, strength)) in expressions.list.iter().zip(SHOWN) {
        let there = performer.on(&given.head, expression);
        for ((p, there), rest) in head.iter_mut().zip(there).zip(&given.head) {
            *p += (there - *rest) * strength;
        }
    }
    let scan = heads::scan(template, &head, 2);
    let points = heads::points(template, &head);
    let register = |registrar: &Registrar<'_>| {
        let registered = registrar.register(&scan, &points, &Settings::default());
        registered.expect("registers")
    };
    let registered = register(given.registrar);
    sound(template, &registered.positions);
    let without = Template {
        expressions: Vec::new(),
        ..template.clone()
    };
    let without = register(&Registrar::new(&without).expect("prepares"));
    let (drift, former) = (
        given.drift(&registered, &head),
        given.drift(&without, &head),
    );
    println!("drift {drift:.3} mm, without expressions {former:.3} mm");
    println!("{}", registered.summary());
    // Measured: 0.48 and 0.66 mm, of a head that no prior knows either.
    assert!(drift < 0.85 * former, "{drift} {former}");
    assert!(without.expressions.is_empty() && !without.summary().contains("shows"));
    let found = |name: &str| {
        let mut found = registered.expressions.iter();
        found.find(|e| e.0 == name).map_or(0.0, |e| e.1)
    };
    for (name, strength) in SHOWN {
        assert!(
            (found(name) - strength).abs() < 0.2,
            "{name} {}",
            found(name)
        );
        assert!(registered.summary().contains(name));
    }
    // The face at rest, from a scan that never shows it.
    let mean = |face: &[DVec3]| {
        let apart = features(template).map(|v| face[v].distance(given.head[v]));
        apart.sum::<f64>() / features(template).count() as f64
    };
    let (shown, neutral) = (mean(&registered.positions), mean(&registered.neutral()));
    println!("{shown:.3} mm from the face at rest, {neutral:.3} mm without the expression");
    assert!(neutral < 0.5 * shown, "{neutral} {shown}");
    let corner = |points: &Pulls| {
        let name = |p: &&(usize, DVec3)| template.landmarks[p.0].name == "ibug_48";
        points.iter().find(name).expect("is there").1
    };
    let there = registered.neutral_points(template, &points);
    let [rest, moved, back] = [&given.points, &points, &there].map(corner);
    assert!(
        back.distance(rest) < 0.4 * moved.distance(rest),
        "{back} {rest}"
    );
}

#[test]
fn a_template_keeps_its_expressions() {
    let Some(template) = heads::template() else {
        return;
    };
    let bytes = template.to_bytes().expect("writes");
    let read = Template::from_bytes(&bytes).expect("reads");
    assert_eq!(read.expressions.len(), template.expressions.len());
    for (read, written) in read.expressions.iter().zip(&template.expressions) {
        assert_eq!(read.name, written.name);
        // Displacements of centimetres in f32.
        assert!(farthest(&read.displacements, &written.displacements) < 1e-5);
    }
    let without = Template {
        expressions: Vec::new(),
        ..template.clone()
    };
    let bytes = without.to_bytes().expect("writes");
    assert!(
        Template::from_bytes(&bytes)
            .expect("reads")
            .expressions
            .is_empty()
    );
}

#[test]
fn with_little_to_start_from_it_works_too() {
    let Some(given) = given() else { return };
    let run = |points: &Pulls, prior: bool| {
        let settings = Settings {
            prior,
            ..Settings::default()
        };
        let registered = given.registrar.register(&given.scan, points, &settings);
        let registered = registered.expect("registers");
        sound(given.template, &registered.positions);
        given.drift(&registered, &given.head)
    };
    let four = given.named(&["ibug_36", "ibug_45", "ibug_30", "ibug_08"]);
    let without_prior = run(&given.points, false);
    let of_four = run(&four, true);
    // Landmarks that are found: of the scan as a file, in another pose.
    let folder = tempfile::tempdir().expect("a folder");
    let job = Job {
        scan: folder.path().join("scan.ply"),
        landmarks: None,
        output: folder.path().join("face.ply"),
    };
    let turn = DMat3::from_rotation_y(0.5) * DMat3::from_rotation_z(-0.4);
    let turned: Vec<DVec3> = given.scan.positions.iter().map(|&p| turn * p).collect();
    write_mesh(&job.scan, &turned, &given.scan.triangles).expect("writes");
    let (prepared, found) =
        register_scan(given.registrar, &job, None, &Settings::default()).expect("registers");
    assert!(
        prepared
            .notes
            .iter()
            .any(|n| n.contains("found without a hand"))
    );
    let truth: Vec<DVec3> = given.head.iter().map(|&p| turn * p).collect();
    let of_found = given.drift(&found, &truth);
    println!("drift: no prior {without_prior:.3}, 4 points {of_four:.3}, found {of_found:.3} mm");
    // Waves suit a warp, which follows them better than a prior of people can. Few or rough
    // landmarks leave the slide to the shape of the skin: half as much again as what is measured.
    assert!(without_prior < 0.25, "{without_prior}");
    assert!(of_four < 1.2, "{of_four}");
    assert!(of_found < 1.2, "{of_found}");
}

#[test]
fn points_are_believed_by_their_own_errors() {
    let Some(given) = given() else { return };
    // The chin and a corner of the mouth were set wrong by 5 mm, the others exactly.
    let wrong = given.named(&["ibug_08", "ibug_48"]);
    let mut points = given.points.clone();
    for (l, p) in &mut points {
        if wrong.iter().any(|w| w.0 == *l) {
            *p += DVec3::new(4.0, 3.0, 0.0);
        }
    }
    let off = |errors: Vec<f64>| {
        let settings = Settings {
            point_errors: errors,
            ..Settings::default()
        };
        let registered = given.registrar.register(&given.scan, &points, &settings);
        let registered = registered.expect("registers");
        let at = |&(l, p): &(usize, DVec3)| {
            given
                .template
                .landmark(l, &registered.positions)
                .distance(p)
        };
        wrong.iter().map(at).sum::<f64>() / wrong.len() as f64
    };
    let mut known = vec![0.0; given.template.landmarks.len()];
    for (l, _) in &wrong {
        known[*l] = 5.0;
    }
    let (believed, doubted) = (off(Vec::new()), off(known));
    println!("{believed:.2} mm off, {doubted:.2} mm where they are doubted");
    assert!(doubted < 0.5 * believed, "{doubted} {believed}");
}

#[test]
fn points_that_were_exchanged_are_named_and_bend_no_face() {
    let Some(given) = given() else { return };
    let mut points = given.points.clone();
    let swapped = given.named(&["ibug_36", "ibug_39"]);
    for (l, p) in &mut points {
        if let Some(at) = swapped.iter().position(|s| s.0 == *l) {
            *p = swapped[1 - at].1;
        }
    }
    let registered = (given.registrar).register(&given.scan, &points, &Settings::default());
    let registered = registered.expect("registers");
    let names: Vec<&str> = registered.strays.iter().map(|s| &*s.0).collect();
    assert_eq!(names, ["ibug_36", "ibug_39"]);
    let apart = swapped[0].1.distance(swapped[1].1);
    for (name, far) in &registered.strays {
        assert!((far - apart).abs() < 3.0, "{name}: {far} of {apart}");
    }
    assert!(given.registered.strays.is_empty());
    let off = farthest(&registered.positions, &given.registered.positions);
    println!("{off:.2} mm from the face of the right points at most");
    // Without these two points the corners are where the surface and the others have them: 3.07 mm.
    assert!(off < 5.0, "{off}");

    // In a file that is said, and they are not among the points that the face goes with.
    let folder = tempfile::tempdir().expect("a folder");
    let job = Job {
        scan: folder.path().join("scan.ply"),
        landmarks: Some(folder.path().join("scan.json")),
        output: folder.path().join("face.ply"),
    };
    write_mesh(&job.scan, &given.scan.positions, &given.scan.triangles).expect("writes");
    let file = job.landmarks.as_deref().expect("a file");
    landmarks::write(file, &points, &[], 1.0, given.template).expect("writes");
    let (prepared, _) =
        register_scan(given.registrar, &job, None, &Settings::default()).expect("registers");
    let note =
        "landmarks: left out, as the surface and the others have them elsewhere: `ibug_36` by ";
    assert!(
        prepared.notes.iter().any(|n| n.starts_with(note)),
        "{:?}",
        prepared.notes
    );
    assert_eq!(prepared.points.len(), points.len() - 2);
}

#[test]
fn points_that_were_found_are_as_certain_in_a_file() {
    let (Some(given), Some(folder)) = (given(), james::james()) else {
        return;
    };
    let root = tempfile::tempdir().expect("a folder");
    // In centimetres, as points and errors then are.
    let mut scan = Scan::read(&folder.join("james.obj"), None).expect("reads");
    scan.positions.iter_mut().for_each(|p| *p *= 0.1);
    let (mesh, file) = (
        root.path().join("james.ply"),
        root.path().join("james.json"),
    );
    write_mesh(&mesh, &scan.positions, &scan.triangles).expect("writes");
    let found = prepare(given.registrar, &mesh, None, None).expect("a face");
    assert_eq!(found.scan.scale, 10.0);
    landmarks::write(&file, &found.points, &found.errors, 10.0, given.template).expect("writes");
    let read = prepare(given.registrar, &mesh, Some(&file), None).expect("a face");
    assert_eq!(read.points.len(), found.points.len());
    for (&(l, a), &(m, b)) in read.points.iter().zip(&found.points) {
        assert_eq!(l, m);
        assert!(a.distance(b) < 1e-9, "{a} {b}");
        let (a, b) = (read.errors[l], found.errors[l]);
        assert!(b > 0.3 && (a - b).abs() < 1e-9, "{a} {b}");
    }
}

#[test]
fn lips_of_a_real_scan_are_shut_without_a_hand() {
    let (Some(given), Some(folder)) = (given(), james::james()) else {
        return;
    };
    let job = Job {
        scan: folder.join("james.obj"),
        landmarks: None,
        output: PathBuf::new(),
    };
    let (_, face) =
        register_scan(given.registrar, &job, None, &Settings::default()).expect("registers");
    let [upper, lower] = ["ibug_62", "ibug_66"].map(|name| {
        let at = given.template.landmarks.iter().position(|l| l.name == name);
        given
            .template
            .landmark(at.expect("is there"), &face.positions)
    });
    // 0.3 by the scan's own landmarks; 4.0 when the line that was found counted as little as brows did.
    let apart = upper.distance(lower);
    println!("lips {apart:.2} mm apart");
    assert!(apart < 2.0, "{apart}");
}

#[test]
fn what_cannot_be_registered_is_an_error() {
    let Some(given) = given() else { return };
    let error = |scan: &Scan, points: &[(usize, DVec3)]| {
        let result = given.registrar.register(scan, points, &Settings::default());
        result.map(|_| ()).expect_err("no").to_string()
    };
    for count in 0..4 {
        let said = error(&given.scan, &given.points[..count]);
        assert_eq!(said, format!("{count} landmarks, where a pose needs four"));
    }
    let place = given.points[0].1;
    let one_place: Pulls = given.points.iter().map(|p| (p.0, place)).collect();
    assert!(error(&given.scan, &one_place).contains("at one place"));
    let flat: Pulls = given
        .points
        .iter()
        .map(|p| (p.0, p.1.with_z(0.0)))
        .collect();
    assert!(error(&given.scan, &flat).contains("in one plane"));
    assert!(error(&Scan::default(), &given.points).contains("no triangles"));
}

#[test]
fn people_are_registered_as_well_as_promised() {
    let (Some(given), Some(ict)) = (given(), ict::ict()) else {
        return;
    };
    let register = |scan: &Scan, landmarks: &[DVec3]| {
        let points: Pulls = given
            .points
            .iter()
            .zip(landmarks)
            .map(|(p, &q)| (p.0, q))
            .collect();
        let registered = given
            .registrar
            .register(scan, &points, &Settings::default());
        registered.expect("registers").positions
    };
    let mean = Scan {
        positions: ict.neutral.clone(),
        triangles: ict.triangles.clone(),
        scale: 1.0,
        ..Scan::default()
    };
    let reference = register(&mean, &ict.landmarks.map(|v| ict.neutral[v as usize]));
    let none = Expressions::default();
    let evaluator = Evaluator::new(given.template, &reference, ict, &none).expect("binds");
    let simulator = Simulator::new(ict);
    let measure = |seed, noise, jitter| {
        let settings = simulate::Settings {
            noise,
            jitter,
            holes: false,
        };
        let person = simulator.scan(seed, &settings);
        let face = register(&person.scan, &person.landmarks);
        sound(given.template, &face);
        evaluator.measure(&person, &face)
    };
    let mean = |lengths: &[f64]| lengths.iter().sum::<f64>() / lengths.len() as f64;
    // Distances are the bars of issue 3. Drift is measured at 0.52 and 0.56 mm on these two, 0.58
    // on the noisy one; the bars are for the mean of a hundred.
    for seed in [8301, 8302] {
        let clean = measure(seed, 0.0, 0.0);
        let (to_scan, drift) = (mean(&clean.face_to_scan), mean(&clean.drift));
        println!(
            "{seed}: {to_scan:.4} mm to the scan, drift {drift:.3} mm, {} folds",
            clean.folds
        );
        assert!(to_scan < 0.06, "{to_scan}");
        assert!(drift < 0.65, "{drift}");
        assert_eq!(clean.folds, 0);
    }
    let noisy = measure(8301, 0.3, 1.5);
    let (to_skin, drift) = (mean(&noisy.face_to_skin), mean(&noisy.drift));
    println!(
        "noisy: {to_skin:.4} mm to the skin, drift {drift:.3} mm, {} folds",
        noisy.folds
    );
    assert!(to_skin < 0.18, "{to_skin}");
    assert!(drift < 0.8, "{drift}");
    assert_eq!(noisy.folds, 0);
}

/// What a fit takes for a trace of an expression on people who show none is how they differ from the prior: it is not taken
/// off them, who would all be made more alike.
#[test]
fn from_people_at_rest_nothing_is_taken_off() {
    let (Some(given), Some(ict)) = (given(), ict::ict()) else {
        return;
    };
    let template = given.template;
    let simulator = Simulator::new(ict);
    let ibug: Vec<usize> = (0..68)
        .map(|i| {
            let name = format!("ibug_{i:02}");
            let mut landmarks = template.landmarks.iter();
            landmarks.position(|l| l.name == name).expect("a point")
        })
        .collect();
    let (mut traces, mut told) = (0, 0);
    for seed in 9000..9010 {
        let settings = simulate::Settings {
            noise: 0.2,
            jitter: 0.5,
            holes: false,
        };
        let person = simulator.scan(seed, &settings);
        let points: Pulls = ibug.iter().copied().zip(person.landmarks).collect();
        let registered = given
            .registrar
            .register(&person.scan, &points, &Settings::default());
        let registered = registered.expect("registers");
        // As all that a fit found would move the face: on the mean over the features, mm.
        let mut moves = vec![DVec3::ZERO; template.positions.len()];
        for (name, strength) in &registered.expressions {
            let own = template.expressions.iter().find(|e| e.name == *name);
            let own = &own.expect("one of the template's").displacements;
            moves
                .iter_mut()
                .zip(own)
                .for_each(|(m, d)| *m += *d * *strength);
        }
        let count = features(template).count() as f64;
        let all = features(template).map(|v| moves[v].length()).sum::<f64>() / count;
        let farthest = features(template)
            .map(|v| moves[v].length())
            .fold(0.0, f64::max);
        let neutral = registered.neutral();
        let taken = features(template).map(|v| neutral[v].distance(registered.positions[v]));
        let taken = taken.sum::<f64>() / count;
        println!(
            "{seed}: {:.2?}; all of it {all:.3} mm, at most {farthest:.2}; taken off {taken:.3} mm",
            registered
                .expressions
                .iter()
                .map(|e| e.1)
                .collect::<Vec<_>>()
        );
        match registered.summary().contains("the face shows") {
            true => told += 1,
            false => {
                traces += usize::from(!registered.expressions.is_empty());
                assert_eq!(neutral, registered.positions, "{seed}");
            }
        }
    }
    println!("{told} are told an expression, {traces} have traces of some");
    // Without such people this would say nothing.
    assert!(traces > 0);
}
