//! A machine built in code: replays a stream on machines whose traversal units have caches of different sizes.
//!
//! Run with: `cargo run --release --example own_machine`

use std::error::Error;
use std::path::Path;

use umbrasim::machine::MachineSpec;
use umbrasim::ranged::{Size, Within};
use umbrasim::replay::{Replay, StreamFile};
use umbrasim::stream::StreamReader;

fn main() -> Result<(), Box<dyn Error>> {
    let stream = Path::new(env!("CARGO_MANIFEST_DIR")).join("traces/quickstart.rays");
    for kibibytes in [4, 8, 16, 32] {
        // Every field has a default. A field's type checks its range.
        let mut machine = MachineSpec { name: format!("{kibibytes} KiB"), ..MachineSpec::default() };
        machine.traversal.cache.bytes = Size::new(kibibytes * 1024)?;
        machine.dispatcher.rays = Within::new(256)?;
        // Checks what concerns several fields: here, that sets and ways fit the size.
        machine.check()?;

        let header = StreamReader::open(&stream)?.header().clone();
        let stats = Replay::new(&machine, &header)?.run(&StreamFile(&stream))?;
        let nodes = stats.caches.get("l1_traversal").into_iter().flatten();
        for (class, counts) in nodes {
            let hits = counts.hit_rate().map_or_else(|| "no accesses".into(), |rate| format!("{:.1} %", rate * 100.0));
            println!("{:>6}: {:>9} cycles, {} hits {hits}", machine.name, stats.cycles, class.name());
        }
    }
    Ok(())
}
