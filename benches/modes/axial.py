#!/usr/bin/env python3
"""Axial natural frequency of a shaft on two preloaded angular-contact bearings over speed: linear analysis beside the full dynamics.

Usage: python3 benches/modes/axial.py --binary BINARY [--angle 15] [--rpm 3000 6000 …]

A bar of 300 × 40 mm on two 7008, rigidly preloaded against each other by 200 N, without weight. The `rotor` analysis gives the axial natural
frequency and the axial stiffness of a bearing. A `machine` on the level `full` rings after a light shock along the axis. Its period is
the median between upward zero crossings of the acceleration. Only the standard library is needed.
"""

import argparse
import csv
import json
import os
import statistics
import subprocess
import tempfile

SHOCK_AT_S, SETTLE_S, DURATION_S = 0.199, 0.2, 0.012


def scene(rpm, angle):
    bearing = {"type": "angular_contact", "outer_diameter_mm": 68, "inner_diameter_mm": 40, "width_mm": 15, "ball_count": 17,
               "ball_diameter_mm": 7.938, "pitch_diameter_mm": 54, "contact_angle_deg": angle}
    return {"shaft": {"sections": [{"length_mm": 300, "outer_diameter_mm": 40}], "axial": "free"},
            "bearings": [{"name": "A", "bearing": bearing, "at_mm": 60, "faces": "+x"},
                         {"name": "B", "bearing": bearing, "at_mm": 240, "faces": "-x"}],
            "preloads": [{"between": ["A", "B"], "force_n": 200}], "gravity_m_s2": 0, "operation": {"speed_rpm": rpm}}


def run(binary, job, *arguments):
    done = subprocess.run([binary, "simulate", "--quiet", *arguments, "-"], input=json.dumps(job), capture_output=True, text=True,
                          check=True)
    return json.loads(done.stdout)


def linear(binary, rpm, angle):
    """Axial natural frequency [Hz] and axial stiffness of the first bearing [N/µm]."""
    answer = run(binary, {"kind": "rotor", "scene": scene(rpm, angle), "speeds_rpm": [rpm]})
    axial = [mode["frequency_hz"] for mode in answer["operating"]["modes"] if mode["whirl"] == "axial"]
    return axial[0], answer["bearings"][0]["stiffness"][0][0] * 1e-6


def ringing(binary, rpm, angle):
    """Frequency of the free axial vibration [Hz]."""
    shocked = scene(rpm, angle)
    shocked["operation"]["loads"] = [{"direction": "x", "shock": {"peak_n": 5, "at_s": SHOCK_AT_S, "duration_s": 0.0005}}]
    job = {"kind": "machine", "scene": shocked, "settle_s": SETTLE_S, "duration_s": DURATION_S, "solver": {"rung": "full"},
           "outputs": {"series": ["A.x.acceleration"]}}
    with tempfile.TemporaryDirectory() as folder:
        run(binary, job, "--output", folder)
        with open(os.path.join(folder, "series.A.x.acceleration.csv"), encoding="utf-8", newline="") as file:
            rows = [(float(row[0]), float(row[1])) for row in csv.reader(file) if row and row[0][:1].isdigit()]
    crossings = [before - (after - before) * one / (other - one)
                 for (before, one), (after, other) in zip(rows, rows[1:]) if one < 0.0 <= other]
    return 1.0 / statistics.median(after - before for before, after in zip(crossings, crossings[1:]))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--binary", required=True)
    parser.add_argument("--angle", type=float, default=15.0, help="free contact angle [°]")
    parser.add_argument("--rpm", type=float, nargs="+", default=[3000.0, 6000.0, 9000.0, 12000.0, 15000.0, 18000.0])
    asked = parser.parse_args()
    print("| speed [r/min] | stiffness of a bearing [N/µm] | `rotor` [Hz] | `machine` [Hz] | difference |\n|---|---|---|---|---|")
    for rpm in asked.rpm:
        frequency, stiffness = linear(asked.binary, rpm, asked.angle)
        rings = ringing(asked.binary, rpm, asked.angle)
        print(f"| {rpm:g} | {stiffness:.2f} | {frequency:.1f} | {rings:.1f} | {100.0 * (frequency / rings - 1.0):+.1f} % |", flush=True)


if __name__ == "__main__":
    main()
