#!/usr/bin/env python3
"""Overload by wrk over 500 connections: reads, submissions, and submissions to a full queue. The check prints rates and processor time
for each response, which does not depend on the load of the machine. Its limits are generous."""

import json
import os
import re
import subprocess
import sys
import tempfile
import time

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), os.pardir))
from service import ARTICLE, Service, check  # noqa: E402

SECONDS = int(os.environ.get("SECONDS", "3"))
SMALL = {"kind": "simulation", "reuse": False, "settle_s": 0, "duration_s": 0.001, "scene": {"bearing": "608", "operation": {"speed_rpm": 3000}}}
LUA = """
wrk.method, wrk.body = "POST", [[%s]]
wrk.headers["Content-Type"] = "application/json"
"""


def processor_time(service):
    """Processor time of all threads except those of the solver, which have a lower priority [s]."""
    ticks = 0
    for thread in os.listdir(f"/proc/{service.process.pid}/task"):
        with open(f"/proc/{service.process.pid}/task/{thread}/stat", encoding="utf-8") as file:
            fields = file.read().rsplit(")", 1)[1].split()
        ticks += int(fields[11]) + int(fields[12]) if fields[16] == "0" else 0
    return ticks / os.sysconf("SC_CLK_TCK")


def seconds(text):
    value, unit = re.fullmatch(r"([\d.]+)(us|ms|s|m)", text).groups()
    return float(value) * {"us": 1e-6, "ms": 1e-3, "s": 1, "m": 60}[unit]


def load(name, service, path, connections, script=None):
    """Responses a second, number of refusals among them, and median and 99th percentile of their times [s]."""
    command = ["wrk", "-t1", f"-c{connections}", f"-d{SECONDS}", "--timeout", "20", "--latency"]
    before = processor_time(service)
    told = subprocess.run([*command, *(["-s", script] if script else []), service.url + path], capture_output=True, text=True, check=True).stdout
    spent = processor_time(service) - before

    def number(pattern, otherwise=None):
        found = re.search(pattern, told)
        return found[1] if found else otherwise

    count, rate = int(number(r"(\d+) requests in")), float(number(r"Requests/sec:\s+([\d.]+)"))
    half, high = seconds(number(r"(?m)^\s+50%\s+(\S+)")), seconds(number(r"(?m)^\s+99%\s+(\S+)"))
    refused = int(number(r"Non-2xx or 3xx responses: (\d+)", 0)) / max(count, 1)
    print(f"{name}, {connections} connections: {rate:.0f}/s, {100 * refused:.0f} % refused, {1e3 * half:.1f} ms in the median, "
          f"{1e3 * high:.1f} ms at the 99th percentile, {1e6 * spent / max(count, 1):.0f} µs of processor time each", flush=True)
    check("Socket errors" not in told, f"{name}: every request is answered")
    return rate, refused, half, high


def busy(directory, queue_limit):
    """A service with its only worker busy, a finished job, and a script with which wrk submits."""
    service = Service(directory, "--workers", "1", "--queue-limit", str(queue_limit))
    path, _ = service.submit(SMALL)
    check(service.ended(path)["status"] == "succeeded", "a job has ended")
    running, _ = service.submit(ARTICLE | {"duration_s": 1000, "settle_s": 100, "solver": {"rung": "full"}})
    service.until(running, lambda job: job["status"] == "running")
    script = os.path.join(directory, "post.lua")
    with open(script, "w", encoding="utf-8") as file:
        file.write(LUA % json.dumps(SMALL))
    return service, path, script


with tempfile.TemporaryDirectory(prefix="raceway-check-") as directory:
    service, path, script = busy(directory, 1_000_000)
    try:
        for connections in (50, 500):
            check(load("a probe", service, "/health/live", connections)[1] == 0, "none is refused")
            for name, asked in (("a job's status", path), ("metrics", f"{path}/metrics")):
                rate, refused, *_ = load(name, service, asked, connections)
                check(refused == 0 and rate > 20, f"{name}: none is refused")
            rate, refused, *_ = load("a submission", service, "/v1/jobs", connections, script)
            check(refused == 0 and rate > 5, "submissions: each is stored")
        # More requests than are processed at a time. The others are refused soon.
        _, refused, _, high = load("a job's status", service, path, 900)
        check(high < 20, "responses beyond the limit arrive soon, too")
        probe = time.perf_counter()
        check(service.request("GET", "/health/ready")[0] == 200, f"ready again {1e3 * (time.perf_counter() - probe):.1f} ms later")
        counted = service.request("GET", "/metrics")[2].decode()
        waiting = int(re.search(r"^raceway_jobs_waiting (\d+)$", counted, re.MULTILINE)[1])
        check(waiting > 10, f"{waiting} jobs wait")
    finally:
        service.stop()

with tempfile.TemporaryDirectory(prefix="raceway-check-") as directory:
    service, path, script = busy(directory, 2)
    try:
        service.submit(SMALL)
        for connections in (50, 500):
            rate, refused, _, high = load("a submission to a full queue", service, "/v1/jobs", connections, script)
            check(refused == 1 and rate > 20 and high < 20, "a full queue: each is refused soon")
        status, headers, problem = service.request("POST", "/v1/jobs", SMALL)
        check((status, headers["Retry-After"]) == (429, "5") and problem["type"].endswith(":queue-full"), "a full queue is answered with 429 and Retry-After")
    finally:
        service.stop()
