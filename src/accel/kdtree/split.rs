//! Where to split a cell: the surface area heuristic, over all planes at which the count of triangles changes, or over
//! a few evenly spaced planes.

use glam::DVec3;

use super::bounds::Bounds;

/// Relative costs of a traversal step and of a triangle test (Wald and Havran 2006).
const TRAVERSAL: f64 = 15.0;
const INTERSECTION: f64 = 20.0;
/// Factor on the cost of a split that cuts off an empty part (Wald and Havran 2006).
const EMPTY: f64 = 0.8;

/// A plane that splits a cell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Plane {
    /// The axis that the plane is perpendicular to.
    pub axis: usize,
    /// Its position.
    pub at: f32,
    /// Whether triangles that lie in the plane go to the left.
    pub flat_left: bool,
}

/// The cost of a leaf of `count` triangles.
pub(super) fn leaf_cost(count: usize) -> f64 {
    INTERSECTION * count as f64
}

/// The best plane so far.
struct Search {
    cell: Bounds,
    /// One over the cell's area.
    per_area: f64,
    /// The cell's sides.
    size: DVec3,
    best: Option<(f64, Plane)>,
}

impl Search {
    fn new(cell: Bounds) -> Self {
        let size = cell.high.as_dvec3() - cell.low.as_dvec3();
        Self { cell, per_area: 1.0 / cell.area(), size, best: None }
    }

    /// Considers a plane with `counts` triangles to the left and to the right. Of equal costs, the first plane is
    /// kept.
    ///
    /// A plane in a face of the cell separates the triangles in the face from the rest. A flat cell with such
    /// triangles, for example a wall, is cheap, because only rays that reach the wall enter it. An empty flat cell
    /// would separate nothing.
    fn consider(&mut self, plane: Plane, counts: [usize; 2]) {
        let (low, high) = (self.cell.low[plane.axis], self.cell.high[plane.axis]);
        let parting = (plane.at > low || counts[0] > 0) && (plane.at < high || counts[1] > 0);
        if !parting || low == high {
            return;
        }
        let (a, b) = (self.size[(plane.axis + 1) % 3], self.size[(plane.axis + 2) % 3]);
        let area = |length: f64| 2.0 * (a * b + (a + b) * length);
        let at = f64::from(plane.at);
        let left = area(at - f64::from(low)) * counts[0] as f64;
        let right = area(f64::from(high) - at) * counts[1] as f64;
        let cost = TRAVERSAL + INTERSECTION * self.per_area * (left + right);
        let cost = if counts.contains(&0) { EMPTY * cost } else { cost };
        if self.best.is_none_or(|(least, _)| cost < least) {
            self.best = Some((cost, plane));
        }
    }
}

/// What happens at a position of the sweep, in the order in which it counts at equal positions.
#[derive(Clone, Copy)]
enum Event {
    End,
    Flat,
    Start,
}

/// An event as a number that sorts by position, then by event.
fn key(at: f32, event: Event) -> u64 {
    // Zero has one sign here. Flipping makes the bits of negative numbers sort, below those of positive ones.
    let bits = (at + 0.0).to_bits();
    let ordered = if bits >> 31 == 1 { !bits } else { bits | 1 << 31 };
    u64::from(ordered) << 2 | event as u64
}

fn position(key: u64) -> f32 {
    let ordered = (key >> 2) as u32;
    f32::from_bits(if ordered >> 31 == 1 { ordered & !(1 << 31) } else { !ordered })
}

/// The cheapest of all planes at the faces of `boxes`, which lie in `cell`, with its cost. Sorted events, O(n log n)
/// for a cell (Wald and Havran 2006).
pub(super) fn sweep(cell: Bounds, boxes: impl ExactSizeIterator<Item = Bounds> + Clone) -> Option<(f64, Plane)> {
    let mut search = Search::new(cell);
    let mut events = Vec::with_capacity(2 * boxes.len());
    for axis in 0..3 {
        events.clear();
        for part in boxes.clone() {
            let (low, high) = (part.low[axis], part.high[axis]);
            if low == high {
                events.push(key(low, Event::Flat));
            } else {
                events.extend([key(low, Event::Start), key(high, Event::End)]);
            }
        }
        events.sort_unstable();
        let (mut left, mut right) = (0, boxes.len());
        let mut rest = events.as_slice();
        while let Some(&first) = rest.first() {
            let mut take = |event: Event| {
                let wanted = first & !3 | event as u64;
                let count = rest.iter().take_while(|&&key| key == wanted).count();
                rest = &rest[count..];
                count
            };
            let [ends, flats, starts] = [take(Event::End), take(Event::Flat), take(Event::Start)];
            let at = position(first);
            right -= ends + flats;
            search.consider(Plane { axis, at, flat_left: true }, [left + flats, right]);
            if flats > 0 {
                search.consider(Plane { axis, at, flat_left: false }, [left, flats + right]);
            }
            left += starts + flats;
        }
    }
    search.best
}

/// Number of bins on each axis; [`bins`] considers one plane fewer.
pub(super) const BINS: usize = 32;

/// The cheapest of evenly spaced planes, with its cost. It counts boxes by the bins of their starts and ends (min-max
/// binning, Shevtsov et al. 2007). O(n) for a cell.
pub(super) fn bins(cell: Bounds, boxes: impl ExactSizeIterator<Item = Bounds> + Clone) -> Option<(f64, Plane)> {
    let mut search = Search::new(cell);
    for axis in 0..3 {
        let (low, size) = (cell.low[axis], cell.high[axis] - cell.low[axis]);
        let bin = |at: f32| (((at - low) / size * BINS as f32) as usize).min(BINS - 1);
        let (mut starts, mut ends) = ([0; BINS], [0; BINS]);
        for part in boxes.clone() {
            starts[bin(part.low[axis])] += 1;
            ends[bin(part.high[axis])] += 1;
        }
        let (mut left, mut right) = (0, boxes.len());
        for index in 0..BINS - 1 {
            left += starts[index];
            right -= ends[index];
            let at = low + size * ((index + 1) as f32 / BINS as f32);
            if low < at && at < cell.high[axis] {
                search.consider(Plane { axis, at, flat_left: true }, [left, right]);
            }
        }
    }
    search.best
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    #[test]
    fn keys_sort_as_positions_do_and_give_them_back() {
        let ascending = [-1e30, -2.0, -1e-40, 0.0, 1e-40, 1.0, 3e38];
        let keys = ascending.map(|at| key(at, Event::Flat));
        assert!(keys.is_sorted());
        assert_eq!(keys.map(position), ascending);
        assert_eq!(key(-0.0, Event::End), key(0.0, Event::End));
        assert!(key(1.0, Event::End) < key(1.0, Event::Flat) && key(1.0, Event::Flat) < key(1.0, Event::Start));
    }

    fn cube(low: f32, high: f32) -> Bounds {
        Bounds { low: Vec3::splat(low), high: Vec3::splat(high) }
    }

    #[test]
    fn cuts_off_empty_space() {
        let part = Bounds { low: Vec3::ZERO, high: Vec3::new(1.0, 4.0, 4.0) };
        let (cost, plane) = sweep(cube(0.0, 4.0), std::iter::repeat_n(part, 4)).unwrap();
        assert_eq!(plane, Plane { axis: 0, at: 1.0, flat_left: true });
        // Each half has an area of 48 of 96. The bonus for an empty part is a fifth.
        assert_eq!(cost, 0.8 * (15.0 + 20.0 * 0.5 * 4.0));
    }

    #[test]
    fn flat_parts_go_to_the_cheaper_side() {
        let mut wall = cube(0.0, 4.0);
        (wall.low.x, wall.high.x) = (1.0, 1.0);
        let walls = [wall; 8];
        let (cost, plane) = sweep(cube(0.0, 4.0), walls.into_iter()).unwrap();
        assert_eq!(plane, Plane { axis: 0, at: 1.0, flat_left: true });
        assert_eq!(cost, 0.8 * (15.0 + 20.0 * (48.0 / 96.0) * 8.0));
    }

    #[test]
    fn a_wall_in_a_face_gets_a_flat_cell() {
        let mut wall = cube(0.0, 4.0);
        wall.high.x = 0.0;
        let walls = [wall; 8];
        let (cost, plane) = sweep(cube(0.0, 4.0), walls.into_iter()).unwrap();
        assert_eq!(plane, Plane { axis: 0, at: 0.0, flat_left: true });
        assert_eq!(cost, 0.8 * (15.0 + 20.0 * (32.0 / 96.0) * 8.0));
    }

    #[test]
    fn no_plane_parts_nothing() {
        let full = cube(0.0, 4.0);
        assert_eq!(sweep(full, [full; 8].into_iter()), None);
        let mut wall = full;
        wall.high.x = 0.0;
        assert_eq!(sweep(wall, [wall; 8].into_iter()), None);
    }

    #[test]
    fn bins_find_the_gap() {
        let boxes = [cube(0.0, 1.0), cube(0.0, 1.0), cube(3.0, 4.0), cube(3.0, 4.0)];
        let (_, plane) = bins(cube(0.0, 4.0), boxes.into_iter()).unwrap();
        assert!(plane.at > 1.0 && plane.at < 3.0);
    }
}
