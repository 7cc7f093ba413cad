//! Scans in units of their own: the size of a face is found with it.

use glam::DVec3;

use super::{Detection, Detector};
use crate::fit::head::template::Template;
use crate::fit::scan::{Placement, Scan, Unit, extent};
use crate::fit::{FitError, FitResult};

/// How large scans of heads are, mm: with the neck, with shoulders, the face alone, busts. A face is
/// found within some 30 % of its size.
const SIZES: [f64; 5] = [300.0, 420.0, 210.0, 600.0, 850.0];

/// A size within this of one that was tried was tried with it.
const TRIED: f64 = 1.2;

impl Detector {
    /// Finds the landmarks of the detector's template on a scan.
    ///
    /// Where the scan's unit was guessed and no face is found, it may be in units of its own, as what a
    /// camera alone has made: then it is taken to be as large as several kinds of scans are, and where
    /// a face is found, the unit is the one in which that is of average size. Scale and notes of the
    /// scan follow.
    ///
    /// # Errors
    /// When there is no face on the scan.
    pub fn find_on(&self, scan: &mut Scan, template: &Template) -> FitResult<Detection> {
        let measured = |unit: &Unit| unit.millimetres() == scan.scale;
        let own = scan.unit_guessed && !Unit::ALL.iter().any(measured);
        let first = match self.find(&scan.positions, &scan.triangles) {
            Err(error) if scan.unit_guessed => error,
            Ok(found) if own => return Ok(average(found, scan, template)),
            found => return found.map_err(|e| FitError::file(&scan.path, e)),
        };
        let (guessed, taken) = (scan.scale, extent(&scan.positions));
        for size in SIZES {
            if (size / taken).ln().abs() < f64::ln(TRIED) {
                continue;
            }
            scan.rescale(guessed * size / taken);
            if let Ok(found) = self.find(&scan.positions, &scan.triangles) {
                return Ok(average(found, scan, template));
            }
        }
        scan.rescale(guessed);
        Err(FitError::file(&scan.path, first))
    }
}

/// Takes the unit of a scan in which the face on it is of average size.
fn average(mut found: Detection, scan: &mut Scan, template: &Template) -> Detection {
    let placed: Vec<(usize, DVec3)> = found.points.iter().copied().enumerate().collect();
    if let Some(placement) = Placement::of(&placed, template, false) {
        found.points.iter_mut().for_each(|p| *p /= placement.scale);
        found.errors.iter_mut().for_each(|e| *e /= placement.scale);
        scan.rescale(scan.scale / placement.scale);
    }
    scan.say_unit(
        Unit::Own(scan.scale),
        "because there then is a face of average size",
    );
    found
}
