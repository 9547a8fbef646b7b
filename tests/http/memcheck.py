#!/usr/bin/env python3
"""A server's life under valgrind: models, reports and exports, simulations with viewers of each kind, everything
deleted, and again with all of it live at the end. Fails on any error of memory and on definite leaks.
ISOCHOR names the program (default: build/release/server/isochor)."""
import os
import pathlib
import subprocess
import sys

SOURCE = pathlib.Path(__file__).resolve().parents[2]
os.environ.setdefault("ISOCHOR", str(SOURCE / "build" / "release" / "server" / "isochor"))
from serving import Serving, eventually  # noqa: E402

VALGRIND = ("valgrind", "--quiet", "--fair-sched=yes", "--leak-check=full", "--show-leak-kinds=definite",
            "--errors-for-leak-kinds=definite", "--error-exitcode=99", "--num-callers=30")
BOX = {"type": "deformable", "lattice": {"cells": [2, 2, 2], "cell_size": 0.5, "origin": [0, 1, 0]}}
PATIENCE = 300.0  # seconds; everything is some thirty times slower


def finished(server, job):
    job = eventually(lambda: server.get("/jobs/" + job["id"]), lambda j: j["status"] not in ("queued", "running"),
                     "the job", PATIENCE)
    assert job["status"] == "done", job
    return job["result"]


def viewed(server, frames, query, lines):
    """A stream that has brought so many lines."""
    peer, text = server.stream(frames + query), b""
    peer.settimeout(PATIENCE)
    while text.count(b"\n") < lines:
        part = peer.recv(1 << 20)
        assert part, text[-500:]
        text += part
    return peer


def live(server):
    """Some of everything; the peers stay connected."""
    mesh = server.send("POST", "/meshes?sample=tree")["id"]
    result = finished(server, server.send("POST", "/models", {"mesh_id": mesh, "params": {"voxels": 48, "cells": 12}}))
    model = "/models/" + result["model_id"]
    for path in ("", "/tets", "/quality", "/voxels", "/embedding", "/exports/msh2", "/exports/vtu", "/exports/tetgen"):
        server.request("GET", model + path)
    finished(server, server.send("POST", "/reports", {"kind": "scene", "repeats": 1, "refinement": 1, "scene": {
        "duration": 0.05, "bodies": [BOX]}, "axes": {"solvers": [], "springs": [], "substeps": [2, 4],
                                                     "tolerances": [], "resolutions": []}}))
    assert server.request("POST", "/models", {"mesh_id": mesh, "params": {"voxels": -1}})[0] == 422
    assert server.request("POST", "/simulations", b"{")[0] == 415
    simulation = server.new_simulation(cells=4)
    queries = ("?encoding=f32", "?encoding=f64&stride=2", "?encoding=array&pace=every", "?topology=inline")
    return model, simulation, [viewed(server, simulation["frames"], query, 8) for query in queries]


def main():
    server = Serving("--threads", "1", launcher=VALGRIND)
    server.patience = PATIENCE
    try:
        eventually(lambda: server.get("/jobs")["jobs"], lambda jobs: all(job["status"] == "done" for job in jobs),
                   "the sample's model", PATIENCE)
        model, simulation, peers = live(server)
        for peer in peers:
            peer.close()
        path = "/simulations/" + simulation["id"]
        eventually(lambda: server.get(path)["viewers"], lambda n: n == 0, "viewers that are gone", PATIENCE)
        for gone in (path, model):
            assert server.request("DELETE", gone)[0] == 204
        peers = live(server)[2]  # SIGTERM meets them
    finally:
        code = server.stop()
    for peer in peers:
        peer.close()
    assert code == 0, f"valgrind found something: {code}"


if __name__ == "__main__":
    try:
        main()
    except (AssertionError, subprocess.TimeoutExpired) as failure:
        sys.exit(f"failed: {failure}")
