//! The part that limits a machine, in words.

use super::machine_run::MachineRun;
use crate::report::format::{percent, words};
use crate::stats::Cause;

/// The DRAM or a kind of unit with at least this utilization is the limit, unless an intake is full.
const FULL: f64 = 0.75;
/// A full intake is the limit if it costs at least this share of a kind of unit's cycles.
const INTAKE: f64 = 0.2;
/// A kind of unit does not limit the run if its share of cycles without rays exceeds another kind's by more than
/// this. Assumed, as the two above.
const IDLER: f64 = 0.02;

/// The limit of a run.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Limit {
    /// In a few words: `its traversal units are busy`.
    pub short: String,
    /// A sentence with its figures.
    pub text: String,
}

/// The kind of unit that is busy in the largest share of its cycles, and that share. The dispatcher does not count,
/// since it only hands out rays.
pub(super) fn busiest(run: &MachineRun) -> Option<(&str, f64)> {
    let units = run.utilization.iter().filter(|(unit, _)| *unit != "dispatcher");
    units.map(|(unit, &share)| (unit.as_str(), share)).max_by(|a, b| a.1.total_cmp(&b.1)).filter(|it| it.1 > 0.0)
}

/// The kind of unit that limits the run, and the share of its cycles in which it is busy. It is the busiest kind
/// among those that have rays in most of their cycles: a kind without rays waits for a kind that holds them.
fn limiting(run: &MachineRun) -> Option<(&str, f64)> {
    let has_rays = |unit: &str| 1.0 - share(run, unit, Cause::Starved);
    let units = || run.utilization.iter().filter(|(unit, _)| *unit != "dispatcher");
    let most = units().map(|(unit, _)| has_rays(unit)).fold(0.0, f64::max);
    let holders = units().filter(|(unit, _)| has_rays(unit) >= most - IDLER);
    holders.map(|(unit, &busy)| (unit.as_str(), busy)).max_by(|a, b| a.1.total_cmp(&b.1))
}

fn share(run: &MachineRun, unit: &str, cause: Cause) -> f64 {
    let Some(causes) = run.stats.units.get(unit) else { return 0.0 };
    let whole: u64 = causes.values().sum();
    causes.get(&cause).map_or(0.0, |&cycles| cycles as f64 / whole.max(1) as f64)
}

/// The limit of a run; `None` where it is not known.
pub(super) fn limit(run: &MachineRun) -> Option<Limit> {
    let (unit, busy) = busiest(run)?;
    let intake = run.stats.units.keys().map(|unit| (unit.as_str(), share(run, unit, Cause::Intake)));
    if let Some((unit, lost)) = intake.max_by(|a, b| a.1.total_cmp(&b.1)).filter(|it| it.1 >= INTAKE) {
        let name = words(unit);
        return Some(Limit {
            short: format!("its {name} units take no more rays a cycle"),
            text: format!(
                "The intake of the {name} units: in {} of their cycles they took as many rays as their width allows, \
                 and others waited.",
                percent(lost)
            ),
        });
    }
    if let Some(used) = run.dram_utilization.filter(|&used| used >= FULL) {
        return Some(Limit {
            short: "its DRAM is full".into(),
            text: format!("DRAM bandwidth: {} of its peak is used.", percent(used)),
        });
    }
    let (name, busy_text) = (words(unit), percent(busy));
    if busy >= FULL {
        return Some(Limit {
            short: format!("its {name} units are busy"),
            text: format!("The {name} units: busy in {busy_text} of their cycles."),
        });
    }
    let (unit, busy) = limiting(run)?;
    let (name, busy_text) = (words(unit), percent(busy));
    let lost = Cause::ALL.into_iter().filter(|&cause| cause != Cause::Busy);
    let lost = lost.map(|cause| (cause, share(run, unit, cause))).max_by(|a, b| a.1.total_cmp(&b.1));
    // Levels that know no causes count busy cycles alone.
    let (cause, lost) = lost.filter(|&(_, lost)| lost > 0.0)?;
    let (short, why) = match cause {
        Cause::Memory => ("wait for memory", "wait for data"),
        Cause::Blocked => ("are blocked by their neighbours", "hold results that a neighbour cannot take"),
        Cause::Pipeline => ("have too few rays for their latency", "have all their rays in the pipeline"),
        Cause::Intake => ("take no more rays a cycle", "have a full intake"),
        Cause::Starved | Cause::Busy => ("have too few rays", "have no ray"),
    };
    Some(Limit {
        short: format!("its {name} units {short}"),
        text: format!(
            "The {name} units {short}: they are busy in {busy_text} of their cycles, and {why} in {}.",
            percent(lost)
        ),
    })
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use super::*;
    use crate::quantity::Cycle;
    use crate::stats::MachineStats;

    /// A run of 100 cycles in which one kind of unit lost cycles to these causes.
    fn run(causes: &[(Cause, u64)]) -> MachineRun {
        let lost: u64 = causes.iter().map(|(_, cycles)| cycles).sum();
        let mut all: BTreeMap<Cause, u64> = causes.iter().copied().collect();
        all.insert(Cause::Busy, 100 - lost);
        let stats = MachineStats {
            cycles: Cycle(100),
            clock_mhz: 1.0,
            units: BTreeMap::from([("shadow_cache".to_owned(), all)]),
            unit_counts: BTreeMap::from([("shadow_cache".to_owned(), 1)]),
            ..MachineStats::default()
        };
        MachineRun::from(stats)
    }

    #[test]
    fn the_cause_of_the_busiest_unit_is_named() {
        let short = |causes: &[(Cause, u64)]| limit(&run(causes)).unwrap().short;
        assert_eq!(short(&[(Cause::Memory, 10)]), "its shadow cache units are busy");
        assert_eq!(short(&[(Cause::Memory, 40)]), "its shadow cache units wait for memory");
        assert_eq!(short(&[(Cause::Starved, 60)]), "its shadow cache units have too few rays");
        assert_eq!(
            short(&[(Cause::Intake, 30), (Cause::Starved, 40)]),
            "its shadow cache units take no more rays a cycle"
        );
        let text = limit(&run(&[(Cause::Pipeline, 40)])).unwrap().text;
        assert!(text.ends_with("busy in 60.0 % of their cycles, and have all their rays in the pipeline in 40.0 %."));
        assert_eq!(limit(&MachineRun::from(MachineStats::default())), None);
    }

    /// The intersection units are the busiest, but they lack rays because the shadow-cache units hold them.
    #[test]
    fn units_that_hold_the_rays_are_the_limit() {
        let mut run = run(&[(Cause::Memory, 60), (Cause::Starved, 5)]);
        let starved = BTreeMap::from([(Cause::Busy, 40), (Cause::Starved, 60)]);
        run.stats.units.insert("intersection".into(), starved);
        run.stats.unit_counts.insert("intersection".into(), 1);
        let limit = limit(&MachineRun::from(run.stats)).unwrap();
        assert_eq!(limit.short, "its shadow cache units wait for memory");
        assert!(limit.text.contains("busy in 35.0 % of their cycles, and wait for data in 60.0 %"), "{}", limit.text);
    }
}
