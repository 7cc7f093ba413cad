//! `phiz-fit photograph`.

use std::path::{Path, PathBuf};
use std::time::Instant;

use clap::Args;
use glam::DVec3;

use phiz::fit::format::files::write_atomically;
use phiz::fit::truth::ict::Ict;
use phiz::fit::truth::photograph::{
    Errors, Mistaken, Photograph, Photographer, Report, SETTINGS, SIZE, Setting, write_floats,
    write_model,
};
use phiz::fit::truth::portrait::Portrait;
use phiz::fit::{FitError, FitResult};
use phiz::photo::{Fit, Fitter, Image, Light, Photo};
use phiz::{Expressions, Performance};

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
    /// programs; with `--pixels` also fits to photos in colour.
    #[arg(long, value_name = "DIR")]
    save: Option<PathBuf>,
    /// Draw the photos, too, in grey and in colour, and compare fits to points with fits to points
    /// and pixels.
    #[arg(long)]
    pixels: bool,
    /// Fit expressions, too: those of this file.
    #[arg(long, value_name = "FILE")]
    expressions: Option<PathBuf>,
    /// Photograph people with one to three of the expressions.
    #[arg(long, requires = "expressions")]
    moods: bool,
    /// Fit the points, and pixels, of so many other photos of each person with those of the first.
    #[arg(long, value_name = "COUNT", default_value_t = 0, value_parser = clap::value_parser!(u64).range(..=20))]
    others: u64,
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
    /// And of those to pixels, when there are any.
    by_pixels: Vec<DVec3>,
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
    /// From that of our fit to pixels.
    pixels_rotation: Option<[f64; 9]>,
    /// px.
    points: Vec<[f64; 2]>,
}

impl Saved {
    /// `NAME.json`, `NAME.truth.f32`, `NAME.fitted.f32`, and with pixels `NAME.pixels.f32`.
    fn write(&self, folder: &Path, name: &str) -> FitResult<()> {
        let path = folder.join(format!("{name}.json"));
        let json = serde_json::to_vec(&self.photos).map_err(|e| FitError::file(&path, e))?;
        write_atomically(&path, &json)?;
        write_floats(&folder.join(format!("{name}.truth.f32")), &self.truth)?;
        if !self.by_pixels.is_empty() {
            write_floats(&folder.join(format!("{name}.pixels.f32")), &self.by_pixels)?;
        }
        write_floats(&folder.join(format!("{name}.fitted.f32")), &self.fitted)
    }
}

pub fn run(args: &PhotographArgs) -> FitResult<()> {
    let template = super::read_template(&args.template)?;
    let model = super::read_model(&args.model)?;
    if model.parts().mean.len() != template.positions.len() {
        let cause = "the model and the template have different numbers of vertices";
        return Err(FitError::file(&args.model, cause));
    }
    let ict = super::step("reading ICT-FaceKit", || Ict::read(&args.ict))?;
    let reference = super::step("registering ICT's mean", || {
        super::evaluate::reference(&template, &ict)
    })?;
    let expressions = (args.expressions.as_ref())
        .map(|path| -> FitResult<Expressions> {
            Expressions::parse(&super::read(path)?, &model).map_err(|e| FitError::file(path, e))
        })
        .transpose()?;
    let mut photographer = Photographer::new(&template, &reference, &ict)?;
    if let Some(expressions) = expressions.as_ref().filter(|_| args.moods) {
        photographer = photographer.of_moods(&model, expressions);
    }
    let fitter = Fitter::new(&model, expressions.as_ref())?;
    if let Some(folder) = &args.save {
        write_model(&model, &photographer, folder)?;
    }
    if args.pixels && args.save.is_none() {
        return pixels(args, &photographer, (&fitter, expressions.as_ref()), &ict);
    }
    let mut reports = Vec::new();
    let (mut seconds, mut fits) = (0.0, 0);
    for setting in &SETTINGS {
        let mut people = Vec::new();
        let mut mistaken = Vec::new();
        let mut saved = Saved::default();
        for seed in (0..args.count).map(|i| args.seed.wrapping_add(i.into())) {
            let photograph = photographer.take(seed, setting);
            let others = others(args, &photographer, seed, setting);
            let others: Vec<Photo> = others.iter().map(|other| photo(other, &[])).collect();
            let photo = photo(&photograph, &others);
            let started = Instant::now();
            let fit = fitter.fit(&photo)?;
            seconds += started.elapsed().as_secs_f64();
            fits += 1;
            let mut face = model.face();
            face.set_coefficients(&fit.coefficients)?;
            let positions: Vec<DVec3> = face.positions().iter().map(|p| p.as_dvec3()).collect();
            let errors = photographer.measure(&photograph, &positions, fit.camera.rotation);
            people.push((seed, errors));
            mistaken.push(Mistaken::of(&fit.expression, &photograph.weights));
            if args.save.is_some() {
                saved.truth.extend(&photograph.truth);
                let fitted = photographer.face.iter().map(|&v| positions[v as usize]);
                saved.fitted.extend(fitted);
                let mut pixels_rotation = None;
                if args.pixels {
                    let portrait = Portrait::take(&photograph, &ict, true);
                    let image = Image::new(SIZE, SIZE, &portrait.rgba)?;
                    let fit = fitter.fit_pixels(&photo, &image)?;
                    face.set_coefficients(&fit.coefficients)?;
                    let vertices = photographer.face.iter();
                    let fitted = vertices.map(|&v| face.positions()[v as usize].as_dvec3());
                    saved.by_pixels.extend(fitted);
                    pixels_rotation = Some(fit.camera.rotation.transpose().to_cols_array());
                }
                saved.photos.push(SavedPhoto {
                    pixels_rotation,
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
        reports.push(Measured {
            report: Report::of(setting, people),
            expressions: expressions.as_ref().map(|_| Mistaken::mean(&mistaken)),
        });
    }
    if args.json {
        let json = serde_json::to_string(&reports).map_err(|e| FitError::Input(e.to_string()))?;
        println!("{json}");
    } else {
        println!(
            "{:12}{:>12}{:>12}{:>12}{:>12}{:>30}",
            "",
            "rigid, mm",
            "similar, mm",
            "size",
            "pose, deg",
            if expressions.is_some() {
                "expressions, spurious, off"
            } else {
                ""
            }
        );
        for Measured {
            report: r,
            expressions,
        } in &reports
        {
            print!(
                "{:12}{:12.3}{:12.3}{:12.4}{:12.2}",
                r.setting.name, r.rigid, r.similarity, r.size, r.turn
            );
            match expressions {
                Some(m) => println!("{:14.1}{:10.3}{:6.2}", m.shown, m.spurious, m.off),
                None => println!(),
            }
        }
        println!("{:.2} ms a fit", 1e3 * seconds / f64::from(fits));
    }
    Ok(())
}

/// What was measured of points alone.
#[derive(serde::Serialize)]
struct Measured {
    #[serde(flatten)]
    report: Report,
    /// Means over people; of fits with expressions.
    #[serde(skip_serializing_if = "Option::is_none")]
    expressions: Option<Mistaken>,
}

/// The other photos of a person.
fn others(
    args: &PhotographArgs,
    photographer: &Photographer,
    seed: u64,
    setting: &Setting,
) -> Vec<Photograph> {
    let each = 1..=args.others;
    each.map(|time| photographer.take_again(seed, time, setting))
        .collect()
}

fn photo<'a>(photograph: &'a Photograph, others: &'a [Photo<'a>]) -> Photo<'a> {
    Photo {
        width: SIZE,
        height: SIZE,
        points: &photograph.points,
        focal: None,
        noise: None,
        jaw: None,
        irises: None,
        others,
        image: None,
    }
}

/// What pixels add to points, on the photos of a setting.
#[derive(serde::Serialize)]
struct Comparison {
    colour: bool,
    points: Report,
    pixels: Report,
    /// The part of the people of whom fits with pixels are worse.
    worse: f64,
    /// The part of whom pixels told nothing.
    unused: f64,
    /// The root mean square of [`Photographer::shading`] over people.
    shading: f64,
    /// The same with the photo's own light on the fitted face.
    shading_of_shape: f64,
    /// The same with the photo's own light on the person's own shape, on the model's mesh: with this mesh nothing is nearer.
    shading_of_mesh: f64,
    /// The median of a fit with pixels.
    milliseconds: f64,
    /// Means over people; of fits with expressions.
    #[serde(skip_serializing_if = "Option::is_none")]
    expressions: Option<Mistaken>,
}

fn pixels(
    args: &PhotographArgs,
    photographer: &Photographer,
    fitter: (&Fitter, Option<&Expressions>),
    ict: &Ict,
) -> FitResult<()> {
    let mut all = Vec::new();
    for setting in &SETTINGS {
        for colour in [false, true] {
            all.push(compare(args, photographer, fitter, ict, setting, colour)?);
        }
    }
    if args.json {
        let json = serde_json::to_string(&all).map_err(|e| FitError::Input(e.to_string()))?;
        println!("{json}");
        return Ok(());
    }
    println!(
        "{:17}{:>16}{:>8}{:>7}{:>8}{:>16}{:>8}{:>7}{:>32}{:>5}",
        "",
        "similar, mm",
        "ratio",
        "worse",
        "unused",
        "rigid, mm",
        "size",
        "pose",
        "shading, by shape, by mesh",
        "ms"
    );
    for c in &all {
        print!(
            "{:10}{:7}{:7.3} -> {:.3}{:8.3}{:5.0} %{:6.0} %{:9.3} -> {:.3}{:8.4}{:7.2}{:18.1} %{:4.1} %{:4.1} %{:5.0}",
            c.points.setting.name,
            if c.colour { "colour" } else { "grey" },
            c.points.similarity,
            c.pixels.similarity,
            c.pixels.similarity / c.points.similarity,
            100.0 * c.worse,
            100.0 * c.unused,
            c.points.rigid,
            c.pixels.rigid,
            c.pixels.size,
            c.pixels.turn,
            100.0 * c.shading,
            100.0 * c.shading_of_shape,
            100.0 * c.shading_of_mesh,
            c.milliseconds
        );
        match &c.expressions {
            Some(m) => println!("{:14.1}{:10.3}{:6.2}", m.shown, m.spurious, m.off),
            None => println!(),
        }
    }
    Ok(())
}

fn compare(
    args: &PhotographArgs,
    photographer: &Photographer,
    (fitter, expressions): (&Fitter, Option<&Expressions>),
    ict: &Ict,
    setting: &Setting,
    colour: bool,
) -> FitResult<Comparison> {
    let mut mistaken = Vec::new();
    let (mut by_points, mut by_pixels) = (Vec::new(), Vec::new());
    let (mut worse, mut unused, mut shading, mut seconds) = (0, 0, [0.0; 3], Vec::new());
    let mesh_triangles = fitter.model().parts().topology.triangles();
    for seed in (0..args.count).map(|i| args.seed.wrapping_add(i.into())) {
        let photograph = photographer.take(seed, setting);
        let portrait = Portrait::take(&photograph, ict, colour);
        let image = Image::new(SIZE, SIZE, &portrait.rgba)?;
        let others = others(args, photographer, seed, setting);
        let portraits: Vec<Portrait> = others
            .iter()
            .map(|other| Portrait::take(other, ict, colour))
            .collect();
        let others: Vec<Photo> = (others.iter().zip(&portraits))
            .map(|(other, portrait)| {
                Ok(Photo {
                    image: Some(Image::new(SIZE, SIZE, &portrait.rgba)?),
                    ..photo(other, &[])
                })
            })
            .collect::<FitResult<_>>()?;
        let photo = photo(&photograph, &others);
        let first = fitter.fit(&photo)?;
        let started = Instant::now();
        let fit = fitter.fit_pixels(&photo, &image)?;
        seconds.push(started.elapsed().as_secs_f64());
        unused += u32::from(fit.appearance.is_none());
        let face = |fit: &Fit| -> FitResult<(phiz::Face, Errors)> {
            let mut face = fitter.model().face();
            face.set_coefficients(&fit.coefficients)?;
            let positions: Vec<DVec3> = face.positions().iter().map(|p| p.as_dvec3()).collect();
            let errors = photographer.measure(&photograph, &positions, fit.camera.rotation);
            Ok((face, errors))
        };
        let (_, before) = face(&first)?;
        let (face, after) = face(&fit)?;
        worse += u32::from(after.similarity > before.similarity);
        mistaken.push(Mistaken::of(&fit.expression, &photograph.weights));
        let mut performance = expressions.map(Performance::new);
        if let Some(performance) = &mut performance {
            let list = expressions.map_or(&[][..], |e| e.list());
            for (e, &weight) in list.iter().zip(&fit.expression) {
                performance.set(&e.name, weight)?;
            }
            performance.perform(&face)?;
        }
        let mesh = match &performance {
            Some(p) if !p.is_at_rest() => [p.positions(), p.normals()],
            _ => [face.positions(), face.normals()],
        };
        let light = Light::on(fitter.model(), mesh, &fit.camera, &image)?;
        let normals: Vec<DVec3> = mesh[1].iter().map(|n| n.as_dvec3()).collect();
        let places: Vec<DVec3> = mesh[0].iter().map(|p| p.as_dvec3()).collect();
        let own = photographer.normals(&photograph, &places, &mesh_triangles);
        let truth = |n| portrait.shade(n, colour);
        let turn = photograph.camera.rotation.transpose() * fit.camera.rotation;
        let off = [
            photographer.shading(&photograph, truth, &normals, |n| light.shade(n)),
            photographer.shading(&photograph, truth, &normals, |n| truth(turn * n)),
            photographer.shading(&photograph, truth, &own, truth),
        ];
        for (sum, off) in shading.iter_mut().zip(off) {
            *sum += off * off;
        }
        by_points.push((seed, before));
        by_pixels.push((seed, after));
    }
    seconds.sort_unstable_by(f64::total_cmp);
    let count = f64::from(args.count);
    let [shading, shading_of_shape, shading_of_mesh] = shading.map(|sum| (sum / count).sqrt());
    Ok(Comparison {
        colour,
        expressions: expressions.map(|_| Mistaken::mean(&mistaken)),
        points: Report::of(setting, by_points),
        pixels: Report::of(setting, by_pixels),
        worse: f64::from(worse) / count,
        unused: f64::from(unused) / count,
        shading,
        shading_of_shape,
        shading_of_mesh,
        milliseconds: 1e3 * seconds[seconds.len() / 2],
    })
}
