//! Means of a photo's brightness over squares.

use glam::DVec2;

use super::light::Image;

/// The part of the photo that is read has at most so many cells along either side: of faces larger
/// than that, several pixels make one.
const MOST: usize = 1024;

/// Sums of a photo's linear light over what is above and to the left of each pixel's corner, so that
/// the mean over a square of any size, between pixels, too, costs the same (Crow 1984, "Summed-area
/// tables for texture mapping").
pub(super) struct Pixels {
    /// The upper left corner of what is covered, px.
    low: DVec2,
    /// Columns and rows of cells.
    width: usize,
    height: usize,
    /// How many px a cell is wide and high.
    cell: f64,
    sums: Table,
    /// Sums of what is background; `None` when nothing is.
    background: Option<Table>,
}

/// Sums of cells above and to the left of each corner.
struct Table {
    width: usize,
    height: usize,
    /// Row by row, one more of each than there are cells.
    sums: Vec<f64>,
}

impl Table {
    fn new([width, height]: [usize; 2], cell: impl Fn(usize, usize) -> f64) -> Self {
        let mut sums = vec![0.0; (width + 1) * (height + 1)];
        for y in 0..height {
            let mut row = 0.0;
            for x in 0..width {
                row += cell(x, y);
                sums[(y + 1) * (width + 1) + x + 1] = sums[y * (width + 1) + x + 1] + row;
            }
        }
        Self {
            width,
            height,
            sums,
        }
    }

    /// The sum up to a point that is inside, in cells.
    fn sum(&self, x: f64, y: f64) -> f64 {
        let (left, top) = (x as usize, y as usize);
        let (right, bottom) = ((left + 1).min(self.width), (top + 1).min(self.height));
        let at = |x: usize, y: usize| self.sums[y * (self.width + 1) + x];
        let (u, v) = (x - left as f64, y - top as f64);
        let above = at(left, top) * (1.0 - u) + at(right, top) * u;
        let below = at(left, bottom) * (1.0 - u) + at(right, bottom) * u;
        above * (1.0 - v) + below * v
    }

    /// The mean over a rectangle that is inside, in cells.
    fn mean(&self, low: DVec2, high: DVec2) -> f64 {
        let sum = self.sum(high.x, high.y) - self.sum(low.x, high.y) - self.sum(high.x, low.y)
            + self.sum(low.x, low.y);
        sum / ((high.x - low.x) * (high.y - low.y))
    }
}

impl Pixels {
    /// Of the part of an image between two corners, px; `None` when it is not in the image.
    pub fn new(image: &Image, [low, high]: [DVec2; 2]) -> Option<Self> {
        let size = DVec2::new(image.width as f64, image.height as f64);
        let (low, high) = (low.floor().max(DVec2::ZERO), high.ceil().min(size));
        let extent = high - low;
        if !(extent.min_element() >= 1.0) {
            return None;
        }
        let cell = (extent.max_element() / MOST as f64).ceil() as usize;
        let first = low.as_usizevec2();
        // What does not fill a cell at the end is left out.
        let cells = [extent.x as usize / cell, extent.y as usize / cell];
        let part = 1.0 / (cell * cell) as f64;
        let light = |x: usize, y: usize| -> f64 {
            let rows = 0..cell;
            rows.map(|row| image.brightness([first.x + x * cell, first.y + y * cell + row], cell))
                .sum::<f64>()
                * part
        };
        let background = |x: usize, y: usize| -> f64 {
            let places = (0..cell).flat_map(|row| (0..cell).map(move |column| [column, row]));
            let pixels = places.map(|[i, j]| [first.x + x * cell + i, first.y + y * cell + j]);
            pixels.filter(|&p| !image.is_person(p)).count() as f64
        };
        (cells[0] > 0 && cells[1] > 0).then(|| {
            let background = Table::new(cells, background);
            let any = background.sums.last().is_some_and(|&all| all > 0.0);
            Self {
                background: any.then_some(background),
                ..Self::of(low, cell as f64, cells, light)
            }
        })
    }

    /// Of cells with a brightness each.
    pub fn of(
        low: DVec2,
        cell: f64,
        [width, height]: [usize; 2],
        light: impl Fn(usize, usize) -> f64,
    ) -> Self {
        Self {
            low,
            width,
            height,
            cell,
            sums: Table::new([width, height], light),
            background: None,
        }
    }

    /// The corners, in cells, of the square around a point (px) whose sides are twice `half` px, and
    /// at least a cell; `None` when it is not inside, or some of it is background.
    fn square(&self, middle: DVec2, half: f64) -> Option<[DVec2; 2]> {
        let p = (middle - self.low) / self.cell;
        let half = (half / self.cell).max(0.5);
        let (low, high) = (p - half, p + half);
        let most = DVec2::new(self.width as f64, self.height as f64);
        let is_inside = low.min_element() >= 0.0 && high.cmple(most).all();
        let is_person = || {
            let background = self.background.as_ref();
            // Sums of whole numbers are exact, those between them are not.
            background.is_none_or(|background| background.mean(low, high) < 1e-6)
        };
        (is_inside && is_person()).then_some([low, high])
    }

    /// The mean brightness of a square.
    pub fn light(&self, middle: DVec2, half: f64) -> Option<f64> {
        let [low, high] = self.square(middle, half)?;
        Some(self.sums.mean(low, high))
    }

    /// How the brightness changes across a square, a px to the right and down: from the mean of one
    /// half of it to that of the other.
    pub fn slope(&self, middle: DVec2, half: f64) -> Option<DVec2> {
        // Halves of less than a cell would be the same cell's.
        let [low, high] = self.square(middle, half.max(self.cell))?;
        let middle = (low + high) / 2.0;
        let mean = |low: DVec2, high: DVec2| self.sums.mean(low, high);
        let right =
            mean(DVec2::new(middle.x, low.y), high) - mean(low, DVec2::new(middle.x, high.y));
        let down =
            mean(DVec2::new(low.x, middle.y), high) - mean(low, DVec2::new(high.x, middle.y));
        Some(DVec2::new(right, down) / ((high.x - low.x) / 2.0 * self.cell))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ramp_is_read_exactly_between_pixels() {
        let ramp = |p: DVec2| 0.2 + 0.01 * p.x - 0.003 * p.y;
        let low = DVec2::new(10.0, 20.0);
        for cell in [1.0, 3.0] {
            let pixels = Pixels::of(low, cell, [40, 30], |x, y| {
                ramp(low + (DVec2::new(x as f64, y as f64) + 0.5) * cell)
            });
            let p = low + DVec2::new(14.3, 11.7) * cell;
            for half in [0.0, 0.8, 2.5] {
                // Of half cells the cell's own brightness is all that is known.
                let light = pixels.light(p, half * cell).unwrap();
                assert!((light - ramp(p)).abs() < 0.01 * cell, "{light}");
            }
            let whole = low + DVec2::new(14.0, 11.0) * cell;
            let light = pixels.light(whole, 2.0 * cell).unwrap();
            assert!((light - ramp(whole)).abs() < 1e-12);
            let slope = pixels.slope(whole, 2.0 * cell).unwrap();
            assert!(slope.distance(DVec2::new(0.01, -0.003)) < 1e-12);
            assert!(pixels.light(low, 1.0).is_none());
        }
    }

    #[test]
    fn large_photos_are_read_in_cells() {
        let (width, height) = (2600, 1300);
        let rgba: Vec<u8> = (0..width * height)
            .flat_map(|i| [(i % width / 11) as u8, 128, 0, 255])
            .collect();
        let image = Image::new(width, height, &rgba).unwrap();
        let corners = [DVec2::ZERO, DVec2::new(2600.0, 1300.0)];
        let pixels = Pixels::new(&image, corners).unwrap();
        assert_eq!(pixels.cell, 3.0);
        assert!(pixels.width <= MOST);
        let light = pixels.light(DVec2::new(2000.5, 600.0), 4.5).unwrap();
        let expected = image.brightness([2000, 600], 1);
        assert!((light - expected).abs() < 0.01, "{light} {expected}");
        assert!(Pixels::new(&image, [corners[1], corners[1] * 2.0]).is_none());
    }

    #[test]
    fn nothing_is_read_of_the_background() {
        let (width, height) = (60, 40);
        let rgba: Vec<u8> = (0..width * height)
            .flat_map(|i| [90, 90, 90, if i % width < 30 { 255 } else { 127 }])
            .collect();
        let image = Image::new(width, height, &rgba).unwrap();
        let pixels = Pixels::new(&image, [DVec2::ZERO, DVec2::new(60.0, 40.0)]).unwrap();
        for (x, is_read) in [(20.0, true), (28.0, true), (28.1, false), (45.0, false)] {
            let middle = DVec2::new(x, 20.0);
            assert_eq!(pixels.light(middle, 2.0).is_some(), is_read, "{x}");
            assert_eq!(pixels.slope(middle, 2.0).is_some(), is_read, "{x}");
            assert_eq!(image.at(middle).is_some(), x < 30.0, "{x}");
        }
    }
}
