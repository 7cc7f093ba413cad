//! `phiz-fit photograph`.

use std::path::{Path, PathBuf};
use std::time::Instant;

use clap::Args;
use glam::DVec3;

use phiz::fit::files::write_atomically;
use phiz::fit::ict::Ict;
use phiz::fit::photograph::{Photographer, Report, SETTINGS, SIZE, write_floats, write_model};
use phiz::fit::{FitError, FitResult};
use phiz::photo::{Fitter, Photo};

#[derive(Args)]
pub struct PhotographArgs {
    /// The folder of ICT-FaceKit (holds `FaceXModel`).
    #[arg(long, value_name = "DIR")]
    ict: PathBuf,
    /// The generic head.
    #[arg(long, value_name = "FILE")]
    template: PathBuf,
    /// How many people.
    #[arg(long, default_value_t = 50, value_parser = clap::value_parser!(u32).range(1..))]
    count: u32,
    /// The first person's seed; the next person has the next one.
    #[arg(long, default_value_t = 9000)]
    seed: u64,
    /// Write the model, the photos' points, the truth and the fits into this folder, for other
    /// programs.
    #[arg(long, value_name = "DIR")]
    save: Option<PathBuf>,
    /// As JSON.
    #[arg(long)]
    json: bool,
    /// The model that is fitted.
    model: PathBuf,
}

/// The photos of a setting, for other programs.
#[derive(Default)]
struct Saved {
    photos: Vec<SavedPhoto>,
    /// The face area's vertices, a photo after another, mm.
    truth: Vec<DVec3>,
    /// The same of our fits.
    fitted: Vec<DVec3>,
}

#[derive(serde::Serialize)]
struct SavedPhoto {
    seed: u64,
    /// px.
    focal: f64,
    /// From the truth's frame to the camera's (x right, y down, z forward), row by row.
    rotation: [f64; 9],
    /// From our fit's.
    fitted_rotation: [f64; 9],
    /// px.
    points: Vec<[f64; 2]>,
}

impl Saved {
    /// `NAME.json`, `NAME.truth.f32` and `NAME.fitted.f32`.
    fn write(&self, folder: &Path, name: &str) -> FitResult<()> {
        let path = folder.join(format!("{name}.json"));
        let json = serde_json::to_vec(&self.photos).map_err(|e| FitError::file(&path, e))?;
        write_atomically(&path, &json)?;
        write_floats(&folder.join(format!("{name}.truth.f32")), &self.truth)?;
        write_floats(&folder.join(format!("{name}.fitted.f32")), &self.fitted)
    }
}

pub fn run(args: &PhotographArgs) -> FitResult<()> {
    let template = super::read_template(&args.template)?;
    let model = super::read_model(&args.model)?;
    if model.parts().mean.len() != template.positions.len() {
        let cause = "the model and the template have different numbers of vertices";
        return Err(FitError::Input(cause.into()));
    }
    let ict = super::step("reading ICT-FaceKit", || Ict::read(&args.ict))?;
    let reference = super::step("registering ICT's mean", || {
        super::evaluate::reference(&template, &ict)
    })?;
    let photographer = Photographer::new(&template, &reference, &ict)?;
    let fitter = Fitter::new(&model, None)?;
    if let Some(folder) = &args.save {
        write_model(&model, &photographer, folder)?;
    }
    if let Ok(which) = std::env::var("PROTO") { return proto(args, &which, &photographer, &fitter, &model, &ict); }
    let mut reports = Vec::new();
    let (mut seconds, mut fits) = (0.0, 0);
    for setting in &SETTINGS {
        let mut people = Vec::new();
        let mut saved = Saved::default();
        for seed in (0..args.count).map(|i| args.seed.wrapping_add(i.into())) {
            let photograph = photographer.take(seed, setting);
            let photo = Photo {
                width: SIZE,
                height: SIZE,
                points: &photograph.points,
                focal: None,
                noise: None,
            };
            let started = Instant::now();
            let fit = fitter.fit(&photo)?;
            seconds += started.elapsed().as_secs_f64();
            fits += 1;
            let mut face = model.face();
            face.set_coefficients(&fit.coefficients)?;
            let positions: Vec<DVec3> = face.positions().iter().map(|p| p.as_dvec3()).collect();
            let errors = photographer.measure(&photograph, &positions, fit.camera.rotation);
            people.push((seed, errors));
            if args.save.is_some() {
                saved.truth.extend(&photograph.truth);
                let fitted = photographer.face.iter().map(|&v| positions[v as usize]);
                saved.fitted.extend(fitted);
                saved.photos.push(SavedPhoto {
                    seed,
                    focal: photograph.camera.focal,
                    rotation: photograph.camera.rotation.transpose().to_cols_array(),
                    fitted_rotation: fit.camera.rotation.transpose().to_cols_array(),
                    points: photograph.points,
                });
            }
        }
        if let Some(folder) = &args.save {
            saved.write(folder, setting.name)?;
        }
        reports.push(Report::of(setting, people));
    }
    if args.json {
        let json = serde_json::to_string(&reports).map_err(|e| FitError::Input(e.to_string()))?;
        println!("{json}");
    } else {
        println!(
            "{:12}{:>12}{:>12}{:>12}{:>12}",
            "", "rigid, mm", "similar, mm", "size", "pose, deg"
        );
        for r in &reports {
            println!(
                "{:12}{:12.3}{:12.3}{:12.4}{:12.2}",
                r.setting.name, r.rigid, r.similarity, r.size, r.turn
            );
        }
        println!("{:.2} ms a fit", 1e3 * seconds / f64::from(fits));
    }
    Ok(())
}

fn proto(args: &PhotographArgs, which: &str, photographer: &Photographer, fitter: &Fitter, model: &phiz::FaceModel, ict: &Ict) -> FitResult<()> {
    use phiz::fit::portrait::Portrait;
    use phiz::photo::Image;
    for setting in SETTINGS.iter().filter(|s| which.contains(s.name)) {
        for colour in [false, true] {
            if which.contains("grey") && colour || which.contains("colour") && !colour { continue; }
            let (mut before, mut after) = (Vec::new(), Vec::new());
            let mut shading = Vec::new();
            let mut seconds = 0.0;
            for seed in (0..args.count).map(|i| args.seed.wrapping_add(i.into())) {
                let mut taken = photographer.take(seed, setting);
                let own = std::env::var("OWN").is_ok();
                let mut own_normals = Vec::new();
                let portrait = if own {
                    let mut f = model.face();
                    f.randomize(&phiz::Randomize { seed: Some(seed), ..Default::default() })?;
                    let rot: Vec<DVec3> = f.positions().iter().map(|p| p.as_dvec3()).collect();
                    let chosen: Vec<DVec3> = photographer.face.iter().map(|&v| rot[v as usize]).collect();
                    let every: Vec<u32> = (0..chosen.len() as u32).collect();
                    let align = phiz::fit::align::Rigid::fit(&chosen, &taken.truth, &every, &vec![1.0; chosen.len()]);
                    let positions: Vec<DVec3> = rot.iter().map(|p| align.apply(*p)).collect();
                    let tri = model.parts().topology.triangles();
                    own_normals = phiz::fit::render::normals(&positions, &tri);
                    taken.truth = photographer.face.iter().map(|&v| positions[v as usize]).collect();
                    let f32s: Vec<glam::Vec3> = positions.iter().map(|p| p.as_vec3()).collect();
                    let mut random = phiz::Random::stream(seed, 77);
                    for i in 0..68 {
                        let l = model.parts().landmarks.iter().find(|l| l.name == format!("ibug_{i:02}")).unwrap();
                        let at = taken.camera.project(l.place(&f32s));
                        taken.points[i] = [at.x + setting.noise * random.normal(), at.y + setting.noise * random.normal()];
                    }
                    let mean: Vec<DVec3> = model.parts().mean.iter().map(|p| p.as_dvec3()).collect();
                    Portrait::of(&taken, &mean, &positions, &tri, colour)
                } else { Portrait::take(&taken, ict, colour) };
                let _ = &own_normals;
                if let Ok(dir) = std::env::var("DUMP") {
                    let mut ppm = format!("P6 {SIZE} {SIZE} 255\n").into_bytes();
                    ppm.extend(portrait.rgba.chunks(4).flat_map(|p| [p[0], p[1], p[2]]));
                    std::fs::write(format!("{dir}/{}-{seed}-{colour}.ppm", setting.name), ppm).ok();
                }
                let image = Image::new(SIZE, SIZE, &portrait.rgba)?;
                let photo = Photo { width: SIZE, height: SIZE, points: &taken.points, focal: None, noise: None };
                let started = Instant::now();
                let first = fitter.fit(&photo)?;
                let fit = fitter.fit_pixels(&photo, &image)?;
                let second = fit.appearance.map(|_| fit);
                seconds += started.elapsed().as_secs_f64();
                let measure = |fit: &phiz::photo::Fit| -> FitResult<phiz::fit::photograph::Errors> {
                    let mut face = model.face();
                    face.set_coefficients(&fit.coefficients)?;
                    let positions: Vec<DVec3> = face.positions().iter().map(|p| p.as_dvec3()).collect();
                    Ok(photographer.measure(&taken, &positions, fit.camera.rotation))
                };
                let a = measure(&first)?;
                let b = match &second {
                    Some(fit) => {
                        let mut face = model.face();
                        face.set_coefficients(&fit.coefficients)?;
                        let light = phiz::photo::Light::of(&face, &fit.camera, &image)?;
                        let normals: Vec<DVec3> = face.normals().iter().map(|p| p.as_dvec3()).collect();
                        shading.push(photographer.shading(&taken, |n| portrait.shade(n, colour), &normals, |n| light.shade(n)));
                        measure(fit)?
                    }
                    None => a,
                };
                if std::env::var_os("DBG").is_some() { println!("{seed} {:.3} -> {:.3}", a.similarity, b.similarity); }
                before.push((seed, a));
                after.push((seed, b));
            }
            let worse = before.iter().zip(&after).filter(|(a, b)| b.1.similarity > a.1.similarity).count();
            let (a, b) = (Report::of(setting, before), Report::of(setting, after));
            let rms = (shading.iter().map(|x| x * x).sum::<f64>() / shading.len() as f64).sqrt();
            println!("{:9} {:7} similar {:.3} -> {:.3} ({:.3}) rigid {:.3} -> {:.3} size {:.4} -> {:.4} turn {:.2} -> {:.2} worse {worse}/{} shading {rms:.4} {:.0} ms",
                setting.name, if colour {"colour"} else {"grey"}, a.similarity, b.similarity, b.similarity / a.similarity, a.rigid, b.rigid, a.size, b.size, a.turn, b.turn, args.count, 1e3 * seconds / f64::from(args.count));
        }
    }
    Ok(())
}
