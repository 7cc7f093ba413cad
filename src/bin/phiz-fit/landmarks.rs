//! `phiz-fit landmarks`.

use std::path::{Path, PathBuf};

use clap::Args;

use phiz::fit::FitResult;
use phiz::fit::detect::Detector;
use phiz::fit::format::files::{check_apart, check_writable};
use phiz::fit::register::batch;
use phiz::fit::scan::{Scan, Unit, landmarks};

/// What files of landmarks call the points of the generic head, for `--help`.
pub const NAMES: &str = "\
Names of landmarks in a JSON, as {\"ibug_30\": [x, y, z], ...}, or of points in MeshLab's .pp, four of them
or more (a fourth number in a JSON is how far a point may be off, in the scan's unit; such points count as
much as they are certain; brows are marked on their hair, but in a JSON, which has their points where the
generic head has them, some 5 mm above):
  ibug_00 to ibug_67, the 68 points of iBUG (300-W) from 0, a person's right first;
  glabella, pogonion, supramentale, trichion, vertex;
  each with \" right\" or \" left\" of the person: alare, tragion, gonion, cheek, postaurale,
  helix root, crus helicis, intertragic notch, superaurale, subaurale, lower helix";

#[derive(Args)]
#[command(after_help = NAMES)]
pub struct LandmarksArgs {
    /// The generic head.
    #[arg(long, value_name = "FILE")]
    template: PathBuf,
    /// The scan: OBJ, PLY, GLB, glTF or STL, in any pose.
    #[arg(long, value_name = "FILE")]
    scan: PathBuf,
    /// The scan's unit: mm, cm, m, inch, or how many mm it has. Without it it is guessed by size, and said.
    #[arg(long)]
    unit: Option<Unit>,
    /// How sure a point must be, 0 to 1; others are left out. With 0 all are there: those that the scan does not show, where
    /// the face that was found has them, with an error of 100 mm, by which `register` leaves them out until a hand sets
    /// them.
    #[arg(long, default_value_t = 0.3, value_name = "CONFIDENCE", value_parser = crate::within(0.0..=1.0))]
    least: f64,
    /// The JSON file of landmarks to write, in the scan's unit; without it they are printed.
    #[arg(short, value_name = "FILE")]
    output: Option<PathBuf>,
}

pub fn run(args: &LandmarksArgs) -> FitResult<()> {
    let written: Vec<&Path> = args.output.as_deref().into_iter().collect();
    let read: [(&str, &Path); 2] = [("the template", &args.template), ("the scan", &args.scan)];
    check_apart(&written, &read)?;
    args.output.as_deref().map_or(Ok(()), check_writable)?;
    let template = super::read_template(&args.template)?;
    let mut scan = super::step("reading the scan", || {
        Scan::read_shape(&args.scan, args.unit)
    })?;
    scan.check_beside(&written)?;
    let found = super::step("looking for the face", || {
        batch::find(&Detector::new(&template)?, &mut scan, &template)
    });
    // What was decided may be why there is no face.
    scan.notes.iter().for_each(|note| eprintln!("{note}"));
    let found = found?;
    let points = found.landmarks(args.least);
    let Some(output) = &args.output else {
        println!("{:16} {:>12} {:>12} {:>12}  confidence", "", "x", "y", "z");
        for (i, p) in points {
            let (p, name) = (p / scan.scale, &template.landmarks[i].name);
            let confidence = found.confidences[i];
            println!(
                "{name:16} {:12.6} {:12.6} {:12.6}  {confidence:.2}",
                p.x, p.y, p.z
            );
        }
        return Ok(());
    };
    landmarks::write(output, &points, &found.errors, scan.scale, &template)?;
    let sure: f64 = points.iter().map(|&(i, _)| found.confidences[i]).sum();
    println!(
        "{}: {} of {} points, mean confidence {:.2}, evidence for a face {:.2}",
        output.display(),
        points.len(),
        template.landmarks.len(),
        sure / points.len().max(1) as f64,
        found.evidence
    );
    Ok(())
}
