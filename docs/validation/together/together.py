"""Makes one sweep by Event and by a sampled level: processor time of both, and how far every figure is off.

    python3 docs/validation/together/together.py target/release/umbrasim configs/studies/machines_kitchen.ron

Streams are recorded before. Writes together.csv, a row a point, and the chart. Event may make the points of a smaller
sweep alone (`--checked`), which varies some of the fields one by one: only those are compared then.
"""

import argparse
import csv
import json
import pathlib
import subprocess
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor

HERE = pathlib.Path(__file__).parent
sys.path.insert(0, str(HERE.parent))

import chart
from measure import FIGURES, figures, half_widths, seconds


def points(program, sweep, folder, level):
    """The points of a sweep in its order: the fields of each, its figures, and half the widths of their intervals."""
    plan = [program, "sweep", sweep, "--out", folder, "--fidelity", level, "--plan", "-"]
    told = subprocess.run(plan, capture_output=True, text=True, check=True).stdout
    for row in csv.DictReader(told.splitlines()):
        point = json.loads((folder / "points" / f"{row.pop('identity')}.json").read_text())
        stats = point["measured"]["stats"]
        what = {key: value for key, value in row.items() if key not in ("index", "cost")}
        yield what, figures(stats), half_widths(stats)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("program")
    parser.add_argument("sweep")
    parser.add_argument("--checked", help="the sweep that Event makes, where it is not the same")
    parser.add_argument("--level", default="Auto(error: 0.02)", help="the sampled level")
    parser.add_argument("--table", default=HERE / "together.csv", help="where the rows go")
    chosen = parser.parse_args()
    program = str(pathlib.Path(chosen.program).resolve())
    ways = {"sampled": (chosen.sweep, chosen.level), "Event": (chosen.checked or chosen.sweep, "Event")}
    with tempfile.TemporaryDirectory() as work, ThreadPoolExecutor() as beside:
        def make(name):
            """Makes a sweep on one thread; the seconds that it takes, and its points."""
            (sweep, level), folder = ways[name], pathlib.Path(work, name)
            took = seconds([program, "sweep", sweep, "--out", folder, "--fidelity", level, "--threads", "1"])
            made = list(points(program, sweep, folder, level))
            print(f"{len(made)} points by {level}: {took:.0f} s", flush=True)
            return took, made

        for name, (sweep, _) in ways.items():
            subprocess.run([program, "sweep", sweep, "--out", pathlib.Path(work, name), "--record"], check=True)
        # Side by side: processor time is what is measured.
        made = dict(zip(ways, beside.map(make, ways)))
    times, found = [{name: of[at] for name, of in made.items()} for at in (0, 1)]
    def told(what):
        """What was told of a point. The first that has its fields has all others as its machine has them."""
        return next(told for fields, *told in found["sampled"] if what.items() <= fields.items())

    pairs = [(what, truth, *told(what)) for what, truth, _ in found["Event"]]
    # As long as Event would take for all of them.
    count = len(found["sampled"])
    times["Event"] *= count / len(pairs)
    baselines = {}
    for what, truth, told, _ in pairs:
        if what["role"] != "free words":
            baselines.setdefault((what["machine"], what["policy"]), (truth, told))
    table = []
    for what, truth, told, widths in pairs:
        base, row = baselines[what["machine"], what["policy"]], dict(what)
        for figure in FIGURES:
            row[figure] = truth[figure]
            row[f"{figure}_off_percent"] = f"{100 * (told[figure] / truth[figure] - 1):.3f}"
            row[f"{figure}_half_width_percent"] = f"{100 * widths.get(figure, 0):.3f}"
            changes = [one[figure] / of[figure] for one, of in ((told, base[1]), (truth, base[0]))]
            row[f"{figure}_change_off_points"] = f"{100 * (changes[0] - changes[1]):.3f}"
        table.append(row)
    with open(chosen.table, "w", newline="") as file:
        writer = csv.DictWriter(file, table[0].keys(), lineterminator="\n")
        writer.writeheader()
        writer.writerows(table)
    chart.draw(table, {"Event": times["Event"], "sampled": times["sampled"]})
    print(f"{count} points: {times['Event']:.0f} s by Event, {times['sampled']:.0f} s by {chosen.level}")
    for kind in ("off_percent", "change_off_points"):
        for figure in FIGURES:
            off = sorted(abs(float(row[f"{figure}_{kind}"])) for row in table)
            print(f"{figure:10} {kind:18} mean {sum(off) / len(off):.2f}  most {off[-1]:.2f}")
    intervals = [(abs(float(row[f"{figure}_off_percent"])), float(row[f"{figure}_half_width_percent"]))
                 for row in table for figure in FIGURES if float(row[f"{figure}_half_width_percent"]) > 0]
    print(f"{sum(off <= width for off, width in intervals)} of {len(intervals)} intervals hold")


if __name__ == "__main__":
    main()
