//! `phiz-fit measure`.

use std::path::PathBuf;

use clap::Args;
use glam::DVec3;
use indicatif::{ProgressBar, ProgressStyle};

use phiz::fit::format::files::{check_apart, check_writable};
use phiz::fit::format::ply;
use phiz::fit::measure::{TABLE, measure, write_faces, write_table};
use phiz::fit::{FitResult, counted};

#[derive(Args)]
#[command(after_help = TABLE)]
pub struct MeasureArgs {
    /// The model.
    model: PathBuf,
    /// The folder of registered faces (PLY), as `register` leaves them; or one of them.
    #[arg(long, value_name = "DIR")]
    faces: PathBuf,
    /// Write the faces here, too, as the model has them: a JSON that the page opens, all at once.
    #[arg(long, value_name = "FILE")]
    designs: Option<PathBuf>,
    /// What the model is taken to leave of each face, mm RMS, where all are to be drawn towards the mean alike.
    #[arg(long, value_name = "MM", value_parser = super::within(0.0..=10.0))]
    left: Option<f64>,
    /// The table to write.
    #[arg(short, value_name = "FILE")]
    output: PathBuf,
}

pub fn run(args: &MeasureArgs) -> FitResult<()> {
    let written: Vec<_> = [Some(&args.output), args.designs.as_ref()]
        .into_iter()
        .flatten()
        .map(PathBuf::as_path)
        .collect();
    check_apart(&written, &[("the model", &args.model)])?;
    super::check_apart_from(&args.faces, &written)?;
    for path in &written {
        check_writable(path)?;
    }
    let model = super::read_model(&args.model)?;
    super::check_varies(&args.model, &model)?;
    let parts = model.parts();
    let mean: Vec<DVec3> = parts.mean.iter().map(|p| p.as_dvec3()).collect();
    let triangles = parts.topology.triangles();
    let faces = super::step("reading faces", || {
        ply::read_faces(&args.faces, &mean, &triangles)
    })?;
    let style = ProgressStyle::with_template("{bar:30} {pos} of {len} faces, {eta} left");
    let bar = ProgressBar::new(faces.len() as u64);
    bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
    let measured =
        measure(&model, &faces, args.left, || bar.inc(1)).map_err(|e| e.of(&args.faces))?;
    bar.finish_and_clear();
    write_table(&model, &measured, &args.output)?;
    if let Some(path) = &args.designs {
        write_faces(&model, &measured, path)?;
    }
    let squares: f64 = measured.iter().map(|face| face.left * face.left).sum();
    let worst = measured.iter().max_by(|a, b| a.left.total_cmp(&b.left));
    let worst = worst.map(|face| format!("{:.2} of {}", face.left, face.name));
    println!(
        "{}: {}, of whose skin the model leaves {:.2} mm RMS, at most {}",
        args.output.display(),
        counted(measured.len()),
        (squares / measured.len() as f64).sqrt(),
        worst.unwrap_or_default(),
    );
    Ok(())
}
