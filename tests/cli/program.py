"""Running the real program from tests: its path is in the environment variable ISOCHOR."""
import json
import os
import pathlib
import subprocess
import tempfile
import unittest

PROGRAM = os.environ["ISOCHOR"]
SLOWNESS = float(os.environ.get("ISOCHOR_SLOWNESS", "1"))  # how many times slower than a release build
SOURCE = pathlib.Path(__file__).resolve().parents[2]
MESHES = SOURCE / "samples" / "meshes"
SCENES = SOURCE / "samples" / "scenes"


class ProgramTest(unittest.TestCase):
    """A folder of its own for each test; nothing may be left in it that the test did not ask for."""

    def setUp(self):
        self._folder = tempfile.TemporaryDirectory()
        self.folder = pathlib.Path(self._folder.name)

    def tearDown(self):
        self._folder.cleanup()

    def run_program(self, *arguments, expect=0, stdin=None):
        done = subprocess.run([PROGRAM, *map(str, arguments)], input=stdin, capture_output=True, timeout=280 * SLOWNESS)
        self.assertEqual(done.returncode, expect, done.stderr.decode())
        return done

    def run_json(self, *arguments, expect=0, stdin=None):
        """stdout is exactly one JSON document, also when the command fails."""
        done = self.run_program(*arguments, "--json", expect=expect, stdin=stdin)
        document = json.loads(done.stdout)
        if expect:
            self.assertTrue(document["detail"] and document["code"] and document["status"])
            self.assertTrue(done.stderr.decode().startswith("error: ") or "\nerror: " in done.stderr.decode())
        return document

    def file(self, name, content):
        path = self.folder / name
        path.write_text(content)
        return path

    def assert_files(self, *names):
        self.assertEqual(sorted(os.listdir(self.folder)), sorted(names))


def read_msh2(text):
    """Nodes and tets of a Gmsh 2.2 file."""
    lines = text.split("\n")
    first = lines.index("$Nodes") + 2
    nodes = [tuple(map(float, line.split()[1:])) for line in lines[first:lines.index("$EndNodes")]]
    first = lines.index("$Elements") + 2
    tets = [[int(tag) - 1 for tag in line.split()[-4:]] for line in lines[first:lines.index("$EndElements")]]
    return nodes, tets


def volume(nodes, tets):
    total = 0.0
    for tet in tets:
        a, b, c, d = (nodes[i] for i in tet)
        u, v, w = ([q[i] - a[i] for i in range(3)] for q in (b, c, d))
        total += (u[0] * (v[1] * w[2] - v[2] * w[1]) + u[1] * (v[2] * w[0] - v[0] * w[2])
                  + u[2] * (v[0] * w[1] - v[1] * w[0])) / 6
    return total
