"""What a hostile peer may cost: of the real server's memory less than 16 MB and of its processor less than a second,
for each threat, while it goes on answering others."""
import contextlib
import gzip
import socket
import threading
import unittest

from serving import SLOWNESS, Serving, eventually, memory_bound

MEMORY = 16 << 20
CPU_SECONDS = 1.0 * SLOWNESS


def flood(peer, part, most_bytes):
    """Sends until the peer has enough; the bytes that it took."""
    sent = 0
    peer.settimeout(1.0)
    with contextlib.suppress(OSError):
        while sent < most_bytes:
            sent += peer.send(part)
    return sent


class Threats(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.server = Serving()
        cls.server.wait_until_idle()
        mesh = cls.server.send("POST", "/meshes?sample=tree")["id"]
        model = cls.server.finish(cls.server.send("POST", "/models", {"mesh_id": mesh}))["result"]["model_id"]
        cls.model = "/api/v1/models/" + model
        for path in ("/voxels", "/tets", "/exports/msh2"):  # what an allocator keeps of honest use
            cls.server.request("GET", "/models/" + model + path)

    @classmethod
    def tearDownClass(cls):
        assert cls.server.stop() == 0

    @contextlib.contextmanager
    def bounded(self):
        """Around an attack: what it costs, and that others are answered on the way."""
        server, answered, over = self.server, [], threading.Event()

        def ask():
            while not over.is_set():
                answered.append(server.request("GET", "/health")[0])
                over.wait(0.02)

        other = threading.Thread(target=ask)
        server.forget_peak()
        memory, cpu = server.resident_bytes(), server.cpu_seconds()
        other.start()
        try:
            yield
        finally:
            over.set()
            other.join()
        self.assertEqual(set(answered), {200})
        self.assertLess(server.peak_bytes() - memory, memory_bound(MEMORY))
        self.assertLess(server.cpu_seconds() - cpu, CPU_SECONDS)

    def head(self, method, path, *fields):
        return self.server.head(method, path, *fields)

    def token(self):
        return "Authorization: Bearer " + self.server.token

    def test_an_endless_request_line(self):
        with self.bounded(), self.server.connect(b"GET /") as peer:
            self.assertLess(flood(peer, b"a" * 65536, 512 << 20), MEMORY)

    def test_endless_headers(self):
        with self.bounded(), self.server.connect(b"GET / HTTP/1.1\r\n") as peer:
            self.assertLess(flood(peer, b"X-A: b\r\n" * 8000, 512 << 20), MEMORY)

    def test_long_heads_that_are_refused(self):
        for fields in (["Range: bytes=0-"], ["Host: evil.example"], []):
            part = self.head("GET", "/nothing", "X-Long: " + "a" * 15000, *fields)
            with self.subTest(fields), self.bounded():
                peers = [self.server.connect(part) for _ in range(1500)]
                for peer in peers:
                    self.assertIn(peer.recv(12)[9:], (b"416", b"400", b"404"))
                    peer.close()

    def test_a_chunked_body(self):
        with self.bounded(), self.server.connect(self.head(
                "POST", "/api/v1/meshes?name=a.obj", self.token(), "Transfer-Encoding: chunked")) as peer:
            self.assertLess(flood(peer, b"10000\r\n" + b"v" * 65536 + b"\r\n", 512 << 20), MEMORY)

    def test_a_body_of_undeclared_length(self):
        with self.bounded(), self.server.connect(
                self.head("POST", "/api/v1/meshes?name=a.obj", self.token())) as peer:
            self.assertLess(flood(peer, b"v" * 65536, 512 << 20), MEMORY)

    def test_a_body_longer_than_declared(self):
        with self.bounded(), self.server.connect(
                self.head("POST", "/api/v1/meshes?name=a.obj", self.token(), "Content-Length: 10")) as peer:
            self.assertLess(flood(peer, b"v" * 65536, 512 << 20), MEMORY)

    def test_a_gzip_bomb(self):
        bomb = gzip.compress(b"0" * (64 << 20))
        with self.bounded():
            status = self.server.exchange(
                self.head("POST", "/api/v1/models", self.token(), "Content-Type: application/json",
                          "Content-Encoding: gzip", f"Content-Length: {len(bomb)}") + bomb)
            self.assertEqual(status, 415)

    def test_overlapping_ranges(self):
        ranges = "Range: bytes=" + ",".join(["0-"] * 3000)
        with self.bounded():
            for _ in range(20):
                self.assertIn(self.server.exchange(self.head("GET", "/main.js", ranges)), (400, 416))

    def refused_json(self, body, status, paths=("/models", "/simulations", "/reports")):
        for path in paths:
            with self.bounded():
                self.assertEqual(self.server.exchange(
                    self.head("POST", "/api/v1" + path, self.token(), "Content-Type: application/json",
                              f"Content-Length: {len(body)}") + body), status, (path, body[:80]))

    def test_json_beyond_its_bounds(self):
        for body in (b"[" * 1000000, b'{"a":' * 100000, b"1e" + b"9" * 1000000,
                     b"[" + b"1," * 500000 + b"1]",
                     b"[" + b"[" * 60 + b"]" * 60 + (b"," + b"[" * 60 + b"]" * 60) * 8000 + b"]",
                     b"{" + b",".join(b'"%08d":1' % i for i in range(80000)) + b"}"):
            self.refused_json(body, 400)
        self.refused_json(b" " * (4 << 20), 413)

    def test_json_within_its_bounds(self):
        nested = b"[" * 60 + b"]" * 60
        for body in (b'{"name":"' + b"a" * 1000000 + b'"}', b'{"' + b"a" * 1000000 + b'":1}',
                     b"[" + b",".join([b'"%s"' % (b"a" * 17)] * 49000) + b"]",
                     b"[" + b",".join([nested] * 800) + b"]",
                     b"[" + b",".join([b"{" + b",".join(b'"%015d":1' % i for i in range(999)) + b"}"] * 24) + b"]"):
            self.refused_json(body, 422)
        scene = b'{"bodies":[' + b",".join([b"{}"] * 24000) + b"]}"
        self.refused_json(scene, 422, ["/simulations"])
        self.refused_json(b'{"kind":"scene","scene":' + scene + b"}", 422, ["/reports"])

    def test_slow_heads(self):
        part = self.head("GET", "/")[:-4] + b"\r\nX-Long: " + b"a" * 12000
        with self.bounded():
            peers = [self.server.connect(part) for _ in range(300)]
            for _ in range(20):
                self.assertEqual(self.server.request("GET", "/version")[0], 200)
            for peer in peers:
                peer.close()

    def test_slow_bodies(self):
        with self.bounded():
            peers = [self.server.connect(self.head(
                "POST", "/api/v1/meshes?name=a.obj", self.token(), "Content-Length: 1073741824") + b"v" * 1000)
                for _ in range(200)]
            self.assertEqual(self.server.request("POST", "/meshes?sample=cube")[0] // 100, 2)
            for peer in peers:
                peer.close()

    def test_bodies_all_but_finished(self):
        for path, kind, declared, senders in (("/meshes?name=a.obj", "model/obj", 8 << 20, 40),
                                              ("/simulations", "application/json", 1 << 20, 100),
                                              ("/simulations", "application/json", 15000, 1500),
                                              ("/simulations", "application/json", 8000, 1000)):
            part = self.head("POST", "/api/v1" + path, self.token(), f"Content-Type: {kind}",
                             f"Content-Length: {declared}") + b" " * (declared - 1)
            with self.subTest(path=path, declared=declared), self.bounded():
                peers = [self.server.connect() for _ in range(senders)]
                for peer in peers:
                    with contextlib.suppress(OSError):  # those that gave way
                        peer.sendall(part)
                self.assertEqual(self.server.request("POST", "/meshes?sample=cube")[0] // 100, 2)
                for peer in peers:
                    peer.close()

    def test_large_json_from_many_at_once(self):
        body = b"[" + b",".join([b'"%s"' % (b"a" * 17)] * 49000) + b"]"
        part = self.head("POST", "/api/v1/simulations", self.token(), "Content-Type: application/json",
                         f"Content-Length: {len(body)}") + body
        with self.bounded():
            peers = [self.server.connect(part) for _ in range(12)]
            for peer in peers:
                self.assertIn(peer.recv(12), (b"HTTP/1.1 422", b"HTTP/1.1 503"))
                peer.close()

    def test_bodies_whose_senders_vanish(self):
        part = self.head("POST", "/api/v1/simulations", self.token(), "Content-Type: application/json",
                         "Content-Length: 1000000") + b"[" * 200000
        with self.bounded():
            for _ in range(300):
                self.server.connect(part).close()

    def test_slow_readers(self):
        with self.bounded():
            peers = [self.server.stream(self.model + path, receive_buffer=4096)
                     for path in ("/voxels?shell=false", "/tets", "/exports/vtu", "/exports/tetgen") for _ in range(50)]
            self.assertEqual(self.server.request("GET", "/version")[0], 200)
            for peer in peers:
                peer.recv(100)
            for peer in peers:
                peer.close()

    def test_slow_readers_of_different_answers(self):
        mesh = self.server.get("/meshes")["meshes"][0]["id"]
        path = "/models/" + self.server.finish(self.server.send("POST", "/models", {
            "mesh_id": mesh, "params": {"voxels": 300, "cells": 70}}))["result"]["model_id"]
        peers, total = [], 0
        with self.bounded():
            for answer in ("/tets", "/tets?smoothed=false&encoding=f64", "/voxels?shell=false", "/voxels", "/exports/vtu",
                           "/exports/tetgen"):
                peers.append(self.server.stream("/api/v1" + path + answer, receive_buffer=4096))
                head = peers[-1].recv(400)
                total += int(head.split(b"Content-Length: ")[1].split(b"\r")[0])
        self.assertGreater(total, MEMORY)
        for peer in peers:
            peer.close()
        self.server.request("DELETE", path)

    def test_slow_viewers(self):
        simulation = self.server.new_simulation(cells=16, gravity=[0, 0, 0])
        path, frames = "/simulations/" + simulation["id"], simulation["frames"]
        eventually(lambda: self.server.get(path)["seq"], lambda seq: seq > 10, "frames to send")
        self.server.send("PATCH", path, {"state": "paused"})
        for query in ("", "?topology=inline", "?pace=every&after_seq=0", "/5"):
            with self.subTest(query), self.bounded():
                peers = [self.server.stream(frames + query, receive_buffer=4096) for _ in range(200)]
                for peer in peers:
                    self.assertTrue(peer.recv(100))
                for peer in peers:
                    peer.close()
        self.server.request("DELETE", path)

    def test_costly_requests_are_refused_by_their_estimate(self):
        mesh = self.server.send("POST", "/meshes?sample=cube")["id"]
        box = {"type": "deformable", "lattice": {"cells": [1024] * 3, "cell_size": 0.1, "origin": [0, 0, 0]}}
        with self.bounded():
            for path, body in (("/models", {"mesh_id": mesh, "params": {"voxels": 1024, "cells": 512}}),
                               ("/models", {"mesh_id": mesh, "params": {"voxels": 10**9}}),
                               ("/simulations", {"bodies": [box]}),
                               ("/reports", {"kind": "scene", "scene": {"bodies": [box], "duration": 1e8}})):
                status, problem = self.server.request("POST", path, body)
                self.assertEqual(status, 422, problem)
                self.assertTrue(problem["hint"] or problem["errors"])


if __name__ == "__main__":
    unittest.main()
