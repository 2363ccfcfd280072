#!/usr/bin/env python3
"""Prints time and memory of the article's case and memory of an idle server beside their goals. It does not fail on them."""

import json
import os
import re
import subprocess
import sys
import time

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), os.pardir))
from service import ARTICLE, binary, check, clean_environment, service  # noqa: E402

GOALS = {"wall time of 0.12 s of the article's case": (5.0, "s"), "its peak memory": (100.0, "MB"),
         "memory of an idle server": (40.0, "MB")}


def told(what, value):
    goal, unit = GOALS[what]
    print(f"bench: {what}: {value:.2f} {unit}, {value / goal:.2f} of the goal of {goal:g} {unit}")


for rung, solver_input in (("as chosen", {}), ("full", {"rung": "full"})):
    job = json.dumps(ARTICLE | {"settle_s": 0.02, "duration_s": 0.1, "solver": solver_input})
    done = subprocess.run(["/usr/bin/time", "-v", binary(), "simulate", "-"], input=job, capture_output=True, text=True,
                          timeout=300, env=clean_environment())
    check(done.returncode == 0, f"the article's case runs, rung {rung}")
    solver = json.loads(done.stdout)["solver"]
    elapsed = re.search(r"Elapsed.*: (?:(\d+):)?(\d+):([\d.]+)", done.stderr)
    hours, minutes, seconds = elapsed.groups()
    told("wall time of 0.12 s of the article's case", 3600 * int(hours or 0) + 60 * int(minutes) + float(seconds))
    told("its peak memory", int(re.search(r"Maximum resident set size.*: (\d+)", done.stderr).group(1)) / 1024)
    print(f"bench: rung {solver['rung']}, {solver['steps']} steps, {solver['rhs_evaluations']} evaluations, "
          f"{solver['real_time_factor']:.2f} x real time with its check, {solver['states']} states")
with service() as running:
    time.sleep(1)
    with open(f"/proc/{running.process.pid}/status", encoding="ascii") as status:
        told("memory of an idle server", int(re.search(r"VmRSS:\s+(\d+)", status.read()).group(1)) / 1024)
