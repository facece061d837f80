"""Prints the tables of docs/validation/extrapolate.md from replays.csv and predictions.csv.

    python3 docs/validation/extrapolate/tables.py
"""

import csv
import pathlib
import statistics

HERE = pathlib.Path(__file__).parent
FIGURES = {"cycles": "cycles", "l2_bytes": "L2 bytes", "dram_bytes": "DRAM bytes", "joules": "energy"}
SHOWN = {"cycles": "{:,.0f}", "l2_bytes": "{:,.1f} MB", "dram_bytes": "{:,.1f} MB", "joules": "{:,.1f}"}
UNITS = {"cycles": 1, "l2_bytes": 1e6, "dram_bytes": 1e6, "joules": 1e-3}
# Rays of a frame for each entry of the pool, below which the command says that they are few.
FEW = 32
LAWS = ["scale models", "largest model as it is", "power law", "proportional"]


def rows(name):
    """The rows of a table by stream, machine and cores."""
    table = csv.DictReader((HERE / f"{name}.csv").open())
    return {(row["stream"], row["machine"], int(row["cores"])): row for row in table}


def others(replays, case, figure):
    """What a power law and proportional scaling say, from 2 and 4 cores that replay the whole stream."""
    stream, machine, cores = case
    try:
        two, four = (float(replays[stream, machine, few][figure]) for few in (2, 4))
    except KeyError:
        return None, None
    doublings = (cores // 4).bit_length() - 1
    return four * (four / two) ** doublings, four * 4 / cores if figure == "cycles" else four


def off(value, truth):
    """The error in percent, if there is a value."""
    return None if value is None else (value / truth - 1) * 100


def main():
    replays, predictions = rows("replays"), rows("predictions")
    cases = [case for case in predictions if case in replays]
    # Cores, figure and law to errors; figure to errors where rays are not few, and to whether ranges hold; cores to
    # shares of processor time.
    errors, many, holds, shares = {}, {}, {}, {}
    names = " | off | ".join([*list(FIGURES.values())[:3], "energy, mJ"])
    print(f"| stream | machine | cores | {names} | off | time |")
    print("|---|---|---|" + "---|---|" * len(FIGURES) + "---|")
    for case in sorted(cases, key=lambda case: (case[2], case[1], case[0])):
        row, truth = predictions[case], replays[case]
        cells = []
        for figure in FIGURES:
            real = float(truth[figure])
            power, proportional = others(replays, case, figure)
            largest = float(row[f"{figure}_models"].split()[-1])
            values = [float(row[figure]), largest, power, proportional]
            for law, value in zip(LAWS, values):
                if value is not None:
                    errors.setdefault((case[2], figure, law), []).append(abs(off(value, real)))
            if float(row["rays_an_entry"]) >= FEW:
                many.setdefault(figure, []).append(abs(off(values[0], real)))
            inside = float(row[f"{figure}_low"]) <= real <= float(row[f"{figure}_high"])
            holds.setdefault(figure, []).append(inside)
            cells.append(SHOWN[figure].format(real / UNITS[figure]))
            cells.append(f"{off(float(row[figure]), real):+.1f} %")
        share = float(row["seconds"]) / float(truth["seconds"])
        shares.setdefault(case[2], []).append(share)
        print(f"| {case[0]} | {case[1]} | {case[2]} | {' | '.join(cells)} | {share:.2f} |")
    print("\n| cores | law | " + " | ".join(f"{name}: mean | worst" for name in FIGURES.values()) + " |")
    print("|---|---|" + "---|---|" * len(FIGURES))
    for cores in sorted({case[2] for case in cases}):
        for law in LAWS:
            of = [errors.get((cores, figure, law)) for figure in FIGURES]
            if all(of):
                cells = [f"{statistics.mean(values):.1f} % | {max(values):.1f} %" for values in of]
                print(f"| {cores} | {law} | {' | '.join(cells)} |")
    for figure, of in many.items():
        name, mean = FIGURES[figure], statistics.mean(of)
        print(f"\n{name}, {FEW} rays an entry or more ({len(of)} cases): mean {mean:.1f} %, worst {max(of):.1f} %")
    for figure, inside in holds.items():
        print(f"\nrange of {FIGURES[figure]} holds: {sum(inside)} of {len(inside)}")
    for cores, of in sorted(shares.items()):
        print(f"\nprocessor time at {cores} cores: {statistics.mean(of):.2f} of Event's on average")


if __name__ == "__main__":
    main()
