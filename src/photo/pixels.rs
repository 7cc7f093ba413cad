//! Means of a photo's pixels over squares, in linear light.

use glam::{DVec2, DVec3};

use super::light::Image;

/// Sums of a photo's light over what is above and to the left of each pixel's corner, so that the
/// mean over a square of any size, between pixels, too, costs the same (Crow 1984, "Summed-area
/// tables for texture mapping").
pub(super) struct Pixels {
    /// The corner of what is covered, px.
    low: DVec2,
    /// How many columns and rows there are, of cells.
    width: usize,
    height: usize,
    /// How many px a cell is wide and high.
    cell: f64,
    /// Row by row, one more of each than cells.
    sums: Vec<DVec3>,
}

/// The mean over a square and how it changes as the square moves, a px.
pub(super) struct Patch {
    pub light: DVec3,
    pub right: DVec3,
    pub down: DVec3,
}

impl Pixels {
    /// Of a part of an image, from one corner to another (px); so many px become one cell that
    /// there are at most `most` along either side. `None` when the part is not in the image.
    pub fn new(image: &Image, low: DVec2, high: DVec2, most: usize) -> Option<Self> {
        let [width, height] = image.size();
        let size = DVec2::new(width as f64, height as f64);
        let (low, high) = (low.floor().max(DVec2::ZERO), high.ceil().min(size));
        let extent = high - low;
        if !(extent.min_element() >= 1.0) {
            return None;
        }
        let cell = (extent.max_element() / most as f64).ceil().max(1.0) as usize;
        let first = low.as_usizevec2();
        // What does not fill a cell at the end is left out.
        let width = extent.x as usize / cell;
        let height = extent.y as usize / cell;
        if width == 0 || height == 0 {
            return None;
        }
        let mut sums = vec![DVec3::ZERO; (width + 1) * (height + 1)];
        let part = 1.0 / (cell * cell) as f64;
        for y in 0..height {
            let mut row = DVec3::ZERO;
            for x in 0..width {
                for inner in 0..cell {
                    let from = [first.x + x * cell, first.y + y * cell + inner];
                    row += image.sum(from, cell) * part;
                }
                sums[(y + 1) * (width + 1) + x + 1] = sums[y * (width + 1) + x + 1] + row;
            }
        }
        Some(Self {
            low,
            width,
            height,
            cell: cell as f64,
            sums,
        })
    }

    /// The sum up to a point, in cells.
    fn sum(&self, x: f64, y: f64) -> DVec3 {
        let (left, top) = (x as usize, y as usize);
        let (right, bottom) = ((left + 1).min(self.width), (top + 1).min(self.height));
        let at = |x: usize, y: usize| self.sums[y * (self.width + 1) + x];
        let (u, v) = (x - left as f64, y - top as f64);
        at(left, top).lerp(at(right, top), u).lerp(at(left, bottom).lerp(at(right, bottom), u), v)
    }

    /// The square whose sides are `half` px, at least half a pixel, from its middle; `None` when
    /// it is not in the part.
    pub fn patch(&self, middle: DVec2, half: f64) -> Option<Patch> {
        let p = (middle - self.low) / self.cell;
        let half = (half / self.cell).max(0.5);
        let (low, high) = (p - half, p + half);
        let inside = low.min_element() >= 0.0
            && high.x <= self.width as f64
            && high.y <= self.height as f64;
        if !inside {
            return None;
        }
        // Between whole cells sums are bilinear: what a square covers of a cell counts in part, and
        // the mean's slope is the difference of the sides' means.
        let area = 4.0 * half * half;
        let strip = |a: DVec2, b: DVec2| {
            self.sum(b.x, b.y) - self.sum(a.x, b.y) - self.sum(b.x, a.y) + self.sum(a.x, a.y)
        };
        let light = strip(low, high) / area;
        let nudge = 1e-3;
        let slope = |by: DVec2| {
            let most = DVec2::new(self.width as f64, self.height as f64);
            let ahead = strip((low + by).max(DVec2::ZERO), (high + by).min(most));
            let behind = strip((low - by).max(DVec2::ZERO), (high - by).min(most));
            (ahead - behind) / (area * 2.0 * nudge * self.cell)
        };
        Some(Patch {
            light,
            right: slope(DVec2::X * nudge),
            down: slope(DVec2::Y * nudge),
        })
    }
}
