#!/usr/bin/env python3
"""Processor time of a step of machines: more bearings, and modes of a shaft, against one bearing on a rigid spindle, on the model levels of bearings.

Usage: python3 benches/modes/cost.py --binary BINARY [--runs 5] [--csv FILE]

All bearings are a 6205, at 6000 r/min under 500 N: on `full` and `planar` in steps of 5.5 µs, on `radially_condensed` and `spindle_only` in steps of
11 µs. Runs take turns over
the machines; the ratio to the first machine is formed in each turn. A step is one evaluation of every bearing. What a run needs before its first
step is left out, and so are repetitions: the difference of a longer record and one of 0.1 s, both repeated over 0.1 s. Beside the cost of the
reduced level stands its largest deviation of a level from `full`.

Only the standard library is needed.
"""

import argparse
import csv
import json
import os
import resource
import statistics
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
LEVELS = {"full": 5.5, "planar": 5.5, "radially_condensed": 11, "spindle_only": 11}
# Shorter and longer record of each level [s]: repetitions are most of a run on the reduced one, so that its difference has to be longer.
RECORDS_S = {"full": (0.1, 0.5), "planar": (0.1, 0.5), "radially_condensed": (0.1, 2.1), "spindle_only": (0.1, 4.1)}


def timed(binary, scene, level, duration):
    """Processor time [s], and the answer."""
    job = {"kind": "machine", "scene": scene, "duration_s": duration, "settle_s": 0.3, "step_us": LEVELS[level]}
    if level != "full":
        job["solver"] = {"rung": level}
    before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
    done = subprocess.run([binary, "simulate", "-", "--quiet"], input=json.dumps(job), text=True, capture_output=True, check=True)
    return resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before, json.loads(done.stdout)


def cost(binary, scene, level):
    """Processor time of a step [µs], simulated over processor time, coordinates of the frame, and largest deviation of a level from `full` [dB]."""
    (short, less), (long, more) = (timed(binary, scene, level, duration) for duration in RECORDS_S[level])
    simulated = RECORDS_S[level][1] - RECORDS_S[level][0]
    errors = more["accuracy"].get("model_errors_db", {})
    step = (long - short) * LEVELS[level] / simulated
    return step, simulated / (long - short), more["model"]["coordinates"], max(errors.values(), default=0.0)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--binary", required=True)
    parser.add_argument("--runs", type=int, default=5)
    parser.add_argument("--csv")
    options = parser.parse_args()
    binary = os.path.abspath(options.binary)
    cases = [(name, level) for name in MACHINES for level in LEVELS]
    found = {case: [] for case in cases}
    for _ in range(options.runs):
        for name, level in cases:
            found[name, level].append(cost(binary, MACHINES[name], level))
    first = [step for step, *_ in found[cases[0]]]
    fields = ["machine", "level", "coordinates", "step_us", "ratio", "least_ratio", "most_ratio", "real_time", "error_db"]
    rows = []
    for (name, level), costs in found.items():
        steps, speeds, coordinates, errors = zip(*costs)
        ratios = [step / reference for step, reference in zip(steps, first)]
        row = (statistics.median(steps), statistics.median(ratios), min(ratios), max(ratios), statistics.median(speeds))
        rows.append([name, level, coordinates[0], *(f"{value:.2f}" for value in row), f"{max(errors):.3f}"])
    print("\n".join("| " + " | ".join(map(str, row)) + " |" for row in [fields, ["---"] * len(fields), *rows]))
    if options.csv:
        with open(options.csv, "w", encoding="utf-8", newline="") as file:
            csv.writer(file, lineterminator="\n").writerows([fields, *rows])


if __name__ == "__main__":
    main()
