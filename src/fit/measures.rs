//! The lengths that a face knows of itself.

use super::template::Template;
use super::{FitError, FitResult};
use crate::anatomy::Measure;

/// A measure's definition.
pub struct Definition {
    /// The block whose controls are described by it.
    pub feature: &'static str,
    /// What anthropometry calls it.
    pub name: &'static str,
    /// Where it is measured, in words.
    pub description: &'static str,
    /// The landmarks at its ends.
    pub ends: [&'static str; 2],
    /// What a face with more of it has, and what one with less of it.
    pub more_and_less: [&'static str; 2],
}

const fn length(
    feature: &'static str,
    name: &'static str,
    description: &'static str,
    ends: [&'static str; 2],
    more_and_less: [&'static str; 2],
) -> Definition {
    Definition {
        feature,
        name,
        description,
        ends,
        more_and_less,
    }
}

/// All measures of a model, all of them distances between two landmarks.
#[rustfmt::skip]
pub const MEASURES: [Definition; 17] = [
    length("head", "face height", "from the nasion to the menton", ["ibug_27", "ibug_08"], ["longer face", "shorter face"]),
    length("head", "face width", "from cheek to cheek", ["cheek right", "cheek left"], ["wider cheeks", "narrower cheeks"]),
    length("head", "jaw width", "from gonion to gonion", ["gonion right", "gonion left"], ["wider jaw", "narrower jaw"]),
    length("head", "tragion width", "from tragion to tragion", ["tragion right", "tragion left"], ["wider head", "narrower head"]),
    length("forehead", "forehead height", "from the trichion to the glabella", ["trichion", "glabella"], ["higher forehead", "lower forehead"]),
    length("eyes", "brow distance", "between the inner ends of the brows", ["ibug_21", "ibug_22"], ["brows apart", "brows together"]),
    length("eyes", "inner eye distance", "between the inner corners of the eyes", ["ibug_39", "ibug_42"], ["eyes apart", "eyes together"]),
    length("eyes", "left eye length", "from corner to corner", ["ibug_42", "ibug_45"], ["longer left eye", "shorter left eye"]),
    length("eyes", "right eye length", "from corner to corner", ["ibug_36", "ibug_39"], ["longer right eye", "shorter right eye"]),
    length("eyes", "left eye height", "from lid to lid", ["ibug_43", "ibug_47"], ["more open left eye", "narrower left eye"]),
    length("eyes", "right eye height", "from lid to lid", ["ibug_38", "ibug_40"], ["more open right eye", "narrower right eye"]),
    length("nose", "nose height", "from the nasion to the subnasale", ["ibug_27", "ibug_33"], ["longer nose", "shorter nose"]),
    length("nose", "nose width", "from ala to ala", ["alare right", "alare left"], ["wider nose", "narrower nose"]),
    length("mouth", "mouth width", "from corner to corner", ["ibug_48", "ibug_54"], ["wider mouth", "narrower mouth"]),
    length("mouth", "lip height", "from the upper to the lower edge of the lips", ["ibug_51", "ibug_57"], ["fuller lips", "thinner lips"]),
    length("mouth", "upper lip height", "from the subnasale to the edge of the lip", ["ibug_33", "ibug_51"], ["longer upper lip", "shorter upper lip"]),
    length("chin", "chin height", "from the lower edge of the lips to the menton", ["ibug_57", "ibug_08"], ["higher chin", "lower chin"]),
];

/// The measures on a template's landmarks.
///
/// # Errors
/// When the template lacks a landmark that a measure needs.
pub fn measures(template: &Template) -> FitResult<Vec<Measure>> {
    let index = |name: &str| {
        let found = template.landmarks.iter().position(|l| l.name == name);
        found
            .map(|i| i as u32)
            .ok_or_else(|| FitError::Input(format!("the template has no landmark called {name:?}")))
    };
    MEASURES
        .iter()
        .map(|m| {
            Ok(Measure {
                name: m.name.into(),
                description: m.description.into(),
                from: index(m.ends[0])?,
                to: index(m.ends[1])?,
            })
        })
        .collect()
}
