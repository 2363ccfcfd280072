#!/usr/bin/env python3
"""Scenes at the limits of the input, as jobs of the service. Each is refused with the name of the field, ends with finite numbers, or
fails with a cause and advice. None stops the service or exceeds the time limit of a worker."""

import json
import os
import sys
import tempfile

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), os.pardir))
from service import ROOT, Service, check  # noqa: E402

TIME_LIMIT_S = 5
CAUSES = {"did-not-converge", "numerical-blowup", "spindle-left-bearing", "time-limit"}


def merged(base, changes):
    """`base` with the fields of `changes`, merged object by object."""
    if not (isinstance(base, dict) and isinstance(changes, dict)):
        return changes
    return {**base, **{name: merged(base.get(name), change) for name, change in changes.items()}}


def finite(answer):
    """Whether the answer has no null, which is written in place of a number that is not finite."""
    if isinstance(answer, dict):
        return all(finite(value) for value in answer.values())
    return all(finite(value) for value in answer) if isinstance(answer, list) else answer is not None


with open(os.path.join(ROOT, "benches", "scenes", "extreme.json"), encoding="utf-8") as file:
    cases = json.load(file)
article = {"bearing": {"preset": "article-integrated"}, "operation": {"speed_rpm": 50000, "radial_load_y_n": 200}}

with tempfile.TemporaryDirectory(prefix="raceway-check-") as directory:
    service = Service(directory, "--time-limit-s", str(TIME_LIMIT_S))
    jobs, ends = {}, {}
    for case in cases:
        job = {"kind": "simulation", "scene": merged(article, case["changes"]), "labels": [case["name"]]}
        job |= {name: case[name] for name in ("settle_s", "duration_s")}
        status, headers, answer = service.request("POST", "/v1/jobs", job)
        if status == 202:
            jobs[case["name"]] = headers["Location"]
        else:
            pointers = [error["pointer"] for error in answer["errors"]]
            check(status == 422 and pointers, f"{case['name']}: refused by {', '.join(pointers)}")
            ends["refused"] = ends.get("refused", 0) + 1
    for name, path in jobs.items():
        ended = service.ended(path, at_most=TIME_LIMIT_S * len(jobs))
        if ended["status"] == "succeeded":
            if not finite(service.request("GET", f"{path}/metrics")[2]):
                check(False, f"{name}: all its numbers are finite")
        else:
            error = ended["error"] or {}
            cause = error.get("type", "").rsplit(":", 1)[-1]
            check(ended["status"] == "failed" and cause in CAUSES and error["detail"], f"{name}: {cause}: {error['detail']}")
        ends[ended["status"]] = ends.get(ended["status"], 0) + 1
    check(service.request("GET", "/health/ready")[0] == 200, f"the service is ready after {len(cases)} extreme scenes: {ends}")
    service.stop()
