#!/usr/bin/env python3
"""The commands of the tutorial of a spindle, run in order against a service; each prints what stands below it."""

import os
import re
import shutil
import subprocess
import sys
import tempfile
import xml.etree.ElementTree

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), os.pardir))
from service import ROOT, check, service  # noqa: E402

# Relative deviation of a printed number that another compiler or a refinement of the model may have.
TOLERANCE = 0.02
NUMBER = re.compile(r"-?\d+(?:\.\d+)?")


def alike(printed, stated):
    """Whether two texts have the same words, and numbers within the tolerance or one unit of the last digit."""
    if NUMBER.sub("#", printed) != NUMBER.sub("#", stated):
        return False
    pairs = zip(NUMBER.findall(printed), NUMBER.findall(stated), strict=True)
    unit = [(float(one), float(other), 10.0 ** -len(other.partition(".")[2])) for one, other in pairs]
    return all(abs(one - other) <= max(TOLERANCE * abs(other), step) for one, other, step in unit)


check(shutil.which("jq") is not None, "jq is installed")
with open(os.path.join(ROOT, "docs", "tutorial-spindle.md"), encoding="utf-8") as tutorial:
    blocks = re.findall(r"```(sh|text)\n(.*?)```", tutorial.read(), re.DOTALL)
check(blocks[0] == ("sh", "cargo run --release -- serve\n"), "the first command starts a service")
with service() as running, tempfile.TemporaryDirectory() as directory:
    stated, parts = [], []
    for language, text in blocks[1:]:
        if language == "text":
            stated[-1] = text
        else:
            stated.append("")
            parts.append(text.replace("http://127.0.0.1:8080", running.url))
    # One shell, because later blocks use variables of earlier ones; a mark separates what each block prints.
    script = "".join(f"{part}\necho '--- end of block'\n" for part in parts)
    done = subprocess.run(["bash", "-euo", "pipefail", "-c", script], cwd=directory, stdin=subprocess.DEVNULL,
                          capture_output=True, text=True, timeout=600)
    check(done.returncode == 0, f"the commands end well {done.stderr}")
    printed = done.stdout.split("--- end of block\n")[:-1]
    for part, found, text in zip(parts, printed, stated, strict=True):
        check(alike(found, text), f"{part.strip().splitlines()[-1][:60]} prints {found.split(chr(10))[:-1]}, stated {text.split(chr(10))[:-1]}")
    for name, words in (("campbell.svg", ["forward", "backward", "1×"]), ("shapes.svg", ["747.", "forward"]),
                        ("spectrum.svg", ["BPFO@A"]), ("envelope.svg", ["BPFO@A"]), ("housing-spectrum.svg", ["sensor.acc", "BPFO@A"])):
        texts = "".join(xml.etree.ElementTree.parse(os.path.join(directory, name)).getroot().itertext())
        check(all(word in texts for word in words), f"{name} shows {', '.join(words)}")
