//! Writes traces for Perfetto: protobuf packets with its `TrackEvent` messages.
//!
//! Field numbers are those of `protos/perfetto/trace/trace_packet.proto` and `track_event/*.proto` of Perfetto 0.59.
//! Names are interned, and timestamps are differences on the packet sequence's own clock, so that a slice takes some
//! 30 bytes.

use std::io;

use smallvec::SmallVec;

use crate::experiment::export_file::ExportFile;

/// The id of the only packet sequence.
const SEQUENCE: u64 = 1;
/// The sequence's own clock: ids 64 to 127 are for such clocks.
const CLOCK: u64 = 64;
/// Perfetto's clock `BOOTTIME`, the default time of traces.
const BOOTTIME: u64 = 6;
/// `SEQ_INCREMENTAL_STATE_CLEARED` and `SEQ_NEEDS_INCREMENTAL_STATE`.
const CLEARED: u64 = 1;
const NEEDS_STATE: u64 = 2;

/// Fields of `TracePacket`.
mod packet {
    pub(super) const CLOCK_SNAPSHOT: u64 = 6;
    pub(super) const TIMESTAMP: u64 = 8;
    pub(super) const SEQUENCE_ID: u64 = 10;
    pub(super) const TRACK_EVENT: u64 = 11;
    pub(super) const INTERNED_DATA: u64 = 12;
    pub(super) const SEQUENCE_FLAGS: u64 = 13;
    pub(super) const DEFAULTS: u64 = 59;
    pub(super) const DEFAULT_CLOCK_ID: u64 = 58;
    pub(super) const TRACK_DESCRIPTOR: u64 = 60;
}

/// Types of `TrackEvent`.
#[derive(Clone, Copy)]
enum EventType {
    Begin = 1,
    End = 2,
    Instant = 3,
    Counter = 4,
}

/// A track: the events of one part.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Track(u64);

/// An interned name of slices.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Name(u64);

/// A trace that is being written.
pub(super) struct Trace {
    file: ExportFile,
    tracks: u64,
    names: u64,
    /// The time of the last event.
    now: u64,
    /// Slices that were begun.
    slices: u64,
}

impl Trace {
    /// Begins a trace.
    ///
    /// # Errors
    /// The file cannot be written.
    pub(super) fn begin(file: ExportFile) -> io::Result<Self> {
        let mut trace = Self { file, tracks: 0, names: 0, now: 0, slices: 0 };
        let boot = Message::new().number(1, BOOTTIME).number(2, 0);
        // Clock.is_incremental: timestamps are differences.
        let own = Message::new().number(1, CLOCK).number(2, 0).number(3, 1);
        let clocks = Message::new().message(1, &boot).message(1, &own).number(2, BOOTTIME);
        let defaults = Message::new().number(packet::DEFAULT_CLOCK_ID, CLOCK);
        let first = Message::new()
            .message(packet::CLOCK_SNAPSHOT, &clocks)
            .message(packet::DEFAULTS, &defaults)
            .number(packet::SEQUENCE_FLAGS, CLEARED);
        trace.put(first)?;
        Ok(trace)
    }

    /// Adds a track for slices, below `parent`.
    ///
    /// # Errors
    /// The file cannot be written.
    pub(super) fn track(&mut self, parent: Option<Track>, name: &str) -> io::Result<Track> {
        self.describe(parent, name, Message::new())
    }

    /// Adds a track for a counter, below `parent`.
    ///
    /// # Errors
    /// The file cannot be written.
    pub(super) fn counter(&mut self, parent: Track, name: &str, unit: &str) -> io::Result<Track> {
        let counter = Message::new().text(6, unit);
        self.describe(Some(parent), name, Message::new().message(8, &counter))
    }

    fn describe(&mut self, parent: Option<Track>, name: &str, kind: Message) -> io::Result<Track> {
        self.tracks += 1;
        // Perfetto shows tracks in the order in which they are described.
        let (explicit, rank) = ((11, 3), (12, self.tracks));
        let mut track = Message::new().number(1, self.tracks).text(2, name);
        if let Some(Track(parent)) = parent {
            track = track.number(5, parent);
        }
        let track = track.number(explicit.0, explicit.1).number(rank.0, rank.1).append(kind);
        self.put(Message::new().message(packet::TRACK_DESCRIPTOR, &track))?;
        Ok(Track(self.tracks))
    }

    /// Interns a name for slices.
    ///
    /// # Errors
    /// The file cannot be written.
    pub(super) fn name(&mut self, name: &str) -> io::Result<Name> {
        self.names += 1;
        let entry = Message::new().number(1, self.names).text(2, name);
        let interned = Message::new().message(2, &entry);
        let message = Message::new().message(packet::INTERNED_DATA, &interned);
        self.put(message.number(packet::SEQUENCE_FLAGS, NEEDS_STATE))?;
        Ok(Name(self.names))
    }

    /// Begins a slice on a track at time `at`. The track's earlier slice must have ended.
    ///
    /// # Errors
    /// See [`Trace::end_slice`].
    pub(super) fn begin_slice(&mut self, at: u64, track: Track, Name(name): Name) -> io::Result<()> {
        self.slices += 1;
        self.event(at, EventType::Begin, track, Message::new().number(10, name))
    }

    /// Ends the slice of a track.
    ///
    /// # Errors
    /// The file cannot be written, or `at` lies before an event that was written.
    pub(super) fn end_slice(&mut self, at: u64, track: Track) -> io::Result<()> {
        self.event(at, EventType::End, track, Message::new())
    }

    /// Adds an event without duration.
    ///
    /// # Errors
    /// See [`Trace::end_slice`].
    pub(super) fn instant(&mut self, at: u64, track: Track, Name(name): Name) -> io::Result<()> {
        self.event(at, EventType::Instant, track, Message::new().number(10, name))
    }

    /// Sets a counter's value from `at` on.
    ///
    /// # Errors
    /// See [`Trace::end_slice`].
    pub(super) fn count(&mut self, at: u64, track: Track, value: u64) -> io::Result<()> {
        self.event(at, EventType::Counter, track, Message::new().number(30, value))
    }

    fn event(&mut self, at: u64, kind: EventType, Track(track): Track, rest: Message) -> io::Result<()> {
        let later = at.checked_sub(self.now).ok_or_else(|| {
            io::Error::other(format!("an event of cycle {at} of the timeline comes after one of cycle {}", self.now))
        })?;
        self.now = at;
        let event = Message::new().number(9, kind as u64).number(11, track).append(rest);
        let message = Message::new().number(packet::TIMESTAMP, later).message(packet::TRACK_EVENT, &event);
        self.put(message.number(packet::SEQUENCE_FLAGS, NEEDS_STATE))
    }

    /// Writes a packet: field 1 of `Trace`.
    fn put(&mut self, message: Message) -> io::Result<()> {
        let message = message.number(packet::SEQUENCE_ID, SEQUENCE);
        self.file.bytes(Message::new().message(1, &message).bytes())
    }

    /// The number of slices that were begun.
    pub(super) fn slices(&self) -> u64 {
        self.slices
    }

    /// Puts the file into its place.
    ///
    /// # Errors
    /// The file cannot be written.
    pub(super) fn finish(self) -> io::Result<()> {
        self.file.finish()
    }
}

/// A protobuf message. All fields have wire type 0 (a number) or 2 (bytes).
#[derive(Clone, Debug, Default)]
struct Message(SmallVec<[u8; 64]>);

impl Message {
    fn new() -> Self {
        Self::default()
    }

    fn bytes(&self) -> &[u8] {
        &self.0
    }

    fn varint(&mut self, mut value: u64) {
        while value >= 0x80 {
            self.0.push(value as u8 | 0x80);
            value >>= 7;
        }
        self.0.push(value as u8);
    }

    fn number(mut self, field: u64, value: u64) -> Self {
        self.varint(field << 3);
        self.varint(value);
        self
    }

    fn text(self, field: u64, text: &str) -> Self {
        self.field(field, text.as_bytes())
    }

    fn message(self, field: u64, message: &Self) -> Self {
        self.field(field, &message.0)
    }

    fn field(mut self, field: u64, bytes: &[u8]) -> Self {
        self.varint(field << 3 | 2);
        self.varint(bytes.len() as u64);
        self.0.extend_from_slice(bytes);
        self
    }

    /// Appends the fields of `other`.
    fn append(mut self, other: Self) -> Self {
        self.0.extend_from_slice(&other.0);
        self
    }
}
