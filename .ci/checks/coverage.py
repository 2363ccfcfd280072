#!/usr/bin/env python3
"""Stated errors of 12 drawn jobs cover their distance from stored references by another method."""

import os
import subprocess
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), os.pardir))
from service import ROOT, binary, check  # noqa: E402

FOLDER = os.path.join(ROOT, "benches", "coverage")
sys.path.insert(0, FOLDER)
import coverage  # noqa: E402
import scenes  # noqa: E402

check(scenes.job(1, 7) == scenes.job(1, 7) != scenes.job(1, 8), "a job depends on its seed and index alone")
# Off [dB], stated error, own error of the reference.
for expected, *case in (("stated", 0.1, 0.1, 0.0), ("thrice", 0.29, 0.1, 0.0), ("miss", 0.31, 0.1, 0.0),
                        ("miss", 0.5, 0.1, 0.19), ("unknown", 0.5, 0.1, 0.21), ("minute", 0.0019, 1e-5, 0.0)):
    check(coverage.verdict(*case, coverage.minute("level y", 40.0)) == expected, f"verdict {expected} on {case}")
program = [sys.executable, os.path.join(FOLDER, "coverage.py"), "check", "--binary", binary(), "--first", "12"]
done = subprocess.run(program, timeout=600, check=False)
check(done.returncode == 0, "numbers of drawn jobs are within three times their stated errors")
