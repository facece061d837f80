//! The rules of a ray stream. The writer and the reader check every item; code that passes items on in memory can do so
//! too.

use fixedbitset::FixedBitSet;

use super::chunk::{Chunk, Decision, Outcome, Ray, RayKind};
use super::header::{Header, NO_RECORD};
use super::item::{FrameInfo, Item};
use super::limits::Limits;
use super::step::Step;
use super::totals::Totals;
use super::violation::{RayFault, Violation};
use crate::quantity::PixelId;

fn at_most(what: &'static str, found: u64, limit: u64) -> Result<(), Violation> {
    if found <= limit { Ok(()) } else { Err(Violation::Header { what, found, limit }) }
}

/// The number of ids that a packed step can name. A larger count belongs to no stream and would only cost memory.
const MOST_IDS: u64 = Step::MAX_INDEX as u64 + 1;

/// Checks a header's numbers, except its records.
pub(super) fn counts(header: &Header) -> Result<(), Violation> {
    let stores = &header.stores;
    let foreign = header.warmup.iter().filter(|frame| !header.frames.contains(frame)).count();
    at_most("warm-up frames that the stream does not have", foreign as u64, 0)?;
    for (what, found) in [
        ("static nodes", header.static_nodes),
        ("static triangle records", header.static_slots),
        ("static list entries", header.static_list_entries),
        ("mode words", stores.mode_words),
        ("occluder ids", stores.occluder_ids),
        ("primitives", header.primitives),
    ] {
        at_most(what, found.into(), MOST_IDS)?;
    }
    at_most("lights", header.lights.into(), u64::from(u8::MAX) + 1)?;
    at_most("static primitives", header.static_primitives.into(), header.primitives.into())?;
    at_most("pixels", pixels(header), u64::from(u32::MAX) + 1)?;
    at_most("primitives with mode words", stores.word_owners.into(), header.primitives.into())?;
    let words = u64::from(stores.word_owners) * u64::from(stores.words_per_primitive);
    at_most("mode words of primitives", words, stores.mode_words.into())?;
    at_most("pixel counters", stores.pixel_counters.into(), header.primitives.into())
}

/// Checks that every static primitive has a record of its own, or none.
fn records(header: &Header) -> Result<(), Violation> {
    let (records, primitives) = (&header.records, header.static_primitives);
    if records.len() != primitives as usize {
        return Err(Violation::Records { found: records.len(), primitives });
    }
    // Memory grows with the records named, not with the count that the header claims.
    let named = || records.iter().enumerate().filter(|(_, record)| **record != NO_RECORD);
    let end = named().map(|(_, record)| record.0 + 1).max().unwrap_or(0).min(header.static_slots);
    let mut taken = FixedBitSet::with_capacity(end as usize);
    for (primitive, record) in named() {
        if record.0 >= end || taken.put(record.0 as usize) {
            return Err(Violation::Record { primitive, found: record.0 });
        }
    }
    Ok(())
}

/// Checks the items of a stream against its header, one after another.
#[derive(Clone, Debug)]
pub struct Checker {
    header: Header,
    /// Frames that have begun.
    begun: usize,
    in_frame: bool,
    path: Limits,
    policy: Limits,
    /// Totals of the frame's rays so far.
    counted: Totals,
}

impl Checker {
    /// A checker at the start of a stream.
    ///
    /// # Errors
    /// The header contradicts itself.
    pub fn new(header: &Header) -> Result<Self, Violation> {
        counts(header)?;
        records(header)?;
        Ok(Self {
            header: header.clone(),
            begun: 0,
            in_frame: false,
            path: Limits::default(),
            policy: Limits::default(),
            counted: Totals::default(),
        })
    }

    /// The header.
    pub fn header(&self) -> &Header {
        &self.header
    }

    /// The number of the current frame; `None` between frames.
    pub fn frame(&self) -> Option<u32> {
        self.in_frame.then(|| self.header.frames[self.begun - 1])
    }

    /// Continues at the beginning of frame `index` of the header's list.
    pub fn seek(&mut self, index: usize) {
        self.begun = index.min(self.header.frames.len());
        self.in_frame = false;
    }

    /// Checks the next item.
    ///
    /// # Errors
    /// The item breaks a rule of streams.
    pub fn check(&mut self, item: &Item) -> Result<(), Violation> {
        match item {
            Item::Frame(info) => self.begin(info),
            Item::Rays(chunk) => {
                self.inside("rays")?;
                self.rays(chunk)
            }
            Item::End { policy, totals } => {
                self.inside("a frame's end")?;
                self.end(policy, totals)
            }
        }
    }

    /// Checks that the stream may end here.
    ///
    /// # Errors
    /// The stream is not complete.
    pub fn finish(&self) -> Result<(), Violation> {
        if self.in_frame {
            return Err(Violation::Order { found: "the stream's end", expected: "more of the frame" });
        }
        match self.header.frames.get(self.begun) {
            None => Ok(()),
            Some(&expected) => Err(Violation::MissingFrame { expected }),
        }
    }

    fn inside(&self, found: &'static str) -> Result<(), Violation> {
        if self.in_frame { Ok(()) } else { Err(Violation::Order { found, expected: "a frame's beginning" }) }
    }

    fn begin(&mut self, info: &FrameInfo) -> Result<(), Violation> {
        if self.in_frame {
            return Err(Violation::Order { found: "a frame's beginning", expected: "more of the frame" });
        }
        match self.header.frames.get(self.begun) {
            None => return Err(Violation::ExtraFrame { found: info.number }),
            Some(&expected) if expected != info.number => {
                return Err(Violation::Frame { found: info.number, expected });
            }
            Some(_) => {}
        }
        let header = &self.header;
        for (what, statics, dynamic) in [
            ("nodes of a frame", header.static_nodes, info.dynamic_nodes),
            ("triangle records of a frame", header.static_slots, info.dynamic_slots),
            ("list entries of a frame", header.static_list_entries, info.dynamic_list_entries),
        ] {
            at_most(what, u64::from(statics) + u64::from(dynamic), MOST_IDS)?;
        }
        let all = |step: Step| match step {
            Step::Node(_) => u64::from(header.static_nodes) + u64::from(info.dynamic_nodes),
            Step::List(_) => u64::from(header.static_list_entries) + u64::from(info.dynamic_list_entries),
            Step::Triangle { .. } => u64::from(header.static_slots) + u64::from(info.dynamic_slots),
            Step::Read { store, .. } | Step::Write { store, .. } | Step::Update { store, .. } => {
                u64::from(header.stores.of(store))
            }
        };
        self.path = Limits::new(|step| if step.is_traversal() { all(step) } else { 0 });
        self.policy = Limits::new(all);
        self.counted = Totals::default();
        self.begun += 1;
        self.in_frame = true;
        Ok(())
    }

    fn rays(&mut self, chunk: &Chunk) -> Result<(), Violation> {
        let extent = chunk.extent();
        let fits = !extent.strays() && extent.unknown().is_none() && self.policy.hold(&extent);
        let mut group = 0;
        for (index, ray) in chunk.rays().enumerate() {
            if ray.head.kind == RayKind::Primary {
                group = index;
            }
            let mut checked = self.ray(chunk, group, index, &ray);
            if !fits {
                // Some step is wrong: each ray's steps are searched for it.
                checked = checked.and_then(|()| self.steps(&ray));
            }
            checked.map_err(|fault| Violation::Ray { ray: index, fault })?;
        }
        self.counted.count_chunk(chunk);
        Ok(())
    }

    /// Checks the steps of a ray.
    fn steps(&self, ray: &Ray<'_>) -> Result<(), RayFault> {
        self.path.check(ray.packed_path()).map_err(RayFault::Path)?;
        self.policy.check(ray.packed_policy()).map_err(RayFault::Policy)
    }

    /// Checks ray `index`, whose pixel group begins at ray `group`, except its steps.
    fn ray(&self, chunk: &Chunk, group: usize, index: usize, ray: &Ray<'_>) -> Result<(), RayFault> {
        let header = &self.header;
        let head = ray.head;
        if head.kind == RayKind::Primary {
            if head.parent != 0 {
                return Err(RayFault::Parent(head.parent));
            }
            if u64::from(head.pixel.0) >= pixels(header) {
                return Err(RayFault::Pixel { found: head.pixel.0, pixels: pixels(header) });
            }
        } else {
            if index == 0 {
                return Err(RayFault::FirstRay);
            }
            if head.parent == 0 || head.parent as usize > index - group {
                return Err(RayFault::Parent(head.parent));
            }
            if !matches!(chunk.head(index - head.parent as usize).outcome, Outcome::Hit(_)) {
                return Err(RayFault::ParentWithoutHit(head.parent));
            }
            let PixelId(pixel) = chunk.head(group).pixel;
            if head.pixel.0 != pixel {
                return Err(RayFault::OtherPixel { found: head.pixel.0, group: pixel });
            }
        }
        let shadow = head.kind == RayKind::Shadow;
        // Rays other than shadow rays must name light 0.
        let lights = if shadow { header.lights } else { 1 };
        if u32::from(head.light.0) >= lights {
            return Err(RayFault::Light { found: head.light.0, lights });
        }
        if !shadow && head.decision != Decision::Trace {
            return Err(RayFault::Decision);
        }
        match (shadow, head.outcome) {
            (true, Outcome::Lit | Outcome::Dark) | (false, Outcome::Miss) => {}
            (false, Outcome::Hit(primitive)) if primitive.0 < header.primitives => {}
            (false, Outcome::Hit(primitive)) => {
                return Err(RayFault::Primitive { found: primitive.0, primitives: header.primitives });
            }
            (_, outcome) => return Err(RayFault::Outcome { kind: head.kind, outcome }),
        }
        if head.decision == Decision::Skip && !ray.packed_path().is_empty() {
            return Err(RayFault::SkippedPath(ray.packed_path().len()));
        }
        Ok(())
    }

    fn end(&mut self, policy: &[u32], totals: &Totals) -> Result<(), Violation> {
        self.policy.check(policy).map_err(Violation::End)?;
        self.counted.count_policy(policy.iter().filter_map(|&word| Step::unpack(word)));
        let pairs = totals.values().into_iter().zip(self.counted.values());
        for ((recorded, counted), counter) in pairs.zip(Totals::DECLARED) {
            if recorded != counted {
                return Err(Violation::Totals { what: counter.name, recorded, counted });
            }
        }
        self.in_frame = false;
        Ok(())
    }
}

fn pixels(header: &Header) -> u64 {
    u64::from(header.resolution.width) * u64::from(header.resolution.height)
}
