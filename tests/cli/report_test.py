"""isochor report: its errors recomputed from the recordings by another program, interruption, resuming, budgets."""
import base64
import csv
import json
import os
import shutil
import signal
import subprocess
import unittest

import numpy

from program import MESHES, PROGRAM, ProgramTest


def cube(cells, **more):
    return {"name": "cube", "type": "deformable",
            "lattice": {"cells": [cells] * 3, "cell_size": 1 / cells, "origin": [-0.5, 0.52, -0.5]},
            "edge_stiffness": 3e3, "diagonal_stiffness": 1e3, **more}


SPINNING = {"name": "spinning", "duration": 0.2, "gravity": [0, 0, 0],
            "bodies": [cube(3, velocity=[1, 0.5, 0], angular_velocity=[1, 2, 3],
                            start={"affine": [[1.05, 0, 0], [0, 0.976, 0], [0, 0, 0.976]]})]}
DROPPED = {"name": "dropped", "duration": 0.3,
           "bodies": [cube(4, velocity=[0, -2, 0]),
                      {"name": "floor", "type": "rigid", "shape": {"plane": {"normal": [0, 1, 0], "offset": -9}},
                       "static": True},
                      {"name": "ball", "type": "rigid", "shape": {"sphere": {"radius": 0.5}}, "static": True},
                      {"name": "stone", "type": "rigid", "shape": {"sphere": {"radius": 0.1}}, "mass": 2,
                       "position": [3, 1, 0], "velocity": [0, 1, 0]},
                      {"name": "ring", "type": "rigid", "shape": {"mesh": str(MESHES / "torus.obj")}, "mass": 1,
                       "position": [-3, 1, 0], "angular_velocity": [1, 4, 2]}]}


def array(packed):
    return numpy.frombuffer(base64.b64decode(packed["data"]), dtype=packed["dtype"]).reshape(packed["shape"])


def sides_of(body):
    """The middles of the sides of its box; of a plane its position."""
    if "bounds" not in body:
        return numpy.zeros((1, 3))
    low, high = (numpy.array(body["bounds"][end]) for end in ("min", "max"))
    half = numpy.diag((high - low) / 2)
    return (low + high) / 2 + numpy.concatenate([half, -half])


def placed(pose, points):
    """Turned by the quaternion x, y, z, w, and moved."""
    axis, w = numpy.array(pose[3:6]), pose[6]
    return pose[:3] + points + 2 * numpy.cross(axis, numpy.cross(axis, points) + w * points)


class Recording:
    """What a report says of a run, from its frames alone."""

    def __init__(self, path):
        lines = [json.loads(line) for line in path.read_text().splitlines()]
        self.topology = lines[0]["bodies"]
        self.frames = [line for line in lines if line["type"] == "frame"]

    def metric(self, name):
        return numpy.array([frame["metrics"][name] for frame in self.frames])

    def positions(self, body):
        return numpy.array([array(frame["bodies"][body]["positions"]) for frame in self.frames])

    def rest_box(self):
        points = numpy.concatenate([array(b["rest_positions"]) for b in self.topology if b["type"] == "deformable"])
        return numpy.linalg.norm(points.max(axis=0) - points.min(axis=0))

    def mass(self):
        return sum(array(b["masses"]).sum() for b in self.topology if b["type"] == "deformable")

    def points(self, most=256):
        """Particles, and the middles of the sides of rigid bodies: frame, point, axis."""
        found = []
        for number, body in enumerate(self.topology):
            if body["type"] == "rigid":
                found.append(numpy.array([placed(frame["bodies"][number]["pose"], sides_of(body))
                                          for frame in self.frames]))
                continue
            positions = self.positions(number)
            found.append(positions[:, ::max(1, positions.shape[1] // most)])
        return numpy.concatenate(found, axis=1)

    def volumes(self):
        """Of each cell: at rest, and frame by frame."""
        body = self.topology[0]
        tets, cells = numpy.array(body["tets"]), numpy.array(body["cells"])

        def of(points):
            a, b, c, d = (points[..., tets[:, i], :] for i in range(4))
            return (numpy.einsum("...i,...i", numpy.cross(b - a, c - a), d - a) / 6)[..., cells].sum(axis=-1)

        return of(array(body["rest_positions"])), of(self.positions(0))


def recomputed(run, reference, duration):
    rest, volumes = run.volumes()
    distances = numpy.linalg.norm(run.points() - reference.points(), axis=2)[1:]
    momentum = run.mass() * run.rest_box() / duration

    def drift(name, scale):
        ours, theirs = run.metric(name), reference.metric(name)
        scale = max(scale, numpy.linalg.norm(theirs, axis=1).max())
        return numpy.linalg.norm(ours - theirs, axis=1)[1:].max() / scale

    def energy(recording):
        return recording.metric("kinetic_energy") + recording.metric("potential_energy")

    return {"max_cell_volume": numpy.abs(volumes / rest - 1)[1:].max(),
            "total_volume": numpy.abs(volumes.sum(axis=1) / rest.sum() - 1)[1:].max(),
            "trajectory_rms": numpy.sqrt((distances**2).mean()), "trajectory_max": distances.max(),
            "linear_momentum": drift("linear_momentum", momentum),
            "angular_momentum": drift("angular_momentum", momentum * run.rest_box()),
            "energy": numpy.abs(energy(run) - energy(reference))[1:].max()
            / max(numpy.ptp(energy(reference)), reference.metric("kinetic_energy").max())}


class ReportErrors(ProgramTest):
    def errors_of(self, scene, *axes):
        out = self.folder / "report"
        report = self.run_json("report", self.file("scene.json", json.dumps(scene)), "-o", out, "--repeats", "1",
                               "--refinement", "4", "--recordings", "--resolutions", "1", *axes)
        reference = Recording(out / "recordings" / "reference.ndjson")
        for point in report["points"]:
            run = Recording(out / "recordings" / (point["name"] + ".ndjson"))
            for name, value in recomputed(run, reference, scene["duration"]).items():
                with self.subTest(point=point["series"], error=name):
                    self.assertAlmostEqual(point["errors"][name], value, delta=1e-6 * value + 1e-12)
            yield point, run

    def test_of_a_spinning_cube(self):
        points = [point for point, _ in self.errors_of(SPINNING, "--solvers", "newton", "--substeps", "2,8", "--tolerances",
                                                       "1e-6", "--springs", "symplectic,implicit,energy_momentum")]
        self.assertEqual(len(points), 6)
        self.assertTrue(all(point["outcome"] == "converged" for point in points))
        by_springs = {point["settings"]["springs"]: point["errors"]["trajectory_rms"] for point in points[1::2]}
        self.assertLess(by_springs["symplectic"], by_springs["implicit"])

    def test_of_a_drop_on_a_ball(self):
        for point, run in self.errors_of(DROPPED, "--solvers", "newton,gradient", "--substeps", "4",
                                         "--tolerances", "1e-3,1e-6"):
            depth = 0.5 - numpy.linalg.norm(run.positions(0), axis=2)
            self.assertGreater(depth.max(), -0.01)  # it did touch
            self.assertAlmostEqual(point["errors"]["max_penetration"], max(0.0, depth[1:].max()), delta=1e-9)


class Report(ProgramTest):
    def interrupt(self, out, *arguments):
        """SIGINT after the third point has been written; once more where it came when all were."""
        for _ in range(10):
            shutil.rmtree(out, ignore_errors=True)
            child = subprocess.Popen([PROGRAM, "report", *map(str, arguments), "-o", str(out)], stderr=subprocess.PIPE)
            seen = []
            for line in child.stderr:
                seen.append(line.decode())
                if seen[-1].startswith("point 4 of"):
                    child.send_signal(signal.SIGINT)
            child.stderr.close()
            if child.wait() != 0:
                break
        self.assertEqual(child.returncode, 130, seen)
        self.assertTrue(any("--resume" in line for line in seen), seen)
        part = json.loads((out / "report.json").read_text())
        self.assertFalse(part["complete"])
        self.assertGreaterEqual(len(part["points"]), 3)
        return part

    def resumed(self, *arguments):
        out = self.folder / "report"
        part = self.interrupt(out, *arguments)
        whole = self.run_json("report", *arguments, "-o", out, "--resume")
        self.assertTrue(whole["complete"])
        self.assertGreater(len(whole["points"]), len(part["points"]))
        for point in part["points"]:
            self.assertIn(point, whole["points"])  # times and all: not run again
        for name in ("report.json", "report.csv", "report.html"):
            self.assertTrue((out / name).exists())
        with open(out / "report.csv", newline="") as file:
            self.assertEqual(len(list(csv.reader(file))), 1 + len(whole["points"]))
        return whole

    def test_of_narrower_axes_resumed_keeps_what_the_wider_ones_gave(self):
        out = self.folder / "report"
        common = ("--repeats", "1", "-o", out)
        scene = (self.file("scene.json", json.dumps(SPINNING)), "--solvers", "newton", "--tolerances", "1e-6", "--resolutions",
                 "1", "--refinement", "2", *common)
        mesh = (MESHES / "torus.obj", "--grid-voxels", "48", "--grid-smoothing", "0", "--grid-p-in-voxels", "1", *common)
        for arguments, axis, wide, narrow in ((scene, "--substeps", "2,4,8", "2,3"), (mesh, "--grid-cells", "8,12,64", "8,10")):
            shutil.rmtree(out, ignore_errors=True)
            whole = self.run_json("report", *arguments, axis, wide)
            resumed = self.run_json("report", *arguments, axis, narrow, "--resume")
            for point in whole["points"]:
                if point["outcome"] != "failed":
                    self.assertIn(point, resumed["points"])
            self.assertEqual(len(resumed["points"]), 1 + sum(p["outcome"] != "failed" for p in whole["points"]))

    def test_of_other_axes_resumed_keeps_the_recordings(self):
        """Of a run that was interrupted, whose points have other places in the whole one."""
        out = self.folder / "report"
        scene = (self.file("scene.json", json.dumps({**SPINNING, "bodies": [cube(6, angular_velocity=[1, 2, 3])]})), "--solvers",
                 "newton", "--tolerances", "1e-4,1e-8", "--resolutions", "1", "--refinement", "1", "--repeats", "1", "--recordings")
        part = self.interrupt(out, *scene, "--substeps", "1,2,4,8,16")
        names = {point["name"] + ".ndjson" for point in part["points"]} | {"reference.ndjson"}
        files = out / "recordings"
        self.assertEqual(set(os.listdir(files)), names)  # none of what was interrupted
        before = {name: (files / name).read_bytes() for name in names - {"reference.ndjson"}}
        whole = self.run_json("report", *scene, "--substeps", "3,16", "-o", out, "--resume")
        self.assertEqual(before, {name: (files / name).read_bytes() for name in before})
        for point in whole["points"]:
            run = Recording(files / (point["name"] + ".ndjson"))
            self.assertEqual(run.metric("substeps").max(), point["settings"]["substeps"])
            self.assertEqual(run.metric("max_cell_volume_error")[1:].max(), point["errors"]["max_cell_volume"])

    def test_of_finer_steps_does_not_replace_what_a_coarser_reference_gave(self):
        out = self.folder / "report"
        scene = (self.file("scene.json", json.dumps(SPINNING)), "--solvers", "newton", "--tolerances", "1e-6", "--resolutions",
                 "1", "--refinement", "2", "--repeats", "1", "-o", out)
        self.run_json("report", *scene, "--substeps", "2,4")
        before = (out / "report.json").read_bytes()
        refused = self.run_json("report", *scene, "--substeps", "2,32", "--resume", expect=2)
        self.assertIn("64 substeps", refused["detail"])
        self.assertEqual((out / "report.json").read_bytes(), before)

    def test_of_a_scene_is_interrupted_and_resumed(self):
        scene = self.file("scene.json", json.dumps({**SPINNING, "bodies": [cube(8)], "duration": 1}))
        self.resumed(scene, "--solvers", "newton", "--substeps", "1,2,4,8,16", "--tolerances", "1e-4,1e-8",
                     "--resolutions", "1", "--refinement", "2")

    def test_of_a_mesh_is_interrupted_and_resumed(self):
        whole = self.resumed(MESHES / "torus.obj", "--grid-voxels", "96,128", "--grid-cells", "12,24,64")
        self.assertEqual({point["outcome"] for point in whole["points"]}, {"converged", "failed"})
        for point in whole["points"]:
            if point["outcome"] == "failed":  # 64 cells of 96 voxels
                self.assertIn("half the voxels", point["reason"])
                self.assertEqual(set(point["ms_per_step"].values()), {None})
        with open(self.folder / "report" / "report.csv", newline="") as file:
            for row in csv.DictReader(file):
                self.assertEqual(row["ms"] == "", row["outcome"] == "failed")

    def test_another_scene_is_not_resumed(self):
        out, grid = self.folder / "report", ("--solvers", "newton", "--substeps", "1", "--repeats", "1", "--refinement", "2")
        self.run_json("report", self.file("scene.json", json.dumps(SPINNING)), "-o", out, *grid)
        other = self.file("scene.json", json.dumps({**SPINNING, "duration": 0.1}))
        refused = self.run_json("report", other, "-o", out, *grid, "--resume", expect=3)
        self.assertIn("another source", refused["detail"])

    def test_the_usual_grid_spans_four_axes_and_runs_nothing_twice(self):
        """A cube that symplectic Euler cannot step under 16 substeps: both integrators stand in the grid, each as itself."""
        stiff = cube(2, edge_stiffness=1e7)
        scene, out = self.file("scene.json", json.dumps({**SPINNING, "bodies": [stiff], "duration": 0.05})), self.folder / "report"
        report = self.run_json("report", scene, "-o", out, "--repeats", "1", "--refinement", "1", "--springs", "auto,implicit")
        settings = [point["settings"] for point in report["points"]]
        self.assertEqual(len({json.dumps(each) for each in settings}), len(settings))
        for axis, values in (("solver", {"newton", "gradient", "scaling"}), ("springs", {"symplectic", "implicit"}),
                             ("tolerance", {1e-2, 1e-4, 1e-6}), ("resolution", {0.5, 1})):
            self.assertEqual({each[axis] for each in settings}, values)
        finest = {each["substeps"] for each in settings if each["springs"] == "symplectic" and each["resolution"] == 1}
        self.assertEqual({n // min(finest) for n in finest}, {1, 2, 4})
        self.assertGreater(min(finest), 15)
        self.assertTrue({1, 2, 4, 8} <= {each["substeps"] for each in settings if each["springs"] == "implicit"})
        with open(out / "report.csv", newline="") as file:
            for row, point in zip(csv.DictReader(file), report["points"], strict=True):
                self.assertEqual(float(row["trajectory_rms"]), point["errors"]["trajectory_rms"])
                self.assertEqual(int(row["substeps"]), point["settings"]["substeps"])

    def test_what_does_not_fit_an_input_or_a_range_is_refused(self):
        scene, out = self.file("scene.json", json.dumps(SPINNING)), self.folder / "report"
        for words, said in ((["--grid-cells", "8"], "--grid-cells is for meshes"), (["--voxels", "64"], "--voxels is for meshes"),
                            (["--substeps", "-3"], "--substeps"), (["--tolerances", "0"], "--tolerances"),
                            (["--resolutions", "0"], "--resolutions"), (["--budget-ms", "-1"], "--budget-ms")):
            self.assertIn(said, self.run_json("report", scene, "-o", out, *words, expect=2)["detail"])
        self.assertIn("--substeps is for scenes",
                      self.run_json("report", MESHES / "torus.obj", "-o", out, "--substeps", "4", expect=2)["detail"])
        self.assertFalse(out.exists())
        self.assertIn("cannot make the folder", self.run_json("report", scene, "-o", scene / "report", expect=1)["detail"])

    def test_a_faulty_input_is_refused_before_another_is_run(self):
        scene, out = self.file("scene.json", json.dumps(SPINNING)), self.folder / "report"
        endless = self.file("endless.json", json.dumps({**SPINNING, "duration": None}))
        for faulty, exit_code in (("missing.json", 3), ("missing.obj", 3), (endless.name, 2)):
            self.run_json("report", scene, self.folder / faulty, "-o", out, expect=exit_code)
            self.assertFalse(out.exists())

    def test_a_budget_is_a_params_file(self):
        scene, out = self.file("scene.json", json.dumps(SPINNING)), self.folder / "report"
        self.run_program("report", scene, "-o", out, "--solvers", "newton", "--substeps", "1,3,9", "--springs", "implicit",
                         "--tolerances", "1e-6", "--resolutions", "1,2", "--repeats", "1", "--budget-ms", "10000")
        chosen = json.loads((out / "budget.json").read_text())
        best = min(json.loads((out / "report.json").read_text())["points"], key=lambda p: p["errors"]["trajectory_rms"])
        self.assertEqual(chosen["solver"]["substeps"], best["settings"]["substeps"])
        self.assertEqual(chosen["resolution"], best["settings"]["resolution"])
        run = self.run_json("simulate", scene, "-o", self.folder / "run.ndjson", "--params", out / "budget.json")
        self.assertEqual(run["max_substeps"], best["settings"]["substeps"])
        hello = json.loads((self.folder / "run.ndjson").read_text().splitlines()[0])
        self.assertEqual(len(hello["bodies"][0]["cells"]), 27 * chosen["resolution"]**3)
        refused = self.run_json("report", scene, "-o", out, "--solvers", "newton", "--substeps", "1", "--repeats", "1",
                                "--tolerances", "1e-6", "--budget-ms", "1e-9", expect=7)
        self.assertIn("1e-09 ms", refused["detail"])

    def test_faulty_params_are_named(self):
        scene = self.file("scene.json", json.dumps(SPINNING))
        faults = self.run_json("simulate", scene, "-o", self.folder / "run.ndjson", "--params", self.file(
            "params.json", '{"solver":{"volume":"magic","substeps":0},"resolutions":2}'), expect=2)["errors"]
        self.assertEqual({fault["pointer"] for fault in faults}, {"/solver/volume", "/solver/substeps"})

    def test_a_budget_for_meshing_is_a_params_file_too(self):
        out = self.folder / "report"
        self.run_program("report", MESHES / "torus.obj", "-o", out, "--grid-voxels", "48", "--grid-cells", "8,16", "--repeats",
                         "1", "--budget-ms", "100000")
        model = self.run_json("mesh", MESHES / "torus.obj", "-o", self.folder / "t.msh", "--params", out / "budget.json")
        points = json.loads((out / "report.json").read_text())["points"]
        best = min(points, key=lambda p: p["errors"]["distance"])
        self.assertEqual(best["errors"]["distance"],
                         max(best["errors"]["boundary_to_input"], best["errors"]["input_to_boundary"]))
        self.assertEqual(model["tets"], best["tets"])
        for distance in ("max_diagonals_to_pseudo_volume", "mean_diagonals_to_pseudo_volume"):
            self.assertEqual(model[distance], best[distance])
            self.assertIn(distance, (out / "report.csv").read_text().splitlines()[0])

    def test_the_lattice_comes_closest_to_a_number_of_tets(self):
        def tets(resolution):
            model = self.run_json("mesh", MESHES / "sphere.obj", "-o", self.folder / "t.msh", "--voxels", "64", *resolution)
            return model["tets"]

        counts = [tets(["--cells", cells]) for cells in range(4, 33, 2)]
        for wanted in (500, 3000, 10000, 10**7):
            self.assertEqual(abs(tets(["--budget-tets", wanted]) - wanted), min(abs(n - wanted) for n in counts))
        far = self.run_program("mesh", MESHES / "sphere.obj", "-o", self.folder / "t.msh", "--voxels", "64", "--budget-tets",
                               "10000000").stderr.decode()
        self.assertIn("the closest to 10000000 that a lattice has: more voxels allow more cells", far)


if __name__ == "__main__":
    unittest.main()
