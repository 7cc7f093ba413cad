//! Measuring registrations: what is right is zero, what is wrong is as wrong as it was made.

use std::sync::OnceLock;

use glam::{DMat3, DVec3};
use phiz::fit::FitError;
use phiz::fit::evaluate::{Evaluator, evaluate};
use phiz::fit::head::expression::{Expressions, Performer};
use phiz::fit::head::template::Template;
use phiz::fit::mesh::align::Rigid;
use phiz::fit::mesh::surface::Surface;
use phiz::fit::mesh::surface::normals;
use phiz::fit::register::warp::{Kernel, Warp};
use phiz::fit::truth::ict::Ict;
use phiz::fit::truth::simulate::{Settings, Simulated, Simulator};

use crate::{base_mesh, heads, ict};

const CLEAN: Settings = Settings {
    noise: 0.0,
    jitter: 0.0,
    holes: false,
};

struct Given {
    ict: &'static Ict,
    template: &'static Template,
    /// The template on ICT's mean head: warped by the landmarks, then set on the surface. Not a
    /// good registration, but every vertex has a spot.
    reference: Vec<DVec3>,
    expressions: Expressions,
}

fn given() -> Option<&'static Given> {
    static GIVEN: OnceLock<Option<Given>> = OnceLock::new();
    GIVEN
        .get_or_init(|| {
            let (ict, folder) = (ict::ict()?, base_mesh::folder()?);
            let template = heads::plain()?;
            let at = |i: usize| {
                let name = format!("ibug_{i:02}");
                let place = template.landmarks.iter().position(|l| l.name == name);
                template.landmark(place.expect("is there"), &template.positions)
            };
            let from: Vec<DVec3> = (0..68).map(at).collect();
            let to: Vec<DVec3> = ict.landmarks.map(|v| ict.neutral[v as usize]).to_vec();
            let warp = Warp::fit(&from, &to, Kernel::default(), 0.1).expect("fits");
            let mut reference = warp.apply_all(&template.positions);
            let facing = normals(&reference, &template.part_triangles("skin").expect("skin"));
            let mean = Surface::new(&ict.neutral, &ict.triangles);
            for v in template.part_vertices("skin").expect("skin") {
                let v = v as usize;
                let alike = |t: u32| mean.facets[t as usize].dot(facing[v]) > 0.5;
                if let Some(hit) = mean.closest_where(reference[v], 30.0, alike) {
                    reference[v] = hit.point;
                }
            }
            let named: [(&str, &[&str]); 2] = [
                ("jawOpen", &["jawOpen"]),
                ("eyeBlink", &["eyeBlinkLeft", "eyeBlinkRight"]),
            ];
            let expressions = Expressions::read(&named, template, &folder).expect("reads");
            Some(Given {
                ict,
                template,
                reference,
                expressions,
            })
        })
        .as_ref()
}

impl Given {
    fn evaluator(&self) -> Evaluator<'_> {
        let evaluator = Evaluator::new(self.template, &self.reference, self.ict, &self.expressions);
        evaluator.expect("evaluates")
    }

    /// The registration that is right: the reference, with every vertex of the skin on its spot.
    fn truth(&self, evaluator: &Evaluator, person: &Simulated) -> Vec<DVec3> {
        let pose = person.truth.pose;
        let mut face: Vec<DVec3> = self.reference.iter().map(|&p| pose.apply(p)).collect();
        let positions = person.truth.positions(self.ict);
        let spots = evaluator.binding.truth(&positions, self.ict);
        for (&v, spot) in evaluator.binding.vertices.iter().zip(spots) {
            face[v as usize] = spot;
        }
        face
    }
}

#[test]
fn the_face_area_is_most_of_what_lies_in_front() {
    let Some(given) = given() else { return };
    let evaluator = given.evaluator();
    let binding = &evaluator.binding;
    let names = &given.template.topology.region_names;
    let share = |region: &str| {
        let region = names.iter().position(|n| n == region).expect("a region") as u8;
        let inside = |v: &u32| given.template.topology.regions[*v as usize] == region;
        let all = binding.vertices.iter().filter(|v| inside(v)).count();
        let face = binding.vertices.iter().zip(&binding.face);
        face.filter(|(v, face)| inside(v) && **face).count() as f64 / all as f64
    };
    for region in ["left eye", "right eye", "nose", "mouth", "chin", "forehead"] {
        println!("{region}: {:.3} in the face area", share(region));
        assert!(share(region) > 0.8, "{region}: {}", share(region));
    }
    // The skull, the ears and the neck are not; the cheeks are.
    assert!(share("head") < 0.5, "head: {}", share("head"));
}

#[test]
fn the_truth_has_no_drift_in_any_pose_and_a_known_slide_has_its_length() {
    let Some(given) = given() else { return };
    let evaluator = given.evaluator();
    let simulator = Simulator::new(given.ict);
    let mut scatter = Vec::new();
    // Each person has a pose of its own.
    for seed in [8201, 8202] {
        let person = simulator.scan(seed, &CLEAN);
        let truth = given.truth(&evaluator, &person);
        let measured = evaluator.measure(&person, &truth);
        assert!(measured.drift.len() > 4000, "{}", measured.drift.len());
        assert!(measured.drift.iter().all(|&d| d < 1e-9));
        assert!(measured.face_to_skin.iter().all(|&d| d < 1e-9));
        // The scan cuts corners of the skin (`simulate`), and these are where vertices of
        // the one meet edges of the other.
        let mean = measured.head_to_scan.iter().sum::<f64>() / measured.head_to_scan.len() as f64;
        assert!(mean < 0.06, "{mean}");

        let slide = DVec3::new(1.0, 2.0, -2.0);
        let slid: Vec<DVec3> = truth.iter().map(|p| *p + slide).collect();
        let measured = evaluator.measure(&person, &slid);
        assert!(measured.drift.iter().all(|&d| (d - 3.0).abs() < 1e-9));
        assert!(measured.face_to_skin.iter().all(|&d| d < 3.0 + 1e-9));

        // Everybody's vertices on the same wrong spots: that is drift, but no scatter.
        let vertices = &evaluator.binding.vertices;
        let mut shifted = truth.clone();
        for pair in vertices.windows(2) {
            shifted[pair[0] as usize] = truth[pair[1] as usize];
        }
        let measured = evaluator.measure(&person, &shifted);
        assert!(measured.drift.iter().sum::<f64>() / measured.drift.len() as f64 > 1.0);
        scatter.push(measured.spots);
    }
    let apart = scatter[0]
        .iter()
        .zip(&scatter[1])
        .map(|(a, b)| match (a, b) {
            (Some(a), Some(b)) => a.distance(*b),
            _ => f64::INFINITY,
        });
    // Where lips touch, the closest point may be on the other one.
    let far = apart.filter(|&d| d > 1e-6).count();
    assert!(far < scatter[0].len() / 500, "{far}");
}

#[test]
fn a_vertex_pulled_through_its_neighbours_is_a_fold() {
    let Some(given) = given() else { return };
    let evaluator = given.evaluator();
    let simulator = Simulator::new(given.ict);
    let person = simulator.scan(8203, &CLEAN);
    // The template as it is has no folds and no crossings, in any pose and size.
    let pose = person.truth.pose;
    let posed: Vec<DVec3> = given
        .template
        .positions
        .iter()
        .map(|&p| pose.apply(p * 1.1))
        .collect();
    let measured = evaluator.measure(&person, &posed);
    assert_eq!((measured.folds, measured.crossings), (0, 0));

    // The tip of the nose, pulled 15 mm back through the nose's base.
    let mut pulled = posed;
    let tip = given
        .template
        .landmarks
        .iter()
        .find(|l| l.name == "ibug_30");
    let tip = tip.expect("a nose").stencil[0].0 as usize;
    pulled[tip] += pose.rotation * DVec3::new(0.0, 6.0, -4.0);
    assert!(evaluator.measure(&person, &pulled).folds > 0);
}

#[test]
fn who_cannot_be_registered_is_listed_and_the_others_are_measured() {
    let Some(given) = given() else { return };
    let evaluator = given.evaluator();
    let simulator = Simulator::new(given.ict);
    let settings = Settings {
        noise: 0.2,
        jitter: 0.5,
        holes: true,
    };
    let run = |threads| {
        let register = |person: &Simulated| match person.truth.seed {
            8205 => Err(FitError::Input("no face".into())),
            _ => Ok(given.truth(&evaluator, person)),
        };
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        let setting = ("usual, holes", &settings);
        let report = pool
            .expect("threads")
            .install(|| evaluate(&evaluator, &simulator, setting, 8204, 3, register, || ()));
        let mut report = report.expect("measures");
        report.seconds = 0.0;
        report
    };
    let report = run(1);
    assert_eq!(report, run(3), "but for the time, threads change nothing");
    assert_eq!(report.people, 2);
    assert_eq!(report.failed, [(8205, "no face".to_string())]);
    assert!(report.drift.max < 1e-9);
    // The scan is noise of 0.2 mm around the skin; its mean size is sqrt(2 / pi) of that, less
    // what the closest of several noisy triangles takes away.
    assert!((0.05..0.16).contains(&report.face_to_scan.mean));
    let names: Vec<&str> = report.expressions.iter().map(|e| &e.0[..]).collect();
    assert_eq!(names, ["jawOpen", "eyeBlink"]);
    // Nobody at all is an error with the first cause.
    let nobody = |_: &Simulated| Err(FitError::Input("no face".into()));
    let setting = ("usual, holes", &settings);
    let error = evaluate(&evaluator, &simulator, setting, 8204, 2, nobody, || ());
    assert_eq!(
        error.map(|_| ()).unwrap_err().to_string(),
        "person 8204: no face"
    );
}

#[test]
fn an_expression_follows_pose_size_and_shape_and_does_not_fold() {
    let Some(given) = given() else { return };
    let performer = Performer::new(given.template, &given.expressions).expect("has a skin");
    let rest = &given.template.positions;
    let pose = Rigid {
        rotation: DMat3::from_rotation_y(0.7) * DMat3::from_rotation_x(-0.3),
        translation: DVec3::new(100.0, -40.0, 250.0),
    };
    let posed: Vec<DVec3> = rest.iter().map(|&p| pose.apply(p * 1.2)).collect();
    // A head of other proportions, with the lids half as far apart.
    let low: Vec<DVec3> = rest
        .iter()
        .map(|&p| p * DVec3::new(1.0, 0.6, 1.1))
        .collect();
    for expression in &given.expressions.list {
        let plain = performer.on(rest, expression);
        let turned = performer.on(&posed, expression);
        let moved: Vec<f64> = rest
            .iter()
            .zip(&plain)
            .map(|(a, b)| a.distance(*b))
            .collect();
        assert!(moved.iter().copied().fold(0.0, f64::max) > 5.0);
        assert!(moved.iter().filter(|&&d| d == 0.0).count() > 5000);
        for (p, q) in plain.iter().zip(&turned) {
            // Whether a pair is folded may be a matter of rounding; not here.
            assert!(q.distance(pose.apply(*p * 1.2)) < 1e-6);
        }
        for face in [&plain, &turned, &performer.on(&low, expression)] {
            assert_eq!(performer.folds.of(face).len(), 0, "{}", expression.name);
        }
    }
}
