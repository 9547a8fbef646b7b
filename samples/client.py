#!/usr/bin/env python3
"""The API in a few lines of standard Python: a mesh becomes a model, the model a body that falls.

    isochor serve --port 8080 --json          # prints {"url": …, "token": …}
    samples/client.py http://127.0.0.1:8080/ TOKEN samples/meshes/tree.obj
"""
import http.client
import json
import pathlib
import sys
import urllib.parse

url, token, mesh = urllib.parse.urlsplit(sys.argv[1]), sys.argv[2], pathlib.Path(sys.argv[3])


def request(method, path, body=None):
    """An open answer: one request a connection."""
    connection = http.client.HTTPConnection(url.hostname, url.port, timeout=60)
    headers = {"Authorization": "Bearer " + token}
    if isinstance(body, dict):
        body, headers["Content-Type"] = json.dumps(body), "application/json"
    connection.request(method, path, body, headers)
    answer = connection.getresponse()
    if answer.status >= 400:
        problem = json.load(answer)
        sys.exit(f"{problem['detail']}\n{problem.get('hint', '')}")
    return answer


def call(method, path, body=None):
    return json.load(request(method, "/api/v1" + path, body))


stored = call("PUT", "/meshes/" + urllib.parse.quote(mesh.name), mesh.read_bytes())
print(f"{mesh.name}: {stored['report']['triangles']} triangles, {stored['report']['components']} components")

job = call("POST", "/models?wait_ms=10000", {"mesh_id": stored["id"], "params": {"voxels": 64, "cells": 12}})
while job["status"] in ("queued", "running"):
    job = call("GET", f"/jobs/{job['id']}?wait_ms=10000")
if job["status"] != "done":
    sys.exit(f"{job['problem']['detail']}\n{job['problem'].get('hint', '')}")
model = job["result"]["model"]
print(f"{model['tets']} tets in {sum(stage['ms'] for stage in model['stages']):.0f} ms, "
      f"smallest dihedral {model['min_dihedral_deg']:.1f} deg")

scene = {"name": "fall", "duration": 0.5,
         "bodies": [{"type": "deformable", "mesh": job["result"]["model_id"], "position": [0, 0, 0]}]}
simulation = call("POST", "/simulations?pace=fast&state=playing&wait_ms=10000", scene)
with request("GET", simulation["frames"] + "?pace=every&encoding=array") as stream:
    for text in stream:
        line = json.loads(text)
        if line["type"] == "frame" and line["seq"] % 10 == 0:
            metrics = line["metrics"]
            print(f"t = {line['t']:.3f} s: volume error {metrics['total_volume_error']:.1e}, "
                  f"of a cell {metrics['max_cell_volume_error']:.1e}, {metrics['step_ms']:.2f} ms")
        if line["type"] == "end":
            print(f"{line['reason']} at frame {line['seq']}")
