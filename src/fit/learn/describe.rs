//! What a control does, in words: eigenmeshes have no names of their own.

use std::collections::BTreeSet;

use glam::{DVec3, Vec3};

use super::measures::MEASURES;
use crate::FaceModel;
use crate::fit::{FitError, FitResult};
use crate::model::{Control, ModelParts};

/// A control is described by what it carries at least this share of, among its group's controls:
/// the root of 0.16 of the variance.
const SHARE: f64 = 0.4;
/// One that carries no such share is described by what it carries most of, if that is this much,
const LEAST_SHARE: f64 = 0.1;
/// and by what it carries nearly as much of.
const NEARLY: f64 = 0.6;
/// And which moves by at least this for one sigma, mm: less is not seen.
const VISIBLE: f64 = 0.25;
const MOST_WORDS: usize = 3;
/// What is said of a control that moves its two sides in opposite ways, and nothing by much.
const UNLIKE: &str = "left and right differ";

/// The skull is looked at from so far over the ears on, and the neck so far over where it ends and so thick, mm.
const CLEAR: f32 = 5.0;
const CUT: f32 = 20.0;
const THICK: f32 = 10.0;

/// What is seen of a face besides its measures.
enum Seen {
    /// How far landmarks lie along an axis, on average.
    Place(&'static [&'static str], Vec3),
    /// How much farther along an axis the left one of two landmarks (right, left) lies.
    Askew([&'static str; 2], Vec3),
    /// The distance of two landmarks.
    Apart([&'static str; 2]),
    /// By how much two landmarks are farther from each other than two others.
    Beyond([&'static str; 2], [&'static str; 2]),
    /// How far the outermost vertices of a slice of the head lie from each other along an axis.
    Across(Slice, Vec3),
    /// Where the middle between these lies.
    Middle(Slice, Vec3),
}
use Seen::{Across, Apart, Askew, Beyond, Middle, Place};

/// Vertices of the mean head, by their height.
#[derive(Clone, Copy)]
enum Slice {
    /// What lies over the ears.
    Skull,
    /// Where the neck is about to end.
    Neck,
}

/// The block whose controls are described by it, what is seen, and what a face is said to have
/// which has more of it, and less.
type Sight = (&'static str, Seen, [&'static str; 2]);

const TRAGIA: [&str; 2] = ["tragion right", "tragion left"];
const GONIA: [&str; 2] = ["gonion right", "gonion left"];
const CHEEKS: [&str; 2] = ["cheek right", "cheek left"];
const UPPER_EARS: [&str; 2] = ["superaurale right", "superaurale left"];
const LOWER_EARS: [&str; 2] = ["lower helix right", "lower helix left"];
const ALAE: [&str; 2] = ["alare right", "alare left"];
const OUTER: [&str; 2] = ["ibug_36", "ibug_45"];
const INNER: [&str; 2] = ["ibug_39", "ibug_42"];
const CORNERS: [&str; 2] = ["ibug_48", "ibug_54"];
const LIDS: [&str; 2] = ["ibug_38", "ibug_43"];
const BROWS: [&str; 2] = ["ibug_19", "ibug_24"];

#[rustfmt::skip]
const SIGHTS: [Sight; 72] = [
    ("nose", Place(&["ibug_30"], Vec3::Z), ["tip forward", "tip back"]),
    ("nose", Place(&["ibug_30"], Vec3::Y), ["tip up", "tip down"]),
    ("nose", Place(&["ibug_28"], Vec3::Z), ["high bridge", "flat bridge"]),
    ("nose", Place(&["ibug_27"], Vec3::Z), ["high root", "deep root"]),
    ("nose", Place(&["ibug_30"], Vec3::X), ["tip to its left", "tip to its right"]),
    ("nose", Place(&["ibug_28"], Vec3::X), ["bridge to its left", "bridge to its right"]),
    ("nose", Place(&ALAE, Vec3::Y), ["wings up", "wings down"]),
    ("nose", Place(&ALAE, Vec3::Z), ["wings forward", "wings back"]),
    ("nose", Place(&["ibug_33"], Vec3::Z), ["base forward", "base back"]),
    ("nose", Place(&["ibug_33"], Vec3::Y), ["base up", "base down"]),
    ("mouth", Place(&["ibug_51"], Vec3::Z), ["upper lip forward", "upper lip back"]),
    ("mouth", Place(&["ibug_57"], Vec3::Z), ["lower lip forward", "lower lip back"]),
    ("mouth", Place(&CORNERS, Vec3::Y), ["corners up", "corners down"]),
    ("mouth", Place(&CORNERS, Vec3::Z), ["corners forward", "corners back"]),
    ("mouth", Apart(["ibug_51", "ibug_62"]), ["fuller upper lip", "thinner upper lip"]),
    ("mouth", Apart(["ibug_57", "ibug_66"]), ["fuller lower lip", "thinner lower lip"]),
    ("mouth", Apart(["ibug_50", "ibug_52"]), ["wide bow", "narrow bow"]),
    ("chin", Place(&["pogonion"], Vec3::Z), ["chin forward", "chin back"]),
    ("chin", Place(&["pogonion"], Vec3::Y), ["chin up", "chin down"]),
    ("chin", Place(&["pogonion"], Vec3::X), ["chin to its left", "chin to its right"]),
    ("chin", Place(&["supramentale"], Vec3::Z), ["shallow groove", "deep groove"]),
    ("chin", Apart(["ibug_06", "ibug_10"]), ["broader chin", "narrower chin"]),
    ("chin", Place(&["ibug_07", "ibug_09"], Vec3::Y), ["sides up", "sides down"]),
    ("eyes", Place(&BROWS, Vec3::Z), ["strong brows", "flat brows"]),
    ("eyes", Place(&BROWS, Vec3::Y), ["brows up", "brows down"]),
    ("eyes", Place(&["ibug_21", "ibug_22"], Vec3::Y), ["inner brows up", "inner brows down"]),
    ("eyes", Place(&["ibug_17", "ibug_26"], Vec3::Y), ["outer brows up", "outer brows down"]),
    ("eyes", Place(&OUTER, Vec3::Y), ["outer corners up", "outer corners down"]),
    ("eyes", Place(&OUTER, Vec3::Z), ["outer corners forward", "outer corners back"]),
    ("eyes", Place(&INNER, Vec3::Y), ["inner corners up", "inner corners down"]),
    ("eyes", Place(&LIDS, Vec3::Z), ["eyes forward", "deep-set eyes"]),
    ("forehead", Place(&["glabella"], Vec3::Z), ["base forward", "base back"]),
    ("forehead", Place(&["trichion"], Vec3::Z), ["top forward", "top back"]),
    ("head", Place(&GONIA, Vec3::Y), ["jaw corners up", "jaw corners down"]),
    ("head", Place(&GONIA, Vec3::Z), ["jaw corners forward", "jaw corners back"]),
    ("head", Place(&["pogonion"], Vec3::Z), ["jaw forward", "jaw back"]),
    ("head", Place(&["pogonion"], Vec3::X), ["jaw to its left", "jaw to its right"]),
    ("head", Place(&["ibug_30"], Vec3::Z), ["nose forward", "nose back"]),
    ("head", Place(&["ibug_30"], Vec3::Y), ["nose up", "nose down"]),
    ("head", Place(&["ibug_36", "ibug_39", "ibug_42", "ibug_45"], Vec3::Y), ["eyes up", "eyes down"]),
    ("head", Place(&CHEEKS, Vec3::Z), ["cheeks forward", "cheeks back"]),
    ("head", Place(&CHEEKS, Vec3::Y), ["cheeks up", "cheeks down"]),
    ("head", Place(&TRAGIA, Vec3::Y), ["ears up", "ears down"]),
    ("head", Place(&TRAGIA, Vec3::Z), ["ears forward", "ears back"]),
    ("head", Beyond(UPPER_EARS, TRAGIA), ["ears stand out", "ears lie close"]),
    ("head", Beyond(LOWER_EARS, TRAGIA), ["lobes stand out", "lobes lie close"]),
    ("head", Across(Slice::Skull, Vec3::X), ["wider skull", "narrower skull"]),
    ("head", Across(Slice::Neck, Vec3::X), ["wider neck", "narrower neck"]),
    ("head", Middle(Slice::Neck, Vec3::Z), ["neck forward", "neck back"]),
    ("head", Across(Slice::Skull, Vec3::Z), ["longer skull", "shorter skull"]),
    ("head", Place(&["vertex"], Vec3::Y), ["higher skull", "lower skull"]),
    ("head", Across(Slice::Neck, Vec3::Z), ["deeper neck", "flatter neck"]),
    ("head", Place(&["trichion"], Vec3::Z), ["hairline forward", "hairline back"]),
    // What is on one side and not on the other.
    ("nose", Askew(ALAE, Vec3::Y), ["left wing higher", "right wing higher"]),
    ("nose", Askew(ALAE, Vec3::Z), ["left wing forward", "right wing forward"]),
    ("mouth", Askew(CORNERS, Vec3::Y), ["left corner higher", "right corner higher"]),
    ("mouth", Askew(CORNERS, Vec3::Z), ["left corner forward", "right corner forward"]),
    ("chin", Askew(["ibug_07", "ibug_09"], Vec3::Y), ["right side lower", "left side lower"]),
    ("eyes", Askew(BROWS, Vec3::Y), ["left brow higher", "right brow higher"]),
    ("eyes", Askew(BROWS, Vec3::Z), ["left brow forward", "right brow forward"]),
    ("eyes", Askew(OUTER, Vec3::Y), ["left outer corner higher", "right outer corner higher"]),
    ("eyes", Askew(OUTER, Vec3::Z), ["left outer corner forward", "right outer corner forward"]),
    ("eyes", Askew(INNER, Vec3::Y), ["left inner corner higher", "right inner corner higher"]),
    ("eyes", Askew(LIDS, Vec3::Z), ["left eye forward", "right eye forward"]),
    ("head", Askew(GONIA, Vec3::Y), ["left jaw corner higher", "right jaw corner higher"]),
    ("head", Askew(GONIA, Vec3::Z), ["left jaw corner forward", "right jaw corner forward"]),
    ("head", Askew(CHEEKS, Vec3::Z), ["left cheek forward", "right cheek forward"]),
    ("head", Askew(OUTER, Vec3::Y), ["left eye higher", "right eye higher"]),
    ("head", Askew(TRAGIA, Vec3::Y), ["left ear higher", "right ear higher"]),
    ("head", Askew(TRAGIA, Vec3::Z), ["left ear forward", "right ear forward"]),
    ("head", Place(&UPPER_EARS, Vec3::X), ["left ear stands out", "right ear stands out"]),
    ("head", Middle(Slice::Neck, Vec3::X), ["neck to its left", "neck to its right"]),
];

/// What a [`Seen`] reads off a head's vertices, mm.
type Reader<'a> = Box<dyn Fn(&[Vec3]) -> f64 + 'a>;

impl Seen {
    /// Reads it on heads of a model.
    fn reader<'a>(&self, parts: &'a ModelParts) -> FitResult<Reader<'a>> {
        let find = |name: &str| {
            let landmark = parts.landmarks.iter().find(|l| l.name == name);
            landmark.ok_or_else(|| {
                FitError::Input(format!("the template has no landmark called {name:?}"))
            })
        };
        let apart = |[a, b]: [&str; 2]| {
            let (a, b) = (find(a)?, find(b)?);
            Ok::<_, FitError>(move |head: &[Vec3]| a.place(head).distance(b.place(head)))
        };
        let ends = |slice: Slice, axis: Vec3| {
            let [low, high] = slice.ends(parts, axis)?;
            let axis = axis.as_dvec3();
            Ok::<_, FitError>(move |head: &[Vec3]| {
                [low, high].map(|v| head[v as usize].as_dvec3().dot(axis))
            })
        };
        let reader: Reader<'a> = match *self {
            Place(names, axis) => {
                let found = (names.iter().map(|name| find(name))).collect::<FitResult<Vec<_>>>()?;
                Box::new(move |head| {
                    let places = found.iter().map(|l| l.place(head));
                    places.sum::<DVec3>().dot(axis.as_dvec3()) / found.len() as f64
                })
            }
            Askew([right, left], axis) => {
                let (right, left) = (find(right)?, find(left)?);
                Box::new(move |head| (left.place(head) - right.place(head)).dot(axis.as_dvec3()))
            }
            Apart(ends) => Box::new(apart(ends)?),
            Beyond(more, less) => {
                let (more, less) = (apart(more)?, apart(less)?);
                Box::new(move |head| more(head) - less(head))
            }
            Across(slice, axis) => {
                let ends = ends(slice, axis)?;
                Box::new(move |head| ends(head)[1] - ends(head)[0])
            }
            Middle(slice, axis) => {
                let ends = ends(slice, axis)?;
                Box::new(move |head| ends(head).iter().sum::<f64>() / 2.0)
            }
        };
        Ok(reader)
    }
}

impl Slice {
    /// The vertices of the mean head's slice that lie least and most far along an axis.
    fn ends(self, parts: &ModelParts, axis: Vec3) -> FitResult<[u32; 2]> {
        let mean = &parts.mean;
        let height = |v: u32| mean[v as usize].y;
        let all = || 0..mean.len() as u32;
        let heights = match self {
            Slice::Skull => {
                let ears = parts
                    .landmarks
                    .iter()
                    .filter(|l| UPPER_EARS.contains(&&*l.name));
                let top = (ears.map(|l| l.position(mean).y)).fold(f32::NEG_INFINITY, f32::max);
                top + CLEAR..f32::INFINITY
            }
            Slice::Neck => {
                let lowest = all().map(height).fold(f32::INFINITY, f32::min);
                lowest + CUT..lowest + CUT + THICK
            }
        };
        let along = |v: &u32| mean[*v as usize].dot(axis);
        let slice = || all().filter(|&v| heights.contains(&height(v)));
        let least = slice().min_by(|a, b| along(a).total_cmp(&along(b)));
        let most = slice().max_by(|a, b| along(a).total_cmp(&along(b)));
        match (least, most) {
            (Some(least), Some(most)) => Ok([least, most]),
            _ => Err(FitError::Input(
                "the template has no skin over its ears, or none at its neck".into(),
            )),
        }
    }
}

/// Describes every control by the lengths and places that it changes most among the controls of
/// its group, out of those of its own feature: what the face has when the slider is at its right end, strongest first. One that
/// carries no large share of any is described by those that it carries most of, and without a
/// description if it hardly moves them, unless its sides differ.
///
/// # Errors
/// When the parts are not a sound model, or lack a landmark.
pub fn describe(parts: &mut ModelParts) -> FitResult<()> {
    let model = FaceModel::parse(&parts.write()?)?;
    let readers = SIGHTS
        .iter()
        .map(|(_, seen, _)| seen.reader(model.parts()))
        .collect::<FitResult<Vec<_>>>()?;
    let words: Vec<[&str; 2]> = MEASURES
        .iter()
        .map(|m| m.more_and_less)
        .chain(SIGHTS.iter().map(|s| s.2))
        .collect();
    let features: Vec<&str> = MEASURES
        .iter()
        .map(|m| m.feature)
        .chain(SIGHTS.iter().map(|s| s.0))
        .collect();
    let mut face = model.face();
    let mut observe = |coefficients: &[f32]| -> FitResult<Vec<f64>> {
        face.set_coefficients(coefficients)?;
        let lengths = MEASURES.iter().map(|m| face.measure(m.name));
        let mut observed = lengths.collect::<Result<Vec<f64>, _>>()?;
        observed.extend(readers.iter().map(|read| read(face.positions())));
        Ok(observed)
    };
    // Semantic controls are described by what they set.
    let modes = |c: &&Control| c.measure.is_none();
    let effects = (parts.controls.iter().filter(modes))
        .map(|control| {
            let mut at = |amount: f32| {
                let mut c = vec![0.0; parts.coefficients()];
                control
                    .direction
                    .iter()
                    .for_each(|&(i, change)| c[i as usize] = amount * change);
                observe(&c)
            };
            // Over two sigmas to both sides: what a person sees, not the slope at the mean.
            let (more, less) = (at(2.0)?, at(-2.0)?);
            Ok(more.iter().zip(&less).map(|(m, l)| (m - l) / 4.0).collect())
        })
        .collect::<FitResult<Vec<Vec<f64>>>>()?;
    let odd = parts.odd();
    let descriptions: Vec<String> = (parts.controls.iter().filter(modes))
        .zip(&effects)
        .map(|(control, own)| {
            let group = || {
                let same = parts.controls.iter().filter(modes).zip(&effects);
                same.filter(|(c, _)| c.group == control.group)
                    .map(|(_, e)| e)
            };
            let carried = (0..words.len())
                .filter(|&i| features[i] == control.group && own[i].abs() >= VISIBLE)
                .map(|i| {
                    let all = group().map(|e| e[i] * e[i]).sum::<f64>().sqrt();
                    (own[i].abs() / all, words[i][usize::from(own[i] < 0.0)])
                })
                .collect();
            let said = sentence(&telling(carried));
            match said.is_empty() && control.direction.iter().all(|&(i, _)| odd[i as usize]) {
                true => UNLIKE.into(),
                false => said,
            }
        })
        .collect();
    let controls = parts.controls.iter_mut().filter(|c| c.measure.is_none());
    for (control, description) in controls.zip(descriptions) {
        control.description = description;
    }
    Ok(())
}

/// Of shares that a control carries and their words, those that tell what it does, strongest first.
fn telling(mut carried: Vec<(f64, &'static str)>) -> Vec<(f64, &'static str)> {
    carried.sort_by(|a, b| b.0.total_cmp(&a.0));
    let most = carried.first().map_or(0.0, |c| c.0);
    let least = SHARE.min((NEARLY * most).max(LEAST_SHARE));
    carried.retain(|(share, _)| *share >= least);
    carried
}

/// The strongest, with one word for both eyes where both do the same.
fn sentence(carried: &[(f64, &str)]) -> String {
    let mut words: Vec<String> = Vec::new();
    for (_, word) in carried {
        let other = word
            .replace("left eye", "RIGHT")
            .replace("right eye", "left eye");
        let other = other.replace("RIGHT", "right eye");
        match words.iter_mut().find(|w| **w == other && other != **word) {
            Some(pair) => {
                *pair = word
                    .replace("left eye", "eyes")
                    .replace("right eye", "eyes")
            }
            None => words.push((*word).to_owned()),
        }
    }
    let mut said = BTreeSet::new();
    words.retain(|word| said.insert(word.clone()));
    words.truncate(MOST_WORDS);
    words.join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_both_eyes_do_is_said_once() {
        let carried = [
            (0.9, "longer left eye"),
            (0.8, "brows up"),
            (0.7, "longer right eye"),
        ];
        assert_eq!(sentence(&carried), "longer eyes, brows up");
        assert_eq!(sentence(&carried[..2]), "longer left eye, brows up");
        let apart = [(0.9, "longer left eye"), (0.8, "shorter right eye")];
        assert_eq!(sentence(&apart), "longer left eye, shorter right eye");
        let thrice = [(0.9, "longer eyes"), carried[0], carried[2]];
        assert_eq!(sentence(&thrice), "longer eyes");
    }

    #[test]
    fn the_small_are_described_by_what_they_do_most() {
        let large = vec![(0.3, "wide"), (0.5, "long"), (0.45, "deep")];
        assert_eq!(
            telling(large),
            [(0.5, "long"), (0.45, "deep"), (0.3, "wide")]
        );
        let small = vec![(0.1, "wide"), (0.3, "long"), (0.19, "deep")];
        assert_eq!(telling(small), [(0.3, "long"), (0.19, "deep")]);
        assert_eq!(telling(vec![(0.05, "wide"), (0.09, "long")]), []);
        assert_eq!(telling(Vec::new()), []);
    }
}
