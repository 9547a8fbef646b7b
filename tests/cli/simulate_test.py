"""isochor simulate: recordings that an independent reader can follow, and every way of not making one."""
import base64
import json
import signal
import struct
import subprocess
import time
import unittest

from program import MESHES, PROGRAM, SLOWNESS, ProgramTest

DROP = {"name": "drop", "duration": 0.25, "frame_rate": 40, "gravity": [0, -10, 0],
        "bodies": [{"name": "cube", "type": "deformable",
                    "lattice": {"cells": [2, 3, 2], "cell_size": 0.25, "origin": [0, 1, 0]},
                    "density": 1000, "edge_stiffness": 1e4, "diagonal_stiffness": 1e3}]}


def scene(**changes):
    return json.dumps({**DROP, **changes})


def positions(body):
    data = base64.b64decode(body["positions"]["data"])
    letter = {"float32": "f", "float64": "d"}[body["positions"]["dtype"]]
    values = struct.unpack(f"<{len(data) // struct.calcsize(letter)}{letter}", data)
    return [values[i:i + 3] for i in range(0, len(values), 3)]


class Simulate(ProgramTest):
    def record(self, *arguments, **changes):
        out = self.folder / "run.ndjson"
        report = self.run_json("simulate", self.file("scene.json", scene(**changes)), "-o", out, *arguments)
        return report, [json.loads(line) for line in out.read_text().splitlines()]

    def test_a_free_fall_is_recorded(self):
        report, lines = self.record("--encoding", "f64")
        self.assertEqual([line["type"] for line in lines], ["hello"] + ["frame"] * 11 + ["end"])
        hello, frames = lines[0], lines[1:-1]
        self.assertEqual(len(hello["bodies"][0]["cells"]), 12)
        self.assertEqual(len(hello["bodies"][0]["tets"]), 60)
        self.assertEqual([frame["seq"] for frame in frames], list(range(11)))
        masses = struct.unpack("<36d", base64.b64decode(hello["bodies"][0]["masses"]["data"]))
        self.assertAlmostEqual(sum(masses), 1000 * 12 * 0.25**3, places=9)

        def height(frame):
            return sum(m * p[1] for m, p in zip(masses, positions(frame["bodies"][0]))) / sum(masses)

        # Symplectic Euler falls by g·t·(t + h)/2 for some substep h up to a frame.
        fallen = height(frames[0]) - height(frames[-1])
        self.assertGreaterEqual(fallen, 10 * 0.25**2 / 2 - 1e-9)
        self.assertLessEqual(fallen, 10 * 0.25 * (0.25 + 1 / 40) / 2 + 1e-9)
        self.assertLess(report["max_cell_volume_error"], 1e-6)
        self.assertEqual(report["frames"], 11)
        for key in ("total_volume_error", "max_penetration", "recoveries", "fallbacks", "ms_per_step"):
            self.assertIn(key, report)
        self.assertTrue(any(phase["included"] for phase in report["plan"]))

    def test_the_report_is_the_worst_of_the_recording(self):
        report, lines = self.record()
        frames = [line["metrics"] for line in lines if line["type"] == "frame"][1:]
        for key in ("total_volume_error", "max_cell_volume_error", "max_penetration"):
            self.assertEqual(report[key], max(frame[key] for frame in frames), key)
        self.assertEqual(report["recoveries"], sum(frame["recoveries"] for frame in frames))

    def test_stdin_stdout_and_encodings(self):
        text = scene()
        lines = self.run_program("simulate", "-", "-o", "-", "--encoding", "array", stdin=text.encode()).stdout
        first = json.loads(lines.splitlines()[1])
        self.assertEqual(first["bodies"][0]["positions"][0], [0, 1, 0])
        _, recorded = self.record("--encoding", "f32")
        self.assertEqual(recorded[1]["bodies"][0]["positions"]["dtype"], "float32")

    def test_the_same_bytes_for_any_number_of_threads(self):
        path, runs = self.file("scene.json", scene()), []
        for threads in (1, 3):
            out = self.folder / f"{threads}.ndjson"
            self.run_program("simulate", path, "-o", out, "--encoding", "f64", "--threads", threads)
            runs.append([json.loads(line).get("bodies") for line in out.read_text().splitlines()])
        self.assertEqual(runs[0], runs[1])

    def test_the_plan_alone(self):
        path = self.file("scene.json", scene(duration=None))
        plan = self.run_json("simulate", "--plan", path)["plan"]
        left_out = [phase for phase in plan if not phase["included"]]
        self.assertTrue(left_out and all(phase["reason"] and phase["bytes"] == 0 for phase in left_out))
        self.assertIn(left_out[0]["name"].encode(), self.run_program("simulate", "--plan", path).stdout)
        self.assert_files("scene.json")

    def test_animations(self):
        path = self.file("scene.json", scene())
        for suffix in ("mdd", "pc2", "glb"):
            self.run_program("simulate", path, "-o", self.folder / f"run.{suffix}")
        frames, points = struct.unpack(">ii", (self.folder / "run.mdd").read_bytes()[:8])
        self.assertEqual((frames, points), (11, 34))  # of the 36 particles two are inside
        self.assertEqual((self.folder / "run.glb").read_bytes()[:4], b"glTF")
        self.run_program("simulate", path, "-o", self.folder / "run.pvd")
        self.assertTrue((self.folder / "run_000010.vtu").exists())

    def test_an_animation_moves_the_original_mesh(self):
        body = {"name": "ball", "type": "deformable", "mesh": str(MESHES / "sphere.obj"),
                "meshing": {"voxels": 32, "cells": 6}, "position": [0, 2, 0]}
        path = self.file("scene.json", scene(bodies=[body], duration=0.1))
        self.run_program("simulate", path, "-o", self.folder / "run.mdd")
        frames, points = struct.unpack(">ii", (self.folder / "run.mdd").read_bytes()[:8])
        self.assertEqual((frames, points), (5, 642))


class SimulateFailures(ProgramTest):
    def test_a_body_that_is_a_part_of_its_mesh_is_said_to_be(self):
        self.file("sheet.obj", "v 0 0 0\nv 1 0 0\nv 1 0.3 1\nv 0 0.3 1\nv 0 .1 3\nv 1 .1 3\nf 1 2 3 4\nf 4 3 6 5\n")
        body = {"name": "sail", "type": "deformable", "mesh": "sheet.obj", "meshing": {"p_in_voxels": 1.5}}
        path, out = self.file("scene.json", json.dumps({"bodies": [body], "duration": 0.05})), self.folder / "out.ndjson"
        self.assertIn("the model of sail is incomplete: it covers only",
                      self.run_json("simulate", path, "-o", out)["warnings"][0])
        self.assertIn("warning: the model of sail is incomplete",
                      self.run_program("simulate", path, "-o", out).stderr.decode())
        body["meshing"]["p_in_voxels"] = 4
        path.write_text(json.dumps({"bodies": [body], "duration": 0.05}))
        self.assertEqual(self.run_json("simulate", path, "-o", out)["warnings"], [])

    def test_each_has_its_exit_code_and_leaves_nothing(self):
        path, out = self.file("scene.json", scene()), self.folder / "out.ndjson"
        self.run_json("simulate", path, expect=2)
        self.run_json("simulate", path, "-o", "-", expect=2)
        self.run_json("simulate", self.folder / "missing.json", "-o", out, expect=3)
        self.run_json("simulate", self.file("cut.json", scene()[:40]), "-o", out, expect=3)
        self.run_json("simulate", path, "-o", self.folder / "out.xyz", expect=4)
        self.run_json("simulate", path, "-o", self.folder / "out", expect=4)
        self.run_json("simulate", path, "-o", self.folder / "no" / "out.ndjson", expect=1)
        endless = self.file("endless.json", scene(duration=None))
        self.run_json("simulate", endless, "-o", out, expect=2)
        problem = self.run_json("simulate", self.file("typo.json", scene(gravty=[0, 0, 0], frame_rate=-1)), "-o", out,
                                expect=2)
        self.assertEqual({e["pointer"] for e in problem["errors"]}, {"/gravty", "/frame_rate"})
        self.assert_files("scene.json", "cut.json", "endless.json", "typo.json")
        self.run_program("simulate", endless, "--duration", "0.1", "-o", out)

    def test_a_device_has_no_extension_and_takes_lines(self):
        self.run_program("simulate", self.file("scene.json", scene()), "-o", "/dev/null")

    def test_ctrl_c_leaves_no_partial_recording(self):
        path = self.file("scene.json", scene(duration=100000))
        for suffix in ("ndjson", "mdd"):
            child = subprocess.Popen([PROGRAM, "simulate", str(path), "-o", str(self.folder / f"out.{suffix}")],
                                     stderr=subprocess.PIPE)
            child.stderr.readline()  # until it has begun
            time.sleep(0.5)
            child.send_signal(signal.SIGINT)
            self.assertIn(b"cancelled", child.communicate(timeout=120 * SLOWNESS)[1])
            self.assertEqual(child.returncode, 130)
            self.assert_files("scene.json")


if __name__ == "__main__":
    unittest.main()
