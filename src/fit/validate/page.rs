//! The report for people: `index.html`, which holds its pictures in itself, and a short copy for
//! a project's documentation.

use std::fmt::Write;
use std::path::Path;

use base64ct::{Base64, Encoding};

use super::bases::{FEWEST_TEST, TRAINING};
use super::held_out::{AreaErrors, HeldOut, Interval};
use super::plots::{self, Axes, Line};
use super::{COUNTED, PAPER, Person, Report, Validated, pictures};
use crate::fit::format::files::write_atomically;
use crate::fit::format::text::decoded;
use crate::fit::picture::render::Image;
use crate::fit::truth::simulate;
use crate::fit::{FitError, FitResult};

/// A part of the report.
struct Section {
    title: &'static str,
    content: Vec<Content>,
    /// Whether the short copy has it.
    short: bool,
}

enum Content {
    Text(String),
    Table(Vec<String>, Vec<Vec<String>>),
    Plot(&'static str, String, String),
    Picture(&'static str, Vec<u8>, String),
}

/// How a short copy says what it is.
const WRITTEN: &str = "Written by `phiz-fit validate`";

/// How a report says what it is.
const GENERATOR: &str = "<meta name=\"generator\" content=\"phiz-fit validate\">";

/// Refuses a folder for the report whose `index.html` is somebody's, before the work.
///
/// # Errors
/// When there is an `index.html` that is no report, or a `report.json` beside none, or one that cannot be read.
pub fn check_report(folder: &Path) -> FitResult<()> {
    // Reports that did not say so yet are told by their style.
    let is_ours = |text: &str| text.contains(GENERATOR) || text.contains(STYLE);
    check_own(&folder.join("index.html"), is_ours, "the report")
}

/// Refuses a folder for the short copy whose README is somebody's, before the work.
///
/// # Errors
/// When there is a `README.md` that is no short copy, or a `report.json` beside none, or one that cannot be read.
pub fn check_short(folder: &Path) -> FitResult<()> {
    let is_ours = |text: &str| text.lines().any(|line| line.starts_with(WRITTEN));
    check_own(&folder.join("README.md"), is_ours, "the short copy")
}

/// Refuses to write over a page that is not ours, or over numbers that no page of ours is beside.
fn check_own(page: &Path, is_ours: impl Fn(&str) -> bool, what: &str) -> FitResult<()> {
    let lost = |path: &Path| {
        let cause =
            format!("is no report of before, and would be lost: {what} goes to another folder");
        Err(FitError::file(path, cause))
    };
    let numbers = page.with_file_name("report.json");
    match std::fs::read(page) {
        Ok(bytes) if is_ours(&decoded(&bytes)) => Ok(()),
        Ok(_) => lost(page),
        Err(e) if e.kind() != std::io::ErrorKind::NotFound => Err(FitError::unread(page, e)),
        Err(_) if numbers.exists() => lost(&numbers),
        Err(_) => Ok(()),
    }
}

/// Writes `index.html` and `report.json` into a folder, and with `short` a page in Markdown with
/// its pictures and the same JSON into that one.
///
/// # Errors
/// When a plot cannot be drawn or a file not be written.
pub fn write(validated: &Validated, folder: &Path, short: Option<&Path>) -> FitResult<()> {
    let sections = sections(validated)?;
    let create = |dir: &Path| std::fs::create_dir_all(dir).map_err(|e| FitError::file(dir, e));
    create(folder)?;
    let json = folder.join("report.json");
    let numbers =
        serde_json::to_vec_pretty(&validated.report).map_err(|e| FitError::file(&json, e))?;
    // The page first, by which the numbers are told to be ours.
    write_atomically(
        &folder.join("index.html"),
        html(&validated.report, &sections).as_bytes(),
    )?;
    write_atomically(&json, &numbers)?;
    let Some(short) = short else {
        return Ok(());
    };
    create(short)?;
    write_atomically(
        &short.join("README.md"),
        markdown(&validated.report, &sections).as_bytes(),
    )?;
    for content in sections.iter().filter(|s| s.short).flat_map(|s| &s.content) {
        match content {
            Content::Plot(name, svg, _) => {
                write_atomically(&short.join(format!("{name}.svg")), svg.as_bytes())?;
            }
            Content::Picture(name, png, _) => {
                write_atomically(&short.join(format!("{name}.png")), png)?;
            }
            Content::Text(_) | Content::Table(..) => {}
        }
    }
    write_atomically(&short.join("report.json"), &numbers)
}

fn sections(validated: &Validated) -> FitResult<Vec<Section>> {
    let report = &validated.report;
    Ok(vec![
        population(report)?,
        variance(report)?,
        held_out(validated)?,
        curves(report)?,
        bases(report)?,
        random_faces(validated)?,
        eigenmeshes(validated)?,
        borders(report),
        normality(report)?,
    ])
}

fn population(report: &Report) -> FitResult<Section> {
    let mut content = vec![Content::Text(format!(
        "{} {}",
        report.about.population, report.about.caveat
    ))];
    if !report.persons.are_single() {
        content.push(Content::Text(format!(
            "They are {}. Whoever has several is held out with all of them and counts once in all means over faces and \
             their intervals; what is learned from is the mean of a person's scans.",
            report.persons.said("faces")
        )));
    }
    match &report.labels {
        None => content.push(Content::Text(
            "The faces carry no labels: nothing is known of their sex, age or origin.".into(),
        )),
        Some(labels) => {
            let axes = |title| Axes {
                title,
                x: "",
                y: "faces",
                highest: None,
            };
            let named = |names: &[&str], counts: &[usize]| -> Vec<(String, f64)> {
                let pairs = names.iter().zip(counts);
                pairs.map(|(n, &c)| ((*n).to_owned(), c as f64)).collect()
            };
            let sex = named(&["more female", "more male"], &labels.sex);
            let origin = named(&["african", "asian", "caucasian"], &labels.ethnicity);
            let ages: Vec<(String, f64)> = (labels.decades.iter())
                .map(|(decade, &count)| (format!("{decade}+"), count as f64))
                .collect();
            for (name, title, values) in [
                ("sex", "Sex", sex),
                ("age", "Age, years", ages),
                ("ethnicity", "Greatest share of origin", origin),
            ] {
                let plot = plots::bars(&axes(title), &values)?;
                content.push(Content::Plot(
                    name,
                    plot,
                    format!("The population: {title}."),
                ));
            }
        }
    }
    let left = Interval::of(&report.persons.means(&report.alignment));
    let axes = Axes {
        title: "What alignment leaves",
        x: "root mean square distance from the mean, mm",
        y: "faces",
        highest: None,
    };
    content.push(Content::Plot(
        "alignment",
        plots::bars(&axes, &plots::histogram(&report.alignment, 8))?,
        format!(
            "What rigid alignment leaves between each face and the mean: {} mm RMS on average.",
            interval(&left, 2)
        ),
    ));
    content.extend(people(report));
    if report.one_sided {
        content.push(Content::Text(
            "All that follows was learned from the faces without their mirror images, but for the sparse bases.".into(),
        ));
    }
    if let Some(drift) = &report.drift {
        content.push(Content::Text(format!(
            "Registration: on {} faces whose truth is known, a vertex of the face lies {} mm from \
             the spot where it belongs on average, and 95 % of them below {:.2} mm.",
            drift.faces,
            interval(&drift.mean, 2),
            drift.percentile_95
        )));
    }
    Ok(Section {
        title: "The population",
        content,
        short: false,
    })
}

/// The faces that stand out: those far beyond the others, and those that other people tell least of.
fn people(report: &Report) -> [Content; 2] {
    /// So many of the worst are named.
    const WORST: usize = 10;
    let mut worst: Vec<&Person> = report.people.iter().collect();
    worst.sort_by(|a, b| {
        let far = |person: &Person| person.far.unwrap_or(0.0);
        far(b)
            .total_cmp(&far(a))
            .then(b.held_out.total_cmp(&a.held_out))
    });
    let rows = worst.iter().take(WORST).map(|person| {
        vec![
            person.name.clone(),
            format!("{:.2}", person.face.alignment),
            format!("{:.1}", person.face.size),
            format!("{:.3}", person.held_out),
            person.far.map_or(String::new(), |far| format!("{far:.1}")),
        ]
    });
    let head = [
        "face",
        "distance from the mean, mm RMS",
        "size, mm RMS",
        "held out at 95 %, mm RMS",
        "robust standard deviations",
    ];
    [
        Content::Text(format!(
            "The faces that are to be looked at first: those far beyond the others in distance from the mean or in size, \
             in robust standard deviations, and then those whose features come back worst when they are held out. {} of \
             {} are far beyond the others.",
            report.people.iter().filter(|p| p.far.is_some()).count(),
            report.people.len()
        )),
        Content::Table(head.map(Into::into).to_vec(), rows.collect()),
    ]
}

fn variance(report: &Report) -> FitResult<Section> {
    let head = ["part".to_owned()]
        .into_iter()
        .chain(COUNTED.map(|tau| format!("{:.0} %", 100.0 * tau)))
        .collect();
    let rows = report
        .modes
        .iter()
        .map(|part| {
            let counts = part.counts.iter().map(ToString::to_string);
            [part.name.clone()].into_iter().chain(counts).collect()
        })
        .collect();
    let lines: Vec<Line> = (report.modes.iter().enumerate())
        .map(|(i, part)| Line {
            name: part.name.clone(),
            colour: i,
            broken: part.name == "whole face",
            points: (part.cumulative.iter().take(60).enumerate())
                .map(|(k, &c)| ((k + 1) as f64, 100.0 * c))
                .collect(),
        })
        .collect();
    let axes = Axes {
        title: "Compactness",
        x: "modes",
        y: "variance kept, %",
        highest: Some(100.0),
    };
    let model = report
        .blocks
        .iter()
        .map(|b| {
            vec![
                b.name.clone(),
                b.modes.to_string(),
                format!("{:.1} %", 100.0 * b.variance),
                format!("{:.0} %", 100.0 * b.kept_by_smoothing),
            ]
        })
        .collect();
    let total: usize = report.blocks.iter().map(|b| b.modes).sum();
    Ok(Section {
        title: "How many modes",
        content: vec![
            Content::Text(
                "The fewest modes of each region, and of whole faces, that keep a part of the \
                 variance (region morphing, Table 1)."
                    .into(),
            ),
            Content::Table(head, rows),
            Content::Plot(
                "compactness",
                plots::lines(&axes, &lines)?,
                "The part of the variance that the first modes keep (Fig. 6).".into(),
            ),
            Content::Text(format!(
                "The blocks of the model at 95 %: {total} coefficients in a file of {} bytes. The \
                 head block holds what the features leave over. Smoothing towards the borders keeps \
                 part of a feature's motion. Rounding for the file moves the vertices of random \
                 faces by {:.1} micrometres RMS.",
                report.rounding.bytes,
                1000.0 * report.rounding.rms
            )),
            Content::Table(
                [
                    "block",
                    "modes",
                    "variance kept",
                    "motion kept by smoothing",
                ]
                .map(Into::into)
                .to_vec(),
                model,
            ),
        ],
        short: true,
    })
}

fn held_out(validated: &Validated) -> FitResult<Section> {
    let report = &validated.report;
    let mut content = vec![Content::Text(format!(
        "Faces that the model has not learned from, given back by least squares over the skin. {} \
         in {} parts, each held out once; means over the {} with 95 % confidence \
         intervals, in mm, and in percent of the diameter of the head's bounding box. On the right \
         a PCA of whole faces with as many coefficients.",
        report.persons.said("faces"),
        report.folds,
        who(report)
    ))];
    for part in &report.held_out {
        content.extend(table_of(part));
    }
    let who = who(report);
    let (drawn, of_drawn, as_in_paper) = match validated.pairs.len() {
        PAPER => (
            format!("Ten {who}"),
            "ten".into(),
            ", as in the paper (Table 2)",
        ),
        1 => ("One face".into(), "one".into(), ""),
        count => (format!("{count} {who}"), count.to_string(), ""),
    };
    content.push(Content::Text(format!(
        "{drawn} drawn at random and held out together{as_in_paper}:"
    )));
    for part in &report.ten_held_out {
        content.extend(table_of(part));
    }
    content.push(Content::Picture(
        "reconstructions",
        pictures::reconstructions(validated)?.png()?,
        format!(
            "Held-out faces at 95 %: the best, the middle and the worst of {of_drawn}. From the left: input \
             and output from the front, input and output from the side, distance (Fig. 11)."
        ),
    ));
    Ok(Section {
        title: "Held-out faces",
        content,
        short: true,
    })
}

/// What means are over, in words.
fn who(report: &Report) -> &'static str {
    match report.persons.are_single() {
        true => "faces",
        false => "people",
    }
}

fn table_of(part: &HeldOut) -> [Content; 4] {
    let head = [
        "area",
        "max, mm",
        "mean, mm",
        "RMS, mm",
        "max, %",
        "mean, %",
        "RMS, %",
        "whole-face PCA: RMS, mm",
    ];
    let row = |own: &AreaErrors, whole: &AreaErrors| {
        vec![
            own.area.clone(),
            interval(&own.max, 2),
            interval(&own.mean, 3),
            interval(&own.rms, 3),
            format!("{:.2}", own.max_percent),
            format!("{:.3}", own.mean_percent),
            format!("{:.3}", own.rms_percent),
            interval(&whole.rms, 3),
        ]
    };
    [
        Content::Text(format!(
            "tau = {:.0} %, {:.0} coefficients:",
            100.0 * part.tau,
            part.coefficients
        )),
        Content::Table(
            head.map(Into::into).to_vec(),
            part.regions
                .iter()
                .zip(&part.whole_face)
                .map(|(o, w)| row(o, w))
                .collect(),
        ),
        Content::Text(
            "The shape of each feature by itself, aligned on itself on a head of average \
             proportions: by its own modes, and by as many modes of whole faces."
                .into(),
        ),
        Content::Table(
            ["feature", "own modes: RMS, mm", "whole-face PCA: RMS, mm"]
                .map(Into::into)
                .to_vec(),
            (part.shapes.iter())
                .map(|s| {
                    vec![
                        s.feature.clone(),
                        interval(&s.region, 3),
                        interval(&s.whole_face, 3),
                    ]
                })
                .collect(),
        ),
    ]
}

fn curves(report: &Report) -> FitResult<Section> {
    let mut content = Vec::new();
    for split in &report.curves {
        let mut lines = Vec::new();
        for (i, curve) in split.curves.iter().enumerate() {
            let line = |name: &str, broken, value: &dyn Fn(&super::curves::Point) -> f64| Line {
                name: format!("{}, {name}", curve.basis),
                colour: i,
                broken,
                points: (curve.points.iter())
                    .map(|p| (p.coefficients as f64, value(p)))
                    .collect(),
            };
            lines.push(line("test", false, &|p| p.test));
            lines.push(line("training", true, &|p| p.training));
        }
        let title = format!(
            "{} training faces, {} test faces",
            split.training, split.test
        );
        let axes = Axes {
            title: &title,
            x: "coefficients",
            y: "mean error on the features, mm",
            highest: None,
        };
        let name = if split.training < 50 {
            "error-few"
        } else {
            "error-many"
        };
        content.push(Content::Plot(
            name,
            plots::lines(&axes, &lines)?,
            format!(
                "Mean distance on the features' skin against the number of coefficients, learned \
                 from {} faces (semantic reshaping, Figs. 5 and 6).",
                split.training
            ),
        ));
    }
    if content.is_empty() {
        content.push(Content::Text(
            "There are too few faces to learn from some and try others.".into(),
        ));
    }
    Ok(Section {
        title: "Error against the number of coefficients",
        content,
        short: true,
    })
}

fn bases(report: &Report) -> FitResult<Section> {
    let mut content = Vec::new();
    for set in &report.bases {
        let lines: Vec<Line> = (set.errors.iter().enumerate())
            .map(|(i, own)| Line {
                name: own.basis.clone(),
                colour: i,
                broken: false,
                points: (set.components.iter().zip(&own.test))
                    .map(|(&k, &e)| (k as f64, e))
                    .collect(),
            })
            .collect();
        let title = format!(
            "{} training faces, {} test faces, {} splits",
            set.training, set.test, set.splits
        );
        let axes = Axes {
            title: &title,
            x: "components",
            y: "mean error on the face, mm",
            highest: None,
        };
        let few = set.training < 50;
        content.push(Content::Plot(
            if few { "bases-few" } else { "bases-many" },
            plots::lines(&axes, &lines)?,
            format!(
                "Sparse bases beside principal components, on faces that none has seen, learned \
                 from {} (semantic reshaping, Figs. 5 and 6).",
                set.training
            ),
        ));
        let counts = set.components.iter().map(ToString::to_string);
        let rows = (set.errors.iter())
            .map(|own| {
                let cells = (own.test.iter().zip(&own.range))
                    .map(|(e, [least, most])| format!("{e:.3} ({least:.3} to {most:.3})"));
                [own.basis.clone()].into_iter().chain(cells).collect()
            })
            .collect();
        content.push(Content::Table(
            ["basis, mm".to_owned()].into_iter().chain(counts).collect(),
            rows,
        ));
        let verdict = set.verdict();
        let crossover = match verdict.below_from {
            Some(k) => format!(
                "From {k} components on the basis of regions, which learned from the same, is below that, with {} by \
                 {:.0} %.",
                set.components.last().unwrap_or(&0),
                100.0 * (1.0 - verdict.at_most)
            ),
            None => "The basis of regions stays above that.".into(),
        };
        let beside: Vec<String> = (verdict.beside.iter())
            .map(|(k, times)| format!("{times:.2} with {k}"))
            .collect();
        content.push(Content::Text(format!(
            "The best that PCA of whole faces and their mirror images reaches is {:.3} mm (of the faces alone {:.3}). \
             {crossover} As a multiple of that PCA's error with as many components it is {}.",
            verdict.best,
            verdict.best_alone,
            beside.join(", ")
        )));
    }
    if content.is_empty() {
        content.push(Content::Text(
            format!(
                "Sparse bases were not compared: ask with --splits, and give {} faces or more, each of another person.",
                TRAINING[0] + FEWEST_TEST
            ),
        ));
    } else {
        let about = &report.about;
        let linear = about.licences.iter().any(|l| l.source == simulate::SOURCE);
        if linear {
            content.push(Content::Text(
                "People who are sampled from a linear model of 100 dimensions, as these are, lie in a space that the \
                 principal components of 100 of them span nearly whole. No local basis has less error \
                 there, and the paper's Fig. 6, of scanned people, cannot hold."
                    .into(),
            ));
        }
        content.push(Content::Text(
            "With 25 faces PCA ends at 24 components, and with their mirror images at 49; local components, of which \
             one person's nose goes with another's chin, go on."
                .into(),
        ));
    }
    Ok(Section {
        title: "Sparse bases",
        content,
        short: true,
    })
}

fn random_faces(validated: &Validated) -> FitResult<Section> {
    let specificity = &validated.report.specificity;
    Ok(Section {
        title: "Random faces",
        content: vec![
            Content::Picture(
                "gallery",
                pictures::gallery(&validated.model)?.png()?,
                "Random faces of the model (Fig. 9).".into(),
            ),
            Content::Text(format!(
                "Specificity: the skin of a random face is {} mm from the nearest person of the \
                 population on average; of a PCA of whole faces with as many coefficients, {} mm; \
                 people are {} mm from the nearest other.",
                interval(&specificity.regions, 2),
                interval(&specificity.whole_face, 2),
                interval(&specificity.population, 2)
            )),
            Content::Picture(
                "morph",
                pictures::morph(&validated.model)?.png()?,
                "The first mode of eyes, nose, mouth, chin and forehead from one extreme to the \
                 other (Fig. 10)."
                    .into(),
            ),
        ],
        short: true,
    })
}

fn eigenmeshes(validated: &Validated) -> FitResult<Section> {
    const NAMES: [&str; 6] = [
        "modes-eyes",
        "modes-nose",
        "modes-mouth",
        "modes-chin",
        "modes-forehead",
        "modes-head",
    ];
    let mut content = Vec::new();
    for (block, name) in NAMES.into_iter().enumerate() {
        let what = &validated.model.parts().blocks[block].name;
        content.push(Content::Picture(
            name,
            pictures::eigenmeshes(&validated.model, block)?.png()?,
            format!(
                "The first modes of the {what} at -3, -1, 1 and 3 sigma, in the colour of how far \
                 they move (Fig. 7)."
            ),
        ));
    }
    Ok(Section {
        title: "Eigenmeshes",
        content,
        short: false,
    })
}

fn borders(report: &Report) -> Section {
    let head = [
        "feature",
        "within, mm",
        "modes at 2 sigma, degrees",
        "whole-face modes",
        "random faces",
        "whole-face random faces",
        "largest ratio",
    ];
    let rows = report
        .seams
        .iter()
        .map(|seam| {
            vec![
                seam.feature.clone(),
                format!("{:.0}", seam.width),
                format!("{:.1}", seam.modes),
                format!("{:.1}", seam.whole_modes),
                format!("{:.1}", seam.random),
                format!("{:.1}", seam.whole_random),
                format!("{:.2}", seam.ratio()),
            ]
        })
        .collect();
    Section {
        title: "Seams",
        content: vec![
            Content::Text(
                "The largest change of the angle between two triangles near a feature's border, \
                 beside the same for a PCA of whole faces, which has no borders."
                    .into(),
            ),
            Content::Table(head.map(Into::into).to_vec(), rows),
        ],
        short: true,
    }
}

fn normality(report: &Report) -> FitResult<Section> {
    let normality = &report.normality;
    let shown: Vec<_> = (normality.coefficients.iter())
        .filter(|d| {
            d.control.ends_with(" 1") || d.control.ends_with(" 2") || d.control.ends_with(" 3")
        })
        .collect();
    let farthest = normality
        .coefficients
        .iter()
        .max_by(|a, b| a.distance.total_cmp(&b.distance));
    let mean = normality
        .coefficients
        .iter()
        .map(|d| d.distance)
        .sum::<f64>()
        / normality.coefficients.len().max(1) as f64;
    let farthest = farthest.map_or(String::new(), |d| {
        format!(" The farthest is {} with {:.3}.", d.control, d.distance)
    });
    Ok(Section {
        title: "Is the population Gaussian?",
        content: vec![
            Content::Text(format!(
                "A slider is the part of the population that has less. Were the coefficients \
                 normally distributed, that would be the normal distribution function; the largest \
                 difference between the two (Kolmogorov and Smirnov's distance) is {mean:.3} on \
                 average.{farthest} Of {} coefficients {} exceed {:.3}, which five in a hundred \
                 normal samples of {} faces do.",
                normality.coefficients.len(),
                normality.exceeding,
                normality.critical,
                normality.faces
            )),
            Content::Plot(
                "quantiles",
                plots::quantiles(&shown, 6)?,
                "Quantiles of the first coefficients of each block against normal ones, with that \
                 distance."
                    .into(),
            ),
        ],
        short: false,
    })
}

fn interval(of: &Interval, digits: usize) -> String {
    if !of.low.is_finite() {
        return format!("{:.digits$} (one face)", of.mean);
    }
    format!(
        "{:.digits$} ({:.digits$} to {:.digits$})",
        of.mean, of.low, of.high
    )
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
        .replace('"', "&quot;")
}

const STYLE: &str = "body{font:16px/1.5 system-ui,sans-serif;max-width:72rem;margin:2rem auto;\
padding:0 1rem;color:#222;background:#fafafa}h1{font-size:1.6rem}h2{margin-top:2.5rem;\
border-bottom:1px solid #ccc}table{border-collapse:collapse;font-size:.85rem;\
font-variant-numeric:tabular-nums}.wide{overflow-x:auto}td,th{padding:.2rem .7rem;\
text-align:right;border-bottom:1px solid #ddd}td:first-child,th:first-child{text-align:left}\
figure{margin:1rem 0}img,svg{max-width:100%;height:auto}figcaption{color:#555;font-size:.9rem}";

fn html(report: &Report, sections: &[Section]) -> String {
    let title = escaped(&report.about.title);
    let mut page = format!(
        "<!doctype html><html lang=\"en\"><meta charset=\"utf-8\">\
         <meta name=\"viewport\" content=\"width=device-width\">{GENERATOR}<title>{title}</title>\
         <style>{STYLE}</style><h1>{title}: {} faces of {} vertices</h1>\n",
        report.faces, report.vertices
    );
    for section in sections {
        let _ = writeln!(page, "<h2>{}</h2>", escaped(section.title));
        for content in &section.content {
            match content {
                Content::Text(text) => {
                    let _ = writeln!(page, "<p>{}</p>", escaped(text));
                }
                Content::Table(head, rows) => {
                    let cells = |tag: &str, row: &[String]| -> String {
                        let cell = |c: &String| format!("<{tag}>{}</{tag}>", escaped(c));
                        row.iter().map(cell).collect()
                    };
                    let _ = write!(
                        page,
                        "<div class=\"wide\"><table><tr>{}</tr>",
                        cells("th", head)
                    );
                    for row in rows {
                        let _ = write!(page, "<tr>{}</tr>", cells("td", row));
                    }
                    page += "</table></div>\n";
                }
                Content::Plot(name, svg, caption) => {
                    let caption = escaped(caption);
                    let _ = writeln!(
                        page,
                        "<figure id=\"{name}\">{svg}<figcaption>{caption}</figcaption></figure>"
                    );
                }
                Content::Picture(name, png, caption) => {
                    let (data, caption) = (Base64::encode_string(png), escaped(caption));
                    let _ = writeln!(
                        page,
                        "<figure id=\"{name}\"><img alt=\"{caption}\" \
                         src=\"data:image/png;base64,{data}\"><figcaption>{caption}</figcaption>\
                         </figure>"
                    );
                }
            }
        }
    }
    page + "</html>\n"
}

fn markdown(report: &Report, sections: &[Section]) -> String {
    let mut page = format!(
        "# {}: {} faces of {} vertices\n\n{WRITTEN}; the numbers are in `report.json`, too.\n",
        report.about.title, report.faces, report.vertices
    );
    for section in sections.iter().filter(|s| s.short) {
        let _ = writeln!(page, "\n## {}", section.title);
        for content in &section.content {
            match content {
                Content::Text(text) => {
                    let _ = writeln!(page, "\n{text}");
                }
                Content::Table(head, rows) => {
                    let line = |row: &[String]| format!("| {} |\n", row.join(" | "));
                    let rule: Vec<String> = (0..head.len())
                        .map(|i| if i == 0 { "---" } else { "---:" }.to_owned())
                        .collect();
                    page += "\n";
                    page += &line(head);
                    page += &line(&rule);
                    rows.iter().for_each(|row| page += &line(row));
                }
                Content::Plot(name, _, caption) => {
                    let _ = writeln!(page, "\n![{caption}]({name}.svg)\n\n{caption}");
                }
                Content::Picture(name, _, caption) => {
                    let _ = writeln!(page, "\n![{caption}]({name}.png)\n\n{caption}");
                }
            }
        }
    }
    page
}

impl Image {
    fn png(&self) -> FitResult<Vec<u8>> {
        crate::fit::picture::render::png([self.width, self.height], &self.pixels)
            .map_err(|e| FitError::Input(format!("a picture could not be packed: {e}")))
    }
}
