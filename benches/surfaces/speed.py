#!/usr/bin/env python3
"""Speed of verified runs with imperfect surfaces: a 6205 at 1797 r/min under 500 N, 1 s.

Usage: python3 benches/surfaces/speed.py --binary BINARY [--runs 5]

For each scene and for vibration alone or all metrics: simulated time, settling included, over processor time of `raceway simulate`,
verification included. Median, least and most of the runs, which take turns over the scenes. Beside it the chosen model level, the level along y
with its stated error, and warnings.

Only the standard library is needed.
"""

import argparse
import json
import os
import resource
import statistics
import subprocess

SYMMETRIC = {"cage": {"seat": "closed", "offset_mm": 0}}
WAVES = {raceway: {"random_waviness": {"amplitude_nm": 5, "at_order": 10, "from_order": 1, "to_order": 64}} for raceway in ("inner", "outer")}
WAVES["every_ball"] = {"random_waviness": {"amplitude_nm": 2, "at_order": 10, "from_order": 2, "to_order": 64}}
RACEWAYS = {raceway: WAVES[raceway] for raceway in ("inner", "outer")}


def spall(depth):
    return {"outer": {"defects": [{"length_mm": 1, "depth_um": depth}]}}


SCENES = {
    "ideal": ({}, None, None),
    "waves of the raceways, symmetric cage": (SYMMETRIC, RACEWAYS, None),
    "waves of the raceways": ({}, RACEWAYS, None),
    "waves of raceways and balls, symmetric cage": (SYMMETRIC, WAVES, None),
    "waves of raceways and balls": ({}, WAVES, None),
    "spall 1 mm x 3 um, symmetric cage": (SYMMETRIC, spall(3), None),
    "spall 1 mm x 3 um": ({}, spall(3), None),
    "spall 1 mm x 50 um, `full` asked for": ({}, spall(50), "full"),
}


def job(scene, metrics):
    bearing, surfaces, rung = SCENES[scene]
    made = {"kind": "simulation", "duration_s": 1, "scene": {
        "bearing": {"preset": "6205", **bearing}, "operation": {"speed_rpm": 1797, "radial_load_y_n": 500}}}
    if surfaces:
        made["scene"]["surfaces"] = surfaces
    if rung:
        made["solver"] = {"rung": rung}
    if metrics:
        made["outputs"] = {"metrics": metrics}
    return made


def timed(binary, request):
    """Times real time, and the answer."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    done = subprocess.run([binary, "simulate", "-", "--quiet"], input=json.dumps(request), text=True, capture_output=True, check=True)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    answer = json.loads(done.stdout)
    cpu = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    return answer["solver"]["simulated_time_s"] / cpu, answer


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--binary", required=True)
    parser.add_argument("--runs", type=int, default=5)
    options = parser.parse_args()
    binary = os.path.abspath(options.binary)
    cases = [(scene, metrics) for scene in SCENES for metrics in (("vibration",), None)]
    speeds, answers = {case: [] for case in cases}, {}
    for _ in range(options.runs):
        for case in cases:
            speed, answers[case] = timed(binary, job(*case))
            speeds[case].append(speed)
    print("| scene | metrics | × real time: median (range) | level | a_y [dB] | stated error [dB] | warnings |")
    print("|---|---|---|---|---|---|---|")
    for case in cases:
        scene, metrics = case
        answer, found = answers[case], speeds[case]
        of_y = answer["channels"]["spindle.y.acceleration"]
        warnings = [message["code"] for message in answer["messages"] if message["severity"] != "info"]
        error = of_y.get("level_error_db")
        print(f"| {scene} | {'vibration' if metrics else 'all'} | {statistics.median(found):.2f} ({min(found):.2f}–{max(found):.2f}) "
              f"| `{answer['solver']['rung']}` | {of_y['level_db']:.2f} | {'–' if error is None else f'{error:.3f}'} | {', '.join(warnings)} |")


if __name__ == "__main__":
    main()
