//! Differences and sums of counts by name.

use std::collections::BTreeMap;
use std::ops::{AddAssign, Sub};

/// Counts of each part.
type Counted<V> = BTreeMap<String, V>;

/// The counts of `now` less those of `earlier`, as far as `stays` keeps them.
pub(super) fn less<K: Clone + Ord, V: Copy + Sub<Output = V>>(
    now: &BTreeMap<K, V>,
    earlier: Option<&BTreeMap<K, V>>,
    stays: fn(&V) -> bool,
) -> BTreeMap<K, V> {
    let before = |key: &K| earlier.and_then(|earlier| earlier.get(key)).copied();
    let all = now.iter().map(|(key, &now)| (key.clone(), before(key).map_or(now, |before| now - before)));
    all.filter(|(_, value)| stays(value)).collect()
}

/// The same for the counts of each part.
pub(super) fn less_nested<K: Clone + Ord, V: Copy + Sub<Output = V>>(
    now: &Counted<BTreeMap<K, V>>,
    earlier: &Counted<BTreeMap<K, V>>,
    stays: fn(&V) -> bool,
) -> Counted<BTreeMap<K, V>> {
    now.iter().map(|(part, now)| (part.clone(), less(now, earlier.get(part), stays))).collect()
}

/// Adds `other` to `sum`.
pub(super) fn more<K: Clone + Ord, V: AddAssign + Copy + Default>(sum: &mut BTreeMap<K, V>, other: &BTreeMap<K, V>) {
    other.iter().for_each(|(key, &value)| *sum.entry(key.clone()).or_default() += value);
}

/// The same for the counts of each part.
pub(super) fn more_nested<K: Clone + Ord, V: AddAssign + Copy + Default>(
    sum: &mut Counted<BTreeMap<K, V>>,
    other: &Counted<BTreeMap<K, V>>,
) {
    other.iter().for_each(|(part, values)| more(sum.entry(part.clone()).or_default(), values));
}
