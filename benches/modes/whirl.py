#!/usr/bin/env python3
"""Growth of the whirl of a rigid spindle on two close bearings beside the linear analysis: of a machine in time, with wide pockets of the cages, and
without traction.

Usage: python3 benches/modes/whirl.py --binary BINARY

Two 7008C 15 mm apart, preloaded by 150 N, hold 3 kg. The machine starts at its operating point; rounding excites its motions. The growth is the slope of
the logarithm of the tilt's rms over ten parts of 0.5 s.
"""

import argparse
import csv
import glob
import json
import math
import os
import subprocess
import tempfile

BEARINGS = [{"name": "A", "at_mm": 0, "faces": "+x"}, {"name": "B", "at_mm": 15, "faces": "-x"}]
WIDE_POCKETS = {"preset": "7008C", "cage": {"pocket_clearance_mm": 0.5}}
NO_TRACTION = {"kind": "grease", "traction": {"maximum": 0, "limit": 0}}
PARTS = 10


def scene(speed_rpm, lubricant=None, bearing="7008C"):
    bearings = [one | {"bearing": bearing} | ({"lubricant": lubricant} if lubricant else {}) for one in BEARINGS]
    return {"spindle": {"mass_kg": 3}, "bearings": bearings, "preloads": [{"between": ["A", "B"], "force_n": 150}],
            "operation": {"speed_rpm": speed_rpm}}


def answer(binary, job, *options):
    done = subprocess.run([binary, "simulate", "-", "--quiet", *options], input=json.dumps(job), text=True, capture_output=True, check=True)
    return json.loads(done.stdout)


def growth(binary, job):
    """Growth of the tilt in time [1/s]."""
    with tempfile.TemporaryDirectory() as directory:
        answer(binary, job, "--output", directory)
        [file] = glob.glob(os.path.join(directory, "*series*.csv"))
        with open(file, encoding="utf-8") as lines:
            rows = [(float(time), float(value)) for time, value in list(csv.reader(lines))[1:]]
    size = len(rows) // PARTS
    logarithms = []
    for part in range(PARTS):
        values = [value for _, value in rows[part * size:(part + 1) * size]]
        mean = sum(values) / size
        logarithms.append(0.5 * math.log(sum((value - mean) ** 2 for value in values) / size))
    step = size * (rows[1][0] - rows[0][0])
    middle = (PARTS - 1) / 2
    slope = sum((part - middle) * logarithm for part, logarithm in enumerate(logarithms))
    return slope / sum((part - middle) ** 2 for part in range(PARTS)) / step


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--binary", required=True)
    binary = os.path.abspath(parser.parse_args().binary)
    for speed_rpm in (10000, 20000):
        modes = answer(binary, {"kind": "rotor", "scene": scene(speed_rpm)})["operating"]["modes"]
        whirl = [mode for mode in modes if mode.get("whirl") == "forward"][0]
        linear = -whirl["damping_ratio"] * 2 * math.pi * whirl["frequency_hz"]
        machines = (scene(speed_rpm), scene(speed_rpm, bearing=WIDE_POCKETS), scene(speed_rpm, lubricant=NO_TRACTION))
        found = [growth(binary, {"kind": "machine", "scene": one, "duration_s": 0.5, "settle_s": 0, "step_us": 5.5,
                                 "outputs": {"series": ["A.tilt.y"]}}) for one in machines]
        print(f"| {speed_rpm} | {whirl['frequency_hz']:.0f} | {linear:.1f} | " + " | ".join(f"{value:.1f}" for value in found) + " |", flush=True)


if __name__ == "__main__":
    main()
