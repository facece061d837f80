//! Speed of the tracer, with and without recording, beside Embree's single-ray queries on the same rays.
//!
//! `cargo bench --bench tracer` prints a table with one line for each scene, tree and query: millions of rays per
//! second of one thread's processor time, best of three. Without Debian's `libembree-dev` or a C++ compiler, it prints
//! that it skips Embree. The trees differ: ours has two or eight children per node, Embree's has four or eight and
//! Embree's best quality.

use std::error::Error;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use umbrasim::accel::{Accel, AccelSpec, Observer, Ray, Scope, Silent, Trail, World};
use umbrasim::quantity::Resolution;
use umbrasim::ron_file;
use umbrasim::scene::spec::SceneSpec;
use umbrasim::scene::{Frame, Scene};
use umbrasim::stream::Structure;

/// The scenes of the table, with a frame number each. Absent scenes are skipped and named.
const SCENES: [(&str, u32); 5] =
    [("room", 0), ("thicket", 0), ("bart_kitchen", 320), ("living_room", 0), ("sponza", 0)];
const PICTURE: Resolution = Resolution { width: 1024, height: 1024 };
/// Distance from its hit at which a shadow ray starts, as a share of the way to the light.
const LIFT: f32 = 1e-4;

/// Rays from the camera, and one ray from each of their hits to a light; the lights take turns.
struct Rays {
    closest: Vec<Ray>,
    any: Vec<Ray>,
}

impl Rays {
    fn of(world: &World<'_>, frame: &Frame) -> Self {
        let pixels = (0..PICTURE.height).flat_map(|y| (0..PICTURE.width).map(move |x| (x, y)));
        let camera = pixels.map(|(x, y)| frame.camera.ray(PICTURE, x, y));
        let closest: Vec<Ray> =
            camera.map(|ray| Ray::new(ray.origin.as_vec3(), ray.direction.as_vec3(), f32::INFINITY)).collect();
        let hits = closest.iter().filter_map(|ray| Some((ray, world.closest(ray, &mut Silent)?)));
        let to_light = |(number, (ray, hit)): (usize, (&Ray, umbrasim::accel::Hit))| {
            let (point, light) = (ray.origin + ray.direction * hit.t, frame.lights[number % frame.lights.len()]);
            Ray::segment(point + (light.position - point) * LIFT, light.position)
        };
        let any = hits.enumerate().map(to_light).collect();
        Self { closest, any }
    }
}

/// The processor time of this thread in seconds, which other programs do not affect; elapsed time where it is
/// unavailable.
fn seconds() -> f64 {
    #[cfg(unix)]
    {
        let time = rustix::time::clock_gettime(rustix::time::ClockId::ThreadCPUTime);
        time.tv_sec as f64 + time.tv_nsec as f64 * 1e-9
    }
    #[cfg(not(unix))]
    std::time::SystemTime::UNIX_EPOCH.elapsed().map_or(0.0, |time| time.as_secs_f64())
}

/// Millions of rays per second, best of three, and the number of rays for which `ask` returns true.
fn timed(rays: &[Ray], mut ask: impl FnMut(&Ray) -> bool) -> (f64, usize) {
    let run = |_| {
        let start = seconds();
        let hits = rays.iter().filter(|ray| ask(ray)).count();
        (rays.len() as f64 / (seconds() - start) / 1e6, hits)
    };
    (0..3).map(run).max_by(|a, b| a.0.total_cmp(&b.0)).unwrap_or_default()
}

/// [`timed`] with a trail that records each ray's steps.
fn recorded(rays: &[Ray], ask: impl Fn(&Ray, &mut Trail) -> bool) -> f64 {
    let mut trail = Trail::default();
    let ask = |ray: &Ray| {
        trail.clear();
        ask(ray, &mut trail)
    };
    timed(rays, ask).0
}

fn closest(world: &World<'_>, ray: &Ray, watch: &mut impl Observer) -> bool {
    world.closest(ray, watch).is_some()
}

fn any(world: &World<'_>, ray: &Ray, watch: &mut impl Observer) -> bool {
    world.occluded(ray, Scope::All, watch).is_some()
}

/// Embree's results for the same triangles and rays: millions of rays per second and hits, for both queries.
fn embree(scene: &Scene, frame: &Frame, rays: &Rays, program: &Path) -> Result<Vec<(f64, usize)>, Box<dyn Error>> {
    let mut bytes = Vec::new();
    let moving = frame.dynamic.triangles.iter().zip(&frame.visible).filter(|(_, visible)| **visible);
    let triangles: Vec<_> = scene.statics.triangles.iter().chain(moving.map(|(triangle, _)| triangle)).collect();
    let mut put = |records: usize, numbers: &mut dyn Iterator<Item = f32>| {
        bytes.extend((records as u32).to_le_bytes());
        bytes.extend(numbers.flat_map(f32::to_le_bytes));
    };
    put(triangles.len(), &mut triangles.iter().flat_map(|it| it.v).flat_map(|it| it.to_array()));
    for rays in [&rays.closest, &rays.any] {
        let numbers = |ray: &Ray| [ray.origin.to_array().as_slice(), &ray.direction.to_array(), &[ray.reach]].concat();
        put(rays.len(), &mut rays.iter().flat_map(numbers));
    }
    let file = program.with_extension("rays");
    fs::write(&file, bytes)?;
    let output = Command::new(program).arg(&file).output()?;
    fs::remove_file(&file)?;
    let line = |line: &str| {
        let (speed, hits) = line.split_once(' ').ok_or("no two numbers")?;
        Ok((speed.parse()?, hits.parse()?))
    };
    String::from_utf8(output.stdout)?.lines().map(line).collect()
}

/// The program that runs Embree's queries, compiled into `folder`; `None` if that is impossible.
fn embree_program(folder: &Path) -> Option<PathBuf> {
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/fixtures/embree/embree.cpp");
    let program = folder.join("embree");
    let mut compiler = Command::new("c++");
    compiler.args(["-O3", "-march=native", "-o"]).arg(&program).arg(source).arg("-lembree3");
    compiler.output().ok().filter(|output| output.status.success()).map(|_| program)
}

fn main() -> Result<(), Box<dyn Error>> {
    let folder = tempfile::tempdir()?;
    let embree_program = embree_program(folder.path());
    if embree_program.is_none() {
        println!("skips Embree: `c++` cannot build tests/fixtures/embree/embree.cpp (Debian: libembree-dev)");
    }
    println!(
        "{:<13} {:<8} {:<8} {:>8} {:>9} {:>9} {:>8} {:>7} {:>13}",
        "scene", "tree", "question", "Mrays/s", "recorded", "recording", "Embree", "ratio", "hits differ"
    );
    for (name, number) in SCENES {
        let file = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("configs/scenes/{name}.ron"));
        let spec: SceneSpec = ron_file::read(&file)?;
        let scene = match spec.load(file.parent().ok_or("no folder")?) {
            Ok(scene) => scene,
            Err(error) => {
                println!("skips {name}: {error}");
                continue;
            }
        };
        let frame = scene.animation.frame(number);
        let mut theirs = None;
        for structure in [Structure::Bvh2, Structure::CwBvh] {
            let accel = Accel::new(&scene, AccelSpec { structure, ..AccelSpec::default() });
            let world = accel.frame(&scene, &frame);
            let rays = Rays::of(&world, &frame);
            if let (None, Some(program)) = (&theirs, &embree_program) {
                theirs = Some(embree(&scene, &frame, &rays, program)?);
            }
            let both = [
                (
                    "closest",
                    timed(&rays.closest, |ray| closest(&world, ray, &mut Silent)),
                    recorded(&rays.closest, |ray, trail| closest(&world, ray, trail)),
                ),
                (
                    "any",
                    timed(&rays.any, |ray| any(&world, ray, &mut Silent)),
                    recorded(&rays.any, |ray, trail| any(&world, ray, trail)),
                ),
            ];
            for (at, (question, (ours, hits), recording)) in both.into_iter().enumerate() {
                let peer = theirs.as_ref().map_or(("–".into(), "–".into(), "–".into()), |theirs| {
                    let (speed, theirs) = theirs[at];
                    (format!("{speed:.2}"), format!("{:.2}", ours / speed), hits.abs_diff(theirs).to_string())
                });
                println!(
                    "{name:<13} {:<8} {question:<8} {ours:>8.2} {recording:>9.2} {:>7.0} % {:>8} {:>7} {:>13}",
                    format!("{structure:?}"),
                    100.0 * (ours / recording - 1.0),
                    peer.0,
                    peer.1,
                    peer.2
                );
            }
        }
    }
    Ok(())
}
