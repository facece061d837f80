//! Both engines give the same numbers.

use proptest::prelude::*;
use proptest::test_runner::{Config, TestCaseError, TestError, TestRunner};

use super::random::{machines, streams};
use super::synthetic::header;
use super::*;
use crate::memory::command::CommandLog;

/// Runs for `cargo test`, or a long suite when the environment says so.
pub fn cases(short: u32) -> u32 {
    if std::env::var_os("UMBRASIM_LONG").is_some() { 20 * short } else { short }
}

fn counted(
    engine: &mut impl Engine,
    machine: &MachineSpec,
    stream: &[Item],
) -> Result<(Tally, Vec<CommandLog>), String> {
    engine.keep_commands();
    let tally = replay(engine, machine, items(stream.to_vec())).map_err(|error| error.to_string())?;
    Ok((tally, engine.commands().into_iter().cloned().collect()))
}

/// What both engines counted, or where they differ.
pub fn agree(machine: &MachineSpec, header: &Header, stream: &[Item]) -> Result<(Tally, Vec<CommandLog>), String> {
    let event = counted(&mut event::Event::new(machine, header), machine, stream)?;
    let cycle = counted(&mut cycle::Cycle::new(machine, header), machine, stream)?;
    for (channel, (event, cycle)) in event.1.iter().zip(&cycle.1).enumerate() {
        if let Some(at) = event.commands().iter().zip(cycle.commands()).position(|(event, cycle)| event != cycle) {
            let (event, cycle) = (event.commands()[at], cycle.commands()[at]);
            return Err(format!("channel {channel}, command {at}: Event gives {event:?}, Cycle {cycle:?}"));
        }
    }
    if event == cycle { Ok(event) } else { Err(format!("Event counts {:#?}\nCycle {:#?}", event.0, cycle.0)) }
}

/// Checks `test` on many values; the message of a failure is short.
fn check_many<S: Strategy>(short: u32, strategy: S, test: impl Fn(S::Value) -> Result<(), String>) {
    let config = Config { cases: cases(short), failure_persistence: None, ..Config::default() };
    let result = TestRunner::new(config).run(&strategy, |value| test(value).map_err(TestCaseError::fail));
    match result {
        Ok(()) => {}
        Err(TestError::Fail(why, value)) => panic!("{why}\nfor {value:#?}"),
        Err(TestError::Abort(why)) => panic!("{why}"),
    }
}

#[test]
fn engines_agree_on_any_machine_and_stream() {
    check_many(200, (machines(), streams()), |(machine, stream)| agree(&machine, &header(), &stream).map(drop));
}

/// The same result when all parts act in all cycles.
#[test]
fn waking_more_often_changes_nothing() {
    check_many(50, (machines(), streams()), |(machine, stream)| {
        let mut engine = event::Event::new(&machine, &header());
        let lazy = counted(&mut engine, &machine, &stream)?;
        let mut engine = event::Event::new(&machine, &header());
        engine.eager = true;
        let eager = counted(&mut engine, &machine, &stream)?;
        if lazy == eager { Ok(()) } else { Err("the eager run differs".into()) }
    });
}
