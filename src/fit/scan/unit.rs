//! Units of length: asked for, or guessed and said.

use std::fmt;
use std::str::FromStr;

/// A unit of length of a scan's file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Unit {
    /// Millimetres.
    Millimetre,
    /// Centimetres.
    Centimetre,
    /// Inches.
    Inch,
    /// Metres.
    Metre,
}

impl Unit {
    /// All units, from the smallest.
    pub const ALL: [Unit; 4] = [Unit::Millimetre, Unit::Centimetre, Unit::Inch, Unit::Metre];

    /// Millimetres in one.
    pub fn millimetres(self) -> f64 {
        match self {
            Unit::Millimetre => 1.0,
            Unit::Centimetre => 10.0,
            Unit::Inch => 25.4,
            Unit::Metre => 1000.0,
        }
    }

    /// The unit in which a mesh is most likely a head, by the longest side of its box: a face
    /// alone has some 200 mm, a bust 600, and powers of ten lie far enough apart. Inches are not
    /// guessed from this: ten may be inches of a head or centimetres of half a face.
    pub(super) fn of_extent(extent: f64) -> Unit {
        nearest(
            [Unit::Millimetre, Unit::Centimetre, Unit::Metre],
            TYPICAL / extent,
        )
    }

    /// The unit in which landmarks are most likely a face's, by the millimetres that one unit
    /// must have for the generic head to fit them.
    pub(super) fn of_scale(scale: f64) -> Unit {
        nearest(Self::ALL, scale)
    }
}

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
            _ => return Err(format!("`{name}` is none of mm, cm, inch, m")),
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
        // By landmarks inches are told too: people's faces differ by less than a third.
        for factor in [0.75, 1.0, 1.3] {
            for unit in Unit::ALL {
                assert_eq!(Unit::of_scale(factor * unit.millimetres()), unit);
            }
        }
    }
}
