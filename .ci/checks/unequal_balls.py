#!/usr/bin/env python3
"""Balls of unequal size and pockets of uneven spacing move the spindle at multiples of the cage speed. With a URL as argument the checks talk to
a service that runs there."""

import os
import sys
import time

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), os.pardir))
from cases import run_cases, verdict  # noqa: E402

DISPLACEMENTS = ["spindle.y.displacement", "spindle.z.displacement"]


def preloaded(level, load=0, surfaces=None, cage=None, balls=7):
    """The article's bearing with a preload, without weight, at 1000 r/min: nothing moves it but what differs from ball to ball."""
    bearing = {"preset": "article-integrated", "radial_clearance_um": -4, "ball_count": balls} | ({"cage": cage} if cage else {})
    scene = {"bearing": bearing, "gravity_m_s2": 0, "operation": {"speed_rpm": 1000, "radial_load_y_n": load}}
    return {"kind": "simulation", "settle_s": 0.3, "duration_s": 1.0, "solver": {"rung": level},
            "outputs": {"metrics": ["vibration"], "spectra": DISPLACEMENTS}, "scene": scene | ({"surfaces": surfaces} if surfaces else {})}


def moves(running, job, multiple, expected, what):
    """The strongest line of each displacement: a multiple of FTF within a fifth of a bin of the spectrum of 1 s, amplitudes [nm] within 2 %."""
    status, _, answer = running.request("POST", "/v1/jobs", job)
    if status != 202:
        verdict(False, f"{what}: {answer}")
        return
    path = f"/v1/jobs/{answer['id']}"
    running.ended(path, at_most=600)
    metrics = running.request("GET", f"{path}/metrics")[2]
    lines = [next((line for line in metrics.get("lines", []) if line["channel"] == channel), None) for channel in DISPLACEMENTS]
    found = [(line["frequency_hz"], 1000 * line["amplitude"], line["label"]) for line in lines if line]
    frequency = multiple * metrics.get("frequencies_hz", {}).get("cage", 0)
    label = "FTF" if multiple == 1 else f"{multiple}·FTF"
    # Single precision does not resolve the acceleration of such a slow motion. Its lines then have no label.
    labels = (label, "") if job["solver"]["rung"] == "radially_condensed" else (label,)
    holds = len(found) == 2 and all(
        abs(at - frequency) < 0.2 and abs(size / amplitude - 1) < 0.02 and name in labels
        for (at, size, name), amplitude in zip(found, expected))
    verdict(holds, f"{what}: {expected} nm at {label}, {frequency:.2f} Hz, found {found}")


def refused(running, job, pointer, words, what):
    status, _, answer = running.request("POST", "/v1/jobs", job)
    errors = answer.get("errors", []) if isinstance(answer, dict) else []
    holds = status == 422 and any(error["pointer"] == pointer and words in error["detail"] for error in errors)
    verdict(holds, f"{what}: {status} {errors}")


def case_one_larger_ball(running):
    larger = {"balls": [{"ball": 3, "diameter_um": 0.05}]}
    for level in ["planar", "radially_condensed", "spindle_only"]:
        moves(running, preloaded(level, surfaces=larger), 1, [14.32, 14.32], f"a ball larger by 0.05 µm on {level}")


def case_two_opposite_balls(running):
    two = {"balls": [{"ball": 2, "diameter_um": 1}, {"ball": 6, "diameter_um": 1}]}
    moves(running, preloaded("radially_condensed", load=50, surfaces=two, balls=8), 2, [62.1, 60.1], "two opposite balls larger by 1 µm")


def case_uneven_pockets(running):
    uneven = {"pocket_spacing_mrad": [0, 0, 10, 0, 0, 0, 0]}
    for level in ["planar", "radially_condensed", "spindle_only"]:
        moves(running, preloaded(level, cage=uneven), 1, [3.810, 3.810], f"a pocket off by 10 mrad on {level}")


def case_no_motion_repeats(running):
    larger = preloaded("periodic", surfaces={"balls": [{"ball": 3, "diameter_um": 0.05}]})
    refused(running, larger, "/solver/rung", "scene.surfaces.balls", "the level periodic names the balls")
    uneven = preloaded("periodic", cage={"pocket_spacing_mrad": [0, 0, 10, 0, 0, 0, 0]})
    refused(running, uneven, "/solver/rung", "pocket_spacing_mrad", "the level periodic names the pockets")


def case_refusals(running):
    balls = "/scene/surfaces/balls"
    for fields, pointer, words in [
            ([{"ball": 8}], f"{balls}/0/ball", "7 balls"),
            ([{"ball": 1}, {"ball": 1}], f"{balls}/1/ball", "both of ball 1"),
            ([{"ball": 1, "diameter_um": 30}], f"{balls}/0/diameter_um", "at most 27.78"),
            ([{"diameter_um": 1}], f"{balls}/0/ball", "missing")]:
        refused(running, preloaded("planar", surfaces={"balls": fields}), pointer, words, f"{fields} is refused by its pointer")
    pockets = "/scene/bearing/cage/pocket_spacing_mrad"
    for spacing, pointer, words in [
            ([0, 1], pockets, "7 pockets"),
            ([0, 600, 0, 0, 0, 0, 0], pockets, "pockets 2 and 3"),
            ([0, 2000, 0, 0, 0, 0, 0], f"{pockets}/1", "from -1000 to 1000 mrad")]:
        job = preloaded("planar", cage={"pocket_spacing_mrad": spacing})
        refused(running, job, pointer, words, f"{spacing} mrad is refused by its pointer")


def case_resolve_lists_the_balls(running):
    job = preloaded("planar", surfaces={"balls": [{"ball": 3, "diameter_um": 0.5}], "every_ball": {"diameter_spread_um": 0.2}})
    answer = running.request("POST", "/v1/scenes/resolve", {"scene": job["scene"]})[2]
    sizes = [ball["diameter_um"] for ball in answer.get("derived", {}).get("surfaces", {}).get("balls", [])]
    mean = sum(sizes) / 7 if len(sizes) == 7 else 0
    verdict(abs(mean - 0.5 / 7) < 1e-9 and max(sizes) > 0.35, f"resolve lists the size of each ball: {sizes}")


def seconds_to_resolve(running, balls):
    """Shortest of three times to resolve a loose bearing whose balls all differ by 20 µm on an oval outer raceway."""
    bearing = {"type": "deep_groove", "ball_count": balls, "ball_diameter_mm": 4, "pitch_diameter_mm": 100, "outer_diameter_mm": 115,
               "inner_diameter_mm": 85, "width_mm": 12, "inner_groove_curvature": 0.52, "outer_groove_curvature": 0.53, "radial_clearance_um": 20}
    surfaces = {"every_ball": {"diameter_spread_um": 20, "random_waviness": {"amplitude_nm": 1, "to_order": 100}},
                "outer": {"waviness": [{"order": 2, "amplitude_nm": 1000}]}}
    scene = {"bearing": bearing, "operation": {"speed_rpm": 0, "axial_load_n": 0.1}, "surfaces": surfaces}
    times = []
    for _ in range(3):
        begin = time.monotonic()
        running.request("POST", "/v1/scenes/resolve", {"scene": scene})
        times.append(time.monotonic() - begin)
    return min(times)


def case_time_grows_with_the_number_of_balls(running):
    # 18 where each ball is eliminated by itself, 54 to 86 with a dense matrix.
    few, many = (seconds_to_resolve(running, balls) for balls in (8, 64))
    verdict(many < 40 * few, f"an equilibrium of 64 balls takes {many / few:.0f} times as long as one of 8: {few:.3f} and {many:.3f} s")


run_cases(globals())
