//! The memory layout of a policy's stores: mode words, counters and occluder ids, and the bytes that an access touches.

use std::sync::Arc;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::word_traffic::LatchedCopy;
use crate::quantity::TriangleSlot;
use crate::stream::{Header, NO_RECORD, Step, Store};

/// Bytes of a mode word, an occluder id and an entry of learned bits.
const WORD_BYTES: u64 = 4;
/// Bytes of a primitive's two counters (GI09: current and highest number of rendered pixels).
const COUNTER_BYTES: u64 = 8;
/// Bits of the frame's number in a word, for [`FrameEnd::Epoch`](super::shadow_cache::FrameEnd::Epoch).
pub const TAG_BITS: u64 = 2;
/// Bits of two counters on a logarithmic scale with one fractional bit each: 6 bits reach 2^31 pixels.
const LOG_COUNTER_BITS: u64 = 2 * 6;
/// A triangle record is a multiple of the plane's 16 bytes.
const RECORD_STEP: u64 = 16;

/// The layout of mode words and counters in memory. A primitive has one 32-bit mode word for up to 15 lights, and one
/// more for every further 16.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub enum StoreLayout {
    /// An array of 32-bit mode words, and an array of counters with 8 bytes per primitive.
    #[default]
    Dense,
    /// Mode words have only the bits that the lights need, rounded up to 4, 8, 16 or 32. Counters as in `Dense`.
    Packed,
    /// Mode words and counters of a primitive side by side. A line holds only whole primitives.
    Beside,
    /// Counters, then mode words, behind the triangle in its record. The record grows from 48 bytes to the next
    /// multiple of 16.
    Record,
    /// One word per primitive holds modes, counters on a logarithmic scale and the frame's tag. More than 8 lights need
    /// another word.
    Tagged,
}

/// The placing of primitives' entries in an array: base address and stride.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Rows {
    base: u64,
    /// Bytes a primitive.
    bytes: u64,
    /// Primitives per line; 0 if they follow one another without regard to lines.
    per_line: u64,
    line: u64,
}

impl Rows {
    fn packed(bytes: u64) -> Self {
        Self { bytes, ..Self::default() }
    }

    /// Rows that never straddle a line unless a row is longer than one.
    fn in_lines(bytes: u64, line: u64) -> Self {
        match line / bytes {
            0 => Self::packed(bytes.next_multiple_of(line)),
            per_line => Self { base: 0, bytes, per_line, line },
        }
    }

    fn addr(&self, row: u64) -> u64 {
        let offset = match self.per_line {
            0 => row * self.bytes,
            rows => row / rows * self.line + row % rows * self.bytes,
        };
        self.base + offset
    }

    fn size(&self, rows: u64) -> u64 {
        match self.per_line {
            0 => rows * self.bytes,
            per_line => rows.div_ceil(per_line) * self.line,
        }
    }
}

/// The triangle record of each primitive, from the stream's header.
#[derive(Clone, Debug)]
struct Records(Arc<[TriangleSlot]>);

impl PartialEq for Records {
    fn eq(&self, other: &Self) -> bool {
        // Layouts of one stream share the records and are often compared.
        Arc::ptr_eq(&self.0, &other.0) || self.0 == other.0
    }
}

/// The stores of a stream, laid out.
#[derive(Clone, Debug, PartialEq)]
pub struct Stores {
    layout: StoreLayout,
    owners: u64,
    words: u64,
    /// Bytes of one mode word.
    word_bytes: u64,
    /// Entries of the store of mode words. Larger indices are learned bits, if those have words of their own.
    entries: u64,
    learned: Option<u64>,
    /// Bits of a primitive's modes, for `Packed`.
    bits: u64,
    /// Bytes of a primitive's counters; 0 if the policy keeps none.
    counter_bytes: u64,
    /// Whether counters and tag need another word, for `Tagged`.
    further_word: bool,
    word_rows: Rows,
    counter_rows: Rows,
    /// Base of the mode words that belong to no primitive.
    rest: u64,
    occluders: u64,
    records: Records,
    /// Static triangle records: base, bytes of a record, and bytes of the triangle in it.
    triangle_records: (u64, u64, u64),
}

/// Checks that the words have room for the frame's number beside the modes of the stream's lights.
///
/// # Errors
/// The modes of the stream's lights fill the words.
pub fn check_tag(header: &Header, layout: StoreLayout) -> Result<(), String> {
    let (lights, words) = (header.lights, header.stores.words_per_primitive);
    if header.stores.word_owners == 0
        || layout == StoreLayout::Tagged
        || mode_bits(header) + TAG_BITS <= 32 * u64::from(words)
    {
        return Ok(());
    }
    Err(format!(
        "`shadow_cache.frame_end` is Epoch, which needs {TAG_BITS} bits beside the modes of the stream's {lights} lights, and these fill \
         {words} word(s) of 32 bits: `List`, `Sweep`, or `layout: Tagged` is allowed"
    ))
}

fn mode_bits(header: &Header) -> u64 {
    2 + 2 * u64::from(header.lights)
}

impl Stores {
    /// The stores of a stream, before they are placed. `tagged`: whether words hold the frame's number.
    pub fn new(header: &Header, layout: StoreLayout, copy: LatchedCopy, tagged: bool, line: u64) -> Self {
        let entries = &header.stores;
        let (owners, words) = (u64::from(entries.word_owners), u64::from(entries.words_per_primitive));
        let learns = entries.pixel_counters > 0;
        let wide = copy == LatchedCopy::Wide && learns;
        let modes = mode_bits(header) * if wide { 2 } else { 1 };
        let modes_and_tag = modes + if tagged || wide { TAG_BITS } else { 0 };
        let word_bytes = if wide && modes_and_tag > 32 * words { 2 * WORD_BYTES } else { WORD_BYTES };
        let bits = match modes_and_tag {
            bits @ ..=16 => bits.next_power_of_two(),
            _ => 8 * word_bytes * words,
        };
        let counter_bytes = if entries.pixel_counters > 0 { COUNTER_BYTES } else { 0 };
        let further_word = words > 1 || modes + LOG_COUNTER_BITS + TAG_BITS > 8 * word_bytes;
        let (word_rows, counter_rows) = match layout {
            StoreLayout::Dense | StoreLayout::Packed | StoreLayout::Record => {
                (Rows::packed(words * word_bytes), Rows::packed(COUNTER_BYTES))
            }
            StoreLayout::Beside => {
                let rows = Rows::in_lines((counter_bytes + words * word_bytes).max(1), line);
                (rows, rows)
            }
            StoreLayout::Tagged => {
                let extra = if further_word { word_bytes } else { 0 };
                let rows = Rows::in_lines((words * word_bytes + extra).max(1), line);
                (rows, rows)
            }
        };
        Self {
            layout,
            owners,
            words,
            word_bytes,
            entries: entries.mode_words.into(),
            learned: (copy == LatchedCopy::Buffers && learns).then_some(0),
            bits,
            counter_bytes,
            further_word,
            word_rows,
            counter_rows,
            rest: 0,
            occluders: 0,
            records: Records(Arc::clone(&header.records)),
            triangle_records: (0, 0, 0),
        }
    }

    /// Bytes of a triangle record with the stores' part, rounded so that records stay aligned.
    pub fn record_bytes(&self, triangle: u64) -> u64 {
        match self.layout {
            StoreLayout::Record if self.owners > 0 => {
                (triangle + self.counter_bytes + self.words * self.word_bytes).next_multiple_of(RECORD_STEP)
            }
            _ => triangle,
        }
    }

    /// Static triangle records of `record` bytes begin at `base`; the triangle takes the first `triangle` bytes of
    /// each.
    pub fn set_records(&mut self, base: u64, record: u64, triangle: u64) {
        self.triangle_records = (base, record, triangle);
    }

    /// Places the stores; `array` reserves the given number of bytes and returns their address.
    pub fn place(&mut self, header: &Header, mut array: impl FnMut(u64) -> u64) {
        let entries = &header.stores;
        let rest = u64::from(entries.mode_words) - self.owners * self.words;
        let counters = u64::from(entries.pixel_counters);
        match self.layout {
            StoreLayout::Dense | StoreLayout::Record => {
                self.word_rows.base = array(self.word_rows.size(self.owners));
                self.rest = array(rest * WORD_BYTES);
                self.counter_rows.base = array(self.counter_rows.size(counters));
            }
            StoreLayout::Packed => {
                self.word_rows.base = array((self.owners * self.bits).div_ceil(8));
                self.rest = array(rest * WORD_BYTES);
                self.counter_rows.base = array(self.counter_rows.size(counters));
            }
            StoreLayout::Beside | StoreLayout::Tagged => {
                self.word_rows.base = array(self.word_rows.size(self.owners.max(counters)));
                self.counter_rows.base = self.word_rows.base;
                self.rest = array(rest * WORD_BYTES);
            }
        }
        self.occluders = array(u64::from(entries.occluder_ids) * WORD_BYTES);
        let learned = self.owners * self.words * WORD_BYTES;
        self.learned = self.learned.map(|_| array(learned));
    }

    /// The address of an entry, and the bytes that an access to it touches. No entry straddles two lines.
    pub fn entry(&self, store: Store, index: u32) -> (u64, u64) {
        let index = u64::from(index);
        match store {
            Store::OccluderId => (self.occluders + index * WORD_BYTES, WORD_BYTES),
            Store::PixelCounter => self.counters(index),
            Store::ModeWord if index >= self.entries => {
                let learned = self.learned.expect("an entry beyond the store's is of learned bits");
                (learned + (index - self.entries) * WORD_BYTES, WORD_BYTES)
            }
            Store::ModeWord => match index.checked_sub(self.owners * self.words) {
                Some(rest) => (self.rest + rest * WORD_BYTES, WORD_BYTES),
                None if self.words == 1 => self.word(index, 0),
                None => self.word(index / self.words, index % self.words),
            },
        }
    }

    /// The address behind the triangle in the primitive's record; `None` if the primitive is dynamic or has no record.
    fn in_record(&self, primitive: u64) -> Option<u64> {
        let slot = self.records.0.get(primitive as usize).filter(|&&slot| slot != NO_RECORD)?;
        let (base, record, triangle) = self.triangle_records;
        Some(base + u64::from(slot.0) * record + triangle)
    }

    fn word(&self, primitive: u64, word: u64) -> (u64, u64) {
        let row = self.word_rows.addr(primitive);
        match self.layout {
            StoreLayout::Packed if self.bits < 32 => {
                (self.word_rows.base + primitive * self.bits / 8, (self.bits / 8).max(1))
            }
            StoreLayout::Record => {
                let words = self.in_record(primitive).map_or(row, |counters| counters + self.counter_bytes);
                (words + word * self.word_bytes, self.word_bytes)
            }
            // The further word holds the tag, so the first mode word is read together with it.
            StoreLayout::Tagged if self.further_word => match word {
                0 => (row, 2 * self.word_bytes),
                _ => (row + (word + 1) * self.word_bytes, self.word_bytes),
            },
            StoreLayout::Beside => (row + self.counter_bytes + word * self.word_bytes, self.word_bytes),
            _ => (row + word * self.word_bytes, self.word_bytes),
        }
    }

    fn counters(&self, primitive: u64) -> (u64, u64) {
        let row = self.counter_rows.addr(primitive);
        match self.layout {
            StoreLayout::Dense | StoreLayout::Packed | StoreLayout::Beside => (row, COUNTER_BYTES),
            StoreLayout::Record => (self.in_record(primitive).unwrap_or(row), COUNTER_BYTES),
            StoreLayout::Tagged => (row, self.word_bytes),
        }
    }

    /// Whether the step updates a primitive's mode word or its learned bits.
    pub fn updates_word(&self, step: Step) -> bool {
        match step {
            Step::Update { store: Store::ModeWord, index } => {
                let index = u64::from(index);
                index < self.owners * self.words || index >= self.entries
            }
            _ => false,
        }
    }

    /// The update of learned bits that replaces a ray's update of a mode word, if learned bits have words of their own.
    pub fn learns(&self, step: Step) -> Option<Step> {
        match step {
            Step::Update { store: Store::ModeWord, index } if self.learned.is_some() && self.updates_word(step) => {
                Some(Step::Update { store: Store::ModeWord, index: index + self.entries as u32 })
            }
            _ => None,
        }
    }

    /// The steps at the end of a frame that merge learned bits into the latched word: a read of the bits of the update
    /// `learned`, and an update of the word.
    pub fn fold(&self, learned: u32) -> [Step; 2] {
        let store = Store::ModeWord;
        [Step::Read { store, index: learned }, Step::Update { store, index: learned - self.entries as u32 }]
    }

    /// Whether the counters and the first mode word of a primitive are one entry.
    pub fn counters_are_in_words(&self) -> bool {
        self.layout == StoreLayout::Tagged
    }

    /// The primitive that an entry's word or counters belong to; `None` if the entry belongs to no primitive.
    pub fn owner(&self, store: Store, index: u32) -> Option<u32> {
        match store {
            Store::PixelCounter => Some(index),
            Store::ModeWord if u64::from(index) < self.owners * self.words => Some(index / self.words as u32),
            Store::ModeWord | Store::OccluderId => None,
        }
    }
}
