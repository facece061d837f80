//! Where a policy's stores lie in memory: layouts of mode words and counters, and what an access to an entry touches.

use std::sync::Arc;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::word_traffic::LatchedCopy;
use crate::quantity::TriangleSlot;
use crate::stream::{Header, NO_RECORD, Step, Store};

/// Bytes of an entry of a store that is an array of its own.
const WORD_BYTES: u64 = 4;
/// Bytes of a primitive's two counters (GI09: current and highest number of rendered pixels).
const COUNTER_BYTES: u64 = 8;
/// Bits of the frame's number in a word, for [`FrameEnd::Epoch`](super::shadow_cache::FrameEnd::Epoch).
pub const TAG_BITS: u64 = 2;
/// Bits of two counters on a logarithmic scale with one fractional bit each: 6 bits reach 2^31 pixels.
const LOG_COUNTER_BITS: u64 = 2 * 6;
/// A triangle record is a multiple of this: the plane's 16 bytes.
const RECORD_STEP: u64 = 16;

/// How mode words and counters of primitives lie in memory. A primitive has as many 32-bit mode words as the stream
/// says: one up to 15 lights, another for each further 16.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub enum StoreLayout {
    /// An array of 32-bit words, and one of counters, 8 bytes a primitive.
    #[default]
    Dense,
    /// Of each word only the bits that the lights need, rounded up to 4, 8, 16 or 32; counters as in `Dense`.
    Packed,
    /// Words and counters of a primitive side by side, as many primitives to a line as fit whole.
    Beside,
    /// Behind the triangle, in its record: counters, then words; the record grows from 48 bytes to the next multiple of
    /// 16.
    Record,
    /// One word a primitive for modes, counters on a logarithmic scale and the frame's tag; more than 8 lights take
    /// another word.
    Tagged,
}

/// Where a primitive's part of an array begins, and how far the next one's is.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Rows {
    base: u64,
    /// Bytes a primitive.
    bytes: u64,
    /// Primitives a line; 0 where they follow one another without regard to lines.
    per_line: u64,
    line: u64,
}

impl Rows {
    fn packed(bytes: u64) -> Self {
        Self { bytes, ..Self::default() }
    }

    /// Primitives that lie in no more lines than they must.
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

/// Triangle records of primitives, as the stream's header has them.
#[derive(Clone, Debug)]
struct Records(Arc<[TriangleSlot]>);

impl PartialEq for Records {
    fn eq(&self, other: &Self) -> bool {
        // Layouts of one stream share them, and are often compared.
        Arc::ptr_eq(&self.0, &other.0) || self.0 == other.0
    }
}

/// The stores of a stream, laid out.
#[derive(Clone, Debug, PartialEq)]
pub struct Stores {
    layout: StoreLayout,
    owners: u64,
    words: u64,
    /// Bytes of a primitive's mode word.
    word_bytes: u64,
    /// Entries of the store of mode words: from there on they are learned bits, if those have words of their own.
    entries: u64,
    learned: Option<u64>,
    /// Bits of a primitive's modes, for `Packed`.
    bits: u64,
    /// Bytes of a primitive's counters; 0 if the policy keeps none.
    counter_bytes: u64,
    /// Whether counters and tag need a word of their own, for `Tagged`.
    further_word: bool,
    word_rows: Rows,
    counter_rows: Rows,
    /// Entries of the store of mode words that are not of a primitive.
    rest: u64,
    occluders: u64,
    records: Records,
    /// Where static triangle records begin, their size, and how much of it is the triangle.
    triangle_records: (u64, u64, u64),
}

/// Checks that words have room for the frame's number, if they are to hold it, beside the modes of the stream's lights.
///
/// # Errors
/// The words of the stream's lights leave no room.
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
    /// The stores of a stream, not placed yet. `tagged` says whether words hold the frame's number.
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

    /// Bytes that each triangle record holds for the stores, rounded so that records stay aligned.
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

    /// Places the stores: `array` gives room for so many bytes and says where.
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

    /// Where an entry begins, and how many bytes an access to it touches. No entry lies in two lines.
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

    /// What follows the triangle in the record of a primitive, if that is static and has one.
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
            // With a further word, the first mode word is read together with it: that has the tag.
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

    /// Whether the step is an update of a primitive's mode word, or of its learned bits.
    pub fn updates_word(&self, step: Step) -> bool {
        match step {
            Step::Update { store: Store::ModeWord, index } => {
                let index = u64::from(index);
                index < self.owners * self.words || index >= self.entries
            }
            _ => false,
        }
    }

    /// The update of learned bits that stands in place of a ray's update of a mode word, if they have words of
    /// their own.
    pub fn learns(&self, step: Step) -> Option<Step> {
        match step {
            Step::Update { store: Store::ModeWord, index } if self.learned.is_some() && self.updates_word(step) => {
                Some(Step::Update { store: Store::ModeWord, index: index + self.entries as u32 })
            }
            _ => None,
        }
    }

    /// What takes learned bits into the latched word at the frame's end: a read of the bits of the update
    /// `learned`, and an update.
    pub fn fold(&self, learned: u32) -> [Step; 2] {
        let store = Store::ModeWord;
        [Step::Read { store, index: learned }, Step::Update { store, index: learned - self.entries as u32 }]
    }

    /// Whether counters and first mode word of a primitive are one entry.
    pub fn counters_are_in_words(&self) -> bool {
        self.layout == StoreLayout::Tagged
    }

    /// The primitive whose word or counters an entry is; `None` for one of no primitive.
    pub fn owner(&self, store: Store, index: u32) -> Option<u32> {
        match store {
            Store::PixelCounter => Some(index),
            Store::ModeWord if u64::from(index) < self.owners * self.words => Some(index / self.words as u32),
            Store::ModeWord | Store::OccluderId => None,
        }
    }
}
