//! Which designs are replayed next: those that may be on the front, and those that least is known of.

use super::figure::LEAST;
use super::front::{beats, unbeaten};
use super::pool::Pool;

/// A design that was not replayed.
struct Open {
    design: usize,
    expected: Compared,
    /// Whether it may be on the front: no design that was replayed beats it, even if each of its figures is a standard
    /// deviation below what is expected.
    may_lead: bool,
    /// Whether it is on the front if all is as expected.
    leads: bool,
}

/// What designs are compared by.
#[derive(Clone)]
struct Compared {
    /// Logarithms of the figures.
    figures: Vec<f64>,
    wrong: u64,
}

impl Compared {
    /// All of it, as [`beats`] wants it.
    fn all(&self) -> Vec<f64> {
        self.figures.iter().copied().chain([self.wrong as f64]).collect()
    }

    /// By how much each of `others` is behind in some figure, as a logarithm: below zero where one of them is nowhere
    /// behind, and infinite where all have more wrong pixels.
    fn ahead_of(&self, others: &[Self]) -> f64 {
        let behind = |other: &Self| {
            let behind = other.figures.iter().zip(&self.figures).map(|(other, own)| other - own);
            behind.fold(f64::NEG_INFINITY, f64::max)
        };
        others.iter().filter(|other| other.wrong <= self.wrong).map(behind).fold(f64::INFINITY, f64::min)
    }
}

/// The designs that were not replayed, by their prospects.
pub(super) struct Prospects {
    open: Vec<Open>,
    replayed: Vec<Compared>,
}

impl Prospects {
    /// Looks at all designs.
    pub(super) fn new(pool: &Pool) -> Self {
        let (mut replayed, mut open, mut expected, mut at_best) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        for (at, design) in pool.designs.iter().enumerate() {
            let compared = |figures: Vec<f64>| Compared { figures, wrong: design.wrong };
            match &design.measured {
                Some(measured) => replayed.push(compared(measured.iter().map(|it| it.max(LEAST).ln()).collect())),
                None => {
                    let found = pool.logarithms(at);
                    open.push(at);
                    expected.push(compared(found.iter().map(|(mean, _)| *mean).collect()));
                    at_best.push(compared(found.iter().map(|(mean, deviation)| mean - deviation).collect()).all());
                }
            }
        }
        let known: Vec<Vec<f64>> = replayed.iter().map(Compared::all).collect();
        let front: Vec<&Vec<f64>> = known.iter().zip(unbeaten(&known)).filter(|it| it.1).map(|it| it.0).collect();
        let leads = unbeaten(&expected.iter().map(Compared::all).chain(known.clone()).collect::<Vec<_>>());
        let prospects = open.into_iter().zip(expected).zip(&at_best).zip(leads);
        let open = prospects.map(|(((design, expected), best), leads)| Open {
            design,
            expected,
            may_lead: !front.iter().any(|other| beats(other, best)),
            leads,
        });
        Self { open: open.collect(), replayed }
    }

    /// How many designs may be on the front and were not replayed.
    pub(super) fn unsure(&self) -> usize {
        self.open.iter().filter(|open| open.may_lead || open.leads).count()
    }

    /// Up to `count` designs to be replayed next. Each choice counts as known for those after it. One in `explore`
    /// (none if that is 0) is taken wherever least is known; the others where the front is expected, or may be, and the
    /// farthest from all that is known.
    pub(super) fn choose(&self, pool: &mut Pool, count: usize, explore: usize) -> Vec<usize> {
        let mut chosen: Vec<usize> = Vec::new();
        let mut known = self.replayed.clone();
        while chosen.len() < count {
            let explores = explore > 0 && chosen.len() % explore == explore - 1;
            let rank = |open: &Open| {
                if explores {
                    return (false, false, pool.logarithms(open.design).iter().map(|(_, deviation)| deviation).sum());
                }
                (open.leads, open.may_lead, open.expected.ahead_of(&known))
            };
            let free = self.open.iter().filter(|open| !chosen.contains(&open.design));
            let ranked = free.map(|open| (rank(open), open));
            let best = ranked.max_by(|(a, _), (b, _)| (a.0, a.1).cmp(&(b.0, b.1)).then(a.2.total_cmp(&b.2)));
            let Some((_, best)) = best else { break };
            chosen.push(best.design);
            known.push(best.expected.clone());
            pool.count_in(best.design);
        }
        chosen
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_design_is_ahead_by_what_the_nearest_lacks() {
        let of = |figures: [f64; 2], wrong: u64| Compared { figures: figures.into(), wrong };
        let others = [of([1.0, 4.0], 0), of([3.0, 1.0], 0), of([0.0, 0.0], 9)];
        assert_eq!(of([2.0, 2.0], 0).ahead_of(&others), 1.0, "the second is behind by one");
        assert_eq!(of([4.0, 4.5], 3).ahead_of(&others), -1.0, "the second is ahead by that everywhere");
        assert_eq!(of([2.0, 2.0], 0).ahead_of(&others[2..]), f64::INFINITY);
    }
}
