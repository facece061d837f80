//! Replays a recorded ray stream on a machine at two fidelity levels, and prints cycles and DRAM traffic by class.
//!
//! Run with: `cargo run --release --example replay_stream [STREAM] [MACHINE]`

use std::error::Error;
use std::path::PathBuf;

use umbrasim::experiment::read_machine;
use umbrasim::replay::{Fidelity, Replay, StreamFile};
use umbrasim::stream::StreamReader;

fn main() -> Result<(), Box<dyn Error>> {
    let root = PathBuf::from(env!("CARGO_MANIFEST_DIR"));
    let mut paths = std::env::args_os().skip(1).map(PathBuf::from);
    let stream = paths.next().unwrap_or_else(|| root.join("traces/quickstart.rays"));
    let machine = read_machine(&paths.next().unwrap_or_else(|| root.join("configs/machines/small.ron")))?;

    // The header describes the stream's scene and policy; the machine must fit them.
    let header = StreamReader::open(&stream)?.header().clone();
    let replay = Replay::new(&machine, &header)?;
    for fidelity in [Fidelity::Event, Fidelity::Profile] {
        let stats = replay.fidelity(fidelity).run(&StreamFile(&stream))?;
        println!("{fidelity} on {}: {} rays in {} cycles", machine.name, stats.rays, stats.cycles);
        for (class, bytes) in stats.bytes.get("dram").into_iter().flatten() {
            println!("  {:>13}  {bytes} bytes", class.name());
        }
    }
    Ok(())
}
