#!/usr/bin/env python3
"""Growth of the whirl of a rigid spindle on two close bearings: of a machine in time, with and without traction, beside the linear analysis.

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

BEARINGS = [{"name": "A", "bearing": "7008C", "at_mm": 0, "faces": "+x"}, {"name": "B", "bearing": "7008C", "at_mm": 15, "faces": "-x"}]
NO_TRACTION = {"kind": "grease", "traction": {"maximum": 0, "limit": 0}}
PARTS = 10


def scene(speed_rpm, lubricant):
    bearings = [bearing | ({"lubricant": lubricant} if lubricant else {}) for bearing in BEARINGS]
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
        modes = answer(binary, {"kind": "rotor", "scene": scene(speed_rpm, None)})["operating"]["modes"]
        whirl = [mode for mode in modes if mode.get("whirl") == "forward"][0]
        linear = -whirl["damping_ratio"] * 2 * math.pi * whirl["frequency_hz"]
        found = {name: growth(binary, {"kind": "machine", "scene": scene(speed_rpm, lubricant), "duration_s": 0.5, "settle_s": 0, "step_us": 5.5,
                                       "outputs": {"series": ["A.tilt.y"]}})
                 for name, lubricant in (("default traction", None), ("no traction", NO_TRACTION))}
        print(f"| {speed_rpm} | {whirl['frequency_hz']:.0f} | {linear:.1f} | " + " | ".join(f"{value:.1f}" for value in found.values()) + " |", flush=True)


if __name__ == "__main__":
    main()
