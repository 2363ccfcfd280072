#!/usr/bin/env python3
"""Waves of the raceways move the spindle as a rigid shift would. With a URL as argument the checks talk to a service that runs there."""

import os
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), os.pardir))
from cases import run_cases, verdict  # noqa: E402

DISPLACEMENTS = ["spindle.y.displacement", "spindle.z.displacement"]


def wave(order):
    return {"waviness": [{"order": order, "amplitude_nm": 10, "phase_deg": 20}]}


def preloaded(surfaces, level="planar"):
    """The article's bearing without clearance, load and weight, at 1000 r/min: nothing moves it but its surfaces."""
    return {"kind": "simulation", "settle_s": 0.3, "duration_s": 1.0, "solver": {"rung": level},
            "outputs": {"metrics": ["vibration"], "spectra": DISPLACEMENTS},
            "scene": {"bearing": {"preset": "article-integrated", "radial_clearance_um": -4}, "gravity_m_s2": 0,
                      "operation": {"speed_rpm": 1000}, "surfaces": surfaces}}


def strongest(running, surfaces, level):
    """The strongest line of each displacement, frequency [Hz] and amplitude [nm], and the bearing's frequencies at the simulated speeds;
    empty where the service refuses the job."""
    status, _, answer = running.request("POST", "/v1/jobs", preloaded(surfaces, level))
    if status != 202:
        print(answer)
        return [], {}
    path = f"/v1/jobs/{answer['id']}"
    running.ended(path, at_most=600)
    metrics = running.request("GET", f"{path}/metrics")[2]
    lines = metrics.get("lines", [])
    first = [next((line for line in lines if line["channel"] == channel), None) for channel in DISPLACEMENTS]
    return [(line["frequency_hz"], 1000 * line["amplitude"]) for line in first if line], metrics.get("frequencies_hz", {})


def moves(running, surfaces, frequency, what, level="planar"):
    """Frequency within 0.1 % of the formula, or a fifth of a bin of the spectrum of 1 s."""
    found, frequencies = strongest(running, surfaces, level)
    expected = frequency(frequencies) if frequencies else float("nan")
    holds = len(found) == 2 and all(
        abs(at - expected) < max(0.001 * expected, 0.2) and abs(size / 10 - 1) < 0.02 for at, size in found)
    verdict(holds, f"{what}: 10 nm at {expected:.2f} Hz in y and z, found {found}")


def case_outer_wave(running):
    moves(running, {"outer": wave(8)}, lambda f: f["ball_pass_outer"], "outer wave of order 8 of 7 balls, BPFO")


def case_inner_wave(running):
    moves(running, {"inner": wave(6)}, lambda f: f["ball_pass_inner"] - f["shaft"], "inner wave of order 6 of 7 balls, BPFI − f_r")


def case_reduced_levels(running):
    for level in ["radially_condensed", "spindle_only"]:
        moves(running, {"inner": wave(8)}, lambda f: f["ball_pass_inner"] + f["shaft"], f"inner wave of order 8 on {level}, BPFI + f_r", level)
    moves(running, {"outer": wave(6)}, lambda f: f["ball_pass_outer"], "outer wave of order 6 on periodic, BPFO", "periodic")


def case_inner_waves_do_not_repeat_with_the_balls(running):
    job = preloaded({"inner": wave(6)}, "periodic")
    status, _, answer = running.request("POST", "/v1/jobs", job)
    holds = status == 422 and "scene.surfaces.inner" in str(answer)
    verdict(holds, f"the level periodic names the inner ring: {status} {answer}")


def case_resolve_lists_waves(running):
    job = preloaded({"outer": {"waviness": [{"order": 8, "amplitude_nm": 10}, {"order": 90000, "amplitude_nm": 1}]}})
    answer = running.request("POST", "/v1/scenes/resolve", {"scene": job["scene"]})[2]
    outer = answer.get("derived", {}).get("surfaces", {}).get("outer", {})
    orders = [one["order"] for one in outer.get("waves", [])], [one["from_order"] for one in outer.get("left_out", [])]
    verdict(orders == ([8], [90000]), f"resolve lists kept and left-out orders: {orders}")


run_cases(globals())
