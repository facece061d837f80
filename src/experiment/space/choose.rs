//! Chooses the designs to replay next: those that may be on the front, and those with the widest predictions.

use super::figure::LEAST;
use super::front::{beats, unbeaten};
use super::pool::Pool;

/// A design that was not replayed.
struct Open {
    design: usize,
    expected: Compared,
    /// Whether it may be on the front: no replayed design beats it, even if each of its figures is one standard
    /// deviation below its expected value.
    may_lead: bool,
    /// Whether it is on the front if all figures have their expected values.
    leads: bool,
}

/// The figures by which designs are compared.
#[derive(Clone)]
struct Compared {
    /// Logarithms of the figures.
    figures: Vec<f64>,
    wrong: u64,
}

impl Compared {
    /// All figures, in the form that [`beats`] takes.
    fn all(&self) -> Vec<f64> {
        self.figures.iter().copied().chain([self.wrong as f64]).collect()
    }

    /// The least lead over any of `others`, as a logarithm: how far the other is behind in its worst figure. Below
    /// zero where another design is behind in no figure; infinite where all others have more wrong pixels.
    fn ahead_of(&self, others: &[Self]) -> f64 {
        let behind = |other: &Self| {
            let behind = other.figures.iter().zip(&self.figures).map(|(other, own)| other - own);
            behind.fold(f64::NEG_INFINITY, f64::max)
        };
        others.iter().filter(|other| other.wrong <= self.wrong).map(behind).fold(f64::INFINITY, f64::min)
    }
}

/// The designs that were not replayed, and whether they may be on the front.
pub(super) struct Prospects {
    open: Vec<Open>,
    replayed: Vec<Compared>,
}

impl Prospects {
    /// Sorts all designs into replayed and open ones.
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

    /// The number of designs that may be on the front and were not replayed.
    pub(super) fn unsure(&self) -> usize {
        self.open.iter().filter(|open| open.may_lead || open.leads).count()
    }

    /// Chooses up to `count` designs to replay next; each choice counts as known for the following ones. Every
    /// `explore`-th choice (none if `explore` is 0) goes to the design with the widest prediction. The others go first
    /// to designs expected on the front, then to those that may be on it, with the largest lead over all known designs
    /// first.
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
