//! What hangs over a face from above, hair, or, upside down, a mask: where it ends. Its lights have the tone of skin, so that
//! no single place tells.

use std::collections::BTreeMap;

use glam::Vec3;

/// Columns are so wide, mm.
const COLUMN: f32 = 6.0;
/// All is covered above where for so many mm more than this part is.
pub(super) const BELOW: f32 = 10.0;
const SHARE: f64 = 0.6;

/// Where it hangs: the lowest of it in each column.
pub(super) struct Curtains {
    lowest: BTreeMap<i32, f32>,
}

impl Curtains {
    /// Of places on the mean head, and whether each is covered.
    pub fn new(places: impl Iterator<Item = (Vec3, bool)>) -> Self {
        let mut columns = BTreeMap::<i32, Vec<(f32, bool)>>::new();
        for (at, is_covered) in places {
            columns
                .entry(Self::column(at))
                .or_default()
                .push((at.y, is_covered));
        }
        let lowest = columns.iter().filter_map(|(&column, all)| {
            let covered = |y: f32| {
                let above = all.iter().filter(|p| (0.0..BELOW).contains(&(p.0 - y)));
                let (own, count) = above.fold((0, 0), |(h, n), p| (h + u32::from(p.1), n + 1));
                f64::from(own) > SHARE * f64::from(count)
            };
            let begins = all.iter().filter(|p| p.1 && covered(p.0)).map(|p| p.0);
            Some((column, begins.min_by(f32::total_cmp)?))
        });
        Self {
            lowest: lowest.collect(),
        }
    }

    /// Where it ends in the column of a place.
    pub fn lowest(&self, at: Vec3) -> Option<f32> {
        self.lowest.get(&Self::column(at)).copied()
    }

    fn column(at: Vec3) -> i32 {
        (at.x / COLUMN).floor() as i32
    }

    /// Whether a place is behind it.
    pub fn cover(&self, at: Vec3) -> bool {
        self.lowest(at).is_some_and(|lowest| at.y >= lowest)
    }
}
