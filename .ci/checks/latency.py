#!/usr/bin/env python3
"""Time that the service adds to the solver, and its response times while all cores simulate. Times are printed and have no limit,
because machines differ. The check fails on a wrong response. Under .ci/with-postgres the first is measured there, too."""

import http.client
import json
import os
import statistics
import sys
import tempfile
import threading
import time

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), os.pardir))
from service import ARTICLE, Service, binary, check  # noqa: E402

RUNS = int(os.environ.get("RUNS", "150"))


def told(name, seconds):
    """Median and 99th percentile."""
    seconds = sorted(seconds)
    high = seconds[min(len(seconds) - 1, int(0.99 * len(seconds)))]
    print(f"{name}: {1e3 * statistics.median(seconds):.2f} ms in the median, {1e3 * high:.2f} ms at the 99th percentile of {len(seconds)}")


class Client:
    """One persistent connection."""

    def __init__(self, url):
        self.connection = http.client.HTTPConnection(url.split("//")[1], timeout=60)

    def ask(self, method, path, body=None, **headers):
        text = json.dumps(body) if body is not None else None
        self.connection.request(method, path, text, {"Content-Type": "application/json", **headers})
        answer = self.connection.getresponse()
        return answer.status, answer.read()


def quick(number):
    """The article's case on its fastest model, different in each call."""
    scene = {**ARTICLE["scene"], "operation": {"speed_rpm": 50000, "radial_load_y_n": 150 + 0.1 * number}}
    return {**ARTICLE, "scene": scene, "outputs": {"metrics": ["vibration"]}, "solver": {"rung": "periodic"}}


def overhead(client, where):
    """Waiting times beyond the solver [s], and the last job."""
    over = []
    for number in range(RUNS):
        begin = time.perf_counter()
        status, answer = client.ask("POST", "/v1/jobs", {**quick(number), "reuse": False}, Prefer="wait=30")
        took = time.perf_counter() - begin
        job = json.loads(answer)
        if number == 0:
            check(status == 200, "the response to `Prefer: wait` contains the metrics")
        over.append(took - job["metrics"]["solver"]["wall_time_s"])
    told(f"from POST with Prefer: wait to metrics on {where}, over the solver's own time", over)
    return job


server = os.environ.get("RACEWAY_TEST_POSTGRES")
if server:
    with tempfile.TemporaryDirectory(prefix="raceway-check-") as directory:
        service = Service(directory, command=[binary(), "serve", "--listen", "127.0.0.1:0", "--database", server])
        try:
            overhead(Client(service.url), "PostgreSQL")
        finally:
            service.stop()

with tempfile.TemporaryDirectory(prefix="raceway-check-") as directory:
    service = Service(directory)
    try:
        client = Client(service.url)
        job = overhead(client, "SQLite")
        path = job["links"]["self"]

        # From here on every worker is busy.
        long = {**ARTICLE, "duration_s": 20, "solver": {"rung": "full", "relative_tolerance": 1e-6}}
        busy = [service.submit({**long, "scene": {**ARTICLE["scene"], "operation": {"speed_rpm": 50000, "radial_load_y_n": 200 + k}}})[0] for k in range(os.cpu_count() or 1)]
        for one in busy:
            service.until(one, lambda job: job["status"] == "running")
        for name, asked in [("status", path), ("metrics", f"{path}/metrics")]:
            took = []
            for _ in range(10 * RUNS):
                begin = time.perf_counter()
                status, _ = client.ask("GET", asked)
                took.append(time.perf_counter() - begin)
            check(status == 200, f"{name} is available")
            told(f"{name} while all cores simulate", took)

        # Time from the end of a cancelled job to its last event.
        ended = {}

        def follow(path):
            stream = http.client.HTTPConnection(service.url.split("//")[1], timeout=60)
            stream.request("GET", f"{path}/events")
            body = stream.getresponse().read()
            ended[path] = (time.time(), body)

        followers = [threading.Thread(target=follow, args=(one,)) for one in busy]
        for follower in followers:
            follower.start()
        time.sleep(1)
        for one in busy:
            client.ask("POST", f"{one}/cancel")
        for follower in followers:
            follower.join()
        for one in busy:
            seen, body = ended[one]
            check(b"event: progress" in body and b"event: cancelled" in body, "an event stream has progress and end")
        print("streams have ended with their jobs")
    finally:
        service.stop()
