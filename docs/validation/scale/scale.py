"""Measures processor time and memory against what grows: triangles, rays, frames, lights and machines.

    python3 docs/validation/scale/scale.py target/release/umbrasim

With `--series triangles` that series alone is measured; the others stay as they are in scale.csv.
Each run has one thread. The slope of a series is that of a straight line through the logarithms of its points: 1 says
that twice as much takes twice as long. Writes scale.csv and the chart.
"""

import argparse
import csv
import math
import os
import pathlib
import subprocess
import tempfile

import chart

HERE = pathlib.Path(__file__).parent
SCENE = "BuiltIn(Thicket(lights: {lights}, frame_count: 120, triangles: {triangles}))"
EXPERIMENT = """(
    name: "scale",
    scene: "scene.ron",
    frames: "0..{frames}",
    resolution: (width: {width}, height: {width}),
    warmup: 0,
    policies: {{"Off": Off, "Published": Published()}},
)"""
# What a run has where its series does not say otherwise.
USUAL = {"triangles": 100_000, "lights": 2, "frames": 2, "width": 256, "machines": 1}
SERIES = {
    "triangles": [10_000, 30_000, 100_000, 300_000, 1_000_000, 3_000_000, 10_000_000],
    "width": [64, 128, 256, 512],
    "frames": [2, 4, 8, 16],
    "lights": [1, 2, 4, 6],
    "machines": [1, 2, 4],
}
MACHINES = ["desktop", "small", "mobile", "desktop_naive", "small_naive", "arches_like", "raycore", "ideal"]


def measured(command, folder):
    """Processor seconds and the most memory, in MB, that a command takes."""
    with open(os.devnull, "w") as nowhere:
        child = subprocess.Popen(command, cwd=folder, stdout=nowhere, stderr=nowhere)
        _, status, used = os.wait4(child.pid, 0)
    if status != 0:
        raise SystemExit(f"{' '.join(command)} ended with {status}")
    return used.ru_utime + used.ru_stime, used.ru_maxrss / 1000


def rays(program, folder):
    """Rays of the stream in the folder."""
    told = subprocess.run([program, "inspect", "s.rays"], cwd=folder, capture_output=True, text=True, check=True)
    frames = [line.split() for line in told.stdout.split("Rays by")[0].splitlines()]
    return sum(int(words[1]) for words in frames if len(words) > 5 and words[0].isdigit())


def rows(program, series, value):
    """The rows of a point: what its trace and its replay take."""
    of = USUAL | {series: value}
    with tempfile.TemporaryDirectory() as folder:
        pathlib.Path(folder, "scene.ron").write_text(SCENE.format(**of))
        pathlib.Path(folder, "e.ron").write_text(EXPERIMENT.format(**of))
        machines = [word for name in MACHINES[:of["machines"]] for word in ("--machine", name)]
        commands = {
            "trace": [program, "trace", "e.ron", "--policy", "Published", "-o", "s.rays", "--threads", "1"],
            "replay": [program, "replay", "s.rays", *machines, "--threads", "1"],
        }
        for name, command in commands.items():
            seconds, megabytes = measured(command, folder)
            yield {"series": series, "value": value, "command": name, "rays": rays(program, folder),
                   "seconds": f"{seconds:.3g}", "megabytes": f"{megabytes:.0f}"}


def slope(points):
    """That of a straight line through the logarithms of points."""
    xs, ys = zip(*((math.log(x), math.log(y)) for x, y in points))
    x, y = sum(xs) / len(xs), sum(ys) / len(ys)
    return sum((a - x) * (b - y) for a, b in zip(xs, ys)) / sum((a - x) ** 2 for a in xs)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("program")
    parser.add_argument("--series", choices=SERIES, action="append", help="measure this one [default: all]")
    chosen = parser.parse_args()
    program = str(pathlib.Path(chosen.program).resolve())
    with open(HERE / "scale.csv", newline="") as file:
        known = list(csv.DictReader(file))
    table = []
    for series, values in SERIES.items():
        if chosen.series and series not in chosen.series:
            table += [row for row in known if row["series"] == series]
        else:
            table += [row for value in values for row in rows(program, series, value)]
    with open(HERE / "scale.csv", "w", newline="") as file:
        writer = csv.DictWriter(file, table[0].keys(), lineterminator="\n")
        writer.writeheader()
        writer.writerows(table)
    chart.draw(table)
    for series in SERIES:
        for command in ("trace", "replay"):
            of = [row for row in table if (row["series"], row["command"]) == (series, command)]
            slopes = [slope([(float(row["value"]), float(row[what])) for row in of]) for what in ("seconds", "megabytes")]
            print(f"{series:10} {command:7} time {slopes[0]:5.2f}  memory {slopes[1]:5.2f}")


if __name__ == "__main__":
    main()
