#!/usr/bin/env python3
"""Change of levels by leaving out a term of shaft or housing, beside its bound of the linear analysis, and the time that it saves.

Usage: python3 benches/modes/omissions.py --binary BINARY [--seed 1] [--count 10] [--limit 60] [--csv FILE] [--summary FILE]

Each machine runs complete, and with each of its terms switched off (`scene.terms`): bending, tilt, gyroscopic moments, housing. Machines: stub
shafts on two 6205 side by side, ever longer; a bar of 300 mm, ever thicker; a motor spindle in a head, whose mount becomes ever stiffer;
and those of benches/coverage/machines.py. All runs of a machine have the same steps.

  bound     `left_out[].bound` of the run without the term [dB]
  change    largest difference of the level at a place, all directions of its acceleration together; places 60 dB below the loudest do not count
  --summary a row for each term: number of machines, changes covered, least and median bound, bounds within 0.5 dB, median share of the time
  error     largest `accuracy.level_errors_db` of both runs [dB]; a change within the bound and this is covered
  --limit   largest processor time of a run [s]; machines beyond it are counted as too dear

Only the standard library is needed.
"""

import argparse
import csv
import json
import math
import os
import statistics
import sys

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path[:0] = [os.path.join(HERE, os.pardir, "compare"), os.path.join(HERE, os.pardir, "coverage")]
import compare  # noqa: E402
import machines  # noqa: E402

TERMS = ("shaft_bending", "tilt", "gyroscopic", "housing")
RUN = {"kind": "machine", "settle_s": 0.1, "duration_s": 0.1, "step_us": 5.5}
FAINT_DB = 60.0


def stub(length):
    half = 0.5 * length
    return {"shaft": {"sections": [{"length_mm": length, "outer_diameter_mm": 25}],
                      "unbalances": [{"at_mm": 0, "unbalance_g_mm": 5}]},
            "bearings": [{"name": name, "bearing": "6205", "at_mm": half + side * max(7.6, half - 12), "faces": faces}
                         for name, side, faces in (("A", -1, "+x"), ("B", 1, "-x"))],
            "preloads": [{"between": ["A", "B"], "force_n": 200}],
            "operation": {"speed_rpm": 12000, "radial_load_y_n": 100}}


def bar(diameter):
    return {"shaft": {"sections": [{"length_mm": 300, "outer_diameter_mm": diameter}],
                      "discs": [{"at_mm": 150, "mass_kg": 1.2, "transverse_inertia_kg_m2": 8e-4, "axial_inertia_kg_m2": 1.5e-3}],
                      "unbalances": [{"at_mm": 150, "unbalance_g_mm": 20}]},
            "bearings": [{"name": "A", "bearing": "6205", "at_mm": 40}, {"name": "B", "bearing": "6205", "at_mm": 260}],
            "operation": {"speed_rpm": 6000, "radial_load_y_n": 500}}


def in_head(stiffness):
    """The bar of 25 mm in a head on a mount of this stiffness [N/µm]."""
    factor = stiffness / 50
    scene = bar(25)
    for bearing in scene["bearings"]:
        bearing["outer_ring"] = {"on": "head"}
    mount = {"body": "head", "stiffness_n_per_um": [stiffness] * 3, "damping_n_s_per_m": [300 * math.sqrt(factor)] * 3,
             "tilt_n_m_per_mrad": [20 * factor] * 2}
    body = {"name": "head", "mass_kg": 8, "at_mm": 150, "inertia_kg_m2": [0.02, 0.05, 0.05]}
    return scene | {"housing": {"bodies": [body], "mounts": [mount]}}


def scenes(options):
    for length in (32, 50, 80, 120):
        yield f"stub of {length} mm", stub(length)
    for diameter in (25, 40, 60):
        yield f"bar of {diameter} mm", bar(diameter)
    for stiffness in (50, 5000, 1_000_000):
        yield f"head on {stiffness} N/µm", in_head(stiffness)
    for index in range(options.count):
        yield f"drawn {options.seed}.{index}", machines.drawn(options.seed, index)["scene"]


def answered(runner, binary, scene):
    """Run, answer; None where it has no result."""
    run = runner.run(binary, "simulate", RUN | {"scene": scene})
    return (run, json.loads(run["answer"])) if "failure" not in run else None


def levels(answer):
    """Level of each place [dB]: of a bearing, a part of the housing or a sensor."""
    powers = {}
    for name, channel in answer["channels"].items():
        if channel.get("level_db") is not None:
            place = name if name.startswith("sensor.") else name.split(".")[0]
            powers[place] = powers.get(place, 0.0) + 10 ** (channel["level_db"] / 10)
    return {place: 10 * math.log10(power) for place, power in powers.items()}


def rows_of(runner, binary, name, scene):
    """A row for each term of a machine."""
    complete = answered(runner, binary, scene)
    if complete is None:
        return None
    found = []
    for term in TERMS:
        lean = answered(runner, binary, scene | {"terms": {term: "off"}})
        if lean is None:
            continue
        (run, answer), (lean_run, lean_answer) = complete, lean
        left_out = lean_answer["model"].get("left_out", [])
        # A machine has not every term.
        if not left_out:
            continue
        own, other = levels(answer), levels(lean_answer)
        loudest = max(own.values())
        changes = [abs(other[place] - level) for place, level in own.items() if place in other and level > loudest - FAINT_DB]
        errors = [error for one in (answer, lean_answer) for error in one["accuracy"]["level_errors_db"].values()]
        found.append({"machine": name, "term": term, "bound_db": left_out[0].get("bound"), "change_db": max(changes),
                      "error_db": max(errors, default=0.0), "coordinates": answer["model"]["coordinates"],
                      "coordinates_without": lean_answer["model"]["coordinates"],
                      "cpu_s": run["cpu_s"], "cpu_without_s": lean_run["cpu_s"]})
        print({key: shown(value) for key, value in found[-1].items()}, flush=True)
    return found


def shown(value):
    return "–" if value is None else f"{value:.3g}" if isinstance(value, float) else str(value)


def summary(rows):
    """A row for each term."""
    found = []
    for term in TERMS:
        of = [row for row in rows if row["term"] == term]
        bound = [math.inf if row["bound_db"] is None else row["bound_db"] for row in of]
        covered = sum(row["change_db"] <= limit + row["error_db"] for row, limit in zip(of, bound))
        share = statistics.median(row["cpu_without_s"] / row["cpu_s"] for row in of)
        found.append({"term": term, "machines": len(of), "covered": covered, "least_db": min(bound), "median_db": statistics.median(bound),
                      "within_half": sum(limit <= 0.5 for limit in bound), "time_share": round(share, 2)})
    return found


def write(path, rows):
    with open(path, "w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, rows[0].keys())
        writer.writeheader()
        writer.writerows({key: shown(value) for key, value in row.items()} for row in rows)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--binary", required=True)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--count", type=int, default=10)
    parser.add_argument("--limit", type=float, default=60.0)
    parser.add_argument("--csv")
    parser.add_argument("--summary")
    options = parser.parse_args()
    runner, rows, missing = compare.Runner(options.limit), [], 0
    for name, scene in scenes(options):
        found = rows_of(runner, options.binary, name, scene)
        missing += found is None
        rows += found or []
    print(f"\n{missing} machines without an answer. Binary {compare.label_of(options.binary)}; {compare.machine()}; {compare.now()}\n")
    of_terms = summary(rows)
    for row in of_terms:
        print({key: shown(value) for key, value in row.items()})
    if options.csv:
        write(options.csv, rows)
    if options.summary:
        write(options.summary, of_terms)


if __name__ == "__main__":
    main()
