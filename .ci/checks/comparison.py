#!/usr/bin/env python3
"""A measured record beside a prediction, over HTTP: a run's own series, changed in known ways. With a URL as argument the requests go there."""

import math
import os
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), os.pardir))
from cases import run_cases, verdict  # noqa: E402

CHANNEL = "spindle.y.acceleration"
RATE = 102400
SPEED = 6000
# An inner spall has lines, sidebands and an envelope.
JOB = {"kind": "simulation", "settle_s": 0.1, "duration_s": 0.5, "outputs": {"spectra": [CHANNEL], "series": [CHANNEL]},
       "scene": {"bearing": "6205", "operation": {"speed_rpm": SPEED, "radial_load_y_n": 500},
                 "surfaces": {"inner": {"defects": [{"length_mm": 0.6, "depth_um": 20}]}}}}
KEPT = {}


def predicted(running):
    """Path of the run, and its series."""
    if not KEPT:
        path, _ = running.submit(JOB)
        ended = running.ended(path)
        if ended["status"] != "succeeded":
            sys.exit(f"FAILED: {ended}")
        KEPT["path"], KEPT["values"] = path, running.request("GET", f"{path}/series?channel={CHANNEL}")[2]["value"]
    return KEPT["path"], KEPT["values"]


def uploaded(running, rate, values):
    return running.request("POST", "/v1/series", {"rate_hz": rate, "values": values})[2]["hash"]


def compared(running, rate, values, **more):
    path, _ = predicted(running)
    body = {"series": uploaded(running, rate, values), "unit": "m/s2"} | more
    status, _, answer = running.request("POST", f"{path}/comparison", body)
    if status != 200:
        sys.exit(f"FAILED: a comparison gives {status}: {answer}")
    return answer


def lines(answer):
    """Lines with labels. Others are peaks of the stored spectrum, whose four digits are up to 0.004 dB."""
    return [line for line in answer["lines"] if line["label"]] + answer.get("envelope", {}).get("lines", [])


def worst(answer, ratio_db, percent):
    ratios = max(abs(one["level_ratio_db"] - ratio_db) for one in answer["levels"] + lines(answer))
    return ratios, max(abs(line["order_difference_percent"] - percent) for line in lines(answer))


def case_own_series(running):
    answer = compared(running, RATE, predicted(running)[1], speed_rpm=SPEED)
    ratio, difference = worst(answer, 0, 0)
    verdict(ratio < 1e-3 and difference < 1e-4, f"a run's own series differs by {ratio:.1e} dB and {difference:.1e} %")
    weak = max((abs(line["level_ratio_db"]) for line in answer["lines"] if not line["label"]), default=0)
    verdict(weak < 0.01, f"its weaker peaks differ by {weak:.1e} dB")
    verdict(len(answer["lines"]) >= 10 and not answer["unmatched"]["predicted"], f"{len(answer['lines'])} lines have partners")
    labels = [line["label"] for line in answer.get("envelope", {}).get("lines", [])]
    verdict("BPFI" in labels, f"lines of the envelope are compared, too: {labels[:4]}")
    verdict(len(answer["levels"]) == 8 and "apparent transfer" in answer["notes"][0], f"{len(answer['levels'])} levels, named a transfer")


def case_twice_the_amplitude(running):
    double = [2 * value for value in predicted(running)[1]]
    ratio, difference = worst(compared(running, RATE, double, speed_rpm=SPEED), 6.0206, 0)
    verdict(ratio < 0.01 and difference < 1e-4, f"twice the amplitude is 6.021 dB to {ratio:.1e} dB")
    answer = compared(running, RATE, double, speed_rpm=SPEED, gain=0.5)
    verdict(worst(answer, 0, 0)[0] < 0.01 and abs(answer["gain"]["db"] + 6.0206) < 1e-3, f"a gain takes it back: {answer['gain']}")


def case_stretched_time(running):
    """The record as a faster recorder would have it: every frequency is 1 % higher."""
    values = predicted(running)[1]
    values = values + values[:RATE // 50]
    nominal = compared(running, 1.01 * RATE, values, speed_rpm=SPEED)
    fast = 1.01 * SPEED / 60
    pulses = [k / fast for k in range(int(len(values) / (1.01 * RATE) * fast) + 1)]
    tracked = compared(running, 1.01 * RATE, values, tachometer={"pulse_times_s": pulses})
    strong = [line for line in nominal["lines"] if line["label"] in ("BPFI", "2·BPFI", "3·BPFI")]
    off = max(abs(line["order_difference_percent"] - 1) for line in strong)
    verdict(bool(strong) and off < 0.02, f"time stretched by 1 %: orders differ by 1 % to {off:.1e} %")
    difference = max(abs(line["order_difference_percent"]) for line in tracked["lines"] if line["label"] in [one["label"] for one in strong])
    verdict(difference < 0.02, f"with its tachometer by {difference:.1e} %")
    signal = [1.0 if math.sin(2 * math.pi * 4 * fast * k / RATE + 1e-9) >= 0 else 0.0 for k in range(int(0.52 * RATE))]
    body = {"series": uploaded(running, RATE, signal), "pulses_per_turn": 4}
    tracked = compared(running, 1.01 * RATE, values, tachometer=body)
    verdict(abs(tracked["measured"]["speed_rpm"] / (60 * fast) - 1) < 1e-4, f"its signal gives {tracked['measured']['speed_rpm']:.2f} r/min")


def case_lower_rate(running):
    """Every fourth value holds 10 kHz: bands above and the envelope are left out, and said to be."""
    quarter = predicted(running)[1][::4]
    answer = compared(running, RATE / 4, quarter, speed_rpm=SPEED)
    notes = " ".join(answer["notes"])
    verdict(abs(answer["to_hz"] - 0.1 * RATE) < 1e-6 and "envelope" not in answer and "envelope" in notes, f"up to {answer['to_hz']} Hz: {notes[-200:]}")


def case_refusals(running):
    path, values = predicted(running)
    good = {"series": uploaded(running, RATE, values), "unit": "m/s2", "speed_rpm": SPEED}
    for body, pointer in [
        ({name: value for name, value in good.items() if name != "speed_rpm"}, "/speed_rpm"),
        (good | {"unit": "mm/s"}, "/unit"),
        (good | {"channel": "spindle.z.acceleration"}, "/channel"),
        (good | {"series": uploaded(running, RATE, values[:1000])}, "/series"),
        (good | {"bands_hz": [300, 50]}, "/bands_hz/1"),
    ]:
        status, _, answer = running.request("POST", f"{path}/comparison", body)
        pointers = [error["pointer"] for error in answer.get("errors", [])]
        verdict(status == 422 and pointers == [pointer], f"refused at {pointer}: {status} {answer.get('detail', '')[:100]}")


run_cases(globals())
