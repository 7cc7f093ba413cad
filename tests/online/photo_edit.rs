//! Faces in photos that take another shape.

use std::sync::LazyLock;

use glam::{DMat3, DVec2, DVec3, Vec3};
use phiz::photo::raster::{NOTHING, Raster};
use phiz::photo::{Camera, Edit, Field, Image};
use phiz::{Expressions, Face, Performance, Random};

use crate::common::{self, person};
use crate::staged::{SIZE, camera, edit, stencil, window};

/// The edits of the paper's Figs. 7 and 8, each both ways.
const EDITS: [&str; 8] = [
    "mouth width",
    "mouth protrusion",
    "nose length",
    "nose width",
    "eyes size",
    "eyes length",
    "forehead convexity",
    "forehead size",
];

fn field(edit: &Edit, face: &Face) -> Option<Field> {
    edit.field(face.positions(), face.normals()).unwrap()
}

/// A face whose control's own mode is moved by so many standard deviations.
fn moved(face: &Face, control: &str, sigmas: f32) -> Face {
    let controls = &face.model().parts().controls;
    let at = controls
        .iter()
        .position(|c| c.name == control)
        .expect("is a control");
    let mut coefficients = face.coefficients();
    coefficients[at] += sigmas;
    let mut face = face.clone();
    face.set_coefficients(&coefficients).unwrap();
    face
}

/// The field's motion at a point of the photo, px.
fn motion(field: &Field, at: DVec2) -> DVec2 {
    let node = (at - field.origin) / field.step;
    let first = node.floor().as_usizevec2();
    let part = node - node.floor();
    let get = |x: usize, y: usize| {
        let [x, y] = field.motion[(first.y + y) * field.columns + first.x + x];
        DVec2::new(f64::from(x), f64::from(y))
    };
    let upper = get(0, 0).lerp(get(1, 0), part.x);
    upper.lerp(get(0, 1).lerp(get(1, 1), part.x), part.y)
}

/// The least of the determinants of the map of places to where they come from: 1 where nothing is
/// stretched, 0 where it folds.
fn least_jacobian(field: &Field) -> f64 {
    let motion = |x: usize, y: usize| {
        let [x, y] = field.motion[y * field.columns + x];
        DVec2::new(f64::from(x), f64::from(y)) / field.step
    };
    let cells = (0..field.rows - 1).flat_map(|y| (0..field.columns - 1).map(move |x| (x, y)));
    let each = cells.map(|(x, y)| {
        let across = DVec2::X + motion(x + 1, y) - motion(x, y);
        let down = DVec2::Y + motion(x, y + 1) - motion(x, y);
        across.perp_dot(down)
    });
    each.fold(f64::INFINITY, f64::min)
}

static EXPRESSIONS: LazyLock<Expressions> = LazyLock::new(|| {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/www/public/expressions.phiz");
    Expressions::parse(&std::fs::read(path).unwrap(), common::head_model()).unwrap()
});

/// A face as it shows expressions.
fn performed(face: &Face, shown: &[(&str, f64)]) -> Performance {
    let mut performance = Performance::new(&EXPRESSIONS);
    for &(name, weight) in shown {
        performance.set(name, weight).unwrap();
    }
    performance.perform(face).unwrap();
    performance
}

/// A landmark in a photo.
fn point(name: &str, of: &[Vec3], camera: &Camera) -> DVec2 {
    let landmarks = &common::head_model().parts().landmarks;
    let found = landmarks.iter().find(|l| l.name == name).unwrap();
    camera.project(found.place(of))
}

/// Whether a point is within a polygon.
fn within(corners: &[DVec2], p: DVec2) -> bool {
    let sides = (0..corners.len()).map(|i| {
        let [a, b] = [corners[i], corners[(i + 1) % corners.len()]];
        (b - a).perp_dot(p - a)
    });
    sides.clone().all(|s| s > 0.0) || sides.clone().all(|s| s < 0.0)
}

#[test]
fn a_shut_eye_is_skin() {
    let mut covered = 0;
    for (seed, yaw) in [(3, 0.0), (4, 0.3), (5, -0.3)] {
        let face = person(seed);
        let camera = camera([yaw, 0.05, 0.0]);
        let edit = edit(&face, &camera, None);
        for blink in [0.6, 1.0] {
            let shut = performed(&face, &[("eyeBlinkLeft", blink), ("eyeBlinkRight", blink)]);
            let field = edit.field(shut.positions(), shut.normals());
            let field = field.unwrap().expect("it moves");
            for eye in [36, 42] {
                let lids = |of: &[Vec3]| -> Vec<DVec2> {
                    let names = (eye..eye + 6).map(|i| format!("ibug_{i}"));
                    names.map(|name| point(&name, of, &camera)).collect()
                };
                let [open, now] = [face.positions(), shut.positions()].map(lids);
                let [[a, b], [c, d]] = [[open[1], open[2]], [open[5], open[4]]];
                // Places of the open eye that a lid is over, by more than a cell.
                for (across, down) in [0.2, 0.5, 0.8].map(|x| [(x, 0.2), (x, 0.5)]).concat() {
                    let at = a.lerp(b, across).lerp(c.lerp(d, across), down);
                    let lid = now[1].lerp(now[2], across);
                    if at.y > lid.y - 1.5 * field.step {
                        continue;
                    }
                    let from = at + motion(&field, at);
                    assert!(!within(&open, from), "{seed}, {blink}: {at} shows {from}");
                    covered += 1;
                }
            }
        }
    }
    assert!(covered > 40, "{covered}");
}

/// Lids that are shut in the photo have their lashes there, and of those at the far side of a profile nothing is told:
/// an edit of something else paints no line over them.
#[test]
fn eyes_that_do_not_shut_get_no_lashes() {
    let blink = [("eyeBlinkLeft", 1.0), ("eyeBlinkRight", 1.0)];
    let mut sideways = 0;
    let mut check = |face: &Face, yaw: f64, shown: &[(&str, f64)]| {
        let (camera, before) = (camera([yaw, 0.05, 0.0]), performed(face, shown));
        let (positions, normals) = (before.positions(), before.normals());
        let edit = Edit::new(face.model(), &camera, SIZE, None, positions, normals).unwrap();
        let across = ["ibug_36", "ibug_39"].map(|name| point(name, positions, &camera).x);
        sideways += usize::from(yaw < -1.0 && across[0] > across[1]);
        for control in ["nose width", "nose length", "mouth width", "forehead size"] {
            for sigmas in [-2.0, 2.0] {
                let after = performed(&moved(face, control, sigmas), shown);
                let field = edit.field(after.positions(), after.normals());
                let field = field.unwrap().expect("it moves");
                // Without a light all that changes one is lashes, and the inside of a mouth that opens.
                let least = field.gain.as_flattened().iter().copied();
                let least = least.fold(f32::INFINITY, f32::min);
                assert!(least == 1.0, "{control} {sigmas} at {yaw}: {least}");
            }
        }
    };
    for (seed, yaw) in [(3, 0.0), (4, 0.4), (5, -0.4)] {
        check(&person(seed), yaw, &blink);
        // Nearly shut is as good.
        check(&person(seed), yaw, &blink.map(|(name, _)| (name, 0.93)));
    }
    for yaw in [1.15, 1.25, 1.35, 1.45] {
        for yaw in [yaw, -yaw] {
            check(&person(3), yaw, &[]);
        }
    }
    assert!(sideways > 0, "a far eye's corners change places");
}

#[test]
fn an_eyeball_stays_where_a_lid_goes_over_it() {
    let face = person(3);
    let camera = camera([0.0; 3]);
    let edit = edit(&face, &camera, None);
    let half = performed(&face, &[("eyeBlinkLeft", 0.4), ("eyeBlinkRight", 0.4)]);
    let field = edit.field(half.positions(), half.normals());
    let field = field.unwrap().expect("it moves");
    for [up, low] in [["ibug_37", "ibug_41"], ["ibug_44", "ibug_46"]] {
        let [lid, rim] = [up, low].map(|name| point(name, half.positions(), &camera));
        assert!(
            rim.y - lid.y > 2.0 * field.step,
            "{} is open",
            rim.y - lid.y
        );
        let moved = motion(&field, lid.lerp(rim, 0.7)).length();
        // It was drawn along by half of the lid's way, 3 px.
        assert!(moved < 1.0, "{up}: {moved}");
    }
}

#[test]
fn an_opened_mouth_has_its_upper_teeth_and_is_dark_below() {
    for (seed, yaw) in [(3, 0.0), (4, 0.3)] {
        let face = person(seed);
        let camera = camera([yaw, 0.05, 0.0]);
        let smile = [
            ("jawOpen", 0.2),
            ("mouthSmileLeft", 0.6),
            ("mouthSmileRight", 0.6),
        ];
        let smiling = performed(&face, &smile);
        let edit = Edit::new(
            face.model(),
            &camera,
            SIZE,
            Some(window()),
            smiling.positions(),
            smiling.normals(),
        )
        .unwrap();
        let gaping = performed(&face, &[&[("jawOpen", 0.9)], &smile[1..]].concat());
        let field = edit.field(gaping.positions(), gaping.normals());
        let field = field.unwrap().expect("it opens");
        let [before, after] = [smiling.positions(), gaping.positions()]
            .map(|of| ["ibug_62", "ibug_66"].map(|name| point(name, of, &camera)));
        let [teeth, gap] = [before[1] - before[0], after[1] - after[0]];
        assert!(gap.y > 2.0 * teeth.y, "{seed}: {gap} after {teeth}");
        // In the middle of what was seen: as the upper lip moves, and no darker.
        let at = after[0] + 0.5 * teeth;
        let off = motion(&field, at) - (before[0] - after[0]);
        // A mouth that moved as a whole would be off by half of the gap, some 20 px.
        assert!(off.length() < 0.1 * gap.y, "{seed}: teeth are off by {off}");
        // Deep in the mouth it is the inside of the mouth that is read, and dark.
        let node = |p: DVec2| {
            let [x, y] = ((p - field.origin) / field.step).round().to_array();
            y as usize * field.columns + x as usize
        };
        let deep = after[0] + 0.8 * gap;
        let from = deep + motion(&field, deep);
        assert!(
            from.y < before[1].y + 1.5,
            "{seed}: {from} is below {}",
            before[1]
        );
        let [light, dark] = [at, deep].map(|p| field.gain[node(p)][0]);
        assert!(light > 0.6 && dark < 0.25, "{seed}: {light}, {dark}");
    }
}

#[test]
fn nothing_is_read_from_outside_of_a_photo() {
    let face = person(8);
    // Heads that are cut off at the left, above and below.
    for shift in [[-190.0, 0.0], [0.0, -110.0], [0.0, 165.0]] {
        let mut camera = camera([0.1, 0.0, 0.0]);
        camera.centre += DVec2::from(shift);
        let edit = edit(&face, &camera, None);
        let mut outside = 0;
        for control in ["forehead size", "mouth width", "nose length"] {
            for sigmas in [-3.0, 3.0] {
                let Some(field) = field(&edit, &moved(&face, control, sigmas)) else {
                    continue;
                };
                for (x, y) in (0..SIZE[0]).flat_map(|x| (0..SIZE[1]).map(move |y| (x, y))) {
                    let at = DVec2::new(f64::from(x), f64::from(y)) + 0.5;
                    let node = (at - field.origin) / field.step;
                    let last = DVec2::new(field.columns as f64, field.rows as f64) - 1.0;
                    if node.min_element() < 0.0 || !node.cmplt(last).all() {
                        continue;
                    }
                    let from = at + motion(&field, at);
                    let size = DVec2::new(f64::from(SIZE[0]), f64::from(SIZE[1]));
                    // Motion is linear between nodes, and what makes up for a cut is not.
                    outside += usize::from(!from.clamp(DVec2::ZERO, size).abs_diff_eq(from, 0.1));
                }
                assert!(least_jacobian(&field) > 0.3, "{shift:?}, {control}");
            }
        }
        assert_eq!(outside, 0, "{shift:?}");
    }
}

#[test]
fn no_change_is_no_field() {
    let face = person(1);
    let edit = edit(&face, &camera([0.2, 0.1, 0.0]), Some(window()));
    assert_eq!(field(&edit, &face), None);
    assert_eq!(field(&edit, &moved(&face, "nose width", 0.0)), None);
}

#[test]
fn what_is_seen_goes_where_the_surface_goes() {
    let face = person(2);
    let camera = camera([0.25, 0.05, 0.1]);
    let edit = edit(&face, &camera, None);
    let mut checked = 0;
    for control in EDITS {
        let other = moved(&face, control, 2.0);
        let field = field(&edit, &other).expect("it moves");
        let eye = camera.position();
        for landmark in &face.model().parts().landmarks {
            // Points of the inner skin; lids and lips have their edges at the points.
            let number = landmark
                .name
                .strip_prefix("ibug_")
                .map(|n| n.parse::<usize>().unwrap());
            let Some(17..=35) = number else { continue };
            let facing = |f: &Face| {
                let p = landmark.place(f.positions());
                let normal: Vec3 = stencil(landmark, f.normals());
                normal.as_dvec3().normalize().dot((eye - p).normalize())
            };
            if facing(&face).min(facing(&other)) < 0.7 {
                continue;
            }
            let place = |f: &Face| camera.project(landmark.place(f.positions()));
            let (from, to) = (place(&face), place(&other));
            let off = (motion(&field, to) - (from - to)).length();
            // Cells are 1.8 px, and over half of one what is known is mixed.
            assert!(
                off < 0.25,
                "{control}, {}: {off} of {}",
                landmark.name,
                from.distance(to)
            );
            checked += 1;
        }
    }
    assert!(checked > 80, "{checked}");
}

#[test]
fn nothing_folds() {
    let mut least = (f64::INFINITY, String::new());
    for (seed, angles) in [
        (3, [0.0; 3]),
        (4, [0.78, 0.1, 0.0]),
        (5, [-0.5, -0.2, 0.15]),
    ] {
        let face = person(seed);
        let edit = edit(&face, &camera(angles), None);
        for control in EDITS {
            for sigmas in [-2.0, 2.0] {
                let field = field(&edit, &moved(&face, control, sigmas)).expect("it moves");
                let jacobian = least_jacobian(&field);
                if jacobian < least.0 {
                    least = (jacobian, format!("{control} {sigmas} of {seed}"));
                }
            }
        }
    }
    println!("least: {least:?}");
    // The project's bar.
    assert!(least.0 > 0.3, "{least:?}");
}

#[test]
fn what_is_far_away_never_moves() {
    let face = person(6);
    let camera = camera([0.0; 3]);
    let edit = edit(&face, &camera, Some(window()));
    let mut other = person(7);
    other.set("nose width", 0.9).unwrap();
    let field = field(&edit, &other).expect("it is another person");
    let points = face
        .model()
        .parts()
        .landmarks
        .iter()
        .filter(|l| l.name.starts_with("ibug_"));
    let points: Vec<DVec2> = points
        .map(|l| camera.project(l.place(face.positions())))
        .collect();
    let wide = points[..17].iter().map(|p| p.x);
    let (low, high) = wide.fold((f64::MAX, f64::MIN), |(l, h), x| (l.min(x), h.max(x)));
    let mut still = 0;
    for at in 0..field.motion.len() {
        let node = DVec2::new((at % field.columns) as f64, (at / field.columns) as f64);
        let place = field.origin + node * field.step;
        let away = points
            .iter()
            .map(|p| p.distance(place))
            .fold(f64::MAX, f64::min);
        if away > high - low {
            assert_eq!(
                (field.motion[at], field.gain[at]),
                ([0.0; 2], [1.0; 3]),
                "{place}"
            );
            still += 1;
        }
    }
    assert!(still > 100, "{still}");
    // Pixels of noise, of which those that do not move are the same.
    let mut random = Random::new(1);
    let noise: Vec<u8> = (0..SIZE[0] * SIZE[1] * 4)
        .map(|_| (random.uniform() * 256.0) as u8)
        .collect();
    let image = Image::new(SIZE[0], SIZE[1], &noise).unwrap();
    let out = field.render(&image, 1.0);
    let changed = |x: usize, y: usize| {
        let at = 4 * (y * SIZE[0] as usize + x);
        noise[at..at + 4] != out[at..at + 4]
    };
    for x in 0..SIZE[0] as usize {
        for y in 0..SIZE[1] as usize {
            let place = DVec2::new(x as f64, y as f64) + 0.5;
            let away = points
                .iter()
                .map(|p| p.distance(place))
                .fold(f64::MAX, f64::min);
            assert!(
                !changed(x, y) || away < high - low + 2.0 * field.step,
                "{place}"
            );
        }
    }
    assert!(changed(240, 200), "the nose is another");
}

/// Whether something is seen within `reach` of each pixel, along both axes.
fn near(raster: &Raster, [width, height]: [usize; 2], reach: usize) -> Vec<bool> {
    let around =
        |middle: usize, size: usize| middle.saturating_sub(reach)..(middle + reach).min(size);
    let seen: Vec<bool> = raster.triangles.iter().map(|t| *t != NOTHING).collect();
    let rows: Vec<bool> = (0..width * height)
        .map(|i| around(i % width, width).any(|x| seen[i / width * width + x]))
        .collect();
    (0..width * height)
        .map(|i| around(i / width, height).any(|y| rows[y * width + i % width]))
        .collect()
}

/// A bald head before a wall: what is not of it is background.
#[test]
fn the_background_stays_but_for_what_is_beside_the_head() {
    let mut least = f64::INFINITY;
    for (seed, angles) in [(3, [0.0; 3]), (4, [0.6, 0.1, 0.0])] {
        let (face, camera) = (person(seed), camera(angles));
        let positions: Vec<DVec3> = face.positions().iter().map(|p| p.as_dvec3()).collect();
        let triangles = face.model().parts().topology.triangles();
        let size = SIZE.map(|s| s as usize);
        let raster = Raster::new(&camera, size, &positions, &triangles);
        let alpha = raster.triangles.iter().map(|&t| match t {
            NOTHING => 0,
            _ => 255,
        });
        let rgba: Vec<u8> = alpha.flat_map(|alpha| [128, 128, 128, alpha]).collect();
        let image = Image::new(SIZE[0], SIZE[1], &rgba).unwrap();
        let anywhere = edit(&face, &camera, None);
        let mut before = anywhere.clone();
        before.set_background(&image).unwrap();
        let moves = |field: &Field| field.motion.iter().filter(|m| **m != [0.0; 2]).count();
        let stranger = person(seed + 20);
        let [less, more] = [&before, &anywhere].map(|edit| moves(&field(edit, &stranger).unwrap()));
        assert!((less as f64) < 0.9 * more as f64, "{less} of {more}");
        // The face is some 200 px high, of which it is an eighth.
        let near = near(&raster, size, 30);
        for control in EDITS {
            for sigmas in [-2.0, 2.0] {
                let other = moved(&face, control, sigmas);
                let field = field(&before, &other).expect("it moves");
                least = least.min(least_jacobian(&field));
                for (at, motion) in field.motion.iter().enumerate() {
                    let node = DVec2::new((at % field.columns) as f64, (at / field.columns) as f64);
                    let [x, y] = (field.origin + node * field.step).to_array();
                    let pixel = |at: f64, size: usize| (at.max(0.0) as usize).min(size - 1);
                    let is_near = near[pixel(y, size[1]) * size[0] + pixel(x, size[0])];
                    assert!(
                        is_near || *motion == [0.0; 2],
                        "{control} {sigmas}: {x} {y}"
                    );
                }
            }
        }
    }
    println!("least: {least}");
    // The project's bar.
    assert!(least > 0.3, "{least}");
    // What was told before is forgotten.
    let (other, untold) = (person(23), edit(&person(3), &camera([0.0; 3]), None));
    let pixels = |alpha: &dyn Fn(usize) -> u8| -> Vec<u8> {
        let each = (0..(SIZE[0] * SIZE[1]) as usize).map(|i| i % SIZE[0] as usize);
        each.flat_map(|x| [128, 128, 128, alpha(x)]).collect()
    };
    let [half, all, none] = [
        pixels(&|x| if x < 200 { 0 } else { 255 }),
        pixels(&|_| 255),
        pixels(&|_| 0),
    ];
    let mut again = untold.clone();
    let mut told = |rgba: &[u8]| {
        let image = Image::new(SIZE[0], SIZE[1], rgba).unwrap();
        again.set_background(&image).unwrap();
        field(&again, &other)
    };
    let mut only = untold.clone();
    let image = Image::new(SIZE[0], SIZE[1], &all).unwrap();
    only.set_background(&image).unwrap();
    assert_ne!(told(&half), field(&only, &other));
    assert_eq!(told(&all), field(&only, &other));
    assert_ne!(told(&half), field(&untold, &other));
    assert_eq!(told(&none), field(&untold, &other));
    let small = Image::new(2, 2, &[255; 16]).unwrap();
    let error = edit(&person(3), &camera([0.0; 3]), None).set_background(&small);
    assert_eq!(
        error.unwrap_err().to_string(),
        "the photo is 480 x 400 pixels, its image 2 x 2"
    );
}

/// A person's light is not their background's: nothing glows beside a cheek whose shade changes.
#[test]
fn what_is_behind_the_head_keeps_its_light() {
    let (face, camera) = (person(4), camera([0.6, 0.1, 0.0]));
    let positions: Vec<DVec3> = face.positions().iter().map(|p| p.as_dvec3()).collect();
    let triangles = face.model().parts().topology.triangles();
    let size = SIZE.map(|s| s as usize);
    let raster = Raster::new(&camera, size, &positions, &triangles);
    let head = |at: DVec2| {
        let at = at.clamp(
            DVec2::ZERO,
            DVec2::new(size[0] as f64, size[1] as f64) - 1.0,
        );
        raster.triangles[at.y as usize * size[0] + at.x as usize] != NOTHING
    };
    let image = |background: u8| -> Vec<u8> {
        let alpha = raster.triangles.iter().map(|&t| match t {
            NOTHING => background,
            _ => 255,
        });
        alpha.flat_map(|alpha| [128, 128, 128, alpha]).collect()
    };
    let untold = edit(&face, &camera, Some(window()));
    let [told, all] = [0, 255].map(|background| {
        let rgba = image(background);
        let mut edit = untold.clone();
        edit.set_background(&Image::new(SIZE[0], SIZE[1], &rgba).unwrap())
            .unwrap();
        edit
    });
    let (mut glowing, mut shaded) = (0, 0);
    // The paper's hardly reach the outline.
    for control in EDITS.into_iter().chain(["forehead width", "chin 1"]) {
        let other = moved(&face, control, 2.0);
        let everywhere = field(&all, &other).expect("it changes");
        for edit in [&untold, &told] {
            let field = field(edit, &other).expect("it changes");
            for (at, (motion, gain)) in field.motion.iter().zip(&field.gain).enumerate() {
                let node = DVec2::new((at % field.columns) as f64, (at / field.columns) as f64);
                let [x, y] = motion.map(f64::from);
                let from = field.origin + node * field.step + DVec2::new(x, y);
                let ring = |cells: f64, steps: u32| {
                    (0..steps).map(move |i| {
                        let angle = f64::from(i) / f64::from(steps) * std::f64::consts::TAU;
                        from + DVec2::from_angle(angle) * (cells * field.step)
                    })
                };
                let around = |cells: u32| (0..=cells).flat_map(move |c| ring(f64::from(c), 24));
                // Three cells of fading (distances are good to a twentieth), a diagonal of one between cells.
                if !around(5).any(head) {
                    assert_eq!(*gain, [1.0; 3], "{control}: {from}");
                    let gain = everywhere.gain[at];
                    glowing += usize::from(gain.iter().any(|g| (g - 1.0).abs() > 0.01));
                } else if around(1).all(head) && everywhere.motion[at] == *motion {
                    // On the head it is as if all of the photo were, to half a step of a byte: where
                    // background is held the grids' equations are others.
                    let off = gain.iter().zip(everywhere.gain[at]);
                    let off = off.map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
                    assert!(off < 2e-3, "{control}: {from}: {off}");
                    shaded += usize::from(gain.iter().any(|g| (g - 1.0).abs() > 0.01));
                }
            }
        }
    }
    // It would glow otherwise, and the face does change.
    assert!(glowing > 20 && shaded > 500, "{glowing}, {shaded}");
}

#[test]
fn mirror_images_change_as_mirror_images() {
    // A symmetric face straight ahead, in the middle between two nodes.
    let face = common::head_model().face();
    let edit = edit(&face, &camera([0.0; 3]), None);
    let field = field(&edit, &moved(&face, "nose width", 2.0)).expect("it moves");
    let mut most = 0.0_f64;
    for y in [150.0, 180.0, 200.0, 215.0, 230.0] {
        for x in [4.0, 9.0, 14.0, 22.0, 40.0] {
            let [left, right] = [-x, x].map(|x| motion(&field, DVec2::new(240.0 + x, y)));
            let off = (left + DVec2::new(right.x, -right.y)).length();
            // The model's mean is symmetric to 0.05 mm; cells lie otherwise on the one side.
            assert!(off < 0.12, "{left}, {right}");
            most = most.max(right.length());
        }
    }
    assert!(most > 1.5, "it moves: {most}");
}

#[test]
fn light_follows_the_normals() {
    let face = person(8);
    let camera = camera([0.0; 3]);
    let other = moved(&face, "nose width", 2.0);
    let dark = field(&edit(&face, &camera, None), &other).unwrap();
    assert!(
        dark.gain.iter().all(|g| *g == [1.0; 3]),
        "without light there is no shading"
    );
    let lit = field(&edit(&face, &camera, Some(window())), &other).unwrap();
    // The light may change farther out, on a grid that begins elsewhere.
    let inside = |field: &Field, at: DVec2| {
        let node = (at - field.origin) / field.step;
        let rows = field.gain.len() / field.columns;
        node.min_element() >= 0.0
            && node.x < (field.columns - 1) as f64
            && node.y < (rows - 1) as f64
    };
    let mut compared = 0;
    for at in (0..480)
        .step_by(7)
        .flat_map(|y| (0..480).step_by(7).map(move |x| (x, y)))
    {
        let at = DVec2::new(f64::from(at.0), f64::from(at.1));
        if inside(&lit, at) && inside(&dark, at) {
            assert!(
                motion(&lit, at).distance(motion(&dark, at)) < 1e-3,
                "at {at}"
            );
            compared += 1;
        }
    }
    assert!(compared > 100, "{compared} places");
    let gains = lit.gain.as_flattened().iter();
    let (low, high) = gains.fold((f32::MAX, 0.0_f32), |(l, h), &g| (l.min(g), h.max(g)));
    assert!(low < 0.97 && high > 1.03, "{low}, {high}");
    // Clipped, but for what the grids' correction overshoots.
    assert!(low > 0.7 && high < 1.4, "{low}, {high}");
    // The same light from everywhere has no ratio.
    let mut even = window();
    even.coefficients.iter_mut().for_each(|c| c[1..].fill(0.0));
    let flat = field(&edit(&face, &camera, Some(even)), &other).unwrap();
    assert!(
        flat.gain
            .as_flattened()
            .iter()
            .all(|g| (g - 1.0).abs() < 1e-6)
    );
}

#[test]
fn pixels_are_read_where_the_motion_says() {
    let (width, height) = (64_u32, 48_u32);
    // A ramp: cubic interpolation has no error on it, bytes half a step.
    let pixel = |x: f64, y: f64| 20.0 + 2.0 * x + 1.5 * y;
    let rgba: Vec<u8> = (0..width * height)
        .flat_map(|i| {
            let value = pixel(f64::from(i % width), f64::from(i / width)).round() as u8;
            [value, value / 2, 255 - value, 200]
        })
        .collect();
    let image = Image::new(width, height, &rgba).unwrap();
    let constant = |motion: [f32; 2], gain: [f32; 3]| Field {
        origin: DVec2::new(8.0, 6.0),
        step: 8.0,
        columns: 5,
        rows: 4,
        motion: vec![motion; 20],
        gain: vec![gain; 20],
    };
    let out = constant([2.25, -1.5], [1.0; 3]).render(&image, 1.0);
    for y in 0..height {
        for x in 0..width {
            let at = 4 * (y * width + x) as usize;
            let (cx, cy) = (f64::from(x) + 0.5, f64::from(y) + 0.5);
            if !(8.0..=40.0).contains(&cx) || !(6.0..=30.0).contains(&cy) {
                assert_eq!(out[at..at + 4], rgba[at..at + 4], "{x}, {y}");
                continue;
            }
            let wanted = pixel(f64::from(x) + 2.25, f64::from(y) - 1.5);
            assert!(
                (f64::from(out[at]) - wanted).abs() <= 1.01,
                "{x}, {y}: {}, {wanted}",
                out[at]
            );
            assert_eq!(out[at + 3], 200, "alpha stays");
        }
    }
    // Twice as much light: sRGB 188 is half of 255's.
    let grey = vec![188; (width * height * 4) as usize];
    let image = Image::new(width, height, &grey).unwrap();
    let out = constant([0.0; 2], [2.0, 1.0, 0.5]).render(&image, 1.0);
    let at = 4 * (20 * width as usize + 20);
    assert!(
        out[at] >= 254 && out[at + 1] == 188 && out[at + 2].abs_diff(137) <= 1,
        "{:?}",
        &out[at..at + 3]
    );
    // On a photo of twice the size everything is twice as far.
    let large: Vec<u8> = (0..4 * width * height)
        .flat_map(|i| {
            let value = 20.0 + f64::from(i % (2 * width));
            [value.round() as u8; 4]
        })
        .collect();
    let image = Image::new(2 * width, 2 * height, &large).unwrap();
    let out = constant([2.0, 0.0], [1.0; 3]).render(&image, 2.0);
    let at = |x: usize| out[4 * (30 * 2 * width as usize + x)];
    assert_eq!([at(10), at(40), at(90)], [30, 64, 110]);
}

/// Only some rows of a photo are kept while it is drawn over itself; none is read that was drawn.
#[test]
fn a_photo_is_drawn_in_its_own_place() {
    let (width, height) = (40_usize, 230_usize);
    let mut random = Random::new(3);
    let noise: Vec<u8> = (0..4 * width * height)
        .map(|_| (random.uniform() * 256.0) as u8)
        .collect();
    let size = [width as u32, height as u32];
    // Whole px, so that pixels are copies: near and far, up and down, and from beyond every border.
    for [dx, dy] in [[3, 2], [-13, 57], [9, -61], [0, 400], [-300, -400]] {
        let field = Field {
            origin: DVec2::new(4.5, 5.5),
            step: 10.0,
            columns: 4,
            rows: 23,
            motion: vec![[dx as f32, dy as f32]; 92],
            gain: vec![[1.0; 3]; 92],
        };
        let mut drawn = noise.clone();
        field.render_in_place(size, &mut drawn, 1.0).unwrap();
        for (at, pixel) in drawn.chunks_exact(4).enumerate() {
            let [x, y] = [at % width, at / width];
            let moves = (4..=34).contains(&x) && (5..=225).contains(&y);
            let from = |at: usize, by: i32, most: usize| match moves {
                true => (at as i32 + by).clamp(0, most as i32 - 1) as usize,
                false => at,
            };
            let from = 4 * (from(y, dy, height) * width + from(x, dx, width));
            assert_eq!(pixel[..3], noise[from..from + 3], "{dx} {dy}: {x}, {y}");
            assert_eq!(pixel[3], noise[4 * at + 3], "alpha stays");
        }
        let image = Image::new(size[0], size[1], &noise).unwrap();
        assert_eq!(field.render(&image, 1.0), drawn);
        // Whatever a motion is there is no panic.
        for odd in [f32::NAN, f32::INFINITY, f32::MIN] {
            let motion = vec![[odd, -odd]; 92];
            Field {
                motion,
                ..field.clone()
            }
            .render(&image, 1.0);
        }
    }
    let mut few = vec![0; 4];
    let field = Field {
        origin: DVec2::ZERO,
        step: 1.0,
        columns: 2,
        rows: 2,
        motion: vec![[0.0; 2]; 4],
        gain: vec![[1.0; 3]; 4],
    };
    assert!(field.render_in_place(size, &mut few, 1.0).is_err());
}

#[test]
fn what_cannot_be_edited_is_refused() {
    let face = person(1);
    let [positions, normals] = [face.positions(), face.normals()];
    let open = |camera: &Camera, positions: &[Vec3]| {
        Edit::new(face.model(), camera, SIZE, None, positions, normals)
            .err()
            .map(|e| e.to_string())
    };
    let wrong = open(&camera([0.0; 3]), &positions[1..]).unwrap();
    assert!(wrong.contains("are no face of"), "{wrong}");
    let beside = Camera {
        translation: DVec3::new(5000.0, 0.0, 800.0),
        ..camera([0.0; 3])
    };
    assert_eq!(
        open(&beside, positions).unwrap(),
        "no face is seen in the photo"
    );
    let behind = Camera {
        translation: DVec3::new(0.0, 0.0, -800.0),
        ..camera([0.0; 3])
    };
    assert_eq!(
        open(&behind, positions).unwrap(),
        "no face is seen in the photo"
    );
    let usual = camera([0.0; 3]);
    let turned = |by: DMat3| Camera {
        rotation: by * usual.rotation,
        ..usual
    };
    let focal = |focal: f64| Camera { focal, ..usual };
    for wrong in [
        focal(-1000.0),
        focal(0.0),
        focal(f64::NAN),
        focal(f64::INFINITY),
        turned(DMat3::from_diagonal(DVec3::splat(1.01))),
        turned(DMat3::from_diagonal(DVec3::new(-1.0, 1.0, 1.0))),
        turned(DMat3::from_diagonal(DVec3::splat(f64::NAN))),
        turned(DMat3::ZERO),
        Camera {
            translation: DVec3::new(0.0, 0.0, f64::INFINITY),
            ..usual
        },
        Camera {
            centre: DVec2::new(f64::NAN, 0.0),
            ..usual
        },
    ] {
        let why = open(&wrong, positions).expect("no camera is like that");
        assert!(why.starts_with("a camera has"), "{why}");
    }
    // Of a rotation in four digits.
    let digits = turned(
        DMat3::from_cols_array(&usual.rotation.to_cols_array().map(|x| x + 4e-5))
            * usual.rotation.transpose(),
    );
    assert_eq!(open(&digits, positions), None);
    let mut light = window();
    light.coefficients[1][4] = f64::NAN;
    let why = Edit::new(face.model(), &usual, SIZE, Some(light), positions, normals);
    assert!(why.unwrap_err().to_string().contains("only finite numbers"));
    let edit = edit(&face, &camera([0.0; 3]), None);
    assert!(edit.field(positions, &normals[1..]).is_err());
}
