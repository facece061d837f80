use std::collections::BTreeMap;

use super::*;
use crate::engine::tests::recorded::{on, quickstart, shipped};
use crate::replay::{Exact, Replay};
use crate::stats::Cause;

/// Spans of a frame are contiguous and sum to the frame's figures; recording changes no result.
#[test]
fn spans_sum_to_their_frames() {
    let (header, stream) = quickstart();
    for name in ["small", "desktop"] {
        let machine = shipped(name);
        let replay = Replay::new(&machine, &header).unwrap().fidelity(Exact::Event);
        let mut recorder = Recorder::new(&header);
        let stats = replay.observe(&mut recorder).unwrap().run(stream.iter().cloned().map(Ok)).unwrap();
        assert_eq!(stats, on(&machine, &header, "Event", &stream));
        let spans = recorder.finish();
        let measured: Vec<_> = stats.frames.iter().filter(|frame| !frame.warmup).collect();
        assert!(!measured.is_empty() && spans.len() > 2 * measured.len());
        let mut frames = spans.chunk_by(|a, b| a.frame == b.frame);
        for frame in measured {
            let spans = frames.next().unwrap();
            assert!(spans.len() < MOST && spans[0].begin == 0);
            assert!(spans.windows(2).all(|pair| pair[0].begin + pair[0].cycles == pair[1].begin));
            let all = Span::joined(spans);
            assert_eq!((all.frame, all.cycles), (frame.frame, frame.cycles.0));
            assert_eq!(all.dram_bytes, frame.bytes["dram"].0);
            let busy = |units: &BTreeMap<String, BTreeMap<Cause, u64>>| units["traversal"][&Cause::Busy];
            assert!(busy(&all.units) > 0);
        }
        assert_eq!(frames.next(), None);
    }
}
