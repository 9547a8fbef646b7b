"""The example client, as its reader would start it."""
import pathlib
import re
import subprocess
import sys
import unittest
import urllib.request

from serving import SLOWNESS, Serving

SAMPLES = pathlib.Path(__file__).resolve().parents[2] / "samples"


class Client(unittest.TestCase):
    def run_client(self, server, token, mesh):
        return subprocess.run([sys.executable, SAMPLES / "client.py", server.url, token, mesh], capture_output=True,
                              text=True, timeout=120 * SLOWNESS)

    def test_a_mesh_becomes_a_body_whose_volume_stays(self):
        with Serving() as server:
            done = self.run_client(server, server.token, SAMPLES / "meshes" / "tree.obj")
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertRegex(done.stdout, r"tree\.obj: \d+ triangles")
            self.assertRegex(done.stdout, r"\d{3,} tets in \d+ ms, smallest dihedral [2-5]\d\.\d deg")
            errors = re.findall(r"volume error (\S+), of a cell (\S+),", done.stdout)
            self.assertEqual(len(errors), 4, "frames 0, 10, 20, 30")
            for total, cell in errors:
                self.assertLess(float(total), 1e-9)
                self.assertLess(float(cell), 1e-5)
            self.assertIn("finished at frame 30", done.stdout)

    def test_the_url_that_is_printed_is_answered(self):
        for host in ("127.0.0.1", "localhost", "127.0.0.2"):
            with self.subTest(host), Serving("--host", host) as server:
                self.assertIn(host, server.url)
                self.assertEqual(urllib.request.urlopen(server.url + "api/v1/health").status, 200)

    def test_it_passes_on_what_went_wrong(self):
        with Serving() as server:
            refused = self.run_client(server, "wrong", SAMPLES / "meshes" / "tree.obj")
            self.assertEqual(refused.returncode, 1)
            self.assertIn("token", refused.stderr)
            unreadable = self.run_client(server, server.token, SAMPLES / "index.json")
            self.assertEqual(unreadable.returncode, 1)
            self.assertTrue(unreadable.stderr.strip())


if __name__ == "__main__":
    unittest.main()
