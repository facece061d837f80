//! research
use super::cells::{Cell, Cells};
use super::{Change, Evidence, Policy, Primary, Probe, SceneFacts, SurfaceHit, Verdict, Worker};
use crate::accel::{Ray, Relation, Shaft, Sight, Trail, World};
use crate::quantity::{LightId, PrimitiveId};
use crate::scene::{Light, Triangle};
use crate::stream::{Store, StoreEntries};
use glam::Vec3;
use rustc_hash::FxHashMap;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// t
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
#[allow(missing_docs)]
pub struct Tuning {
    pub cell: f64,
    pub deepest: u8,
    pub gate: u32,
    pub dark_gate: u32,
    pub at_once: bool,
    pub occluders: bool,
    pub register: bool,
    pub dynamic: bool,
    pub after_dark: bool,
    pub packet: u8,
    pub parent_first: bool,
    pub verbose: bool,
}
impl Default for Tuning {
    fn default() -> Self {
        Self {
            cell: 0.02,
            deepest: 8,
            gate: 2,
            dark_gate: 4,
            at_once: false,
            occluders: true,
            register: false,
            dynamic: true,
            after_dark: false,
            packet: 0,
            parent_first: false,
            verbose: false,
        }
    }
}

const NONE: u32 = u32::MAX;
const UNKNOWN: u8 = 0;
const FULL: u8 = 1;
const NON: u8 = 2;
const FAILED: u8 = 3;

const CLAIM: u32 = 0;
const OCCLUDER: u32 = 1;
const LIT: u32 = 2;
const DARK: u32 = 3;
const MODE: u32 = 4;

/// t
pub struct Certified {
    t: Tuning,
    facts: SceneFacts,
    cells: Cells,
    /// side: 0 unclaimed 1 outside 2 inside
    side: Vec<u8>,
    mode: Vec<u8>,
    occluder: Vec<u32>,
    dynamic: Vec<u32>,
    lights: Vec<Light>,
    stats: BTreeMap<&'static str, (u64, u64, u64)>,
}
impl Drop for Certified {
    fn drop(&mut self) {
        if self.t.verbose {
            println!("{:?}", self.t);
            for (k, v) in &self.stats {
                println!("   {k}: count {} nodes {} tris {}", v.0, v.1, v.2);
            }
            println!("   cells {} claimed {}", self.cells.len(), self.side.iter().filter(|&&s| s > 0).count());
            for m in 0..4 {
                println!("   mode {m}: {}", self.mode.iter().filter(|&&s| s == m).count());
            }
        }
    }
}
impl Certified {
    /// t
    pub fn new(t: Tuning, facts: SceneFacts, statics: &[Triangle]) -> Self {
        let (low, high) = statics
            .iter()
            .flat_map(|t| t.v)
            .fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(l, h), c| (l.min(c), h.max(c)));
        let diag = f64::from((high - low).length());
        let cells = Cells::new(statics, t.cell * diag, t.deepest, facts.offset);
        let n = cells.len() as usize;
        let l = facts.lights as usize;
        Self {
            t,
            facts,
            side: vec![0; n],
            mode: vec![0; n * l],
            occluder: vec![NONE; n * l],
            dynamic: vec![NONE; (facts.primitives - facts.statics) as usize * l],
            cells,
            lights: vec![],
            stats: BTreeMap::new(),
        }
    }
    fn stat(&mut self, k: &'static str, b: &Trail, nodes: u64, tris: u64) {
        let s = self.stats.entry(k).or_default();
        s.0 += 1;
        s.1 += b.nodes - nodes;
        s.2 += b.triangles - tris;
    }
    fn shaft(&self, cell: Cell, up: u8, number: u32, light: LightId) -> Shaft {
        self.cells.shaft(cell, up, self.side[number as usize] == 1, self.lights[light.0 as usize].position)
    }
}
impl Policy for Certified {
    fn begin_frame(&mut self, lights: &[Light], _: Option<Vec<u32>>) {
        for (at, (new, old)) in lights.iter().zip(&self.lights).enumerate() {
            if new.position != old.position {
                for mode in self.mode.iter_mut().skip(at).step_by(lights.len()) {
                    *mode = UNKNOWN;
                }
            }
        }
        self.lights = lights.to_vec();
    }
    fn worker(&self) -> Box<dyn Worker + '_> {
        Box::new(W { p: self, local: FxHashMap::default(), dynamic: FxHashMap::default(), claims: FxHashMap::default(), last: vec![NONE; self.facts.lights as usize], last_dark: vec![false; self.facts.lights as usize] })
    }
    fn end_frame(&mut self, changes: &[Change], world: &World<'_>, trail: &mut Trail) {
        let lights = self.facts.lights;
        let mut demand: BTreeMap<u32, (u32, u32)> = BTreeMap::new();
        let base = self.cells.len() * lights;
        for c in changes {
            match c.kind {
                CLAIM => {
                    if self.side[c.index as usize] == 0 {
                        self.side[c.index as usize] = c.value as u8
                    }
                }
                OCCLUDER => {
                    if c.index >= base {
                        self.dynamic[(c.index - base) as usize] = c.value
                    } else {
                        self.occluder[c.index as usize] = c.value
                    }
                }
                LIT => demand.entry(c.index).or_default().0 += c.value,
                DARK => demand.entry(c.index).or_default().1 += c.value,
                _ => self.mode[c.index as usize] = c.value as u8,
            }
        }
        // (primitive/parent group, light) -> entries
        let mut groups: BTreeMap<(u32, u32, u32), Vec<u32>> = BTreeMap::new();
        for (&entry, &(lit, dark)) in &demand {
            if self.mode[entry as usize] != UNKNOWN {
                continue;
            }
            let (number, light) = (entry / lights, LightId((entry % lights) as u8));
            let cell = self.cells.cell(number);
            if lit > 0 && dark > 0 {
                if lit + dark >= self.t.gate {
                    self.mode[entry as usize] = FAILED;
                }
            } else if dark >= self.t.dark_gate {
                let shaft = self.shaft(cell, 0, number, light);
                let (n, t) = (trail.nodes, trail.triangles);
                let occ = PrimitiveId(self.occluder[entry as usize]);
                let ok = world.relation(&shaft, occ, trail) == Relation::Covers;
                self.mode[entry as usize] = if ok { FULL } else { FAILED };
                self.stat(if ok { "full ok" } else { "full fail" }, trail, n, t);
            } else if lit >= self.t.gate {
                let up = self.t.packet.min(self.cells.level(cell.primitive));
                groups.entry((cell.primitive.0, cell.path >> (2 * up), u32::from(light.0))).or_default().push(entry);
            }
        }
        for ((primitive, parent, light), entries) in groups {
            let light = LightId(light as u8);
            let number = entries[0] / lights;
            let side = self.side[number as usize];
            let (same, other): (Vec<u32>, Vec<u32>) =
                entries.into_iter().partition(|e| self.side[(e / lights) as usize] == side);
            let _ = other;
            let cell = self.cells.cell(number);
            let (n, t) = (trail.nodes, trail.triangles);
            if let [entry] = same[..] {
                let shaft = self.shaft(cell, 0, number, light);
                let answer = world.sight(&shaft, std::slice::from_ref(&shaft), trail)[0];
                let k = self.put(entry, answer);
                self.stat(k, trail, n, t);
                continue;
            }
            let up = self.t.packet.min(self.cells.level(cell.primitive));
            let around = self.shaft(cell, up, number, light);
            let _ = (primitive, parent);
            let shafts: Vec<_> =
                same.iter().map(|e| self.shaft(self.cells.cell(e / lights), 0, e / lights, light)).collect();
            let answers = world.sight(&around, &shafts, trail);
            let mut clear = 0;
            for (e, a) in same.iter().zip(&answers) {
                if *a == Sight::Clear {
                    clear += 1
                }
                self.put(*e, *a);
            }
            self.stat(
                if clear == same.len() {
                    "packet all clear"
                } else if clear == 0 {
                    "packet none"
                } else {
                    "packet some"
                },
                trail,
                n,
                t,
            );
            self.stats.entry("packet cells").or_default().0 += same.len() as u64;
            self.stats.entry("packet cells clear").or_default().0 += clear as u64;
        }
    }
    fn stores(&self) -> StoreEntries {
        StoreEntries {
            mode_words: self.cells.len(),
            occluder_ids: (self.occluder.len() + self.dynamic.len()) as u32,
            ..StoreEntries::default()
        }
    }
}
impl Certified {
    fn put(&mut self, entry: u32, answer: Sight) -> &'static str {
        let e = entry as usize;
        match answer {
            Sight::Clear => {
                self.mode[e] = NON;
                "clear"
            }
            Sight::Blocked(b) => {
                self.mode[e] = FULL;
                self.occluder[e] = b.0;
                "blocked"
            }
            Sight::Unknown(b) => {
                self.mode[e] = FAILED;
                if self.occluder[e] == NONE {
                    self.occluder[e] = b.0;
                }
                "unknown"
            }
        }
    }
}
#[derive(Clone, Copy, Default)]
struct Local {
    lit: u32,
    dark: u32,
    occluder: Option<u32>,
    last_lit: bool,
    mode: u8,
    retested: bool,
}
struct W<'a> {
    p: &'a Certified,
    local: FxHashMap<u32, Local>,
    dynamic: FxHashMap<u32, u32>,
    claims: FxHashMap<u32, u8>,
    last: Vec<u32>,
    last_dark: Vec<bool>,
}
impl W<'_> {
    /// entry & whether ours
    fn entry(&mut self, hit: SurfaceHit, light: LightId) -> Option<u32> {
        let cell = self.p.cells.at(hit.primitive, hit.barycentric)?;
        let number = self.p.cells.number(cell);
        let want = if hit.outside { 1 } else { 2 };
        let side = self.p.side[number as usize];
        let side = if side != 0 { side } else { *self.claims.entry(number).or_insert(want) };
        (side == want).then_some(number * self.p.facts.lights + u32::from(light.0))
    }
}
impl Worker for W<'_> {
    fn hit(&mut self, _: SurfaceHit, _: Option<&Primary<'_>>, _: &mut Probe<'_>) {}
    fn decide(&mut self, hit: SurfaceHit, light: LightId, ray: &Ray, probe: &mut Probe<'_>) -> Verdict {
        let l = light.0 as usize;
        let (hint, mode, after_lit) = if self.p.facts.is_dynamic(hit.primitive) {
            if !self.p.t.dynamic {
                return Verdict::Trace;
            }
            let e = (hit.primitive.0 - self.p.facts.statics) * self.p.facts.lights + l as u32;
            (self.dynamic.get(&e).copied().unwrap_or(self.p.dynamic[e as usize]), 0, false)
        } else {
            let Some(e) = self.entry(hit, light) else { return Verdict::Trace };
            let loc = self.local.entry(e).or_default();
            let mode = if loc.mode != 0 { loc.mode } else { self.p.mode[e as usize] };
            (loc.occluder.unwrap_or(self.p.occluder[e as usize]), mode, loc.last_lit)
        };
        match mode {
            FULL => return Verdict::Dark,
            NON => return Verdict::DynamicOnly,
            _ => {}
        }
        if !self.p.t.occluders {
            return Verdict::Trace;
        }
        let mut tried = NONE;
        if hint != NONE && !(self.p.t.after_dark && after_lit) {
            if probe.surely_blocked(ray, PrimitiveId(hint)) {
                return Verdict::Dark;
            }
            tried = hint;
        }
        if self.p.t.register && self.last_dark[l] && self.last[l] != tried && self.last[l] != NONE && hint == NONE {
            if probe.surely_blocked(ray, PrimitiveId(self.last[l])) {
                if !self.p.facts.is_dynamic(hit.primitive) {
                    if let Some(e) = self.entry(hit, light) {
                        self.local.entry(e).or_default().occluder = Some(self.last[l]);
                    }
                } else {
                    let e = (hit.primitive.0 - self.p.facts.statics) * self.p.facts.lights + l as u32;
                    self.dynamic.insert(e, self.last[l]);
                }
                return Verdict::Dark;
            }
        }
        Verdict::Trace
    }
    fn learn(&mut self, hit: SurfaceHit, light: LightId, evidence: Evidence, probe: &mut Probe<'_>) {
        let l = light.0 as usize;
        let statics = self.p.facts.statics;
        let blocker = evidence.blocker.filter(|b| b.0 < statics);
        let dark = evidence.verdict == Verdict::Dark || blocker.is_some();
        if let Some(b) = blocker {
            self.last[l] = b.0;
        }
        self.last_dark[l] = dark;
        if self.p.facts.is_dynamic(hit.primitive) {
            if let Some(b) = blocker {
                self.dynamic.insert((hit.primitive.0 - statics) * self.p.facts.lights + l as u32, b.0);
            }
            return;
        }
        let Some(e) = self.entry(hit, light) else { return };
        let latched = self.p.mode[e as usize];
        let loc = self.local.entry(e).or_default();
        let mode = if loc.mode != 0 { loc.mode } else { latched };
        if mode == FULL || mode == NON {
            return;
        }
        if let Some(b) = blocker {
            loc.occluder = Some(b.0);
        }
        if dark {
            loc.dark += 1
        } else {
            loc.lit += 1
        }
        loc.last_lit = !dark;
        if self.p.t.at_once && mode == UNKNOWN && !loc.retested {
            let loc = *loc;
            let want_non = loc.dark == 0 && loc.lit >= self.p.t.gate;
            let want_full = loc.lit == 0 && loc.dark >= self.p.t.dark_gate;
            if want_non || want_full {
                let number = e / self.p.facts.lights;
                let cell = self.p.cells.cell(number);
                let shaft = self.p.cells.shaft(cell, 0, hit.outside, self.p.lights[l].position);
                let mut occ = None;
                let mode = if want_non {
                    match probe.sight(&shaft) {
                        Sight::Clear => NON,
                        Sight::Blocked(b) => {
                            occ = Some(b.0);
                            FULL
                        }
                        Sight::Unknown(b) => {
                            occ = Some(b.0);
                            FAILED
                        }
                    }
                } else {
                    let o = PrimitiveId(loc.occluder.unwrap_or(self.p.occluder[e as usize]));
                    if probe.relation(&shaft, o) == Relation::Covers { FULL } else { FAILED }
                };
                let loc = self.local.get_mut(&e).unwrap();
                loc.mode = mode;
                loc.retested = true;
                if loc.occluder.is_none() {
                    loc.occluder = occ;
                }
            } else if loc.lit > 0 && loc.dark > 0 {
                self.local.get_mut(&e).unwrap().mode = FAILED;
            }
        }
    }
    fn finish(self: Box<Self>) -> Vec<Change> {
        let mut out = vec![];
        for (index, value) in self.claims {
            out.push(Change { kind: CLAIM, index, value: u32::from(value) });
        }
        let base = self.p.cells.len() * self.p.facts.lights;
        for (index, value) in self.dynamic {
            out.push(Change { kind: OCCLUDER, index: base + index, value });
        }
        for (index, l) in self.local {
            // a claim by another band may win: then what was seen from this side is dropped by end_frame
            if let Some(value) = l.occluder {
                out.push(Change { kind: OCCLUDER, index, value });
            }
            if l.mode != 0 {
                out.push(Change { kind: MODE, index, value: u32::from(l.mode) });
            }
            if l.lit > 0 {
                out.push(Change { kind: LIT, index, value: l.lit });
            }
            if l.dark > 0 {
                out.push(Change { kind: DARK, index, value: l.dark });
            }
        }
        out
    }
}
