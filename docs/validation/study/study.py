"""Replays for the pages of the study: words' cache and place, lights, the size of the picture, all policies.

    python3 docs/validation/study/study.py words docs/validation/study/words.csv

Each row is one command: `umbrasim replay STREAM --machine MACHINE` with a `--set` for each change. The first frame
warms up: figures are of the frames after it, and changes are against no culling.
"""

import argparse
import pathlib
import re
import subprocess
import tempfile
from concurrent.futures import ThreadPoolExecutor

from unit_designs import FAIR as UNITS
from unit_designs import replay, row, write

MACHINES = ["desktop", "small"]
FREE = {"place": "Free"}
FOUR = UNITS["four of those units"]
# The words' cache from four lines to 64 KiB, ways as far as they go.
CACHES = {f"{size} bytes": {"cache.bytes": str(size), "cache.ways": str(min(4, size // 64))}
          for size in (256, 1024, 4096, 16384, 65536)}
WORDS = CACHES | {"as it is": {}, "free words": FREE} | {
    f"{field}: {value}": {field: value} for field, values in {
        "place": ["Triangle", "L2"], "layout": ["Beside", "Tagged"], "frame_end": ["Sweep", "Epoch"]}.items()
    for value in values}
FAIR = {"as it is": {}, "free words": FREE}
# The unit as read from the poster, in the machines that ship with the fair one.
NAIVE = {"silent": "Sent", "decide": "Unit", "width": "1", "gather": "0", "latched": "Free"}
REGISTER = {"as it is": {}, "register: 16": {"register": "16"}, "naive": NAIVE,
            "naive, register: 16": NAIVE | {"register": "16"}, "free words": FREE}
# Policies that keep something, and the limit of all.
POLICIES = ["Off", "Published", "Symmetric", "LastOccluder", "OccluderGrid", "HashPredictor", "Certified", "Hybrid",
            "Oracle"]
# Places of lights, first those of the scenes' files.
LIGHTS = {
    "living_room": [(2.6, 2.6, -1.7), (0.9, 2.2, -0.5), (3.2, 1.4, -0.5), (4.6, 2.3, -2.9)] + [
        (x, 2.7, z) for z in (-3.0, -1.0) for x in (0.4, 1.3, 2.1, 3.0, 3.9, 4.7)],
    "staircase": [(x, 5.5, z) for z in (1.5, 0.3, 2.7) for x in (-1.51, -4.83, 1.8, -8.15, -11.46)],
}


def with_lights(scene, count, folder):
    """A study of a scene with other lights than its file has, and without what moves."""
    root = pathlib.Path.cwd()
    lights = ", ".join(f"(position: {place}, color: (0.1, 0.1, 0.1))" for place in LIGHTS[scene][:count])
    text = (root / f"configs/scenes/{scene}.ron").read_text()
    text = re.sub(r"lights: \[.*?\]", f"lights: [{lights}]", text, flags=re.DOTALL)
    text = re.sub(r"    moving: \[.*?\n    \],\n", "", text, flags=re.DOTALL)
    (folder / f"{count}.scene.ron").write_text(text.replace('"../../../shared', f'"{root}/../shared'))
    study = (root / f"configs/studies/{scene}.ron").read_text()
    study = study.replace('"../machines/', f'"{root}/configs/machines/')
    file = folder / f"{count}.ron"
    file.write_text(study.replace(f"../scenes/{scene}.ron", f"{count}.scene.ron"))
    return file


def experiments(part, scenes, folder):
    """Experiments of a part: the columns that tell them apart, the file, and the picture's size."""
    for scene in scenes:
        file = pathlib.Path(f"configs/studies/{scene}.ron")
        if part == "words":
            yield {"scene": scene}, file, 256
        elif part == "policies":
            yield {"scene": scene}, pathlib.Path(f"configs/experiments/policies_{scene}.ron"), 256
        elif part == "resolution":
            for size in (128, 256, 512):
                yield {"scene": scene}, file, size
        else:
            for count in (1, 4, 15):
                yield {"scene": scene, "lights": count}, with_lights(scene, count, folder), 256


def designs(part, policy):
    """Designs of a part for a policy."""
    if policy == "Off":
        return {"no culling": {}}
    if part == "policies":
        return {"as it is": {}, "four units": FOUR}
    if policy == "Hybrid":
        return {"words": {}, "lights": {"as it is": {}}, "resolution": {"four units": FOUR}}[part]
    return {"words": WORDS, "lights": FAIR, "resolution": REGISTER}[part]


def accesses(stats):
    """Accesses to the L1s of the shadow-cache units."""
    return sum(of_class["accesses"] for of_class in stats["caches"]["l1_shadow_cache"].values())


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("part", choices=["words", "lights", "resolution", "policies"])
    parser.add_argument("csv")
    parser.add_argument("--scenes", help="files of configs/studies without .ron")
    parser.add_argument("--program", default="target/release/umbrasim")
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--fidelity", default="Event")
    chosen = parser.parse_args()
    scenes = {"words": "kitchen,living_room", "lights": "living_room,staircase", "resolution": "kitchen",
              "policies": "kitchen"}
    rows = []
    with tempfile.TemporaryDirectory() as folder, ThreadPoolExecutor(chosen.threads) as pool:
        folder = pathlib.Path(folder)
        for value, file, size in experiments(chosen.part, (chosen.scenes or scenes[chosen.part]).split(","), folder):
            policies = [policy for policy in (POLICIES if chosen.part == "policies" else ("Off", "Published", "Hybrid"))
                        if designs(chosen.part, policy)]
            # Files of policies trace whole animations: three frames of them, as the studies have.
            frames = ["--frames", "320..323"] if chosen.part == "policies" else []
            streams = {policy: str(folder / f"{policy}.rays") for policy in policies}
            for policy, stream in streams.items():
                subprocess.run([chosen.program, "trace", str(file), "--policy", policy, "--warmup", "1", "--threads",
                                str(chosen.threads), "--resolution", f"{size}x{size}", "--quiet", "-o", stream,
                                *frames], check=True, stdout=subprocess.DEVNULL)
            plan = [(machine, policy, design, changes) for machine in MACHINES for policy in policies
                    for design, changes in designs(chosen.part, policy).items()]
            stats = list(pool.map(
                lambda it: replay(chosen.program, streams[it[1]], it[0], it[3], chosen.fidelity), plan))
            off = {it[0]: found for it, found in zip(plan, stats) if it[1] == "Off"}
            for it, found in zip(plan, stats):
                rows.append(value | {"resolution": size} | row(*it, found, off[it[0]]))
                if chosen.part == "resolution":
                    rows[-1]["l1_accesses"] = accesses(found)
            for stream in streams.values():
                pathlib.Path(stream).unlink()
            write(chosen.csv, rows)


if __name__ == "__main__":
    main()
