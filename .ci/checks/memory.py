#!/usr/bin/env python3
"""The memory of a run does not grow with its duration, because samples outside a requested series are dropped every second."""

import json
import os
import subprocess
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), os.pardir))
from service import ARTICLE, binary, check, clean_environment  # noqa: E402

MOST = 64.0
SECONDS = 20

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
