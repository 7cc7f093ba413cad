//! What a photo tells of a head beside its shape: the colours that it wears, and its looks.

use glam::{DVec2, DVec3, Vec3};
use phiz::Face;
use phiz::photo::raster::{NOTHING, Raster, barycentric};
use phiz::photo::{Camera, Detail, Edit, Hair, Image, Light, Looks, Texture, View};

use crate::common::person;
use crate::staged::{SIZE, camera, edit, stencil, window};

const SKIN: DVec3 = DVec3::new(0.5, 0.35, 0.25);

/// A picture of a face whose skin has some linear albedo at each vertex, in a light, on green.
fn picture(face: &Face, camera: &Camera, light: &Light, albedo: &[DVec3]) -> Vec<u8> {
    coded(&linear_picture(face, camera, light, albedo))
}

/// The bytes of light, all of which is a person's.
fn coded(picture: &[DVec3]) -> Vec<u8> {
    let each = picture.iter().flat_map(|colour| {
        let [r, g, b] = colour.to_array().map(|c| match c <= 0.0031308 {
            true => 12.92 * c,
            false => 1.055 * c.powf(1.0 / 2.4) - 0.055,
        });
        [r, g, b, 1.0].map(|c| (255.0 * c.min(1.0)).round() as u8)
    });
    each.collect()
}

fn linear_picture(face: &Face, camera: &Camera, light: &Light, albedo: &[DVec3]) -> Vec<DVec3> {
    let triangles = face.model().parts().topology.triangles();
    let positions: Vec<DVec3> = face.positions().iter().map(|p| p.as_dvec3()).collect();
    let size = SIZE.map(|s| s as usize);
    let raster = Raster::new(camera, size, &positions, &triangles);
    let mut picture = Vec::with_capacity(size[0] * size[1]);
    for (at, &triangle) in raster.triangles.iter().enumerate() {
        let mut colour = DVec3::new(0.0, 0.5, 0.0);
        if triangle != NOTHING {
            let corners = triangles[triangle as usize].map(|v| v as usize);
            let here = DVec2::new((at % size[0]) as f64, (at / size[0]) as f64) + 0.5;
            let share = barycentric(here, corners.map(|v| camera.project(positions[v])));
            let mix = |of: &dyn Fn(usize) -> DVec3| -> DVec3 {
                (0..3).map(|i| of(corners[i]) * share[i]).sum()
            };
            let normal = mix(&|v| face.normals()[v].as_dvec3()).normalize();
            colour = mix(&|v| albedo[v]) * light.shade(normal);
        }
        picture.push(colour);
    }
    picture
}

/// How red what is worn is at the vertices of the skin that some places of the mean head are of, in order:
/// more than `fewest` of them.
fn reds(face: &Face, worn: &Texture, is_one: impl Fn(Vec3) -> bool, fewest: usize) -> Vec<u8> {
    let parts = face.model().parts();
    let last = worn.size - 1;
    let each = parts.topology.part_vertices("skin").into_iter();
    let each = each.filter(|&v| is_one(parts.mean[v as usize]));
    let each = each.map(|v| {
        let [u, w] = parts.topology.uvs[v as usize];
        let [x, y] = [u, 1.0 - w].map(|c| ((c * worn.size as f32) as usize).min(last));
        worn.rgba[4 * (worn.size * y + x)]
    });
    let mut all: Vec<u8> = each.collect();
    all.sort_unstable();
    assert!(all.len() > fewest, "{}", all.len());
    all
}

#[test]
fn a_head_wears_the_photo_without_its_light() {
    let face = person(9);
    let model = face.model();
    let parts = model.parts();
    // Turned: the right side of the face is hardly seen. Skin is striped across, the same on both sides.
    let camera = camera([0.6, 0.0, 0.0]);
    let albedo: Vec<DVec3> = (parts.mean.iter())
        .map(|p| DVec3::new(0.5, 0.35, 0.25) * (1.0 + 0.2 * f64::from(p.y / 9.0).sin()))
        .collect();
    let light = window();
    let rgba = picture(&face, &camera, &light, &albedo);
    let image = Image::new(SIZE[0], SIZE[1], &rgba).unwrap();
    let worn = edit(&face, &camera, Some(light))
        .texture(&image, None, 512)
        .unwrap();
    assert_eq!(worn.rgba.len(), 4 * 512 * 512);
    let linear = |byte: u8| (f64::from(byte) / 255.0 + 0.055).powf(2.4) / 1.055_f64.powf(2.4);
    // Over the true albedo, which is known but for the exposure.
    let mut ratios: [Vec<f64>; 2] = Default::default();
    for (v, uv) in parts.topology.uvs[..parts.mean.len()].iter().enumerate() {
        let [x, y] = [uv[0], 1.0 - uv[1]].map(|c| ((c * 512.0) as usize).min(511));
        let at = 4 * (512 * y + x);
        if worn.rgba[at + 3] > 230 && parts.mean[v].x.abs() > 15.0 {
            let side = usize::from(parts.mean[v].x > 0.0);
            ratios[side].push(linear(worn.rgba[at]) / albedo[v].x);
        }
    }
    let [right, left] = ratios.map(|mut all| {
        all.sort_unstable_by(f64::total_cmp);
        assert!(all.len() > 300, "{}", all.len());
        [0.1, 0.5, 0.9].map(|q| all[(q * (all.len() - 1) as f64) as usize])
    });
    // Stripes are some cells of the picture wide, so a tenth of their height is lost.
    for [low, median, high] in [right, left] {
        assert!(
            low / median > 0.92 && high / median < 1.08,
            "{low}, {median}, {high}"
        );
    }
    assert!(
        (right[1] / left[1] - 1.0).abs() < 0.05,
        "{right:?}, {left:?}"
    );
    // Nothing of the wall is on the skin.
    let skin = parts.topology.part_vertices("skin");
    let green = skin.iter().filter(|&&v| {
        let [u, w] = parts.topology.uvs[v as usize];
        let [x, y] = [u, 1.0 - w].map(|c| ((c * 512.0) as usize).min(511));
        let pixel = &worn.rgba[4 * (512 * y + x)..][..3];
        pixel[1] > pixel[0]
    });
    assert_eq!(green.count(), 0);
}

/// Photos of both sides, darker and bluer than the one from the front, show what that one does not and no mirror can: each
/// side is striped in its own way. Tones are those of the photo from the front.
#[test]
fn a_head_wears_several_photos() {
    let face = person(9);
    let model = face.model();
    let parts = model.parts();
    let striped = |p: &Vec3| {
        let wide = if p.x > 0.0 { 9.0 } else { 6.0 };
        DVec3::new(0.5, 0.35, 0.25) * (1.0 + 0.15 * f64::from(p.y / wide).sin())
    };
    let albedo: Vec<DVec3> = parts.mean.iter().map(striped).collect();
    let light = window();
    let dimmed = DVec3::new(0.55, 0.6, 0.75);
    let dim = light.coefficients;
    let dim = Light {
        coefficients: [0, 1, 2].map(|k| dim[k].map(|l| l * dimmed[k])),
        ..light
    };
    let positions: Vec<DVec3> = face.positions().iter().map(|p| p.as_dvec3()).collect();
    let cameras = [0.0, 0.75, -0.75].map(|yaw| camera([yaw, 0.0, 0.0]));
    let photos = [(0, &light), (1, &dim), (2, &dim)]
        .map(|(i, light)| picture(&face, &cameras[i], light, &albedo));
    let images = [0, 1, 2].map(|i| Image::new(SIZE[0], SIZE[1], &photos[i]).unwrap());
    let others = [1, 2].map(|i| View {
        camera: &cameras[i],
        light: &dim,
        positions: &positions,
        normals: face.normals(),
        image: images[i],
        detail: None,
    });
    let edit = edit(&face, &cameras[0], Some(light));
    let alone = edit.texture(&images[0], None, 512).unwrap();
    assert_eq!(
        edit.texture_with(&images[0], None, &[], 512).unwrap(),
        alone
    );
    let all = edit.texture_with(&images[0], None, &others, 512).unwrap();
    let linear = |byte: u8| (f64::from(byte) / 255.0 + 0.055).powf(2.4) / 1.055_f64.powf(2.4);
    // Of what is seen in photos: the logarithm of what is worn over the albedo, each channel, at the face's middle, to its
    // right and to its left.
    let off = |worn: &Texture| -> [Vec<DVec3>; 3] {
        let mut off: [Vec<DVec3>; 3] = Default::default();
        for v in parts.topology.part_vertices("skin") {
            let [u, w] = parts.topology.uvs[v as usize];
            let [x, y] = [u, 1.0 - w].map(|c| ((c * 512.0) as usize).min(511));
            let at = 4 * (512 * y + x);
            let place = parts.mean[v as usize];
            // Where both sides meet the stripes do not.
            if worn.rgba[at + 3] > 230 && place.x.abs() > 8.0 {
                let side = match place.x {
                    x if x.abs() < 45.0 => 0,
                    x if x < 0.0 => 1,
                    _ => 2,
                };
                let seen = [0, 1, 2].map(|k| linear(worn.rgba[at + k]));
                let tone = DVec3::from_array(seen) / albedo[v as usize];
                off[side].push(tone.map(f64::ln));
            }
        }
        off
    };
    let [one, many] = [off(&alone), off(&all)];
    let shares = |of: &[DVec3], channel: usize, shares: [f64; 3]| {
        let mut all: Vec<f64> = of.iter().map(|o| o[channel]).collect();
        all.sort_unstable_by(f64::total_cmp);
        shares.map(|share| all[(share * (all.len() - 1) as f64) as usize])
    };
    for channel in 0..3 {
        let [tone, ..] = shares(&one[0], channel, [0.5; 3]);
        for (side, name) in [(0, "middle"), (1, "right"), (2, "left")] {
            let [low, median, high] =
                shares(&many[side], channel, [0.1, 0.5, 0.9]).map(|o| o - tone);
            // As of one photo: stripes are some cells of the picture wide.
            assert!(
                low > -0.08 && median.abs() < 0.02 && high < 0.08,
                "{name}, {channel}: {low}, {median}, {high}"
            );
        }
    }
    // A photo from a side shows more of it.
    for side in [1, 2] {
        let [before, now] = [&one, &many].map(|of| of[side].len());
        assert!(4 * now > 5 * before, "{before}, {now}");
    }
}

/// What is not seen has the tone of what is, however far that is from the skin that the model is painted with.
#[test]
fn dark_skin_has_one_hue_all_round() {
    let face = person(9);
    let parts = face.model().parts();
    let (camera, light) = (camera([0.0; 3]), window());
    let skin = DVec3::new(0.2, 0.055, 0.024);
    let rgba = picture(&face, &camera, &light, &vec![skin; parts.mean.len()]);
    let image = Image::new(SIZE[0], SIZE[1], &rgba).unwrap();
    let edit = edit(&face, &camera, Some(light));
    let worn = edit.texture(&image, None, 512).unwrap();
    let hue = |is_one: &dyn Fn(Vec3) -> bool| {
        let all = parts.topology.part_vertices("skin").into_iter();
        let all = all.filter(|&v| is_one(parts.mean[v as usize])).map(|v| {
            let [u, w] = parts.topology.uvs[v as usize];
            let [x, y] = [u, 1.0 - w].map(|c| ((c * 512.0) as usize).min(511));
            let texel = &worn.rgba[4 * (512 * y + x)..][..3];
            f64::from(texel[2]) / f64::from(texel[0])
        });
        let mut all: Vec<f64> = all.collect();
        all.sort_unstable_by(f64::total_cmp);
        assert!(all.len() > 100, "{}", all.len());
        all[all.len() / 2]
    };
    let [seen, behind] = [
        hue(&|p| p.z > 0.0 && p.y > -60.0 && p.y < -10.0),
        hue(&|p| p.z < -80.0),
    ];
    // The darkest bytes are steps of some hundredths.
    assert!((behind / seen - 1.0).abs() < 0.1, "{behind} for {seen}");
}

/// Of brows that a photo does not show whole the rest is as dark as what it shows: of nobody's brows there is none.
#[test]
fn brows_are_as_dark_as_the_photos() {
    let face = person(9);
    let parts = face.model().parts();
    let arches: Vec<Vec3> = (17..=26)
        .map(|i| {
            let name = format!("ibug_{i}");
            let found = parts.landmarks.iter().find(|l| l.name == name);
            stencil(found.expect("is there"), &parts.mean)
        })
        .collect();
    let is_brow = |p: Vec3| arches.iter().any(|a| a.distance(p) < 4.0);
    // Their outer ends turn from the camera.
    let (camera, light) = (camera([0.0; 3]), window());
    let of = |brow: f64| {
        let each = parts.mean.iter();
        let albedo: Vec<DVec3> = each
            .map(|&p| SKIN * if is_brow(p) { brow } else { 1.0 })
            .collect();
        let rgba = picture(&face, &camera, &light, &albedo);
        let image = Image::new(SIZE[0], SIZE[1], &rgba).unwrap();
        let edit = edit(&face, &camera, Some(light));
        let worn = edit.texture(&image, None, 512).unwrap();
        let brows = reds(&face, &worn, is_brow, 20);
        let skin = reds(
            &face,
            &worn,
            |p| p.z > 0.0 && p.y < -10.0 && p.y > -40.0,
            100,
        );
        let middle = f64::from(skin[skin.len() / 2]);
        [brows[brows.len() / 20], brows[brows.len() / 2]].map(|red| f64::from(red) / middle)
    };
    let [darkest, _] = of(1.0);
    assert!(
        darkest > 0.93,
        "of nobody's brows some are {darkest} of the skin"
    );
    let [_, usual] = of(0.3);
    assert!(usual < 0.75, "of dark brows most are {usual} of the skin");
}

/// A lamp that a cheek mirrors is not worn: it would turn with the head. What is paler for a beard's sake is.
/// What is redder than skin is darker, or it is light.
#[test]
fn stains_of_light_are_no_skin() {
    let redder = |by: DVec3| {
        let mut face = Portrait::new(9);
        let middle = face.at("ibug_27").0 + Vec3::Y * 20.0;
        face.paint(SKIN * by, |p| p.distance(middle) < 10.0);
        let rgba = face.rgba();
        let image = Image::new(SIZE[0], SIZE[1], &rgba).unwrap();
        let edit = edit(&face.face, &face.camera, Some(face.light));
        let worn = edit.texture(&image, None, 512).unwrap();
        let parts = face.face.model().parts();
        let inside = parts.topology.part_vertices("skin").into_iter();
        let inside = inside.filter(|&v| parts.mean[v as usize].distance(middle) < 6.0);
        let mut all: Vec<f64> = inside
            .map(|v| {
                let [u, w] = parts.topology.uvs[v as usize];
                let [x, y] = [u, 1.0 - w].map(|c| ((c * 512.0) as usize).min(511));
                let pixel = &worn.rgba[4 * (512 * y + x)..][..3];
                let [red, blue] = [pixel[0], pixel[2]]
                    .map(|byte| (f64::from(byte) / 255.0 + 0.055).powf(2.4) / 1.055_f64.powf(2.4));
                (red / blue).ln() - (SKIN.x / SKIN.z).ln()
            })
            .collect();
        all.sort_unstable_by(f64::total_cmp);
        all[all.len() / 2]
    };
    // As bright as the skin beside it: a quarter of what is more than a flush.
    let (pale, flushed) = (DVec3::new(1.25, 1.0, 0.6), DVec3::new(0.85, 0.5, 0.5));
    // The head has the photo's white balance.
    let plain = redder(DVec3::ONE);
    let stain = redder(pale) - plain;
    assert!(stain < 0.35, "{stain} of {}", (1.25_f64 / 0.6).ln());
    let flush = redder(flushed) - plain;
    let all = (0.85_f64 / 0.5).ln();
    assert!((flush - all).abs() < 0.1, "{flush} of {all}");
}

#[test]
fn shine_is_no_skin() {
    let face = person(9);
    let parts = face.model().parts();
    let nose = parts.landmarks.iter().find(|l| l.name == "ibug_33");
    let nose = stencil(nose.expect("is there"), &parts.mean);
    let (camera, light) = (camera([0.0; 3]), window());
    let albedo = vec![SKIN; parts.mean.len()];
    let mut picture = linear_picture(&face, &camera, &light, &albedo);
    let near = |x: f32, y: f32| move |p: Vec3| (p.x - x).hypot(p.y - nose.y - y) < 5.0 && p.z > 0.0;
    let [cheek, chin] = [near(36.0, 14.0), near(4.0, -40.0)];
    let skin = parts.topology.part_vertices("skin");
    for is_one in [&cheek as &dyn Fn(Vec3) -> bool, &chin] {
        for &v in skin.iter().filter(|&&v| is_one(parts.mean[v as usize])) {
            let at = camera.project(face.positions()[v as usize].as_dvec3());
            for (i, light) in picture.iter_mut().enumerate() {
                let pixel =
                    DVec2::new((i % SIZE[0] as usize) as f64, (i / SIZE[0] as usize) as f64);
                // Once, however many vertices are near.
                if (pixel + 0.5).distance(at) < 3.0 && light.z < 0.4 {
                    *light += 0.3;
                }
            }
        }
    }
    let rgba = coded(&picture);
    let image = Image::new(SIZE[0], SIZE[1], &rgba).unwrap();
    let worn = edit(&face, &camera, Some(light))
        .texture(&image, None, 512)
        .unwrap();
    let red = |is_one: &dyn Fn(Vec3) -> bool| {
        let all = reds(&face, &worn, is_one, 5);
        f64::from(all[all.len() / 2])
    };
    let usual = red(&|p| p.z > 0.0 && (p.y - nose.y - 14.0).abs() < 8.0 && p.x < -20.0);
    // The lamp is 0.3 of white on 0.5 of red: a fifth more as bytes.
    let [cheek, chin] = [red(&cheek), red(&chin)].map(|red| red / usual);
    assert!(
        (cheek - 1.0).abs() < 0.05,
        "a cheek with a lamp is {cheek} of the skin"
    );
    assert!(chin > 1.1, "a pale chin is {chin} of the skin");
}

/// A photo without colours does not tell a light from skin: what is bright in it stays.
#[test]
fn what_is_bright_in_a_photo_without_colours_is_skin() {
    let face = person(9);
    let parts = face.model().parts();
    let camera = camera([0.0; 3]);
    let mut light = window();
    light.coefficients = [light.coefficients[1]; 3];
    let albedo: Vec<DVec3> = (parts.mean.iter())
        .map(|p| DVec3::splat(0.35 * (1.0 + 0.2 * f64::from(p.y / 9.0).sin())))
        .collect();
    let rgba = picture(&face, &camera, &light, &albedo);
    let image = Image::new(SIZE[0], SIZE[1], &rgba).unwrap();
    let worn = edit(&face, &camera, Some(light))
        .texture(&image, None, 512)
        .unwrap();
    let linear = |byte: u8| (f64::from(byte) / 255.0 + 0.055).powf(2.4) / 1.055_f64.powf(2.4);
    let mut ratios = Vec::new();
    for (v, uv) in parts.topology.uvs[..parts.mean.len()].iter().enumerate() {
        let [x, y] = [uv[0], 1.0 - uv[1]].map(|c| ((c * 512.0) as usize).min(511));
        let texel = &worn.rgba[4 * (512 * y + x)..][..4];
        if texel[3] > 230 {
            ratios.push(linear(texel[1]) / albedo[v].y);
        }
    }
    ratios.sort_unstable_by(f64::total_cmp);
    assert!(ratios.len() > 1000, "{}", ratios.len());
    let [low, median, high] =
        [0.05, 0.5, 0.95].map(|q| ratios[(q * (ratios.len() - 1) as f64) as usize]);
    // As of a photo with colours: stripes are some cells of the picture wide.
    assert!(
        low / median > 0.92 && high / median < 1.08,
        "{low}, {median}, {high}"
    );
}

/// Pictures that were cut out have any colours where nothing is: none of them is seen, through the edge neither.
#[test]
fn what_is_cut_out_has_no_colour() {
    let mut face = Portrait::new(9);
    face.paint_scalp(DVec3::new(0.1, 0.06, 0.03));
    face.over.clear();
    let positions: Vec<DVec3> = face.face.positions().iter().map(|p| p.as_dvec3()).collect();
    let triangles = face.face.model().parts().topology.triangles();
    let size = SIZE.map(|s| s as usize);
    let raster = Raster::new(&face.camera, size, &positions, &triangles);
    let mut state = 7_u32;
    let mut random = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 24) as u8
    };
    // By day, and in the dark with the grain of it.
    for (exposure, grain) in [(1.0, 0.0), (1.0 / 12.0, 5.0)] {
        face.exposure = exposure;
        let mut rgba = face.rgba();
        for byte in &mut rgba {
            let noise = grain * 12_f64.sqrt() * (f64::from(random()) / 255.0 - 0.5);
            *byte = (f64::from(*byte) + noise).round() as u8;
        }
        let cut = |fill: &mut dyn FnMut() -> u8| -> Vec<u8> {
            let mut cut = rgba.clone();
            for (pixel, &triangle) in cut.chunks_exact_mut(4).zip(&raster.triangles) {
                match triangle {
                    NOTHING => pixel.copy_from_slice(&[fill(), fill(), fill(), 0]),
                    _ => pixel[3] = 255,
                }
            }
            cut
        };
        let told = |rgba: &[u8]| {
            let image = Image::new(SIZE[0], SIZE[1], rgba).unwrap();
            let light = Light::of(&face.face, &face.camera, &image).unwrap();
            let edit = edit(&face.face, &face.camera, Some(light));
            let (corner, scale) = (DVec2::ZERO, 1.0);
            let detail = Detail {
                image,
                corner,
                scale,
            };
            let [worn, finer] =
                [None, Some(&detail)].map(|detail| edit.texture(&image, detail, 256).unwrap());
            (light, worn, finer, edit.looks(&image, None).unwrap())
        };
        let black = told(&cut(&mut || 0));
        // Grain is told from the pixels around the head, or from all of a detail.
        assert!(
            grain > 0.0 || black.1 == black.2,
            "a detail of the same pixels"
        );
        for other in [cut(&mut || 255), cut(&mut random)] {
            let other = told(&other);
            assert_eq!((other.0, other.3), (black.0, black.3));
            let off = other
                .1
                .rgba
                .iter()
                .zip(&black.1.rgba)
                .filter(|(a, b)| a != b);
            assert_eq!(off.count(), 0, "bytes at {exposure}");
            assert!(other.2 == black.2);
        }
        // It is the face that was there, in the dark, too: what the photo shows of it is a fourteenth of the texture.
        let texels = |worn: &Texture| worn.rgba.chunks_exact(4).filter(|p| p[3] > 230).count();
        let shown = texels(&black.1);
        assert!(shown > 256 * 256 / 16, "{shown} texels at {exposure}");
    }
}

/// A beard is no shadow: the light is that of the face above it.
#[test]
fn a_beard_does_not_come_from_light_above() {
    let face = person(9);
    let parts = face.model().parts();
    let nose = parts.landmarks.iter().find(|l| l.name == "ibug_33");
    let nose = stencil(nose.expect("is there"), &parts.mean);
    let camera = camera([0.0; 3]);
    let truth = window();
    for dark in [0.2, 0.4, 0.5] {
        // Mottled, as skin is: what is off by much is no outlier then.
        let mottled = |p: &Vec3| 1.0 + 0.3 * f64::from((p.x / 4.0).sin() * (p.y / 5.0).sin());
        let beard = |p: &Vec3| {
            let own = if p.y < nose.y - 6.0 { dark } else { 1.0 };
            SKIN * own * mottled(p)
        };
        let albedo: Vec<DVec3> = parts.mean.iter().map(beard).collect();
        let rgba = picture(&face, &camera, &truth, &albedo);
        let image = Image::new(SIZE[0], SIZE[1], &rgba).unwrap();
        let light = Light::of(&face, &camera, &image).unwrap();
        let front = DVec3::Z;
        for normal in [[0.0, 0.6, 0.8], [0.0, -0.6, 0.8], [0.6, 0.0, 0.8]] {
            let normal = DVec3::from_array(normal);
            let of = |light: &Light| light.shade(normal) / light.shade(front);
            let off = (of(&light) / of(&truth) - 1.0).abs().max_element();
            // As measured 0.012; with the beard in the fit it is 0.3.
            assert!(off < 0.05, "{off} at {normal} with a beard of {dark}");
        }
    }
}

/// A face that is small in a large photo is fitted in fewer pixels than there are; what it wears has them all.
#[test]
fn finer_pixels_are_worn_where_there_are_some() {
    const FEWER: usize = 4;
    let face = person(9);
    let parts = face.model().parts();
    let (camera, light) = (camera([0.1, 0.0, 0.0]), window());
    // Stripes of which the few pixels have four a period.
    let albedo: Vec<DVec3> = (parts.mean.iter())
        .map(|p| SKIN * (1.0 + 0.2 * f64::from(p.y / 2.0).sin()))
        .collect();
    let [wide, high] = SIZE.map(|side| side as usize);
    let fine = linear_picture(&face, &camera, &light, &albedo);
    let [few, low] = [wide / FEWER, high / FEWER];
    let coarse: Vec<DVec3> = (0..few * low)
        .map(|at| {
            let first = FEWER * (at / few) * wide + FEWER * (at % few);
            let rows = (0..FEWER).map(|y| &fine[first + y * wide..][..FEWER]);
            rows.flatten().sum::<DVec3>() / (FEWER * FEWER) as f64
        })
        .collect();
    let coarse = coded(&coarse);
    let image = Image::new(few as u32, low as u32, &coarse).unwrap();
    let small = Camera {
        focal: camera.focal / FEWER as f64,
        centre: camera.centre / FEWER as f64,
        ..camera
    };
    let size = [few as u32, low as u32];
    let (positions, normals) = (face.positions(), face.normals());
    let edit = Edit::new(face.model(), &small, size, Some(light), positions, normals).unwrap();
    // A part of the photo.
    let (left, top, across, down) = (60, 40, 380, 340);
    let rows = fine.chunks_exact(wide).skip(top).take(down);
    let part: Vec<DVec3> = rows
        .flat_map(|row| &row[left..left + across])
        .copied()
        .collect();
    let part = coded(&part);
    let detail = Detail {
        image: Image::new(across as u32, down as u32, &part).unwrap(),
        corner: DVec2::new(left as f64, top as f64) / FEWER as f64,
        scale: FEWER as f64,
    };
    let nose = parts.landmarks.iter().find(|l| l.name == "ibug_30");
    let nose = stencil(nose.expect("is there"), &parts.mean);
    // Cheeks, whose light is even.
    let contrast = |detail: Option<&Detail>| {
        let worn = edit.texture(&image, detail, 512).unwrap();
        let is_cheek =
            |p: Vec3| (p.y - nose.y).abs() < 15.0 && (25.0..45.0).contains(&p.x.abs()) && p.z > 0.0;
        let reds = reds(&face, &worn, is_cheek, 100);
        let [low, high] = [0.1, 0.9].map(|q| reds[(q * (reds.len() - 1) as f64) as usize]);
        f64::from(high) / f64::from(low)
    };
    let [few, all] = [contrast(None), contrast(Some(&detail))];
    // 0.8 to 1.2 of linear light is 1 to 1.2 as bytes; the tenth and the ninetieth hundredth are nearly that.
    assert!(few < 1.1, "{few}");
    assert!(all > 1.14, "{all}");
}

/// Of a head that is turned the temple faces the camera, and the hair on it; a beard is worn.
#[test]
fn hair_on_a_temple_is_no_skin() {
    let face = person(9);
    let parts = face.model().parts();
    let landmark = |name: &str| {
        let found = parts.landmarks.iter().find(|l| l.name == name);
        stencil(found.expect("is there"), &parts.mean)
    };
    let [corner, nose] = ["ibug_45", "ibug_33"].map(landmark);
    // Behind the corner of the eye, and below the mouth.
    let is_hair = |p: Vec3| p.z < corner.z - 18.0 && p.y > nose.y + 14.0;
    let is_beard = |p: Vec3| p.y < nose.y - 30.0;
    let skin = DVec3::new(0.5, 0.35, 0.25);
    let each = parts.mean.iter().map(|&p| match (is_hair(p), is_beard(p)) {
        (true, _) => skin * 0.12,
        (_, true) => skin * 0.4,
        _ => skin,
    });
    let albedo: Vec<DVec3> = each.collect();
    for yaw in [-0.7, 0.7] {
        let (camera, light) = (camera([yaw, 0.0, 0.0]), window());
        let rgba = picture(&face, &camera, &light, &albedo);
        let image = Image::new(SIZE[0], SIZE[1], &rgba).unwrap();
        let edit = edit(&face, &camera, Some(light));
        let worn = edit.texture(&image, None, 512).unwrap();
        let red = |is_one: &dyn Fn(Vec3) -> bool| reds(&face, &worn, is_one, 100);
        let near = |p: Vec3, x: f32| (p.x.abs() - x).abs() < 12.0;
        let cheek = red(&|p| p.z > corner.z && (p.y - nose.y).abs() < 10.0 && near(p, 35.0));
        let cheek = f64::from(cheek[cheek.len() / 2]);
        // From the edge of the hair on, but for where painted brows and ears end.
        let temple = red(&|p| is_hair(p) && p.z > corner.z - 45.0 && p.y < corner.y + 40.0);
        let dark = f64::from(temple[temple.len() / 50]);
        assert!(
            dark > 0.75 * cheek,
            "a temple is {dark} of 255, a cheek {cheek}"
        );
        let chin = red(&|p| is_beard(p) && p.z > corner.z && near(p, 0.0));
        let chin = f64::from(chin[chin.len() / 2]);
        assert!(
            chin < 0.8 * cheek,
            "a beard is {chin} of 255, a cheek {cheek}"
        );
    }
}

#[test]
fn colours_that_nobody_knows_are_refused() {
    let face = person(1);
    let grey = vec![128; (4 * SIZE[0] * SIZE[1]) as usize];
    let image = Image::new(SIZE[0], SIZE[1], &grey).unwrap();
    let dark = edit(&face, &camera([0.0; 3]), None).texture(&image, None, 512);
    assert!(dark.unwrap_err().to_string().contains("without the light"));
    let lit = edit(&face, &camera([0.0; 3]), Some(window()));
    for size in [0, 63, 4097] {
        let why = lit.texture(&image, None, size).unwrap_err().to_string();
        assert!(why.contains("from 64 to 4096 texels"), "{why}");
    }
    for (left, scale, wanted) in [
        (0.0, 0.0, "scale must be above 0"),
        (0.0, f64::NAN, "scale must be above 0"),
        (f64::INFINITY, 1.0, "left edge must be a number of px"),
    ] {
        let corner = DVec2::new(left, 0.0);
        let detail = Some(&Detail {
            image,
            corner,
            scale,
        });
        let why = lit.texture(&image, detail, 512).unwrap_err().to_string();
        assert!(why.contains(wanted), "{why}");
    }
    let half = Image::new(SIZE[0], SIZE[1] / 2, &grey[..grey.len() / 2]).unwrap();
    let why = lit.texture(&half, None, 512).unwrap_err().to_string();
    assert!(why.contains("pixels, its image"), "{why}");
}

/// Whether a point of the photo, px, is in something.
type Place = Box<dyn Fn(DVec2) -> bool>;

/// A face that looks at the camera, its photo, and where things are in it.
struct Portrait {
    face: Face,
    camera: Camera,
    light: Light,
    albedo: Vec<DVec3>,
    /// Painted over what is drawn: whether it is there, and its light.
    over: Vec<(Place, DVec3)>,
    /// What all light in the photo is multiplied by.
    exposure: f64,
}

impl Portrait {
    fn new(seed: u64) -> Self {
        let face = person(seed);
        Self {
            albedo: vec![SKIN; face.positions().len()],
            face,
            camera: Camera {
                translation: DVec3::new(0.0, 0.0, 700.0),
                ..camera([0.0; 3])
            },
            light: window(),
            // Something in a photo is white.
            over: vec![(Box::new(|p| p.x < 12.0), DVec3::splat(0.9))],
            exposure: 1.0,
        }
    }

    /// Where a landmark is on the mean head and, px, in the photo.
    fn at(&self, name: &str) -> (Vec3, DVec2) {
        let parts = self.face.model().parts();
        let found = parts.landmarks.iter().find(|l| l.name == name);
        let landmark = found.expect("is there");
        let here = stencil(landmark, self.face.positions());
        let seen = self.camera.project(here.as_dvec3());
        (stencil(landmark, &parts.mean), seen)
    }

    /// Gives an albedo to some of the mean head's skin.
    fn paint(&mut self, albedo: DVec3, is_there: impl Fn(Vec3) -> bool) {
        let mean = &self.face.model().parts().mean;
        for (own, &p) in self.albedo.iter_mut().zip(mean) {
            if is_there(p) {
                *own = albedo;
            }
        }
    }

    /// px a mm along the height at a landmark.
    fn scale_at(&self, name: &str) -> f64 {
        let parts = self.face.model().parts();
        let landmark = parts.landmarks.iter().find(|l| l.name == name);
        let here = stencil(landmark.expect("is there"), self.face.positions()).as_dvec3();
        let [from, to] = [here, here + DVec3::Y].map(|p| self.camera.project(p));
        from.distance(to)
    }

    /// px a mm at the face.
    fn scale(&self) -> f64 {
        self.camera.focal / self.camera.translation.z
    }

    /// Paints what is higher than a hairline that is everywhere inside the usual one.
    fn paint_scalp(&mut self, albedo: DVec3) {
        let [trichion, tragion] = ["trichion", "tragion left"].map(|name| self.at(name).0);
        let slope = 0.8 * (trichion.y - tragion.y) / (trichion.z - tragion.z);
        let line = move |z: f32| tragion.y + 4.0 + slope * (z - tragion.z).max(0.0);
        self.paint(albedo, |p| {
            p.y > line(p.z) && p.z < trichion.z + 5.0 || p.y > trichion.y
        });
    }

    fn rgba(&self) -> Vec<u8> {
        let mut picture = linear_picture(&self.face, &self.camera, &self.light, &self.albedo);
        for (at, light) in picture.iter_mut().enumerate() {
            let width = SIZE[0] as usize;
            let here = DVec2::new((at % width) as f64, (at / width) as f64) + 0.5;
            for (is_there, colour) in &self.over {
                if is_there(here) {
                    *light = *colour;
                }
            }
            *light *= self.exposure;
        }
        coded(&picture)
    }

    fn looks(&self) -> Looks {
        let rgba = self.rgba();
        let image = Image::new(SIZE[0], SIZE[1], &rgba).unwrap();
        let light = Light::of(&self.face, &self.camera, &image).unwrap();
        let edit = edit(&self.face, &self.camera, Some(light));
        edit.looks(&image, None).unwrap()
    }

    fn hair(&self) -> Hair {
        self.looks().hair.expect("there is hair")
    }
}

/// The greatest ratio of two colours' channels, either way.
fn ratio(a: DVec3, b: DVec3) -> f64 {
    let ratio = a / b;
    ratio.max_element().max(1.0 / ratio.min_element())
}

#[test]
fn skin_has_its_colour_without_the_light() {
    let face = Portrait::new(3);
    let looks = face.looks();
    // Of the exposure nobody knows more than that usual light is 1: the light's mean here is near that of
    // the front, and the hue is that of the skin under the lamp's own.
    let front = face.light.shade(DVec3::new(0.0, 0.1, 1.0).normalize());
    let off = ratio(looks.skin, SKIN * front);
    assert!(off < 1.12, "{:?} for {:?}", looks.skin, SKIN * front);
    assert!(looks.beard < 0.05, "{}", looks.beard);
    assert_eq!(looks.hair, None, "nothing grows on bare skin");
}

#[test]
fn hair_has_its_colour_and_ends_where_it_ends() {
    let black = DVec3::new(0.04, 0.03, 0.025);
    let mut face = Portrait::new(4);
    face.paint_scalp(black);
    let short = face.hair();
    let front = face.light.shade(DVec3::new(0.0, 0.1, 1.0).normalize());
    assert!(
        ratio(short.colour, black * front) < 1.25,
        "{:?}",
        short.colour
    );
    assert!(short.cover > 0.9, "{}", short.cover);
    assert!(short.off < 6.0, "{}", short.off);
    assert!(short.forehead < 0.15, "{}", short.forehead);
    assert_eq!(short.hangs, 0.0);

    // A mop that stands off by 24 mm: a disc around the head above the ears.
    let (_, ear) = face.at("tragion left");
    let crown: DVec2 = {
        let all = face
            .face
            .positions()
            .iter()
            .map(|p| face.camera.project(p.as_dvec3()));
        all.min_by(|a, b| a.y.total_cmp(&b.y)).unwrap()
    };
    let scale = face.scale();
    let (_, trichion) = face.at("trichion");
    let radius = (ear.y - crown.y).max((ear.x - crown.x).abs()) + 24.0 * scale;
    let centre = DVec2::new(crown.x, crown.y - 24.0 * scale + radius);
    let mut mop = Portrait::new(4);
    mop.paint_scalp(black);
    let outside = move |p: DVec2| p.distance(centre) < radius && p.y < trichion.y;
    mop.over.push((Box::new(outside), black * 0.8));
    let off = mop.hair().off;
    assert!((14.0..40.0).contains(&off), "{off}");

    // Curtains on both sides, to so many mm below the ears.
    for down in [60.0, 120.0] {
        let mut long = Portrait::new(4);
        long.paint_scalp(black);
        for side in ["left", "right"] {
            let (_, ear) = long.at(&format!("tragion {side}"));
            let scale = long.scale_at(&format!("tragion {side}"));
            let curtain = move |p: DVec2| {
                (p.x - ear.x).abs() < 14.0 * scale
                    && p.y > ear.y - 50.0 * scale
                    && p.y < ear.y + down * scale
            };
            long.over.push((Box::new(curtain), black * 0.8));
        }
        let hangs = long.hair().hangs;
        // It is looked for in steps of 4 mm, by the light within one.
        assert!((hangs - down).abs() < 6.0, "{hangs} mm for {down}");
    }
}

/// Brighter than skin and of less hue is a head without hair that shines, and grey hair, whose strands are seen.
#[test]
fn a_bald_head_that_shines_has_no_hair() {
    let dark = DVec3::new(0.16, 0.06, 0.03);
    let pale = dark * 0.8 + 0.12;
    let head = |scalp: bool| {
        let mut face = Portrait::new(6);
        face.albedo.fill(dark);
        if scalp {
            let trichion = face.at("trichion").0;
            face.paint(pale, |p| p.y > trichion.y);
        }
        face
    };
    assert_eq!(head(false).looks().hair, None);
    assert_eq!(head(true).looks().hair, None, "it shines");
    // Where nothing is as skin is it does not.
    let mut shorn = head(false);
    shorn.paint_scalp(pale);
    assert!(shorn.hair().cover > 0.9);
    // Strands of 3 mm, every other one of them in the shadow of its neighbours.
    let mut grey = head(true);
    let (hairline, period) = (grey.at("trichion").1, 6.0 * grey.scale());
    let between =
        move |p: DVec2| p.y < hairline.y && ((p.x - 0.3 * p.y) / period).rem_euclid(1.0) < 0.5;
    let light = grey.light.shade(DVec3::Z);
    grey.over.push((Box::new(between), pale * light * 0.7));
    let hair = grey.looks().hair.expect("has strands");
    assert!(hair.cover > 0.3, "{}", hair.cover);
}

#[test]
fn a_fringe_covers_the_forehead() {
    let fair = DVec3::new(0.3, 0.2, 0.09);
    let mut face = Portrait::new(5);
    face.paint_scalp(fair);
    let [brow, trichion] = ["ibug_19", "trichion"].map(|name| face.at(name).0);
    face.paint(fair, |p| p.z > 0.0 && p.y > brow.y + 8.0);
    let forehead = face.hair().forehead;
    assert!(forehead > 0.8, "{forehead}");
    assert!(face.hair().aside.abs() < 0.1, "{}", face.hair().aside);
    // Paint has no strands; strands of 3 mm tell by their direction, and not by which side is in the light.
    assert!(face.hair().lean.abs() < 0.15, "{}", face.hair().lean);
    for (slope, range) in [
        (1.0, 0.5..=1.0),
        (0.3, 0.3..=0.8),
        (0.0, -0.15..=0.15),
        (-1.0, -1.0..=-0.5),
    ] {
        let mut strands = Portrait::new(5);
        strands.paint_scalp(fair);
        strands.paint(fair, |p| p.z > 0.0 && p.y > brow.y + 8.0);
        let (_, edge) = strands.at("ibug_19");
        let period = 6.0 * strands.scale();
        // Down to the left of the subject, which is to the right in the photo.
        let dark =
            move |p: DVec2| p.y < edge.y && ((p.x - slope * p.y) / period).rem_euclid(1.0) < 0.5;
        strands.over.push((Box::new(dark), fair * 0.6));
        let lean = strands.hair().lean;
        println!("strands of a slope of {slope} lean by {lean:.2}");
        assert!(range.contains(&lean), "{slope}: {lean}");
    }
    // Its left half; its upper one.
    let whole = |p: Vec3| p.z > 0.0 && p.y > brow.y + 8.0;
    face.paint(SKIN, |p| whole(p) && p.x < 0.0);
    let aside = face.hair().aside;
    assert!((0.6..=1.0).contains(&aside), "{aside}");
    face.paint(fair, whole);
    let middle = (brow.y + 9.0 + trichion.y - 8.0) / 2.0;
    face.paint(SKIN, |p| p.z > 0.0 && p.y < middle);
    let forehead = face.hair().forehead;
    assert!((0.3..0.7).contains(&forehead), "{forehead}");
}

/// Down to the brows, and where its lights are as bright as skin.
#[test]
fn a_fringe_is_no_skin() {
    let mut face = Portrait::new(5);
    let hair = SKIN * 0.35;
    face.paint_scalp(hair);
    let brows: Vec<Vec3> = (17..27).map(|i| face.at(&format!("ibug_{i}")).0).collect();
    let top = brows.iter().map(|p| p.y).fold(f32::NEG_INFINITY, f32::max);
    let trichion = face.at("trichion").0;
    let [nose, corner] = ["ibug_33", "ibug_45"].map(|name| face.at(name).0);
    let above = move |p: Vec3| {
        let near = brows.iter().map(|b| b.distance(p));
        p.z > 0.0 && p.x.abs() < 45.0 && p.y > top + 3.0 && near.fold(f32::INFINITY, f32::min) > 9.0
    };
    face.paint(hair, &above);
    face.paint(SKIN * 0.8, |p| above(p) && (p.x / 7.0).sin() > 0.8);
    let rgba = face.rgba();
    let image = Image::new(SIZE[0], SIZE[1], &rgba).unwrap();
    let edit = edit(&face.face, &face.camera, Some(face.light));
    let worn = edit.texture(&image, None, 512).unwrap();
    let red = |is_one: &dyn Fn(Vec3) -> bool| reds(&face.face, &worn, is_one, 40);
    let cheek =
        red(&|p| p.z > corner.z && (p.y - nose.y).abs() < 10.0 && (p.x.abs() - 35.0).abs() < 12.0);
    let cheek = f64::from(cheek[cheek.len() / 2]);
    let forehead = red(&|p| above(p) && p.y < trichion.y);
    let dark = f64::from(forehead[forehead.len() / 50]);
    assert!(
        dark > 0.87 * cheek,
        "a forehead is {dark} of 255, a cheek {cheek}"
    );
}

/// Down to the inner ends of the brows, which are lower than their arches.
#[test]
fn a_fringe_on_brows_is_no_brow() {
    let mut face = Portrait::new(5);
    let hair = SKIN * 0.3;
    face.paint_scalp(hair);
    let brows: Vec<Vec3> = (17..27).map(|i| face.at(&format!("ibug_{i}")).0).collect();
    let [nose, corner] = ["ibug_33", "ibug_45"].map(|name| face.at(name).0);
    // How far a place is above the brows, or what is between them.
    let over = move |p: Vec3| {
        let pair = brows.windows(2).find(|pair| pair[1].x > p.x);
        let [from, to] = pair.map_or([brows[8], brows[9]], |pair| [pair[0], pair[1]]);
        p.y - from.y - (p.x - from.x) / (to.x - from.x) * (to.y - from.y)
    };
    face.paint(hair, |p| p.z > 0.0 && p.x.abs() < 45.0 && over(p) > 3.0);
    let rgba = face.rgba();
    let image = Image::new(SIZE[0], SIZE[1], &rgba).unwrap();
    let edit = edit(&face.face, &face.camera, Some(face.light));
    let worn = edit.texture(&image, None, 512).unwrap();
    let cheek = reds(
        &face.face,
        &worn,
        |p| p.z > corner.z && (p.y - nose.y).abs() < 10.0 && (p.x.abs() - 35.0).abs() < 12.0,
        40,
    );
    let cheek = f64::from(cheek[cheek.len() / 2]);
    let near = |p: Vec3| p.z > corner.z && p.x.abs() < 30.0 && (3.5..7.0).contains(&over(p));
    let near = reds(&face.face, &worn, near, 10);
    let dark = f64::from(near[near.len() / 10]);
    // Hair is 0.58 of the skin in bytes.
    assert!(
        dark > 0.8 * cheek,
        "above the brows is {dark} of 255, a cheek {cheek}"
    );
}

/// The head has its skin's tone where a mask or a scarf covers nose and mouth, and everywhere else.
#[test]
fn a_mask_is_no_skin() {
    // Blue, white and black.
    for (cloth, angles) in [
        (DVec3::new(0.25, 0.48, 0.62), [0.0; 3]),
        (DVec3::splat(0.8), [-0.5, 0.1, 0.0]),
        (DVec3::splat(0.03), [0.0; 3]),
    ] {
        let mut face = Portrait::new(5);
        face.camera.rotation = camera(angles).rotation;
        let bare = face.looks();
        let [bridge, tip, chin] = ["ibug_28", "ibug_30", "ibug_08"].map(|name| face.at(name).0);
        let corner = face.at("ibug_45").0;
        // Over the nose just below its bridge, and falling to the sides, with folds.
        let masked = move |p: Vec3| {
            p.z > corner.z - 40.0 && p.y < bridge.y - 2.0 - 0.4 * (p.x.abs() - 8.0).max(0.0)
        };
        face.paint(cloth, masked);
        face.paint(cloth * 0.7, |p| masked(p) && (p.y / 3.0).sin() > 0.5);
        let rgba = face.rgba();
        let image = Image::new(SIZE[0], SIZE[1], &rgba).unwrap();
        let light = Light::of(&face.face, &face.camera, &image).unwrap();
        let edit = edit(&face.face, &face.camera, Some(light));
        let looks = edit.looks(&image, None).unwrap();
        // What is near the eyes is a tenth of the face, in less of the light than the whole.
        let off = ratio(looks.skin, bare.skin);
        assert!(off < 1.15, "{:?} for {:?}", looks.skin, bare.skin);
        assert_eq!(looks.beard, 0.0, "a mask is no beard");
        let worn = edit.texture(&image, None, 256).unwrap();
        let red = |is_one: &dyn Fn(Vec3) -> bool| reds(&face.face, &worn, is_one, 40);
        let free = red(&|p| p.y > bridge.y && p.y < bridge.y + 50.0 && p.z > corner.z);
        let free = f64::from(free[free.len() / 2]);
        let places: [(&str, &dyn Fn(Vec3) -> bool); 4] = [
            ("nose", &|p| p.distance(tip) < 10.0),
            ("chin", &|p| p.distance(chin) < 18.0),
            ("cheeks", &|p| {
                (p.y - tip.y).abs() < 14.0 && p.z > corner.z && p.x.abs() > 25.0
            }),
            ("back", &|p| p.z < -80.0),
        ];
        for (name, is_one) in places {
            let red = red(is_one);
            // But for a hundredth: what the model paints is not all of one colour.
            for red in [red[red.len() / 100], red[red.len() - 1 - red.len() / 100]] {
                let part = f64::from(red) / free;
                assert!(
                    (0.85..1.15).contains(&part),
                    "{name}: {part} of the skin, under {cloth:?} from {angles:?}"
                );
            }
        }
    }
}

/// A photo that ends at the hairline does not show whether hair stands off, but what colour it has.
#[test]
fn hair_that_a_photo_cuts_off_is_not_cropped() {
    let fair = DVec3::new(0.2, 0.14, 0.06);
    let portrait = |near: bool| {
        let mut face = Portrait::new(5);
        if near {
            face.camera.translation.z = 330.0;
            face.camera.translation.y += 10.0;
        }
        face.paint_scalp(fair);
        let brow = face.at("ibug_19").0;
        // It has lights and shadows.
        face.paint(fair * 0.4, |p| {
            p.y > brow.y + 12.0 && (p.x / 2.0).sin() > 0.1
        });
        face.paint(fair, |p| {
            p.z > 0.0 && p.y > brow.y + 8.0 && (p.x / 2.0).sin() <= 0.1
        });
        face
    };
    let near = portrait(true);
    let hair = near.hair();
    assert!((6.0..20.0).contains(&hair.off), "{}", hair.off);
    let front = near.light.shade(DVec3::new(0.0, 0.1, 1.0).normalize());
    let lit = fair * front;
    assert!(hair.colour.x > 0.5 * lit.x, "{:?} for {lit:?}", hair.colour);
}

#[test]
fn a_beard_is_no_skin() {
    let shaved = Portrait::new(6).looks().skin;
    let mut face = Portrait::new(6);
    let nose = face.at("ibug_33").0;
    face.paint(SKIN * 0.3, |p| p.y < nose.y - 3.0);
    let bearded = face.looks().skin;
    assert!(ratio(bearded, shaved) < 1.2, "{bearded:?} for {shaved:?}");
}

#[test]
fn a_beard_is_darker_than_the_cheeks() {
    // From the front, and of a head that is turned and looks down, whose chin hardly faces the camera.
    for (darker, angles) in [
        (0.3_f64, [0.0; 3]),
        (0.9, [0.0; 3]),
        (1.5, [0.6, -0.3, 0.0]),
        (1.5, [-0.6, -0.3, 0.0]),
    ] {
        let mut face = Portrait::new(6);
        face.camera.rotation = camera(angles).rotation;
        let nose = face.at("ibug_33").0;
        face.paint(SKIN * (-darker).exp(), |p| p.y < nose.y - 3.0);
        let looks = face.looks();
        let beard = looks.beard;
        let off = if angles == [0.0; 3] { 0.12 } else { 0.4 };
        assert!(
            (beard - darker).abs() < off,
            "{beard} for {darker}, {angles:?}"
        );
        // Stubble is none.
        let colour = looks.beard_colour;
        assert_eq!(colour.is_some(), darker > 0.4, "{colour:?} for {darker}");
        if let Some(colour) = colour {
            let off = ratio(colour, looks.skin * (-darker).exp());
            assert!(
                off < 1.0 + 3.0 * 0.12,
                "{colour:?} for {darker}, {angles:?}"
            );
        }
    }
}

#[test]
fn irises_are_told_beside_the_white_of_the_eye() {
    let eye = |iris: DVec3, first: &[u32]| {
        let mut face = Portrait::new(7);
        let radius = 5.9 * face.scale();
        for &i in first {
            let points: Vec<DVec2> = (i..i + 6)
                .map(|i| face.at(&format!("ibug_{i}")).1)
                .collect();
            let centre = points.iter().sum::<DVec2>() / 6.0;
            let wide = points[0].distance(points[3]) / 2.0;
            let white = DVec3::splat(0.4);
            face.over
                .push((Box::new(move |p| p.distance(centre) < wide), white));
            // An albedo of 0.02 is what the cornea mirrors.
            let shown = (iris + 0.02) / 0.55 * 0.4;
            face.over
                .push((Box::new(move |p| p.distance(centre) < radius), shown));
            face.over.push((
                Box::new(move |p| p.distance(centre) < 0.35 * radius),
                DVec3::splat(0.004),
            ));
        }
        face.looks().irises
    };
    for iris in [DVec3::new(0.08, 0.15, 0.22), DVec3::new(0.11, 0.06, 0.03)] {
        let found = eye(iris, &[36, 42]).expect("eyes are open");
        assert!(ratio(found, iris) < 1.15, "{found:?} for {iris:?}");
    }
    // Lids are shut: skin all over.
    assert_eq!(eye(DVec3::ONE, &[]), None);
}

/// Whose upper lids hang low and are dark has the darkest disc above the iris: a detector sees it all the same.
#[test]
fn an_iris_is_where_the_detector_sees_it() {
    let mut face = Portrait::new(7);
    let radius = 5.9 * face.scale();
    let iris = DVec3::new(0.08, 0.15, 0.22);
    let middles = [36, 42].map(|first| {
        let points: Vec<DVec2> = (first..first + 6)
            .map(|i| face.at(&format!("ibug_{i}")).1)
            .collect();
        let wide = points[0].distance(points[3]) / 2.0;
        let centre = points.iter().sum::<DVec2>() / 6.0;
        // It looks aside.
        let middle = centre + DVec2::X * 0.3 * radius;
        let shown = (iris + 0.02) / 0.55 * 0.4;
        for (reach, at, light) in [
            (wide, centre, DVec3::splat(0.4)),
            (radius, middle, shown),
            (0.35 * radius, middle, DVec3::splat(0.004)),
        ] {
            face.over
                .push((Box::new(move |p| p.distance(at) < reach), light));
        }
        // (Down is positive in a photo.)
        let lid = move |p: DVec2| p.distance(centre) < wide && p.y < middle.y - 0.25 * radius;
        face.over.push((Box::new(lid), DVec3::splat(0.02)));
        middle
    });
    let rgba = face.rgba();
    let image = Image::new(SIZE[0], SIZE[1], &rgba).unwrap();
    let edit = edit(&face.face, &face.camera, Some(face.light));
    let told = |middles| edit.looks(&image, middles).unwrap().irises;
    let found = told(Some(middles)).expect("eyes are open");
    assert!(ratio(found, iris) < 1.15, "{found:?} for {iris:?}");
    let alone = told(None);
    assert!(
        alone.is_none_or(|alone| ratio(alone, iris) > 1.3),
        "the lid is no darker than the iris: {alone:?}"
    );
}

/// Draws a frame around both eyes, with a bridge, and lenses that let so much light through.
fn glasses(face: &mut Portrait, through: f64) {
    let scale = face.scale();
    let eyes = [[36, 39], [42, 45]].map(|pair| {
        let [a, b] = pair.map(|i| face.at(&format!("ibug_{i}")).1);
        (a + b) / 2.0
    });
    let (wide, tall, thick) = (21.0 * scale, 16.0 * scale, 2.5 * scale);
    for eye in eyes {
        let inside = move |p: DVec2, more: f64| {
            ((p.x - eye.x) / (wide + more)).powi(4) + ((p.y - eye.y) / (tall + more)).powi(4) < 1.0
        };
        let frame = move |p: DVec2| inside(p, 0.5 * thick) && !inside(p, -0.5 * thick);
        face.over.push((Box::new(frame), DVec3::splat(0.01)));
        if through < 1.0 {
            let lens = move |p: DVec2| inside(p, -0.5 * thick);
            face.over.push((Box::new(lens), SKIN * through));
        }
    }
    let bridge = move |p: DVec2| {
        (p.y - eyes[0].y).abs() < 0.5 * thick && p.x > eyes[0].x + wide && p.x < eyes[1].x - wide
    };
    face.over.push((Box::new(bridge), DVec3::splat(0.01)));
}

#[test]
fn glasses_are_not_skin() {
    // The red of the skin around the eyes.
    let around_eyes = |face: &Portrait| -> Vec<f64> {
        let rgba = face.rgba();
        let image = Image::new(SIZE[0], SIZE[1], &rgba).unwrap();
        let edit = edit(&face.face, &face.camera, Some(face.light));
        let worn = edit.texture(&image, None, 512).unwrap();
        let parts = face.face.model().parts();
        let [right, left] = ["ibug_36", "ibug_45"].map(|name| face.at(name).0);
        let middle = (right + left) / 2.0;
        let near = |p: Vec3| {
            let off = p - middle;
            off.x.abs() < 60.0 && off.y.abs() < 35.0 && off.z > -15.0
        };
        let skin = parts.topology.part_vertices("skin").into_iter();
        let skin = skin.filter(|&v| near(parts.mean[v as usize]));
        let red = skin.map(|v| {
            let [u, w] = parts.topology.uvs[v as usize];
            let [x, y] = [u, 1.0 - w].map(|c| ((c * 512.0) as usize).min(511));
            f64::from(worn.rgba[4 * (512 * y + x)])
        });
        red.collect()
    };
    let bare = around_eyes(&Portrait::new(8));
    // The part of it that is darker than bare skin.
    let darker = |face: &Portrait| {
        let seen = around_eyes(face);
        let count = seen
            .iter()
            .zip(&bare)
            .filter(|(seen, bare)| **seen < 0.75 * **bare);
        count.count() as f64 / bare.len() as f64
    };
    // (Above the brows it is taken for hair.)
    for (through, painted) in [(1.0, 0.015), (0.1, 0.15)] {
        let mut face = Portrait::new(8);
        glasses(&mut face, through);
        let worn = darker(&face);
        assert!(worn < 0.01, "{worn} of the skin is glasses");
        if through < 1.0 {
            assert_eq!(face.looks().irises, None, "behind dark lenses");
        }
        // Without a bridge it is paint, which is worn.
        face.over.pop();
        let worn = darker(&face);
        assert!(worn > painted, "{worn} of the skin is painted");
    }
}

#[test]
fn a_photo_in_the_dark_is_of_no_darker_person() {
    let mut face = Portrait::new(9);
    face.paint_scalp(DVec3::new(0.1, 0.06, 0.03));
    let day = face.looks();
    face.exposure = 1.0 / 8.0;
    let night = face.looks();
    // White is 0.9 by day, and taken for 0.7 by night; bytes of the dark are coarse.
    let off = ratio(night.skin * 0.9 / 0.7, day.skin);
    assert!(
        off < 1.1,
        "{:?} by night, {:?} by day",
        night.skin,
        day.skin
    );
    let [night, day] = [night, day].map(|looks| looks.hair.expect("there is hair"));
    let off = ratio(night.colour * 0.9 / 0.7, day.colour);
    assert!(
        off < 1.2,
        "{:?} by night, {:?} by day",
        night.colour,
        day.colour
    );
}

/// A sensor's noise is as large as before where a head shows a dark photo in good light, and looks like a rash.
#[test]
fn grain_of_a_photo_in_the_dark_is_not_worn() {
    let mut face = Portrait::new(9);
    face.exposure = 1.0 / 12.0;
    let spread = |rgba: &[u8]| {
        let image = Image::new(SIZE[0], SIZE[1], rgba).unwrap();
        let edit = edit(&face.face, &face.camera, Some(face.light));
        let worn = edit.texture(&image, None, 512).unwrap();
        let cheeks = |p: Vec3| {
            (15.0..45.0).contains(&p.x.abs()) && (-20.0..10.0).contains(&p.y) && p.z > 0.0
        };
        let all = reds(&face.face, &worn, cheeks, 200);
        let count = all.len() as f64;
        let mean = all.iter().copied().map(f64::from).sum::<f64>() / count;
        let squares = all.iter().map(|&red| (f64::from(red) - mean).powi(2));
        (squares.sum::<f64>() / count).sqrt()
    };
    let clean = face.rgba();
    let mut state = 7_u32;
    let mut random = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        f64::from(state >> 8) / f64::from(1 << 24) - 0.5
    };
    // A standard deviation of 5 bytes, of some 50.
    let noisy: Vec<u8> = (clean.iter())
        .map(|&byte| (f64::from(byte) + 5.0 * 12_f64.sqrt() * random()).round() as u8)
        .collect();
    let (clean, noisy) = (spread(&clean), spread(&noisy));
    // A standard deviation is added of 6.3 bytes where the grain is worn, of 1.5 where it is not.
    let added = (noisy * noisy - clean * clean).max(0.0).sqrt();
    assert!(added < 3.0, "{noisy} of grain, {clean} without");
}

#[test]
fn a_portrait_on_a_large_dark_page_is_of_no_fairer_person() {
    let mut face = Portrait::new(9);
    // White is near to the head.
    let cheek = face.at("ibug_00").1;
    face.over = vec![(Box::new(move |p| p.x < cheek.x - 30.0), DVec3::splat(0.9))];
    let alone = face.looks().skin;
    let (rgba, [width, height]) = (face.rgba(), SIZE.map(|px| px as usize));
    let wide = 9;
    let mut page = vec![20; 4 * width * wide * height * wide];
    page.chunks_exact_mut(4).for_each(|pixel| pixel[3] = 255);
    let corner = [width, height].map(|px| px * (wide / 2));
    for y in 0..height {
        let at = 4 * ((y + corner[1]) * width * wide + corner[0]);
        page[at..at + 4 * width].copy_from_slice(&rgba[4 * y * width..4 * (y + 1) * width]);
    }
    let [w, h] = [width * wide, height * wide].map(|px| px as u32);
    let image = Image::new(w, h, &page).unwrap();
    let mut camera = face.camera;
    camera.centre += DVec2::new(corner[0] as f64, corner[1] as f64);
    let light = Light::of(&face.face, &camera, &image).unwrap();
    let (positions, normals) = (face.face.positions(), face.face.normals());
    let edit = Edit::new(
        face.face.model(),
        &camera,
        [w, h],
        Some(light),
        positions,
        normals,
    );
    let there = edit.unwrap().looks(&image, None).unwrap().skin;
    // The same pixels; of others there are eighty times as many, and none of them is white.
    assert!(ratio(there, alone) < 1.02, "{there:?}, {alone:?} alone");
}

/// The albedo is asked at single places of the face: between vertices it is between theirs, and behind the head nobody sees it.
#[test]
fn places_have_the_albedo_of_their_skin() {
    let mut face = Portrait::new(5);
    let [tip, brow] = ["ibug_30", "ibug_24"].map(|name| face.at(name).0);
    let stain = DVec3::new(0.2, 0.15, 0.1);
    face.paint(stain, |p| p.distance(brow) < 12.0);
    let rgba = face.rgba();
    let image = Image::new(SIZE[0], SIZE[1], &rgba).unwrap();
    let edit = edit(&face.face, &face.camera, Some(face.light));
    let mean = &face.face.model().parts().mean;
    let skin = face.face.model().parts().topology.part_vertices("skin");
    let nearest = |at: Vec3| -> u32 {
        let all = skin.iter().copied();
        let found = all.min_by(|&a, &b| {
            let [a, b] = [a, b].map(|v| mean[v as usize].distance(at));
            a.total_cmp(&b)
        });
        found.unwrap()
    };
    let back = skin.iter().copied();
    let back = back.min_by(|&a, &b| mean[a as usize].z.total_cmp(&mean[b as usize].z));
    let [nose, dark, back] = [nearest(tip), nearest(brow), back.unwrap()];
    let ends = [1.0, 0.0, 0.0];
    let places = [
        ([nose, dark, back], ends),
        ([dark, nose, nose], ends),
        ([back, nose, dark], ends),
    ];
    let told = edit.albedos(&image, &places).unwrap();
    let [light, darker, hidden] = [told[0], told[1], told[2]];
    let usual = edit.looks(&image, None).unwrap().skin;
    let colour = |[r, g, b, _]: [f64; 4]| DVec3::new(r, g, b);
    assert!(light[3] > 0.9 && darker[3] > 0.5, "{light:?} {darker:?}");
    assert!(ratio(colour(light), usual) < 1.1, "{light:?} {usual:?}");
    assert!(
        ratio(colour(darker) / colour(light), stain / SKIN) < 1.1,
        "{darker:?} {light:?}"
    );
    assert_eq!(hidden, [0.0; 4], "behind the head");
    let count = mean.len() as u32;
    let why = edit.albedos(&image, &[([0, 1, count], ends)]).unwrap_err();
    assert_eq!(why.to_string(), format!("there is no vertex {count}"));
}

#[test]
fn looks_that_nobody_knows_are_refused() {
    let face = person(1);
    let grey = vec![128; (4 * SIZE[0] * SIZE[1]) as usize];
    let image = Image::new(SIZE[0], SIZE[1], &grey).unwrap();
    let dark = edit(&face, &camera([0.0; 3]), None).looks(&image, None);
    assert!(dark.unwrap_err().to_string().contains("without the light"));
    let small = Image::new(1, 1, &grey[..4]).unwrap();
    let lit = edit(&face, &camera([0.0; 3]), Some(window()));
    let why = lit.looks(&small, None).unwrap_err().to_string();
    assert!(why.contains("480 x 400"), "{why}");
}
