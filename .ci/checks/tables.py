#!/usr/bin/env python3
"""The short tables of the documents are those of their data files."""

import pathlib
import subprocess
import sys

TABLES = pathlib.Path(__file__).resolve().parents[2] / "docs" / "data" / "tables.py"

sys.exit(subprocess.run([sys.executable, TABLES, "--check"]).returncode)
