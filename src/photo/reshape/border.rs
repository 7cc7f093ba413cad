//! What is read stays within the photo.
//!
//! Where a photo cuts a head off and what it shows moves away from the cut, something comes into the
//! picture that nobody took. The photo's last row would be drawn out to streaks; instead what is near
//! the cut is stretched up to it, by no more than a half.

use super::membrane::Cell;

/// What moves away from the cut by some cells is made up for within so many times as many.
const WITHIN: f32 = 6.0;

/// Changes the motion of a grid's cells, row by row, so that nothing is read from outside a photo whose
/// edges lie at `low` and `high` along x and y, in cells: the first cell's middle is at 0. Those of `still`
/// stay as they are.
pub(super) fn stay_within(
    cells: &mut [Cell],
    [columns, rows]: [usize; 2],
    [low, high]: [[f32; 2]; 2],
    still: &[bool],
) {
    let counts = [columns, rows];
    let strides = [1, columns];
    for axis in 0..2 {
        let (count, stride) = (counts[axis], strides[axis]);
        for line in 0..counts[1 - axis] {
            let first = line * strides[1 - axis];
            for (edge, inwards) in [(low[axis], 1.0), (high[axis], -1.0)] {
                if edge < 0.0 || edge > (count - 1) as f32 {
                    continue;
                }
                let near = (edge as usize).min(count - 2);
                let [a, b] = [near, near + 1].map(|i| cells[first + i * stride][axis]);
                let motion = a + (edge - near as f32) * (b - a);
                let missing = -inwards * motion;
                if missing <= 0.0 {
                    continue;
                }
                for i in 0..count {
                    let at = first + i * stride;
                    // How far inside of what is read for the edge.
                    let depth = inwards * (i as f32 + cells[at][axis] - edge) + missing;
                    let share = 1.0 - depth.max(0.0) / (WITHIN * missing);
                    if share > 0.0 && !still[at] {
                        cells[at][axis] += inwards * missing * share * share;
                    }
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE: [usize; 2] = [60, 50];

    /// All of it moves by some cells.
    fn moved(by: [f32; 2]) -> Vec<Cell> {
        vec![[by[0], by[1], 0.1, 0.2, 0.3]; SIZE[0] * SIZE[1]]
    }

    #[test]
    fn what_is_read_stays_within_and_in_order() {
        let edges = [[0.5, 0.5], [58.7, 48.2]];
        for by in [[0.0, -3.0], [0.0, 3.0], [-3.0, 0.0], [4.0, 2.0]] {
            let mut cells = moved(by);
            stay_within(&mut cells, SIZE, edges, &[false; 60 * 50]);
            for (axis, stride) in [(0, 1), (1, 60)] {
                let line: Vec<f32> = (0..SIZE[axis])
                    .map(|i| i as f32 + cells[i * stride][axis])
                    .collect();
                for (i, pair) in line.windows(2).enumerate() {
                    let rate = pair[1] - pair[0];
                    assert!(
                        rate > 0.66 && rate < 1.001,
                        "{by:?}, axis {axis}, {i}: {rate}"
                    );
                }
                let read = |at: f32| {
                    let i = at as usize;
                    line[i] + (at - i as f32) * (line[i + 1] - line[i])
                };
                assert!(read(edges[0][axis]) > edges[0][axis] - 0.1, "{by:?}");
                assert!(read(edges[1][axis]) < edges[1][axis] + 0.1, "{by:?}");
            }
            // In the middle all is as it was.
            assert_eq!(cells[25 * 60 + 30], [by[0], by[1], 0.1, 0.2, 0.3]);
        }
    }

    #[test]
    fn what_does_not_leave_the_photo_is_not_touched() {
        for (edges, by) in [
            // The photo goes on beyond the grid.
            ([[-9.0, -9.0], [90.0, 90.0]], [4.0, -7.0]),
            ([[0.5, 0.5], [58.7, 48.2]], [0.0, 0.0]),
        ] {
            let mut cells = moved(by);
            stay_within(&mut cells, SIZE, edges, &[false; 60 * 50]);
            assert_eq!(cells, moved(by));
        }
        // Nor what is still.
        let mut cells = moved([0.0, -4.0]);
        stay_within(
            &mut cells,
            SIZE,
            [[0.5, 0.5], [58.7, 48.2]],
            &[true; 60 * 50],
        );
        assert_eq!(cells, moved([0.0, -4.0]));
    }
}
