//! What a face knows of itself, in mm.

use glam::DVec3;

use crate::anatomy::{Axis, Landmark, Measure, Quantity};
use crate::fit::head::generic_head::closest;
use crate::fit::head::region::point;
use crate::fit::head::template::Template;
use crate::fit::{FitError, FitResult};

/// A measure's definition.
pub struct Definition {
    /// The block whose controls are described by it.
    pub feature: &'static str,
    /// What anthropometry calls it.
    pub name: &'static str,
    /// Where it is measured, in words.
    pub description: &'static str,
    /// What is measured.
    pub what: What,
    /// What a face with more of it has, and what one with less of it.
    pub more_and_less: [&'static str; 2],
}

/// A [`Quantity`] with landmarks by name.
#[derive(Debug, Clone, Copy)]
pub enum What {
    /// The distance between two landmarks.
    Distance(&'static str, &'static str),
    /// How far the mean of some landmarks lies from that of others along an axis.
    Offset(Axis, &'static [&'static str], &'static [&'static str]),
    /// The mean of several.
    Mean(&'static [What]),
    /// The geometric mean of several.
    Size(&'static [What]),
}
use What::{Distance, Mean, Offset, Size};

const fn measure(
    feature: &'static str,
    name: &'static str,
    description: &'static str,
    what: What,
    more_and_less: [&'static str; 2],
) -> Definition {
    Definition {
        feature,
        name,
        description,
        what,
        more_and_less,
    }
}

/// What no feature moves: places are counted from between the ears.
const EARS: &[&str] = &["tragion right", "tragion left"];
const LIPS: &[&str] = &["ibug_48", "ibug_51", "ibug_54", "ibug_57"];
const NOSE: &[&str] = &["alare right", "ibug_33", "alare left"];
const LEFT_LENGTH: What = Distance("ibug_42", "ibug_45");
const RIGHT_LENGTH: What = Distance("ibug_36", "ibug_39");
const LENGTH: What = Mean(&[LEFT_LENGTH, RIGHT_LENGTH]);
const LEFT_OPENING: What = Distance("ibug_43", "ibug_47");
const RIGHT_OPENING: What = Distance("ibug_38", "ibug_40");
const OPENING: What = Mean(&[LEFT_OPENING, RIGHT_OPENING]);
const LEFT_PLACE: What = Offset(Axis::Y, &["ibug_42", "ibug_45"], EARS);
const RIGHT_PLACE: What = Offset(Axis::Y, &["ibug_36", "ibug_39"], EARS);
const FOREHEAD_WIDTH: What = Distance("frontotemporale right", "frontotemporale left");
const FOREHEAD_HEIGHT: What = Distance("trichion", "glabella");

/// All measures of a model: the twenty that semantic controls set (semantic reshaping, Table 1, in
/// its order), then others.
#[rustfmt::skip]
pub const MEASURES: [Definition; 31] = [
    measure("mouth", "mouth width", "from corner to corner", Distance("ibug_48", "ibug_54"), ["wider mouth", "narrower mouth"]),
    measure("mouth", "mouth protrusion", "how far the middle of the lips lies before their corners", Offset(Axis::Z, &["ibug_51", "ibug_57"], &["ibug_48", "ibug_54"]), ["lips forward", "lips back"]),
    measure("mouth", "mouth vertical position", "how high the lips lie over the ears' tragi", Offset(Axis::Y, LIPS, EARS), ["mouth up", "mouth down"]),
    measure("mouth", "mouth lateral position", "how far the lips lie to the subject's left of the middle between the tragi", Offset(Axis::X, LIPS, EARS), ["mouth to its left", "mouth to its right"]),
    measure("nose", "nose length", "how far the tip lies before the subnasale", Offset(Axis::Z, &["ibug_30"], &["ibug_33"]), ["longer nose", "shorter nose"]),
    measure("nose", "nose width", "from ala to ala", Distance("alare right", "alare left"), ["wider nose", "narrower nose"]),
    measure("nose", "nose height", "from the nasion to the subnasale", Distance("ibug_27", "ibug_33"), ["higher nose", "lower nose"]),
    measure("nose", "nose lateral position", "how far the nose's base lies to the subject's left of the middle between the tragi", Offset(Axis::X, NOSE, EARS), ["nose to its left", "nose to its right"]),
    measure("nose", "nose vertical position", "how high the nose's base lies over the ears' tragi", Offset(Axis::Y, NOSE, EARS), ["nose up", "nose down"]),
    measure("eyes", "eyes size", "the geometric mean of length and opening, both the mean of left and right", Size(&[LENGTH, OPENING]), ["larger eyes", "smaller eyes"]),
    measure("eyes", "eyes length", "from corner to corner, the mean of left and right", LENGTH, ["longer eyes", "shorter eyes"]),
    measure("eyes", "eyes vertical position", "how high the corners lie over the ears' tragi, the mean of left and right", Mean(&[LEFT_PLACE, RIGHT_PLACE]), ["eyes up", "eyes down"]),
    measure("forehead", "forehead width", "from frontotemporale to frontotemporale", FOREHEAD_WIDTH, ["wider forehead", "narrower forehead"]),
    measure("forehead", "forehead convexity", "how far the metopion lies before the middle between trichion and glabella", Offset(Axis::Z, &["metopion"], &["trichion", "glabella"]), ["convex forehead", "flat forehead"]),
    measure("forehead", "forehead size", "the geometric mean of width and height", Size(&[FOREHEAD_WIDTH, FOREHEAD_HEIGHT]), ["larger forehead", "smaller forehead"]),
    measure("eyes", "inner eye distance", "between the inner corners of the eyes", Distance("ibug_39", "ibug_42"), ["eyes apart", "eyes together"]),
    measure("eyes", "right eye vertical position", "how high its corners lie over the ears' tragi", RIGHT_PLACE, ["right eye up", "right eye down"]),
    measure("eyes", "right eye length", "from corner to corner", RIGHT_LENGTH, ["longer right eye", "shorter right eye"]),
    measure("eyes", "left eye vertical position", "how high its corners lie over the ears' tragi", LEFT_PLACE, ["left eye up", "left eye down"]),
    measure("eyes", "left eye length", "from corner to corner", LEFT_LENGTH, ["longer left eye", "shorter left eye"]),

    measure("head", "face height", "from the nasion to the menton", Distance("ibug_27", "ibug_08"), ["longer face", "shorter face"]),
    measure("head", "face width", "from cheek to cheek", Distance("cheek right", "cheek left"), ["wider cheeks", "narrower cheeks"]),
    measure("head", "jaw width", "from gonion to gonion", Distance("gonion right", "gonion left"), ["wider jaw", "narrower jaw"]),
    measure("head", "tragion width", "from tragion to tragion", Distance("tragion right", "tragion left"), ["wider head", "narrower head"]),
    measure("forehead", "forehead height", "from the trichion to the glabella", FOREHEAD_HEIGHT, ["higher forehead", "lower forehead"]),
    measure("eyes", "brow distance", "between the inner ends of the brows", Distance("ibug_21", "ibug_22"), ["brows apart", "brows together"]),
    measure("eyes", "left eye height", "from lid to lid", LEFT_OPENING, ["more open left eye", "narrower left eye"]),
    measure("eyes", "right eye height", "from lid to lid", RIGHT_OPENING, ["more open right eye", "narrower right eye"]),
    measure("mouth", "lip height", "from the upper to the lower edge of the lips", Distance("ibug_51", "ibug_57"), ["fuller lips", "thinner lips"]),
    measure("mouth", "upper lip height", "from the subnasale to the edge of the lip", Distance("ibug_33", "ibug_51"), ["longer upper lip", "shorter upper lip"]),
    measure("chin", "chin height", "from the lower edge of the lips to the menton", Distance("ibug_57", "ibug_08"), ["higher chin", "lower chin"]),
];

/// How many of [`MEASURES`], from the first on, semantic controls set.
pub const SEMANTIC: usize = 20;

/// What no semantic control should change besides, though none sets it: how eyes are tilted and
/// turned, how far the forehead leans back, how deep the nose sits in the face and how its tip, wings
/// and bridge stand to each other, whether the mouth smiles, and how its lips lie on each other. Tilted
/// far enough, lengths grow; a nose that grows by sinking is none; a mouth that goes up in the middle
/// alone frowns, and lips and nostrils that turn go up without moving.
#[rustfmt::skip]
pub const GUARDED: [Definition; 17] = [
    measure("nose", "nose base depth", "how far the nose's base lies before the ears' tragi", Offset(Axis::Z, NOSE, EARS), ["", ""]),
    measure("nose", "nose tip rise", "how high the tip lies over the subnasale", Offset(Axis::Y, &["ibug_30"], &["ibug_33"]), ["", ""]),
    measure("nose", "nose wing rise", "how high the alae lie over the subnasale", Offset(Axis::Y, &["alare right", "alare left"], &["ibug_33"]), ["", ""]),
    measure("nose", "nose wing depth", "how far the alae lie before the subnasale", Offset(Axis::Z, &["alare right", "alare left"], &["ibug_33"]), ["", ""]),
    measure("nose", "nose bridge", "how far the bridge lies before the middle between nasion and tip", Offset(Axis::Z, &["ibug_28", "ibug_29"], &["ibug_27", "ibug_30"]), ["", ""]),
    measure("nose", "nose root depth", "how far the nasion lies before the ears' tragi", Offset(Axis::Z, &["ibug_27"], EARS), ["", ""]),
    measure("mouth", "upper vermilion height", "how high the upper lip's edge lies over where the lips meet", Offset(Axis::Y, &["ibug_51"], &["ibug_62"]), ["", ""]),
    measure("mouth", "lower vermilion height", "how high where the lips meet lies over the lower lip's edge", Offset(Axis::Y, &["ibug_66"], &["ibug_57"]), ["", ""]),
    measure("mouth", "lips apart", "how high the upper lip lies over the lower where they meet", Offset(Axis::Y, &["ibug_62"], &["ibug_66"]), ["", ""]),
    measure("mouth", "lips out of line", "how far the upper lip lies before the lower where they meet", Offset(Axis::Z, &["ibug_62"], &["ibug_66"]), ["", ""]),
    measure("mouth", "upper lip prominence", "how far the upper lip's edge lies before the lower's", Offset(Axis::Z, &["ibug_51"], &["ibug_57"]), ["", ""]),
    measure("mouth", "mouth curve", "how high the mouth's corners lie over the middle of its lips", Offset(Axis::Y, &["ibug_48", "ibug_54"], &["ibug_51", "ibug_57"]), ["", ""]),
    measure("forehead", "forehead slope", "how far the trichion lies before the glabella", Offset(Axis::Z, &["trichion"], &["glabella"]), ["", ""]),
    measure("eyes", "left eye tilt", "how high the outer corner lies over the inner", Offset(Axis::Y, &["ibug_45"], &["ibug_42"]), ["", ""]),
    measure("eyes", "right eye tilt", "how high the outer corner lies over the inner", Offset(Axis::Y, &["ibug_36"], &["ibug_39"]), ["", ""]),
    measure("eyes", "left eye turn", "how far the outer corner lies before the inner", Offset(Axis::Z, &["ibug_45"], &["ibug_42"]), ["", ""]),
    measure("eyes", "right eye turn", "how far the outer corner lies before the inner", Offset(Axis::Z, &["ibug_36"], &["ibug_39"]), ["", ""]),
];

/// A point that no template has, by a point near it that landmarks give: it is where the skin is
/// nearest to that.
type Near = (&'static str, &'static [(&'static str, f64)]);

/// The middle of the forehead, and where it turns to the temple (the frontotemporale lies a third
/// of the way from the outer end of the brow to the hair line).
#[rustfmt::skip]
const POINTS: [Near; 3] = [
    ("metopion", &[("glabella", 0.5), ("trichion", 0.5)]),
    ("frontotemporale left", &[("ibug_26", 0.7), ("trichion", 0.3)]),
    ("frontotemporale right", &[("ibug_17", 0.7), ("trichion", 0.3)]),
];

/// A model's landmarks, which are the template's and those that measures need besides, and the
/// measures on them.
///
/// # Errors
/// When the template lacks a landmark that a measure needs.
pub fn measures(template: &Template) -> FitResult<(Vec<Landmark>, Vec<Measure>)> {
    let mut landmarks = template.landmarks.clone();
    let triangles = template.part_triangles("skin")?;
    for (name, near) in POINTS {
        let mut place = DVec3::ZERO;
        for (other, weight) in near {
            place += *weight * point(template, other)?;
        }
        landmarks.push(Landmark {
            name: name.into(),
            stencil: on_grid(closest(&template.positions, &triangles, place)),
        });
    }
    let measures = on(&landmarks, &MEASURES)?;
    Ok((landmarks, measures))
}

/// Weights in units of 1/65536, which a header's JSON keeps to the last bit; the largest takes what
/// rounding leaves.
fn on_grid(mut stencil: Vec<(u32, f64)>) -> Vec<(u32, f64)> {
    for (_, weight) in &mut stencil {
        *weight = (*weight * 65_536.0).round() / 65_536.0;
    }
    let left = 1.0 - stencil.iter().map(|s| s.1).sum::<f64>();
    if let Some(largest) = stencil.iter_mut().max_by(|a, b| a.1.total_cmp(&b.1)) {
        largest.1 += left;
    }
    stencil
}

/// Definitions on a model's landmarks.
///
/// # Errors
/// When a landmark is missing.
pub fn on(landmarks: &[Landmark], definitions: &[Definition]) -> FitResult<Vec<Measure>> {
    let index = |name: &str| {
        let found = landmarks.iter().position(|l| l.name == name);
        found
            .map(|i| i as u32)
            .ok_or_else(|| FitError::Input(format!("the template has no landmark called {name:?}")))
    };
    let measure = |m: &Definition| {
        Ok(Measure {
            name: m.name.into(),
            description: m.description.into(),
            quantity: quantity(&m.what, &index)?,
        })
    };
    definitions.iter().map(measure).collect()
}

fn quantity(what: &What, index: &impl Fn(&str) -> FitResult<u32>) -> FitResult<Quantity> {
    let all = |names: &[&str]| -> FitResult<Vec<u32>> { names.iter().map(|n| index(n)).collect() };
    let each = |some: &[What]| -> FitResult<Vec<Quantity>> {
        some.iter().map(|what| quantity(what, index)).collect()
    };
    Ok(match what {
        Distance(from, to) => Quantity::Distance {
            from: index(from)?,
            to: index(to)?,
        },
        Offset(axis, of, over) => Quantity::Offset {
            axis: *axis,
            of: all(of)?,
            over: all(over)?,
        },
        Mean(some) => Quantity::Mean { mean: each(some)? },
        Size(some) => Quantity::GeometricMean {
            geometric_mean: each(some)?,
        },
    })
}
