//! Speed of both engines on the shipped machines, replaying the recorded quickstart. Both engines must give equal
//! results.
//!
//! `cargo bench --bench engine` prints one line per machine. Wall times are the best of three runs of `Event`, and one
//! run of `Cycle`.

use std::path::Path;
use std::time::Instant;

use umbrasim::experiment::read_machine;
use umbrasim::machine::MachineSpec;
use umbrasim::replay::{Fidelity, Replay, RunError};
use umbrasim::stats::MachineStats;
use umbrasim::stream::{Header, Item, StreamReader};

/// The result, and the shortest wall time of `times` runs in seconds.
fn replay(
    machine: &MachineSpec,
    fidelity: Fidelity,
    header: &Header,
    items: &[Item],
    times: u32,
) -> (MachineStats, f64) {
    let run = |_| {
        let start = Instant::now();
        let replay = Replay::new(machine, header).map_err(RunError::from);
        let stats = replay.and_then(|replay| replay.fidelity(fidelity).run(&items));
        (stats.unwrap_or_else(|error| panic!("{error}")), start.elapsed().as_secs_f64())
    };
    (0..times).map(run).min_by(|a, b| a.1.total_cmp(&b.1)).expect("at least one run")
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let reader = StreamReader::open(&root.join("traces/quickstart.rays"))?;
    let header = reader.header().clone();
    let items = reader.collect::<Result<Vec<_>, _>>()?;
    let mut machines: Vec<_> = std::fs::read_dir(root.join("configs/machines"))?.collect::<Result<_, _>>()?;
    machines.sort_by_key(|file| file.path());
    println!(
        "{:<12} {:>10} {:>12} {:>14} {:>14} {:>13} {:>13} {:>8}",
        "machine", "rays", "cycles", "Event Mray/s", "Cycle Mray/s", "Event Mcyc/s", "Cycle Mcyc/s", "ratio"
    );
    for file in machines {
        let machine = read_machine(&file.path())?;
        let (event, event_seconds) = replay(&machine, Fidelity::Event, &header, &items, 3);
        let (cycle, cycle_seconds) = replay(&machine, Fidelity::Cycle, &header, &items, 1);
        assert_eq!(event, cycle, "the engines differ on {}", machine.name);
        let rays = |seconds: f64| event.rays as f64 / seconds / 1e6;
        let cycles = |seconds: f64| event.cycles.0 as f64 / seconds / 1e6;
        println!(
            "{:<12} {:>10} {:>12} {:>14.4} {:>14.4} {:>13.3} {:>13.3} {:>8.1}",
            machine.name,
            event.rays,
            event.cycles.0,
            rays(event_seconds),
            rays(cycle_seconds),
            cycles(event_seconds),
            cycles(cycle_seconds),
            cycle_seconds / event_seconds
        );
    }
    Ok(())
}
