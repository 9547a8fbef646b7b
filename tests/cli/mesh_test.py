"""isochor mesh, info and formats as a person or a script uses them."""
import json
import unittest

from program import MESHES, ProgramTest, read_msh2, volume

SPHERE = MESHES / "sphere.obj"
COARSE = ("--voxels", "48", "--cells", "10")


class Mesh(ProgramTest):
    def test_writes_what_it_reports(self):
        out = self.folder / "sphere.msh"
        report = self.run_json("mesh", SPHERE, "-o", out, *COARSE)
        nodes, tets = read_msh2(out.read_text())
        self.assertEqual((len(nodes), len(tets)), (report["vertices"], report["tets"]))
        self.assertEqual(report["tets"], 5 * report["cells"])
        self.assertAlmostEqual(volume(nodes, tets) / report["volume"], 1.0, places=12)
        self.assertAlmostEqual(report["volume"] / 0.5191, 1.0, delta=0.1)
        self.assertEqual((report["components"], report["inverted"]), (1, 0))
        self.assertTrue(report["complete"])
        self.assertEqual([stage["name"] for stage in report["stages"]],
                         ["distance_field", "pseudo_volume", "lattice", "tetrahedra", "smoothing", "embedding"])
        self.assertEqual(report["params"]["cells"], 10)
        self.assertEqual(report["outputs"], [str(out)])
        self.assertTrue(report["report"]["closed"])
        self.assert_files("sphere.msh")

    def test_stdin_and_stdout(self):
        out = self.folder / "sphere.msh"
        self.run_program("mesh", SPHERE, "-o", out, *COARSE)
        piped = self.run_program("mesh", "-", "--input-format", "obj", "-o", "-", *COARSE,
                                 stdin=SPHERE.read_bytes())
        self.assertEqual(piped.stdout.decode().split("$Comments")[0], out.read_text().split("$Comments")[0])
        self.run_json("mesh", "-", "-o", out, stdin=b"v 0 0 0", expect=2)
        self.run_json("mesh", SPHERE, "-o", "-", expect=2)

    def test_the_same_bytes_for_any_number_of_threads(self):
        for threads in (1, 4):
            self.run_program("mesh", SPHERE, "-o", self.folder / f"{threads}.msh", "--threads", threads, *COARSE)
        self.assertEqual((self.folder / "1.msh").read_bytes(), (self.folder / "4.msh").read_bytes())

    def test_several_formats_at_once(self):
        self.run_program("mesh", SPHERE, *COARSE, "-o", self.folder / "a.vtu", "-o", self.folder / "a.node",
                         "-o", self.folder / "a.msh")
        self.assert_files("a.vtu", "a.node", "a.ele", "a.face", "a.msh")
        self.run_program("mesh", "-o", self.folder / "b.msh", SPHERE, *COARSE, "--format", "msh4")
        self.assertIn('file="b.msh"', (self.folder / "b.xml").read_text())

    def test_parameters_from_a_file_and_from_options(self):
        params = self.file("params.json", json.dumps({"voxels": 48, "cells": 10, "preset": "thin"}))
        report = self.run_json("mesh", SPHERE, "--params", params, "--density", "0.3", "--no-fill-holes")
        used = report["params"]
        self.assertEqual((used["voxels"], used["cells"], used["density"]), (48, 10, 0.3))
        self.assertEqual((used["p_in_voxels"], used["fill_holes"]), (4.0, False))
        again = self.file("again.json", json.dumps(used))
        self.assertEqual(self.run_json("mesh", SPHERE, "--params", again)["params"], used)
        report = self.run_json("mesh", SPHERE, *COARSE, "--p-in", "0.9", "--p-subs", "0.85")
        self.assertEqual(report["params"]["p_in"], 0.9)
        self.assertAlmostEqual(report["thresholds"]["p_in"], 0.9)

    def test_a_budget_of_tets_asks_for_no_cells_that_the_voxels_allow(self):
        report = self.run_json("mesh", SPHERE, "--voxels", "32", "--budget-tets", "800")
        self.assertLessEqual(report["params"]["cells"], 16)
        self.assertIn("cells", self.run_json("mesh", SPHERE, "--voxels", "32", "--cells", "24", "--budget-tets", "800",
                                             expect=2)["detail"])

    def test_a_budget_of_tets(self):
        report = self.run_json("mesh", SPHERE, "--budget-tets", "3000")
        self.assertAlmostEqual(report["tets"] / 3000, 1.0, delta=0.3)

    def test_a_dry_run_only_counts(self):
        out = self.folder / "sphere.msh"
        document = self.run_json("mesh", SPHERE, "-o", out, "--dry-run", "--voxels", "512", "--cells", "256")
        self.assertGreater(document["estimate"]["bytes"], 512**3 * 4)
        self.assert_files()

    def test_gates(self):
        out = self.folder / "sphere.msh"
        self.run_program("mesh", SPHERE, "-o", out, *COARSE, "--require", "min-dihedral=20,coverage=0.95,inverted=0")
        out.unlink()
        problem = self.run_json("mesh", SPHERE, "-o", out, *COARSE, "--require", "min-dihedral=60,coverage=0.9",
                                expect=6)
        self.assertEqual([e["pointer"] for e in problem["errors"]], ["/require/min-dihedral"])
        self.run_json("mesh", SPHERE, "--require", "beauty=1", expect=2)
        self.assert_files()

    def test_the_distance_to_the_pseudo_volume_tells_caps_from_error(self):
        out = self.folder / "tree.msh"
        made = self.run_program("mesh", MESHES / "tree.obj", "-o", out, "--voxels", "64", "--cells", "24", "--json", "--require",
                                "diagonals-to-pseudo-volume=0.6")
        model = json.loads(made.stdout)
        self.assertGreater(model["max_diagonals_to_pseudo_volume"], model["mean_diagonals_to_pseudo_volume"])
        self.assertIn(f"within {model['max_diagonals_to_pseudo_volume']:.2f} cell diagonals of the pseudo volume "
                      f"(mean {model['mean_diagonals_to_pseudo_volume']:.2f})", made.stderr.decode())

    def test_what_was_found_and_what_was_not_written_is_said(self):
        said = self.run_program("mesh", SPHERE, "--budget-tets", "3000").stderr.decode()
        cells = self.run_json("mesh", SPHERE, "--budget-tets", "3000")["params"]["cells"]
        self.assertIn(f"closest to 3000 tets: --cells {cells}\n", said)
        self.assertIn("nothing is written", said)
        self.assertNotIn("nothing is written", self.run_program("mesh", SPHERE, "-o", "-", "--format", "obj").stderr.decode())

    def test_an_incomplete_model_is_written_and_no_success(self):
        sheet = self.file("sheet.obj", "v 0 0 0\nv 1 0 0\nv 1 0.3 1\nv 0 0.3 1\nv 0 .1 3\nv 1 .1 3\n"
                                       "f 1 2 3 4\nf 4 3 6 5\n" + cube_at(0.0))
        out = self.folder / "sheet.msh"
        done = self.run_program("mesh", sheet, "-o", out, "--crossing", "at_maximum", "--json", expect=5)
        report = json.loads(done.stdout)
        self.assertLess(report["coverage"], 0.95)
        self.assertFalse(report["complete"])
        self.assertIn("covers", report["warnings"][0])
        self.assertIn("warning: ", done.stderr.decode())
        self.assertIn("error: the model is incomplete: it covers only", done.stderr.decode())
        self.assertTrue(out.exists())

    def test_a_volume_far_from_that_of_the_input_is_no_success(self):
        # A closed box with walls much thinner than a voxel.
        hollow = self.file("hollow.obj", cube_at(0.0) + cube_at(0.0, 0.995, inward=True))
        report = json.loads(self.run_program("mesh", hollow, "--json", expect=5).stdout)
        self.assertTrue(report["report"]["closed"])
        self.assertGreater(report["volume"], 2.0 * report["report"]["volume"])
        self.assertFalse(report["complete"])
        self.assertIn("closed input encloses", " ".join(report["warnings"]))
        self.assertNotIn("is written", self.run_program("mesh", hollow, "--json", expect=5).stderr.decode())


def cube_at(x, size=1.0, inward=False):
    corners = [(x + size * ((b & 1) - 0.5), size * ((b >> 1 & 1) - 0.5), size * ((b >> 2 & 1) - 0.5) - 1.0)
               for b in range(8)]
    faces = ("0 4 6 2", "1 3 7 5", "0 1 5 4", "2 6 7 3", "0 2 3 1", "4 5 7 6")
    text = "".join("v {} {} {}\n".format(*corner) for corner in corners)
    step = -1 if inward else 1
    return text + "".join("f " + " ".join(str(int(i) - 8) for i in face.split()[::step]) + "\n" for face in faces)


class Failures(ProgramTest):
    """Each with its exit code, one JSON document, one sentence, and nothing left behind."""

    def tearDown(self):
        self.assertFalse([p for p in self.folder.iterdir() if p.suffix == ".tmp" or "out" in p.name])
        super().tearDown()

    def mesh(self, path, expect, *arguments):
        return self.run_json("mesh", path, "-o", self.folder / "out.msh", *arguments, expect=expect)

    def test_usage(self):
        self.mesh(SPHERE, 2, "--no-such-option")
        self.run_json("nonsense", expect=2)
        self.run_json(expect=2)
        problem = self.mesh(SPHERE, 2, "--voxels", "4000", "--density", "often", "--rays", "7")
        self.assertEqual({e["pointer"] for e in problem["errors"]}, {"/voxels", "/density", "/rays"})
        self.assertEqual(self.mesh(SPHERE, 2, "--cells", "100")["errors"][0]["max"], 64)
        self.mesh(SPHERE, 2, "--params", self.file("p.json", '{"voxels": 64, "colour": "red"}'))

    def test_cannot_read(self):
        cases = {"missing.obj": None, "nan.obj": "v 0 0 0\nv nan 0 0\nv 0 1 0\nf 1 2 3\n",
                 "index.obj": "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4\n", "cut.off": "OFF\n3 1 0\n0 0 0\n1 0 0\n"}
        for name, content in cases.items():
            path = self.folder / name if content is None else self.file(name, content)
            with self.subTest(name):
                self.assertIn(name, self.mesh(path, 3)["detail"])
        self.mesh(self.folder, 4)
        self.mesh(SPHERE, 3, "--params", self.file("p.json", '{"voxels": '))

    def test_unsupported(self):
        self.mesh(self.file("mesh.xyz", "0 0 0\n"), 4)
        self.run_json("mesh", SPHERE, "-o", self.folder / "out.xyz", expect=4)
        self.run_json("mesh", SPHERE, "-o", self.folder / "out.msh", "--format", "nonsense", expect=4)

    def test_empty(self):
        self.mesh(self.file("points.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\n"), 5)

    def test_out_of_budget(self):
        problem = self.mesh(SPHERE, 7, "--voxels", "512", "--max-memory", "0.05")
        self.assertIn("voxels", problem["hint"] + problem["detail"])

    def test_cannot_write(self):
        self.run_json("mesh", SPHERE, "-o", self.folder / "no" / "folder.msh", expect=1)
        self.run_json("mesh", SPHERE, *COARSE, "-o", "/dev/full", "--format", "msh2", expect=1)


class InfoAndFormats(ProgramTest):
    def test_info(self):
        report = self.run_json("info", MESHES / "tree.obj")["report"]
        self.assertEqual((report["triangles"], report["closed"]), (6064, False))
        self.assertGreater({d["name"]: d["count"] for d in report["defects"]}["open_edges"], 1000)
        self.assertIn(b"1280 triangles, 642 vertices, 1 component, closed", self.run_program("info", SPHERE).stdout)
        self.run_json("info", self.folder / "missing.obj", expect=3)

    def test_formats(self):
        document = self.run_json("formats")
        self.assertEqual(document["input"], ["obj", "stl", "ply", "off", "glb"])
        self.assertIn("MuJoCo flexcomp", {row["consumers"] for row in document["export"]})
        self.assertIn(b"SOFA", self.run_program("formats").stdout)


if __name__ == "__main__":
    unittest.main()
