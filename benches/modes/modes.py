#!/usr/bin/env python3
"""Error of levels against run time for the number of kept modes of a shaft (`mode_range`), for two machines.

Usage: python3 benches/modes/modes.py --binary BINARY [--ranges 0.25,0.5,1,1.5,2] [--reference 5] [--step 2.75] [--csv FILE]

  motor    a shaft of 25 mm × 300 mm with a disc on two preloaded 6205 at 12 000 r/min, docs/how-to/simulate-a-shaft.md
  spindle  a hollow spindle on two 7008 with a nose that hangs over, at 12 000 r/min, docs/tutorial-spindle.md

Bearing A has a spall in its outer raceway, whose impacts excite the whole band.

Every run of a machine has the same step, settling and recorded time. Only the free modes differ, and with them the mesh, which is refined until
the kept frequencies change by less than 1e-4. Residual vectors of all ports belong to every run. The reference keeps modes up to 5 times
the band, the most that a job may ask for. Errors [dB] are distances of the levels of acceleration from those of the reference: the largest
of the bearings' rings and of the sensor. Times are processor times of the process. Only the standard library is needed.
"""

import argparse
import csv
import json
import os
import sys

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path.insert(0, os.path.join(HERE, os.pardir, "compare"))
import compare  # noqa: E402


def motor():
    return {"kind": "machine", "settle_s": 0.05, "duration_s": 0.1, "scene": {
        "shaft": {
            "sections": [{"length_mm": 300, "outer_diameter_mm": 25}],
            "discs": [{"at_mm": 150, "mass_kg": 1.2, "transverse_inertia_kg_m2": 8e-4, "axial_inertia_kg_m2": 1.5e-3}],
            "unbalances": [{"at_mm": 150, "unbalance_g_mm": 20}]},
        "bearings": [{"name": "A", "bearing": "6205", "at_mm": 40, "faces": "+x", "surfaces": spall(1)},
                     {"name": "B", "bearing": "6205", "at_mm": 260, "faces": "-x"}],
        "preloads": [{"between": ["A", "B"], "force_n": 200}],
        "sensors": [{"name": "probe", "at_mm": 200, "direction": "y"}],
        "operation": {"speed_rpm": 12000, "radial_load_y_n": 100}}}


def spindle():
    bearing = {"type": "angular_contact", "outer_diameter_mm": 68, "inner_diameter_mm": 40, "width_mm": 15, "ball_count": 17,
               "ball_diameter_mm": 7.938, "pitch_diameter_mm": 54, "contact_angle_deg": 25}
    sections = [(35, 55), (45, 40), (150, 46), (60, 40)]
    return {"kind": "machine", "settle_s": 0.05, "duration_s": 0.1, "scene": {
        "shaft": {
            "sections": [{"length_mm": length, "outer_diameter_mm": outer, "inner_diameter_mm": 20} for length, outer in sections],
            "discs": [{"at_mm": 0, "mass_kg": 0.6, "transverse_inertia_kg_m2": 2.5e-4, "axial_inertia_kg_m2": 2.2e-4},
                      {"at_mm": 155, "mass_kg": 2.4, "transverse_inertia_kg_m2": 3.4e-3, "axial_inertia_kg_m2": 2e-3}],
            "unbalances": [{"at_mm": 0, "unbalance_g_mm": 1}, {"at_mm": 155, "unbalance_g_mm": 3, "phase_deg": 90}],
            "axial": "free"},
        "bearings": [{"name": "A", "bearing": bearing, "at_mm": 55, "faces": "+x", "surfaces": spall(0.8)},
                     {"name": "B", "bearing": bearing, "at_mm": 255, "faces": "-x"}],
        "preloads": [{"between": ["A", "B"], "force_n": 300}],
        "sensors": [{"name": "nose", "at_mm": 20, "direction": "y"}],
        "operation": {"speed_rpm": 12000, "radial_load_y_n": 100}}}


def spall(length_mm):
    return {"outer": {"defects": [{"azimuth_deg": 0, "length_mm": length_mm, "width_mm": 2, "depth_um": 3}]}}


MACHINES = {"motor": motor, "spindle": spindle}


def run(runner, binary, job, mode_range, step):
    found = runner.run(binary, "simulate", job | {"mode_range": mode_range, "step_us": step})
    if "failure" in found:
        sys.exit(found["failure"])
    answer = json.loads(found["answer"])
    levels = {name: channel["level_db"] for name, channel in answer["channels"].items() if "level_db" in channel}
    return {"levels": levels, "cpu_s": found["cpu_s"], "coordinates": answer["model"]["coordinates"]}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--binary", required=True)
    parser.add_argument("--ranges", type=lambda text: [float(one) for one in text.split(",")], default=[0.25, 0.5, 1.0, 1.5, 2.0])
    parser.add_argument("--reference", type=float, default=5.0)
    parser.add_argument("--step", type=float, default=2.75)
    parser.add_argument("--csv")
    options = parser.parse_args()
    runner, rows = compare.Runner(3600.0), []
    for name, machine in MACHINES.items():
        reference = run(runner, options.binary, machine(), options.reference, options.step)
        loudest = max(reference["levels"].values())
        for mode_range in options.ranges:
            found = run(runner, options.binary, machine(), mode_range, options.step)
            # Channels more than 60 dB below the strongest are rounding.
            errors = {channel: abs(found["levels"][channel] - level) for channel, level in reference["levels"].items() if level > loudest - 60}
            worst = max(errors, key=errors.get)
            rows.append({"machine": name, "mode_range": f"{mode_range:g}", "coordinates": found["coordinates"],
                         "cpu_s": f"{found['cpu_s']:.2f}", "largest_error_db": f"{errors[worst]:.5f}", "of": worst,
                         "reference_coordinates": reference["coordinates"], "reference_cpu_s": f"{reference['cpu_s']:.2f}"})
            print(rows[-1], flush=True)
    print(f"\nBinary {compare.label_of(options.binary)}; {compare.machine()}; {compare.now()}\n")
    print("| " + " | ".join(rows[0]) + " |\n|" + "---|" * len(rows[0]))
    for row in rows:
        print("| " + " | ".join(str(value) for value in row.values()) + " |")
    if options.csv:
        with open(options.csv, "w", newline="", encoding="utf-8") as file:
            writer = csv.DictWriter(file, rows[0].keys())
            writer.writeheader()
            writer.writerows(rows)


if __name__ == "__main__":
    main()
