#!/usr/bin/env python3
"""What the server carries: viewers of live simulations, and /health meanwhile. Prints one line a figure, or one JSON
document with --json; names of measures ask for these alone. ISOCHOR names the program (default:
build/release/server/isochor)."""
import http.client
import json
import multiprocessing
import os
import pathlib
import selectors
import statistics
import sys
import threading
import time

SOURCE = pathlib.Path(__file__).resolve().parents[2]
os.environ.setdefault("ISOCHOR", str(SOURCE / "build" / "release" / "server" / "isochor"))
sys.path.insert(0, str(SOURCE / "tests" / "http"))
from serving import Serving  # noqa: E402


class Viewers:
    """Readers of a stream that take all they get, in one thread; frames are lines."""

    def __init__(self, server, path, count):
        self.sockets = [server.stream(path) for _ in range(count)]
        self.lines = [0] * count
        self.over = threading.Event()
        self.thread = threading.Thread(target=self.read)
        self.thread.start()

    def read(self):
        selector, buffer = selectors.DefaultSelector(), bytearray(1 << 18)
        for i, peer in enumerate(self.sockets):
            selector.register(peer, selectors.EVENT_READ, i)
        while not self.over.is_set():
            for key, _ in selector.select(0.05):
                size = key.fileobj.recv_into(buffer)
                self.lines[key.data] += buffer.count(b'"type":"frame"', 0, size)
        selector.close()

    def close(self):
        self.over.set()
        self.thread.join()
        for peer in self.sockets:
            peer.close()


def ask_health(port, over):
    """Again and again until told; then the seconds of each answer go back."""
    seconds = []
    while not over.poll(0.01):
        start = time.perf_counter()
        connection = http.client.HTTPConnection("127.0.0.1", port)
        connection.request("GET", "/api/v1/health")
        answer = connection.getresponse()
        assert answer.status == 200 and answer.read()
        connection.close()
        seconds.append(time.perf_counter() - start)
    over.send(seconds)


class Health:
    """Asked from a process of its own, which does not wait for the readers' interpreter."""

    def __init__(self, server):
        spawn = multiprocessing.get_context("spawn")
        self.control, asker = spawn.Pipe()
        self.process = spawn.Process(target=ask_health, args=(server.port, asker))
        self.process.start()

    def close(self):
        self.control.send("over")
        ordered = sorted(self.control.recv())
        self.process.join()
        return {"median_ms": 1e3 * statistics.median(ordered), "p99_ms": 1e3 * ordered[int(0.99 * len(ordered))],
                "max_ms": 1e3 * ordered[-1]}


def new_simulation(server, cells, query="", wait_ms=10000):
    body = {"type": "deformable", "edge_stiffness": 100, "diagonal_stiffness": 100,
            "lattice": {"cells": [cells] * 3, "cell_size": 1.0 / cells, "origin": [0, 1, 0]}}
    simulation = server.send("POST", f"/simulations?state=playing&wait_ms={wait_ms}{query}",
                             {"duration": None, "gravity": [0, 0, 0], "bodies": [body]})
    return simulation["frames"], "/simulations/" + simulation["id"]


def steps_per_second(server, path, seconds):
    first, start = server.get(path)["seq"], time.perf_counter()
    time.sleep(seconds)
    return (server.get(path)["seq"] - first) / (time.perf_counter() - start)


def many_viewers(server, seconds=6.0):
    """200 viewers of 4,913 vertices, each frame 80 KB."""
    frames, path = new_simulation(server, 16)
    alone = steps_per_second(server, path, 2.0)
    memory, encoded, seq = server.resident_bytes(), server.get(path)["encoded_frames"], server.get(path)["seq"]
    viewers, health = Viewers(server, frames, 200), Health(server)
    time.sleep(1.0)
    before, start = list(viewers.lines), time.perf_counter()
    rate = steps_per_second(server, path, seconds)
    rates = [(now - then) / (time.perf_counter() - start) for now, then in zip(viewers.lines, before)]
    state = server.get(path)
    asked = health.close()
    viewers.close()
    start = time.perf_counter()
    while server.get(path)["viewers"]:
        time.sleep(0.005)
    gone = time.perf_counter() - start
    kept = (server.get(path)["seq"] - seq) * 17**3 * 24  # frames for scrubbing, viewers or not
    growth = server.resident_bytes() - memory - kept
    server.request("DELETE", path)
    return {"viewers": 200, "frames_per_second_least": min(rates), "frames_per_second_median": statistics.median(rates),
            "encodes_per_frame": (state["encoded_frames"] - encoded) / (state["seq"] - seq),
            "step_rate": rate, "step_rate_alone": alone, "memory_growth_mb": growth / 1e6, "gone_after_s": gone,
            "health": asked}


def few_viewers(server, rounds=21, seconds=0.7):
    """4 viewers at 30 frames a second of a simulation that steps as fast as it can, with and without them in turn: the
    ratio of its rates by the clock, which the readers here and all else on the machine share in, and by the time that
    its own threads need for a step; and what encoding and sending take of a core."""
    frames, path = new_simulation(server, 16, "&pace=fast")
    stride = max(1, round(steps_per_second(server, path, seconds) / 30))

    def measure():
        before, start, rate = server.thread_seconds(), time.perf_counter(), steps_per_second(server, path, seconds)
        elapsed = time.perf_counter() - start
        return rate, {thread: (now - before.get(thread, 0.0)) / elapsed
                      for thread, now in server.thread_seconds().items()}

    by_clock, by_own_time, streaming, seen = [], [], [], []
    for _ in range(rounds):
        rate_without, busy_without = measure()
        viewers = Viewers(server, f"{frames}?stride={stride}", 4)
        rate, busy = measure()
        seen.append(sum(viewers.lines) / 4 / seconds)
        viewers.close()
        steppers = [thread for thread, share in busy_without.items() if share > 0.1 * sum(busy_without.values())]
        own, own_without = (sum(shares[thread] for thread in steppers) for shares in (busy, busy_without))
        by_clock.append(rate / rate_without)
        by_own_time.append((rate / own) / (rate_without / own_without))
        streaming.append(sum(busy.values()) - own - (sum(busy_without.values()) - own_without))
    server.request("DELETE", path)
    return {"step_rate_ratio": statistics.median(by_clock), "quartiles": quartiles(by_clock),
            "by_own_cpu_time": statistics.median(by_own_time), "own_quartiles": quartiles(by_own_time),
            "streaming_of_a_core": statistics.median(streaming), "frames_per_second": statistics.median(seen)}


def quartiles(values):
    first, _, third = statistics.quantiles(values, n=4)
    return {"first": first, "third": third}


def one_browser(server, seconds=4.0):
    """One viewer of 19,683 vertices at real time, 60 frames a second, 320 KB each."""
    frames, path = new_simulation(server, 26)
    alone = steps_per_second(server, path, 2.0)
    viewers = Viewers(server, frames, 1)
    rate = steps_per_second(server, path, seconds)
    seen = viewers.lines[0] / seconds
    viewers.close()
    server.request("DELETE", path)
    return {"frames_per_second": seen, "step_rate": rate, "step_rate_alone": alone}


def slow_heads(server, seconds=3.0):
    """/health while 300 connections hold an unfinished head."""
    peers = [server.connect(b"GET / HTTP/1.1\r\nX-Slow: " + b"a" * 1000) for _ in range(300)]
    health = Health(server)
    time.sleep(seconds)
    asked = health.close()
    for peer in peers:
        peer.close()
    return asked


def own_work(server, seconds=4.0):
    """/health while the server has work for more threads than there are cores."""
    mesh = server.send("POST", "/meshes?sample=tree")["id"]
    jobs = [server.send("POST", "/models", {"mesh_id": mesh, "params": {"voxels": 400, "cells": cells}})
            for cells in (150, 151, 152, 153)]
    frames, path = new_simulation(server, 16, "&pace=fast")
    viewers, health = Viewers(server, frames, 20), Health(server)
    time.sleep(seconds)
    asked = health.close()
    viewers.close()
    for gone in [path] + ["/jobs/" + job["id"] for job in jobs]:
        server.request("DELETE", gone)
    return asked


def slow_reader(server, seconds=4.0):
    """One reader of 1 KB/s beside one that takes all: what the other gets."""
    frames, path = new_simulation(server, 16)
    viewers = Viewers(server, frames, 1)
    rates = {}
    for name in ("alone", "beside"):
        if name == "beside":
            slow = server.stream(frames, receive_buffer=4096)
        before, end = viewers.lines[0], time.perf_counter() + seconds
        while time.perf_counter() < end:
            if name == "beside":
                slow.recv(100)
            time.sleep(0.1)
        rates[name] = (viewers.lines[0] - before) / seconds
    slow.close()
    viewers.close()
    server.request("DELETE", path)
    return {"frames_per_second_" + name: rate for name, rate in rates.items()}


def stop(server, path):
    """Seconds until a DELETE is answered, and until the server works no more: then all is freed, too."""
    start = time.perf_counter()
    _, ended = server.request("DELETE", path)
    answered = time.perf_counter() - start
    while True:
        stopped, busy = time.perf_counter() - start, server.cpu_seconds()  # in ticks of 10 ms
        time.sleep(0.025)
        if server.cpu_seconds() == busy:
            return ended, answered, max(answered, stopped)


def summary(stops):
    answered, stopped = zip(*stops)
    return {"stops": len(stops), "answered_median_ms": 1e3 * statistics.median(answered),
            "answered_max_ms": 1e3 * max(answered), "all_freed_median_ms": 1e3 * statistics.median(stopped),
            "all_freed_max_ms": 1e3 * max(stopped)}


def cancelling(server, tries=20):
    """Long jobs cancelled at moments spread over them."""
    mesh, stops = server.send("POST", "/meshes?sample=tree")["id"], []
    for i in range(tries):
        job = server.send("POST", "/models", {"mesh_id": mesh, "params": {"voxels": 400, "cells": 150 + i}})
        time.sleep(0.06 * i)
        ended, *seconds = stop(server, "/jobs/" + job["id"])
        if ended["status"] == "cancelled":
            stops.append(seconds)
    return summary(stops)


def ending(server, tries=12):
    """Simulations of 884,736 cells taken away while they are prepared, and as they begin to step."""
    stops = []
    for i in range(tries):
        _, path = new_simulation(server, 96, "&pace=fast", wait_ms=0)
        time.sleep(0.3 * i)
        stops.append(stop(server, path)[1:])
    return summary(stops)


def show(name, value, indent=""):
    if isinstance(value, dict):
        print(f"{indent}{name}")
        for key, item in value.items():
            show(key, item, indent + "  ")
    else:
        print(f"{indent}{name:<28}{value:10.3f}")


def main():
    figures, asked = {}, [name for name in sys.argv[1:] if name != "--json"]
    measures = (slow_heads, own_work, cancelling, ending, one_browser, few_viewers, slow_reader, many_viewers)
    for measure in [one for one in measures if not asked or one.__name__ in asked]:
        with Serving() as server:
            server.wait_until_idle()
            figures[measure.__name__] = measure(server)
        if "--json" not in sys.argv:
            show(measure.__name__, figures[measure.__name__])
            sys.stdout.flush()
    if "--json" in sys.argv:
        print(json.dumps(figures, indent=1))


if __name__ == "__main__":
    main()
