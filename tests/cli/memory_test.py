"""The estimate of --dry-run against the largest resident set of the run itself."""
import math
import os
import struct
import subprocess
import unittest

from program import MESHES, PROGRAM, ProgramTest


def write_torus(path, segments):
    """2·segments² triangles, binary, a row at a time: the largest resident set of a child counts that of its parent."""
    def point(i, j):
        a, b = 2 * math.pi * i / segments, 2 * math.pi * j / segments
        return ((1 + 0.4 * math.cos(b)) * math.cos(a), (1 + 0.4 * math.cos(b)) * math.sin(a), 0.4 * math.sin(b))

    pack = struct.Struct("<12fH").pack
    with open(path, "wb") as file:
        file.write(b" " * 80 + struct.pack("<I", 2 * segments * segments))
        for i in range(segments):
            for j in range(segments):
                a, b, c, d = point(i, j), point(i + 1, j), point(i + 1, j + 1), point(i, j + 1)
                file.write(pack(0, 0, 0, *a, *b, *c, 0) + pack(0, 0, 0, *a, *c, *d, 0))


class Memory(ProgramTest):
    def peak(self, *arguments):
        child = subprocess.Popen([PROGRAM, "mesh", *map(str, arguments), "-q"], stdout=subprocess.DEVNULL)
        _, status, usage = os.wait4(child.pid, 0)
        child.returncode = os.waitstatus_to_exitcode(status)
        self.assertEqual(child.returncode, 0)
        return 1024 * usage.ru_maxrss

    def test_is_near_what_the_estimate_says(self):
        many = self.folder / "many.stl"
        write_torus(many, 240)
        cases = [(MESHES / "sphere.obj",), (MESHES / "torus.obj", "--voxels", 256),
                 (MESHES / "table.obj", "--voxels", 200, "--cells", 100), (MESHES / "tree.obj", "--preset", "thin"),
                 (many, "--voxels", 64, "--cells", 16), (many, "--voxels", 192, "--cells", 48)]
        for case in cases:
            with self.subTest(case):
                estimate, peak = self.run_json("mesh", *case, "--dry-run")["estimate"]["bytes"], self.peak(*case)
                self.assertTrue(0.9 <= estimate / peak <= 1.5, f"{estimate >> 20} MiB for {peak >> 20}")


if __name__ == "__main__":
    unittest.main()
