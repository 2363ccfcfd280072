#!/usr/bin/env python3
"""Time that the service adds to the solver, rates of the page's slider, and response times of the service while all cores simulate. Times
are printed and have no limit, because machines differ. The check fails on a wrong response. Under .ci/with-postgres the first is measured there, too."""

import http.client
import json
import math
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

    def __init__(self, url, timeout=60):
        self.connection = http.client.HTTPConnection(url.split("//")[1], timeout=timeout)

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


# Longest time for the rates of all presets, time for a preset whose previews are fast, and for the first preview of a slow one [s].
ALL_RATES, RATE, FIRST = 18, 1, 5


def position(name, bearing, seconds):
    """The request of the page's slider over the clearance, some time after `Sweep` at its start: the other settings are those of the page."""
    swing = 1 - math.cos(math.pi / 2 + 2 * math.pi * seconds / 6)
    changed = {"preset": name, "radial_clearance_um": float(f"{bearing['radial_clearance_um'] * swing:.5g}")}
    return {"kind": "simulation", "solver": {"model_tolerance_db": 1},
            "scene": {"bearing": changed, "operation": {"speed_rpm": 3000, "radial_load_y_n": 500}, "spindle": {"balance_grade": 6.3}},
            "outputs": {"metrics": ["vibration"], "spectra": ["spindle.y.acceleration"]}}


def slide(url, name, bearing, share):
    """Prints the rate of previews of a preset, one after another, and cancels the first one if it takes longer than the share."""
    begin, took, rungs = time.perf_counter(), [], set()
    while not took or time.perf_counter() - begin < RATE:
        since = time.perf_counter()
        client = Client(url, timeout=max(share - (since - begin), 0.2))
        try:
            status, answer = client.ask("POST", "/v1/preview", position(name, bearing, since - begin))
        except TimeoutError:
            break
        finally:
            client.connection.close()
        if status != 200:
            check(False, f"the slider on {name} gives {status}: {answer}")
        took.append(time.perf_counter() - since)
        rungs.add(json.loads(answer)["metrics"]["solver"]["rung"])
    if took:
        told = f"{len(took) / sum(took):.1f} previews a second, {1e3 * statistics.median(took):.0f} ms in the median of {len(took)}"
        print(f"slider on {name}: {told}, model {' and '.join(sorted(rungs))}")
    else:
        print(f"slider on {name}: no preview within {share:.1f} s")


def slider(service):
    """The rate for every preset. What fast ones leave of the time is for slow ones."""
    presets = service.request("GET", "/v1/presets")[2]["bearings"]
    end = time.perf_counter() + ALL_RATES
    for left, (name, preset) in zip(range(len(presets), 0, -1), presets.items()):
        slide(service.url, name, preset["bearing"], min((end - time.perf_counter()) / left, FIRST))


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
        slider(service)

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
