#!/usr/bin/env python3
"""The finite elements of verification/pocket on their coarsest mesh give the stored results, and the pocket law agrees with them."""

import pathlib
import subprocess
import sys

FOLDER = pathlib.Path(__file__).resolve().parents[2] / "verification" / "pocket"
sys.exit(subprocess.run([sys.executable, "-B", FOLDER / "pocket.py", "quick"], timeout=300).returncode)
