//! The report on a population: whole on a small one, clear about a bad one, and the numbers that
//! the documentation quotes, found again.

use std::path::Path;
use std::sync::OnceLock;

use glam::{DVec3, Vec3};
use phiz::FaceModel;
use phiz::fit::head::template::Template;
use phiz::fit::learn::labels::Told;
use phiz::fit::learn::persons::Persons;
use phiz::fit::mesh::align::{Rigid, vertex_areas};
use phiz::fit::register::Settings as Registration;
use phiz::fit::sparse::compare::BASES;
use phiz::fit::statistics::subspace::Subspace;
use phiz::fit::truth::population::{self, Labels};
use phiz::fit::truth::simulate::{self, Settings, Simulator};
use phiz::fit::validate::areas::{Areas, FEATURES};
use phiz::fit::validate::held_out::Interval;
use phiz::fit::validate::{Population, Report, STEPS, bases, page, validate};
use rayon::prelude::*;

use crate::{base_mesh, heads, ict};

/// A template, faces of it, and who they are.
type Labelled = (&'static Template, Vec<Vec<Vec3>>, Vec<Labels>);

/// A population of a dozen faces, with its labels.
fn dozen() -> Option<&'static Labelled> {
    static DOZEN: OnceLock<Option<Labelled>> = OnceLock::new();
    DOZEN
        .get_or_init(|| {
            let folder = base_mesh::folder()?;
            let template = heads::plain()?;
            let people = population::sample(template, &folder, 12, 3).unwrap();
            let narrow = |face: &Vec<DVec3>| face.iter().map(|p| p.as_vec3()).collect();
            let faces = people.faces.iter().map(narrow).collect();
            Some((template, faces, people.labels))
        })
        .as_ref()
}

fn report_of(template: &Template, faces: Vec<Vec<Vec3>>) -> Result<Report, String> {
    let population = Population {
        template,
        names: Vec::new(),
        both_sides: true,
        persons: Persons::each(faces.len()),
        faces,
        labels: Vec::new(),
        about: population::about(),
        drift: None,
    };
    match validate(population, |_| ()) {
        Ok(validated) => Ok(validated.report),
        Err(error) => Err(error.to_string()),
    }
}

#[test]
fn a_small_population_gets_a_whole_report() {
    let Some((template, faces, labels)) = dozen() else {
        return;
    };
    let names = (1..=12).map(|i| format!("person {i}"));
    let population = Population {
        template,
        names: names.collect(),
        both_sides: true,
        faces: faces.clone(),
        persons: Persons::each(12),
        labels: labels.clone(),
        about: population::about(),
        drift: None,
    };
    let mut steps = 0;
    let mut validated = validate(population, |_| steps += 1).unwrap();
    assert_eq!(steps, STEPS);
    let report = &validated.report;
    let labelled = report.labels.as_ref().unwrap();
    assert_eq!(labelled.sex.iter().sum::<usize>(), 12);
    assert_eq!(labelled.decades.values().sum::<usize>(), 12);
    for part in report.held_out.iter().chain(&report.ten_held_out) {
        for area in part.regions.iter().chain(&part.whole_face) {
            let rms = area.rms;
            assert!(rms.low <= rms.mean && rms.mean <= rms.high && area.max.mean >= rms.mean);
            // Some ten faces say little of another: it comes back by millimetres, not exactly.
            assert!((0.01..10.0).contains(&rms.mean), "{}: {rms:?}", area.area);
        }
    }
    for part in &report.modes {
        assert!(part.counts.is_sorted() && part.cumulative.is_sorted());
        assert!((part.cumulative.last().unwrap() - 1.0).abs() < 1e-9);
    }

    // Each face is told of by its name.
    assert_eq!(report.people[3].name, "person 4");
    for (person, alignment) in report.people.iter().zip(&report.alignment) {
        assert_eq!(person.face.alignment, *alignment);
        // Root mean square over a head some 200 mm wide and 250 high.
        assert!((50.0..150.0).contains(&person.face.size));
        assert!(person.held_out > 0.0, "{person:?}");
    }
    let mean = report.people.iter().map(|p| p.held_out).sum::<f64>() / 12.0;
    let all = report.held_out[0].regions.last().unwrap();
    // A mean of the same numbers, in another order.
    assert!((mean - all.rms.mean).abs() < 1e-12);

    // As if bases had been compared, of these people, who are of no linear model of a hundred dimensions.
    let errors = BASES.iter().map(|basis| bases::Errors {
        basis: (*basis).into(),
        training: vec![1.0],
        test: vec![1.0],
        range: vec![[1.0, 1.0]],
    });
    validated.report.bases = vec![bases::Bases {
        training: 25,
        test: 100,
        splits: 1,
        components: vec![5],
        errors: errors.collect(),
    }];
    let folder = tempfile::tempdir().unwrap();
    let (out, short) = (folder.path().join("report"), folder.path().join("short"));
    page::write(&validated, &out, Some(&short)).unwrap();
    page::check_report(&out).unwrap();
    page::check_short(&short).unwrap();
    let text = std::fs::read_to_string(short.join("README.md")).unwrap();
    assert!(!text.contains("linear model"), "{text}");
    // Half of a dozen was held out, and no ten of them.
    assert!(text.contains("6 faces drawn at random and held out together:"));
    assert!(text.contains("the worst of 6."));
    assert!(!text.contains("Ten faces") && !text.contains("of ten"));
    validated.report.about = simulate::about();
    page::write(&validated, &out, Some(&short)).unwrap();
    let html = std::fs::read_to_string(out.join("index.html")).unwrap();
    // Self-contained: nothing is fetched.
    assert!(!html.contains("src=\"http") && !html.contains("href="));
    let pictures = html.matches("data:image/png;base64,").count();
    let plots = html.matches("<svg").count();
    assert!(
        pictures >= 9 && plots >= 5,
        "{pictures} pictures, {plots} plots"
    );
    let json = std::fs::read(out.join("report.json")).unwrap();
    let json: serde_json::Value = serde_json::from_slice(&json).unwrap();
    assert_eq!(json["faces"], 12);
    assert_eq!(json["people"][3]["name"], "person 4");
    assert!(html.contains("person 4"));
    let text = std::fs::read_to_string(short.join("README.md")).unwrap();
    assert!(text.contains("a linear model of 100 dimensions, as these are"));
    for picture in text.split("](").skip(1) {
        let name = picture.split(')').next().unwrap();
        assert!(short.join(name).is_file(), "{name}");
    }
}

/// Whoever was scanned twice is held out with both scans, and counts once.
#[test]
fn a_person_is_not_held_out_from_a_scan_of_the_same() {
    let Some((template, faces, _)) = dozen() else {
        return;
    };
    // Five people; the second scan of each is a tenth of the way to somebody else.
    let again = |face: &Vec<Vec3>| -> Vec<Vec3> {
        let other = &faces[11];
        face.iter()
            .zip(other)
            .map(|(p, q)| p.lerp(*q, 0.1))
            .collect()
    };
    let scans: Vec<Vec<Vec3>> = (faces[..5].iter().cloned())
        .chain(faces[..5].iter().map(again))
        .collect();
    let names: Vec<String> = (0..10).map(|i| format!("{i}")).collect();
    let folder = tempfile::tempdir().unwrap();
    let told = (0..10).map(|i| format!("\"{i}\": {{\"person\": {}}}", i % 5));
    let told = format!("{{{}}}", told.collect::<Vec<_>>().join(", "));
    std::fs::write(folder.path().join("labels.json"), told).unwrap();
    let told = Told::beside(folder.path()).unwrap().unwrap();
    let validated = |persons: Persons, scans: &[Vec<Vec3>]| {
        let population = Population {
            template,
            names: names[..scans.len()].to_vec(),
            both_sides: true,
            persons,
            faces: scans.to_vec(),
            labels: Vec::new(),
            about: population::about(),
            drift: None,
        };
        validate(population, |_| ())
    };
    let persons = Persons::told(&names, &told);
    let found = validated(persons.clone(), &scans).unwrap();
    let apart = &found.report;
    let mixed = validated(Persons::each(10), &scans).unwrap().report;
    let error = |report: &Report| report.held_out[0].regions.last().unwrap().rms;
    // With the other scan among those learned from, what is left of a face is little more than what the model leaves out.
    assert!(
        error(apart).mean > 2.0 * error(&mixed).mean,
        "{:?} {:?}",
        error(apart),
        error(&mixed)
    );
    // Half as wide an interval would be of ten people.
    let held_out: Vec<f64> = apart.people.iter().map(|p| p.held_out).collect();
    let of_people = Interval::of(&persons.means(&held_out));
    // Means of the same numbers, in another order.
    assert!((of_people.high - error(apart).high).abs() < 1e-9);
    assert!((of_people.mean - error(apart).mean).abs() < 1e-9);
    // The nearest other person is farther than the other scan.
    let nearest = |report: &Report| report.specificity.population.mean;
    assert!(nearest(apart) > 2.0 * nearest(&mixed));
    assert_eq!((apart.folds, apart.normality.faces), (5, 5));

    let (out, short) = (folder.path().join("report"), folder.path().join("short"));
    page::write(&found, &out, Some(&short)).unwrap();
    let text = std::fs::read_to_string(short.join("README.md")).unwrap();
    assert!(text.contains(
        "10 scans of 5 people in 5 parts, each held out once; means over the people with"
    ));
    assert!(text.contains("2 people drawn at random and held out together:"));
    let json = std::fs::read(out.join("report.json")).unwrap();
    let json: serde_json::Value = serde_json::from_slice(&json).unwrap();
    assert_eq!(json["persons"][6], 1);
    let json = serde_json::to_value(&mixed).unwrap();
    assert!(json.get("persons").is_none());

    // People are too few, and not scans; and other faces' persons are none of these.
    let some: Vec<usize> = vec![0, 1, 2, 5, 6, 7];
    let few: Vec<Vec<Vec3>> = some.iter().map(|&i| scans[i].clone()).collect();
    let refused = |persons: Persons| {
        let error = validated(persons, &few).map(|_| ());
        error.expect_err("refused").to_string()
    };
    let said = refused(persons.some(&some));
    assert!(
        said.starts_with("6 scans of 3 people are too few"),
        "{said}"
    );
    let said = refused(persons);
    assert!(
        said.contains("those of 10 faces, and not of these 6"),
        "{said}"
    );
}

#[test]
fn a_bad_population_is_said_to_be_one() {
    let Some((template, faces, _)) = dozen() else {
        return;
    };
    let few = report_of(template, faces[..2].to_vec()).unwrap_err();
    assert!(
        few.contains("2 faces are too few") && few.contains("4 is the least"),
        "{few}"
    );
    let three = report_of(template, faces[..3].to_vec()).unwrap_err();
    assert!(three.contains("4 is the least"), "{three}");
    let least = report_of(template, faces[..4].to_vec()).unwrap();
    assert_eq!(least.folds, 4);
    let of_one = least.ten_held_out[0].regions[0].rms;
    assert!(of_one.mean > 0.0 && of_one.high == f64::INFINITY);
    let mut other = faces.clone();
    other[5].pop();
    let other = report_of(template, other).unwrap_err();
    assert!(
        other.contains("face 5 has") && other.contains("the template"),
        "{other}"
    );
    let same = report_of(template, vec![faces[0].clone(); 5]).unwrap_err();
    assert!(
        same.contains("eyes") && same.contains("do not vary"),
        "{same}"
    );
}

const DOCS: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/www/docs/validation");

/// The committed numbers.
fn committed() -> serde_json::Value {
    let path = Path::new(DOCS).join("report.json");
    serde_json::from_slice(&std::fs::read(path).unwrap()).unwrap()
}

/// The root mean square error over all features of held-out faces at tau = 95 %.
fn committed_error() -> f64 {
    let report = committed();
    let areas = report["held_out"][0]["regions"].as_array().unwrap();
    let all = areas.iter().find(|a| a["area"] == FEATURES).unwrap();
    all["rms"]["mean"].as_f64().unwrap()
}

/// What the project's README says of the model's size and error is what the report says.
#[test]
fn the_readme_quotes_the_report() {
    let readme = concat!(env!("CARGO_MANIFEST_DIR"), "/README.md");
    let readme = std::fs::read_to_string(readme).unwrap();
    let words: Vec<&str> = readme.split_whitespace().collect();
    let words = words.join(" ");
    let report = committed();
    let count = |block: &serde_json::Value| block["modes"].as_u64().unwrap();
    let modes: u64 = report["blocks"].as_array().unwrap().iter().map(count).sum();
    let rounding = 1000.0 * report["rounding"]["rms"].as_f64().unwrap();
    // Learned from few, the basis of regions with most components, beside the best of each PCA.
    let few = report["bases"][0]["errors"].as_array().unwrap();
    let errors = |basis: &str| -> Vec<f64> {
        let own = few.iter().find(|own| own["basis"] == basis).unwrap();
        let test = own["test"].as_array().unwrap();
        test.iter().map(|e| e.as_f64().unwrap()).collect()
    };
    let sparse = *errors("regions").last().unwrap();
    let less_than = |basis: &str| {
        let best = errors(basis).into_iter().fold(f64::INFINITY, f64::min);
        100.0 * (1.0 - sparse / best)
    };
    for said in [
        format!("{} adults", report["faces"]),
        format!("{modes} *modes*"),
        format!("{:.2} mm", committed_error()),
        format!("{rounding:.0} micrometres RMS"),
        format!("{:.0} % less error", less_than("PCA, mirrored")),
        format!("({:.0} % less than", less_than("PCA")),
    ] {
        assert!(words.contains(&said), "README does not say {said:?}");
    }
}

/// Two of the report's numbers from the committed model itself: its coefficients, and how far it is
/// from people whom it has never seen.
#[test]
fn the_committed_model_has_the_reported_error() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/www/public/model.phiz");
    let model = FaceModel::parse(&std::fs::read(path).unwrap()).unwrap();
    let report = committed();
    for (block, reported) in model
        .parts()
        .blocks
        .iter()
        .zip(report["blocks"].as_array().unwrap())
    {
        assert_eq!(block.name, reported["name"].as_str().unwrap());
        assert_eq!(
            block.sigmas.len() as u64,
            reported["modes"].as_u64().unwrap()
        );
    }
    let (Some(ict), Some(registrar), Some(template)) =
        (ict::ict(), heads::registrar(), heads::template())
    else {
        return;
    };
    let simulator = Simulator::new(ict);
    let ibug: Vec<usize> = (0..68)
        .map(|i| {
            let name = format!("ibug_{i:02}");
            template
                .landmarks
                .iter()
                .position(|l| l.name == name)
                .unwrap()
        })
        .collect();
    // The model learned from the seeds from 1 on.
    let faces: Vec<Vec<DVec3>> = (7000..7024)
        .into_par_iter()
        .map(|seed| {
            let settings = Settings {
                noise: 0.2,
                jitter: 0.5,
                holes: true,
            };
            let person = simulator.scan(seed, &settings);
            let points: Vec<_> = ibug.iter().copied().zip(person.landmarks).collect();
            let registered = registrar.register(&person.scan, &points, &Registration::default());
            registered.unwrap().positions
        })
        .collect();

    let wide = |points: &[Vec3]| points.iter().map(|p| p.as_dvec3()).collect::<Vec<_>>();
    let mean = wide(&model.parts().mean);
    let areas = Areas::new(template).unwrap();
    let weights = vertex_areas(&template.positions, &template.triangles());
    let modes: Vec<Vec<DVec3>> = (0..model.parts().population())
        .map(|k| {
            let mut c = vec![0.0; model.parts().coefficients()];
            c[k] = 1.0;
            let mut face = model.face();
            face.set_coefficients(&c).unwrap();
            wide(face.positions())
                .iter()
                .zip(&mean)
                .map(|(p, m)| *p - *m)
                .collect()
        })
        .collect();
    let subspace = Subspace::new(&modes, &areas.skin).unwrap();
    let fields: Vec<Vec<DVec3>> = faces
        .iter()
        .map(|face| {
            let motion = Rigid::fit(face, &mean, &areas.skin, &weights);
            face.iter()
                .zip(&mean)
                .map(|(&p, m)| motion.apply(p) - *m)
                .collect()
        })
        .collect();
    let back = subspace.fields(&subspace.coefficients(&fields));
    let errors: Vec<f64> = (back.iter().zip(&fields))
        .map(|(back, field)| areas.errors(field, back).last().unwrap().rms)
        .collect();
    let found = errors.iter().sum::<f64>() / errors.len() as f64;
    let reported = committed_error();
    println!("{found:.3} mm, reported {reported:.3} mm; {errors:.3?}");
    // Faces differ by 0.05 mm in this; three standard errors of so many. The model learned from 300 faces and those of
    // the report from 240, and is nearer; by no more than three errors of eight faces and a fiftieth.
    let spread = |faces: usize| 3.0 * 0.05 / (faces as f64).sqrt();
    assert!(found < reported + spread(errors.len()));
    assert!(reported - found < spread(8) + reported / 50.0);
}
