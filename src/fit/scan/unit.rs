//! Units of length: asked for, or guessed and said.

use std::fmt;
use std::ops::RangeInclusive;
use std::str::FromStr;

/// A unit of length of a scan's file.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Unit {
    /// Millimetres.
    Millimetre,
    /// Centimetres.
    Centimetre,
    /// Inches.
    Inch,
    /// Metres.
    Metre,
    /// None of these, but so many millimetres: a scanner without a scale has units of its own.
    Own(f64),
}

impl Unit {
    /// All units that people measure in, from the smallest.
    pub const ALL: [Unit; 4] = [Unit::Millimetre, Unit::Centimetre, Unit::Inch, Unit::Metre];

    /// Millimetres in one.
    pub fn millimetres(self) -> f64 {
        match self {
            Unit::Millimetre => 1.0,
            Unit::Centimetre => 10.0,
            Unit::Inch => 25.4,
            Unit::Metre => 1000.0,
            Unit::Own(millimetres) => millimetres,
        }
    }

    /// The unit in which a mesh is most likely a head, by the longest side of its box: a face
    /// alone has some 200 mm, a bust 600, and powers of ten lie far enough apart. Inches are not
    /// guessed from this: ten may be inches of a head or centimetres of half a face.
    pub(super) fn of_extent(extent: f64) -> Unit {
        let likely = [Unit::Millimetre, Unit::Centimetre, Unit::Metre];
        let unit = nearest(likely, TYPICAL / extent);
        let between = likely[0].millimetres()..likely[2].millimetres();
        match EXTENTS.contains(&(extent * unit.millimetres())) {
            // Between two of them there are units of nobody's.
            false if between.contains(&(TYPICAL / extent)) => Unit::Own(TYPICAL / extent),
            _ => unit,
        }
    }

    /// That of [`Unit::ALL`] which is nearest to so many millimetres.
    pub(in crate::fit) fn nearest(millimetres: f64) -> Unit {
        nearest(Self::ALL, millimetres)
    }

    /// The unit in which landmarks are most likely a face's, by the millimetres that one unit
    /// must have for the generic head to fit them. Of [`Unit::ALL`], unless the face would then have a
    /// size that no person has, or in inches, in which hardly anybody scans, a child's.
    pub(super) fn of_scale(scale: f64) -> Unit {
        let unit = Self::nearest(scale);
        let most = match unit {
            Unit::Inch => LARGEST_IN_INCHES,
            _ => LARGEST_FACE,
        };
        match (scale / unit.millimetres()).ln().abs() <= f64::ln(most) {
            true => unit,
            false => Unit::Own(scale),
        }
    }
}

/// Between this and its inverse lie the sizes of all people's faces beside the generic one's.
pub(super) const LARGEST_FACE: f64 = 1.55;
/// And so those of adults, with room.
const LARGEST_IN_INCHES: f64 = 1.35;

/// What no head, face or person is smaller or larger than, mm.
pub(super) const EXTENTS: RangeInclusive<f64> = 60.0..=2500.0;

/// A head with its neck is about this long, mm.
const TYPICAL: f64 = 300.0;

fn nearest<const N: usize>(units: [Unit; N], scale: f64) -> Unit {
    let far = |unit: Unit| (scale / unit.millimetres()).ln().abs();
    units
        .into_iter()
        .min_by(|&a, &b| far(a).total_cmp(&far(b)))
        .unwrap_or(Unit::Millimetre)
}

impl fmt::Display for Unit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Unit::Millimetre => "millimetres",
            Unit::Centimetre => "centimetres",
            Unit::Inch => "inches",
            Unit::Metre => "metres",
            Unit::Own(millimetres) => return write!(f, "units of {millimetres:.4} mm"),
        })
    }
}

impl FromStr for Unit {
    type Err = String;

    fn from_str(name: &str) -> Result<Self, String> {
        Ok(match name {
            "mm" => Unit::Millimetre,
            "cm" => Unit::Centimetre,
            "inch" | "in" => Unit::Inch,
            "m" => Unit::Metre,
            _ => match name.parse::<f64>() {
                Ok(millimetres) if millimetres.is_normal() && millimetres > 0.0 => {
                    Unit::Own(millimetres)
                }
                _ => {
                    return Err(format!(
                        "`{name}` is none of mm, cm, inch, m, and no number of millimetres"
                    ));
                }
            },
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn faces_heads_and_busts_are_told_in_three_units() {
        // Half a face to a bust with arms, mm.
        for size in [120.0, 200.0, 260.0, 450.0, 900.0] {
            for unit in [Unit::Millimetre, Unit::Centimetre, Unit::Metre] {
                assert_eq!(Unit::of_extent(size / unit.millimetres()), unit);
            }
        }
        assert_eq!(Unit::of_extent(4.0), Unit::Own(75.0));
        // By landmarks inches are told too: people's faces differ by less than a third.
        for factor in [0.75, 1.0, 1.3] {
            for unit in Unit::ALL {
                assert_eq!(Unit::of_scale(factor * unit.millimetres()), unit);
            }
        }
        // And units that are nobody's, the second last an inch of a baby.
        for scale in [0.2, 4.0, 16.5, 35.7, 200.0] {
            assert_eq!(Unit::of_scale(scale), Unit::Own(scale));
        }
    }

    #[test]
    fn units_are_named_or_measured() {
        for (name, unit) in [
            ("mm", Unit::Millimetre),
            ("in", Unit::Inch),
            ("14.3", Unit::Own(14.3)),
        ] {
            assert_eq!(name.parse(), Ok(unit));
        }
        for name in ["", "ell", "0", "-2", "NaN", "inf"] {
            assert!(name.parse::<Unit>().is_err(), "{name}");
        }
    }
}
