//! The rules of a ray stream. The writer and the reader hold every item against them, and so can whoever passes items
//! on in memory.

use rustc_hash::FxHashSet;

use super::{Chunk, Decision, FrameInfo, Header, Item, NO_RECORD, Outcome, Ray, RayKind, Step, Totals};
use crate::quantity::PixelId;

/// A rule that a stream breaks.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Violation {
    /// A number of the header is more than it can be.
    #[error("{what}: {found}, and at most {limit} are possible")]
    Header {
        /// What is counted.
        what: &'static str,
        /// The number.
        found: u64,
        /// The largest possible.
        limit: u64,
    },
    /// The table of triangle records has another length than there are static primitives.
    #[error("records of {found} static primitives, and there are {primitives}")]
    Records {
        /// Entries of the table.
        found: usize,
        /// Static primitives.
        primitives: u32,
    },
    /// A static primitive's record does not exist, or is another's.
    #[error("the triangle record of primitive {primitive} is {found}, which does not exist or is another's")]
    Record {
        /// The primitive.
        primitive: usize,
        /// The record.
        found: u32,
    },
    /// An item stands where another belongs: every frame is a beginning, any number of rays, and an end.
    #[error("{found} where {expected} belongs")]
    Order {
        /// What came.
        found: &'static str,
        /// What can come here.
        expected: &'static str,
    },
    /// A frame is not the one that follows in the header's list.
    #[error("frame {found} begins where the header lists frame {expected}")]
    Frame {
        /// The frame's number.
        found: u32,
        /// The number in the header.
        expected: u32,
    },
    /// There is a frame more than the header lists.
    #[error("frame {found} begins, but the header lists no further frame")]
    ExtraFrame {
        /// The frame's number.
        found: u32,
    },
    /// There are frames fewer than the header lists.
    #[error("the stream ends, but the header lists frame {expected} as the next")]
    MissingFrame {
        /// The number of the first that is missing.
        expected: u32,
    },
    /// A block would be larger than the format allows.
    #[error("{what} of {found} bytes: at most {limit} fit a block; split it")]
    TooLarge {
        /// What is too large.
        what: &'static str,
        /// Its length before compression, in bytes.
        found: u64,
        /// The largest length.
        limit: u64,
    },
    /// A ray breaks a rule.
    #[error("ray {ray} of the chunk: {fault}")]
    Ray {
        /// The ray's place in its chunk.
        ray: usize,
        /// The rule.
        fault: RayFault,
    },
    /// A step that the policy does at the frame's end breaks a rule.
    #[error("the policy's work at the frame's end: {0}")]
    End(StepFault),
    /// What the tracer counted is not what the records hold.
    #[error("{what} is {recorded} in the totals, and {counted} in the records")]
    Totals {
        /// The total.
        what: &'static str,
        /// What the tracer counted.
        recorded: u64,
        /// What the records hold.
        counted: u64,
    },
}

/// A rule that a ray breaks.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum RayFault {
    /// A chunk begins with another than a primary ray.
    #[error("the first ray of a chunk must be a primary ray")]
    FirstRay,
    /// A primary ray has a parent, or the parent of another ray is not in its pixel group.
    #[error("its parent, {0} rays back, is not in its pixel group")]
    Parent(u32),
    /// Rays start on hits only.
    #[error("its parent, {0} rays back, hits nothing")]
    ParentWithoutHit(u32),
    /// The pixel is not in the picture.
    #[error("pixel {found}, and there are {pixels}")]
    Pixel {
        /// The pixel.
        found: u32,
        /// The picture's pixels.
        pixels: u64,
    },
    /// The pixel is not that of the group's primary ray.
    #[error("pixel {found} in the group of pixel {group}")]
    OtherPixel {
        /// The pixel.
        found: u32,
        /// The pixel of the group.
        group: u32,
    },
    /// The light is not in the scene, or the ray is no shadow ray and has a light.
    #[error("light {found}, and it can have {lights}")]
    Light {
        /// The light.
        found: u8,
        /// How many the ray can name.
        lights: u32,
    },
    /// Only shadow rays are decided on.
    #[error("only a shadow ray can be culled")]
    Decision,
    /// A skipped ray was traced.
    #[error("it is skipped, and yet its path has {0} steps")]
    SkippedPath(usize),
    /// The outcome is none of its kind's.
    #[error("the outcome {outcome:?} is not possible for a ray of kind {}", kind.name())]
    Outcome {
        /// The ray's kind.
        kind: RayKind,
        /// The outcome.
        outcome: Outcome,
    },
    /// The primitive that is hit is not in the scene.
    #[error("primitive {found} is hit, and there are {primitives}")]
    Primitive {
        /// The primitive.
        found: u32,
        /// Primitives of the scene.
        primitives: u32,
    },
    /// A step of the path.
    #[error("path: {0}")]
    Path(StepFault),
    /// A step of the policy.
    #[error("policy: {0}")]
    Policy(StepFault),
}

/// A rule that a step breaks.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum StepFault {
    /// The packed word stands for no step.
    #[error("step {at} is {word:#010x}, which is no step")]
    Unknown {
        /// The step's place.
        at: usize,
        /// The packed word.
        word: u32,
    },
    /// The step cannot be there, or its id is too large.
    #[error("step {at} is {step:?}, and ids below {limit} are possible for it here")]
    Id {
        /// The step's place.
        at: usize,
        /// The step.
        step: Step,
        /// Ids below this are possible; 0 for a step that cannot be there.
        limit: u32,
    },
}
/// Tags that a packed step can have, those of no step included.
const TAGS: usize = 1 << (u32::BITS - INDEX_BITS);
const INDEX_BITS: u32 = Step::MAX_INDEX.trailing_ones();

/// For each tag of a packed step the number of ids that it can have: 0 if the step cannot be there.
#[derive(Clone, Debug, Default)]
struct Limits([u32; TAGS]);

impl Limits {
    fn new(allowed: impl Fn(Step) -> u64) -> Self {
        let mut limits = [0; TAGS];
        for (tag, limit) in limits.iter_mut().enumerate() {
            if let Some(step) = Step::unpack((tag as u32) << INDEX_BITS) {
                // No packed id is larger, whatever the counts say.
                *limit = allowed(step).min(u64::from(Step::MAX_INDEX) + 1) as u32;
            }
        }
        Self(limits)
    }

    fn of(&self, word: u32) -> u32 {
        self.0[(word >> INDEX_BITS) as usize]
    }

    fn check(&self, words: &[u32]) -> Result<(), StepFault> {
        let is_wrong = |&word: &u32| word & Step::MAX_INDEX >= self.of(word);
        // Where one is wrong hardly ever matters, and a loop without a way out is faster.
        if !words.iter().fold(false, |any, word| any | is_wrong(word)) {
            return Ok(());
        }
        let at = words.iter().position(is_wrong).expect("one of them is wrong");
        Err(match Step::unpack(words[at]) {
            None => StepFault::Unknown { at, word: words[at] },
            Some(step) => StepFault::Id { at, step, limit: self.of(words[at]) },
        })
    }
}

fn at_most(what: &'static str, found: u64, limit: u64) -> Result<(), Violation> {
    if found <= limit { Ok(()) } else { Err(Violation::Header { what, found, limit }) }
}

/// Checks a header's numbers, its records apart.
pub(super) fn counts(header: &Header) -> Result<(), Violation> {
    let stores = &header.stores;
    let foreign = header.warmup.iter().filter(|frame| !header.frames.contains(frame)).count();
    at_most("warm-up frames that the stream does not have", foreign as u64, 0)?;
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
    let mut taken = FxHashSet::default();
    for (primitive, &record) in records.iter().enumerate().filter(|(_, record)| **record != NO_RECORD) {
        if record.0 >= header.static_slots || !taken.insert(record) {
            return Err(Violation::Record { primitive, found: record.0 });
        }
    }
    Ok(())
}

/// Holds the items of a stream against its header, one after another.
#[derive(Clone, Debug)]
pub struct Checker {
    header: Header,
    /// Frames that have begun.
    begun: usize,
    in_frame: bool,
    path: Limits,
    policy: Limits,
    /// What the rays of the frame hold so far.
    counted: Totals,
}

impl Checker {
    /// A checker at the start of a stream.
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

    /// The number of the frame that has begun and not ended.
    pub fn frame(&self) -> Option<u32> {
        self.in_frame.then(|| self.header.frames[self.begun - 1])
    }

    /// Continues at the beginning of frame `index` of the header's list.
    pub fn seek(&mut self, index: usize) {
        self.begun = index.min(self.header.frames.len());
        self.in_frame = false;
    }

    /// Checks the next item.
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
        let mut group = 0;
        for (index, ray) in chunk.rays().enumerate() {
            if ray.head.kind == RayKind::Primary {
                group = index;
            }
            self.ray(chunk, group, index, &ray).map_err(|fault| Violation::Ray { ray: index, fault })?;
            self.counted.count(&ray);
        }
        Ok(())
    }

    /// Checks ray `index`, whose pixel group begins at ray `group`.
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
        // Rays that are no shadow rays have the one light 0.
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
        self.path.check(ray.packed_path()).map_err(RayFault::Path)?;
        self.policy.check(ray.packed_policy()).map_err(RayFault::Policy)
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
