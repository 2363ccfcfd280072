#!/usr/bin/env python3
"""Shafts on bearings with clearance over HTTP: a static equilibrium, or a refusal that names its cause. With a URL as argument the requests go
there."""

import os
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.dirname(os.path.abspath(__file__)))))
from cases import result, run_cases, verdict  # noqa: E402


def job(length, diameter, bearings, load, speed, **shaft):
    """A bar on two bearings that face each other, under a load at its mass centre."""
    pair = [{"name": name, "bearing": bearing, "at_mm": at, "faces": faces}
            for (name, faces), (bearing, at) in zip((("A", "+x"), ("B", "-x")), bearings)]
    return {"kind": "rotor", "speeds_rpm": [speed], "modes": 4, "scene": {
        "shaft": {"sections": [{"length_mm": length, "outer_diameter_mm": diameter}]} | shaft, "bearings": pair,
        "operation": {"speed_rpm": speed, "radial_load_y_n": load}}}


def case_overhung_spindle(running):
    """The bearings carry weight and load, from rest to 50 000 r/min."""
    for speed in (0, 1000, 10000, 50000):
        answer = result(running, job(110, 8.5, [("article-integrated", 5), ("article-integrated", 45)], 50, speed), "rotor")
        carried, whole = sum(one["static_force_n"][1] for one in answer["supports"]), 50 + 9.81 * answer["mass_kg"]
        verdict(abs(carried / whole - 1) < 1e-8, f"{carried:.9f} of {whole:.9f} N at {speed} r/min")


def case_clearance(running):
    """A wider clearance lets the shaft sink further, by half of it at least."""
    sunk = []
    for clearance in (0, 5, 20, 40):
        bearing = {"preset": "6205", "radial_clearance_um": clearance}
        answer = result(running, job(300, 25, [(bearing, 50), (bearing, 250)], 100, 3000), "rotor")
        sunk.append(answer["bearings"][0]["displacement_um"][1])
        verdict(sunk[-1] > clearance / 2, f"{sunk[-1]:.3f} µm with {clearance} µm of clearance")
    verdict(sunk == sorted(sunk), f"the displacement grows: {sunk}")


def case_causes(running):
    """A shaft of 5 mm with 100 kg leans too far."""
    disc = {"at_mm": 150, "mass_kg": 100, "transverse_inertia_kg_m2": 0.1, "axial_inertia_kg_m2": 0.1}
    body = job(300, 5, [("6205", 20), ("6205", 280)], 0, 0, discs=[disc])
    status, _, answer = running.request("POST", "/v1/rotor", body)
    detail = answer.get("detail", "") if isinstance(answer, dict) else ""
    verdict(status >= 400 and "leans by" in detail, f"{status}: {detail}")


if __name__ == "__main__":
    run_cases(globals())
