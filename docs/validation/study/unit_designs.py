"""Replays a scene on designs of the shadow-cache unit, and writes a CSV file: a row a replay.

    python3 docs/validation/study/unit_designs.py kitchen docs/validation/study/unit_designs_kitchen.csv

Streams come from configs/studies/SCENE.ron. Each row is one command: `umbrasim replay STREAM --machine MACHINE` with a
`--set` for each change. The first frame warms up: all columns but `cold_cycles` are of the frames after it.
"""

import argparse
import csv
import json
import pathlib
import subprocess
import tempfile
from concurrent.futures import ThreadPoolExecutor

# Names of designs, and what they change in the unit of the machine before them.
ALONE = {
    "naive: as read from the poster": {},
    "`silent: Latched` alone": {"silent": "Latched"},
    "`silent: Live` alone": {"silent": "Live"},
    "`decide: Hit` alone": {"decide": "Hit"},
    "`width: 4` alone": {"width": "4"},
    "`count: 4` alone": {"count": "4"},
    "`gather: 128` alone": {"gather": "128"},
    "`register: 16` alone": {"register": "16"},
    "`latched: Wide` alone": {"latched": "Wide"},
    "`latched: Buffers` alone": {"latched": "Buffers"},
}
FAIR = {
    "`Latched`, `Hit`, width, `Wide` together": {"gather": "0"},
    "the same, `latched: Buffers`": {"gather": "0", "latched": "Buffers"},
    "fair: the same and `gather: 128`": {},
    "fair, `register: 16`": {"register": "16"},
    "that, `width: 4`, 64 contexts, 4 L1 ports": {
        "register": "16", "width": "4", "contexts": "64", "cache.ports": "4"},
    "four of those units": {"register": "16", "width": "4", "contexts": "64", "cache.ports": "4", "count": "4"},
    "fair, an L1 that never misses": {"cache.contents": "Ideal"},
    "free words": {"place": "Free"},
}
# What is replayed with `--designs six`, and with `--designs two`.
SIX = ["naive: as read from the poster", "`silent: Latched` alone", "`gather: 128` alone",
       "fair: the same and `gather: 128`", "four of those units", "free words"]
TWO = {"Published": ["fair: the same and `gather: 128`", "free words"], "Hybrid": ["four of those units", "free words"]}
# `Hybrid` updates no words of primitives within a frame: options of updates do nothing there.
OF_HYBRID = ["naive: as read from the poster", "`count: 4` alone", "fair: the same and `gather: 128`",
             "fair, `register: 16`", "that, `width: 4`, 64 contexts, 4 L1 ports", "four of those units",
             "fair, an L1 that never misses", "free words"]
CAUSES = ["busy", "pipeline", "memory", "blocked", "intake", "starved"]


def replay(program, stream, machine, changes, fidelity="Event"):
    """The figures of a replay."""
    sets = [word for field, value in changes.items() for word in ("--set", f"shadow_cache.{field}={value}")]
    command = [program, "replay", stream, "--machine", machine, *sets, "--fidelity", fidelity, "--threads", "1",
               "--quiet", "--json"]
    return json.loads(subprocess.run(command, check=True, stdout=subprocess.PIPE).stdout)


def row(machine, policy, design, changes, stats, off):
    """A row, with changes against no culling."""
    def cold(stats):
        return sum(frame["cycles"] for frame in stats["frames"] if frame["warmup"])

    def dram(stats):
        return sum(stats["bytes"]["dram"].values())

    unit = stats["units"]["shadow_cache"]
    energy = stats["energy"]
    found = {
        "machine": machine, "policy": policy, "design": design,
        "changes": " ".join(f"shadow_cache.{field}={value}" for field, value in changes.items()),
        "cycles": stats["cycles"], "cold_cycles": cold(stats), "dram_bytes": dram(stats),
        "joules": energy["joules"], "joules_low": energy["low"], "joules_high": energy["high"],
        "cycles_change": stats["cycles"] / off["cycles"] - 1, "cold_change": cold(stats) / cold(off) - 1,
        "dram_change": dram(stats) / dram(off) - 1, "joules_change": energy["joules"] / off["energy"]["joules"] - 1,
    }
    total = sum(unit[cause] for cause in CAUSES)
    return found | {f"unit_{cause}": unit[cause] / total for cause in CAUSES}


def write(path, rows):
    """Writes rows as CSV, measures with six digits."""
    with open(path, "w", newline="") as file:
        writer = csv.DictWriter(file, rows[0].keys(), lineterminator="\n")
        writer.writeheader()
        writer.writerows({name: f"{value:.6g}" if isinstance(value, float) else value for name, value in it.items()}
                         for it in rows)


def wanted(designs, policy, design):
    """Whether a design is replayed for a policy."""
    chosen = {"all": [*ALONE, *FAIR], "six": SIX, "two": TWO[policy]}[designs]
    return design in chosen and (policy == "Published" or design in OF_HYBRID)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("scene", help="a file of configs/studies without .ron")
    parser.add_argument("csv")
    parser.add_argument("--designs", choices=["all", "six", "two"], default="all")
    parser.add_argument("--resolution", default="512x512")
    parser.add_argument("--frames", help="other frames than the file's")
    parser.add_argument("--program", default="target/release/umbrasim")
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--machines", default="desktop,small")
    chosen = parser.parse_args()
    frames = ["--frames", chosen.frames] if chosen.frames else []
    with tempfile.TemporaryDirectory() as folder, ThreadPoolExecutor(chosen.threads) as pool:
        streams = {policy: str(pathlib.Path(folder) / f"{policy}.rays") for policy in ("Off", "Published", "Hybrid")}
        for policy, stream in streams.items():
            subprocess.run([chosen.program, "trace", f"configs/studies/{chosen.scene}.ron", "--policy", policy,
                            "--warmup", "1", "--threads", str(chosen.threads), "--quiet", "-o", stream,
                            "--resolution", chosen.resolution, *frames], check=True, stdout=subprocess.DEVNULL)
        plan = []
        for machine in chosen.machines.split(","):
            plan.append((machine, "Off", "no culling", machine, {}))
            for policy in ("Published", "Hybrid"):
                for base, designs in ((f"{machine}_naive", ALONE), (machine, FAIR)):
                    plan += [(machine, policy, design, base, changes) for design, changes in designs.items()
                             if wanted(chosen.designs, policy, design)]
        stats = list(pool.map(lambda it: replay(chosen.program, streams[it[1]], it[3], it[4]), plan))
    off = {it[0]: found for it, found in zip(plan, stats) if it[1] == "Off"}
    rows = [row(it[0], it[1], it[2], it[4], found, off[it[0]]) for it, found in zip(plan, stats)]
    write(chosen.csv, rows)


if __name__ == "__main__":
    main()
