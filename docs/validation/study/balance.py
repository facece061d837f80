"""Measures how busy the units of the shipped machines are without culling, and writes a CSV file.

    python3 docs/validation/study/balance.py docs/validation/study/balance.csv

Each row is one command: `umbrasim replay STREAM --machine MACHINE`, with the stream of `umbrasim trace
configs/studies/SCENE.ron --resolution 256x256 --policy Off --warmup 1 -o STREAM`.
"""

import argparse
import pathlib
import subprocess
import tempfile

from unit_designs import CAUSES, replay, write

SCENES = ["kitchen", "robot", "staircase", "living_room", "sponza", "gas_station"]
UNITS = ["dispatcher", "traversal", "intersection", "division"]


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("csv")
    parser.add_argument("--program", default="target/release/umbrasim")
    parser.add_argument("--threads", default="2")
    chosen = parser.parse_args()
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        stream = str(pathlib.Path(folder) / "off.rays")
        for scene in SCENES:
            subprocess.run([chosen.program, "trace", f"configs/studies/{scene}.ron", "--policy", "Off", "--warmup", "1",
                            "--resolution", "256x256", "--threads", chosen.threads, "--quiet", "-o", stream],
                           check=True, stdout=subprocess.DEVNULL)
            for machine in ("small", "mobile", "desktop"):
                stats = replay(chosen.program, stream, machine, {})
                peak = stats["cycles"] * stats["dram_peak_bytes_per_cycle"]
                rows.append({"scene": scene, "machine": machine} | {
                    unit: stats["units"][unit]["busy"] / sum(stats["units"][unit][cause] for cause in CAUSES)
                    for unit in UNITS} | {"dram": sum(stats["bytes"]["dram"].values()) / peak})
    write(chosen.csv, rows)


if __name__ == "__main__":
    main()
