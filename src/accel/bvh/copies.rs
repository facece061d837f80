//! Items whose boxes are equal: obvhs builds over one of them, as its clustering takes quadratic time where all boxes
//! are alike (ties leave one pair of mutual neighbours a round).

use rustc_hash::FxHashMap;

use crate::accel::structure::Item;

/// Groups of up to this many are left to obvhs.
const FEW: usize = 16;

/// Items in groups of equal boxes, in the order of their first members; a group of [`FEW`] at most is taken apart.
/// `None` if there is no larger group.
pub fn groups(items: &[Item<'_>]) -> Option<Vec<Vec<u32>>> {
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

/// The corners of an item's box, by their bits; both zeros are one number.
fn bounds(item: &Item<'_>) -> [u32; 6] {
    let [a, b, c] = item.triangle.v;
    let (low, high) = (a.min(b).min(c), a.max(b).max(c));
    let [low, high] = [low, high].map(|corner| corner.to_array().map(|side| (side + 0.0).to_bits()));
    std::array::from_fn(|at| if at < 3 { low[at] } else { high[at - 3] })
}
