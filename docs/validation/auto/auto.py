"""`Auto(error: 0.02)` beside `Event`: six scenes, nine machines, streams of about as many rays as asked for.

    python3 docs/validation/auto/auto.py target/release/umbrasim 2

Records each scene until it has so many million rays (`Published`), and replays it by both levels in one thread. A row a
replay in auto.csv: errors, half the widths of 95 % intervals, and processor time. Rows of other streams and machines
stay.
"""

import argparse
import csv
import json
import pathlib
import subprocess
import sys
import tempfile

HERE = pathlib.Path(__file__).parent
sys.path.insert(0, str(HERE.parent))

from measure import FIGURES, figures, half_widths, measured

# The scenes, each with its first frame.
SCENES = {"kitchen": 320, "robot": 320, "staircase": 20, "living_room": 20, "sponza": 20, "gas_station": 20}
MACHINES = {
    "small": ["small"], "desktop": ["desktop"],
    "2 miss registers": ["small", "traversal.cache.mshrs=2", "intersection.cache.mshrs=2"],
    "64 miss registers": ["small", "traversal.cache.mshrs=64", "intersection.cache.mshrs=64"],
    "L2 of 16 kB": ["small", "l2.bytes=16KiB"], "L2 of 64 kB": ["small", "l2.bytes=64KiB"],
    "four shadow-cache units": ["small", "shadow_cache.count=4"],
    "words at the L2": ["small", "shadow_cache.place=L2"],
    "a register": ["small", "shadow_cache.register=8"],
}


def replay(program, stream, machine, level):
    """The statistics of a replay, and its processor seconds."""
    name, *settings = MACHINES[machine]
    command = [program, "replay", stream, "--machine", name, "--fidelity", level, "--threads", "1", "--quiet"]
    command += [part for setting in settings for part in ("--set", setting)]
    return measured([*command, "--json", "-"])


def record(program, scene, millions, folder):
    """Records frames of a scene until its stream has so many rays."""
    stream, frames, first = folder / f"{scene}.rays", 2, SCENES[scene]
    # Animations are too short for many rays of small pictures.
    resolution = "256x256" if millions <= 2 else "512x512" if millions <= 10 else "1024x1024"
    while True:
        subprocess.run([program, "trace", f"configs/studies/{scene}.ron", "--resolution", resolution,
                        "--policy", "Published", "--frames", f"{first}..{first + frames}", "--warmup", "0",
                        "--quiet", "-o", stream], check=True)
        found = subprocess.run([program, "inspect", stream, "--json"], capture_output=True, check=True)
        told = json.loads(found.stdout)
        rays = sum(frame["rays"] for frame in told["frames"])
        if rays >= 0.9e6 * millions:
            return stream, rays
        stream.unlink()
        frames = max(frames + 1, round(frames * 1e6 * millions / rays))


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("program")
    parser.add_argument("millions", type=float)
    parser.add_argument("--scenes", nargs="+", default=list(SCENES))
    parser.add_argument("--machines", nargs="+", default=list(MACHINES))
    chosen = parser.parse_args()
    program, table = str(pathlib.Path(chosen.program).resolve()), HERE / "auto.csv"
    with open(table, newline="") as file:
        rows = list(csv.DictReader(file))
    for scene in chosen.scenes:
        with tempfile.TemporaryDirectory() as work:
            stream, rays = record(program, scene, chosen.millions, pathlib.Path(work))
            for machine in chosen.machines:
                truth, slow = replay(program, stream, machine, "Event")
                told, fast = replay(program, stream, machine, "Auto(error: 0.02)")
                what = {"scene": scene, "millions": f"{chosen.millions:g}", "machine": machine}
                rows = [row for row in rows if any(row[name] != value for name, value in what.items())]
                row = {**what, "rays": rays,
                       "windows": told["choice"]["windows"], "of": told["choice"]["of"]}
                widths = half_widths(told)
                is_told, is_so = figures(told), figures(truth)
                for name in FIGURES:
                    row[f"{name}_off_percent"] = f"{100 * (is_told[name] / is_so[name] - 1):.3f}"
                    row[f"{name}_half_width_percent"] = f"{100 * widths.get(name, 0):.3f}"
                rows.append(row | {"event_seconds": f"{slow:.2f}", "auto_seconds": f"{fast:.2f}"})
        with open(table, "w", newline="") as file:
            writer = csv.DictWriter(file, rows[0].keys(), lineterminator="\n")
            writer.writeheader()
            writer.writerows(rows)


if __name__ == "__main__":
    main()
