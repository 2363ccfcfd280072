#!/usr/bin/env python3
"""A vibration analyst's questions: where a spall rings, what a study over its length says, and what a description of surfaces leaves out. With a URL
as argument the checks talk to a service that runs there."""

import os
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), os.pardir))
from cases import finished, metrics, run_cases, verdict  # noqa: E402

Y = "spindle.y.acceleration"
BAND = [890, 3500]


def motor(surfaces, **fields):
    """A 6205 under 500 N at 1797 r/min."""
    return {"kind": "simulation", "settle_s": 0.2, "duration_s": 0.3, "solver": {"rung": "planar"},
            "scene": {"bearing": "6205", "operation": {"speed_rpm": 1797, "radial_load_y_n": 500}, "surfaces": surfaces}, **fields}


def spall(**fields):
    return {"outer": {"defects": [{"length_mm": 0.6, "depth_um": 50, **fields}]}}


def resolved(running, job):
    return running.request("POST", "/v1/scenes/resolve", job)[2]


def codes(answer):
    return [message["code"] for message in answer.get("messages", [])]


def strongest(found):
    return max((line["amplitude"] for line in found.get("envelope_lines", []) if line["channel"] == Y), default=0)


def case_resonance(running):
    job = {"scene": motor(spall())["scene"]}
    answer = resolved(running, job)
    found = [round(one["frequency_hz"]) for one in answer.get("derived", {}).get("resonances", [])]
    verdict(len(found) == 2 and 1000 < found[0] < 1250 and 1650 < found[1] < 1900, f"resonances of the spindle on its contacts: {found} Hz")
    verdict("missed-resonance" in codes(answer), "the default band of the envelope leaves them out, and resolve says so")
    wide, narrow = metrics(running, motor(spall())), metrics(running, motor(spall(), outputs={"envelope_band_hz": BAND}))
    verdict("missed-resonance" in codes(wide) and "missed-resonance" not in codes(narrow), "so does the result; not with the band named there")
    verdict(strongest(narrow) > 3 * strongest(wide) > 0, f"that band raises the strongest line: {strongest(wide):.1f} to {strongest(narrow):.1f} m/s²")


def case_limits_of_waves(running):
    def said(surfaces, code, speed=1797, seconds=1.0):
        job = motor(surfaces, duration_s=seconds)
        job["scene"]["operation"]["speed_rpm"] = speed
        return code in codes(resolved(running, {field: job[field] for field in ("scene", "duration_s")}))

    def wave(order, amplitude):
        return {"outer": {"waviness": [{"order": order, "amplitude_nm": amplitude}]}}

    verdict(said(wave(300, 1000), "bridged-troughs") and not said(wave(300, 300), "bridged-troughs"), "a trough that a ball bridges is told")
    rough = {"outer": {"random_waviness": {"amplitude_nm": 20, "exponent": 0, "from_order": 601, "to_order": 1000}}}
    verdict(said(rough, "rough-contact") and not said(wave(2, 5000), "rough-contact"), "roughness above the film is told")
    verdict(said(wave(10, 10), "merged-cage-lines", 30, 20) and not said(wave(10, 10), "merged-cage-lines"), "a cage too slow for the spectra is told")


def case_squared_envelope(running):
    found = metrics(running, motor(spall(), outputs={"envelope_band_hz": BAND, "envelope": "squared"}))
    verdict(found.get("envelope") == "squared" and strongest(found) > 0, "lines of the squared envelope")
    ended = finished(running, motor(spall(), outputs={"envelope_band_hz": BAND, "envelope": "squared"}))
    picture = running.request("GET", f"/v1/jobs/{ended.get('id')}/plots/envelope.svg")[2]
    text = picture.decode() if isinstance(picture, bytes) else str(picture)
    verdict("Squared-envelope spectrum" in text and "(m/s²)²" in text, "its plot is labelled")


def case_study_over_the_length(running):
    job = motor(spall(), kind="study", outputs={"metrics": ["vibration"], "envelope_band_hz": BAND},
                axes=[{"path": "/surfaces/outer/defects/0/length_mm", "values": [0.2, 0.6]}])
    ended = finished(running, job)
    rows = running.request("GET", f"/v1/jobs/{ended['id']}/table")[2]["rows"] if ended else []
    found = [row.get("metrics", {}).get("channels", {}).get(Y, {}).get("envelope", {}).get("ball_pass_outer", {}) for row in rows]
    first = [one.get("first", 0) for one in found]
    verdict(len(first) == 2 and first[1] > 4 * first[0] > 0, f"BPFO of the envelope along the length: {first} m/s²")
    verdict(all(0.1 < one.get("first_over_rms", 0) < 2 for one in found), "its ratio to the rms is a column, too")


def case_optimum_over_an_envelope(running):
    metric = f"/channels/{Y}/envelope/ball_pass_outer/first_over_rms"
    job = motor(spall(), kind="optimum", metric=metric, goal="maximum",
                axes=[{"path": "/surfaces/outer/defects/0/length_mm", "from": 0.2, "to": 0.6}])
    status, _, answer = running.request("POST", "/v1/jobs", job)
    verdict(status == 202, f"an optimum takes an envelope over the rms: status {status}")
    running.request("POST", f"/v1/jobs/{answer.get('id')}/cancel")


def case_one_name_of_an_item(running):
    axes = [{"path": f"/surfaces/outer/defects/{item}/length_mm", "values": [0.2, 0.4]} for item in ("0", "00")]
    status, _, answer = running.request("POST", "/v1/jobs", motor(spall(), kind="study", axes=axes))
    verdict(status == 422 and "has no item 00" in str(answer), f"items 0 and 00 are not two fields: status {status}")


def case_waves_that_change_nothing(running):
    waves = {"outer": {"waviness": [{"order": order, "amplitude_nm": 100} for order in (8, 5000)]}}
    answer = resolved(running, {"scene": motor(waves)["scene"]})
    stated = [message for message in answer.get("messages", []) if message["code"] == "waves-left-out"]
    verdict([(one.get("order"), one.get("count")) for one in stated] == [(5000, 1)], "a wave of order 5000 is told to change nothing")


def case_rates_below_the_resolution(running):
    job = motor(spall(), settle_s=0.05, duration_s=0.2, outputs={"metrics": ["vibration"], "spectra": []})
    job["scene"]["operation"]["speed_rpm"] = 100
    envelope = metrics(running, job).get("channels", {}).get(Y, {}).get("envelope", {})
    found = {name: envelope[name].get("first") for name in ("shaft", "cage", "ball_pass_outer") if name in envelope}
    verdict(set(found.values()) == {None}, f"0.2 s have no lines at 0.7, 1.7 and 6 Hz: {found}")


def case_balls_that_stay_in_a_defect(running):
    job = motor({"outer": {"defects": [{"length_mm": 1, "depth_um": 10}]}}, solver={"rung": "radially_condensed"})
    job["scene"]["bearing"] = {"preset": "6205", "cage": {"seat": "closed", "offset_mm": 0}}
    level = lambda rung: metrics(running, job | {"solver": {"rung": rung}}).get("channels", {}).get(Y, {}).get("level_db", 0)
    off = level("radially_condensed") - level("planar")
    verdict(abs(off) < 0.05, f"a spall as deep as 0.98 of the approach on radially_condensed: {off:.3f} dB from planar")


run_cases(globals())
