//! The Pareto front: designs that no other design beats.

/// Whether `a` is in no figure worse than `b`, and in one better; less is better.
pub(super) fn beats(a: &[f64], b: &[f64]) -> bool {
    let pairs = || a.iter().zip(b);
    pairs().all(|(a, b)| a <= b) && pairs().any(|(a, b)| a < b)
}

/// For each of `all`, whether no other one beats it.
pub(super) fn unbeaten(all: &[Vec<f64>]) -> Vec<bool> {
    // In this order a design comes after all that beat it. If any design beats it, an unbeaten one does.
    let mut order: Vec<usize> = (0..all.len()).collect();
    order.sort_by(|&a, &b| {
        let pairs = all[a].iter().zip(&all[b]).map(|(a, b)| a.total_cmp(b));
        pairs.fold(std::cmp::Ordering::Equal, std::cmp::Ordering::then)
    });
    let mut front: Vec<usize> = Vec::new();
    let mut found = vec![false; all.len()];
    for at in order {
        if !front.iter().any(|&other| beats(&all[other], &all[at])) {
            front.push(at);
            found[at] = true;
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn the_front_is_what_none_beats() {
        let all = [[1.0, 5.0], [2.0, 3.0], [2.0, 4.0], [4.0, 1.0], [2.0, 3.0], [5.0, 5.0]].map(|it| it.to_vec());
        assert_eq!(unbeaten(&all), [true, true, false, true, true, false]);
    }

    proptest! {
        #[test]
        fn it_is_what_a_search_of_pairs_finds(all in prop::collection::vec(prop::collection::vec(0..6u8, 3), 0..40)) {
            let all: Vec<Vec<f64>> = all.iter().map(|of| of.iter().map(|&it| f64::from(it)).collect()).collect();
            let searched: Vec<bool> = all.iter().map(|it| !all.iter().any(|other| beats(other, it))).collect();
            prop_assert_eq!(unbeaten(&all), searched);
        }
    }
}
