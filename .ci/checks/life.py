#!/usr/bin/env python3
"""Rating life and torque of friction over HTTP. With a URL as argument the checks talk to a service that runs there."""

import os
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), os.pardir))
from cases import metrics, run_cases, verdict  # noqa: E402

BEARING = {"preset": "6205", "dynamic_load_rating_n": 14000, "static_load_rating_n": 7850, "f0": 13.9}
OIL = {"kind": "oil", "viscosity_40_mm2_s": 20, "viscosity_100_mm2_s": 4, "temperature_c": 40}


def scene(speed=3000, bearing=BEARING, **loads):
    loads = loads or {"radial_load_y_n": 500, "axial_load_n": 200}
    return {"bearing": bearing, "gravity_m_s2": 0, "lubricant": OIL, "operation": {"speed_rpm": speed, **loads}}


def resolved(running, of):
    return running.request("POST", "/v1/scenes/resolve", {"scene": of})[2]["derived"]


def run(of, parts, **job):
    return {"kind": "simulation", "settle_s": 0.02, "duration_s": 0.05, "scene": of,
            "outputs": {"metrics": parts, "spectra": []}, **job}


def near(value, expected, half_digit):
    return value is not None and abs(value - expected) <= half_digit


def case_life_of_a_6205(running):
    life = resolved(running, scene())["life"]
    numbers = [("e", 0.2211, 5e-5), ("y", 1.983, 5e-4), ("equivalent_load_n", 676.5, 0.05), ("basic_l10h", 49236, 0.5)]
    found = {name: life.get(name) for name, _, _ in numbers}
    verdict(all(near(found[name], expected, half) for name, expected, half in numbers), f"life of a 6205: {found}")


def case_life_of_a_6309(running):
    of = scene(1800, {"preset": "6309", "dynamic_load_rating_n": 55300}, radial_load_y_n=4000)
    life = resolved(running, of)["life"]
    verdict(near(life["basic_l10h"], 24466, 0.5) and near(life["nu1_mm2_s"], 12.46, 5e-3),
            f"life of a 6309: {life['basic_l10h']} h, ν₁ {life['nu1_mm2_s']} mm²/s")


def case_reasons(running):
    still = resolved(running, scene(0))["life"]
    verdict("basic_l10h" not in still and any("do not turn" in note for note in still["notes"]),
            f"at rest there is no life: {still['notes']}")
    status, _, answer = running.request("POST", "/v1/scenes/resolve", {"scene": {**scene(), "contamination_factor": 2}})
    verdict(status == 422 and answer["errors"][0]["pointer"] == "/scene/contamination_factor",
            f"a contamination factor of 2 is refused: {answer.get('errors')}")


def case_reference_moments(running):
    of = resolved(running, scene(radial_load_y_n=500))["friction_reference"]
    verdict(near(of["skf_rolling_n_mm"], 9.83, 5e-3) and near(of["skf_sliding_n_mm"], 1.99, 5e-3), f"reference: {of}")


def case_run(running):
    found = metrics(running, run(scene(), ["vibration", "life", "friction"], solver={"rung": "full"}))
    life, friction = found["life"], found["friction"]
    ratio = life["reference_l10h_dynamic"] / life["reference_l10h_static"]
    verdict(0.5 < ratio < 2, f"life from the loads of a run over that at rest: {ratio:.3f}")
    gap = abs(friction["gap_n_mm"]) / friction["drive_n_mm"]
    verdict(gap < 1e-3, f"torque of the parts closes to {gap:.1e} of {friction['drive_n_mm']:.2f} N·mm of the drive")


def case_reduced_level(running):
    of = scene(radial_load_y_n=500)
    found = metrics(running, run(of, ["vibration", "life"], solver={"rung": "radially_condensed"}))
    verdict(found.get("life", {}).get("reference_l10h_dynamic", 0) > 0 and "friction" not in found,
            f"radially_condensed gives the life: {found.get('life', {}).get('reference_l10h_dynamic')}")
    status, _, answer = running.request(
        "POST", "/v1/jobs", run(of, ["vibration", "friction"], solver={"rung": "radially_condensed"}))
    verdict(status == 422, f"radially_condensed has no torque: {answer}")


def case_metric_of_a_study(running):
    job = {"kind": "study", "settle_s": 0.01, "duration_s": 0.02, "scene": scene(radial_load_y_n=500),
           "axes": [{"path": "/operation/radial_load_y_n", "values": [500, 1000]}],
           "outputs": {"metrics": ["vibration", "life", "friction"]}}
    path, _ = running.submit(job)
    running.ended(path, at_most=600)
    rows = running.request("GET", f"{path}/table")[2]["rows"]
    totals = [row["metrics"]["friction"]["total_n_mm"] for row in rows]
    lives = [row["metrics"]["life"]["basic_l10h"] for row in rows]
    verdict(totals[0] < totals[1] and near(lives[0] / lives[1], 8, 1e-6), f"a study: torques {totals} N·mm, lives {lives} h")


if __name__ == "__main__":
    run_cases(globals())
