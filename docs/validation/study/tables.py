"""Prints the tables of the study as Markdown, from its CSV files.

    python3 docs/validation/study/tables.py scenes
    python3 docs/validation/study/tables.py unit kitchen
"""

import argparse

from plots import FAIR, FOUR, SCENES, find, of_scene, rows

DESIGN = ["cycles_change", "cold_change", "dram_change", "joules_change"]


def table(head, lines):
    print("| " + " | ".join(head) + " |")
    print("|" + "---|" * len(head))
    for line in lines:
        print("| " + " | ".join(line) + " |")
    print()


def named(scene):
    return scene.replace("_", " ").replace("sponza", "Sponza")


def signed(share):
    shown = f"{100 * float(share):+.1f} %"
    return "+0.0 %" if shown == "-0.0 %" else shown


def unit(scene):
    """Designs of the unit, a table for each machine and policy."""
    found = of_scene(scene)
    for policy in ("Published", "Hybrid"):
        for machine in ("desktop", "small"):
            off = next(it for it in found if it["machine"] == machine and it["policy"] == "Off")
            print(f"{scene}, `{machine}`, `{policy}` (no culling: {int(off['cycles']):,} cycles, "
                  f"{int(off['dram_bytes']):,} DRAM bytes, {1000 * float(off['joules']):.2f} mJ in two frames):\n")
            table(["unit", "cycles, warm", "cycles, cold", "DRAM, warm", "energy, warm",
                   "unit busy", "memory", "intake", "starved"],
                  [[it["design"], *[signed(it[column]) for column in DESIGN],
                    *[f"{100 * float(it[f'unit_{cause}']):.0f} %" for cause in ("busy", "memory", "intake", "starved")]]
                   for it in found if (it["machine"], it["policy"]) == (machine, policy)])


def scenes():
    """Where it pays."""
    def lines():
        for scene in SCENES:
            for machine in ("desktop", "small"):
                for policy, design in (("Published", FAIR), ("Hybrid", FOUR)):
                    def of(column, of_design):
                        return signed(find(of_scene(scene), column, machine=machine, policy=policy, design=of_design))
                    yield [named(scene), f"`{machine}`", f"`{policy}`",
                           of("cycles_change", design), of("cold_change", design), of("cycles_change", "free words"),
                           of("dram_change", design), of("joules_change", design), of("joules_change", "free words")]
    table(["scene", "machine", "policy", "cycles, warm", "cycles, cold", "free words", "DRAM", "energy",
           "energy, free words"], lines())


def sizes():
    """Two sizes of the picture."""
    def lines():
        for scene in ("living_room", "staircase", "sponza"):
            for machine in ("desktop", "small"):
                def of(found, policy, design):
                    return signed(find(found, "cycles_change", machine=machine, policy=policy, design=design))
                pictures = [rows(f"designs_{scene}_256.csv"), rows(f"designs_{scene}.csv")]
                yield [named(scene), f"`{machine}`",
                       *[of(found, policy, design) for policy, design in
                         (("Published", FAIR), ("Published", "free words"), ("Hybrid", FOUR)) for found in pictures]]
    table(["scene", "machine", "`Published`, 256x256", "512x512", "free words, 256x256", "512x512",
           "`Hybrid`, 256x256", "512x512"], lines())


def words():
    """The words' cache, place, layout and frame end."""
    found = rows("words.csv")
    for scene in dict.fromkeys(it["scene"] for it in found):
        of_scene = [it for it in found if it["scene"] == scene and it["policy"] == "Published"]

        def lines():
            for it in of_scene:
                if it["machine"] == "desktop":
                    def small(column):
                        return signed(find(of_scene, column, machine="small", design=it["design"]))
                    yield [it["design"], signed(it["cycles_change"]), signed(it["cold_change"]), small("cycles_change"),
                           small("cold_change"), small("dram_change")]
        print(f"{scene}:\n")
        table(["words", "`desktop`, warm", "cold", "`small`, warm", "cold", "`small`, DRAM"], lines())


def lights():
    """One to 15 lights."""
    found = rows("lights.csv")
    def lines():
        for it in found:
            if it["policy"] == "Published" and it["design"] == "as it is":
                free = find(found, "cycles_change", scene=it["scene"], lights=it["lights"], machine=it["machine"],
                            policy="Published", design="free words")
                yield [named(it["scene"]), it["lights"], f"`{it['machine']}`", signed(it["cycles_change"]),
                       signed(it["cold_change"]), signed(free), signed(it["dram_change"]), signed(it["joules_change"])]
    table(["scene", "lights", "machine", "cycles, warm", "cold", "free words", "DRAM", "energy"], lines())


def resolution():
    """The size of the picture, and what a register takes of the accesses to the words' L1s."""
    found = rows("resolution.csv")
    def lines():
        for size in dict.fromkeys(it["resolution"] for it in found):
            for machine in ("desktop", "small"):
                def of(column, design, policy="Published"):
                    return find(found, column, resolution=size, machine=machine, policy=policy, design=design)

                def share(with_register, without):
                    return f"{100 * (1 - of('l1_accesses', with_register) / of('l1_accesses', without)):.0f} %"
                yield [f"{size}x{size}", f"`{machine}`", signed(of("cycles_change", "as it is")),
                       signed(of("cycles_change", "free words")), signed(of("cycles_change", "four units", "Hybrid")),
                       share("naive, register: 16", "naive"), share("register: 16", "as it is"),
                       signed(of("cycles_change", "naive")), signed(of("cycles_change", "naive, register: 16"))]
    table(["picture", "machine", "`Published`", "free words", "`Hybrid`", "register's share, naive", "fair",
           "naive", "naive, register"], lines())


def policies():
    """All policies."""
    found = rows("policies.csv")
    def lines():
        for policy in dict.fromkeys(it["policy"] for it in found if it["policy"] != "Off"):
            def of(column, machine, design):
                return signed(find(found, column, machine=machine, policy=policy, design=design))
            columns = [("cycles_change", "as it is"), *[(column, "four units") for column in (
                "cycles_change", "dram_change", "joules_change")]]
            yield [f"`{policy}`", *[of(column, machine, design) for machine in ("desktop", "small")
                                    for column, design in columns]]
    table(["policy", "`desktop`, one unit", "four units", "DRAM", "energy", "`small`, one unit", "four units", "DRAM",
           "energy"], lines())


def wrong():
    """Wrong decisions."""
    found = rows("wrong.csv")
    def lines():
        for it in found:
            if it["policy"] == "Published":
                hybrid = [other for other in found if other["policy"] == "Hybrid"
                          and all(other[name] == it[name] for name in ("scene", "resolution"))][0]
                dark, lit, rays = (int(it[name]) for name in ("false_dark", "false_lit", "compared_rays"))
                quiet = int(it["silent_updates"]) / int(it["policy_writes"])
                yield [named(it["scene"]), f"{it['resolution']}x{it['resolution']}", f"{rays:,}",
                       f"{dark:,}", f"{lit:,}", f"{1e6 * (dark + lit) / rays:,.0f}",
                       f"{float(it['psnr']):.1f} dB" if it["psnr"] else "same picture",
                       str(int(hybrid["false_dark"]) + int(hybrid["false_lit"])), f"{100 * quiet:.0f} %"]
    table(["scene", "picture", "decisions", "false dark", "false lit", "wrong a million", "worst picture",
           "`Hybrid`, wrong", "silent of all writes"], lines())


def balance():
    """How busy units are."""
    columns = ["dispatcher", "traversal", "intersection", "division", "dram"]
    table(["scene", "machine", *columns[:-1], "DRAM"],
          [[named(it["scene"]), f"`{it['machine']}`",
            *[f"{100 * float(it[column]):.1f} %" for column in columns]] for it in rows("balance.csv")])


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    tables = {it.__name__: it for it in (unit, scenes, sizes, words, lights, resolution, policies, wrong, balance)}
    parser.add_argument("table", choices=tables)
    parser.add_argument("scenes", nargs="*", help="of `unit`")
    chosen = parser.parse_args()
    tables[chosen.table](*chosen.scenes)


if __name__ == "__main__":
    main()
