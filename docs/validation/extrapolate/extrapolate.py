"""Predicts machines of 16 and 64 cores from scale models, and replays the large machines by Event.

    python3 docs/validation/extrapolate/extrapolate.py umbrasim

The program is named by its path, or found on PATH. Streams are recorded first, into `--streams FOLDER` or a folder that
goes away. Each row of replays.csv and predictions.csv is written as soon as it is known; rows that are there are not
made again. `tables.py` makes the tables of docs/validation/extrapolate.md of both files.
"""

import argparse
import csv
import pathlib
import re
import subprocess
import sys
import tempfile

HERE = pathlib.Path(__file__).parent
sys.path.insert(0, str(HERE.parent))

from measure import FIGURES, figures, measured

ROOT = HERE.parent.parent.parent
# Experiment, scene, frames, resolution, policy. Where there are two frames, the first one warms up.
STREAMS = {
    "kitchen": ("policies_kitchen", None, "320..321", "512x512", "Off"),
    "kitchen, culled": ("policies_kitchen", None, "319..321", "512x512", "Published"),
    "living room, culled": ("policies_living_room", None, "20..22", "256x256", "Published"),
    "Sibenik": ("policies_living_room", "sibenik", "0..1", "256x256", "Off"),
}
MACHINES = ["small", "desktop", "mobile"]
LARGE = [16, 64]
# Machines that other laws scale: they replay the whole stream.
FEW = [2, 4]
# In front of which bits of an address those of the channel stand.
ABOVE = {"small": "Column(1), ", "mobile": "Column(1), ", "desktop": "BankGroup(1), Column(1), "}


def trace(program, name, folder):
    """The file of a stream, which is recorded if it is not there."""
    file = folder / f"{re.sub('[^a-z]+', '_', name.lower())}.rays"
    experiment, scene, frames, size, policy = STREAMS[name]
    if not file.exists():
        command = [program, "trace", ROOT / f"configs/experiments/{experiment}.ron", "--frames", frames]
        command += ["--resolution", size, "--policy", policy, "--output", file, "--quiet"]
        command += ["--scene", ROOT / f"configs/scenes/{scene}.ron"] if scene else []
        subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
    return file


def replay(program, stream, machine, cores, folder):
    """Figures of a machine with so many cores and channels on the whole stream, by Event."""
    text = (ROOT / f"configs/machines/{machine}.ron").read_text()
    text = re.sub(r"channels: \d+", f"channels: {cores}", text)
    text = re.sub(r"Channel\(\d+\), ", "", text)
    channel = f"Channel({cores.bit_length() - 1}), "
    text = text.replace(f"mapping: [{ABOVE[machine]}", f"mapping: [{ABOVE[machine]}{channel}")
    text = text.replace("    dispatcher: (", f"    cores: {cores},\n    dispatcher: (", 1)
    text = text.replace('"../dram/', f'"{ROOT}/configs/dram/')
    file = folder / f"{machine}_{cores}.ron"
    file.write_text(text)
    stats, seconds = measured([program, "replay", stream, "--machine", file, "--json", "-", "--quiet"])
    energy = stats.get("energy") or {}
    return {**figures(stats), "joules": energy.get("joules", ""), "seconds": f"{seconds:.1f}"}


def predict(program, stream, machine, cores, _):
    """What scale models say of the same machine: the prediction, its range, and what each model stands for."""
    command = [program, "extrapolate", stream, "--machine", ROOT / f"configs/machines/{machine}.ron"]
    command += ["--cores", str(cores), "--channels", str(cores), "--json", "-", "--quiet"]
    found, seconds = measured(command)
    row = {"models": " ".join(str(model["cores"]) for model in found["models"]), "seconds": f"{seconds:.1f}",
           "rays_an_entry": f"{found['rays_an_entry']:.1f}"}
    for figure in FIGURES:
        predicted = found["predicted"][figure]
        row[figure] = round(predicted["value"])
        row[f"{figure}_low"], row[f"{figure}_high"] = round(predicted["low"]), round(predicted["high"])
        row[f"{figure}_models"] = " ".join(str(round(model["figures"][figure])) for model in found["models"])
    # That of a DRAM of which no currents are known is not.
    known = found["joules"]
    for name, kind in (("joules", "value"), ("joules_low", "low"), ("joules_high", "high")):
        row[name] = known[kind] if known else ""
    row["joules_models"] = " ".join(str(model["joules"]) for model in found["models"]) if known else ""
    return row


def fill(table, cases, make):
    """Adds the rows of `cases` that a table has not."""
    known = list(csv.DictReader(table.open())) if table.exists() else []
    done = {(row["stream"], row["machine"], int(row["cores"])) for row in known}
    with table.open("a", newline="") as out:
        for stream, machine, cores in (case for case in cases if case not in done):
            row = {"stream": stream, "machine": machine, "cores": cores, **make(stream, machine, cores)}
            writer = csv.DictWriter(out, row, lineterminator="\n")
            if table.stat().st_size == 0:
                writer.writeheader()
            writer.writerow(row)
            out.flush()


def main():
    arguments = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    arguments.add_argument("program")
    arguments.add_argument("--streams", type=pathlib.Path)
    arguments.add_argument("--only", choices=["replays", "predictions"])
    arguments.add_argument("--cores", type=int, nargs="+", default=[*LARGE, *FEW])
    asked = arguments.parse_args()
    with tempfile.TemporaryDirectory() as place:
        folder = pathlib.Path(place)
        streams = asked.streams or folder

        def run(of):
            return lambda stream, *case: of(asked.program, trace(asked.program, stream, streams), *case, folder)

        def wanted(of):
            return [case for case in of if case[2] in asked.cores]

        cases = [(stream, machine, cores) for cores in LARGE for machine in MACHINES for stream in STREAMS]
        few = [(stream, machine, cores) for machine in MACHINES for stream in STREAMS for cores in FEW]
        if asked.only != "replays":
            fill(HERE / "predictions.csv", wanted(cases), run(predict))
        if asked.only != "predictions":
            fill(HERE / "replays.csv", wanted(cases + few), run(replay))


if __name__ == "__main__":
    main()
