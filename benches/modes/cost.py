#!/usr/bin/env python3
"""Instructions of a step of machines: more bearings, and modes of a shaft, against one bearing on a rigid spindle, on model levels of bearings.

Usage: python3 benches/modes/cost.py --binary BINARY [--csv FILE]

All bearings are a 6205, at 6000 r/min under 500 N: on `full` in steps of 5.5 µs, on `radially_condensed` and `spindle_only` in steps of 11 µs. A step is one
evaluation of every bearing, with recording. What a run needs before its first step is left out, and so are repetitions: the difference of records of 0.2 and 0.1 s, both repeated over 0.1 s. Instructions are counted, because processor time of the same run may scatter by
half. A run with AVX-512 takes fewer than this count, which is that of AVX2. Beside the cost stands the largest deviation of a level from `full`.

Needs valgrind, and a quarter of an hour.
"""

import argparse
import csv
import json
import os
import re
import subprocess

SHAFT = {"sections": [{"length_mm": 300, "outer_diameter_mm": 25}],
         "discs": [{"at_mm": 150, "mass_kg": 1.2, "transverse_inertia_kg_m2": 8e-4, "axial_inertia_kg_m2": 1.5e-3}]}
SUPPORT = {"at_mm": 260, "stiffness_n_per_um": [0, 50, 50], "damping_n_s_per_m": [0, 200, 200]}


def machine(places, shaft):
    """A scene with bearings at these places."""
    bearings = [{"name": f"B{index}", "bearing": "6205", "at_mm": at, "faces": "-x" if index % 2 else "+x"} for index, at in enumerate(places)]
    scene = {"bearings": bearings, "operation": {"speed_rpm": 6000, "radial_load_y_n": 500}}
    if shaft:
        return scene | {"shaft": SHAFT} | ({"supports": [SUPPORT]} if len(places) == 1 else {})
    return scene | {"spindle": {"mass_kg": 1.2, "centre_mm": 150, "tilt": "free" if len(places) > 1 else "held"}}


EIGHT = [15, 45, 75, 105, 195, 225, 255, 285]
MACHINES = {
    "one bearing, rigid spindle": machine([150], False),
    "two bearings, rigid spindle": machine([40, 260], False),
    "eight bearings, rigid spindle": machine(EIGHT, False),
    "one bearing and a support, flexible shaft": machine([40], True),
    "two bearings, flexible shaft": machine([40, 260], True),
    "eight bearings, flexible shaft": machine(EIGHT, True),
}


# Steps of each level [µs].
# Without `planar`, which has an instruction that valgrind 3.19 does not know.
LEVELS = {"full": 5.5, "radially_condensed": 11, "spindle_only": 11}
# Shorter and longer record [s].
RECORDS_S = (0.1, 0.2)


def counted(binary, scene, level, duration):
    """Instructions of a run, and its answer."""
    job = {"kind": "machine", "scene": scene, "duration_s": duration, "settle_s": 0.01, "step_us": LEVELS[level]}
    if level != "full":
        job["solver"] = {"rung": level}
    command = ["valgrind", "--tool=callgrind", "--callgrind-out-file=/dev/null", binary, "simulate", "-", "--quiet"]
    done = subprocess.run(command, input=json.dumps(job), text=True, capture_output=True, check=True)
    return int(re.search(r"Collected : (\d+)", done.stderr).group(1)), json.loads(done.stdout)


def cost(binary, scene, level):
    """Instructions of a step, coordinates of the frame, and largest deviation of a level from `full` [dB]."""
    (short, _), (long, answer) = (counted(binary, scene, level, duration) for duration in RECORDS_S)
    steps = (RECORDS_S[1] - RECORDS_S[0]) / (LEVELS[level] * 1e-6)
    errors = answer["accuracy"].get("model_errors_db", {})
    return (long - short) / steps, answer["model"]["coordinates"], max(errors.values(), default=0.0)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--binary", required=True)
    parser.add_argument("--csv")
    options = parser.parse_args()
    binary = os.path.abspath(options.binary)
    # Eight bearings only where the goal names them: a run takes minutes.
    cases = [(name, level) for name in MACHINES for level in LEVELS if not name.startswith("eight") or level == "full"]
    found = {}
    rows = []
    for name, level in cases:
        step, coordinates, error = found[name, level] = cost(binary, MACHINES[name], level)
        first = found[cases[0]][0]
        of_level = found[cases[0][0], level][0]
        rows.append([name, level, coordinates, round(step), f"{step / first:.2f}", f"{step / of_level:.2f}", f"{error:.3f}"])
        print("| " + " | ".join(map(str, rows[-1])) + " |", flush=True)
    if options.csv:
        fields = ["machine", "level", "coordinates", "instructions", "ratio", "ratio_on_level", "error_db"]
        with open(options.csv, "w", encoding="utf-8", newline="") as file:
            csv.writer(file, lineterminator="\n").writerows([fields, *rows])


if __name__ == "__main__":
    main()
