//! `phiz-fit basis`.

use std::path::{Path, PathBuf};

use clap::builder::RangedU64ValueParser;
use clap::error::ErrorKind;
use clap::{Args, ValueEnum};
use indicatif::{ProgressBar, ProgressStyle};

use glam::DVec3;
use phiz::fit::format::files::{check_apart, check_writable, write_atomically};
use phiz::fit::head::template::Template;
use phiz::fit::mesh::align::{procrustes, vertex_areas};
use phiz::fit::mesh::mirror::with_mirror_images;
use phiz::fit::sparse::compare::{BASES, Curve, Trial};
use phiz::fit::sparse::{self, Kind, Problem, Settings, SparseBasis, face_parts, head_parts};
use phiz::fit::validate::bases::COMPONENTS;
use phiz::fit::{FitError, FitResult};

#[derive(Args)]
pub struct BasisArgs {
    /// The generic head.
    #[arg(long, value_name = "FILE")]
    template: PathBuf,
    /// The folder of registered faces (PLY).
    #[arg(long, value_name = "DIR")]
    faces: PathBuf,
    /// Where components may be.
    #[arg(long, value_enum, default_value_t = Where::Region)]
    kind: Where,
    /// What is modelled.
    #[arg(long, value_enum, default_value_t = Area::Face)]
    area: Area,
    /// How many components.
    #[arg(long, default_value_t = 65)]
    components: usize,
    /// Learn from the faces as they are, without the mirror image of each.
    #[arg(long)]
    one_sided: bool,
    #[arg(long, help = usual("Iterations at most", Settings::default().iterations))]
    iterations: Option<usize>,
    #[arg(long, value_parser = super::within(0.0..=1.0), help = usual(
        "Stop when the objective changes by less than this part over five iterations",
        Settings::default().tolerance
    ))]
    tolerance: Option<f64>,
    /// Alternate between weights and components as published, without trying to go farther at
    /// once.
    #[arg(long)]
    plain: bool,
    /// Write weights and displacements for one standard deviation each, instead of for a largest
    /// weight of 1.
    #[arg(long)]
    sigmas: bool,
    /// Write what is optimised into this folder too, for another program: `problem.json` says what
    /// is in the other files.
    #[arg(long, value_name = "DIR")]
    save_problem: Option<PathBuf>,
    /// Compare bases instead: learn each from this many of the faces, chosen at random, and
    /// measure it on others. Prints mean errors over the splits, and writes all of them. Of scans that labels.json tells
    /// to be of one person the first is taken.
    #[arg(
        long,
        value_name = "COUNT",
        value_parser = RangedU64ValueParser::<usize>::new().range(3..),
        conflicts_with_all = ["components", "kind", "area", "one_sided", "sigmas", "save_problem"]
    )]
    compare: Option<usize>,
    /// On how many others.
    #[arg(
        long,
        default_value_t = 100,
        requires = "compare",
        value_name = "COUNT",
        value_parser = RangedU64ValueParser::<usize>::new().range(1..)
    )]
    test: usize,
    /// How many splits of the faces into the two.
    #[arg(
        long,
        default_value_t = 5,
        requires = "compare",
        value_name = "COUNT",
        value_parser = clap::value_parser!(u64).range(1..)
    )]
    splits: u64,
    /// The first split's seed; the next has the next one.
    #[arg(long, default_value_t = 1, requires = "compare")]
    seed: u64,
    /// The basis (or the comparison) to write, as JSON.
    #[arg(short, value_name = "FILE")]
    output: PathBuf,
}

/// The help of an option that clap must not fill in: whether it was given counts.
fn usual(help: &str, value: impl std::fmt::Display) -> String {
    format!("{help} [default: {value}]")
}

#[derive(Clone, Copy, PartialEq, ValueEnum)]
enum Where {
    /// In a part of the face and a band around it.
    Region,
    /// Around a centre, wherever faces vary.
    Distance,
    /// Everywhere: principal components, to compare with.
    Pca,
}

#[derive(Clone, Copy, PartialEq, ValueEnum)]
enum Area {
    /// The skin of the face.
    Face,
    /// The whole head, with eyeballs and cavities.
    Head,
}

impl BasisArgs {
    /// What is said of all bases that are optimised.
    fn settings(&self) -> Settings {
        let usual = Settings::default();
        Settings {
            iterations: self.iterations.unwrap_or(usual.iterations),
            tolerance: self.tolerance.unwrap_or(usual.tolerance),
            bold: !self.plain,
            ..usual
        }
    }

    /// The first option that says how to optimise what principal components do not.
    fn optimises(&self) -> Option<&'static str> {
        [
            ("--iterations", self.iterations.is_some()),
            ("--tolerance", self.tolerance.is_some()),
            ("--plain", self.plain),
            ("--save-problem", self.save_problem.is_some()),
        ]
        .into_iter()
        .find_map(|(option, given)| given.then_some(option))
    }
}

pub fn run(args: &BasisArgs) -> FitResult<()> {
    if args.kind == Where::Pca
        && let Some(option) = args.optimises()
    {
        let cause = format!("{option} is of no use with --kind pca, which optimises nothing");
        super::refuse("basis", ErrorKind::ArgumentConflict, cause);
    }
    check_apart(&[&args.output], &[("the template", &args.template)])?;
    super::check_apart_from(&args.faces, &[&args.output])?;
    check_writable(&args.output)?;
    let template = super::read_template(&args.template)?;
    let (names, mut faces) = super::read_faces(&args.faces, &template)?;
    let persons = super::persons_of(&args.faces, &names)?;
    if let Some(train) = args.compare {
        super::say_scans(&args.faces, &persons, "the first is taken");
        // Nobody is learned from and tried.
        let of_each = persons.one_each().into_iter();
        let of_each: Vec<_> = of_each.map(|i| std::mem::take(&mut faces[i])).collect();
        return compare(args, &template, &of_each, train);
    }
    super::say_scans(&args.faces, &persons, "each scan is learned from as a face");
    let of_faces = |e: FitError| e.of(&args.faces);
    let triangles = template.triangles();
    let parts = face_parts(&template).map_err(|e| e.of(&args.template))?;
    if !args.one_sided {
        // What is learned from would be told to be two.
        if faces.len() < 2 {
            let cause =
                "1 face is too few to learn from; 2 are the least, with their mirror images";
            return Err(FitError::file(&args.faces, cause));
        }
        faces = with_mirror_images(&faces, &template.topology.mirror);
    }
    // The pose is that of the face, whatever is modelled: a basis of the head is one of the face.
    let mut face: Vec<u32> = parts.iter().flat_map(|p| &p.vertices).copied().collect();
    face.sort_unstable();
    let areas = vertex_areas(&template.positions, &triangles);
    procrustes(&mut faces, &template.positions, &face, &areas, None);
    let regions = match args.area {
        Area::Face => parts,
        Area::Head => head_parts(&template).map_err(|e| e.of(&args.template))?,
    };
    let kind = match args.kind {
        Where::Region => Kind::REGIONS,
        Where::Distance => Kind::DISTANCE,
        Where::Pca => {
            let basis = sparse::principal(&faces, &regions, args.components).map_err(of_faces)?;
            return write(args, &basis, None);
        }
    };
    let settings = Settings {
        components: args.components,
        kind,
        ..args.settings()
    };
    if let Some(folder) = &args.save_problem {
        let problem = sparse::problem(&faces, &triangles, &regions, &settings).map_err(of_faces)?;
        save(folder, &problem, &settings)?;
    }
    let style = ProgressStyle::with_template("{bar:30} {pos} of at most {len}, objective {msg}");
    let bar = ProgressBar::new(settings.iterations as u64);
    bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
    let told = |iteration: usize, objective: f64| {
        bar.set_position(iteration as u64);
        bar.set_message(format!("{objective:.6e}"));
    };
    let learned = sparse::learn(&faces, &triangles, &regions, &settings, told);
    bar.finish_and_clear();
    let (basis, report) = learned.map_err(of_faces)?;
    let last = report.objective.len() - 1;
    println!(
        "objective {:.6e} mm^2 after {last} iterations, from {:.6e}; {:.3} s for the start, {:.3} s \
         for the iterations",
        report.objective[last], report.objective[0], report.seconds[0], report.seconds[1]
    );
    if !report.converged {
        eprintln!(
            "phiz-fit: warning: the objective still changes, or ADMM's residual of {:.1e} is over \
             its limit",
            report.residual
        );
    }
    write(args, &basis, Some(&report))
}

fn compare(
    args: &BasisArgs,
    template: &Template,
    faces: &[Vec<DVec3>],
    train: usize,
) -> FitResult<()> {
    let settings = args.settings();
    let steps = (COMPONENTS.len() * BASES.len()) as u64;
    let bar = ProgressBar::new(args.splits.saturating_mul(steps));
    let style = ProgressStyle::with_template("{bar:30} {pos} of {len} bases, {eta} left");
    bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
    let mut all: Vec<Vec<Curve>> = Vec::new();
    for split in 0..args.splits {
        let trial = Trial {
            train,
            test: args.test,
            seed: args.seed.wrapping_add(split),
            components: COMPONENTS.to_vec(),
        };
        let kinds = [Kind::REGIONS, Kind::DISTANCE];
        let curves =
            sparse::compare::compare(template, faces, &trial, &settings, kinds, || bar.inc(1));
        all.push(curves.map_err(|e| e.of(&args.faces))?);
    }
    bar.finish_and_clear();
    let path = &args.output;
    let bytes = serde_json::to_vec_pretty(&all).map_err(|e| FitError::file(path, e))?;
    write_atomically(path, &bytes)?;
    println!(
        "Mean error on {} faces after learning from {train}, mm, mean of {} splits",
        args.test, args.splits
    );
    let cells = |values: &[f64]| -> String { values.iter().map(|v| format!("{v:8.3}")).collect() };
    let counts: String = COMPONENTS.iter().map(|k| format!("{k:8}")).collect();
    println!("{:24}{counts}", "components");
    for (basis, name) in BASES.iter().enumerate() {
        for (what, of) in [
            ("", (|c: &Curve| &c.test) as fn(&Curve) -> &Vec<f64>),
            (" (seen)", |c: &Curve| &c.train),
        ] {
            let mean: Vec<f64> = (0..COMPONENTS.len())
                .map(|i| all.iter().map(|s| of(&s[basis])[i]).sum::<f64>() / all.len() as f64)
                .collect();
            println!("{:24}{}", format!("{name}{what}"), cells(&mean));
        }
    }
    let open = all.iter().flatten().flat_map(|c| &c.converged);
    let open = open.filter(|converged| !**converged).count();
    if open > 0 {
        eprintln!(
            "phiz-fit: warning: {open} bases were not at rest after {} iterations",
            settings.iterations
        );
    }
    Ok(())
}

/// Writes a basis and says what is in it.
fn write(args: &BasisArgs, basis: &SparseBasis, report: Option<&sparse::Report>) -> FitResult<()> {
    let scaled;
    let basis = match args.sigmas {
        true => {
            scaled = basis.clone().in_sigmas();
            &scaled
        }
        false => basis,
    };
    let json = serde_json::json!({ "basis": basis, "report": report });
    let path = &args.output;
    let bytes = serde_json::to_vec(&json).map_err(|e| FitError::file(path, e))?;
    write_atomically(path, &bytes)?;
    let mut names: Vec<&str> = Vec::new();
    for component in &basis.components {
        let name = component.region.as_deref().unwrap_or("anywhere");
        if !names.contains(&name) {
            names.push(name);
        }
    }
    for name in names {
        let own = basis.components.iter();
        let own = own.filter(|c| c.region.as_deref().unwrap_or("anywhere") == name);
        let sizes: Vec<usize> = own.map(|c| c.support.len()).collect();
        println!(
            "{name:10} {:3} components, which move {} vertices on average",
            sizes.len(),
            sizes.iter().sum::<usize>() / sizes.len()
        );
    }
    println!(
        "{}: {} components of {} vertices",
        path.display(),
        basis.components.len(),
        basis.vertices.len()
    );
    Ok(())
}

/// Files of little-endian f64, row-major, and their sizes.
fn save(folder: &Path, problem: &Problem, settings: &Settings) -> FitResult<()> {
    std::fs::create_dir_all(folder).map_err(|e| FitError::file(folder, e))?;
    for (name, matrix) in [
        ("samples", &problem.samples),
        ("lambda", &problem.lambda),
        ("components", &problem.components),
        ("weights", &problem.weights),
    ] {
        let bytes: Vec<u8> = matrix
            .iter()
            .flatten()
            .flat_map(|x| x.to_le_bytes())
            .collect();
        write_atomically(&folder.join(format!("{name}.f64")), &bytes)?;
    }
    let header = serde_json::json!({
        "faces": problem.samples.len(), "vertices": problem.vertices.len(),
        "components": problem.components.len(), "iterations": settings.iterations,
        "steps": settings.steps,
        "files": {
            "samples.f64": "faces x 3 vertices: displacements from the mean, mm",
            "lambda.f64": "components x vertices: the penalty; infinite is nowhere",
            "components.f64": "components x 3 vertices: the start, mm at a weight of 1",
            "weights.f64": "faces x components: the start",
        },
    });
    let path = folder.join("problem.json");
    let bytes = serde_json::to_vec_pretty(&header).map_err(|e| FitError::file(&path, e))?;
    write_atomically(&path, &bytes)
}
