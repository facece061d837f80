//! Rays of one kind on a machine with the structure of the T&I engine: the paper's table, and two identities. They tie
//! utilisation to throughput, and hit rates to traffic.

mod spec;

use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};

use serde::Serialize;

pub use self::spec::{IdentitiesSpec, PerUnit, Row, SceneFrame};
use crate::experiment::files::{machine_with, named, not_set};
use crate::experiment::load::{ExperimentError, read_scene};
use crate::experiment::progress;
use crate::experiment::set::{self, Setting};
use crate::machine::MachineSpec;
use crate::replay::{Replay, RunError};
use crate::report::Grid;
use crate::report::format::percent;
use crate::ron_file::{self, ConfigError, Kind};
use crate::scene::Scene;
use crate::stats::{CacheCounts, MachineStats, TrafficClass};
use crate::stream::{Item, RayKind, Step, Stop};
use crate::tracer::{Alone, Samples, Tracer, TracerSpec};

/// A measured row, with the results of the identities.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Measured {
    /// The measured row.
    pub row: Row,
    /// Hit rates of the L1s with MSHR hits counted as hits.
    pub l1_with_merged: PerUnit,
    /// The largest difference, over all units, between utilisation and operations per ray (as recorded) x rays per
    /// second / peak rate.
    pub utilization_gap: f64,
    /// DRAM bytes per ray by the identity: accesses x (1 - L1 hit rate) x (1 - L2 hit rate) x line bytes, summed over
    /// the units. It counts MSHR hits as misses, as if each fetched its line again.
    pub bytes_by_identity: f64,
    /// Bytes per ray that MSHR hits save.
    pub bytes_merged: f64,
}

/// Why a table could not be measured.
#[derive(Debug, thiserror::Error)]
pub enum IdentitiesError {
    /// A config or a scene is wrong.
    #[error(transparent)]
    Experiment(#[from] ExperimentError),
    /// A replay failed.
    #[error(transparent)]
    Run(#[from] RunError),
}

/// The largest allowed [`Measured::utilization_gap`]: rounding only, since an operation occupies its unit for exactly
/// its interval. (The T&I paper's own table meets the identity within 17 points.)
pub const MOST_GAP: f64 = 1e-9;

/// A table and all that its file names.
pub(crate) struct Table {
    spec: IdentitiesSpec,
    machine: MachineSpec,
    /// The scenes, in the order of the file.
    scenes: Vec<Scene>,
}

impl Table {
    /// Reads the table of the file `path`. `settings` set fields of the table and of its machine.
    ///
    /// # Errors
    /// A file cannot be read or is wrong, a field cannot be set, or a scene has no such frame.
    pub(crate) fn load(path: &Path, settings: &[Setting]) -> Result<Self, ExperimentError> {
        let mut spec: IdentitiesSpec = ron_file::read(path)?;
        let known = set::names(&spec);
        let is_own = |setting: &&Setting| match setting.path.split_once('.') {
            Some((first, _)) => first != "machine" && known.iter().any(|name| name == first),
            None => known.contains(&setting.path),
        };
        let (own, of_machine): (Vec<&Setting>, Vec<&Setting>) = settings.iter().partition(is_own);
        for setting in own {
            spec = set::field(&spec, &setting.path, &setting.value).map_err(|what| not_set(setting, what))?;
        }
        let machine = machine_with(&named(Kind::Machine, path, &spec.machine), &of_machine);
        let machine = machine.map_err(|error| ron_file::named_in(path, error))?;
        let load = |SceneFrame { scene, frame, reach }: &SceneFrame| {
            let wrong = |what: String| ExperimentError::from(ConfigError::Content { path: path.into(), what });
            let (_, scene) = read_scene(&named(Kind::Scene, path, scene)).map_err(|error| error.named_in(path))?;
            if *frame >= scene.frame_count {
                let (name, count) = (&scene.name, scene.frame_count);
                return Err(wrong(format!("`frame` is {frame}, but `{name}` has {count} frames")));
            }
            if reach.is_some_and(|reach| !(reach > 0.0 && reach.is_finite())) {
                return Err(wrong("`reach` is no distance: a number above 0 is needed".into()));
            }
            Ok(scene)
        };
        let scenes = spec.scenes.iter().map(load).collect::<Result<_, _>>()?;
        Ok(Self { spec, machine, scenes })
    }

    /// The number of rows to measure.
    pub(crate) fn rows(&self) -> usize {
        self.spec.scenes.iter().map(|scene| kinds(scene.reach).count()).sum()
    }
}

/// Measures all scenes and kinds of rays of a table. When `stop` becomes true, returns the rows done.
pub(crate) fn identities(table: Table, stop: &AtomicBool) -> Result<(Vec<Measured>, Vec<Row>), IdentitiesError> {
    let bar = progress::bar("identities", table.rows(), "rows");
    let Table { spec, machine, scenes } = table;
    let mut rows = Vec::new();
    for (scene, SceneFrame { frame: number, reach, .. }) in scenes.iter().zip(&spec.scenes) {
        let frame = scene.animation.frame(*number);
        let tracer_spec = TracerSpec { accel: spec.accel, ..TracerSpec::default() };
        let tracer = Tracer::new(scene, &frame, spec.resolution, tracer_spec);
        let samples = Samples {
            a_pixel: spec.samples.get() as u32,
            reach: reach.unwrap_or_default(),
            directions: spec.directions,
        };
        for kind in kinds(*reach) {
            if stop.load(Ordering::Relaxed) {
                return Ok((rows, spec.published));
            }
            let (header, items) = tracer.alone(&frame, *number, kind, samples);
            let work = Work::of(&items, kind);
            let stats = Replay::new(&machine, &header).map_err(RunError::from)?.run(&items)?;
            let name = format!("{} {number}, {}", scene.name, format!("{kind:?}").to_lowercase());
            rows.push(measured(name, &work, &stats, &machine));
            bar.inc(1);
        }
    }
    drop(bar);
    Ok((rows, spec.published))
}

/// The work of a stream: its rays of the kind, and their operations.
#[derive(Debug)]
struct Work {
    rays: f64,
    operations: PerUnit,
}

impl Work {
    fn of(items: &[Item], kind: Alone) -> Self {
        let wanted = match kind {
            Alone::Primary => RayKind::Primary,
            Alone::Shadow | Alone::Occlusion => RayKind::Shadow,
            Alone::Diffuse => RayKind::Reflection,
        };
        let mut work = Self { rays: 0.0, operations: PerUnit::default() };
        let chunks = items.iter().filter_map(|item| if let Item::Rays(chunk) = item { Some(chunk) } else { None });
        for ray in chunks.flat_map(|chunk| chunk.rays()).filter(|ray| ray.head.kind == wanted) {
            work.rays += 1.0;
            let done = &mut work.operations;
            for step in ray.path() {
                match step {
                    Step::Node(_) => done.traversal += 1.0,
                    Step::List(_) => done.list += 1.0,
                    Step::Triangle { stop, .. } => {
                        done.intersection += if stop == Stop::Plane { 1.0 } else { 2.0 };
                        done.division += f64::from(u8::from(stop == Stop::Hit && wanted != RayKind::Shadow));
                    }
                    _ => {}
                }
            }
        }
        work
    }
}

/// The kinds of rays of a scene.
fn kinds(reach: Option<f32>) -> impl Iterator<Item = Alone> {
    Alone::ALL.into_iter().filter(move |&kind| kind != Alone::Occlusion || reach.is_some())
}

fn measured(name: String, work: &Work, stats: &MachineStats, machine: &MachineSpec) -> Measured {
    let PerUnit { traversal, list, intersection, division } = work.operations;
    let rays = work.rays.max(1.0);
    let cycles = stats.cycles.0 as f64;
    let busy = |unit| stats.utilization(unit).unwrap_or(0.0);
    let utilization = PerUnit {
        traversal: busy("traversal"),
        list: busy("list"),
        intersection: busy("intersection"),
        division: busy("division"),
    };
    // Operations per ray x rays per cycle / operations that all units together can start per cycle.
    let per_cycle = |operations: f64, count: u64, interval: u64| {
        (operations / rays) * (rays / cycles) * interval as f64 / (machine.cores.get() * count) as f64
    };
    let MachineSpec { traversal: trv, list: lst, intersection: ist, division: div, .. } = machine;
    let gaps = [
        utilization.traversal - per_cycle(traversal, trv.count.get(), trv.interval.get()),
        utilization.list - per_cycle(list, lst.count.get(), lst.interval.get()),
        utilization.intersection - per_cycle(intersection, ist.count.get(), ist.interval.get()),
        utilization.division - per_cycle(division, div.count.get(), div.interval.get()),
    ];
    let levels = [
        ("l1_traversal", TrafficClass::Node),
        ("l1_list", TrafficClass::List),
        ("l1_intersection", TrafficClass::Triangle),
    ];
    let line = machine.line_bytes.get() as f64;
    let (mut l1_rates, mut with_merged, mut l2_rates) = ([0.0; 3], [0.0; 3], [0.0; 3]);
    let (mut by_identity, mut fetched) = (0.0, 0.0);
    for (index, (l1, class)) in levels.into_iter().enumerate() {
        let l1 = counts(stats, l1, class);
        let l2 = counts_in_l2(stats, class);
        (l1_rates[index], l2_rates[index]) = (l1.hit_rate().unwrap_or(0.0), l2.hit_rate().unwrap_or(0.0));
        with_merged[index] = (l1.hits + l1.mshr_hits) as f64 / l1.accesses.max(1) as f64;
        by_identity += l1.accesses as f64 * (1.0 - l1_rates[index]) * (1.0 - l2_rates[index]) * line;
        fetched += l2.misses as f64 * line;
    }
    let seconds = cycles / (stats.clock_mhz * 1e6);
    let dram = stats.moved("dram").0 as f64;
    let per_ray = |[traversal, list, intersection]: [f64; 3]| PerUnit { traversal, list, intersection, division: 0.0 };
    Measured {
        row: Row {
            name,
            utilization,
            l1: per_ray(l1_rates),
            l2: per_ray(l2_rates),
            operations: PerUnit {
                traversal: traversal / rays,
                list: list / rays,
                intersection: intersection / rays,
                division: division / rays,
            },
            dram_gb_per_s: dram / seconds / 1e9,
            mrays_per_s: rays / seconds / 1e6,
            dram_bytes_per_ray: dram / rays,
        },
        l1_with_merged: per_ray(with_merged),
        utilization_gap: gaps.into_iter().map(f64::abs).fold(0.0, f64::max),
        bytes_by_identity: by_identity / rays,
        bytes_merged: (by_identity - fetched) / rays,
    }
}

/// A cache's counts of a class; zeros if it has no such traffic.
fn counts(stats: &MachineStats, cache: &str, class: TrafficClass) -> CacheCounts {
    stats.caches.get(cache).and_then(|classes| classes.get(&class)).map(|cache| cache.counts).unwrap_or_default()
}

/// The counts of a class in the L2 that serves it: only one L2 does.
fn counts_in_l2(stats: &MachineStats, class: TrafficClass) -> CacheCounts {
    let levels = stats.caches.keys().filter(|name| name.starts_with("l2"));
    levels.map(|name| counts(stats, name, class)).find(|counts| counts.accesses > 0).unwrap_or_default()
}

/// The measured rows, then the published ones.
pub(crate) fn grid(measured: &[Measured], published: &[Row]) -> Grid {
    const HEAD: [&str; 10] = [
        "rays",
        "utilization T/L/I/D",
        "L1 hits T/L/I",
        "with merged T/L/I",
        "L2 hits T/L/I",
        "operations T/L/I a ray",
        "DRAM GB/s",
        "Mrays/s",
        "DRAM B/ray",
        "by identity, merged",
    ];
    let shares = |unit: &PerUnit, division: bool| {
        let all = [unit.traversal, unit.list, unit.intersection, unit.division];
        all.iter().take(3 + usize::from(division)).map(|&share| percent(share)).collect::<Vec<_>>().join(" / ")
    };
    let row = |row: &Row, merged: String, identity: String| {
        let PerUnit { traversal, list, intersection, .. } = row.operations;
        vec![
            row.name.clone(),
            shares(&row.utilization, true),
            shares(&row.l1, false),
            merged,
            shares(&row.l2, false),
            format!("{traversal:.1} / {list:.1} / {intersection:.1}"),
            format!("{:.1}", row.dram_gb_per_s),
            format!("{:.0}", row.mrays_per_s),
            format!("{:.2}", row.dram_bytes_per_ray),
            identity,
        ]
    };
    let ours = measured.iter().map(|it| {
        let identity = format!("{:.2}, -{:.2}", it.bytes_by_identity, it.bytes_merged);
        row(&it.row, shares(&it.l1_with_merged, false), identity)
    });
    let theirs = published.iter().map(|it| row(it, "-".into(), "-".into()));
    Grid { head: HEAD.map(Into::into).to_vec(), names: 1, rows: ours.chain(theirs).collect() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::experiment::files::read_machine;
    use crate::quantity::Resolution;
    use crate::replay::Fidelity;
    use crate::tracer::Directions;

    /// All rows of the room, on each shipped machine for kd-trees.
    #[test]
    fn the_identities_hold_and_both_engines_agree_on_every_kind_of_rays() {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("configs");
        let (_, scene) = read_scene(&root.join("scenes/room.ron")).unwrap();
        let frame = scene.animation.frame(3);
        let tables: IdentitiesSpec = ron_file::read(&root.join("experiments/identities.ron")).unwrap();
        let tracer_spec = TracerSpec { accel: tables.accel, ..TracerSpec::default() };
        let tracer = Tracer::new(&scene, &frame, Resolution { width: 40, height: 40 }, tracer_spec);
        for name in ["tni_engine", "raycore", "small"] {
            let machine = read_machine(&root.join(format!("machines/{name}.ron"))).unwrap();
            for kind in Alone::ALL {
                let samples = Samples { a_pixel: 1, reach: 1.0, directions: Directions::Hashed };
                let (header, items) = tracer.alone(&frame, 3, kind, samples);
                let work = Work::of(&items, kind);
                assert!(work.rays > 1000.0 && work.operations.list > work.rays / 2.0, "{kind:?}");
                let replay = Replay::new(&machine, &header).unwrap();
                let [event, cycle] =
                    [Fidelity::Event, Fidelity::Cycle].map(|fidelity| replay.fidelity(fidelity).run(&items).unwrap());
                assert_eq!(event, cycle, "{name}, {kind:?}");
                let found = measured(String::new(), &work, &event, &machine);
                assert!(found.utilization_gap <= MOST_GAP, "{name}, {kind:?}: {}", found.utilization_gap);
                // The identity fetches twice exactly the lines that MSHR hits save.
                let fetched = found.bytes_by_identity - found.bytes_merged;
                assert!((fetched / found.row.dram_bytes_per_ray - 1.0).abs() < 1e-9, "{name}, {kind:?}: {fetched}");
                assert!(found.bytes_merged >= 0.0);
            }
        }
    }

    #[test]
    fn samples_are_rays_and_occlusion_rays_end_at_their_reach() {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("configs");
        let (_, scene) = read_scene(&root.join("scenes/room.ron")).unwrap();
        let frame = scene.animation.frame(3);
        let tracer = Tracer::new(&scene, &frame, Resolution { width: 24, height: 16 }, TracerSpec::default());
        let alone = |kind, a_pixel, reach| {
            let samples = Samples { a_pixel, reach, directions: Directions::Hashed };
            let (_, items) = tracer.alone(&frame, 3, kind, samples);
            let end =
                items.iter().find_map(|item| if let Item::End { totals, .. } = item { Some(*totals) } else { None });
            (Work::of(&items, kind), end.unwrap())
        };
        let (one, _) = alone(Alone::Primary, 1, 1.0);
        let (three, _) = alone(Alone::Primary, 3, 1.0);
        assert_eq!((one.rays, three.rays), (384.0, 1152.0));
        // The samples of a pixel are different rays.
        assert!((three.operations.traversal - 3.0 * one.operations.traversal).abs() > 0.5);
        let [(near, _), (far, all)] = [0.01, 100.0].map(|reach| alone(Alone::Occlusion, 1, reach));
        assert_eq!((near.rays, far.rays), (far.rays, all.shadow_rays as f64));
        assert!(near.operations.traversal < far.operations.traversal, "{near:?} {far:?}");
    }

    /// Eight neighbouring pixels visit fewer distinct nodes if their rays are parallel.
    #[test]
    fn neighbours_share_nodes_if_they_share_directions() {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("configs");
        let (_, scene) = read_scene(&root.join("scenes/room.ron")).unwrap();
        let frame = scene.animation.frame(3);
        let tracer = Tracer::new(&scene, &frame, Resolution { width: 48, height: 48 }, TracerSpec::default());
        let nodes = |directions| {
            let (_, items) = tracer.alone(&frame, 3, Alone::Diffuse, Samples { a_pixel: 1, reach: 1.0, directions });
            let chunks = items.iter().filter_map(|item| if let Item::Rays(chunk) = item { Some(chunk) } else { None });
            let paths = chunks.flat_map(|chunk| chunk.rays()).filter(|ray| ray.head.kind == RayKind::Reflection);
            let paths: Vec<Vec<Step>> = paths.map(|ray| ray.path().collect()).collect();
            let distinct = |rays: &[Vec<Step>]| {
                let nodes =
                    rays.iter().flatten().filter_map(|step| if let Step::Node(it) = step { Some(it.0) } else { None });
                nodes.collect::<std::collections::BTreeSet<_>>().len()
            };
            paths.chunks(8).map(distinct).sum::<usize>()
        };
        let [hashed, shared] = [Directions::Hashed, Directions::Shared].map(nodes);
        assert!(4 * shared < 3 * hashed, "{shared} of {hashed}");
    }
}
