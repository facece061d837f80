"""Bar and line charts as SVG, with the Python standard library alone."""

from xml.sax.saxutils import escape

# Okabe and Ito's colours, which colour-blind people can tell apart.
COLOURS = ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#56b4e9", "#e69f00"]
WIDTH, SIZE = 720, 13


def text(x, y, words, anchor="start", weight="normal", colour="#222"):
    return (f'<text x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}" font-weight="{weight}" fill="{colour}">'
            f"{escape(words)}</text>")


def line(x1, y1, x2, y2, colour="#ccc", width=1, dash=""):
    dashed = f' stroke-dasharray="{dash}"' if dash else ""
    return (f'<line x1="{x1:.1f}" y1="{y1:.1f}" x2="{x2:.1f}" y2="{y2:.1f}" stroke="{colour}" '
            f'stroke-width="{width}"{dashed}/>')


def percent(share):
    shown = f"{100 * share:+.1f}"
    return f"{'0.0' if shown in ('-0.0', '+0.0') else shown} %".replace("-", "−")


def ticks(low, high):
    """Round steps over a range of shares."""
    step = next(step for step in (0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1, 2) if (high - low) / step <= 8)
    first = int(low / step) - (low < 0 and low % step != 0)
    found = []
    while first * step < high + 1e-9:
        found.append(first * step)
        first += 1
    return found if found[-1] >= high - 1e-9 else [*found, found[-1] + step]


def picture(height, title, parts):
    head = (f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {height}" width="{WIDTH}" '
            f'height="{height}" font-family="Helvetica, Arial, sans-serif" font-size="{SIZE}" role="img">'
            f"<title>{escape(title)}</title>")
    body = [f'<rect width="{WIDTH}" height="{height}" fill="#fff"/>', text(16, 24, title, weight="bold"), *parts]
    return "\n".join([head, *body, "</svg>\n"])


def legend(names, y):
    x, parts = 16, []
    for index, name in enumerate(names):
        parts += [f'<rect x="{x}" y="{y - 10}" width="12" height="12" fill="{COLOURS[index]}"/>', text(x + 17, y, name)]
        x += 30 + 7.2 * len(name)
    return parts


def bars(title, axis, groups, series, left=330):
    """A row a group with a bar a series: `groups` are pairs of a name and values. A value of None has no bar."""
    several = len(series) > 1
    thick = 13 if several else 17
    row = thick * len(series) + 9
    top = 62 if several else 42
    height = top + row * len(groups) + 44
    values = [value for _, found in groups for value in found if value is not None]
    marks = ticks(min(0, *values), max(0, *values))
    low, high = marks[0], marks[-1]
    span = WIDTH - left - 122

    def place(value):
        return left + 56 + span * (value - low) / (high - low)

    parts = legend(series, 46) if several else []
    bottom = top + row * len(groups)
    for mark in marks:
        parts.append(line(place(mark), top - 4, place(mark), bottom, "#777" if abs(mark) < 1e-9 else "#ddd"))
        parts.append(text(place(mark), bottom + 16, f"{100 * mark:g}".replace("-", "−"), "middle", colour="#555"))
    parts.append(text(place((low + high) / 2), bottom + 35, axis, "middle", colour="#555"))
    for index, (name, found) in enumerate(groups):
        y = top + row * index
        parts.append(text(left - 4, y + row / 2 + 1, name, "end"))
        for at, value in enumerate(found):
            if value is None:
                continue
            from_, to = sorted((place(0), place(value)))
            parts.append(f'<rect x="{from_:.1f}" y="{y + thick * at}" width="{max(to - from_, 0.5):.1f}" '
                         f'height="{thick - 2}" fill="{COLOURS[at]}"/>')
            end = (place(value) + 4, "start") if value >= 0 else (place(value) - 4, "end")
            parts.append(text(end[0], y + thick * at + thick - 3, percent(value), end[1], colour="#444"))
    return picture(height, title, parts)


def lines(title, across, axis, labels, series, height=340):
    """Lines over places of even distance: `series` are pairs of a name and values."""
    left, right, top = 64, 24, 70
    values = [value for _, found in series for value in found if value is not None]
    marks = ticks(min(0, *values), max(0, *values))
    low, high = marks[0], marks[-1]
    bottom = height - 52

    def place(index, value):
        return (left + 16 + (WIDTH - left - right - 32) * index / (len(labels) - 1),
                bottom - (bottom - top) * (value - low) / (high - low))

    parts = legend([name for name, _ in series], 48)
    for mark in marks:
        y = place(0, mark)[1]
        parts.append(line(left, y, WIDTH - right, y, "#777" if abs(mark) < 1e-9 else "#ddd"))
        parts.append(text(left - 6, y + 4, f"{100 * mark:g}".replace("-", "−"), "end", colour="#555"))
    for index, label in enumerate(labels):
        parts.append(text(place(index, low)[0], bottom + 18, label, "middle", colour="#555"))
    parts.append(text((left + WIDTH - right) / 2, bottom + 40, across, "middle", colour="#555"))
    parts.append(f'<text transform="translate(18 {(top + bottom) / 2:.1f}) rotate(-90)" text-anchor="middle" '
                 f'fill="#555">{escape(axis)}</text>')
    for at, (_, found) in enumerate(series):
        points = [place(index, value) for index, value in enumerate(found) if value is not None]
        joined = " ".join(f"{x:.1f},{y:.1f}" for x, y in points)
        parts.append(f'<polyline points="{joined}" fill="none" stroke="{COLOURS[at]}" stroke-width="2"/>')
        parts += [f'<circle cx="{x:.1f}" cy="{y:.1f}" r="3.5" fill="{COLOURS[at]}"/>' for x, y in points]
    return picture(height, title, parts)
