//! Checks the rows of random machines.

use std::collections::BTreeMap;

use super::*;
use crate::engine::tests::agreement::check_many;
use crate::engine::tests::frames::numbered;
use crate::engine::tests::random::{machines, streams};
use crate::replay::{Exact, Replay};
use crate::stream::Item;

#[test]
fn rows_of_random_machines_sum_to_their_frames_and_both_engines_write_the_same() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("interval.csv");
    let run = |machine: &_, level: Exact, header: &Header, stream: &[Item], interval| {
        let mut export = IntervalExport::create(header, interval, &path).map_err(|error| error.to_string())?;
        let replay = Replay::new(machine, header).map_err(|error| error.to_string())?.fidelity(level);
        let observed = replay.observe(&mut export).map_err(|error| error.to_string())?;
        let stats = observed.run(stream.iter().cloned().map(Ok)).map_err(|error| error.to_string())?;
        export.finish().map_err(|error| error.to_string())?;
        Ok::<_, String>((stats, std::fs::read_to_string(&path).map_err(|error| error.to_string())?))
    };
    // 40 cases missed a fault.
    check_many(
        120,
        || (machines(), streams(), 0..2u32, 1..300u64),
        |(machine, stream, warmup, interval)| {
            let (header, stream) = numbered(&stream, warmup);
            let (stats, text) = run(&machine, Exact::Event, &header, &stream, interval)?;
            let (truth, exact) = run(&machine, Exact::Cycle, &header, &stream, interval)?;
            if let Some(difference) = first_difference(&text, &exact) {
                return Err(format!("the engines count different intervals: {difference}"));
            }
            if truth != stats {
                return Err("the engines count different frames".into());
            }
            let mut sums: BTreeMap<(u32, String), u64> = BTreeMap::new();
            for row in csv::Reader::from_reader(text.as_bytes()).deserialize() {
                let row: BTreeMap<String, u64> = row.map_err(|error| error.to_string())?;
                assert!((1..=interval).contains(&row["cycles"]), "{row:?}");
                let frame = row["frame"] as u32;
                row.iter().for_each(|(name, value)| *sums.entry((frame, name.clone())).or_default() += value);
            }
            for frame in &stats.frames {
                let columns = counted_columns(frame).into_iter().filter(|(name, _)| !name.starts_with("energy"));
                for (name, text) in columns {
                    let (sum, counted) = (sums[&(frame.frame, name.clone())], text(frame));
                    if sum.to_string() != counted {
                        return Err(format!("frame {}: {name} sums to {sum}, not {counted}", frame.frame));
                    }
                }
                if sums[&(frame.frame, "cycles".into())] != frame.cycles.0 {
                    return Err(format!("cycles of frame {}", frame.frame));
                }
            }
            Ok(())
        },
    );
}

/// The first difference of two tables: row, column and values.
fn first_difference(found: &str, is: &str) -> Option<String> {
    let names: Vec<&str> = is.lines().next()?.split(',').collect();
    for (row, (found, is)) in found.lines().zip(is.lines()).enumerate() {
        for (name, (found, is)) in names.iter().zip(found.split(',').zip(is.split(','))) {
            if found != is {
                return Some(format!("row {row}, {name}: {found} for {is}"));
            }
        }
    }
    (found.lines().count() != is.lines().count()).then(|| "the number of rows".into())
}
