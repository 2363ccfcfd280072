#!/usr/bin/env python3
"""64 jobs on a service with one worker and with two, in turn: each ends once, with the same result.

The ratio of the times is printed without a limit, because two workers need two free cores."""

import json
import os
import statistics
import sys
import time

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), os.pardir))
from service import ARTICLE, check, service  # noqa: E402

JOBS = 64
ROUNDS = 2


def job(number):
    operation = {"speed_rpm": 50000, "radial_load_y_n": 150 + number}
    scene = ARTICLE["scene"] | {"operation": operation}
    return ARTICLE | {"scene": scene, "solver": {"rung": "full"}, "settle_s": 0.02, "duration_s": 0.2, "reuse": False}


def run(workers):
    """Time from the first submission to the last end [s], and the results."""
    with service("--workers", str(workers)) as running:
        begin = time.monotonic()
        paths = [running.submit(job(number))[0] for number in range(JOBS)]
        ended = [running.ended(path, at_most=600) for path in paths]
        took = time.monotonic() - begin
        check(all(one["status"] == "succeeded" for one in ended), f"{JOBS} jobs on {workers} worker(s) succeed")
        metrics = [running.request("GET", path + "/metrics")[2] for path in paths]
        return took, [json.dumps(one["channels"], sort_keys=True) for one in metrics]


ratios = []
for _ in range(ROUNDS):
    one, of_one = run(1)
    two, of_two = run(2)
    check(of_one == of_two, "one worker and two give the same numbers")
    ratios.append(one / two)
    print(f"workers: {JOBS} jobs take {one:.2f} s on one worker, {two:.2f} s on two: {one / two:.2f} times as fast")
print(f"workers: median {statistics.median(ratios):.2f} of {ROUNDS} rounds, {os.cpu_count()} cores; the goal is 1.9 on two free cores")
