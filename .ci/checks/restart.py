#!/usr/bin/env python3
"""SIGKILL during a job. After a restart this job and the waiting job succeed, each once."""

import os
import sys
import tempfile

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), os.pardir))
from service import ARTICLE, Service, check  # noqa: E402

# A job of some seconds, so that the kill interrupts it on a fast machine, too.
LONG = ARTICLE | {"duration_s": 10, "solver": {"rung": "full"}}

with tempfile.TemporaryDirectory(prefix="raceway-check-") as directory:
    first = Service(directory, "--workers", "1")
    long, _ = first.submit(LONG | {"labels": ["killed"]})
    waiting, _ = first.submit(ARTICLE | {"duration_s": 0.02, "labels": ["waiting"]})
    job = first.until(long, lambda job: job["progress"] > 0.05)
    check(job["status"] == "running", f"the job runs ({100 * job['progress']:.0f} % done)")
    check(first.request("GET", waiting)[2]["status"] == "queued", "the other one waits")
    first.kill()
    check(True, "the process is killed")

    second = Service(directory, "--workers", "1")
    try:
        check(second.url != "", "the service starts again on the same database")
        job = second.ended(long)
        check(job["status"] == "succeeded" and job["error"] is None, "the killed job has succeeded")
        check(second.ended(waiting)["status"] == "succeeded", "the waiting job has succeeded")
        jobs = second.request("GET", "/v1/jobs")[2]["jobs"]
        check(len(jobs) == 2, "there are two jobs, no more")
        metrics = second.request("GET", f"{long}/metrics")[2]
        check(metrics["channels"]["spindle.y.acceleration"]["level_db"] > 0, "its metrics are available")
        again = second.request("POST", "/v1/jobs", LONG)[2]
        check(again["status"] == "succeeded" and again["reused"], "its result is reused for the same job")
    finally:
        second.stop()
