"""Many viewers of one simulation, as its owner sees it: what they get, and what they cost."""
import json
import selectors
import time
import unittest

from serving import SLOWNESS, Serving, eventually, memory_bound

VERTICES = 17 ** 3
FRAME_BYTES = VERTICES * 24  # kept for scrubbing


def lines_of(peer, passes):
    """Lines of a stream, parsed, until one passes."""
    found, rest = [], b""
    peer.settimeout(Serving.patience)
    while not (found and passes(found[-1])):
        part = peer.recv(1 << 16)
        assert part, "the stream ended"
        *whole, rest = (rest + part).split(b"\n")
        found += [json.loads(line) for line in whole if line.startswith(b'{"type"')]
    return found


class Streams(unittest.TestCase):
    def setUp(self):
        self.server = Serving()
        self.server.wait_until_idle()

    def tearDown(self):
        self.assertEqual(self.server.stop(), 0)

    def simulation(self, cells=16):
        simulation = self.server.new_simulation(cells, gravity=[0, 0, 0])
        return simulation["frames"], "/simulations/" + simulation["id"]

    def test_two_hundred_viewers_share_one_encoding_and_cost_no_memory(self):
        server = self.server
        frames, path = self.simulation()
        memory, threads, first = server.resident_bytes(), server.threads(), server.get(path)
        peers = [server.stream(frames) for _ in range(200)]
        seen, tails, buffer = [0] * len(peers), [b""] * len(peers), bytearray(1 << 18)
        with selectors.DefaultSelector() as selector:
            for i, peer in enumerate(peers):
                selector.register(peer, selectors.EVENT_READ, i)
            end = time.monotonic() + Serving.patience
            while min(seen) < 5:
                self.assertLess(time.monotonic(), end, "somebody gets no frames")
                for key, _ in selector.select(1.0):
                    size, i = key.fileobj.recv_into(buffer), key.data
                    data = tails[i] + buffer[:size]
                    seen[i] += data.count(b'"type":"frame"')
                    tails[i] = bytes(data[-13:])  # what a mark may begin with
        last = server.get(path)
        self.assertEqual(last["viewers"], 200)
        steps = last["seq"] - first["seq"]
        self.assertLessEqual(last["encoded_frames"] - first["encoded_frames"], steps + 2)
        self.assertEqual(server.threads(), threads, "a viewer takes no thread")
        self.assertLess(server.resident_bytes() - memory, memory_bound(steps * FRAME_BYTES + (16 << 20)))
        for peer in peers:
            peer.close()
        eventually(lambda: server.get(path)["viewers"], lambda n: n == 0, "viewers")

    def test_a_slow_reader_loses_frames_and_nobody_else_does(self):
        server = self.server
        frames, path = self.simulation()
        with server.stream(frames, receive_buffer=4096) as slow, server.stream(frames + "?pace=every") as quick:
            start = slow.recv(256)
            self.assertIn(b"200 OK", start)
            lines = lines_of(quick, lambda line: line.get("seq", 0) >= 120 / SLOWNESS)
            numbers = [line["seq"] for line in lines if line["type"] == "frame"]
            self.assertEqual(numbers, list(range(numbers[0], numbers[0] + len(numbers))))
            lines_of(slow, lambda line: line.get("dropped", 0) > 10 / SLOWNESS)


if __name__ == "__main__":
    unittest.main()
