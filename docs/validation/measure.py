"""What the scripts of this folder measure of commands."""

import json
import os
import subprocess
import tempfile

FIGURES = ["cycles", "l2_bytes", "dram_bytes"]


def seconds(command, out=subprocess.DEVNULL):
    """Processor seconds that a command takes, which writes to `out`."""
    child = subprocess.Popen(command, stdout=out)
    _, status, used = os.wait4(child.pid, 0)
    if status != 0:
        raise SystemExit(f"{' '.join(map(str, command))} ended with {status}")
    return used.ru_utime + used.ru_stime


def measured(command):
    """The JSON that a command prints, and the processor seconds that it takes."""
    with tempfile.TemporaryFile("w+") as out:
        took = seconds(command, out)
        out.seek(0)
        return json.load(out), took


def half_widths(stats):
    """Half the widths of the 95 % intervals of what a sample told, as shares of the figures; nothing of other runs."""
    return stats["accuracy"]["estimated"] if "estimated" in stats["accuracy"] else {}


def figures(stats):
    """Cycles, and bytes of L2 and DRAM, of a replay's statistics."""
    moved = [sum(sum(classes.values()) for level, classes in stats["bytes"].items() if level.startswith(name))
             for name in ("l2", "dram")]
    return dict(zip(FIGURES, [stats["cycles"], *moved]))
