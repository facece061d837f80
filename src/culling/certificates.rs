//! Certificates: proofs, kept for cells of static receivers, that a lamp's static answer is the same in the whole
//! cell.
//!
//! A lamp is a light, or all points of an area light: one proof, one mode and one count serve all its points. A cell
//! has one mode for each lamp, in the two bits of the published word: nothing known, FULL_SHADOW and NON_SHADOW (both
//! proven), or PARTIAL_SHADOW (not provable in one piece: see the four child cells). The tree of cells grows where
//! rays ask for it and the answer is not uniform. Nothing in it depends on a unit of length.
//!
//! A certificate holds for one side of a receiver: the side of the first ray. Rays that start on the other side are
//! traced. Bits 1:0 of the whole primitive's word give the side.

use std::collections::BTreeSet;

use glam::Vec3;
use rustc_hash::FxHashMap;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use smallvec::SmallVec;

use super::cells::{Cell, DEEPEST, Inside};
use super::facts::SceneFacts;
use super::mode_word::{SEEN_DARK, SEEN_LIT, Shadow, WordLayout};
use super::policy::{Change, SurfaceHit};
use super::probe::Probe;
use super::ray_counts::RayCounts;
use crate::accel::{Relation, Sight, Trail};
use crate::quantity::{LightId, PrimitiveId};
use crate::ranged::{PowerOfTwo, Within};
use crate::scene::Light;
use crate::stream::{Store, StoreEntries};

/// When proofs are attempted, and how many are stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct CertificateSpec {
    /// A proof is attempted after this many rays from a cell to a light in one band of the picture, all with the same
    /// answer. For an area light, hits are counted.
    pub ask: Within<1, 255>,
    /// A cell without a uniform or provable answer is divided after this many rays from it to a light in one band. For
    /// an area light, hits are counted.
    pub divide: Within<1, 255>,
    /// Maximum number of divisions of a primitive; 0 allows certificates for whole primitives only.
    pub deepest: Within<0, DEEPEST>,
    /// Capacity for cells in addition to the whole primitives. When it is full, no further cell is divided.
    pub cells: Within<0, 16_777_216>,
    /// Slots of the table that counts rays per cell and light.
    pub counts: PowerOfTwo<2, 1_048_576>,
}

impl Default for CertificateSpec {
    /// The settings that save most on the BART scenes for their memory. A proof costs about as much as one ray, so two
    /// rays repay it. Cells that fewer than eight rays meet are seldom met again before the memory is full.
    fn default() -> Self {
        Self {
            ask: const { Within::literal(2) },
            divide: const { Within::literal(8) },
            deepest: const { Within::literal(8) },
            cells: const { Within::literal(131_072) },
            counts: const { PowerOfTwo::literal(4096) },
        }
    }
}

/// A node without children.
const NO_CHILDREN: u32 = 0;

/// The tree of cells, as of the frame's start.
pub(crate) struct Certificates {
    spec: CertificateSpec,
    facts: SceneFacts,
    layout: WordLayout,
    /// Words of all nodes: first the whole primitives, then groups of four.
    words: Vec<u32>,
    /// The first of each node's four children.
    children: Vec<u32>,
    lights: Vec<Light>,
    /// Words that a light's movement cleared; their updates are recorded at the frame's end.
    cleared: Vec<u32>,
}

/// The smallest cell of the tree around a hit, and its mode.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Leaf {
    /// The cell.
    pub cell: Cell,
    /// Its mode; PARTIAL_SHADOW if it cannot be divided any more.
    pub mode: Shadow,
    outside: bool,
}

fn side_bits(outside: bool) -> u32 {
    if outside { 0b01 } else { 0b10 }
}

fn bits(mode: Shadow) -> u32 {
    match mode {
        Shadow::Init => 0,
        Shadow::Full => SEEN_DARK,
        Shadow::Non => SEEN_LIT,
        Shadow::Partial => SEEN_DARK | SEEN_LIT,
    }
}

impl Certificates {
    /// A tree without certificates.
    pub(crate) fn new(spec: CertificateSpec, facts: SceneFacts) -> Self {
        let layout = WordLayout::new(facts.lamps.count(facts.lights as usize));
        Self {
            spec,
            facts,
            layout,
            words: vec![0; facts.statics as usize * layout.words_per_primitive() as usize],
            children: vec![NO_CHILDREN; facts.statics as usize],
            lights: Vec::new(),
            cleared: Vec::new(),
        }
    }

    /// Starts a frame with these lights; clears the modes of lamps that have moved.
    pub(crate) fn begin_frame(&mut self, lights: &[Light]) {
        let moved: Vec<_> = lights
            .iter()
            .zip(&self.lights)
            .enumerate()
            .filter(|(_, (new, old))| new.position != old.position)
            .map(|(light, _)| self.facts.lamps.of(LightId(light as u8)))
            .collect();
        let moved = moved.into_iter().collect::<BTreeSet<_>>();
        for light in moved {
            for node in 0..self.children.len() as u32 {
                let place = self.layout.shadow(PrimitiveId(node), light);
                let word = &mut self.words[place.word as usize];
                if place.mode(*word) != Shadow::Init {
                    *word &= !(0b11 << place.shift);
                    self.cleared.push(place.word);
                }
            }
        }
        self.lights = lights.to_vec();
    }

    /// A worker that uses and extends the certificates in a band.
    pub(crate) fn prover(&self) -> Prover<'_> {
        Prover {
            certificates: self,
            sides: FxHashMap::default(),
            modes: FxHashMap::default(),
            seen: RayCounts::new(self.spec.counts, self.reference(self.nodes())),
            leaves: vec![None; self.facts.lights as usize],
            read: Vec::new(),
            counted: Vec::new(),
        }
    }

    fn mode(&self, node: u32, light: LightId) -> Shadow {
        let place = self.layout.shadow(PrimitiveId(node), light);
        place.mode(self.words[place.word as usize])
    }

    fn side(&self, primitive: PrimitiveId) -> Option<bool> {
        match self.words[self.layout.first(primitive) as usize] & 0b11 {
            0 => None,
            side => Some(side == side_bits(true)),
        }
    }

    fn child(&self, node: u32, at: u32) -> Option<u32> {
        let first = self.children[node as usize];
        (first != NO_CHILDREN).then_some(first + at)
    }

    /// The entry of a node's reference to its children in the store of mode words: after the words of all possible
    /// nodes.
    fn reference(&self, node: u32) -> u32 {
        self.nodes() * self.layout.words_per_primitive() + node
    }

    fn nodes(&self) -> u32 {
        self.facts.statics + self.spec.cells.get() as u32
    }

    /// Applies the findings of a frame. The bands' findings agree, because what is proven is true. So their order
    /// affects only the side of a receiver that was first seen from both sides.
    pub(crate) fn end_frame(&mut self, changes: &[Change], trail: &mut Trail) {
        for word in self.cleared.drain(..) {
            trail.update(Store::ModeWord, word);
        }
        let mut findings: Vec<_> = changes.iter().filter_map(Finding::from_change).collect();
        // Outer cells come first, so that a cell is divided before its children are written.
        findings.sort_by_key(|finding| (finding.cell, finding.light));
        for Finding { cell, light, mode, outside } in findings {
            let word = self.layout.first(cell.primitive);
            if *self.side(cell.primitive).get_or_insert(outside) != outside {
                continue;
            }
            self.words[word as usize] |= side_bits(outside);
            let node = cell.path().try_fold(cell.primitive.0, |node, at| self.child(node, at));
            let Some(node) = node else { continue };
            let known = self.mode(node, light);
            if known == mode || matches!(known, Shadow::Full | Shadow::Non) {
                continue;
            }
            let place = self.layout.shadow(PrimitiveId(node), light);
            let word = &mut self.words[place.word as usize];
            *word = *word & !(0b11 << place.shift) | bits(mode) << place.shift;
            trail.update(Store::ModeWord, place.word);
            let room = (self.children.len() + 4) as u32 <= self.nodes();
            if mode == Shadow::Partial
                && self.children[node as usize] == NO_CHILDREN
                && room
                && cell.level() < self.spec.deepest.get() as u32
            {
                self.children[node as usize] = self.children.len() as u32;
                self.children.extend([NO_CHILDREN; 4]);
                self.words.extend(std::iter::repeat_n(0, 4 * self.layout.words_per_primitive() as usize));
                trail.update(Store::ModeWord, self.reference(node));
            }
        }
    }

    /// The store of mode words: first the words of all possible nodes (static primitives first), then a reference for
    /// each node, then the counts of rays.
    pub(crate) fn stores(&self) -> StoreEntries {
        StoreEntries {
            mode_words: self.reference(self.nodes()) + self.spec.counts.get() as u32,
            word_owners: self.facts.statics,
            words_per_primitive: self.layout.words_per_primitive(),
            ..StoreEntries::default()
        }
    }
}

/// A prover's result for a cell and a lamp.
#[derive(Clone, Copy, Debug)]
struct Finding {
    cell: Cell,
    light: LightId,
    mode: Shadow,
    outside: bool,
}

/// The kind of [`Change`] that carries a finding; the light and the mode's bits are added.
const FINDING: u32 = 1 << 16;

impl Finding {
    fn to_change(self) -> Change {
        let kind = FINDING | u32::from(self.light.0) << 8 | bits(self.mode) << 2 | side_bits(self.outside);
        Change { kind, index: self.cell.primitive.0, value: self.cell.place }
    }

    fn from_change(change: &Change) -> Option<Self> {
        let mode = match change.kind >> 2 & 0b11 {
            SEEN_DARK => Shadow::Full,
            SEEN_LIT => Shadow::Non,
            _ => Shadow::Partial,
        };
        (change.kind & FINDING != 0).then_some(Self {
            cell: Cell { primitive: PrimitiveId(change.index), place: change.value },
            light: LightId((change.kind >> 8 & 0xff) as u8),
            mode,
            outside: change.kind & 0b11 == side_bits(true),
        })
    }
}

/// Uses certificates in a band and tries new ones, which are valid at once within the band. Answers of rays are
/// counted within the band only.
pub(crate) struct Prover<'a> {
    certificates: &'a Certificates,
    sides: FxHashMap<PrimitiveId, bool>,
    modes: FxHashMap<(Cell, LightId), Shadow>,
    seen: RayCounts,
    /// The leaf around the current hit, by light.
    leaves: Vec<Option<Leaf>>,
    /// Words read for the current hit; all lights share them.
    read: Vec<u32>,
    /// Lamps for which a ray of the current hit was counted.
    counted: Vec<LightId>,
}

impl Prover<'_> {
    /// Starts the next hit.
    pub(crate) fn hit(&mut self) {
        self.read.clear();
        self.counted.clear();
    }

    fn read(&mut self, entry: u32, probe: &mut Probe<'_>) {
        if !self.read.contains(&entry) {
            self.read.push(entry);
            probe.read(Store::ModeWord, entry);
        }
    }

    /// The leaf around the hit for a light. `None` where there can be no certificate: on dynamic primitives, on the
    /// strip along the edges, and on a receiver's other side.
    pub(crate) fn leaf(&mut self, hit: SurfaceHit, light: LightId, probe: &mut Probe<'_>) -> Option<Leaf> {
        let leaf = self.find(hit, light, probe);
        self.leaves[usize::from(light.0)] = leaf;
        leaf
    }

    fn find(&mut self, hit: SurfaceHit, light: LightId, probe: &mut Probe<'_>) -> Option<Leaf> {
        let all = self.certificates;
        let light = all.facts.lamps.of(light);
        if all.facts.is_dynamic(hit.primitive) {
            return None;
        }
        let mut inside = Inside::whole(hit.barycentric)?;
        let side = all.side(hit.primitive);
        let side = side.unwrap_or_else(|| *self.sides.entry(hit.primitive).or_insert(hit.outside));
        let mut cell = Cell::whole(hit.primitive);
        let mut node = Some(hit.primitive.0);
        loop {
            let stored = node.map_or(Shadow::Init, |node| {
                self.read(all.layout.shadow(PrimitiveId(node), light).word, probe);
                all.mode(node, light)
            });
            if side != hit.outside {
                return None;
            }
            let mode = match stored {
                Shadow::Init => self.modes.get(&(cell, light)).copied().unwrap_or(Shadow::Init),
                stored => stored,
            };
            let leaf = Leaf { cell, mode, outside: hit.outside };
            if mode != Shadow::Partial || cell.level() >= all.spec.deepest.get() as u32 {
                return Some(leaf);
            }
            let (at, within) = inside.descend();
            if stored == Shadow::Partial {
                let node = node.filter(|&node| all.child(node, at).is_some());
                // A divided node without children: there was no room for them.
                let Some(node) = node else { return Some(leaf) };
                self.read(all.reference(node), probe);
            }
            inside = within;
            cell = cell.child(at);
            node = node.and_then(|node| all.child(node, at));
        }
    }

    /// Learns the static blocker of a ray from the last leaf found for the light, or that there is none. Tries a proof
    /// when enough rays agree.
    pub(crate) fn learn(&mut self, light: LightId, blocker: Option<PrimitiveId>, probe: &mut Probe<'_>) {
        let Some(Leaf { cell, mode: Shadow::Init, outside }) = self.leaves[usize::from(light.0)] else { return };
        let all = self.certificates;
        let light = all.facts.lamps.of(light);
        if self.modes.contains_key(&(cell, light)) {
            // An earlier point of the lamp has just settled this cell.
            return;
        }
        let first = !self.counted.contains(&light);
        if first {
            self.counted.push(light);
        }
        let seen = self.seen.count(cell, light, blocker.is_some(), first, probe);
        let (rays, uniform) = (u64::from(seen.rays), seen.uniform());
        let mut found = None;
        if uniform && !seen.asked && rays >= all.spec.ask.get() {
            seen.asked = true;
            let points = all.facts.lamps.lights(light, all.lights.len());
            let positions: SmallVec<[Vec3; 1]> =
                points.map(|light| all.lights[usize::from(light.0)].position).collect();
            let shaft = probe.receiver(cell.primitive).shaft(cell, outside, &positions);
            found = match blocker {
                None => match probe.sight(&shaft) {
                    Sight::Clear => Some(Shadow::Non),
                    Sight::Blocked => Some(Shadow::Full),
                    Sight::Unknown => None,
                },
                Some(blocker) => (probe.relation(&shaft, blocker) == Relation::Covers).then_some(Shadow::Full),
            };
        }
        let divided = (seen.asked || !uniform) && rays >= all.spec.divide.get();
        if let Some(mode) = found.or(divided.then_some(Shadow::Partial)) {
            self.modes.insert((cell, light), mode);
        }
    }

    /// The findings of the band.
    pub(crate) fn finish(self) -> impl Iterator<Item = Change> {
        let (all, sides) = (self.certificates, self.sides);
        self.modes.into_iter().filter_map(move |((cell, light), mode)| {
            let side = all.side(cell.primitive).or_else(|| sides.get(&cell.primitive).copied());
            side.map(|outside| Finding { cell, light, mode, outside }.to_change())
        })
    }
}
