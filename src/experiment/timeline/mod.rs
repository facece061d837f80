//! A timeline of one frame, for Perfetto: the cause of each unit's cycles, queue depths, outstanding misses, and open
//! rows of the DRAM's banks. One nanosecond in Perfetto is one cycle of the machine; the frame begins at 0.

mod perfetto;
#[cfg(test)]
mod tests;

use std::io;
use std::path::Path;

use self::perfetto::{Name, Trace, Track};
use super::export_file::ExportFile;
use crate::machine::MachineSpec;
use crate::memory::dram::command::{Command, LoggedCommand};
use crate::memory::dram::spec::{Clocks, Model};
use crate::replay::{Observer, Place, Places, Seen};
use crate::stats::Cause;
use crate::stream::Header;

/// Cycles between two samples of queue depths and misses: these change nearly every cycle, and would fill the file.
const LOOK_CYCLES: u64 = 16;

/// Writes the timeline of a frame while its stream is replayed.
pub(crate) struct Timeline {
    trace: Trace,
    frame: u32,
    /// The cycle in which the frame began, and the first cycle that is not written.
    begin: Option<u64>,
    end: u64,
    units: Vec<Unit>,
    causes: [Name; Cause::ALL.len()],
    counters: Vec<Counter>,
    banks: Option<Banks>,
    /// Commands of the cycle that is not written yet.
    given: Vec<(usize, LoggedCommand)>,
}

/// A unit's track, and the cause of its last cycle.
struct Unit {
    track: Track,
    cause: Option<Cause>,
}

/// The track of a counter, and its last value.
struct Counter {
    track: Track,
    value: Option<u32>,
}

/// The banks of the DRAM.
struct Banks {
    clocks: Clocks,
    a_channel: usize,
    channels: Vec<Track>,
    banks: Vec<Bank>,
    /// Names of a bank's slices, and of a channel's refreshes.
    open: Name,
    refresh: Name,
}

/// A bank's track, and whether a row is open.
struct Bank {
    track: Track,
    is_open: bool,
}

impl Timeline {
    /// Begins the timeline of `frame`, by default the first measured frame.
    ///
    /// # Errors
    /// The stream has no such frame, or the file cannot be written.
    pub(crate) fn create(machine: &MachineSpec, header: &Header, frame: Option<u32>, path: &Path) -> io::Result<Self> {
        let measured = header.frames.iter().find(|frame| !header.warmup.contains(frame));
        let Some(frame) = frame.or(measured.copied()).filter(|frame| header.frames.contains(frame)) else {
            return Err(io::Error::other(no_frame(frame, header)));
        };
        let mut trace = Trace::begin(ExportFile::create(path)?)?;
        let root = format!("{}, {}, frame {frame}, in cycles", machine.name, header.policy);
        let root = trace.track(None, &root)?;
        let places = Places::of(machine);
        let unit = |track| Unit { track, cause: None };
        let units = tracks(&mut trace, root, &places.units, None)?.into_iter().map(unit).collect();
        let queues = trace.track(Some(root), "queues")?;
        let misses = trace.track(Some(root), "misses under way")?;
        let mut counters = tracks(&mut trace, queues, &places.queues, Some("entries"))?;
        counters.extend(tracks(&mut trace, misses, &places.misses, Some("misses"))?);
        let counters = counters.into_iter().map(|track| Counter { track, value: None }).collect();
        let banks = match machine.dram.model {
            Model::Banks => Some(Banks::new(&mut trace, root, machine)?),
            Model::Flat { .. } => None,
        };
        let names: Vec<Name> = Cause::ALL.iter().map(|cause| trace.name(cause.name())).collect::<io::Result<_>>()?;
        let mut causes = [names[0]; Cause::ALL.len()];
        Cause::ALL.into_iter().zip(names).for_each(|(cause, name)| causes[cause as usize] = name);
        Ok(Self { trace, frame, begin: None, end: 0, units, causes, counters, banks, given: Vec::new() })
    }

    /// Puts the file into its place. Returns a message about its content.
    ///
    /// # Errors
    /// The file cannot be written.
    pub(crate) fn finish(mut self) -> io::Result<String> {
        let end = self.end;
        for unit in &mut self.units {
            if unit.cause.take().is_some() {
                self.trace.end_slice(end, unit.track)?;
            }
        }
        let banks = self.banks.iter().flat_map(|banks| &banks.banks).filter(|bank| bank.is_open);
        for bank in banks.filter(|_| self.begin.is_some()) {
            self.trace.end_slice(end, bank.track)?;
        }
        let told = format!("timeline: frame {}, {end} cycles, {} slices", self.frame, self.trace.slices());
        self.trace.finish()?;
        Ok(told)
    }
}

/// Why there is no such frame.
fn no_frame(frame: Option<u32>, header: &Header) -> String {
    match (frame, header.frames.as_slice()) {
        (None, _) => "the stream has no measured frame: `--timeline-frame` names one that warms up".into(),
        (Some(frame), []) => format!("there is no frame {frame}: the stream has no frames"),
        (Some(frame), [first, .., last]) => {
            format!("there is no frame {frame}: the stream has {} frames from {first} to {last}", header.frames.len())
        }
        (Some(frame), [only]) => format!("there is no frame {frame}: the stream has frame {only} alone"),
    }
}

/// Makes a track for each part, below one for each kind. `unit` makes them counters.
fn tracks(trace: &mut Trace, parent: Track, places: &[Place], unit: Option<&str>) -> io::Result<Vec<Track>> {
    let mut all = Vec::with_capacity(places.len());
    for kind in places.chunk_by(|one, next| one.kind == next.kind) {
        let [first, ..] = kind else { continue };
        let parent = trace.track(Some(parent), &first.kind)?;
        for Place { kind, index } in kind {
            let name = format!("{kind} {index}");
            all.push(match unit {
                Some(unit) => trace.counter(parent, &name, unit)?,
                None => trace.track(Some(parent), &name)?,
            });
        }
    }
    Ok(all)
}

impl Banks {
    fn new(trace: &mut Trace, root: Track, machine: &MachineSpec) -> io::Result<Self> {
        let (count, a_channel) = (machine.dram.channels.size(), machine.dram.part.banks.size());
        let dram = trace.track(Some(root), "DRAM")?;
        let (mut channels, mut banks) = (Vec::with_capacity(count), Vec::with_capacity(count * a_channel));
        for channel in 0..count {
            let track = trace.track(Some(dram), &format!("channel {channel}"))?;
            channels.push(track);
            for bank in 0..a_channel {
                let track = trace.track(Some(track), &format!("channel {channel} bank {bank}"))?;
                banks.push(Bank { track, is_open: false });
            }
        }
        let (open, refresh) = (trace.name("row open")?, trace.name("refresh")?);
        Ok(Self { clocks: machine.dram.clocks(machine.clock_mhz.get()), a_channel, channels, banks, open, refresh })
    }

    /// Notes a DRAM command; writes it at cycle `at`, if given.
    fn command(&mut self, trace: &mut Trace, at: Option<u64>, channel: usize, command: Command) -> io::Result<()> {
        let first = channel * self.a_channel;
        let one = |bank: usize| first + bank..first + bank + 1;
        let (banks, is_open) = match command {
            Command::Activate { bank, .. } => (one(bank), true),
            Command::Precharge { bank } => (one(bank), false),
            Command::Read(column) | Command::Write(column) if column.auto_precharge => (one(column.bank), false),
            Command::Read(_) | Command::Write(_) => return Ok(()),
            Command::PrechargeAll => (first..first + self.a_channel, false),
            Command::Refresh => {
                return at.map_or(Ok(()), |at| trace.instant(at, self.channels[channel], self.refresh));
            }
        };
        for bank in &mut self.banks[banks] {
            if bank.is_open != is_open {
                bank.is_open = is_open;
                match at {
                    Some(at) if is_open => trace.begin_slice(at, bank.track, self.open)?,
                    Some(at) => trace.end_slice(at, bank.track)?,
                    None => {}
                }
            }
        }
        Ok(())
    }

    /// Starts slices for rows that are open when the frame begins.
    fn begin(&self, trace: &mut Trace) -> io::Result<()> {
        let open = self.banks.iter().filter(|bank| bank.is_open);
        open.into_iter().try_for_each(|bank| trace.begin_slice(0, bank.track, self.open))
    }
}

impl Observer for Timeline {
    fn wants_dram(&self) -> bool {
        self.banks.is_some()
    }

    fn watched_frame(&self) -> Option<u32> {
        Some(self.frame)
    }

    fn command(&mut self, channel: usize, given: LoggedCommand) -> io::Result<()> {
        let Some(banks) = &mut self.banks else { return Ok(()) };
        match self.begin {
            None => banks.command(&mut self.trace, None, channel, given.command),
            // Commands of later frames arrive too. Those of this frame belong to the cycle that is shown next.
            Some(begin) if banks.clocks.cycle(given.clock) <= begin + self.end => {
                self.given.push((channel, given));
                Ok(())
            }
            Some(_) => Ok(()),
        }
    }

    fn cycle(&mut self, now: u64, seen: &Seen<'_>) -> io::Result<()> {
        let begin = match self.begin {
            Some(begin) => begin,
            None => {
                self.banks.as_ref().map_or(Ok(()), |banks| banks.begin(&mut self.trace))?;
                *self.begin.insert(now)
            }
        };
        if let Some(banks) = &mut self.banks {
            for (channel, given) in self.given.drain(..) {
                let at = banks.clocks.cycle(given.clock) - begin;
                banks.command(&mut self.trace, Some(at), channel, given.command)?;
            }
        }
        let at = now - begin;
        for (unit, &cause) in self.units.iter_mut().zip(seen.units) {
            if unit.cause != Some(cause) {
                if unit.cause.replace(cause).is_some() {
                    self.trace.end_slice(at, unit.track)?;
                }
                self.trace.begin_slice(at, unit.track, self.causes[cause as usize])?;
            }
        }
        if at.is_multiple_of(LOOK_CYCLES) {
            for (counter, &value) in self.counters.iter_mut().zip(seen.queues.iter().chain(seen.misses)) {
                if counter.value.replace(value) != Some(value) {
                    self.trace.count(at, counter.track, value.into())?;
                }
            }
        }
        self.end = at + 1;
        Ok(())
    }
}
