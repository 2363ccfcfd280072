#!/usr/bin/env python3
"""An uncertainty job over HTTP: the numbers follow from its table, a killed service continues it, and one seed gives the same points. A study over
uncertain inputs has the statistics of uncertainty jobs."""

import math
import os
import sys
import tempfile
import time

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), os.pardir))
from service import ARTICLE, Service, check  # noqa: E402

LEVEL = "/channels/spindle.y.acceleration/level_db"
MASS = "/spindle/mass_kg"
CLEARANCE = "/bearing/radial_clearance_um"
JOB = ARTICLE | {
    "kind": "uncertainty", "reuse": False, "settle_s": 0.02, "duration_s": 0.05, "solver": {"rung": "radially_condensed"},
    "samples": 32, "seed": 7, "metrics": [LEVEL],
    "inputs": [{"path": MASS, "distribution": {"type": "uniform", "from": 0.04, "to": 0.06}},
               {"path": CLEARANCE, "distribution": {"type": "normal", "mean": 5, "standard_deviation": 1, "from": 2, "to": 8}}],
}


def answer(service, path):
    return service.request("GET", f"{path}/uncertainty")[2]


def rows(service, path):
    return service.request("GET", f"{path}/table")[2]["rows"]


def levels(found):
    return [row["metrics"]["channels"]["spindle.y.acceleration"]["level_db"] for row in found[1:]]


with tempfile.TemporaryDirectory(prefix="raceway-check-") as directory:
    service = Service(directory, "--workers", "2")
    path, _ = service.submit(JOB)
    while answer(service, path)["ended"] < 5:
        time.sleep(0.02)
    service.kill()
    service = Service(directory, "--workers", "2")
    try:
        check(service.ended(path)["status"] == "succeeded", "a killed uncertainty job succeeds without help")
        found, table = answer(service, path), rows(service, path)
        check((found["points"], found["ended"], found["failed"]) == (33, 33, 0), "33 points have ended")
        check(table[0]["point"] == {MASS: 0.05, CLEARANCE: 5.0}, "the first point is the nominal one")
        masses = sorted(int((row["point"][MASS] - 0.04) / 0.02 * 32) for row in table[1:])
        check(masses == list(range(32)), "each thirty-second of the range of the mass has one point")
        of, values = found["metrics"][LEVEL], levels(table)
        mean = sum(values) / 32
        deviation = math.sqrt(sum((value - mean) ** 2 for value in values) / 31)
        check(abs(of["mean"] - mean) < 1e-9 and abs(of["standard_deviation"] - deviation) < 1e-9, "mean and deviation are those of the table")
        power = 10 * math.log10(sum(10 ** (value / 10) for value in values) / 32)
        check(abs(of["energy_mean_db"] - power) < 1e-9 and power >= mean, "the energy mean is that of the powers")
        check(sum(of["histogram"]["counts"]) == 32, "the histogram counts every point")
        shown = {one["percentile"]: one for one in of["percentiles"]}
        order = sorted(values)
        check(shown[50]["from"] == order[9] and shown[50]["to"] == order[22], "the median lies between ranks 10 and 23 of 32")
        check("to" not in shown[90] and "from" not in shown[10], "32 points bound P90 from below only")
        errors = of["errors"]
        subtracted = math.sqrt(max(0.0, deviation ** 2 - errors["integration"] ** 2))
        check(abs(errors["tolerance_spread"] - subtracted) < 1e-9, "the spread has the integration error subtracted")
        check(len(found["inputs"]) == 2 and "cut below 2 and above 8" in found["inputs"][1]["assumption"], "assumptions are stated")
        shares = {one["input"]: one["share"] for one in of["sensitivity"]["inputs"]}
        print(f"level {of['mean']:.2f} dB, deviation {deviation:.3f} dB, integration {errors['integration']:.1e} dB, "
              f"Q2 {of['sensitivity']['q2']:.3f}, shares {shares}, verdict {of['verdict']}")
        picture = service.request("GET", f"{path}/plots/uncertainty.svg")
        check(picture[0] == 200 and b"</svg>" in picture[2], "drawn")
        again, _ = service.submit(JOB)
        check(service.ended(again)["status"] == "succeeded", "the same job again")
        check(answer(service, again) == found, "gives the same answer")

        # A study over the clearance: the statistic of each point is that of the runs with its values.
        fields = {key: value for key, value in JOB.items() if key != "metrics"}
        study = fields | {"kind": "study", "samples": 16, "statistic": "mean", "inputs": JOB["inputs"][1:], "axes": [{"path": MASS, "values": [0.04, 0.06]}]}
        path, _ = service.submit(study)
        check(service.ended(path)["status"] == "succeeded", "a study over uncertain inputs succeeds")
        table = service.request("GET", f"{path}/table")[2]
        check((table["points"], table["ended"], table["statistic"]) == (2, 2, "mean"), "each of its points is a row")
        for row in table["rows"]:
            mass = row["point"][MASS]
            alone = {key: value for key, value in fields.items() if key != "design"} | {"samples": 16, "inputs": JOB["inputs"][1:], "metrics": [LEVEL]}
            alone["scene"] = fields["scene"] | {"spindle": fields["scene"].get("spindle", {}) | {"mass_kg": mass}}
            spread, _ = service.submit(alone)
            check(service.ended(spread)["status"] == "succeeded", f"uncertainty at {mass} kg")
            of = answer(service, spread)["metrics"][LEVEL]
            level = row["metrics"]["channels"]["spindle.y.acceleration"]["level_db"]
            half = row["samples"]["half_intervals"]["channels"]["spindle.y.acceleration"]["level_db"]
            check(abs(level - of["mean"]) < 1e-9, f"mean level {level:.3f} dB at {mass} kg, uncertainty job {of['mean']:.3f} dB")
            check(abs(half - 1.96 * of["standard_deviation"] / 4) < 1e-9, "half of its interval is that of the mean of 16")
        best = table["best"][LEVEL]
        check(best["value"] == min(row["metrics"]["channels"]["spindle.y.acceleration"]["level_db"] for row in table["rows"]), "the best point is that of the statistic")
    finally:
        service.stop()
