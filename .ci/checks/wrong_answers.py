#!/usr/bin/env python3
"""Answers that were wrong without a message stay right. With a URL as argument the checks talk to a service that runs there."""

import os
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), os.pardir))
from service import Service, service  # noqa: E402

FAILED = []


def verdict(holds, what):
    """Prints one line; a failure does not stop the other cases."""
    print(f"{'ok' if holds else 'FAILED'}: {what}")
    if not holds:
        FAILED.append(what)


def result(running, job, view="metrics"):
    """A result of the finished job."""
    path, _ = running.submit(job)
    ended = running.ended(path)
    if ended["status"] != "succeeded":
        sys.exit(f"FAILED: {ended}")
    return running.request("GET", f"{path}/{view}")[2]


def without_cage(**bearing):
    return {"kind": "simulation", "settle_s": 0.3, "duration_s": 0.3, "scene": {
        "bearing": {"preset": "6206", **bearing}, "operation": {"speed_rpm": 600, "radial_load_y_n": 500}, "terms": {"cage": "off"}}}


def end_without_cage(running, job):
    """Largest displacement of the spindle [mm] or the cause of the failure."""
    path, _ = running.submit(job)
    ended = running.ended(path)
    if ended["status"] == "failed":
        return ended["error"]["type"].rsplit(":", 1)[-1], ended["error"]["detail"]
    channels = running.request("GET", f"{path}/metrics")[2]["channels"]
    return "succeeded", max(channels[f"spindle.{axis}.displacement"]["peak"] / 1000 for axis in "yz")


def case_balls_without_a_cage_touch(running):
    """Balls that pass through each other gather below the load, and the spindle falls for metres."""
    end, found = end_without_cage(running, without_cage())
    verdict(end == "spindle-left-bearing" or (end == "succeeded" and found < 1), f"6206 without a cage: {end}, {found} mm")


def case_full_complement_bearing(running):
    end, found = end_without_cage(running, without_cage(ball_count=15))
    verdict(end == "succeeded" and found < 0.1, f"15 balls fill a 6206 and hold the spindle: {end}, {found} mm")


def case_spindle_that_leaves_the_bearing(running):
    end, found = end_without_cage(running, without_cage(ball_count=3))
    names = isinstance(found, str) and "t = 0." in found and "9.531 mm" in found
    verdict(end == "spindle-left-bearing" and names, f"three balls do not hold the spindle: {end}, {found}")


def case_reduced_levels_need_a_cage(running):
    job = {**without_cage(), "solver": {"rung": "radially_condensed"}}
    status, _, answer = running.request("POST", "/v1/jobs", job)
    pointers = [error["pointer"] for error in answer.get("errors", [])]
    verdict(status == 422 and pointers == ["/solver/rung"], f"a reduced level refuses balls that touch: {status}, {pointers}")


def case_initial_perturbation(running):
    """The push moves the cage of a scene that is at rest in equilibrium; its seed gives the same motion again."""
    def orbit(seed):
        job = {"kind": "simulation", "settle_s": 0, "duration_s": 0.01, "reuse": False, "scene": {
            "bearing": "article-integrated", "operation": {
                "speed_rpm": 20000, "radial_load_y_n": 100, "initial_perturbation": {"speed_mm_s": 10, "seed": seed}}}}
        status, headers, answer = running.request("POST", "/v1/jobs", job)
        if status != 202:
            return answer["detail"]
        running.ended(headers["Location"])
        return running.request("GET", f"{headers['Location']}/metrics")[2]["cage"]["orbit_radius_um"]
    first, again, other = orbit(1), orbit(1), orbit(2)
    verdict(isinstance(first, float) and first == again != other, f"a seed gives its own motion: {first}, {again}, {other}")


class Running(Service):
    """A service that runs already."""

    def __init__(self, url):
        self.url, self.token = url, None

    def stderr(self):
        return ""


def run(running):
    for name, case in list(globals().items()):
        if name.startswith("case_"):
            case(running)


if len(sys.argv) > 1:
    run(Running(sys.argv[1]))
else:
    with service() as started:
        run(started)
sys.exit(1 if FAILED else 0)
