#!/usr/bin/env python3
"""Housing bodies, mounts, seats, imported structures and sensors on them, of rotor and machine jobs, against closed forms, limits and each other.
With a URL as argument the requests go there."""

import json
import math
import os
import re
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.dirname(os.path.abspath(__file__)))))
from cases import finished, run_cases, verdict  # noqa: E402

RATIO = 0.3
HEAD = {"name": "head", "mass_kg": 8, "at_mm": 150, "inertia_kg_m2": [0.02, 0.05, 0.05]}
MOUNT = {"body": "head", "stiffness_n_per_um": [50, 20, 50], "damping_n_s_per_m": [300, 300, 300], "tilt_n_m_per_mrad": [20, 20]}
SPRING = {"seat": "sliding", "spring_force_n": 150, "spring_n_per_um": 0.05}


def spindle(first=None, second=None, housing=None, **fields):
    """A motor spindle: a bar with a disc on two bearings, of which the second may slide on a spring."""
    disc = {"at_mm": 150, "mass_kg": 1.2, "transverse_inertia_kg_m2": 8e-4, "axial_inertia_kg_m2": 1.5e-3}
    bearings = [{"name": "A", "bearing": "6205", "at_mm": 40, "faces": "+x", "outer_ring": first or {}},
                {"name": "B", "bearing": "6205", "at_mm": 260, "faces": "-x", "outer_ring": second or {}}]
    scene = {"shaft": {"sections": [{"length_mm": 300, "outer_diameter_mm": 25}], "discs": [disc], "axial": "free",
                       "unbalances": [{"at_mm": 150, "unbalance_g_mm": 20}]},
             "bearings": bearings, "operation": {"speed_rpm": 12000, "radial_load_y_n": 100}}
    if housing:
        scene["housing"] = housing
    if not second or second.get("seat") != "sliding":
        scene["preloads"] = [{"between": ["A", "B"], "force_n": 150}]
    return scene | fields


def in_head(**fields):
    """The spindle in a head on a mount, with a sensor on it and one between shaft and head."""
    sensors = [{"name": "acc", "on": "head", "at_mm": 40, "direction": "y"},
               {"name": "probe", "at_mm": 200, "direction": "z", "relative_to": "head"}]
    fields = {"sensors": sensors, "housing": {"bodies": [HEAD], "mounts": [MOUNT]}} | fields
    return spindle({"on": "head"}, SPRING | {"on": "head"}, **fields)


def pedestals():
    """10 kg on a shaft of 4 MN/m, two bearings of 10⁸ N/m, each on a pedestal of 5 kg and 5·10⁷ N/m. A short, thin bar stands in for the shaft."""
    length, diameter, density = 0.5, 0.03, 10.0
    area, moment = math.pi * diameter**2 / 4, math.pi * diameter**4 / 64
    shear = 6 * (1 + RATIO) / (7 + 6 * RATIO)
    modulus = 4e6 * (length**3 / (48 * moment) + length / (4 * shear * area / (2 * (1 + RATIO))))
    bodies = [{"name": name, "mass_kg": 5, "at_mm": at, "inertia_kg_m2": [0.01] * 3} for name, at in (("left", 0), ("right", 500))]
    return {"shaft": {"material": {"elastic_modulus_gpa": modulus / 1e9, "poisson_ratio": RATIO, "density_kg_m3": density}, "damping_ratio": 0,
                      "sections": [{"length_mm": 250, "outer_diameter_mm": 1e3 * diameter}] * 2, "discs": [{"at_mm": 250, "mass_kg": 10}]},
            "supports": [{"at_mm": body["at_mm"], "stiffness_n_per_um": [0, 100, 100], "on": body["name"]} for body in bodies],
            "housing": {"bodies": bodies,
                        "mounts": [{"body": body["name"], "stiffness_n_per_um": [50, 50, 50], "tilt_n_m_per_mrad": [1000, 1000]} for body in bodies]},
            "operation": {"speed_rpm": 0}}


def rotor(running, scene, **fields):
    status, _, answer = running.request("POST", "/v1/rotor", {"kind": "rotor", "scene": scene, "modes": 12, **fields})
    if status != 200:
        print(status, answer)
        return {}
    return answer


def frequencies(answer):
    return sorted(mode["frequency_hz"] for mode in answer.get("operating", {}).get("modes", []))


def machine(running, scene, **fields):
    job = {"kind": "machine", "scene": scene, "settle_s": 0.1, "duration_s": 0.1, **fields}
    ended = finished(running, job)
    if ended.get("status") != "succeeded":
        print(ended.get("error"))
        return {}
    return running.request("GET", f"/v1/jobs/{ended['id']}/machine")[2]


def case_pedestals_have_the_closed_form(running):
    answer = rotor(running, pedestals())
    found = frequencies(answer)
    for expected in (97.696, 513.445):
        near = [value for value in found if abs(value / expected - 1) < 1e-3]
        verdict(len(near) == 2, f"a mass on two pedestals vibrates at {near} Hz, closed form {expected}")
    carried = sum(mount["static_force_n"][1] for mount in answer.get("mounts", []))
    verdict(abs(carried / (9.81 * 20) - 1) < 1e-3, f"the mounts carry {carried:.2f} N of 20 kg")


def case_stiff_mounts_are_the_ground(running):
    ground = frequencies(rotor(running, spindle(), modes=8))
    mount = MOUNT | {"stiffness_n_per_um": [1e6] * 3, "tilt_n_m_per_mrad": [1e9] * 2}
    stiff = frequencies(rotor(running, spindle({"on": "head"}, {"on": "head"}, {"bodies": [HEAD], "mounts": [mount]}), modes=8))
    worst = max((abs(one / other - 1) for one, other in zip(ground, stiff)), default=math.inf)
    verdict(len(ground) == len(stiff) == 8 and worst < 1e-3, f"mounts of 10⁶ N/µm change frequencies by {worst:.1e}")


def case_spring_preloads_both_bearings(running):
    answer = rotor(running, spindle(second=SPRING | {"spring_n_per_um": 0}, operation={"speed_rpm": 0}))
    forces = [support["static_force_n"][0] for support in answer.get("supports", [])]
    verdict(len(forces) == 2 and all(abs(abs(force) / 150 - 1) < 1e-3 for force in forces), f"a spring of 150 N loads both bearings: {forces} N")


def case_machine_meets_the_linear_analysis(running):
    # The speed of the run itself: the head resonates at 216 Hz, so that 100 r/min change its response by an eighth.
    linear, seen = rotor(running, in_head(), speeds_rpm=[11000, 12000]), machine(running, in_head())
    natural = [mode["frequency_hz"] for mode in seen.get("natural_frequencies", [])]
    below = [value for value in frequencies(linear) if value > 0]
    worst = max((min((abs(one / value - 1) for one in natural), default=math.inf) for value in below), default=math.inf)
    verdict(len(below) == 12 and worst < 1e-3, f"natural frequencies of both kinds differ by {worst:.1e}")
    body = (linear.get("bodies") or [{}])[0]
    mean = seen.get("channels", {}).get("head.y.displacement", {}).get("mean", math.nan)
    static = body.get("static_um", [math.nan] * 3)[1]
    verdict(abs(mean / static - 1) < 0.02, f"the head sinks by {mean} µm, static {static} µm")
    for sensor in linear.get("sensors", []):
        channel = f"sensor.{sensor['name']}.displacement"
        expected = sensor["displacement_um"][linear["speeds_rpm"].index(12000)] / math.sqrt(2)
        rms = seen.get("channels", {}).get(channel, {}).get("rms", math.nan)
        verdict(abs(rms / expected - 1) < 0.05, f"{channel}: {rms:.4f} µm in time, {expected:.4f} µm linear")


def case_stiff_seat_is_the_ground_in_time(running):
    stiff = {"seat": "elastic", "stiffness_n_per_um": [1e6, 1e6], "damping_n_s_per_m": [100, 100]}
    answers = [machine(running, scene, settle_s=0.02, duration_s=0.05) for scene in (spindle(), spindle(stiff, stiff))]
    levels = [answer.get("channels", {}).get("A.y.displacement", {}).get("rms", math.nan) for answer in answers]
    verdict(abs(levels[1] / levels[0] - 1) < 0.01, f"a seat of 10⁶ N/µm is the ground: {levels} µm")


PORT = {"name": "head", "at_mm": 150}
MASSES = [8, 8, 8, 0.05, 0.05]
STIFFNESS = [50e6, 20e6, 50e6, 20e3, 20e3]
DAMPING = [300, 300, 300, 0, 0]


def diagonal(values):
    return [[value if row == column else 0 for column in range(len(values))] for row, value in enumerate(values)]


def as_matrices(ports=None, **fields):
    """The head on its mount as matrices."""
    names = [f"head.{name}" for name in ("x", "y", "z", "about_y", "about_z")]
    matrices = {"coordinates": names, "mass": diagonal(MASSES), "damping": diagonal(DAMPING), "stiffness": diagonal(STIFFNESS)}
    return {"ports": [PORT] if ports is None else ports, "matrices": matrices | fields}


def as_modes(first=None, **fields):
    """The head on its mount as modes."""
    modes = []
    for row, (mass, stiffness, damping) in enumerate(zip(MASSES, STIFFNESS, DAMPING)):
        shape = [float(row == other) for other in range(5)]
        modes.append({"frequency_hz": math.sqrt(stiffness / mass) / (2 * math.pi), "damping_ratio": damping / (2 * math.sqrt(stiffness * mass)),
                      "mass_kg": mass, "shape": {"head": shape}})
    return {"ports": [PORT], "modes": [modes[0] | (first or {}), *modes[1:]]} | fields


def case_imported_structures_are_the_body(running):
    # The structure has no weight, so that the body has none either.
    weightless = {"gravity_m_s2": 0}
    body = rotor(running, in_head(**weightless))
    for name, housing in (("matrices", as_matrices()), ("modes", as_modes())):
        found = rotor(running, in_head(housing=housing, **weightless))
        pairs = list(zip(frequencies(body), frequencies(found)))
        worst = max((abs(one / other - 1) for one, other in pairs), default=math.inf)
        verdict(len(pairs) == 12 and worst < 1e-9, f"{name} of a body change its natural frequencies by {worst:.1e}")
        for one, other in zip(body.get("sensors", []), found.get("sensors", [])):
            worst = max(abs(a - b) for a, b in zip(one["displacement_um"], other["displacement_um"])) / max(one["displacement_um"])
            verdict(worst < 1e-8, f"{name} of a body change the response of {one['name']} by {worst:.1e}")
        verdict([port["name"] for port in found.get("bodies", [])] == ["head"], f"the port of {name} has an answer like a body")
    levels = [machine(running, in_head(housing=housing, **weightless), step_us=5).get("channels", {})
              for housing in ({"bodies": [HEAD], "mounts": [MOUNT]}, as_matrices())]
    common = [name for name in levels[0] if name in levels[1]]
    worst = max((abs(20 * math.log10(levels[0][name]["rms"] / levels[1][name]["rms"])) for name in common), default=math.inf)
    verdict(len(common) == len(levels[0]) > 10 and worst < 1e-5, f"matrices of a body change levels in time by {worst:.1e} dB")


def case_example_of_the_guide_runs(running):
    root = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
    with open(os.path.join(root, "docs", "how-to", "simulate-a-shaft.md"), encoding="utf-8") as file:
        section = file.read().split("### An imported structure")[1]
    housing = json.loads("{" + re.search(r"```json\n(.*?)```", section, re.DOTALL)[1] + "}")["housing"]
    scene = spindle({"on": "front"}, {"on": "rear"}, housing)
    found = rotor(running, scene)
    verdict([port["name"] for port in found.get("bodies", [])] == ["front", "rear"], "the example of the guide has two ports")
    seen = machine(running, scene, settle_s=0.02, duration_s=0.05).get("channels", {})
    verdict("front.y.acceleration" in seen and "rear.z.displacement" in seen, "the ports of the example have channels in time")


def case_refusals(running):
    def pointers(scene, kind="rotor"):
        status, _, answer = running.request("POST", "/v1/jobs", {"kind": kind, "scene": scene})
        return [error["pointer"] for error in answer.get("errors", [])] if status == 422 else [f"status {status}"]

    at, ring = "/scene/housing", "/scene/bearings/0/outer_ring"
    matrices, modes = f"{at}/matrices", f"{at}/modes"

    def changed(values, row, column, value):
        rows = diagonal(values)
        rows[row][column] = value
        return rows

    imported = {
        "without anything": ({}, f"{at}/bodies"),
        "with ports alone": ({"ports": [PORT]}, f"{at}/ports"),
        "with matrices without ports": ({"matrices": as_matrices()["matrices"]}, f"{at}/ports"),
        "with modes and matrices": (as_modes() | as_matrices(), matrices),
        "with a port of the name of a body": (as_modes() | {"bodies": [HEAD], "mounts": [MOUNT]}, f"{at}/ports/0/name"),
        "with a port far away": (as_matrices(ports=[PORT | {"at_mm": 1e9}]), f"{at}/ports/0/at_mm"),
        "with a port of the name of a bearing": (as_matrices(ports=[PORT, {"name": "A", "at_mm": 1}],
                                                             coordinates=["head.x", "head.y", "head.z", "A.y", "A.z"]), f"{at}/ports/1/name"),
        "with a port that nothing moves": (as_matrices(ports=[PORT, {"name": "foot", "at_mm": 1}]), f"{at}/ports/1"),
        "with a coordinate twice": (as_matrices(coordinates=["head.x", "head.y", "head.z", "head.y", "inner"]), f"{matrices}/coordinates/3"),
        "with a coordinate of no port": (as_matrices(coordinates=["head.x", "head.y", "head.z", "foot.y", "inner"]), f"{matrices}/coordinates/3"),
        "with an unknown displacement": (as_matrices(coordinates=["head.x", "head.y", "head.z", "head.roll", "inner"]), f"{matrices}/coordinates/3"),
        "with too many coordinates": (as_matrices(coordinates=[f"q{k}" for k in range(61)]), f"{matrices}/coordinates"),
        "with too few rows": (as_matrices(mass=diagonal(MASSES)[:4]), f"{matrices}/mass"),
        "with a short row": (as_matrices(stiffness=[[1], *diagonal(STIFFNESS)[1:]]), f"{matrices}/stiffness/0"),
        "with an entry beyond its limits": (as_matrices(stiffness=changed(STIFFNESS, 1, 1, 1e14)), f"{matrices}/stiffness/1/1"),
        "that is not symmetric": (as_matrices(stiffness=changed(STIFFNESS, 2, 1, 1e5)), f"{matrices}/stiffness/2/1"),
        "without mass": (as_matrices(mass=changed(MASSES, 3, 3, 0)), f"{matrices}/mass/3/3"),
        "whose mass is not definite": (as_matrices(mass=[[8, 8, 0, 0, 0], [8, 8, 0, 0, 0], *diagonal(MASSES)[2:]]), f"{matrices}/mass"),
        "whose stiffness is negative": (as_matrices(stiffness=changed(STIFFNESS, 0, 0, -1)), f"{matrices}/stiffness/0/0"),
        "whose stiffness is not semi-definite": (as_matrices(stiffness=[[1e7, 2e7, 0, 0, 0], [2e7, 1e7, 0, 0, 0], *diagonal(STIFFNESS)[2:]]),
                                                 f"{matrices}/stiffness"),
        "whose damping drives": (as_matrices(damping=[[1, 2, 0, 0, 0], [2, 1, 0, 0, 0], *diagonal(DAMPING)[2:]]), f"{matrices}/damping"),
        "that vibrates too fast": (as_matrices(mass=changed(MASSES, 0, 0, 1e-9)), f"{matrices}/stiffness"),
        "that nothing holds along y": (as_matrices(stiffness=changed(STIFFNESS, 1, 1, 0)), f"{at}/ports/0"),
        "with a free mode": (as_modes({"frequency_hz": 0}), f"{at}/ports/0"),
        "without modes": (as_modes(modes=[]), f"{modes}"),
        "with a mode without mass": (as_modes({"mass_kg": 0}), f"{modes}/0/mass_kg"),
        "with a mode damped too much": (as_modes({"damping_ratio": 0.9}), f"{modes}/0/damping_ratio"),
        "with a mode too fast": (as_modes({"frequency_hz": 2e6}), f"{modes}/0/frequency_hz"),
        "with a shape of an unknown port": (as_modes({"shape": {"head": [1, 0, 0, 0, 0], "foot": [1, 0, 0, 0, 0]}}), f"{modes}/0/shape/foot"),
        "with a shape beyond its limits": (as_modes({"shape": {"head": [1e7, 0, 0, 0, 0]}}), f"{modes}/0/shape/head/0"),
        "with a short shape": (as_modes({"shape": {"head": [1, 0, 0, 0]}}), f"{modes}/0/shape/head"),
    }
    for name, (housing, pointer) in imported.items():
        on = {"on": "head"} if "ports" in housing else {}
        for kind in ("rotor", "machine"):
            found = pointers(spindle(on, on) | {"housing": housing}, kind)
            verdict(found == [pointer], f"a {kind} with an imported structure {name} is refused at {found}")

    def housed(body=None, mount=None, **fields):
        return spindle({"on": "head"}, {"on": "head"}, {"bodies": [HEAD | (body or {})], "mounts": [MOUNT | (mount or {})]}, **fields)

    cases = {
        "without bodies": (spindle(housing={"bodies": []}), f"{at}/bodies"),
        "of a body without mass": (housed({"mass_kg": 0}), f"{at}/bodies/0/mass_kg"),
        "with the name of a bearing": (spindle(housing={"bodies": [HEAD | {"name": "A"}], "mounts": [MOUNT | {"body": "A"}]}), f"{at}/bodies/0/name"),
        "with a mount of an unknown body": (housed(mount={"body": "foot"}), f"{at}/mounts/0/body"),
        "with a mount to itself": (housed(mount={"to": "head"}), f"{at}/mounts/0/to"),
        "with a mount without stiffness": (housed(mount={"stiffness_n_per_um": [-1, 1, 1]}), f"{at}/mounts/0/stiffness_n_per_um/0"),
        "that nothing holds along x": (housed(mount={"stiffness_n_per_um": [0, 20, 50]}), f"{at}/bodies/0"),
        "that nothing holds in its tilt": (housed(mount={"tilt_n_m_per_mrad": [20, 0]}), f"{at}/bodies/0"),
        "with a ring on an unknown body": (spindle({"on": "head"}), f"{ring}/on"),
        "with an elastic seat without stiffness": (spindle({"seat": "elastic"}), f"{ring}/stiffness_n_per_um"),
        "with a spring on a rigid ring": (spindle({"spring_force_n": 1}), f"{ring}/spring_force_n"),
        "with a sensor on an unknown body": (in_head(sensors=[{"name": "s", "on": "foot", "at_mm": 1, "direction": "y"}]), "/scene/sensors/0/on"),
        "with a sensor relative to itself": (in_head(sensors=[{"name": "s", "at_mm": 1, "direction": "y", "relative_to": "shaft"}]),
                                             "/scene/sensors/0/relative_to"),
    }
    for name, (scene, pointer) in cases.items():
        for kind in ("rotor", "machine"):
            found = pointers(scene, kind)
            verdict(found == [pointer], f"a {kind} with a housing {name} is refused at {found}")


if __name__ == "__main__":
    run_cases(globals())
