#!/usr/bin/env python3
"""Rotor jobs over HTTP: known frequencies and stiffnesses, refusals by pointer, and the answer at once. With a URL as argument the requests go
there."""

import os
import sys
import time

sys.path.insert(0, os.path.join(os.path.dirname(os.path.dirname(os.path.abspath(__file__)))))
from cases import result, run_cases, verdict  # noqa: E402

SUPPORT = {"stiffness_n_per_um": [0, 50, 50], "damping_n_s_per_m": [0, 200, 200]}


def job(shaft=None, operation=None, **scene):
    """A bar with a disc in the middle on two equal supports, changed."""
    usual = {"material": {"elastic_modulus_gpa": 211, "poisson_ratio": 211 / (2 * 81.2) - 1, "density_kg_m3": 7810},
             "sections": [{"length_mm": 10, "outer_diameter_mm": 25}] * 30, "damping_ratio": 0, "elements": "sections",
             "discs": [{"at_mm": 150, "mass_kg": 1.2, "transverse_inertia_kg_m2": 8e-4, "axial_inertia_kg_m2": 1.5e-3}],
             "unbalances": [{"at_mm": 150, "unbalance_g_mm": 20}]}
    supports = [SUPPORT | {"at_mm": at} for at in (40, 260)]
    scene = {"shaft": usual | (shaft or {}), "supports": supports, "operation": {"speed_rpm": 12000} | (operation or {})} | scene
    return {"kind": "rotor", "scene": scene, "speeds_rpm": [0, 6000, 12000, 18000, 24000, 30000]}


def pointers(running, body):
    status, _, answer = running.request("POST", "/v1/rotor", body)
    return status, {error["pointer"] for error in answer.get("errors", [])} if isinstance(answer, dict) else set()


def case_known_rotor(running):
    answer = result(running, job(), "rotor")
    found = sorted(mode["frequency_hz"][4] for mode in answer["modes"])
    known = [478.545, 480.350, 1567.076, 1767.981, 2001.751, 2010.308, 2289.108, 2607.341]
    verdict(all(abs(one / other - 1) < 1e-6 for one, other in zip(found, known)), f"frequencies at 24 000 r/min: {found}")
    criticals = [(round(one["speed_rpm"]), one["whirl"]) for one in answer["criticals"]]
    verdict(criticals == [(28702, "backward"), (28832, "forward")], f"critical speeds {criticals}")
    at_disc = next(one for one in answer["response"] if abs(one["at_mm"] - 150) < 1e-6)["y_um"]
    verdict(abs(at_disc[2] / 2.535067 - 1) < 1e-5, f"{at_disc[2]:.6f} µm at the disc at 12 000 r/min")


def case_preloaded_pair(running):
    """Two angular contact bearings of 17 balls, preloaded by 200 N against each other: the stiffness of each at rest."""
    steel = {"elastic_modulus_gpa": 208, "poisson_ratio": 0.3, "density_kg_m3": 7810}
    bearing = {"type": "angular_contact", "ball_count": 17, "ball_diameter_mm": 7.938, "pitch_diameter_mm": 54, "contact_angle_deg": 25,
               "inner_diameter_mm": 40, "outer_diameter_mm": 68, "width_mm": 15, "inner_groove_curvature": 0.52,
               "outer_groove_curvature": 0.53, "materials": {"ball": steel, "inner_raceway": steel, "outer_raceway": steel}}
    pair = [{"name": name, "bearing": bearing, "at_mm": at, "faces": faces} for name, at, faces in (("A", 20, "+x"), ("B", 35, "-x"))]
    shaft = {"sections": [{"length_mm": 55, "outer_diameter_mm": 40}], "discs": [], "unbalances": []}
    body = job(shaft, {"speed_rpm": 0}, bearings=pair, preloads=[{"between": ["A", "B"], "force_n": 200}], gravity_m_s2=0)
    del body["scene"]["supports"]
    body["speeds_rpm"] = [0]
    status, _, answer = running.request("POST", "/v1/rotor", body)
    if status != 200:
        return verdict(False, f"a preloaded pair is analysed: {status} {answer}")
    stiffness = answer["bearings"][0]["stiffness"]
    axial, radial, tilt = stiffness[0][0] / 1e6, stiffness[1][1] / 1e6, stiffness[3][3]
    near = abs(axial / 61.710 - 1) < 1e-3 and abs(radial / 131.870 - 1) < 1e-3 and abs(tilt / 22721.7 - 1) < 1e-3
    verdict(near, f"{axial:.3f} and {radial:.3f} N/µm, {tilt:.1f} N·m/rad of each of a pair under 200 N")
    return None


def case_messages(running):
    """A sliding ring presses the first bearing of a pair on its open side, or on its shoulder; 60 kN are too much."""
    def told(facing, load):
        seat = {"seat": "sliding", "spring_force_n": 200, "spring_n_per_um": 1}
        bearings = [{"name": "A", "bearing": "7008C", "at_mm": 60, "faces": facing},
                    {"name": "B", "bearing": "7008C", "at_mm": 240, "faces": "-x", "outer_ring": seat}]
        shaft = {"sections": [{"length_mm": 300, "outer_diameter_mm": 40}], "axial": "free"}
        scene = {"shaft": shaft, "bearings": bearings, "operation": {"speed_rpm": 3000, "radial_load_y_n": load}}
        status, _, answer = running.request("POST", "/v1/rotor", {"kind": "rotor", "scene": scene, "speeds_rpm": [3000]})
        return sorted((one["code"], one["bearing"]) for one in answer["messages"]) if status == 200 else answer

    found = [told("-x", 50), told("+x", 50), told("+x", 60_000)]
    expected = [[("open-side", "A")], [], [("overloaded", "A"), ("overloaded", "B")]]
    verdict(found == expected, f"thrust over an open side and too much pressure have messages: {found}")


def case_answer_at_once(running):
    body = job() | {"speeds_rpm": {"from": 0, "to": 30000, "count": 50}}
    running.request("POST", "/v1/rotor", body)
    begin = time.monotonic()
    status, _, answer = running.request("POST", "/v1/rotor", body)
    took = time.monotonic() - begin
    verdict(status == 200 and len(answer["speeds_rpm"]) == 50, f"50 speeds in {1e3 * took:.0f} ms, no job made")


def case_plots(running):
    path = running.submit(job())[0]
    running.ended(path)
    for name, words in (("campbell.svg", ("forward", "backward", "28702")), ("shapes.svg", ("479.9 Hz, forward", "bearings and supports"))):
        status, headers, picture = running.request("GET", f"{path}/plots/{name}")
        text = picture.decode() if isinstance(picture, bytes) else str(picture)
        is_drawn = status == 200 and headers.get_content_type() == "image/svg+xml" and all(word in text for word in words)
        verdict(is_drawn, f"{name} of a rotor job shows {', '.join(words)}: {status}")
    status, _, problem = running.request("GET", f"{path}/plots/spectrum.svg")
    verdict(status == 409 and "campbell.svg" in str(problem), f"a rotor job without spectrum names its plots: {status}")


def case_refusals(running):
    cases = [
        (job({"sections": [{"length_mm": 300, "outer_diameter_mm": 25, "inner_diameter_mm": 26}]}),
         "/scene/shaft/sections/0/inner_diameter_mm"),
        (job(supports=[SUPPORT | {"at_mm": 400}]), "/scene/supports/0/at_mm"),
        (job(supports=[SUPPORT | {"at_mm": 40}]), "/scene/supports"),
        (job(housing={"bodies": []}), "/scene/housing/bodies"),
        (job(spindle={"mass_kg": 1}), "/scene/spindle"),
        (job(bearing="6205"), "/scene/bearing"),
        (job(operation={"speed_rpm": -1}), "/scene/operation/speed_rpm"),
        (job(operation={"speed_rpm": 0, "loads": [{"direction": "y"}]}), "/scene/operation/loads/0"),
        (job(bearings=[{"name": "cage", "bearing": "6205", "at_mm": 40}]), "/scene/bearings/0/name"),
        (job(bearings=[{"name": "A", "bearing": "6205", "at_mm": 40, "outer_ring": {"seat": "sliding"}}]),
         "/scene/bearings/0/outer_ring/spring_force_n"),
        (job(bearings=[{"name": "A", "bearing": "none", "at_mm": 40}]), "/scene/bearings/0/bearing"),
        (job() | {"speeds_rpm": [100, 50]}, "/speeds_rpm/1"),
        (job() | {"modes": 41}, "/modes"),
    ]
    for body, pointer in cases:
        status, found = pointers(running, body)
        verdict(status == 422 and pointer in found, f"{pointer} is refused: {status} {sorted(found)}")


if __name__ == "__main__":
    run_cases(globals())
