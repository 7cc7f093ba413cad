//! Scans in units of their own: the size of a face is found with it.

use glam::DVec3;

use super::{Detection, Detector};
use crate::fit::head::template::Template;
use crate::fit::scan::{Placement, Scan, Unit, extent};
use crate::fit::{FitError, FitResult};

/// How large scans of heads are, mm: with the neck, with shoulders, the face alone, busts. A face is
/// found within some 30 % of its size.
const SIZES: [f64; 5] = [300.0, 420.0, 210.0, 600.0, 850.0];

/// Adults' faces are within this of the average: in units of its own a scan seldom is so near to inches.
const ADULT: f64 = 1.15;

/// A size within this of one that was tried was tried with it.
const TRIED: f64 = 1.2;

impl Detector {
    /// Finds the landmarks of the detector's template on a scan.
    ///
    /// Where no face is found, it is looked for on the scan turned inside out: what surrounds a face may have
    /// told its reader the wrong side. Where that finds it, the triangles of the scan stay so.
    ///
    /// Where the scan's unit was guessed and no face is found, it may be in another unit, or in one of its own, as
    /// what a camera alone has made: then it is taken to be as large as several kinds of scans are, and where
    /// a face is found, the unit is the one by which that is a person's, or of average size. Scale and notes of the
    /// scan follow, also where there is more than one face.
    ///
    /// # Errors
    /// When there is no face on the scan.
    pub fn find_on(&self, scan: &mut Scan, template: &Template) -> FitResult<Detection> {
        let found = self.find_in_any_unit(scan, template)?;
        if !found.others.is_empty() {
            let apart: Vec<String> = found.others.iter().map(|d| format!("{d:.0}")).collect();
            scan.notes.push(format!(
                "face: one of {}, the likeliest; noses of others are {} mm from its: cut the scan to have another",
                found.others.len() + 1,
                apart.join(", ")
            ));
        }
        Ok(found)
    }

    fn find_in_any_unit(&self, scan: &mut Scan, template: &Template) -> FitResult<Detection> {
        let measured = |unit: &Unit| unit.millimetres() == scan.scale;
        let own = scan.unit_guessed && !Unit::ALL.iter().any(measured);
        let first = match self.find(&scan.positions, &scan.triangles) {
            Ok(found) if own => return Ok(sized(found, scan, template)),
            Ok(found) => return Ok(found),
            Err(error) => error,
        };
        scan.turn_inside_out();
        if let Ok(found) = self.find(&scan.positions, &scan.triangles) {
            scan.say_turned_by_face();
            return Ok(match own {
                true => sized(found, scan, template),
                false => found,
            });
        }
        scan.turn_inside_out();
        if !scan.unit_guessed {
            return Err(FitError::file(&scan.path, first));
        }
        let (guessed, taken) = (scan.scale, extent(&scan.positions));
        for size in SIZES {
            if (size / taken).ln().abs() < f64::ln(TRIED) {
                continue;
            }
            scan.rescale(guessed * size / taken);
            if let Ok(found) = self.find(&scan.positions, &scan.triangles) {
                return Ok(sized(found, scan, template));
            }
        }
        scan.rescale(guessed);
        Err(FitError::file(&scan.path, first))
    }
}

/// Takes the unit of a scan in which the face on it is an adult's, of average size where there is none.
fn sized(mut found: Detection, scan: &mut Scan, template: &Template) -> Detection {
    let placed: Vec<(usize, DVec3)> = found.points.iter().copied().enumerate().collect();
    let Some(placement) = Placement::of(&placed, template, false) else {
        return found;
    };
    let average = scan.scale / placement.scale;
    let nearest = Unit::nearest(average);
    let unit = match (average / nearest.millimetres()).ln().abs() < f64::ln(ADULT) {
        true => nearest,
        false => Unit::Own(average),
    };
    let by = unit.millimetres() / scan.scale;
    found.points.iter_mut().for_each(|p| *p *= by);
    let lengths = found.errors.iter_mut().chain(&mut found.others);
    lengths.for_each(|length| *length *= by);
    scan.rescale(unit.millimetres());
    let why = match unit {
        Unit::Own(_) => "because there then is a face of average size",
        _ => "because there then is a face",
    };
    scan.say_unit(unit, why);
    found
}
