//! Refused inputs, stopped runs, and their error messages.

use super::*;

#[test]
fn an_empty_stream_takes_one_cycle() {
    let machine = MachineSpec::default();
    let stats = replayed(&machine, Vec::new());
    assert_eq!((stats.cycles.0, stats.rays), (1, 0));
    let stats = replayed(&machine, one_frame(&[]));
    assert_eq!((stats.cycles.0, stats.rays), (2, 0));
}

#[test]
fn wrong_streams_are_refused() {
    let machine = MachineSpec::default();
    let good = one_frame(&[SyntheticRay::primary(nodes([0]))]);
    let error = |stream: Vec<Item>| run(&machine, Level::Event, &header(), &stream).unwrap_err().to_string();
    assert_eq!(error(good[..2].to_vec()), "the stream has its end where rays or a frame's end belongs");
    assert_eq!(error(good[1..].to_vec()), "the stream has rays where a frame's beginning belongs");
    let beyond = one_frame(&[SyntheticRay::primary(nodes([STATIC]))]);
    assert_eq!(error(beyond), "node 4096 does not exist: the stream's header and frame announce 4096");
    let orphan = one_frame(&[SyntheticRay::primary(nodes([0])), SyntheticRay::shadow(2, Decision::Trace, Vec::new())]);
    assert_eq!(error(orphan), "ray 1 of a chunk has a parent outside its pixel group");
    let mut miscounted = good;
    if let Some(Item::End { totals, .. }) = miscounted.last_mut() {
        totals.node_visits += 1;
    }
    assert_eq!(error(miscounted), "frame 0: the machine replayed 1 node visits, the tracer counted 2");
}

#[test]
fn an_error_of_the_source_comes_through() {
    let fire = || StreamError::Io { path: "x.rays".into(), doing: "read", source: std::io::Error::other("on fire") };
    let mut stream = one_frame(&[]).into_iter().take(1).map(Ok).chain([Err(fire())]);
    let found = whole(Level::Event, &MachineSpec::default(), &header(), &mut stream, None);
    assert!(matches!(found, Err(RunError::Source(error)) if error.to_string() == fire().to_string()));
}

/// A machine with minimum sizes and counts.
fn tiny() -> MachineSpec {
    let mut machine = MachineSpec::default();
    (machine.dispatcher.rays, machine.dispatcher.in_fifo, machine.dispatcher.out_fifo) = (num(1), num(1), num(1));
    machine.traversal.count = num(1);
    machine.traversal.rays = num(1);
    (machine.list.count, machine.list.lists, machine.list.queue) = (num(1), num(1), num(1));
    (machine.division.count, machine.division.queue) = (num(1), num(1));
    machine.intersection.count = num(1);
    machine.intersection.tests = num(1);
    machine.intersection.queue = num(1);
    machine.shadow_cache.contexts = num(1);
    let MachineSpec { traversal, list, intersection, shadow_cache, .. } = &mut machine;
    for cache in [&mut traversal.cache, &mut list.cache, &mut intersection.cache, &mut shadow_cache.cache] {
        (cache.bytes, cache.ways) = (size(64), num(1));
        (cache.mshrs, cache.targets, cache.queue) = (num(1), num(1), num(1));
    }
    machine.l2 = L2Spec::Unified(BankedSpec {
        banks: pow(1),
        bytes: size(64),
        ways: num(1),
        mshrs: num(1),
        targets: num(1),
        queue: num(1),
        ..BankedSpec::DEFAULT
    });
    machine.dram.queue = num(1);
    machine
}

#[test]
fn size_one_everywhere_does_not_deadlock() {
    for line in [32, 64] {
        for writes in [WritePolicy::Back, WritePolicy::Through] {
            let mut machine = tiny();
            machine = with_line(machine, line);
            machine.shadow_cache.writes = writes;
            let end: Vec<_> = (0..40).map(|i| Step::Update { store: Store::PixelCounter, index: i * 9 }).collect();
            let mut rays = bvh_like(3, 60, 12, 3);
            let traced = rays.iter_mut().filter(|ray| ray.decision != Decision::Skip);
            traced.for_each(|ray| ray.path.extend(leaf(7, 3)));
            let stats = replayed(&machine, frame(FrameInfo::default(), &rays, &end, 16));
            assert_eq!(stats.units.len(), 6);
        }
    }
}

#[test]
fn a_shadow_rays_test_of_the_policy_uses_the_intersection_unit() {
    let machine = MachineSpec::default();
    let ray = SyntheticRay::primary(vec![]).with_policy(vec![triangle(5, Stop::Hit), triangle(5, Stop::Plane)]);
    let stats = replayed(&machine, one_frame(&[ray]));
    assert_eq!(stats.units["intersection"][&Cause::Busy], 3);
    assert_eq!(stats.bytes["l1_intersection"][&TrafficClass::Triangle].0, 16 + 32 + 16);
}

#[test]
fn chunks_are_dropped_when_their_rays_are_done() {
    let stream = frame(FrameInfo::default(), &bvh_like(1, 2000, 12, 1), &[], 64);
    let total = stream.len();
    let mut chunks = Vec::new();
    let mut most = 0;
    let mut watched = stream.into_iter().map(|item| {
        if let Item::Rays(chunk) = &item {
            chunks.push(std::sync::Arc::downgrade(chunk));
        }
        chunks.retain(|chunk| chunk.strong_count() > 0);
        most = most.max(chunks.len());
        Ok(item)
    });
    whole(Level::Event, &MachineSpec::default(), &header(), &mut watched, None).unwrap();
    // 128 rays are in flight and hits are shaded: about 400 rays are begun and not done, 64 per chunk.
    assert!(total > 60 && most <= 10, "{most} of {total} chunks at once");
}

#[test]
fn a_machine_that_does_not_move_is_reported_with_its_queues() {
    let machine = MachineSpec::default();
    let mut engine = Event::new(&machine, &header());
    engine.dispatcher.take_all_slots();
    let stream = one_frame(&[SyntheticRay::primary(nodes([0]))]);
    let error = replay(&mut engine, &machine, &mut items(stream), None).unwrap_err().to_string();
    assert!(error.contains("dispatcher: rays in flight 0/128, in FIFO 1/16, ready 0"), "{error}");
    assert!(error.contains("dram channel 0: queue 0/32"), "{error}");
}

/// `Profile` has no watchdog: it reports a deadlock when no event is due but the stream has not ended.
#[test]
fn a_machine_that_does_not_move_is_reported_by_profile() {
    let machine = MachineSpec::default();
    let mut engine = Profile::new(&machine, &header());
    engine.dispatch.take_all_slots();
    let stream = one_frame(&[SyntheticRay::primary(nodes([0]))]);
    let error = replay(&mut engine, &machine, &mut items(stream), None).unwrap_err().to_string();
    assert!(error.contains("nothing has moved up to cycle 0:\nrays in flight 0"), "{error}");
}

#[test]
fn violated_identities_are_found() {
    let machine = MachineSpec::default();
    let good =
        replay(&mut Event::new(&machine, &header()), &machine, &mut items(one_frame(&bvh_like(1, 50, 12, 2))), None)
            .unwrap();
    type Breakage = fn(&mut Tally);
    let broken: [(&str, Breakage); 8] = [
        ("in the queue of l2 0 against cycles waited", |t| t.queues[QueueKind::L2 as usize][0].waited += 1),
        ("less than their least latency", |t| t.latencies.too_fast += 1),
        ("hits + MSHR hits + misses + passed writes", |t| t.banks[0].cache[TrafficClass::Node as usize].hits += 1),
        ("cycles of all causes", |t| t.units[Kind::Traversal as usize][1].causes[Cause::Busy as usize] += 1),
        ("row hits", |t| t.channels[0].counts.row_hits += 1),
        ("bytes of L2 and host against DRAM", |t| t.channels[0].moved[TrafficClass::Node as usize].0 += 1),
        ("against DRAM bytes", |t| {
            t.channels[0].counts.reads -= 1;
            t.channels[0].counts.row_misses -= 1;
        }),
        ("exceed the peak", |t| {
            t.cycles /= 50;
            let causes = t.units.iter_mut().flatten().map(|unit| &mut unit.causes);
            let causes = causes.chain(&mut t.divisions).chain([&mut t.dispatcher]);
            causes.for_each(|causes| (*causes = Default::default(), causes[0] = t.cycles).1);
        }),
    ];
    for (expected, breakage) in broken {
        let mut tally = good.clone();
        breakage(&mut tally);
        let error = check::run(&tally, &machine).unwrap_err();
        assert!(error.contains(expected), "{error}");
    }
}
