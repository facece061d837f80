//! Which designs are replayed next: those that may be on the front, and those that least is known of.

use super::front::{beats, unbeaten};
use super::series::Series;

/// A design: its series, and its place in that.
pub(super) type Place = (usize, usize);

/// A design that was not replayed.
struct Open {
    place: Place,
    /// Whether it may be on the front: no design that was replayed beats it, even if each of its figures is a standard
    /// deviation below what is expected.
    may_lead: bool,
    /// Whether it is on the front if all is as expected.
    leads: bool,
}

/// What is known of all designs, as points that are compared: logarithms of figures, and wrong pixels.
pub(super) struct Field {
    open: Vec<Open>,
}

/// The figures of a design as they are compared.
fn compared(series: &Series, logarithms: impl Iterator<Item = f64>) -> Vec<f64> {
    logarithms.chain([series.wrong as f64]).collect()
}

impl Field {
    /// Looks at all designs.
    pub(super) fn new(all: &[Series]) -> Self {
        let (mut known, mut places, mut expected) = (Vec::new(), Vec::new(), Vec::new());
        for (at, series) in all.iter().enumerate() {
            for (number, design) in series.designs.iter().enumerate() {
                match &design.measured {
                    Some(measured) => known.push(compared(series, measured.iter().map(|it| it.max(1e-30).ln()))),
                    None => {
                        places.push((at, number));
                        expected.push(series.logarithms(number));
                    }
                }
            }
        }
        let front = unbeaten(&known);
        let front: Vec<&Vec<f64>> = known.iter().zip(&front).filter(|(_, best)| **best).map(|(it, _)| it).collect();
        let means = places.iter().zip(&expected);
        let means = means.map(|(&(at, _), found)| compared(&all[at], found.iter().map(|(mean, _)| *mean)));
        let together: Vec<Vec<f64>> = means.chain(known.iter().cloned()).collect();
        let leads = unbeaten(&together);
        let open = |((place, found), leads): ((&Place, &Vec<(f64, f64)>), &bool)| {
            let best = compared(&all[place.0], found.iter().map(|(mean, deviation)| mean - deviation));
            Open { place: *place, may_lead: !front.iter().any(|other| beats(other, &best)), leads: *leads }
        };
        Self { open: places.iter().zip(&expected).zip(&leads).map(open).collect() }
    }

    /// How many designs may be on the front and were not replayed.
    pub(super) fn unsure(&self) -> usize {
        self.open.iter().filter(|open| open.may_lead || open.leads).count()
    }

    /// Up to `count` designs to be replayed next. Each choice counts as known for those after it. One in `explore`
    /// (none if that is 0) is taken wherever least is known; the others where the front is expected or may be.
    pub(super) fn choose(&self, all: &mut [Series], count: usize, explore: usize) -> Vec<Place> {
        let mut chosen: Vec<Place> = Vec::new();
        while chosen.len() < count {
            let explores = explore > 0 && chosen.len() % explore == explore - 1;
            let doubt = |(at, number): Place| -> f64 { all[at].logarithms(number).iter().map(|(_, it)| it).sum() };
            let rank = |open: &&Open| (open.leads && !explores, open.may_lead && !explores, doubt(open.place));
            let free = self.open.iter().filter(|open| !chosen.contains(&open.place));
            let best = free.max_by(|a, b| {
                let (a, b) = (rank(a), rank(b));
                (a.0, a.1).cmp(&(b.0, b.1)).then(a.2.total_cmp(&b.2))
            });
            let Some(best) = best else { break };
            chosen.push(best.place);
            all[best.place.0].count_in(best.place.1);
        }
        chosen
    }
}
