"""Faults: what is killed, full, out of memory or gone. Nothing may be lost, torn or leaked."""
import ctypes
import os
import pathlib
import random
import resource
import signal
import socket
import subprocess
import tempfile
import time
import unittest

from serving import PROGRAM, SLOWNESS, Serving, eventually, memory_bound

SAMPLES = pathlib.Path(__file__).resolve().parents[2] / "samples"
CUBE = SAMPLES / "meshes" / "cube.obj"


class Folder(unittest.TestCase):
    def setUp(self):
        self._folder = tempfile.TemporaryDirectory()
        self.folder = pathlib.Path(self._folder.name)

    def tearDown(self):
        self._folder.cleanup()

    def mesh(self, out, *arguments, **options):
        return subprocess.Popen([PROGRAM, "mesh", str(CUBE), "--voxels", "32", "--cells", "15", "-o", str(out),
                                 *arguments], stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, **options)


class Saves(Folder):
    def test_a_file_is_whole_or_the_old_one_wherever_the_program_is_killed(self):
        out = self.folder / "cube.msh"
        self.mesh(out).communicate()
        whole, chance, seen = out.read_bytes(), random.Random(1), []
        while len(seen) < 50 or all(seen):  # until a kill has met a save
            out.write_bytes(b"old")
            child = self.mesh(out)
            while child.poll() is None and not list(self.folder.glob(".*.tmp")):
                pass  # until it begins to write
            time.sleep(chance.uniform(0.0, 0.003))
            child.send_signal(signal.SIGKILL)
            child.communicate()
            content = out.read_bytes()
            self.assertIn(content, (b"old", whole))
            seen.append(content == whole)
            for beside in self.folder.glob(".*.tmp"):
                beside.unlink()
            self.assertEqual(os.listdir(self.folder), [out.name])

    def limited(self, most_bytes):
        return lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (most_bytes, most_bytes))

    def test_a_full_disk_leaves_the_old_file_and_says_so(self):
        for name, arguments in (("cube.msh", ()), ("cube.vtu", ()), ("cube.node", ("--format", "tetgen"))):
            with self.subTest(name):
                out = self.folder / name
                out.write_bytes(b"old")
                child = self.mesh(out, *arguments, preexec_fn=self.limited(4096))
                error = child.communicate()[1].decode()
                self.assertEqual(child.returncode, 1, error)
                self.assertIn("cannot write", error)
                self.assertEqual(out.read_bytes(), b"old")
                self.assertEqual(os.listdir(self.folder), [name])
                out.unlink()

    def test_a_recording_that_does_not_fit_leaves_nothing(self):
        child = subprocess.Popen([PROGRAM, "simulate", str(SAMPLES / "scenes" / "drop.json"), "-o",
                                  str(self.folder / "out.ndjson")], stderr=subprocess.PIPE,
                                 preexec_fn=self.limited(100000))
        error = child.communicate()[1].decode()
        self.assertEqual(child.returncode, 1, error)
        self.assertEqual(os.listdir(self.folder), [])

    def test_a_full_device_is_told(self):
        child = self.mesh("/dev/full", "--format", "msh2")
        error = child.communicate()[1].decode()
        self.assertEqual(child.returncode, 1, error)
        self.assertIn("free some space", error)


class Ends(unittest.TestCase):
    def test_a_signal_ends_it_with_live_streams(self):
        for number in (signal.SIGTERM, signal.SIGINT):
            with self.subTest(number), Serving() as server:
                frames = server.new_simulation(cells=4)["frames"]
                streams = [server.stream(frames) for _ in range(10)]
                stalled = [server.stream(frames, receive_buffer=4096) for _ in range(10)]
                for peer in streams:
                    self.assertIn(b"200 OK", peer.recv(65536))
                start = time.monotonic()
                server.process.send_signal(number)
                self.assertEqual(server.process.wait(10), 0)
                self.assertLess(time.monotonic() - start, 2.0)
                rest = b""
                while part := streams[0].recv(1 << 20):
                    rest += part
                self.assertIn(b'"type":"end"', rest, "a reader is told that it ends")
                for peer in streams + stalled:
                    peer.close()

    def test_a_signal_ends_it_at_once_while_it_works(self):
        with Serving() as server:
            mesh = server.send("POST", "/meshes?sample=tree")["id"]
            server.send("POST", "/models", {"mesh_id": mesh, "params": {"voxels": 400, "cells": 150}})
            server.send("POST", "/reports", {"kind": "stability"})
            server.send("POST", "/simulations?state=playing&wait_ms=0", {
                "duration": None, "bodies": [{"type": "deformable", "lattice": {
                    "cells": [48, 48, 48], "cell_size": 0.05, "origin": [0, 0, 0]}}]})
            time.sleep(0.3)
            start = time.monotonic()
            server.process.send_signal(signal.SIGTERM)
            self.assertEqual(server.process.wait(10), 0)
            self.assertLess(time.monotonic() - start, 2.0)

    def freeze(self, thread):
        """Stops one thread of a child, so that it looks at no flag; it ends with its program only."""
        seize, interrupt, any_thread = 0x4206, 0x4207, 0x40000000
        ptrace = ctypes.CDLL(None, use_errno=True).ptrace
        ptrace.argtypes = [ctypes.c_long, ctypes.c_long, ctypes.c_void_p, ctypes.c_void_p]
        for request in (seize, interrupt):
            if ptrace(request, thread, None, None):
                self.skipTest("no thread may be stopped here: " + os.strerror(ctypes.get_errno()))
        os.waitpid(thread, any_thread)
        return lambda: os.waitpid(thread, any_thread | os.WNOHANG)[0]

    def test_a_signal_ends_it_while_jobs_do_not_look_at_their_flags(self):
        server = Serving()
        server.wait_until_idle()
        before = server.thread_seconds()
        mesh = server.send("POST", "/meshes?sample=tree")["id"]
        server.send("POST", "/models", {"mesh_id": mesh, "params": {"voxels": 500, "cells": 150}})
        server.new_simulation(cells=16)

        def busy():
            return [int(thread) for thread, spent in server.thread_seconds().items()
                    if spent > before.get(thread, 0.0) + 0.05 and int(thread) != server.pid]
        ends = [self.freeze(thread) for thread in eventually(busy, lambda found: len(found) > 1, "threads that work")]
        start = time.monotonic()
        server.process.send_signal(signal.SIGTERM)
        try:
            for end in ends:
                eventually(end, bool, "a thread", 10.0)
            self.assertEqual(server.process.wait(10), 0)
            self.assertLess(time.monotonic() - start, 2.0)
        finally:
            server.process.kill()
            server.process.stdout.close()

    def test_a_second_instance_on_the_port_says_so(self):
        with Serving() as server:
            second = subprocess.run([PROGRAM, "serve", "--port", str(server.port)], capture_output=True,
                                    timeout=120 * SLOWNESS)
            self.assertEqual(second.returncode, 8)
            self.assertIn(b"in use", second.stderr)
            self.assertEqual(server.get("/health"), {"status": "ok"})


class Peers(unittest.TestCase):
    def setUp(self):
        self.server = Serving()
        self.server.wait_until_idle()

    def tearDown(self):
        self.assertEqual(self.server.stop(), 0)

    def test_the_table_of_descriptors_need_not_grow(self):
        # While it grew, with threads that share it, the kernel would halt the one that accepts for some 20 ms.
        _, most = resource.getrlimit(resource.RLIMIT_NOFILE)
        self.assertGreaterEqual(self.server.status_field("FDSize"), min(most, 16384))

    def test_connections_that_open_and_drop_leave_nothing(self):
        server = self.server
        descriptors, threads = server.descriptors(), server.threads()
        server.forget_peak()
        memory = server.resident_bytes()
        kinds = (b"", b"G", b"GET / HTTP/1.1\r\nHost:", server.head("GET", "/api/v1/health"))
        for i in range(2000):
            server.connect(kinds[i % 4]).close()
        eventually(server.descriptors, lambda n: n <= descriptors, "descriptors")
        self.assertEqual(server.threads(), threads)
        self.assertLess(server.peak_bytes() - memory, memory_bound(16 << 20))
        self.assertEqual(server.get("/health"), {"status": "ok"})

    def test_viewers_that_vanish_are_forgotten(self):
        server = self.server
        simulation = server.new_simulation(cells=4)
        path = "/simulations/" + simulation["id"]
        descriptors, threads = server.descriptors(), server.threads()
        streams = [server.stream(simulation["frames"]) for _ in range(100)]
        for peer in streams:
            self.assertIn(b"200 OK", peer.recv(65536))
        self.assertEqual(server.get(path)["viewers"], 100)
        for i, peer in enumerate(streams):
            if i % 2:  # a reset, as of a process that was killed
                peer.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, b"\1\0\0\0\0\0\0\0")
            peer.close()
        eventually(lambda: server.get(path)["viewers"], lambda n: n == 0, "viewers")
        eventually(server.descriptors, lambda n: n <= descriptors, "descriptors")
        self.assertEqual(server.threads(), threads)
        seq = server.get(path)["seq"]
        eventually(lambda: server.get(path)["seq"], lambda n: n > seq, "the simulation goes on")


    def test_a_sender_that_vanishes_stops_the_reading_of_its_mesh(self):
        server = self.server
        mesh = b"v 0 0 0\nv 1 0 0\nv 0 1 0\n" + b"f 1 2 3\n" * (1 << 21)
        head = server.head("POST", "/api/v1/meshes?format=obj", "Authorization: Bearer " + server.token,
                           f"Content-Length: {len(mesh)}")
        peer = server.connect(head + mesh)
        spent = server.cpu_seconds()
        eventually(server.cpu_seconds, lambda now: now > spent + 0.1, "it reads")
        peer.close()
        spent = last = server.cpu_seconds()
        time.sleep(0.1)
        while (now := server.cpu_seconds()) > last:
            last = now
            time.sleep(0.1)
        self.assertLess(last - spent, 1.0 * SLOWNESS)  # all of it takes four times as long
        self.assertEqual(server.get("/meshes")["meshes"][1:], [])

    def test_a_large_simulation_gives_its_memory_back(self):
        server = self.server
        memory, scene = server.resident_bytes(), {"bodies": [{"type": "deformable", "lattice": {
            "cells": [40, 40, 40], "cell_size": 0.01, "origin": [0, 0, 0]}}]}
        for wait_ms in (0, 10000):  # while it is prepared, and while it plays
            path = server.send("POST", f"/simulations?state=playing&wait_ms={wait_ms}", scene)["id"]
            eventually(server.resident_bytes, lambda now: now > memory + (64 << 20), "it grows")
            server.request("DELETE", "/simulations/" + path)
            eventually(server.resident_bytes, lambda now: now < memory + memory_bound(48 << 20), "memory")


class Memory(Folder):
    """Allocations fail: one of some hundreds to millions (fiu-run), or all that want more (a limit)."""

    def start_failing(self, pid, probability):
        subprocess.run(["fiu-ctrl", "-f", str(self.folder / "fiu"), "-c",
                        f"enable_random name=libc/mm/malloc,probability={probability}", str(pid)],
                       check=True, timeout=120)

    def launcher(self):
        return ["fiu-run", "-x", "-f", str(self.folder / "fiu")]

    def test_a_command_outlives_single_failures(self):
        out = self.folder / "out.msh"
        for i in range(12):
            child = subprocess.Popen([*self.launcher(), PROGRAM, "mesh", "-", "--input-format", "obj", "--voxels", "24",
                                      "--cells", "6", "-o", str(out)], stdin=subprocess.PIPE, stderr=subprocess.PIPE)
            eventually(lambda: list(self.folder.glob("fiu-*.in")), bool, "the control pipe")
            self.start_failing(child.pid, 10.0 ** -(2 + i % 4))  # it waits for its input
            error = child.communicate(CUBE.read_bytes(), timeout=120)[1]
            self.assertIn(child.returncode, (0, 7), error[-500:])
            self.assertEqual(out.exists(), child.returncode == 0)
            self.assertEqual(list(self.folder.glob(".*.tmp")), [])
            for file in self.folder.iterdir():
                file.unlink()

    def test_a_command_that_does_not_fit_says_so_and_leaves_nothing(self):
        ends = []
        for most_mib in (150, 200, 250, 300, 400, 600, 4000):
            out = self.folder / "out.msh"
            limit = (most_mib << 20, most_mib << 20)
            done = subprocess.run([PROGRAM, "mesh", str(CUBE), "--threads", "1", "--voxels", "256", "--cells", "16", "-o",
                                   str(out)], capture_output=True, timeout=120,
                                  preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_AS, limit))
            ends.append(done.returncode)
            self.assertIn(done.returncode, (0, 7), (most_mib, done.stderr[-500:]))
            self.assertEqual(os.listdir(self.folder), ["out.msh"] if done.returncode == 0 else [])
            if done.returncode:
                self.assertIn(b"memory", done.stderr)
        self.assertEqual(ends[-1], 0)
        self.assertIn(7, ends)

    def test_the_server_goes_on_while_allocations_fail(self):
        with Serving(launcher=self.launcher()) as server:
            server.wait_until_idle()
            self.start_failing(server.pid, 0.001)
            wanted = {("POST", "/meshes?sample=cube"): None, ("GET", "/openapi.json"): None, ("GET", "/jobs"): None,
                      ("POST", "/simulations?wait_ms=2000"): {"sample": "drop"}}
            answered = {wish: set() for wish in wanted}
            for _ in range(30):
                for (method, path), body in wanted.items():
                    try:
                        status, document = server.request(method, path, body)
                    except OSError:
                        continue  # not even memory for an answer: the connection ends
                    self.assertIn(status, (200, 201, 422, 429, 503), document)
                    answered[method, path].add(status)
            for wish, statuses in answered.items():
                self.assertTrue(statuses & {200, 201}, (wish, statuses))

    def test_the_server_is_as_before_once_there_is_memory_again(self):
        with Serving() as server:
            server.wait_until_idle()
            mesh = server.send("POST", "/meshes?sample=sphere")["id"]
            wish = {"mesh_id": mesh, "params": {"voxels": 256, "cells": 64}}
            limits = resource.prlimit(server.pid, resource.RLIMIT_AS)
            resource.prlimit(server.pid, resource.RLIMIT_AS, (server.status_field("VmSize") * 1024 + (8 << 20), limits[1]))
            status, job = server.request("POST", "/models", wish)
            if status < 300:
                job = server.finish(job)
                self.assertEqual((job["status"], job["problem"]["code"]), ("failed", "over_budget"))
            else:
                self.assertEqual(status, 503)
            self.assertEqual(server.get("/health"), {"status": "ok"})
            resource.prlimit(server.pid, resource.RLIMIT_AS, limits)
            self.assertEqual(server.finish(server.send("POST", "/models", wish))["status"], "done")


if __name__ == "__main__":
    unittest.main()
