#!/usr/bin/env python3
"""Waves and defects of balls have their lines. With a URL as argument the checks talk to a service that runs there."""

import os
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), os.pardir))
from cases import metrics, run_cases, verdict  # noqa: E402

Y, Z = "spindle.y.displacement", "spindle.z.displacement"
ACCELERATION = "spindle.y.acceleration"


def one_ball(order, level="planar"):
    """The article's bearing without clearance, load and weight at 1000 r/min, one of its seven balls with a wave of 10 nm."""
    ball = {"ball": 3, "waviness": [{"order": order, "amplitude_nm": 10, "phase_deg": 20}]}
    return {"kind": "simulation", "settle_s": 0.3, "duration_s": 2.0, "solver": {"rung": level},
            "outputs": {"metrics": ["vibration"], "spectra": [Y, Z]},
            "scene": {"bearing": {"preset": "article-integrated", "radial_clearance_um": -4}, "gravity_m_s2": 0,
                      "operation": {"speed_rpm": 1000}, "surfaces": {"balls": [ball]}}}


def motor(surfaces, **fields):
    """A 6205 under 500 N at 1797 r/min."""
    return {"kind": "simulation", "settle_s": 0.2, "duration_s": 1.0, "solver": {"rung": "planar"}, "outputs": {"spectra": [ACCELERATION]},
            "scene": {"bearing": "6205", "operation": {"speed_rpm": 1797, "radial_load_y_n": 500}, "surfaces": surfaces}, **fields}


def dent(**fields):
    return {"balls": [{"ball": 1, "defects": [{"diameter_mm": 2, "depth_um": 10, **fields}]}]}


def amplitude(found, channel, label):
    """Amplitude of a labelled line [nm]; 0 without it."""
    lines = [line for line in found.get("lines", []) if line["channel"] == channel and line["label"] == label]
    return 1000 * max((line["amplitude"] for line in lines), default=0)


def case_even_wave(running):
    for level in ["planar", "radially_condensed", "spindle_only"]:
        for order in [2, 4]:
            found = metrics(running, one_ball(order, level))
            sides = [amplitude(found, channel, f"{order}·BSF {sign} FTF") for channel in (Y, Z) for sign in "−+"]
            verdict(all(abs(side / 2.857 - 1) < 0.02 for side in sides),
                    f"wave of order {order} on one ball of seven, {level}: 2.857 nm at {order}·BSF ∓ FTF in y and z: {sides}")


def case_odd_wave(running):
    found = metrics(running, one_ball(3))
    largest = max((1000 * line["amplitude"] for line in found.get("lines", [])), default=0)
    verdict(found and largest < 0.03, f"a wave of order 3 does not change the diameter of its ball: {largest} nm at most")


def case_defect(running):
    found = metrics(running, motor(dent()))
    names = [line["label"] for line in found.get("envelope_lines", []) if line["channel"] == ACCELERATION][:8]
    beside = [name for name in names if "BSF" in name]
    verdict("FTF" in names and beside, f"defect of a ball, envelope lines at FTF and at 2·BSF with sidebands: {names}")


def case_resolve_describes_balls(running):
    surfaces = dent()
    surfaces["balls"][0]["waviness"] = [{"order": 4, "amplitude_nm": 10}, {"order": 90000, "amplitude_nm": 10}]
    answer = running.request("POST", "/v1/scenes/resolve", {"scene": motor(surfaces)["scene"]})[2]
    balls = answer.get("derived", {}).get("surfaces", {}).get("balls", [{}])
    of = [balls[0].get(ring, {}) for ring in ("inner", "outer")]
    kept = [[wave["order"] for wave in one.get("waves", [])] for one in of]
    drops = [(one.get("defects") or [{}])[0].get("edge_drop_um", 0) for one in of]
    verdict(kept == [[4], [4]] and drops[0] > drops[1] > 0, f"kept orders and drops at inner and outer raceway: {kept}, {drops} µm")


def refused(running, job, pointer):
    status, _, answer = running.request("POST", "/v1/jobs", job)
    errors = answer.get("errors", []) if isinstance(answer, dict) else []
    verdict(status == 422 and [error["pointer"] for error in errors] == [pointer], f"refused at {pointer}: {status} {errors}")


def case_refusals(running):
    refused(running, motor(dent(latitude_deg=10)), "/solver/rung")
    refused(running, motor(dent(), solver={"rung": "radially_condensed"}), "/solver/rung")
    refused(running, motor(dent(diameter_mm=7.9)), "/scene/surfaces/balls/0/defects/0/diameter_mm")
    refused(running, one_ball(2, "periodic"), "/solver/rung")
    refused(running, motor(dent(), solver={"rung": "planar", "method": "dormand_prince", "fixed_step_us": 50}), "/solver/fixed_step_us")


run_cases(globals())
