"""The real server in a process of its own, and what it costs: its path is in the environment variable ISOCHOR."""
import http.client
import json
import math
import os
import pathlib
import signal
import socket
import subprocess
import time

PROGRAM = os.environ["ISOCHOR"]
TICKS = os.sysconf("SC_CLK_TCK")
SLOWNESS = float(os.environ.get("ISOCHOR_SLOWNESS", "1"))  # how many times slower than a release build; 1: it is one


def memory_bound(most_bytes):
    """None for a sanitized build: its shadow, and what it keeps of freed memory, are no cost of the program."""
    return most_bytes if SLOWNESS == 1 else math.inf


class Serving:
    """with Serving() as server: …; ends with SIGTERM, and with an exit code of 0."""

    patience = 120.0 * SLOWNESS  # seconds for an answer, and for the end

    def __init__(self, *arguments, launcher=(), **options):
        self.process = subprocess.Popen([*launcher, PROGRAM, "serve", "--port", "0", "--json", *arguments],
                                        stdout=subprocess.PIPE, **options)
        announced = json.loads(self.process.stdout.readline())
        self.url, self.token = announced["url"], announced["token"]
        self.port = int(self.url.rsplit(":", 1)[1].strip("/"))
        self.pid = self.process.pid

    def __enter__(self):
        return self

    def __exit__(self, kind, value, trace):
        code = self.stop()
        if kind is None:
            assert code == 0, f"the server ended with {code}"

    def stop(self):
        if self.process.poll() is None:
            self.process.send_signal(signal.SIGTERM)
        try:
            return self.process.wait(self.patience)
        finally:
            self.process.kill()
            self.process.stdout.close()

    def wait_until_idle(self):
        """The sample that is made at the start would count as somebody else's cost."""
        while any(job["status"] in ("queued", "running") for job in self.get("/jobs")["jobs"]):
            time.sleep(0.02)

    def request(self, method, path, body=None):
        """Status and document."""
        connection = http.client.HTTPConnection("127.0.0.1", self.port, timeout=self.patience)
        headers = {"Authorization": "Bearer " + self.token}
        if body is not None and not isinstance(body, bytes):
            body = json.dumps(body)
            headers["Content-Type"] = "application/json"
        try:
            connection.request(method, "/api/v1" + path, body, headers)
            answer = connection.getresponse()
            text = answer.read()
        finally:
            connection.close()
        is_json = "json" in (answer.getheader("Content-Type") or "")
        return answer.status, json.loads(text) if is_json and text else text

    def get(self, path):
        status, document = self.request("GET", path)
        assert status == 200, (status, document)
        return document

    def send(self, method, path, body=None):
        status, document = self.request(method, path, body)
        assert status < 300, (status, document)
        return document

    def finish(self, job):
        """Follows a job until it has ended."""
        while job["status"] in ("queued", "running"):
            job = self.get(f"/jobs/{job['id']}?wait_ms=1000")
        return job

    def head(self, method, path, *fields):
        lines = [f"{method} {path} HTTP/1.1", f"Host: 127.0.0.1:{self.port}", *fields]
        return ("\r\n".join(lines) + "\r\n\r\n").encode()

    def connect(self, data=b"", receive_buffer=None):
        """A socket that has sent these bytes."""
        peer = socket.socket()
        if receive_buffer:
            peer.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, receive_buffer)
        peer.settimeout(self.patience)
        peer.connect(("127.0.0.1", self.port))
        peer.sendall(data)
        return peer

    def exchange(self, data):
        """The status of the answer to these bytes, 0 when there is none."""
        with self.connect(data) as peer:
            answer = b""
            while part := peer.recv(65536):
                answer += part
        return int(answer.split(b" ", 2)[1]) if answer else 0

    def stream(self, path, receive_buffer=None):
        return self.connect(self.head("GET", path), receive_buffer)

    def new_simulation(self, cells=2, **scene):
        body = {"name": "box", "type": "deformable",
                "lattice": {"cells": [cells] * 3, "cell_size": 0.5 / cells, "origin": [0, 5, 0]}}
        scene = {"duration": None, "bodies": [body], **scene}
        return self.send("POST", "/simulations?state=playing&wait_ms=10000", scene)

    # What it costs, from /proc.
    def status_field(self, name):
        text = pathlib.Path(f"/proc/{self.pid}/status").read_text()
        return int(text.split(name + ":")[1].split()[0])

    def peak_bytes(self):
        return self.status_field("VmHWM") * 1024

    def resident_bytes(self):
        return self.status_field("VmRSS") * 1024

    def forget_peak(self):
        pathlib.Path(f"/proc/{self.pid}/clear_refs").write_text("5")

    def cpu_seconds(self):
        fields = pathlib.Path(f"/proc/{self.pid}/stat").read_text().rsplit(")", 1)[1].split()
        return (int(fields[11]) + int(fields[12])) / TICKS

    def thread_seconds(self):
        """CPU time of each thread."""
        tasks = pathlib.Path(f"/proc/{self.pid}/task")
        return {task.name: int((task / "schedstat").read_text().split()[0]) / 1e9 for task in tasks.iterdir()}

    def descriptors(self):
        return len(os.listdir(f"/proc/{self.pid}/fd"))

    def threads(self):
        return self.status_field("Threads")


def eventually(read, passes, what, patience=Serving.patience):
    end = time.monotonic() + patience
    while not passes(value := read()):
        assert time.monotonic() < end, f"{what}: still {value}"
        time.sleep(0.01)
    return value
