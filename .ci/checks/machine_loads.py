#!/usr/bin/env python3
"""Loads on places of a shaft and run-ups of machine jobs, against closed forms and the linear analysis; orders and waterfalls labelled by bearing.
With a URL as argument the requests go there."""

import math
import os
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.dirname(os.path.abspath(__file__)))))
from cases import finished, run_cases, verdict  # noqa: E402

# A disc of 10 kg on springs of 4 MN/m: angular frequency.
STIFFNESS, MASS = 4e6, 10
FREQUENCY = math.sqrt(STIFFNESS / MASS)


def spindle(loads=(), unbalance=True, **operation):
    """A bar with a disc in the middle on two preloaded bearings under loads."""
    disc = {"at_mm": 150, "mass_kg": 1.2, "transverse_inertia_kg_m2": 8e-4, "axial_inertia_kg_m2": 1.5e-3}
    shaft = {"sections": [{"length_mm": 300, "outer_diameter_mm": 25}], "discs": [disc]}
    if unbalance:
        shaft["unbalances"] = [{"at_mm": 150, "unbalance_g_mm": 20}]
    return {"shaft": shaft,
            "bearings": [{"name": name, "bearing": "6205", "at_mm": at, "faces": faces} for name, at, faces in (("A", 40, "+x"), ("B", 260, "-x"))],
            "preloads": [{"between": ["A", "B"], "force_n": 200}],
            "sensors": [{"name": "probe", "at_mm": 200, "direction": "y"}],
            "operation": {"speed_rpm": 12000, "loads": list(loads), **operation}}


def oscillator(loads=(), ratio=0.0, unbalance_g_mm=0, speed=0):
    """A rigid shaft without mass with a disc in the middle on two springs. A short bar stands in for it."""
    damping = ratio * MASS * FREQUENCY
    return {"shaft": {"sections": [{"length_mm": 300, "outer_diameter_mm": 200}], "axial": "fixed", "damping_ratio": 0,
                      "material": {"elastic_modulus_gpa": 2000, "poisson_ratio": 0.3, "density_kg_m3": 10},
                      "discs": [{"at_mm": 150, "mass_kg": MASS - 10 * 0.3 * math.pi * 0.01, "transverse_inertia_kg_m2": 0.1, "axial_inertia_kg_m2": 0.1}],
                      "unbalances": [{"at_mm": 150, "unbalance_g_mm": unbalance_g_mm}]},
            "supports": [{"at_mm": at, "stiffness_n_per_um": [0, 2, 2], "damping_n_s_per_m": [0, damping, damping]} for at in (0, 300)],
            "sensors": [{"name": axis, "at_mm": 150, "direction": axis} for axis in "yz"],
            "gravity_m_s2": 0, "operation": {"speed_rpm": speed, "loads": list(loads)}}


def machine(running, scene, view="machine", **fields):
    """A view of the finished job; empty where it has none."""
    ended = finished(running, {"kind": "machine", "scene": scene, "settle_s": 0, "duration_s": 0.05, **fields})
    if ended.get("status") != "succeeded":
        print(ended.get("error"))
        return {}
    return running.request("GET", f"/v1/jobs/{ended['id']}/{view}")[2]


def of(answer, channel, field):
    return answer.get("channels", {}).get(channel, {}).get(field, math.nan)


def case_constant_load_is_the_static_deflection(running):
    loads = [{"on": "shaft", "at_mm": 200, "direction": "y", "constant_n": 150}, {"at_mm": 290, "direction": "about_z", "constant_n_m": 3}]
    scene = spindle(loads, unbalance=False)
    status, _, rotor = running.request("POST", "/v1/rotor", {"kind": "rotor", "scene": scene, "speeds_rpm": [0]})
    seen = of(machine(running, scene, settle_s=0.05, duration_s=0.02), "sensor.probe.displacement", "mean")
    static = math.nan
    if status == 200:
        node = min(range(len(rotor["nodes_mm"])), key=lambda node: abs(rotor["nodes_mm"][node] - 200))
        static = rotor["static"]["y_um"][node]
    verdict(abs(seen / static - 1) < 1e-3, f"deflection under a load and a moment: {seen} µm, static {static} µm")


def case_rotating_load_is_an_unbalance(running):
    force = 20e-6 * (12000 * math.pi / 30) ** 2
    loads = [{"at_mm": 150, "rotating": {"amplitude_n": force, "order": 1}}]
    levels = [of(machine(running, scene), "sensor.probe.acceleration", "level_db") for scene in (spindle(), spindle(loads, unbalance=False))]
    verdict(abs(levels[0] - levels[1]) < 1e-6, f"an unbalance and a rotating load of its force give one level: {levels} dB")


def case_harmonic_load_below_the_resonance(running):
    load = {"at_mm": 150, "direction": "y", "harmonic": {"amplitude_n": 100, "frequency_hz": 5}}
    answer = machine(running, oscillator([load]), duration_s=0.4)
    factor = of(answer, "sensor.y.displacement", "peak") * 1e-6 * STIFFNESS / 100
    verdict(abs(factor - 1) < 0.004, f"a harmonic load of 5 Hz moves the disc by {factor:.4f} F/K")
    load["harmonic"]["frequency_hz"] = 1500
    lines = machine(running, spindle([load]), duration_s=0.2).get("lines", [])
    found = [line["frequency_hz"] for line in lines if line["label"] == "load" and line["channel"].startswith("sensor")]
    verdict(len(found) == 1 and abs(found[0] - 1500) < 5, f"a harmonic load of 1500 Hz has the line `load`: {found}")


def case_shock(running):
    load = {"at_mm": 150, "direction": "y", "shock": {"peak_n": 100, "at_s": 2e-3, "duration_s": math.pi / FREQUENCY}}
    series = machine(running, oscillator([load]), "series", outputs={"series": ["sensor.y.displacement"]})
    factor = 1e-6 * max(series.get("value", [math.nan])) * STIFFNESS / 100
    verdict(abs(factor - math.pi / 2) < 1e-3, f"response factor of a shock of half a period: {factor:.5f}, π/2 is 1.57080")


def case_uploaded_series(running):
    rate, frequency = 20000, 90
    values = [100 * math.sin(2 * math.pi * frequency * k / rate) for k in range(rate)]
    stored = running.request("POST", "/v1/series", {"rate_hz": rate, "values": values})[2]
    harmonic = {"amplitude_n": 100, "frequency_hz": frequency, "phase_deg": -90}
    loads = [{"at_mm": 150, "direction": "y", "harmonic": harmonic}, {"at_mm": 150, "direction": "y", "series": {"hash": stored.get("hash", "0" * 64)}}]
    rms = [of(machine(running, oscillator([load], ratio=0.05), settle_s=0.3, duration_s=0.2), "sensor.y.displacement", "rms") for load in loads]
    verdict(abs(rms[0] / rms[1] - 1) < 1e-4, f"a harmonic load and its values give one motion: {rms} µm")


def case_run_up_through_the_resonance(running):
    """Without acceleration the amplitude is 500.03 µm."""
    for acceleration, amplitude in ((400, 291.58), (1600, 185.58)):
        end = 1.2 * FREQUENCY / acceleration
        speed = [{"at_s": 0, "rpm": 0}, {"at_s": end, "rpm": acceleration * end * 30 / math.pi}]
        fields = {"duration_s": end, "outputs": {"series": ["sensor.y.displacement", "sensor.z.displacement"]}}
        ended = finished(running, {"kind": "machine", "scene": oscillator(ratio=0.01, unbalance_g_mm=100, speed=speed), **fields})
        y, z = ([math.nan], [math.nan])
        if ended.get("status") == "succeeded":
            y, z = (running.request("GET", f"/v1/jobs/{ended['id']}/series?channel=sensor.{axis}.displacement")[2]["value"] for axis in "yz")
        seen = max(math.hypot(*at) for at in zip(y, z))
        verdict(abs(seen / amplitude - 1) < 2e-3, f"run-up at {acceleration} rad/s²: {seen:.2f} µm, known {amplitude} µm")


def case_orders_of_a_run_up(running):
    speed = [{"at_s": 0.05, "rpm": 3000}, {"at_s": 1.05, "rpm": 12000}]
    job = {"kind": "machine", "scene": spindle(speed_rpm=speed), "outputs": {"orders": {"turns_per_block": 8}}}
    ended = finished(running, job)
    path = f"/v1/jobs/{ended.get('id')}"
    status, _, orders = running.request("GET", f"{path}/orders")
    tracks = {track["name"]: track for track in orders.get("tracks", [])} if status == 200 else {}
    verdict({"1", "BPFO@A", "BPFO@B", "BPFI@B"} <= set(tracks), f"orders are named by bearing: {sorted(tracks)}")
    verdict(orders.get("channel") == "sensor.probe.acceleration" and orders.get("names_follow") == "simulated", f"orders of {orders.get('channel')}")
    first = tracks.get("1", {"amplitude": [0, 0]})["amplitude"]
    speeds = orders.get("speed_rpm", [1, 1])
    # Far below the first resonance, 480 Hz, acceleration by unbalance grows with the fourth power of the speed.
    power = math.log(max(first[-1], 1e-9) / max(first[0], 1e-9)) / math.log(speeds[-1] / speeds[0]) if len(first) > 1 and speeds[-1] != speeds[0] else 0
    verdict(3.9 < power < 4.5, f"order 1 grows with the speed to the power {power:.2f}")
    for channel in ("A.y.acceleration", "B.z.acceleration"):
        status = running.request("GET", f"{path}/orders?channel={channel}")[0]
        verdict(status == 404, f"the series of {channel} was not asked for: {status}")
    status, _, waterfall = running.request("GET", f"{path}/waterfall?axis=order&tracks=BPFO@B")
    named = [line["name"] for line in waterfall.get("order_lines", [])]
    verdict(status == 200 and named == ["BPFO@B"] and len(waterfall["speed_rpm"]) > 5, f"a waterfall with the order {named}")
    links = ended.get("links", {})
    verdict(all(name in links for name in ("orders", "waterfall", "waterfall_svg", "orders_svg", "series")), f"links {sorted(links)}")
    drawing = running.request("GET", f"{path}/plots/spectrum.svg")[2]
    drawing = drawing.decode() if isinstance(drawing, bytes) else str(drawing)
    verdict("waterfall.svg" in drawing, "the spectrum of a run-up leads to its waterfall")
    for plot in ("waterfall.svg", "orders.svg"):
        verdict(running.request("GET", f"{path}/plots/{plot}")[0] == 200, f"{plot} is drawn")
    status, _, answer = running.request("GET", f"{path}/orders?tracks=BPFO")
    verdict(status == 400 and "BPFO@A" in str(answer), f"BPFO without a bearing is refused: {status} {answer}")


def case_growth_along_a_run_up(running):
    scene = spindle(speed_rpm=[{"at_s": 0, "rpm": 12000}, {"at_s": 0.1, "rpm": 60000}])
    scene["shaft"] |= {"damping_ratio": 0.05, "rotating_share": 1}
    ended = finished(running, {"kind": "machine", "scene": scene, "duration_s": 0.1})
    detail = (ended.get("error") or {}).get("detail", "")
    verdict("rotating_share" in detail and "between" in detail, f"a run-up beyond the threshold of rotating damping: {ended.get('status')}, {detail}")


def case_refusals(running):
    def pointers(scene, **fields):
        status, _, answer = running.request("POST", "/v1/jobs", {"kind": "machine", "scene": scene, **fields})
        return [error["pointer"] for error in answer.get("errors", [])] if status == 422 else [f"status {status}"]

    load, at = {"direction": "y", "constant_n": 1}, "/scene/operation/loads/0"
    held = oscillator([{"direction": "x", "constant_n": 1}])
    silent = {key: value for key, value in oscillator().items() if key != "sensors"}
    cases = {
        "beside the shaft": (spindle([load | {"at_mm": 301}]), f"{at}/at_mm"),
        "on a spindle": (spindle([load | {"on": "spindle"}]), f"{at}/on"),
        "along a held axis": (held, f"{at}/direction"),
        "of two kinds": (spindle([load | {"points": [{"at_s": 0, "n": 1}]}]), at),
        "of an order at rest": (spindle([{"direction": "y", "harmonic": {"amplitude_n": 1, "order": 1}}], speed_rpm=0), f"{at}/harmonic/order"),
        "of an unknown series": (spindle([{"direction": "y", "series": {"hash": "0" * 64}}]), f"{at}/series/hash"),
        "at a negative speed of a profile": (spindle(speed_rpm=[{"at_s": 0, "rpm": -1}, {"at_s": 1, "rpm": 1}]), "/scene/operation/speed_rpm/0/rpm"),
        "without bearings and sensors": (silent, "/scene/sensors"),
    }
    for name, (scene, pointer) in cases.items():
        found = pointers(scene)
        verdict(found == [pointer], f"a load or machine {name} is refused at {found}")
    for outputs, pointer in (({"series": ["C.y.acceleration"]}, "/outputs/series/0"), ({"orders": {"tracks": ["BPFO"]}}, "/outputs/orders/tracks/0"),
                             ({"orders": {"reference": "cage"}}, "/outputs/orders/reference"), ({"spectra": []}, "/outputs/spectra")):
        found = pointers(spindle(), outputs=outputs)
        verdict(found == [pointer], f"{outputs} is refused at {found}")
    job = {"kind": "simulation", "scene": {"bearing": "6205", "operation": {"speed_rpm": 3000, "loads": [load | {"on": "shaft", "at_mm": 1}]}}}
    status, _, answer = running.request("POST", "/v1/jobs", job)
    found = [error["pointer"] for error in answer.get("errors", [])]
    verdict(status == 422 and found == [f"{at}/on", f"{at}/at_mm"], f"a spindle has no places: {found}")


if __name__ == "__main__":
    run_cases(globals())
