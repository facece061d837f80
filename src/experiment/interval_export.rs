//! What a machine counts every so many cycles, as CSV.

use std::io;
use std::path::Path;

use super::export_file::ExportFile;
use crate::replay::Observer;
use crate::report::run::{CountedColumn, counted_columns};
use crate::stats::{FrameStats, MachineStats};
use crate::stream::Header;

/// Writes a row an interval. An interval ends with its frame, so that the rows of a frame sum to what it counted.
pub(crate) struct IntervalExport {
    interval: u64,
    /// Frames that warm up.
    warmup: Vec<u32>,
    /// The run up to the last row.
    before: MachineStats,
    /// The columns, once the first row has told which parts there are.
    columns: Vec<CountedColumn>,
    file: ExportFile,
}

impl IntervalExport {
    /// Begins the file, with a row every `interval` cycles.
    ///
    /// # Errors
    /// The file cannot be written.
    pub(crate) fn create(header: &Header, interval: u64, path: &Path) -> io::Result<Self> {
        let (warmup, file) = (header.warmup.clone(), ExportFile::create(path)?);
        Ok(Self { interval, warmup, before: MachineStats::default(), columns: Vec::new(), file })
    }

    /// Puts the file into its place.
    ///
    /// # Errors
    /// The file cannot be written.
    pub(crate) fn finish(self) -> io::Result<()> {
        self.file.finish()
    }

    fn row(&mut self, begin: u64, row: &FrameStats) -> io::Result<()> {
        if self.columns.is_empty() {
            self.columns = counted_columns(row);
            let counted = self.columns.iter().map(|(name, _)| name.as_str());
            let head: Vec<&str> = ["frame", "warmup", "begin", "cycles", "rays"].into_iter().chain(counted).collect();
            self.file.line(format_args!("{}", head.join(",")))?;
        }
        let counted: Vec<String> = self.columns.iter().map(|(_, text)| text(row)).collect();
        let FrameStats { frame, warmup, cycles, rays, .. } = row;
        self.file.line(format_args!("{frame},{},{begin},{cycles},{rays},{}", u8::from(*warmup), counted.join(",")))
    }
}

impl Observer for IntervalExport {
    fn interval(&self) -> Option<u64> {
        Some(self.interval)
    }

    fn counted(&mut self, frame: u32, stats: MachineStats) -> io::Result<()> {
        let mut own = stats.since(&self.before);
        // Rays may not have moved yet.
        own.bytes.entry("fifos".into()).or_default();
        let row = own.as_frame(frame, self.warmup.contains(&frame), 0);
        let begin = self.before.cycles.0;
        self.before = stats;
        self.row(begin, &row)
    }
}

#[cfg(test)]
mod tests {
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
        check_many(
            40,
            || (machines(), streams(), 0..2u32, 1..300u64),
            |(machine, stream, warmup, interval)| {
                let (header, stream) = numbered(&stream, warmup);
                let (stats, text) = run(&machine, Exact::Event, &header, &stream, interval)?;
                if run(&machine, Exact::Cycle, &header, &stream, interval)? != (stats.clone(), text.clone()) {
                    return Err("the engines count different intervals".into());
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
}
