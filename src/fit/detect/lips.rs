//! Where lips meet on a scan. What is skin on both sides of a line tells a fit little of where the line is: it slides.

use glam::DVec3;

use crate::fit::head::template::Template;

/// Landmarks on the lips, by their places among the template's: of three columns the upper edge of the upper lip, its lower
/// edge, the upper edge of the lower lip, and its lower edge.
pub struct Lips([[usize; 4]; 3]);

/// How far apart places are at which a column is looked at, mm.
const STEP: f64 = 0.25;
/// A line between lips is a valley at least so deep, mm; one that is deeper is an open mouth.
const VALLEY: [f64; 2] = [0.3, 6.0];
/// How far from the line the edges of shut lips are, mm.
const EDGE: f64 = 0.3;

impl Lips {
    /// Nothing when the template lacks one of them.
    pub fn new(template: &Template) -> Option<Self> {
        let place = |name: &str| template.landmarks.iter().position(|l| l.name == name);
        let columns = [
            ["ibug_50", "ibug_61", "ibug_67", "ibug_58"],
            ["ibug_51", "ibug_62", "ibug_66", "ibug_57"],
            ["ibug_52", "ibug_63", "ibug_65", "ibug_56"],
        ];
        let mut places = [[0; 4]; 3];
        for (places, column) in places.iter_mut().zip(columns) {
            for (own, name) in places.iter_mut().zip(column) {
                *own = place(name)?;
            }
        }
        Some(Self(places))
    }

    /// Puts the edges of shut lips to where they meet. `front` and `up` are the face's axes, `seen` is the point of the scan
    /// that is seen from the front through a point, if there is any. Of open mouths, and where no line is seen, nothing changes;
    /// else these are the points that were put, with an error of [`LINE_ERROR`].
    pub fn shut(
        &self,
        points: &mut [DVec3],
        front: DVec3,
        up: DVec3,
        seen: impl Fn(DVec3) -> Option<DVec3>,
    ) -> Option<[usize; 6]> {
        let met = self.0.map(|[above, upper, lower, below]| {
            let at = |i: usize| points[i];
            let middle = (at(upper) + at(lower)) / 2.0;
            let ends = [below, above].map(|i| (at(i) - middle).dot(up));
            let count = ((ends[1] - ends[0]) / STEP).floor();
            if !(8.0..=400.0).contains(&count) {
                return None;
            }
            let height = |i: usize| ends[0] + STEP * i as f64;
            let column: Option<Vec<DVec3>> = (0..=count as usize)
                .map(|i| seen(middle + up * height(i)))
                .collect();
            let line = valley(&column?.iter().map(|p| p.dot(front)).collect::<Vec<_>>())?;
            let on = |off: f64| seen(middle + up * (height(line) + off));
            Some([on(EDGE)?, on(-EDGE)?])
        });
        // A mouth that is open anywhere is open.
        let [Some(a), Some(b), Some(c)] = met else {
            return None;
        };
        let mut put = [0; 6];
        let edges = put.as_chunks_mut().0;
        for ((edges, &[_, upper, lower, _]), [over, under]) in
            edges.iter_mut().zip(&self.0).zip([a, b, c])
        {
            *edges = [upper, lower];
            points[upper] = over;
            points[lower] = under;
        }
        Some(put)
    }
}

/// The error of a place on the line between lips, mm: across it, it is seen; along it, it is where the fit has its column.
pub const LINE_ERROR: f64 = 0.7;

/// The place of the deepest valley in a row of heights (mm), if it is as deep as lips' line.
fn valley(heights: &[f64]) -> Option<usize> {
    // Scanners' noise is no valley.
    let smooth = |i: usize| {
        let near = &heights[i.saturating_sub(2)..(i + 3).min(heights.len())];
        near.iter().sum::<f64>() / near.len() as f64
    };
    let smooth: Vec<f64> = (0..heights.len()).map(smooth).collect();
    let highest = |part: &[f64]| part.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let depth = |i: usize| highest(&smooth[..i]).min(highest(&smooth[i + 1..])) - smooth[i];
    let deepest =
        (1..smooth.len().saturating_sub(1)).max_by(|&a, &b| depth(a).total_cmp(&depth(b)))?;
    (VALLEY[0]..VALLEY[1])
        .contains(&depth(deepest))
        .then_some(deepest)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two lips of a radius of 5 mm that meet at `line` mm above the middle, with a gap between them.
    fn profile(y: f64, line: f64, gap: f64) -> Option<f64> {
        let from = (y - line).abs() - gap / 2.0;
        if from < 0.0 {
            return None;
        }
        Some((25.0 - (from - 5.0).powi(2)).max(0.0).sqrt() - 2.0)
    }

    fn edges(line: f64, gap: f64, depth: f64) -> [f64; 2] {
        let lips = Lips([[0, 1, 2, 3]; 3]);
        let mut points = [9.0, 3.0, -3.0, -9.0].map(|y| DVec3::new(0.0, y, 0.0));
        let before = points;
        let put = lips.shut(&mut points, DVec3::Z, DVec3::Y, |p| {
            let z = profile(p.y, line, gap).unwrap_or(-depth);
            (z > -90.0).then_some(DVec3::new(p.x, p.y, z))
        });
        assert_eq!(put.is_some(), points != before);
        assert!(put.is_none_or(|put| put == [1, 2, 1, 2, 1, 2]));
        [points[1].y, points[2].y]
    }

    #[test]
    fn edges_of_shut_lips_are_where_they_meet() {
        for line in [-2.0, 0.0, 0.4, 2.5] {
            let [upper, lower] = edges(line, 0.0, 0.0);
            // A place is looked at every quarter of a millimetre.
            assert!((upper - line - EDGE).abs() < 0.26, "{upper} of {line}");
            assert!((lower - line + EDGE).abs() < 0.26, "{lower} of {line}");
        }
    }

    #[test]
    fn open_mouths_stay_open() {
        // Into a mouth, and through a hole.
        for depth in [20.0, 100.0] {
            assert_eq!(edges(0.0, 3.0, depth), [3.0, -3.0]);
        }
    }

    #[test]
    fn what_is_flat_has_no_line() {
        assert_eq!(valley(&[1.0; 50]), None);
        let round: Vec<f64> = (0..50).map(|i| -(f64::from(i) - 25.0).powi(2)).collect();
        assert_eq!(valley(&round), None);
        assert_eq!(valley(&[]), None);
    }
}
