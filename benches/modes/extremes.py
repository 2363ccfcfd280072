#!/usr/bin/env python3
"""Extreme shafts: does each end in a right answer, in a warning or in a refusal that names the cause?

Usage: python3 benches/modes/extremes.py --binary BINARY [--csv FILE]

Each machine runs as sent, then again with a quarter of its step and modes up to three times the band, after the same settling.

  confirmed   no level differs by more than three times its stated error plus 0.01 dB
  warning     a level does, and a message of severity `warning` says that the result is not resolved
  refused     the request is answered with the name of a field
  failed      the run ends with a cause
  WRONG       none of these

Only the standard library is needed. Takes some ten minutes.
"""

import argparse
import copy
import csv
import json
import os
import resource
import subprocess

BAR = {
    "shaft": {"sections": [{"length_mm": 300, "outer_diameter_mm": 25}],
              "discs": [{"at_mm": 150, "mass_kg": 1.2, "transverse_inertia_kg_m2": 8e-4, "axial_inertia_kg_m2": 1.5e-3}],
              "unbalances": [{"at_mm": 150, "unbalance_g_mm": 5}]},
    "bearings": [{"name": "A", "bearing": "6205", "at_mm": 40}, {"name": "B", "bearing": "6205", "at_mm": 260, "faces": "-x"}],
    "operation": {"speed_rpm": 6000, "radial_load_y_n": 500},
}
HEAD = {"bodies": [{"name": "head", "mass_kg": 8, "at_mm": 150, "inertia_kg_m2": [0.02, 0.05, 0.05]}],
        "mounts": [{"body": "head", "at_mm": 150, "stiffness_n_per_um": [50, 50, 50], "damping_n_s_per_m": [300, 300, 300],
                    "tilt_n_m_per_mrad": [20, 20]}]}
SPINDLE = {
    "shaft": {"sections": [{"length_mm": 300, "outer_diameter_mm": 40}], "axial": "free"},
    "bearings": [{"name": "A", "bearing": "7008C", "at_mm": 60, "faces": "+x"}, {"name": "B", "bearing": "7008C", "at_mm": 240, "faces": "-x"}],
    "operation": {"speed_rpm": 30000, "radial_load_y_n": 50},
}


def changed(scene, **fields):
    """A copy with other values; `a__b` stands for `a.b`, numbers for places of lists."""
    scene = copy.deepcopy(scene)
    for path, value in fields.items():
        *path, last = path.split("__")
        place = scene
        for key in path:
            place = place[int(key)] if key.isdigit() else place.setdefault(key, {})
        place[int(last) if last.isdigit() else last] = value
    return scene


def in_seats(stiffness, **fields):
    seat = {"seat": "elastic", "stiffness_n_per_um": [stiffness, stiffness], "on": "head", **fields}
    return changed(BAR, housing=HEAD, bearings__0__outer_ring=seat, bearings__1__outer_ring=seat)


def on_body(mass):
    housing = changed(HEAD, bodies__0__mass_kg=mass, bodies__0__inertia_kg_m2=[1e-3 * mass] * 3)
    ring = {"seat": "rigid", "on": "head"}
    return changed(BAR, housing=housing, bearings__0__outer_ring=ring, bearings__1__outer_ring=ring)


SHOCK = {"at_mm": 150, "direction": "y", "shock": {"peak_n": 490.0, "at_s": 0.31, "duration_s": 0.001}}
EIGHT = [{"name": "ABCDEFGH"[k], "bearing": "6205", "at_mm": at, "faces": "-x" if k % 2 else "+x"}
         for k, at in enumerate((15, 45, 75, 105, 195, 225, 255, 285))]
SCENES = {
    "seats of 10⁶ N/µm": in_seats(1e6),
    "seats of 10⁶ N/µm without damping": in_seats(1e6, damping_n_s_per_m=[0, 0], tilt_damping_n_m_s_per_rad=0),
    # Twice the rate of steps of 5.5 µs: 363 kHz.
    "undamped seats at a multiple of the rate of steps": in_seats(
        3e5, mass_kg=0.06, damping_n_s_per_m=[0, 0], tilt_damping_n_m_s_per_rad=0),
    "seats of 0.1 N/µm": in_seats(0.1),
    "body without mass": on_body(0.0),
    "body of 1 mg": on_body(1e-6),
    "body of 0.1 g": on_body(1e-4),
    "body of 1 g": on_body(1e-3),
    "disc of 100 kg on a shaft of 5 mm": changed(
        BAR, shaft__sections__0__outer_diameter_mm=5, shaft__discs__0__mass_kg=100, bearings__0__bearing="625", bearings__1__bearing="625",
        operation__radial_load_y_n=0),
    "bore of 0.98 of the diameter": changed(BAR, shaft__sections__0__inner_diameter_mm=24.5),
    "rotating damping above its threshold": changed(
        BAR, shaft__damping_ratio=0.05, shaft__rotating_share=1, operation__speed_rpm=60000, operation__radial_load_y_n=100,
        preloads=[{"between": ["A", "B"], "force_n": 200}]),
    "rigid preload of 20 N at 30 000 r/min": changed(SPINDLE, preloads=[{"between": ["A", "B"], "force_n": 20}]),
    "400 000 r/min": changed(BAR, operation__speed_rpm=400000),
    "500 000 r/min": changed(BAR, operation__speed_rpm=500000),
    "outer rings at 500 000 r/min": changed(BAR, operation__speed_rpm=0, operation__outer_speed_rpm=500000),
    "no rotation": changed(BAR, operation__speed_rpm=0),
    "eight bearings": changed(BAR, bearings=EIGHT),
    "shock of 490 N on a shaft in a body of 0.5 kg": changed(on_body(0.5), operation__loads=[SHOCK]),
    "unbalance of 2 kg mm": changed(BAR, shaft__unbalances__0__unbalance_g_mm=2000),
    # Both have 445 Hz at this speed.
    "axial and forward mode that cross": changed(
        BAR, shaft__axial="free", shaft__discs__0={"at_mm": 290, "mass_kg": 3, "transverse_inertia_kg_m2": 6e-3, "axial_inertia_kg_m2": 1.1e-2},
        shaft__unbalances__0__at_mm=290, preloads=[{"between": ["A", "B"], "force_n": 200}], operation__radial_load_y_n=0,
        operation__speed_rpm=7500),
}


# Shortest step of a request.
SHORTEST_US = 0.1


def run(binary, scene, **fields):
    """Exit status, answer, processor time [s]."""
    job = {"kind": "machine", "scene": scene, "duration_s": 0.1, "settle_s": 0.3, **fields}
    before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
    done = subprocess.run([binary, "simulate", "-", "--quiet"], input=json.dumps(job), text=True, capture_output=True, check=False)
    took = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before
    text = done.stdout if done.returncode == 0 else done.stderr
    try:
        return done.returncode, json.loads(text), took
    except json.JSONDecodeError:
        return done.returncode, {"detail": text.strip() or done.stdout.strip()}, took


def judged(binary, scene):
    status, answer, took = run(binary, scene)
    if status:
        verdict = "refused" if answer.get("errors") else "failed"
        cause = " ".join(answer.get("detail", "").split())
        return [verdict if cause else "WRONG", "", "", "", f"{took:.1f}", cause]
    model = answer["model"]
    stated = answer["accuracy"]["level_errors_db"]
    status, finer, _ = run(binary, scene, step_us=max(SHORTEST_US, float(f"{model['step_us'] / 4:.4g}")), mode_range=3)
    if status:
        return ["WRONG", "", "", f"{model['step_us']:.3g}", f"{took:.1f}", "the reference: " + finer.get("detail", "")]
    level = lambda of, name: of["channels"][name]["level_db"]
    off = {name: abs(level(answer, name) - level(finer, name)) for name in stated}
    worst = max(off, key=lambda name: off[name] - 3 * (stated[name] or 0.0))
    warnings = sorted({one["code"] for one in answer["messages"] if one["severity"] == "warning"})
    resolved = all(off[name] <= 3 * (stated[name] or 0.0) + 0.01 for name in stated)
    verdict = "confirmed" if resolved else "warning" if {"uncertain", "not-stationary", "start-transient"} & set(warnings) else "WRONG"
    return [verdict, f"{off[worst]:.3g}", f"{stated[worst]:.3g}", f"{model['step_us']:.3g}", f"{took:.1f}", ", ".join(warnings)]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--binary", required=True)
    parser.add_argument("--csv")
    options = parser.parse_args()
    binary = os.path.abspath(options.binary)
    fields = ["scene", "verdict", "off_db", "stated_db", "step_us", "cpu_s", "says"]
    rows = []
    for name, scene in SCENES.items():
        rows.append([name, *judged(binary, scene)])
        print("| " + " | ".join(rows[-1]) + " |", flush=True)
    if options.csv:
        with open(options.csv, "w", encoding="utf-8", newline="") as file:
            csv.writer(file, lineterminator="\n").writerows([fields, *rows])


if __name__ == "__main__":
    main()
