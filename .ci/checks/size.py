#!/usr/bin/env python3
"""Disk space of finished jobs with default outputs, and response time of a page of their list."""

import os
import statistics
import sys
import tempfile
import time

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), os.pardir))
from service import ARTICLE, Service, check  # noqa: E402

JOBS = int(os.environ.get("JOBS", "200"))
# Largest disk space of a job [bytes].
PROMISED = 70_000

with tempfile.TemporaryDirectory(prefix="raceway-check-") as directory:
    service = Service(directory)
    try:
        def job(number):
            scene = {**ARTICLE["scene"], "operation": {"speed_rpm": 50000, "radial_load_y_n": 150 + 0.1 * number}}
            return {**ARTICLE, "scene": scene, "labels": ["size"]}

        for begin in range(0, JOBS, 100):
            status, _, answer = service.request("POST", "/v1/jobs/batch", {"jobs": [job(n) for n in range(begin, min(JOBS, begin + 100))]})
            check(status == 200 and all(item["status"] == 202 for item in answer["answers"]), f"jobs from {begin} on are accepted")
        last = answer["answers"][-1]["job"]["links"]["self"]
        while service.request("GET", "/v1/jobs?status=queued&limit=1")[2]["jobs"] or service.request("GET", "/v1/jobs?status=running&limit=1")[2]["jobs"]:
            time.sleep(0.5)
        took = []
        for _ in range(20):
            begin = time.perf_counter()
            status, _, page = service.request("GET", "/v1/jobs?limit=50")
            took.append(time.perf_counter() - begin)
        check(status == 200 and len(page["jobs"]) == 50, "a page is listed")
        print(f"a page of 50 jobs: {1e3 * statistics.median(took):.1f} ms in the median, {1e3 * max(took):.1f} ms at most")
    finally:
        # The stop moves the write-ahead log into the database.
        service.stop()
    size = sum(os.path.getsize(os.path.join(directory, name)) for name in os.listdir(directory) if ".db" in name)
    print(f"{JOBS} jobs take {size / 1e6:.1f} MB: {size / JOBS / 1e3:.1f} kB a job")
    check(size / JOBS < PROMISED, "a job takes less than 70 kB")
