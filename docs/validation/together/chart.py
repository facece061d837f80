"""Draws how far each figure of a sampled sweep is off, and the processor time of both ways, as SVG, with the Python
standard library alone."""

import math
import pathlib

IMAGE = pathlib.Path(__file__).parent.parent.parent / "images" / "together.svg"
WIDTH, LEFT, RIGHT, ROW = 720, 190, 700, 34
PANELS = [
    ("off_percent", "figures, off by percent (grey: the aim)", 1.0),
    ("change_off_points", "changes from the baseline, off by points (grey: the aim)", 0.5),
]
NAMES = {"cycles": "cycles", "l2_bytes": "L2 bytes", "dram_bytes": "DRAM bytes"}
COLOURS = ["#0072b2", "#d55e00", "#009e73", "#cc79a7"]


def times(parts, seconds):
    """A bar for each way."""
    most = max(seconds.values())
    for at, (name, value) in enumerate(seconds.items()):
        y, width = 66 + 26 * at, max(2, (RIGHT - LEFT - 80) * value / most)
        parts.append(f'<text x="{LEFT - 10}" y="{y + 13}" text-anchor="end" fill="#222">{name}</text>'
                     f'<rect x="{LEFT}" y="{y}" width="{width:.1f}" height="18" fill="{COLOURS[at]}"/>'
                     f'<text x="{LEFT + width + 8:.1f}" y="{y + 13}" fill="#222">{value:,.0f} s</text>')


def panel(parts, table, top, kind, title, aim):
    """A dot a point, in rows by figure; coloured by machine."""
    machines = sorted({row["machine"] for row in table})
    largest = max(abs(float(row[f"{figure}_{kind}"])) for row in table for figure in NAMES)
    reach = aim * max(2, math.ceil(largest / aim))
    middle, scale = (LEFT + RIGHT) / 2, (RIGHT - LEFT) / 2 / reach
    bottom = top + ROW * len(NAMES)
    parts.append(f'<text x="16" y="{top - 10}" font-weight="bold" fill="#222">{title}</text>'
                 f'<rect x="{middle - aim * scale:.1f}" y="{top}" width="{2 * aim * scale:.1f}" '
                 f'height="{bottom - top}" fill="#eee"/>')
    for mark in (-reach, -aim, 0, aim, reach):
        x = middle + mark * scale
        parts.append(f'<line x1="{x:.1f}" y1="{top}" x2="{x:.1f}" y2="{bottom}" stroke="#bbb"/>'
                     f'<text x="{x:.1f}" y="{bottom + 15}" text-anchor="middle" fill="#555">{f"{mark:+g}" if mark else 0}</text>')
    for at, (figure, name) in enumerate(NAMES.items()):
        y = top + ROW * (at + 0.5)
        parts.append(f'<text x="{LEFT - 10}" y="{y + 4:.1f}" text-anchor="end" fill="#222">{name}</text>')
        for row in table:
            off = float(row[f"{figure}_{kind}"])
            place = machines.index(row["machine"])
            parts.append(f'<circle cx="{middle + off * scale:.1f}" cy="{y + 8 * place - 4 * (len(machines) - 1):.1f}" '
                         f'r="2.6" fill="{COLOURS[place % len(COLOURS)]}" fill-opacity="0.6"/>')
    return machines


def draw(table, seconds):
    """Writes the chart of the rows of together.csv."""
    height = 150 + len(PANELS) * (ROW * len(NAMES) + 70)
    title = "One sweep by Event and together: processor time, and every figure's difference"
    parts = [f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {height}" width="{WIDTH}" '
             f'height="{height}" font-family="Helvetica, Arial, sans-serif" font-size="13" role="img">',
             f"<title>{title}</title>", f'<rect width="{WIDTH}" height="{height}" fill="#fff"/>',
             f'<text x="16" y="24" font-weight="bold" fill="#222">{title}</text>',
             '<text x="16" y="50" font-weight="bold" fill="#222">processor time</text>']
    times(parts, seconds)
    machines = []
    for at, of in enumerate(PANELS):
        machines = panel(parts, table, 172 + at * (ROW * len(NAMES) + 70), *of)
    for at, machine in enumerate(machines):
        parts.append(f'<circle cx="{LEFT + 130 * at}" cy="{height - 16}" r="4" fill="{COLOURS[at % len(COLOURS)]}"/>'
                     f'<text x="{LEFT + 10 + 130 * at}" y="{height - 12}" fill="#222">{machine}</text>')
    IMAGE.write_text("\n".join([*parts, "</svg>", ""]))
