//! Marks of points, which differ by shape, and names beside points.

use super::canvas::{Canvas, DrawError, LINE, Text};
use super::palette::{Color, PAPER};

/// Half the size of a mark.
const HALF: i32 = 5;

/// Draws the mark of series `index`, filled or as an outline.
pub(crate) fn mark(
    canvas: &Canvas<'_>,
    index: usize,
    (x, y): (i32, i32),
    color: Color,
    filled: bool,
) -> Result<(), DrawError> {
    let corners: &[(i32, i32)] = match index % 5 {
        0 => {
            if filled {
                return canvas.dot((x, y), HALF, color);
            }
            canvas.dot((x, y), HALF, PAPER)?;
            return canvas.ring((x, y), HALF, color, 2);
        }
        1 => &[(-1, -1), (1, -1), (1, 1), (-1, 1)],
        2 => &[(0, -1), (1, 1), (-1, 1)],
        3 => &[(0, -1), (1, 0), (0, 1), (-1, 0)],
        _ => &[(-1, -1), (1, -1), (0, 1)],
    };
    let size = if index % 5 == 1 { HALF - 1 } else { HALF + 1 };
    let mut points: Vec<(i32, i32)> = corners.iter().map(|(dx, dy)| (x + dx * size, y + dy * size)).collect();
    canvas.polygon(points.clone(), if filled { color } else { PAPER })?;
    points.extend(points.first().copied());
    canvas.line(points, color, 2)
}

/// Draws the interval of a point, horizontally or vertically, with its ends.
pub(crate) fn whisker(
    canvas: &Canvas<'_>,
    (from, to): ((i32, i32), (i32, i32)),
    color: Color,
) -> Result<(), DrawError> {
    canvas.line(vec![from, to], color, 1)?;
    let (across, along) = if from.1 == to.1 { (0, HALF - 2) } else { (HALF - 2, 0) };
    [from, to]
        .into_iter()
        .try_for_each(|(x, y)| canvas.line(vec![(x - across, y - along), (x + across, y + along)], color, 1))
}

/// Places names beside points so that they do not overlap.
#[derive(Default)]
pub(crate) struct Names {
    /// Opposite corners of the occupied rectangles.
    taken: Vec<((i32, i32), (i32, i32))>,
}

impl Names {
    /// Reserves the place of a point's mark.
    pub(crate) fn point(&mut self, (x, y): (i32, i32)) {
        self.taken.push(((x - HALF, y - HALF), (x + HALF, y + HALF)));
    }

    /// Reserves the rectangle between two corners.
    pub(crate) fn keep(&mut self, (from, to): ((i32, i32), (i32, i32))) {
        self.taken.push(((from.0.min(to.0), from.1.min(to.1)), (from.0.max(to.0), from.1.max(to.1))));
    }

    /// Writes a name beside the point at `at`: to its right, to its left, above or below; further away if these
    /// places are taken.
    pub(crate) fn write(&mut self, canvas: &Canvas<'_>, name: &str, at: (i32, i32)) -> Result<(), DrawError> {
        let look = Text::NOTE;
        let width = look.width(name);
        let rows = [0, -1, 1, -2, 2, -3, 3].map(|row| row * (LINE - 5));
        let places = rows.into_iter().flat_map(|dy| [(HALF + 5, dy), (-HALF - 5 - width, dy), (-width / 2, dy)]);
        let free = |&(dx, dy): &(i32, i32)| {
            let (left, top) = (at.0 + dx, at.1 + dy - 7);
            let is_inside = left >= 0 && left + width <= canvas.width() && top >= 0;
            let clear =
                |&((l, t), (r, b)): &((i32, i32), (i32, i32))| left + width < l || left > r || top + 14 < t || top > b;
            is_inside && self.taken.iter().all(clear)
        };
        let (dx, dy) = places.into_iter().find(free).unwrap_or((HALF + 5, 0));
        let (left, y) = (at.0 + dx, at.1 + dy);
        self.taken.push(((left, y - 7), (left + width, y + 7)));
        canvas.text(name, (left, y), look)
    }
}
