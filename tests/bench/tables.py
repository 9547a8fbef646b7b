#!/usr/bin/env python3
"""The tables of the README's performance section from one JSON of tests/bench/run.

tables.py FIGURES.json             prints them
tables.py FIGURES.json README.md   puts them between the README's two marks
tables.py --check FIGURES.json README.md   exits 1 when the README says something else"""
import json
import math
import pathlib
import sys

BEGIN, END = "<!-- figures: tests/bench/tables.py -->\n", "<!-- end of figures -->\n"
MILLISECONDS = {"ns": 1e-6, "us": 1e-3, "ms": 1.0, "s": 1e3}


class Figures:
    def __init__(self, path):
        self.json = json.loads(pathlib.Path(path).read_text())

    def of(self, program, start=""):
        """Measured entries (not the fitted ones) whose names start so."""
        return [entry for entry in self.json["programs"].get(program, [])
                if entry["name"].startswith(start) and "big_o" not in entry and "rms" not in entry]


def ms(entry):
    """CPU time, which other programs disturb little. A manual time is what the benchmark says."""
    manual = entry["name"].endswith("/manual_time")
    return entry["real_time" if manual else "cpu_time"] * MILLISECONDS[entry["time_unit"]]


def number(value):
    if value == 0:
        return "0"
    return f"{value:.1e}" if abs(value) < 1e-3 else f"{value:,.{max(0, 1 - math.floor(math.log10(abs(value))))}f}"


def arguments(entry):
    """{"n": 8, …} of "volume/solver:0/n:8/real_time"."""
    return {name: int(value) for name, value in (part.split(":") for part in entry["name"].split("/") if ":" in part)
            if value.lstrip("-").isdigit()}


def growth(entries, size):
    """The exponent p of time ~ size^p, by least squares on logarithms."""
    points = [(math.log(entry[size]), math.log(ms(entry))) for entry in entries]
    x0, y0 = (sum(p[i] for p in points) / len(points) for i in (0, 1))
    return sum((x - x0) * (y - y0) for x, y in points) / sum((x - x0)**2 for x, _ in points)


def table(title, head, rows):
    lines = [title, "", "| " + " | ".join(head) + " |", "|---" * len(head) + "|"]
    return "\n".join(lines + ["| " + " | ".join(row) + " |" for row in rows]) + "\n"


def grown(figures, program, rows, title):
    """One row a benchmark: its smallest and largest size, the time there, the growth over all."""
    lines = []
    for name, meaning, unit in rows:
        entries = figures.of(program, name + "/")
        if entries:
            first, last = entries[0], entries[-1]
            lines.append([meaning, f"{number(first['size'])} to {number(last['size'])} {unit}", number(ms(first)),
                          number(ms(last)), f"{growth(entries, 'size'):.2f}"])
    return table(title, ["", "sizes", "ms at the smallest", "ms at the largest", "grows as size to the"], lines)


STAGES = [("read_obj", "reading OBJ", "quads"), ("inspect", "inspection", "triangles"),
          ("distance_field/over_voxels", "distance field, 69,696 triangles", "voxels"),
          ("distance_field/over_triangles", "distance field, 128³", "triangles"), ("pseudo_volume", "pseudo volume", "voxels"),
          ("lattice/over_voxels", "lattice of 24 cells", "voxels"), ("lattice/over_cells", "lattice, 128³", "cells"),
          ("tetrahedra", "tetrahedra", "cells"), ("smoothing", "smoothing", "cells"),
          ("embedding/over_vertices", "embedding, 48 cells", "vertices"),
          ("embedding/over_cells", "embedding, 34,848 vertices", "cells"), ("quality", "quality", "cells"),
          ("pipeline", "all of it, cells = voxels / 4", "voxels")]
STEPS = [("springs/symplectic", "symplectic Euler", "cells"), ("springs/implicit", "implicit Euler", "cells"),
         ("springs/energy_momentum", "energy_momentum", "cells"),
         ("contact/cube_on_the_ground", "a cube at rest on the ground", "cells"),
         ("recovery/randomised", "cure of a start randomised by a whole cell", "cells"),
         ("rigid/stacks_of_five", "rigid boxes in stacks of five", "boxes"), ("rigid/chain", "chain of rigid links", "links")]


def distance(figures):
    rows = {}
    for entry in figures.of("distance_field_bench", "distance_field"):
        given = arguments(entry)
        if given["threads"] == 1:
            rows[f"{entry['label']}, {given['voxels']}³"] = entry
    return table("Distance field of about 69,700 triangles, beside CGAL's AABB tree with hints:",
                 ["", "ours", "CGAL", "times faster", "largest difference, voxels"],
                 [[name, f"{number(ms(row))} ms", f"{number(row['cgal_seconds'])} s", number(row["times_faster"]),
                   number(row["difference_voxels"])] for name, row in rows.items()])


MESHERS = {"isochor": "Isochor", "tetgen": "TetGen", "alpha_wrap_mesh_3": "CGAL alpha wrap + Mesh_3"}


def meshing(figures):
    rows = []
    for entry in figures.of("meshing_comparison_bench"):
        mesh, mesher = entry["name"].split("/")[:2]
        if entry.get("error_occurred"):
            rows.append([mesh, MESHERS[mesher], "fails: " + entry["error_message"], "", "", "", ""])
            continue
        error = f"{100 * entry['volume_error']:+.1f} %" if "volume_error" in entry else number(entry["volume"])
        rows.append([mesh, MESHERS[mesher], f"{number(ms(entry))} ms", number(entry["times_isochor"]),
                     f"{entry['tets']:,.0f}", f"{entry['min_dihedral_deg']:.1f}°", error])
    return table("To tets at the same edge length (volume: error where the input is closed, else itself):",
                 ["mesh", "", "time", "times ours", "tets", "smallest dihedral angle", "volume"], rows)


SCENES = {"by_hand": "written by hand, with nothing else", "plain": "by the scene's stepper", "gravity": "and gravity",
          "diagonals": "and diagonal springs", "damping": "and damping", "a_rigid_body_far_away": "and a rigid body far away",
          "one_with_a_mass_far_away": "and one with a mass", "self_contact": "and contact with itself"}
SOLVERS, SHAPES, STARTS = ("Newton", "the paper's scaling", "gradient"), ("box", "ball", "torus"), ("squashed to 80 %", "dropped")


def volume(figures):
    groups = {}
    for entry in figures.of("volume_solver_bench", "volume"):
        given = arguments(entry)
        if given["threads"] == 1:
            groups.setdefault((given["solver"], given["shape"], given["state"]), {})[given["n"]] = entry
    sizes = sorted({n for group in groups.values() for n in group})
    rows = [[f"{SOLVERS[solver]}, {SHAPES[shape]} {STARTS[start]}"]
            + [number(ms(group[n])) if n in group else "" for n in sizes] + [f"{growth(group.values(), 'cells'):.2f}"]
            for (solver, shape, start), group in groups.items()]
    return table("Volume projection to 1e-9 in the worst cell, ms:",
                 ["", *(f"{n}³" for n in sizes), "grows as cells to the"], rows)


def bullet(figures):
    rows = {}
    for entry in figures.of("bullet_bench"):
        given = arguments(entry)
        name = (f"Bullet, {given['passes']} iterations" if "passes" in given else f"Isochor to 1e-{given['digits']}")
        rows.setdefault(name, {})[given["n"]] = entry
    sizes = sorted({n for row in rows.values() for n in row})
    return table("A cube dropped on a sphere, 60 frames, and the largest cell error that was reached:",
                 ["", *(f"{n}³" for n in sizes)],
                 [[name, *(f"{number(ms(row[n]))} ms, {row[n]['max_cell_error']:.0e}" for n in sizes)]
                  for name, row in rows.items()])


def embedding(figures):
    entries = figures.of("embedding_bench")
    return "Moving embedded vertices with their body: " + ", ".join(
        f"{arguments_of_plain(entry):,} in {number(ms(entry))} ms" for entry in entries) + ".\n"


def arguments_of_plain(entry):
    return int(entry["name"].split("/")[1])


def instructions(figures):
    scenes = figures.json["programs"].get("instructions", {})
    rows = [[SCENES[scene], f"{entry['instructions'] / 1e6:.2f} million", f"{entry['over_by_hand']:.4f}"]
            for scene, entry in scenes.items()]
    return table("Instructions of a frame of eight substeps, a cube of 8³ cells swinging on its edges:",
                 ["", "", "over the step by hand"], rows) if rows else ""


def server(figures):
    load = figures.json["programs"].get("load", {})
    rows = []
    if many := load.get("many_viewers"):
        rows.append(["200 viewers of 4,913 vertices", f"{many['frames_per_second_median']:.0f} frames a second each, "
                     f"{many['encodes_per_frame']:.2f} encodings a frame"])
    if one := load.get("one_browser"):
        rows.append(["1 viewer of 19,683 vertices", f"{one['frames_per_second']:.0f} frames a second"])
    if few := load.get("few_viewers"):
        rows.append(["4 viewers at 30 frames a second", f"{few['step_rate_ratio']:.2f} of the step rate without them"])
    if slow := load.get("slow_heads"):
        rows.append(["`/health` under 300 slow heads", f"median {slow['median_ms']:.1f} ms, 99 % within {slow['p99_ms']:.0f} ms"])
    return table("The server, readers in Python on the same cores:", ["", ""], rows) if rows else ""


def section(figures):
    source = figures.json
    head = (f"{source['machine']}; {source['compiler']}; commit {source['commit']}; load average of the machine "
            f"{source['load_average']}. Measured by `tests/bench/run`, kept in tests/bench/figures.json. CPU time on one thread.\n")
    stages = grown(figures, "meshing_stages_bench", STAGES, "Meshing a torus of 69,696 triangles (unless its size varies):")
    parts = [head, stages, distance(figures), meshing(figures), volume(figures),
             grown(figures, "step_bench", STEPS, "A frame of 1/60 s:"), instructions(figures), bullet(figures), embedding(figures), server(figures)]
    return "\n".join(part for part in parts if part)


def replaced(readme, text):
    before, rest = readme.split(BEGIN)
    return before + BEGIN + text + rest[rest.index(END):]


def main(arguments):
    check = arguments[:1] == ["--check"]
    figures, *readme = arguments[check:]
    text = section(Figures(figures))
    if not readme:
        return print(text)
    path = pathlib.Path(readme[0])
    old = path.read_text()
    new = replaced(old, text)
    if check and new != old:
        sys.exit(f"{path} does not say what {figures} says: run tests/bench/tables.py {figures} {path}")
    if not check:
        path.write_text(new)


main(sys.argv[1:])
