//! Which designs are replayed next: those that may be on the front, and those that least is known of.

use super::front::{beats, unbeaten};
use super::pool::{LEAST, Pool};

/// A design that was not replayed.
struct Open {
    design: usize,
    /// Whether it may be on the front: no design that was replayed beats it, even if each of its figures is a standard
    /// deviation below what is expected.
    may_lead: bool,
    /// Whether it is on the front if all is as expected.
    leads: bool,
}

/// The designs that were not replayed, by their prospects.
pub(super) struct Prospects {
    open: Vec<Open>,
}

impl Prospects {
    /// Looks at all designs. They are compared by the logarithms of their figures, and by wrong pixels.
    pub(super) fn new(pool: &Pool) -> Self {
        let (mut known, mut open, mut expected, mut at_best) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        for (at, design) in pool.designs.iter().enumerate() {
            let wrong = design.wrong as f64;
            let compared = |figures: Vec<f64>| -> Vec<f64> { figures.into_iter().chain([wrong]).collect() };
            match &design.measured {
                Some(measured) => known.push(compared(measured.iter().map(|it| it.max(LEAST).ln()).collect())),
                None => {
                    let found = pool.logarithms(at);
                    open.push(at);
                    expected.push(compared(found.iter().map(|(mean, _)| *mean).collect()));
                    at_best.push(compared(found.iter().map(|(mean, deviation)| mean - deviation).collect()));
                }
            }
        }
        let front: Vec<&Vec<f64>> = known.iter().zip(unbeaten(&known)).filter(|it| it.1).map(|it| it.0).collect();
        let leads = unbeaten(&expected.iter().chain(&known).cloned().collect::<Vec<_>>());
        let open = open.into_iter().zip(&at_best).zip(leads).map(|((design, best), leads)| Open {
            design,
            may_lead: !front.iter().any(|other| beats(other, best)),
            leads,
        });
        Self { open: open.collect() }
    }

    /// How many designs may be on the front and were not replayed.
    pub(super) fn unsure(&self) -> usize {
        self.open.iter().filter(|open| open.may_lead || open.leads).count()
    }

    /// Up to `count` designs to be replayed next. Each choice counts as known for those after it. One in `explore`
    /// (none if that is 0) is taken wherever least is known; the others where the front is expected or may be.
    pub(super) fn choose(&self, pool: &mut Pool, count: usize, explore: usize) -> Vec<usize> {
        let mut chosen: Vec<usize> = Vec::new();
        while chosen.len() < count {
            let explores = explore > 0 && chosen.len() % explore == explore - 1;
            let rank = |open: &Open| {
                let doubt: f64 = pool.logarithms(open.design).iter().map(|(_, deviation)| deviation).sum();
                (open.leads && !explores, open.may_lead && !explores, doubt)
            };
            let free = self.open.iter().filter(|open| !chosen.contains(&open.design));
            let ranked = free.map(|open| (rank(open), open.design));
            let best = ranked.max_by(|(a, _), (b, _)| (a.0, a.1).cmp(&(b.0, b.1)).then(a.2.total_cmp(&b.2)));
            let Some((_, best)) = best else { break };
            chosen.push(best);
            pool.count_in(best);
        }
        chosen
    }
}
