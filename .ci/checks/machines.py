#!/usr/bin/env python3
"""A study of 64 points on PostgreSQL with one and with two `raceway worker` processes of one thread each, in turn. The tables must be
equal. The ratio of the times is printed without a limit, because two workers need two free cores. So is the waiting time of a
job beyond its solver."""

import json
import os
import statistics
import subprocess
import sys
import tempfile
import time

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), os.pardir))
from service import ARTICLE, ROOT, Service, binary, check, clean_environment  # noqa: E402

POINTS = 64
ROUNDS = 2
WAITED_FOR = 60
STUDY = {
    "kind": "study", "scene": ARTICLE["scene"], "solver": {"rung": "full"}, "settle_s": 0.01, "duration_s": 0.12, "reuse": False,
    "axes": [{"path": "/operation/radial_load_y_n", "from": 100, "to": 300, "count": POINTS}],
}


def timeless(table):
    """The table without measured times."""
    return json.dumps([[row["point"], row["metrics"]["channels"]] for row in table["rows"]], sort_keys=True)


def run(server, workers):
    """Time from submission to end [s], and the table."""
    command = [binary(), "worker", "--database", server, "--workers", "1"]
    started = [subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True,
                                env=clean_environment()) for _ in range(workers)]
    try:
        for worker in started:
            check(worker.stdout.readline().startswith("working for postgres://"), "a worker has started")
        begin = time.monotonic()
        path = service.submit(STUDY)[0]
        ended = service.ended(path, at_most=600)
        took = time.monotonic() - begin
        check(ended["status"] == "succeeded", f"the study succeeds on {workers} worker(s)")
        return took, timeless(service.request("GET", f"{path}/table")[2])
    finally:
        for worker in started:
            worker.terminate()
        for worker in started:
            worker.wait()


def overhead():
    """Waiting times of jobs beyond their solver [ms]."""
    beyond = []
    for number in range(WAITED_FOR):
        operation = {"speed_rpm": 50000, "radial_load_y_n": 100 + number}
        begin = time.perf_counter()
        answer = alone.request("POST", "/v1/jobs", ARTICLE | {"scene": ARTICLE["scene"] | {"operation": operation}, "reuse": False},
                               {"Prefer": "wait=30"})[2]
        took = time.perf_counter() - begin
        beyond.append(1e3 * (took - answer["metrics"]["solver"]["wall_time_s"]))
    return sorted(beyond)


server = os.environ.get("RACEWAY_TEST_POSTGRES")
if not server:
    again = [os.path.join(ROOT, ".ci", "with-postgres"), sys.executable, os.path.abspath(__file__)]
    sys.exit(subprocess.run(again).returncode)
serve = [binary(), "serve", "--listen", "127.0.0.1:0", "--database", server]
with tempfile.TemporaryDirectory(prefix="raceway-check-") as directory:
    service = Service(directory, command=[*serve, "--workers", "0"])
    ratios = []
    for _ in range(ROUNDS):
        one, of_one = run(server, 1)
        two, of_two = run(server, 2)
        check(of_one == of_two, "one worker and two give the same table")
        ratios.append(one / two)
        print(f"machines: {POINTS} points take {one:.2f} s on one worker, {two:.2f} s on two: {one / two:.2f} times as fast")
    print(f"machines: median {statistics.median(ratios):.2f} of {ROUNDS} rounds, {os.cpu_count()} cores; the goal is 1.8 on two free cores")
    check(service.stop() == 0, "the service stops with status 0")
    alone = Service(directory, command=serve)
    beyond = overhead()
    print(f"machines: {WAITED_FOR} waited-for jobs on PostgreSQL take {statistics.median(beyond):.1f} ms beyond their solver in the median, "
          f"{beyond[0]:.1f} to {beyond[-1]:.1f} ms")
    check(alone.stop() == 0, "a service with its own worker stops with status 0")
