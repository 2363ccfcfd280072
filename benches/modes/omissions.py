#!/usr/bin/env python3
"""What a machine could leave out by the linear analysis, and what that would save: bending, tilt, gyroscopic moments, housing.

Usage: python3 benches/modes/omissions.py --binary BINARY [--seed 1] [--count 10] [--stubs 4] [--csv FILE]

Each machine is analysed as a `rotor` at its operating speed. Supports with the stiffness and damping matrices of its bearings then take the
place of the bearings, so that one term at a time can be left out. A change is the largest relative change of the eight lowest natural
frequencies below 20 kHz, matched by their number.

  bending     with the largest modulus that a job may have, 2000 GPa; a rigid shaft changes more
  tilt        with the moment rows and columns of the matrices set to 0; beside it the largest static tilt of an inner ring [mrad]
  gyroscopic  at rest in place of the operating speed

Machines: stub shafts on two 6205 side by side, ever longer, and those of benches/coverage/machines.py. A motor spindle in a housing follows,
whose mounts become ever stiffer; the change is that against ground in place of the housing. At last one run in time of a stub shaft and of
a bar of 300 mm, each with a shaft and with a rigid spindle of the same mass and inertia: processor time, coordinates, and the largest
difference of a level. Only the standard library is needed.
"""

import argparse
import csv
import json
import math
import os
import sys

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path[:0] = [os.path.join(HERE, os.pardir, "compare"), os.path.join(HERE, os.pardir, "coverage")]
import compare  # noqa: E402
import machines  # noqa: E402

BAND_HZ, MODES, STIFFEST_GPA, STEEL_GPA, DENSITY = 20_000.0, 8, 2000.0, 208.0, 7830.0
STEP_US, SETTLE_S, DURATION_S = 2.75, 0.02, 0.05


def steel(modulus=STEEL_GPA):
    return {"elastic_modulus_gpa": modulus, "poisson_ratio": 0.3, "density_kg_m3": DENSITY}


class Analyses:
    def __init__(self, binary):
        self.runner, self.binary = compare.Runner(3600.0), binary

    def of(self, scene, modulus=STEEL_GPA):
        """The analysis at the operating speed; None without an equilibrium."""
        scene = scene | {"shaft": scene["shaft"] | {"material": steel(modulus)}}
        operation = scene["operation"]
        rpm = operation["speed_rpm"]
        rpm = rpm if isinstance(rpm, (int, float)) else max(point["rpm"] for point in rpm)
        scene["operation"] = operation | {"speed_rpm": rpm}
        found = self.runner.run(self.binary, "simulate", {"kind": "rotor", "scene": scene, "speeds_rpm": [rpm], "modes": MODES})
        return None if "failure" in found else json.loads(found["answer"])


def frequencies(answer):
    return sorted(mode["frequency_hz"] for mode in answer["operating"]["modes"] if mode["frequency_hz"] < BAND_HZ)


def change(one, other):
    """Largest relative change of a frequency; None where only one has any."""
    pairs = list(zip(frequencies(one), frequencies(other)))
    return max((abs(b / a - 1.0) for a, b in pairs), default=None)


def on_supports(scene, answer, has_tilt=True):
    """The scene on supports with the matrices of its bearings."""
    def matrix(rows):
        return [[value if has_tilt or max(row, column) < 3 else 0.0 for column, value in enumerate(values)]
                for row, values in enumerate(rows)]

    supports = [{"at_mm": of["at_mm"], "matrix": {"k": matrix(of["stiffness"]), "c": matrix(of["damping"])}} for of in answer["bearings"]]
    kept = {key: value for key, value in scene.items() if key in ("shaft", "operation")}
    return kept | {"supports": supports, "operation": {"speed_rpm": answer["operating"]["speed_rpm"]}}


def stub(length):
    half = 0.5 * length
    return {"shaft": {"sections": [{"length_mm": length, "outer_diameter_mm": 25}]},
            "bearings": [{"name": name, "bearing": "6205", "at_mm": half + side * max(7.6, half - 12), "faces": faces}
                         for name, side, faces in (("A", -1, "+x"), ("B", 1, "-x"))],
            "preloads": [{"between": ["A", "B"], "force_n": 200}],
            "operation": {"speed_rpm": 12000, "radial_load_y_n": 100}}


def analysed(analyses, name, scene):
    """The row of a machine; None without an equilibrium."""
    own = analyses.of(scene)
    if own is None:
        return None
    base = on_supports(scene, own)
    linear = analyses.of(base)
    others = [analyses.of(base, STIFFEST_GPA), analyses.of(on_supports(scene, own, has_tilt=False)),
              analyses.of(base | {"operation": {"speed_rpm": 0}})]
    if linear is None:
        return None
    bending, tilt, gyroscopic = [None if other is None else change(linear, other) for other in others]
    rpm = own["operating"]["speed_rpm"]
    return {"machine": name, "speed_rpm": f"{rpm:g}", "bending": bending, "tilt": tilt, "gyroscopic": gyroscopic,
            "static_tilt_mrad": max(abs(value) for of in own["bearings"] for value in of["tilt_mrad"])}


def in_housing(factor):
    """A motor spindle in a head on a mount, `factor` times as stiff as 50 N/µm."""
    bearings = [{"name": name, "bearing": "6205", "at_mm": at, "faces": faces} | ({"outer_ring": {"on": "head"}} if factor else {})
                for name, at, faces in (("A", 40, "+x"), ("B", 260, "-x"))]
    scene = {"shaft": {"sections": [{"length_mm": 300, "outer_diameter_mm": 25}]}, "bearings": bearings,
             "preloads": [{"between": ["A", "B"], "force_n": 200}], "operation": {"speed_rpm": 12000, "radial_load_y_n": 100}}
    if factor:
        mount = {"body": "head", "stiffness_n_per_um": [50 * factor] * 3, "damping_n_s_per_m": [300 * math.sqrt(factor)] * 3,
                 "tilt_n_m_per_mrad": [20 * factor] * 2}
        scene["housing"] = {"bodies": [{"name": "head", "mass_kg": 8, "at_mm": 150, "inertia_kg_m2": [0.02, 0.05, 0.05]}], "mounts": [mount]}
    return scene


def in_time(analyses, scene):
    """A run of a machine with its shaft, and with a rigid spindle of the same mass and inertia."""
    [section] = scene["shaft"]["sections"]
    length, radius = 1e-3 * section["length_mm"], 0.5e-3 * section["outer_diameter_mm"]
    mass = DENSITY * math.pi * radius**2 * length
    rigid = {key: value for key, value in scene.items() if key != "shaft"}
    rigid["spindle"] = {"mass_kg": mass, "centre_mm": 500 * length, "axial": "fixed", "axial_inertia_kg_m2": 0.5 * mass * radius**2,
                        "transverse_inertia_kg_m2": mass * (3 * radius**2 + length**2) / 12}
    found = []
    for case in (scene | {"shaft": scene["shaft"] | {"material": steel()}}, rigid):
        job = {"kind": "machine", "scene": case, "settle_s": SETTLE_S, "duration_s": DURATION_S, "step_us": STEP_US}
        run = analyses.runner.run(analyses.binary, "simulate", job)
        if "failure" in run:
            sys.exit(run["failure"])
        answer = json.loads(run["answer"])
        levels = {name: channel["level_db"] for name, channel in answer["channels"].items() if "level_db" in channel}
        found.append({"cpu_s": run["cpu_s"], "coordinates": answer["model"]["coordinates"], "levels": levels})
    shaft, spindle = found
    loudest = max(shaft["levels"].values())
    apart = {name: abs(level - spindle["levels"][name]) for name, level in shaft["levels"].items() if level > loudest - 60}
    return {"length_mm": section["length_mm"], "coordinates": [of["coordinates"] for of in found],
            "cpu_s": [round(of["cpu_s"], 2) for of in found], "largest_difference_db": round(max(apart.values()), 3)}


def shown(value):
    return "–" if value is None else f"{value:.2g}" if isinstance(value, float) else str(value)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--binary", required=True)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--count", type=int, default=10)
    parser.add_argument("--stubs", type=int, default=4)
    parser.add_argument("--csv")
    options = parser.parse_args()
    analyses, rows = Analyses(options.binary), []
    for length in [32, 50, 80, 120, 200][: options.stubs]:
        rows.append(analysed(analyses, f"stub of {length} mm", stub(length)))
        print(rows[-1], flush=True)
    for length in (50, 300):
        print(in_time(analyses, stub(length)), flush=True)
    ground = analyses.of(in_housing(None))
    for factor in (1, 100, 20_000):
        housed = analyses.of(in_housing(factor))
        print({"mount_n_per_um": 50 * factor, "change": housed and shown(change(ground, housed))}, flush=True)
    for index in range(options.count):
        rows.append(analysed(analyses, f"drawn {options.seed}.{index}", machines.drawn(options.seed, index)["scene"]))
        print(rows[-1], flush=True)
    failed, rows = rows.count(None), [row for row in rows if row]
    print(f"\n{len(rows)} machines, {failed} without an equilibrium. Binary {compare.label_of(options.binary)}; {compare.machine()}; {compare.now()}\n")
    for name, limit in (("bending", 1e-3), ("tilt", 1e-3), ("gyroscopic", 1e-4), ("static_tilt_mrad", 0.1)):
        values = sorted(row[name] for row in rows if row[name] is not None)
        print(f"{name}: {sum(value < limit for value in values)} of {len(values)} below {limit:g}; least {values[0]:.2g}, "
              f"median {values[len(values) // 2]:.2g}")
    if options.csv:
        with open(options.csv, "w", newline="", encoding="utf-8") as file:
            writer = csv.DictWriter(file, rows[0].keys())
            writer.writeheader()
            writer.writerows({key: shown(value) for key, value in row.items()} for row in rows)


if __name__ == "__main__":
    main()
