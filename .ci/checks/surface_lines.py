#!/usr/bin/env python3
"""Each source of `benches/surfaces/lines.py` has its lines, and no other, on one scene and the leanest level that carries it."""

import os
import subprocess
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), os.pardir))
from service import ROOT, binary, check  # noqa: E402

program = [sys.executable, os.path.join(ROOT, "benches", "surfaces", "lines.py"), "--binary", binary(), "--short"]
check(subprocess.run(program, timeout=300, check=False).returncode == 0, "every source has its lines and no other")
