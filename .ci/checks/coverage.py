#!/usr/bin/env python3
"""Stated errors of 12 drawn jobs cover their distance from stored references by another method."""

import os
import subprocess
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), os.pardir))
from service import ROOT, binary, check  # noqa: E402

PROGRAM = os.path.join(ROOT, "benches", "coverage", "coverage.py")
done = subprocess.run([sys.executable, PROGRAM, "check", "--binary", binary(), "--first", "12"], timeout=600, check=False)
check(done.returncode == 0, "numbers of drawn jobs are within three times their stated errors")
