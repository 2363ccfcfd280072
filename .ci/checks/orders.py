#!/usr/bin/env python3
"""Orders of run-ups over HTTP: exact angle, tracks beside a direct sum, exact cage orders, waterfalls in every form, refusals. With a URL as
argument the requests go there."""

import cmath
import math
import os
import struct
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.dirname(os.path.abspath(__file__)))))
from cases import finished, run_cases, verdict  # noqa: E402

SETTLE, DURATION, SLOW, FAST = 0.05, 0.8, 1800, 7800
# One run for all cases.
JOBS = {}


def job(orders=None, **more):
    """A run-up of a 6205 with unbalance by 64 turns, 30 to 130 Hz."""
    profile = [{"at_s": SETTLE, "rpm": SLOW}, {"at_s": SETTLE + DURATION, "rpm": FAST}]
    scene = {"bearing": "6205", "spindle": {"unbalance_g_mm": 50}, "operation": {"speed_rpm": profile, "radial_load_y_n": 500}}
    outputs = {"metrics": ["vibration", "cage"], "orders": {"turns_per_block": 16} | (orders or {})}
    return {"kind": "simulation", "scene": scene, "settle_s": SETTLE, "duration_s": DURATION, "outputs": outputs} | more


def path_of(running):
    if "run-up" not in JOBS:
        ended = finished(running, job())
        JOBS["run-up"] = f"/v1/jobs/{ended['id']}" if ended.get("status") == "succeeded" else None
    return JOBS["run-up"]


def turns(time):
    """Turns since the end of settling."""
    elapsed, slope = time - SETTLE, (FAST - SLOW) / 60 / DURATION
    return SLOW / 60 * elapsed + 0.5 * slope * elapsed**2


def speed(time):
    return (SLOW + (FAST - SLOW) * (time - SETTLE) / DURATION) / 60


def case_angle_and_speeds_are_exact(running):
    path = path_of(running)
    if not path:
        return verdict(False, "a run-up with orders is accepted")
    answer = running.request("GET", f"{path}/orders")[2]
    last = turns(SETTLE + DURATION - 1 / 102400)
    verdict(abs(answer["turns"] - last) < 1e-6, f"{answer['turns']} turns of {last:.6f}")
    wrong = [abs(60 * speed(time) / rpm - 1) for time, rpm in zip(answer["time_s"], answer["speed_rpm"])]
    verdict(len(wrong) == 6 and max(wrong) < 1e-8, f"{len(wrong)} blocks at the speed of their middle")
    return None


def case_tracks_are_the_sums_of_their_definition(running):
    path = path_of(running)
    if not path:
        return verdict(False, "a run-up with orders is accepted")
    answer = running.request("GET", f"{path}/orders?tracks=1,3.5")[2]
    series = running.request("GET", f"{path}/series?channel=spindle.y.acceleration")[2]
    for track in answer["tracks"]:
        total = weight = 0
        for time, value in zip(series["time_s"], series["value"]):
            at = turns(time)
            share = (at - 16) / 16
            if 0 <= share <= 1:
                window = (0.5 - 0.5 * math.cos(2 * math.pi * share)) * speed(time)
                total += window * value * cmath.exp(-2j * math.pi * track["order"] * at)
                weight += window
        direct = 2 * abs(total) / weight
        verdict(abs(track["amplitude"][2] / direct - 1) < 1e-3, f"order {track['name']}: {track['amplitude'][2]}, directly {direct:.5g}")
    return None


def case_cage_orders_are_exact(running):
    path = path_of(running)
    if not path:
        return verdict(False, "a run-up with orders is accepted")
    answer = running.request("GET", f"{path}/orders?reference=cage&tracks=BPFO,2*BPFO,FTF&turns_per_block=8")[2]
    orders = {track["name"]: track["order"] for track in answer["tracks"]}
    verdict(orders == {"BPFO": 9, "2·BPFO": 18, "FTF": 1}, f"orders of the cage {orders}")
    verdict(answer["names_follow"] == "simulated", "names follow the simulated cage and ball")
    by_shaft = running.request("GET", f"{path}/orders?tracks=FTF,BPFO,0.45")[2]["tracks"]
    verdict(abs(by_shaft[0]["order"] - 0.3985) < 0.01, f"FTF is order {by_shaft[0]['order']} of the shaft")
    verdict(by_shaft[0]["beats_with"] == ["0.45"] and by_shaft[2]["beats_with"] == ["FTF"], "orders closer than 2/turns beat")
    return None


def case_waterfall_has_every_form(running):
    path = path_of(running)
    if not path:
        return verdict(False, "a run-up with orders is accepted")

    def get(query, kind):
        return running.request("GET", f"{path}/waterfall{query}", headers={"Accept": kind})[2]

    for query, unit in (("", "hz"), ("?axis=order", "order")):
        answer = get(query, "application/json")
        rows, columns = len(answer["speed_rpm"]), len(answer["axis"])
        verdict(len(answer["amplitude"]) == rows * columns and answer["axis_unit"] == unit, f"{rows} × {columns} bins, {unit}")
        table = get(query, "application/x-npy")
        head = 10 + struct.unpack("<H", table[8:10])[0]
        values = struct.unpack(f"<{(rows + 1) * (columns + 1)}f", table[head:])
        first = [answer["speed_rpm"][0], *answer["amplitude"][:columns]]
        near = all(abs(one - other) <= 1e-6 * abs(other) for one, other in zip(values[columns + 1:], first))
        verdict(near, "NPY has the speed in its first column, then the amplitudes")
        lines = get(query, "text/csv").decode().splitlines()
        verdict(len(lines) == rows + 1 and [float(cell) for cell in lines[1].split(",")] == first, "CSV has the same rows")
    smear = get("", "application/json")["smear_bins"]
    verdict(smear is not None and smear <= 1.01, f"BPFI moves by {smear} bins in a window")
    picture = get("?width=320&height=200&range_db=50", "image/png")
    verdict(picture[:8] == b"\x89PNG\r\n\x1a\n" and struct.unpack(">II", picture[16:24]) == (320, 200), "PNG of 320 × 200 pixels")
    svg = get("", "image/svg+xml").decode()
    verdict("data:image/png;base64," in svg and "BPFO" in svg and "shaft speed" in svg, "SVG with axes, colours and labelled orders")
    return None


def case_plots_of_a_run_up(running):
    path = path_of(running)
    if not path:
        return verdict(False, "a run-up with orders is accepted")
    spectrum = running.request("GET", f"{path}/plots/spectrum.svg")[2].decode()
    verdict('href="waterfall.svg"' in spectrum and "1800 to 7800 r/min" in spectrum, "the spectrum of a run-up leads to the waterfall")
    verdict("shaft 8" not in spectrum and "BPFO 2" not in spectrum, "and prints no single shaft frequency")
    for name in ("waterfall", "orders"):
        status, _, svg = running.request("GET", f"{path}/plots/{name}.svg")
        verdict(status == 200 and svg.startswith(b"<svg"), f"{name}.svg")
    links = running.request("GET", path)[2]["links"]
    verdict(links.get("waterfall_svg") == f"{path}/plots/waterfall.svg" and "orders" in links, "the job links them")
    return None


def case_refusals(running):
    back = [{"at_s": 0.1, "rpm": 1000}, {"at_s": 0.3, "rpm": -1000}]
    reversing = job()
    reversing["scene"]["operation"]["speed_rpm"] = back
    bare = job({"reference": "cage"})
    bare["scene"]["terms"] = {"cage": "off"}
    bare["outputs"]["metrics"] = ["vibration"]
    large = job({"max_order": 79, "overlap": 0.9}, duration_s=20)
    large["scene"]["operation"]["speed_rpm"] = 30000
    cases = [
        (job({"turns_per_block": 65}), "/outputs/orders/turns_per_block"),
        (job({"max_order": 5000}), "/outputs/orders/max_order"),
        (job({"overlap": 1}), "/outputs/orders/overlap"),
        (job({"tracks": ["1", "BPF"]}), "/outputs/orders/tracks/1"),
        (job({"channels": ["spindle.w.acceleration"]}), "/outputs/orders/channels/0"),
        (reversing, "/outputs/orders"),
        (bare, "/outputs/orders/reference"),
        (large, "/outputs/orders"),
    ]
    for body, pointer in cases:
        status, _, answer = running.request("POST", "/v1/jobs", body)
        found = [error["pointer"] for error in answer.get("errors", [])]
        verdict(status == 422 and found == [pointer], f"{pointer}: {status} {found}")
    path = path_of(running)
    if not path:
        return verdict(False, "a run-up with orders is accepted")
    for query, text in (("orders?turns_per_block=76", "turns_per_block"), ("orders?tracks=x", "tracks/0"), ("waterfall?width=5", "width"),
                        ("waterfall?window_s=2", "window_s"), ("waterfall?max_frequency_hz=60000", "max_frequency_hz")):
        status, _, answer = running.request("GET", f"{path}/{query}")
        verdict(status == 400 and text in answer["detail"], f"{query}: {status} {answer['detail']}")
    return None


if __name__ == "__main__":
    run_cases(globals())
