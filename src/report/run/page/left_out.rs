//! Traffic that machines leave out: the sizes of docs/model/not-modelled.md, from the run's own counts.

use crate::quantity::Bytes;
use crate::report::format::bytes;
use crate::report::grid::Grid;
use crate::report::run::machine_run::MachineRun;
use crate::report::run::summary::Summary;
use crate::stats::TrafficClass;

/// Traffic of the host: its description, its class where a machine models it, the switch, and bytes per frame.
struct HostTraffic {
    what: &'static str,
    class: TrafficClass,
    switch: &'static str,
    bytes: f64,
}

/// The host's traffic per frame without culling; sources of the sizes: docs/model/traffic.md.
fn host_traffic(summary: &Summary) -> Vec<HostTraffic> {
    let Some(off) = summary.baseline.as_deref().and_then(|name| summary.policies.get(name)) else { return Vec::new() };
    let frames = summary.frames.len().max(1) as f64;
    let (primary, seen) =
        (off.counts.primary_rays as f64, (off.counts.primary_rays + off.counts.secondary_rays) as f64);
    let rays = seen + (off.counts.shadow_rays - off.counts.shadow_rays_skipped) as f64;
    let dynamic = summary.scene.triangles_dynamic as f64;
    let row = |what, class, switch, bytes: f64| HostTraffic { what, class, switch, bytes };
    vec![
        row("rays and hits: 32 and 16 B a ray", TrafficClass::Ray, "traffic.rays=Dram", 48.0 * rays / frames),
        row("frame buffer: 4 B a pixel", TrafficClass::FrameBuffer, "traffic.pixel_bytes=4", 4.0 * primary / frames),
        row(
            "textures: 16 B at most a ray that is no shadow ray",
            TrafficClass::Texture,
            "traffic.texture_bytes=16",
            16.0 * seen / frames,
        ),
        row(
            "dynamic triangles, 48 B, and nodes, 64 B at most",
            TrafficClass::Build,
            "traffic.build=Written",
            112.0 * dynamic,
        ),
    ]
}

/// Whether a machine counts traffic of a class in its memory. The FIFOs do not count: rays pass through those of
/// every machine.
fn counts(run: &MachineRun, class: TrafficClass) -> bool {
    let mut levels = ["dram", "ray_buffer"].iter().filter_map(|&level| run.stats.bytes.get(level));
    levels.any(|classes| classes.get(&class).is_some_and(|bytes| bytes.0 > 0))
}

/// The traffic that some machine leaves out; no rows without machines, or without a policy that culls nothing.
pub(super) fn left_out(summary: &Summary) -> Grid {
    let baseline = summary.baseline.as_deref().unwrap_or_default();
    let runs = || summary.machines.iter().filter_map(|(name, it)| it.policies.get(baseline).map(|run| (name, run)));
    let mut rows: Vec<Vec<String>> = Vec::new();
    for traffic in host_traffic(summary).into_iter().filter(|traffic| traffic.bytes > 0.0) {
        let without: Vec<&str> =
            runs().filter(|(_, run)| !counts(run, traffic.class)).map(|(machine, _)| machine).collect();
        if !without.is_empty() {
            let size = bytes(Bytes(traffic.bytes as u64));
            rows.push(vec![traffic.what.into(), size, without.join(", "), format!("--set {}", traffic.switch)]);
        }
    }
    if !rows.is_empty() {
        rows.extend(runs().filter_map(|(machine, run)| {
            let moved = bytes(Bytes(run.dram_bytes_per_frame? as u64));
            Some(vec!["for comparison: what is modelled in the DRAM".into(), moved, machine.into(), String::new()])
        }));
    }
    let head = ["what", "size a frame", "machines", "switch"];
    Grid { head: head.map(Into::into).to_vec(), names: 1, rows }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::run::tests::sample::parts;

    #[test]
    fn sizes_follow_from_counts_and_go_where_the_machine_counts_them() {
        let (mut summary, ..) = parts(&[0, 16]);
        let count_rays = |level: &str, summary: &mut Summary| {
            for run in summary.machines.values_mut().flat_map(|machine| machine.policies.values_mut()) {
                run.stats.bytes.entry(level.into()).or_default().insert(TrafficClass::Ray, Bytes(1));
            }
        };
        count_rays("fifos", &mut summary);
        let baseline = summary.baseline.clone().unwrap();
        let table = left_out(&summary);
        let rays = &table.rows[0];
        let counts = &summary.policies.get(&baseline).unwrap().counts;
        let expected = 48 * (counts.primary_rays + counts.secondary_rays + counts.shadow_rays);
        assert_eq!(rays[1], bytes(Bytes(expected / summary.frames.len() as u64)));
        count_rays("dram", &mut summary);
        assert!(left_out(&summary).rows.iter().all(|row| !row[0].starts_with("rays")));
        summary.machines = crate::named::Named::default();
        assert!(left_out(&summary).rows.is_empty());
    }
}
