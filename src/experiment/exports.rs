//! Files that a replay writes besides its figures.

use std::io;

use super::dram_export::DramExport;
use super::interval_export::IntervalExport;
use super::timeline::Timeline;
use crate::memory::dram::command::{LoggedCommand, LoggedRequest};
use crate::replay::{Observer, Seen};
use crate::stats::MachineStats;

/// The files to be written during a run.
#[derive(Default)]
pub(crate) struct Exports {
    /// Requests to the DRAM and its commands.
    pub dram: Option<DramExport>,
    /// A frame's timeline.
    pub timeline: Option<Timeline>,
    /// Counters at a fixed interval of cycles.
    pub interval: Option<IntervalExport>,
}

impl Exports {
    /// Whether no file is wanted.
    pub(crate) fn is_empty(&self) -> bool {
        self.all().next().is_none()
    }

    /// Puts the files into their places. Returns a message for the user.
    ///
    /// # Errors
    /// A file cannot be written.
    pub(crate) fn finish(self) -> io::Result<Option<String>> {
        self.dram.map_or(Ok(()), DramExport::finish)?;
        self.interval.map_or(Ok(()), IntervalExport::finish)?;
        self.timeline.map(Timeline::finish).transpose()
    }

    fn all(&self) -> impl Iterator<Item = &dyn Observer> {
        let dram = self.dram.as_ref().map(|it| it as &dyn Observer);
        let timeline = self.timeline.as_ref().map(|it| it as &dyn Observer);
        let interval = self.interval.as_ref().map(|it| it as &dyn Observer);
        dram.into_iter().chain(timeline).chain(interval)
    }

    fn tell(&mut self, mut tell: impl FnMut(&mut dyn Observer) -> io::Result<()>) -> io::Result<()> {
        self.dram.as_mut().map_or(Ok(()), |it| tell(it))?;
        self.timeline.as_mut().map_or(Ok(()), |it| tell(it))?;
        self.interval.as_mut().map_or(Ok(()), |it| tell(it))
    }
}

impl Observer for Exports {
    fn wants_dram(&self) -> bool {
        self.all().any(Observer::wants_dram)
    }

    fn request(&mut self, channel: usize, request: LoggedRequest) -> io::Result<()> {
        self.tell(|it| it.request(channel, request))
    }

    fn command(&mut self, channel: usize, command: LoggedCommand) -> io::Result<()> {
        self.tell(|it| it.command(channel, command))
    }

    fn interval(&self) -> Option<u64> {
        self.all().find_map(Observer::interval)
    }

    fn counted(&mut self, frame: u32, stats: MachineStats) -> io::Result<()> {
        self.interval.as_mut().map_or(Ok(()), |it| it.counted(frame, stats))
    }

    fn watched_frame(&self) -> Option<u32> {
        self.all().find_map(Observer::watched_frame)
    }

    fn cycle(&mut self, now: u64, seen: &Seen<'_>) -> io::Result<()> {
        self.timeline.as_mut().map_or(Ok(()), |it| it.cycle(now, seen))
    }
}
