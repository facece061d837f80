//! Items with equal boxes: obvhs builds over one item of each group. Its clustering takes quadratic time on equal
//! boxes, because ties leave one pair of mutual neighbours per round.

use rustc_hash::FxHashMap;

use crate::accel::structure::Item;

/// Groups of up to this many are left to obvhs.
const FEW: usize = 16;

/// Items in groups of equal boxes, in the order of their first members. A group of at most [`FEW`] items is split into
/// single items. `None` if there is no larger group.
pub(super) fn groups(items: &[Item<'_>]) -> Option<Vec<Vec<u32>>> {
    let mut sizes: FxHashMap<[u32; 6], usize> = FxHashMap::default();
    items.iter().for_each(|item| *sizes.entry(bounds(item)).or_default() += 1);
    if sizes.values().all(|size| *size <= FEW) {
        return None;
    }
    let mut places: FxHashMap<[u32; 6], usize> = FxHashMap::default();
    let mut groups: Vec<Vec<u32>> = Vec::new();
    for (at, item) in items.iter().enumerate() {
        let bounds = bounds(item);
        match places.get(&bounds) {
            Some(place) => groups[*place].push(at as u32),
            None => {
                if sizes[&bounds] > FEW {
                    places.insert(bounds, groups.len());
                }
                groups.push(vec![at as u32]);
            }
        }
    }
    Some(groups)
}

/// The bits of the corners of an item's box; both zeros have the same bits.
fn bounds(item: &Item<'_>) -> [u32; 6] {
    let [a, b, c] = item.triangle.v;
    let (low, high) = (a.min(b).min(c), a.max(b).max(c));
    let [low, high] = [low, high].map(|corner| corner.to_array().map(|side| (side + 0.0).to_bits()));
    std::array::from_fn(|at| if at < 3 { low[at] } else { high[at - 3] })
}
