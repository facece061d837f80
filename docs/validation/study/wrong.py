"""Counts wrong decisions of the study's policies against the reference renderer, and writes a CSV file.

    python3 docs/validation/study/wrong.py docs/validation/study/wrong.csv

Each row is a policy of one command: `umbrasim run configs/studies/SCENE.ron --set validate=All --set machines=[]`.
"""

import argparse
import json
import subprocess
import tempfile

from unit_designs import write

# Scenes and the widths of their square pictures.
PICTURES = [("kitchen", size) for size in (128, 256, 512)] + [
    (scene, 256) for scene in ("robot", "living_room", "staircase", "sponza", "gas_station")]


def pixels(frames):
    """The lowest ratio of signal to noise of the frames that differ from the reference picture, in dB."""
    return min((frame["psnr"]["decibel"] for frame in frames if frame["psnr"] != "identical"), default="")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("csv")
    parser.add_argument("--program", default="target/release/umbrasim")
    parser.add_argument("--threads", default="2")
    chosen = parser.parse_args()
    rows = []
    for scene, size in PICTURES:
        with tempfile.TemporaryDirectory() as folder:
            found = subprocess.run([chosen.program, "run", f"configs/studies/{scene}.ron", "--resolution",
                                    f"{size}x{size}", "--set", "machines=[]", "--set", "validate=All", "--threads",
                                    chosen.threads, "--quiet", "--json", "--out", f"{folder}/report"],
                                   check=True, stdout=subprocess.PIPE).stdout
        for policy, found in json.loads(found)["policies"].items():
            rows.append({"scene": scene, "resolution": size, "policy": policy, "pixels": found["primary_rays"]} | {
                count: found[count] for count in (
                    "shadow_rays", "shadow_rays_skipped", "shadow_rays_dynamic_only", "compared_rays", "false_dark",
                    "false_lit", "numeric_differences", "policy_writes", "repeated_updates", "silent_updates")} | {
                "traversal_saved": found["traversal_saved"]["total"], "psnr": pixels(found["frames"])})
        write(chosen.csv, rows)


if __name__ == "__main__":
    main()
