"""Draws the plots of the study from its CSV files.

    python3 docs/validation/study/plots.py
"""

import csv
import pathlib

import charts

HERE = pathlib.Path(__file__).parent
IMAGES = HERE.parent.parent / "images"
SCENES = [scene for scene in ("kitchen", "robot", "living_room", "staircase", "sponza", "gas_station")
          if any((HERE / f"{kind}_{scene}.csv").exists() for kind in ("unit_designs", "designs"))]
FAIR = "fair: the same and `gather: 128`"
FOUR = "four of those units"
CYCLES = "change of cycles against no culling, %"


def rows(name):
    with open(HERE / name, newline="") as file:
        return list(csv.DictReader(file))


def of_scene(scene):
    full = HERE / f"unit_designs_{scene}.csv"
    return rows(full.name if full.exists() else f"designs_{scene}.csv")


def find(table, column, **wanted):
    """The number of the row that has these values."""
    found = [row for row in table if all(row[name] == value for name, value in wanted.items())]
    return float(found[0][column]) if found else None


def unit():
    table = [row for row in of_scene("kitchen") if row["machine"] == "desktop" and row["policy"] == "Published"]
    groups = [(row["design"].replace("`", ""), [float(row["cycles_change"])]) for row in table]
    return charts.bars("BART kitchen, desktop, published policy: the unit decides", CYCLES, groups, [""])


def scenes(title, column, axis):
    def values(scene):
        table = of_scene(scene)
        return [find(table, column, machine=machine, policy=policy, design=design)
                for machine in ("desktop", "small") for policy, design in (("Published", FAIR), ("Hybrid", FOUR))]

    groups = [(scene.replace("_", " "), values(scene)) for scene in SCENES]
    series = ["desktop, Published", "desktop, Hybrid", "small, Published", "small, Hybrid"]
    return charts.bars(title, axis, groups, series, left=110)


def price():
    """What the published words save when they are free, and what is left when they are paid."""
    series = ["desktop", "desktop, free words", "small", "small, free words"]

    def values(scene):
        table = of_scene(scene)
        return [find(table, "cycles_change", machine=machine, policy="Published", design=design)
                for machine in ("desktop", "small") for design in (FAIR, "free words")]

    groups = [(scene.replace("_", " "), values(scene)) for scene in SCENES]
    return charts.bars("Published words: paid, and for nothing", CYCLES, groups, series, left=110)


def words():
    table = rows("words.csv")
    sizes = [256 << 2 * power for power in range(5)]
    labels = [f"{size} B" if size < 1024 else f"{size // 1024} KiB" for size in sizes]

    def values(scene, machine):
        return [find(table, "cycles_change", scene=scene, machine=machine, design=f"{size} bytes") for size in sizes]

    series = [(f"{scene.replace('_', ' ')}, {machine}", values(scene, machine))
              for scene in ("kitchen", "living_room") for machine in ("desktop", "small")]
    return charts.lines("A cache of a few KiB is enough for the words", "words' L1", CYCLES, labels, series)


def lights():
    table = rows("lights.csv")
    counts = ["1", "4", "15"]

    def values(scene, machine):
        return [find(table, "cycles_change", scene=scene, lights=count, machine=machine, policy="Published",
                     design="as it is") for count in counts]

    series = [(f"{scene.replace('_', ' ')}, {machine}", values(scene, machine))
              for scene in ("living_room", "staircase") for machine in ("desktop", "small")]
    return charts.lines("Published words by the number of lights, 256x256", "lights", CYCLES, counts, series)


def main():
    IMAGES.mkdir(exist_ok=True)
    plots = {
        "study_unit": unit,
        "study_price": price,
        "study_scenes": lambda: scenes("Where culling pays", "cycles_change", CYCLES),
        "study_energy": lambda: scenes("What culling does to energy", "joules_change",
                                       "change of energy against no culling, %"),
        "study_dram": lambda: scenes("What culling does to memory traffic", "dram_change",
                                     "change of DRAM bytes against no culling, %"),
    }
    plots |= {f"study_{plot.__name__}": plot for plot in (words, lights) if (HERE / f"{plot.__name__}.csv").exists()}
    for name, plot in plots.items():
        (IMAGES / f"{name}.svg").write_text(plot())


if __name__ == "__main__":
    main()
