//! What a control does, in words: eigenmeshes have no names of their own.

use glam::Vec3;

use super::measures::MEASURES;
use crate::FaceModel;
use crate::fit::{FitError, FitResult};
use crate::model::ModelParts;

/// A control is described by what it carries at least this share of, among its group's controls:
/// the root of 0.16 of the variance.
const SHARE: f64 = 0.4;
/// And which moves by at least this for one sigma, mm: less is not seen.
const VISIBLE: f64 = 0.25;
const MOST_WORDS: usize = 3;

/// The block whose controls are described by it, a place, an axis, and what a face is said to have
/// whose place lies farther along it, and less far.
type Shift = (&'static str, &'static str, Vec3, [&'static str; 2]);

#[rustfmt::skip]
const SHIFTS: [Shift; 19] = [
    ("nose", "ibug_30", Vec3::Z, ["tip forward", "tip back"]),
    ("nose", "ibug_30", Vec3::Y, ["tip up", "tip down"]),
    ("nose", "ibug_28", Vec3::Z, ["high bridge", "flat bridge"]),
    ("nose", "ibug_30", Vec3::X, ["tip to its left", "tip to its right"]),
    ("mouth", "ibug_51", Vec3::Z, ["upper lip forward", "upper lip back"]),
    ("mouth", "ibug_57", Vec3::Z, ["lower lip forward", "lower lip back"]),
    ("mouth", "ibug_54", Vec3::Y, ["corners up", "corners down"]),
    ("chin", "pogonion", Vec3::Z, ["chin forward", "chin back"]),
    ("chin", "pogonion", Vec3::Y, ["chin up", "chin down"]),
    ("eyes", "ibug_24", Vec3::Z, ["strong brows", "flat brows"]),
    ("eyes", "ibug_24", Vec3::Y, ["brows up", "brows down"]),
    ("eyes", "ibug_45", Vec3::Y, ["outer corners up", "outer corners down"]),
    ("eyes", "ibug_43", Vec3::Z, ["eyes forward", "deep-set eyes"]),
    ("forehead", "glabella", Vec3::Z, ["base forward", "base back"]),
    ("forehead", "trichion", Vec3::Z, ["top forward", "top back"]),
    ("head", "gonion left", Vec3::Y, ["jaw corners up", "jaw corners down"]),
    ("head", "vertex", Vec3::Y, ["higher skull", "lower skull"]),
    ("head", "pogonion", Vec3::Z, ["jaw forward", "jaw back"]),
    ("head", "ibug_30", Vec3::Z, ["nose forward", "nose back"]),
];

/// Describes every control by the lengths and places that it changes most among the controls of
/// its group, out of those of its own feature: what the face has when the slider is at its right end, strongest first. One that
/// carries no large share of any is left without a description.
///
/// # Errors
/// When the parts are not a sound model.
pub fn describe(parts: &mut ModelParts) -> FitResult<()> {
    let model = FaceModel::parse(&parts.write()?)?;
    let shifts = SHIFTS
        .iter()
        .map(|(_, name, axis, words)| {
            let landmark = parts.landmarks.iter().find(|l| l.name == *name);
            let landmark = landmark.ok_or_else(|| {
                FitError::Input(format!("the template has no landmark called {name:?}"))
            })?;
            Ok((landmark.clone(), *axis, *words))
        })
        .collect::<FitResult<Vec<_>>>()?;
    let words: Vec<[&str; 2]> = MEASURES
        .iter()
        .map(|m| m.more_and_less)
        .chain(shifts.iter().map(|s| s.2))
        .collect();
    let features: Vec<&str> = MEASURES
        .iter()
        .map(|m| m.feature)
        .chain(SHIFTS.iter().map(|s| s.0))
        .collect();
    let mut face = model.face();
    let mut observe = |coefficients: &[f32]| -> FitResult<Vec<f64>> {
        face.set_coefficients(coefficients)?;
        let lengths = MEASURES.iter().map(|m| face.measure(m.name));
        let mut observed = lengths.collect::<Result<Vec<f64>, _>>()?;
        let place = |(landmark, axis, _): &(crate::anatomy::Landmark, Vec3, _)| {
            f64::from(landmark.position(face.positions()).dot(*axis))
        };
        observed.extend(shifts.iter().map(place));
        Ok(observed)
    };
    let effects = parts
        .controls
        .iter()
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
    let descriptions: Vec<String> = parts
        .controls
        .iter()
        .zip(&effects)
        .map(|(control, own)| {
            let group = || {
                let same = parts.controls.iter().zip(&effects);
                same.filter(|(c, _)| c.group == control.group)
                    .map(|(_, e)| e)
            };
            let mut carried: Vec<(f64, &str)> = (0..words.len())
                .filter(|&i| features[i] == control.group && own[i].abs() >= VISIBLE)
                .map(|i| {
                    let all = group().map(|e| e[i] * e[i]).sum::<f64>().sqrt();
                    (own[i].abs() / all, words[i][usize::from(own[i] < 0.0)])
                })
                .filter(|(share, _)| *share >= SHARE)
                .collect();
            carried.sort_by(|a, b| b.0.total_cmp(&a.0));
            sentence(&carried)
        })
        .collect();
    for (control, description) in parts.controls.iter_mut().zip(descriptions) {
        control.description = description;
    }
    Ok(())
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
    }
}
