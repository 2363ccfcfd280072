#!/usr/bin/env python3
"""The article's spindle with an overhang: levels and lines on an elastic shaft beside those on a rigid one.

Usage: python3 benches/overhang/overhang.py --binary BINARY [--csv FILE] [--duration 0.2]

Two of the article's bearings stand 40 mm apart, 5 mm from one end; the other end hangs over the second bearing by 60 or by 120 mm.
The shaft has the bearings' bore, turns at 50 000 r/min, carries 200 N at its mass centre and an unbalance of 0.1 g mm at its free end.

  elastic  steel
  rigid    twice the diameter, 10 times the modulus and a quarter of the density: the same mass, a bending stiffness 154 times that
           of steel, and a first free bending mode above the band of levels
  loose    both bearings with the clearance of the preset
  preload  both pressed along the axis by 30 N

Each run records after its settling time. The table has levels of acceleration [dB] with their estimated error, natural frequencies [Hz], and
the strongest lines of the second bearing's place and of the free end. Only the standard library is needed.
"""

import argparse
import csv
import datetime
import itertools
import json
import os
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), os.pardir, "compare"))
import compare  # noqa: E402

OVERHANGS = (60, 120)
BORE, STEEL, DENSITY = 8.5, 208.0, 7810.0
SHAFTS = {"elastic": (BORE, STEEL, DENSITY), "rigid": (2 * BORE, 2000.0, DENSITY / 4)}
SUPPORTS = {"loose": [], "preload": [{"between": ["A", "B"], "force_n": 30}]}
CHANNELS = ("A.y", "A.z", "B.y", "B.z", "sensor.nose")
LINES = 5


def job(overhang, shaft, support, duration):
    diameter, modulus, density = SHAFTS[shaft]
    length = 50 + overhang
    material = {"elastic_modulus_gpa": modulus, "poisson_ratio": 0.3, "density_kg_m3": density}
    return {"kind": "machine", "duration_s": duration, "scene": {
        "shaft": {"material": material, "sections": [{"length_mm": length, "outer_diameter_mm": diameter}],
                  "unbalances": [{"at_mm": length, "unbalance_g_mm": 0.1}]},
        "bearings": [{"name": "A", "bearing": "article-integrated", "at_mm": 5},
                     {"name": "B", "bearing": "article-integrated", "at_mm": 45, "faces": "-x"}],
        "preloads": SUPPORTS[support], "sensors": [{"name": "nose", "at_mm": length, "direction": "y"}],
        "operation": {"speed_rpm": 50000, "radial_load_y_n": 200}}}


def row_of(overhang, shaft, support, found):
    levels = {channel: found["channels"][f"{channel}.acceleration"]["level_db"] for channel in CHANNELS}
    errors = [error for error in found["accuracy"]["level_errors_db"].values() if error is not None]
    lines = lambda channel: [f"{line['label'] or '?'} {line['frequency_hz']:.0f} Hz {line['amplitude']:.3g}"
                             for line in found["lines"] if line["channel"] == f"{channel}.acceleration"][:LINES]
    frequencies = sorted(mode["frequency_hz"] for mode in found["natural_frequencies"])
    return {"overhang_mm": overhang, "bearings": support, "shaft": shaft, **{f"{name}_db": f"{level:.2f}" for name, level in levels.items()},
            "largest_error_db": f"{max(errors, default=float('nan')):.3f}",
            "natural_frequencies_hz": " ".join(f"{frequency:.0f}" for frequency in frequencies[:6]),
            "lines_B_y": "; ".join(lines("B.y")), "lines_nose_y": "; ".join(lines("sensor.nose"))}


def write_csv(rows, path, duration):
    with open(path, "w", encoding="utf-8", newline="") as file:
        file.write("# Levels and lines of the article's spindle with an overhang, on an elastic and on a rigid shaft.\n"
                   f"# command: python3 benches/overhang/overhang.py --binary target/release/raceway --duration {duration:g} --csv docs/data/overhang.csv\n"
                   f"# date: {datetime.date.today()}\n# machine: any; levels and lines do not depend on it\n"
                   "# lines: label, frequency, amplitude [m/s²]\n")
        table = csv.DictWriter(file, rows[0].keys(), lineterminator="\n")
        table.writeheader()
        table.writerows(rows)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--binary", required=True)
    parser.add_argument("--csv")
    parser.add_argument("--duration", type=float, default=0.2)
    options = parser.parse_args()
    runner, rows, failures = compare.Runner(timeout=3600), [], 0
    for support, overhang, shaft in itertools.product(SUPPORTS, OVERHANGS, SHAFTS):
        done = runner.run(options.binary, "simulate", job(overhang, shaft, support, options.duration))
        if "failure" in done:
            failures += 1
            print(f"{overhang} mm, {support}, {shaft}: {done['failure']}", file=sys.stderr)
            continue
        row = row_of(overhang, shaft, support, json.loads(done["answer"]))
        rows.append(row)
        print("\n".join(f"{key}: {value}" for key, value in row.items()), end="\n\n", flush=True)
    if options.csv and rows:
        write_csv(rows, options.csv, options.duration)
    sys.exit(1 if failures else 0)


if __name__ == "__main__":
    main()
