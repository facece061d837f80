"""Replays for the pages of the study: the cache of the words, their place, the number of lights.

    python3 docs/validation/study/study.py words docs/validation/study/words.csv

Each row is one command: `umbrasim replay STREAM --machine MACHINE` with a `--set` for each change. The first frame
warms up: figures are of the frames after it, and changes are against no culling.
"""

import argparse
import pathlib
import subprocess
import tempfile
from concurrent.futures import ThreadPoolExecutor

from unit_designs import replay, row, write

MACHINES = ["desktop", "small"]
# The words' cache from four lines to 64 KiB, ways as far as they go.
CACHES = {f"{size} bytes": {"cache.bytes": str(size), "cache.ways": str(min(4, size // 64))}
          for size in (256, 1024, 4096, 16384, 65536)}
WORDS = CACHES | {"as it is": {}, "free words": {"place": "Free"}} | {
    f"{field}: {value}": {field: value} for field, values in {
        "place": ["Triangle", "L2"], "layout": ["Beside", "Tagged"], "frame_end": ["Epoch"]}.items()
    for value in values}
FAIR = {"as it is": {}, "free words": {"place": "Free"}}
# Places of lights in the living room, first those of configs/scenes/living_room.ron.
LIGHTS = [(2.6, 2.6, -1.7), (0.9, 2.2, -0.5), (3.2, 1.4, -0.5), (4.6, 2.3, -2.9)] + [
    (x, 2.7, z) for z in (-3.0, -1.0) for x in (0.4, 1.3, 2.1, 3.0, 3.9, 4.7)]
LIVING_ROOM = """Files(
    files: "{root}/../shared/scenes/living-room/living-room.obj",
    lights: [{lights}],
    camera: (fov: Vertical(36), path: Keys([
        (frame: 0, eye: (5.105, 0.731, -2.318), look: Along(-0.962, 0.074, 0.263)),
        (frame: 30, eye: (4.9, 0.85, -2.25), look: Along(-0.962, 0.05, 0.23)),
    ])),
    frame_count: 31,
)"""


def experiments(part, folder):
    """Experiments of a part: a column that tells them apart, its value, the file, and the picture's size."""
    root = pathlib.Path.cwd()
    if part == "words":
        yield "kitchen", root / "configs/studies/kitchen.ron", 256
    if part == "lights":
        study = (root / "configs/studies/living_room.ron").read_text()
        study = study.replace('"../machines/', f'"{root}/configs/machines/')
        for count in (1, 4, 15):
            lights = ", ".join(f"(position: {place}, color: (0.1, 0.1, 0.1))" for place in LIGHTS[:count])
            (folder / f"{count}.scene.ron").write_text(LIVING_ROOM.format(root=root, lights=lights))
            file = folder / f"{count}.ron"
            file.write_text(study.replace("../scenes/living_room.ron", f"{count}.scene.ron"))
            yield count, file, 256


def designs(part, policy):
    """Designs of a part for a policy."""
    if part == "words":
        return WORDS if policy == "Published" else {}
    return FAIR if policy == "Published" else {"as it is": {}}


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("part", choices=["words", "lights"])
    parser.add_argument("csv")
    parser.add_argument("--program", default="target/release/umbrasim")
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--fidelity", default="Event")
    chosen = parser.parse_args()
    rows = []
    with tempfile.TemporaryDirectory() as folder, ThreadPoolExecutor(chosen.threads) as pool:
        folder = pathlib.Path(folder)
        for value, file, size in experiments(chosen.part, folder):
            policies = ["Off"] + [policy for policy in ("Published", "Hybrid") if designs(chosen.part, policy)]
            streams = {policy: str(folder / f"{value}-{policy}.rays") for policy in policies}
            for policy, stream in streams.items():
                subprocess.run([chosen.program, "trace", str(file), "--policy", policy, "--warmup", "1", "--threads",
                                str(chosen.threads), "--resolution", f"{size}x{size}", "--quiet", "-o", stream],
                               check=True, stdout=subprocess.DEVNULL)
            plan = [(machine, policy, design, changes) for machine in MACHINES for policy in policies
                    for design, changes in ({"no culling": {}} if policy == "Off" else
                                            designs(chosen.part, policy)).items()]
            stats = list(pool.map(
                lambda it: replay(chosen.program, streams[it[1]], it[0], it[3], chosen.fidelity), plan))
            off = {it[0]: found for it, found in zip(plan, stats) if it[1] == "Off"}
            rows += [{chosen.part: value, "resolution": size} | row(*it[:2], it[2], it[3], found, off[it[0]])
                     for it, found in zip(plan, stats)]
    write(chosen.csv, rows)


if __name__ == "__main__":
    main()
