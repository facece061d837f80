//! What is known of windows that are not replayed: their steps, lines that they touch for the first time, and when each line was
//! touched last, from which the L2's contents at any later window follow (Barr et al. 2005, "memory timestamp record").

use super::super::bound::Lines;
use super::super::work::{Holder, Kind, Work};
use super::estimate::KNOWN;
use crate::machine::MachineSpec;
use crate::machine::layout::{Element, Layout};
use crate::memory::Touch;
use crate::quantity::LineAddr;
use crate::stats::TrafficClass;
use crate::stream::{Decision, FrameInfo, Header, Ray, RayKind, Step};

/// The record.
#[derive(Clone, Debug)]
pub struct Recency {
    layout: Layout,
    /// Of each line the last window that touched it, counted from 1, and its class.
    last: Vec<u32>,
    class: Vec<TrafficClass>,
    written: Lines,
    window: u32,
    /// The last window that was replayed.
    replayed: u32,
    known: [u64; KNOWN],
}

impl Recency {
    /// An empty record.
    pub fn new(header: &Header, machine: &MachineSpec) -> Self {
        Self {
            layout: Layout::new(header, machine),
            last: Vec::new(),
            class: Vec::new(),
            written: Lines::default(),
            window: 0,
            replayed: 0,
            known: [0; KNOWN],
        }
    }

    /// A frame begins.
    pub fn begin_frame(&mut self, info: &FrameInfo) {
        self.layout.begin_frame(info);
        self.last.truncate(self.layout.dynamic_part().0 as usize);
        self.class.truncate(self.last.len());
    }

    /// A window of rays begins and touches what they need; what is known of it.
    pub fn window<'a>(&mut self, rays: impl Iterator<Item = Ray<'a>>) -> [f64; KNOWN] {
        self.window += 1;
        self.known = [0; KNOWN];
        for ray in rays {
            self.known[Kind::ShadowCache as usize] += u64::from(ray.head.decision == Decision::Skip);
            self.steps(ray.packed_path(), Holder::Traversal, ray.head.kind);
            self.steps(ray.packed_policy(), Holder::ShadowCache, ray.head.kind);
        }
        self.known.map(|known| known as f64)
    }

    /// Steps of a frame's end, which are replayed always; what is known of them.
    pub fn frame_end(&mut self, steps: &[u32]) -> [f64; KNOWN] {
        self.known = [0; KNOWN];
        self.steps(steps, Holder::ShadowCache, RayKind::Primary);
        self.known.map(|known| known as f64)
    }

    fn steps(&mut self, words: &[u32], holder: Holder, kind: RayKind) {
        for step in words.iter().filter_map(|&word| Step::unpack(word)) {
            let work = Work::of(step, holder, kind, &self.layout);
            self.known[work.kind as usize] += work.operations();
            self.touch(&work.first);
            if let Some(second) = &work.second {
                self.touch(second);
            }
        }
    }

    fn touch(&mut self, element: &Element) {
        let (first, lines) = self.layout.lines(element);
        for line in first.0 as usize..(first.0 + lines) as usize {
            match self.last.get_mut(line) {
                Some(last) if *last > 0 => *last = self.window,
                _ => self.first_touch(line, element.class),
            }
            if element.write {
                self.written.touch(line as u64);
            }
        }
    }

    #[cold]
    fn first_touch(&mut self, line: usize, class: TrafficClass) {
        if line >= self.last.len() {
            self.last.resize(line + 1, 0);
            self.class.resize(line + 1, TrafficClass::Node);
        }
        (self.last[line], self.class[line]) = (self.window, class);
        self.known[KNOWN - 1] += 1;
    }

    /// The window that was told last is replayed.
    pub fn replays(&mut self) {
        self.replayed = self.window;
    }

    /// Lines touched since the last window that was replayed, the most recent last. A line that was ever written is dirty.
    pub fn since_replayed(&self) -> Vec<Touch> {
        let mut lines: Vec<(u32, usize)> = Vec::new();
        for (line, &window) in self.last.iter().enumerate() {
            if window > self.replayed {
                lines.push((window, line));
            }
        }
        lines.sort_unstable();
        let touch = |(_, line): (u32, usize)| Touch {
            line: LineAddr(line as u64),
            class: self.class[line],
            dirty: self.written.holds(line as u64),
        };
        lines.into_iter().map(touch).collect()
    }
}
