#!/usr/bin/env python3
"""Presets of surfaces, flights of balls, and plots of a defect. With a URL as argument the checks talk to a service that runs there."""

import os
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), os.pardir))
from cases import finished, run_cases, verdict  # noqa: E402


def motor(surfaces):
    """A 6205 under 500 N at 1797 r/min."""
    return {"kind": "simulation", "settle_s": 0.1, "duration_s": 0.1, "solver": {"rung": "planar"},
            "scene": {"bearing": "6205", "operation": {"speed_rpm": 1797, "radial_load_y_n": 500}, "surfaces": surfaces}}


def case_presets_give_waviness(running):
    names = running.request("GET", "/v1/presets")[2].get("surfaces", {})
    verdict(list(names) == ["precision", "standard", "worn"], f"qualities of raceways: {list(names)}")
    surfaces = {"preset": "worn", "outer": {"random_waviness": {"amplitude_nm": 3}}}
    answer = running.request("POST", "/v1/scenes/resolve", {"scene": motor(surfaces)["scene"]})[2]
    found = answer.get("scene", {}).get("surfaces", {})
    amplitudes = [found.get(ring, {}).get("random_waviness", {}).get("amplitude_nm") for ring in ("inner", "outer")]
    pointer = "/scene/surfaces/inner/random_waviness/amplitude_nm"
    verdict(amplitudes == [25, 3] and pointer in answer.get("defaults", []), f"preset inside, given field outside: {amplitudes}")


def case_flights_and_plots(running):
    job = finished(running, motor({"outer": {"defects": [{"length_mm": 1, "depth_um": 10}]}}))
    links = job.get("links", {})
    metrics = running.request("GET", links["metrics"])[2] if links else {}
    shares = [metrics.get("contacts", {}).get("inner", {}).get(name) for name in ("mean_off_share", "max_off_share")]
    verdict(None not in shares and 0 < shares[0] <= shares[1] < 0.1, f"share of the time off the inner raceway: {shares}")
    for name in ("envelope_svg", "impact_svg"):
        status, _, body = running.request("GET", links[name]) if name in links else (None, None, b"")
        verdict(status == 200 and bytes(body).startswith(b"<svg"), f"{name} is a picture: {status}")


def case_ideal_raceways_state_no_flights(running):
    links = finished(running, motor({})).get("links", {})
    inner = running.request("GET", links["metrics"])[2]["contacts"]["inner"] if links else {}
    verdict("max_load_n" in inner and "mean_off_share" not in inner and "impact_svg" not in links, f"ideal raceways: {sorted(inner)}")


run_cases(globals())
