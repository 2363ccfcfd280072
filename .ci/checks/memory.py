#!/usr/bin/env python3
"""The memory of a run does not grow with its duration, because samples are dropped every second and requested series are stored while it
computes. Readers hold a piece of a series at a time."""

import concurrent.futures
import http.client
import json
import os
import subprocess
import sys
import time

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), os.pardir))
from service import ARTICLE, binary, check, clean_environment, service  # noqa: E402

MOST = 64.0
SECONDS = 20
# Of a run with the largest series, and what readers of them may add [MB].
MOST_WITH_SERIES, MOST_OF_READERS = 128.0, 256.0
READERS = 8


def long_run():
    job = ARTICLE | {"settle_s": 0.02, "duration_s": SECONDS, "solver": {"rung": "radially_condensed"}}
    with subprocess.Popen([binary(), "simulate", "-", "--quiet"], stdin=subprocess.PIPE, stdout=subprocess.PIPE,
                          env=clean_environment()) as run:
        run.stdin.write(json.dumps(job).encode())
        run.stdin.close()
        answer = json.loads(run.stdout.read())
        # Usage of this child only. RUSAGE_CHILDREN would give the largest of all.
        _, status, usage = os.wait4(run.pid, 0)
        run.returncode = os.waitstatus_to_exitcode(status)
    check(run.returncode == 0, f"{SECONDS} s are simulated")
    labels = {line["label"] for line in answer["lines"]}
    check({"BPFO", "2·BPFO"} <= labels, "its lines are labelled")
    peak = usage.ru_maxrss / 1024
    check(peak < MOST, f"peak memory {peak:.1f} MB, less than {MOST:g} MB")


def resident(service, what):
    """Resident memory of a service, now (`VmRSS`) or at most since it was asked to forget (`VmHWM`) [MB]."""
    with open(f"/proc/{service.process.pid}/status", encoding="ascii") as status:
        return next(int(line.split()[1]) for line in status if line.startswith(what)) / 1024


def forget_peak(service):
    with open(f"/proc/{service.process.pid}/clear_refs", "w", encoding="ascii") as file:
        file.write("5")


def channels(balls):
    spindle = [f"spindle.{axis}.{motion}" for axis in "yz" for motion in ("displacement", "velocity", "acceleration")]
    loads = [f"ball.{ball}.{contact}.load" for ball in range(1, balls + 1) for contact in ("inner", "outer", "pocket")]
    return spindle + ["cage.y.displacement", "cage.z.displacement", "cage.speed"] + loads


# As many series and as many values as the limits allow.
FEW = ARTICLE | {"settle_s": 0.02, "duration_s": 23.4, "solver": {"rung": "radially_condensed"}, "outputs": {"series": channels(7)[:14]}}
MANY = FEW | {"duration_s": 5.118, "scene": {"bearing": {"preset": "6206", "ball_count": 20, "ball_diameter_mm": 6},
                                            "operation": {"speed_rpm": 6000, "radial_load_y_n": 300}}, "outputs": {"series": channels(20)[:64]}}


def read(service, path, accept):
    """Reads an answer piece by piece; returns its length."""
    connection = http.client.HTTPConnection(service.url.removeprefix("http://"), timeout=300)
    connection.request("GET", path, headers={"Accept": accept})
    answer, length = connection.getresponse(), 0
    while piece := answer.read(1 << 20):
        length += len(piece)
    connection.close()
    return answer.status, length


def largest_series():
    with service("--workers", "1", "--time-limit-s", "600") as running:
        for job, name in [(FEW, "14 series of 23.4 s"), (MANY, "64 series of 5.118 s")]:
            begin = time.monotonic()
            path, _ = running.submit(job)
            ended = running.ended(path, at_most=600)
            check(ended["status"] == "succeeded", f"{name} are recorded in {time.monotonic() - begin:.1f} s: {ended['error']}")
            peak = resident(running, "VmHWM")
            check(peak < MOST_WITH_SERIES, f"{name}: peak memory {peak:.1f} MB, less than {MOST_WITH_SERIES:g} MB")
            if job is not FEW:
                continue
            forget_peak(running)
            before, begin = resident(running, "VmRSS"), time.monotonic()
            asked = [(f"{path}/series?channel={channel}", accept) for channel, accept in zip(
                FEW["outputs"]["series"], ["application/json", "text/csv", "application/x-npy", "application/json"] * 2)]
            asked[-1] = (asked[-1][0] + "&max_points=1200000", "application/x-npy")
            with concurrent.futures.ThreadPoolExecutor(READERS) as pool:
                answers = list(pool.map(lambda one: read(running, *one), asked))
            sent = sum(length for _, length in answers) / 1e6
            check(all(status == 200 for status, _ in answers), f"{READERS} readers at once receive {sent:.0f} MB in {time.monotonic() - begin:.1f} s")
            values = round(23.4 * 102_400)
            check(answers[2][1] == 128 + 16 * values, f"a NumPy file has all of the {values} values")
            added = resident(running, "VmHWM") - before
            check(added < MOST_OF_READERS, f"they add {added:.1f} MB, less than {MOST_OF_READERS:g} MB")


long_run()
largest_series()
