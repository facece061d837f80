//! Tags beside `Event`: they have no time, and perform the same operations.

use super::*;
use crate::engine::tests::synthetic::{STATIC, SyntheticRay, nodes};
use crate::machine::kinds::Kind;
use crate::sampling::path_tags::PathTags;
use crate::sampling::word_tags::WordTags;
use crate::stream::Decision;

/// Operations of each kind that tags know of a stream.
fn known(machine: &MachineSpec, header: &Header, stream: &[Item]) -> [u64; Kind::ALL.len()] {
    let (mut path, mut words) = (PathTags::new(header, machine), WordTags::new(header, machine));
    let mut operations = [0; Kind::ALL.len()];
    for item in stream {
        let known = match item {
            Item::Frame(info) => {
                path.begin_frame(info);
                words.begin_frame(info);
                continue;
            }
            Item::Rays(chunk) => {
                let trodden = path.piece(chunk, 0..chunk.len());
                let shift = path.shift_to(words.layout()).unwrap();
                words.piece(chunk, 0..chunk.len(), &trodden, shift).known
            }
            Item::End { policy, .. } => {
                let trodden = path.frame_end(policy);
                let shift = path.shift_to(words.layout()).unwrap();
                words.frame_end(policy, &trodden, shift).known
            }
        };
        operations.iter_mut().zip(known.operations).for_each(|(sum, of)| *sum += of);
    }
    Kind::ALL.map(|kind| operations[kind as usize] / kind.spec(machine).interval)
}

/// Registers and tables of hits, which tags leave out, are taken away.
#[test]
fn tags_perform_the_operations_that_event_does() {
    check_many(
        300,
        || (machines(), streams()),
        |(mut machine, stream)| {
            (machine.shadow_cache.register, machine.shadow_cache.gather) = (num(0), num(0));
            let (header, whole) = (header(), on(&machine, &header(), "Event", &stream));
            let operations = Kind::ALL.map(|kind| whole.operations.get(kind.names().0).copied().unwrap_or(0));
            let known = known(&machine, &header, &stream);
            if operations == known { Ok(()) } else { Err(format!("Event {operations:?}, tags {known:?}")) }
        },
    );
}

/// What is wrong with a stream in memory is told as whole replays tell it, wherever windows lie.
#[test]
fn wrong_streams_are_refused_before_tags_take_them() {
    let machine = MachineSpec::default();
    let (header, plan) = (header(), Plan::new(0.5, Cut { pixels: 1, before: 2, own: 2, behind: 1 }, 0));
    let sampler = Sampler::new(Sampled::Event, &header);
    let error = |rays: &[SyntheticRay]| {
        let stream = frame(FrameInfo::default(), rays, &[], 64);
        let member = [Member { machine: &machine, plan: plan.clone() }];
        sampler.pass(&member, 0, &mut items(stream)).unwrap_err().to_string()
    };
    let beyond = [SyntheticRay::primary(nodes([STATIC]))];
    assert_eq!(error(&beyond), "node 4096 does not exist: the stream's header and frame announce 4096");
    let orphan = [SyntheticRay::primary(nodes([0])), SyntheticRay::shadow(2, Decision::Trace, Vec::new())];
    assert_eq!(error(&orphan), "ray 1 of a chunk has a parent outside its pixel group");
}
