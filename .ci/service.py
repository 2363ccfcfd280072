"""Shared by the checks of the running program: a service as a process, and requests to it. Standard library only."""

import contextlib
import json
import os
import queue
import socket
import subprocess
import sys
import tempfile
import threading
import time
import urllib.error
import urllib.request

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))


def binary():
    """Path of the release build: the variable RACEWAY, else the target directory of cargo."""
    target = os.environ.get("CARGO_TARGET_DIR", os.path.join(ROOT, "target"))
    path = os.environ.get("RACEWAY", os.path.join(target, "release", "raceway"))
    if not os.path.exists(path):
        sys.exit(f"{path} does not exist; build it with: cargo build --release")
    return path


ARTICLE = {
    "kind": "simulation",
    "scene": {"bearing": "article-integrated", "operation": {"speed_rpm": 50000, "radial_load_y_n": 200}},
}


def check(holds, what):
    """Stops with a message if the condition does not hold."""
    if not holds:
        sys.exit(f"FAILED: {what}")
    print(f"ok: {what}")


def clean_environment(**more):
    """The environment without settings of the service, so that those of a developer have no effect."""
    kept = {name: value for name, value in os.environ.items() if not name.startswith("RACEWAY_")}
    return kept | more


def free_port():
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


class Service:
    """`raceway serve` on a free port."""

    def __init__(self, directory, *options, command=None, environment=None, **popen):
        database = os.path.join(directory, "raceway.db")
        default = [binary(), "serve", "--listen", "127.0.0.1:0", "--database", f"sqlite://{database}", *options]
        self.log_path = os.path.join(directory, "stderr.log")
        self.log = open(self.log_path, "ab")
        self.process = subprocess.Popen(
            command or default, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=self.log,
            env=environment or clean_environment(), text=True, **popen)
        self.url = self._announced()
        self.token = None

    def _announced(self, at_most=30):
        lines = queue.Queue()
        threading.Thread(target=lambda: lines.put(self.process.stdout.readline()), daemon=True).start()
        try:
            line = lines.get(timeout=at_most).strip()
        except queue.Empty:
            line = ""
        if not line.startswith("listening on http://"):
            self.kill()
            sys.exit(f"FAILED: the first line of stdout is {line!r}; stderr:\n{self.stderr()}")
        return line.removeprefix("listening on ")

    def stderr(self):
        with open(self.log_path, encoding="utf-8", errors="replace") as log:
            return log.read()

    def request(self, method, path, body=None, headers=None, timeout=70):
        """Status, headers and body (parsed if it is JSON)."""
        request = urllib.request.Request(self.url + path, method=method, headers=dict(headers or {}))
        if self.token:
            request.add_header("Authorization", f"Bearer {self.token}")
        if body is not None:
            request.data = json.dumps(body).encode()
            request.add_header("Content-Type", "application/json")
        try:
            with urllib.request.urlopen(request, timeout=timeout) as answer:
                status, fields, content = answer.status, answer.headers, answer.read()
        except urllib.error.HTTPError as error:
            status, fields, content = error.code, error.headers, error.read()
        kind = fields.get_content_type()
        if kind.endswith("json") and content:
            content = json.loads(content)
        return status, fields, content

    def submit(self, job):
        status, headers, answer = self.request("POST", "/v1/jobs", job)
        if status != 202:
            sys.exit(f"FAILED: submitting gives {status}: {answer}")
        return headers["Location"], answer

    def until(self, path, holds, at_most=120, every=0.05):
        """The job, as soon as `holds(job)` is true."""
        deadline = time.monotonic() + at_most
        while time.monotonic() < deadline:
            job = self.request("GET", path)[2]
            if holds(job):
                return job
            time.sleep(every)
        sys.exit(f"FAILED: after {at_most} s the job is still {job}\n{self.stderr()}")

    def ended(self, path, at_most=120):
        return self.until(path, lambda job: job["status"] not in ("queued", "running"), at_most)

    def kill(self):
        """Kills the process, like a power cut."""
        self.process.kill()
        self.process.wait()

    def stop(self):
        """Stops the process with SIGTERM and returns its exit status."""
        if self.process.poll() is None:
            self.process.terminate()
            try:
                self.process.wait(timeout=20)
            except subprocess.TimeoutExpired:
                self.kill()
                sys.exit("FAILED: the service does not stop within 20 s of SIGTERM")
        self.log.close()
        return self.process.returncode


@contextlib.contextmanager
def service(*options, **settings):
    """A service with its own database, both removed afterwards."""
    with tempfile.TemporaryDirectory(prefix="raceway-check-") as directory:
        running = Service(directory, *options, **settings)
        try:
            yield running
        except BaseException:
            running.kill()
            raise
        else:
            status = running.stop()
            check(status == 0, "the service stops with status 0 on SIGTERM")
