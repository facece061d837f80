"""Draws time and memory over what grows, both axes logarithmic, as SVG, with the Python standard library alone.

    python3 docs/validation/scale/chart.py
"""

import csv
import math
import pathlib

HERE = pathlib.Path(__file__).parent
IMAGE = HERE.parent.parent / "images" / "scale.svg"
COLOURS = {"trace": "#0072b2", "replay": "#d55e00"}
TITLES = {
    "triangles": "triangles", "width": "pixels across (rays grow with their square)", "frames": "frames",
    "lights": "lights", "machines": "machines in one replay",
}
WIDTH, ROW, LEFT, PANEL = 720, 190, 62, 270


def short(number):
    for unit, name in ((1e6, " M"), (1e3, " k")):
        if number >= unit:
            return f"{number / unit:g}{name}"
    return f"{number:g}"


def panel(table, series, what, unit, at, top):
    """Points and lines of one measure over one series."""
    left = LEFT + at * (PANEL + 72)
    right, bottom = left + PANEL, top + ROW - 62
    of = [row for row in table if row["series"] == series]
    xs, ys = [float(row["value"]) for row in of], [float(row[what]) for row in of]
    low, high = 10 ** math.floor(math.log10(min(ys))), 10 ** math.ceil(math.log10(max(ys)) + 1e-9)

    def place(x, y):
        across = math.log(x / min(xs)) / math.log(max(xs) / min(xs))
        return left + 10 + (PANEL - 20) * across, bottom - (bottom - top) * math.log(y / low) / math.log(high / low)

    parts = []
    mark = low
    while mark <= high * 1.01:
        y = place(min(xs), mark)[1]
        parts.append(f'<line x1="{left}" y1="{y:.1f}" x2="{right}" y2="{y:.1f}" stroke="#ddd"/>')
        parts.append(f'<text x="{left - 6}" y="{y + 4:.1f}" text-anchor="end" fill="#555">{short(mark)}</text>')
        mark *= 10
    for x in sorted(set(xs)):
        parts.append(f'<text x="{place(x, low)[0]:.1f}" y="{bottom + 16}" text-anchor="middle" fill="#555">'
                     f"{short(x)}</text>")
    parts.append(f'<text x="{(left + right) / 2}" y="{bottom + 34}" text-anchor="middle" fill="#555">'
                 f"{TITLES[series]}</text>")
    parts.append(f'<text x="{left}" y="{top - 8}" fill="#222">{unit}</text>')
    for command, colour in COLOURS.items():
        points = [place(float(row["value"]), float(row[what])) for row in of if row["command"] == command]
        joined = " ".join(f"{x:.1f},{y:.1f}" for x, y in points)
        parts.append(f'<polyline points="{joined}" fill="none" stroke="{colour}" stroke-width="2"/>')
        parts += [f'<circle cx="{x:.1f}" cy="{y:.1f}" r="3.5" fill="{colour}"/>' for x, y in points]
    return parts


def draw(table):
    """Writes the chart of `table`, the rows of scale.csv."""
    height = 76 + ROW * len(TITLES)
    title = "Time and memory of one thread, both axes logarithmic"
    parts = [f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {height}" width="{WIDTH}" '
             f'height="{height}" font-family="Helvetica, Arial, sans-serif" font-size="13" role="img">',
             f"<title>{title}</title>", f'<rect width="{WIDTH}" height="{height}" fill="#fff"/>',
             f'<text x="16" y="24" font-weight="bold" fill="#222">{title}</text>']
    for at, (command, colour) in enumerate(COLOURS.items()):
        parts.append(f'<rect x="{16 + 90 * at}" y="36" width="12" height="12" fill="{colour}"/>'
                     f'<text x="{33 + 90 * at}" y="47" fill="#222">{command}</text>')
    for index, series in enumerate(TITLES):
        top = 86 + ROW * index
        parts += panel(table, series, "seconds", "processor seconds", 0, top)
        parts += panel(table, series, "megabytes", "MB, at most", 1, top)
    IMAGE.write_text("\n".join([*parts, "</svg>\n"]))


if __name__ == "__main__":
    with open(HERE / "scale.csv", newline="") as file:
        draw(list(csv.DictReader(file)))
