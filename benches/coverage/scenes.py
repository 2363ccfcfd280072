"""Jobs drawn from a seed over everything that a user may send. The job of an index depends on seed and index alone.

Raceways and balls of the seeds below 100 are ideal; from 100 on, every job has imperfect surfaces, too.

Dimensions follow ISO 15 (D = d + f d^0.9), balls and their number the proportions of catalogues. Loads are shares of an
estimated dynamic load rating, speeds come from the speed factor n·D_m. Most fields are left out in most jobs, as users do.
"""

import hashlib
import math
import os
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "compare"))
import compare  # noqa: E402

# Presets: bore, width, balls, ball and pitch diameter [mm], for the scale of loads, speeds and clearances.
PRESETS = {
    "article-integrated": (8.5, 5.9, 7, 2.778, 13.0),
    "article-deep-groove": (8.0, 6.3, 7, 2.38, 14.0),
    "608": (8.0, 7.0, 7, 3.969, 15.0),
    "6203": (17.0, 12.0, 8, 6.746, 28.5),
    "6204": (20.0, 14.0, 8, 7.938, 33.5),
    "6205": (25.0, 15.0, 9, 7.94, 39.04),
    "6206": (30.0, 16.0, 9, 9.525, 46.0),
    "6208": (40.0, 18.0, 9, 11.906, 60.0),
    "6210": (50.0, 20.0, 10, 12.7, 70.0),
}
# Diameter series 9, 0, 1, 2 and 3 of ISO 15.
SERIES = (0.62, 0.84, 1.12, 1.48, 1.92)
# Balls over balls of a full complement: from, to.
FILLING = {"deep_groove": (0.52, 0.66), "integrated": (0.5, 0.75), "angular_contact": (0.65, 0.88)}
METRICS = ("vibration", "contacts", "cage")
# First seed whose jobs have imperfect surfaces.
FIRST_WITH_SURFACES = 100


class Draw(compare.Draw):
    """Draws of one job."""

    def __init__(self, seed, index):
        super().__init__(int.from_bytes(hashlib.sha256(f"{seed} {index}".encode()).digest()[:8], "big"))

    def signed(self, value):
        return -value if self.chance(0.5) else value

    def job(self, has_surfaces=False):
        bearing, size = self.bearing()
        scene = {"bearing": bearing, "operation": self.operation(size)}
        spindle = self.spindle(size, scene["operation"])
        if spindle:
            scene["spindle"] = spindle
        if self.chance(0.65):
            scene["lubricant"] = self.lubricant()
        if self.chance(0.12):
            scene["damping"] = self.damping()
        if self.chance(0.12):
            scene["terms"] = self.terms()
        if self.chance(0.1):
            scene["gravity_m_s2"] = self.one_of((0.0, -9.81, 1.62))
        job = {"kind": "simulation", "scene": scene} | self.times()
        if self.chance(0.12):
            self.profile(job)
        if self.chance(0.4):
            job["outputs"] = {"metrics": self.metrics()}
        return self.with_surfaces(job, size) if has_surfaces else job

    # ---- surfaces

    def with_surfaces(self, job, size):
        """One to three imperfections, each of another kind."""
        surfaces = {}
        kinds = ["waves", "random", "defect", "sizes", "ball waves", "ball defect", "pockets"]
        for _ in range(self.one_of((1, 1, 2, 3))):
            kind = kinds.pop(int(self.share() * len(kinds)))
            raceway = surfaces.setdefault(self.one_of(("inner", "outer")), {}) if kind in ("waves", "random", "defect") else {}
            if kind == "waves":
                orders = {int(self.between_decades(1, 200)) for _ in range(self.one_of((1, 2, 4)))}
                raceway["waviness"] = [self.wave(order) for order in sorted(orders)]
            elif kind == "random":
                raceway["random_waviness"] = {"amplitude_nm": self.between_decades(0.3, 30.0)}
            elif kind == "defect":
                raceway["defects"] = [self.raceway_defect(size)]
            elif kind == "sizes":
                surfaces["every_ball"] = {"diameter_spread_um": self.between_decades(0.02, 3.0)}
            elif kind == "ball waves":
                ball = {"ball": 1, "waviness": [self.wave(self.one_of((2, 3, 4, 6, 8, 12)))]}
                surfaces.setdefault("balls", [{}])[0].update(ball)
            elif kind == "ball defect":
                defect = {"diameter_mm": float(f"{size['ball'] * self.between_decades(0.02, 0.2):.3g}"),
                          "depth_um": self.between_decades(0.5, 50.0)}
                surfaces.setdefault("balls", [{}])[0].update({"ball": 1, "defects": [defect]})
            else:
                self.pockets(job, size)
        job["scene"]["surfaces"] = surfaces
        return job

    def wave(self, order):
        return {"order": order, "amplitude_nm": float(f"{self.between_decades(0.5, 300.0) / math.sqrt(order):.3g}"),
                "phase_deg": self.between(-180, 180)}

    def raceway_defect(self, size):
        defect = {"azimuth_deg": self.one_of((0.0, 0.0, self.between(-180, 180))),
                  "length_mm": float(f"{size['ball'] * self.between_decades(0.02, 0.4):.3g}"),
                  "depth_um": self.between_decades(0.5, 100.0)}
        if self.chance(0.3):
            defect["width_mm"] = float(f"{size['ball'] * self.between_decades(0.03, 0.4):.3g}")
        if self.chance(0.3):
            defect["shape"] = "half_sine"
        return defect

    def pockets(self, job, size):
        cage = job["scene"]["bearing"].setdefault("cage", {})
        cage["pocket_spacing_mrad"] = [self.between_decades(0.1, 10.0)] + [0.0] * (size["balls"] - 1)

    # ---- bearing

    def bearing(self):
        """The bearing, and its scales."""
        if self.chance(0.35):
            name = self.one_of(tuple(PRESETS))
            bearing, (bore, width, balls, ball, pitch) = {"preset": name}, PRESETS[name]
            kind = "integrated" if name == "article-integrated" else "deep_groove"
        else:
            kind = self.one_of(("deep_groove", "deep_groove", "angular_contact", "angular_contact", "integrated"))
            bore = self.between_decades(3.0, 220.0)
            section = self.one_of(SERIES) * math.pow(bore, 0.9)
            width = round(0.5 * section * self.one_of((0.88, 1.0, 1.15)), 3)
            ball = round(section * self.between(0.27, 0.33), 3)
            pitch = round(bore + section * self.between(0.5, 0.52), 3)
            balls = max(4, int(math.pi / math.asin(ball / pitch) * self.between(*FILLING[kind])))
            bearing = {
                "type": kind, "inner_diameter_mm": bore, "outer_diameter_mm": round(bore + section, 3), "width_mm": width,
                "ball_count": balls, "ball_diameter_mm": ball, "pitch_diameter_mm": pitch,
            }
        # The rating of ISO 281 for common grooves.
        rating = 75.0 * math.pow(balls, 2 / 3) * (math.pow(ball, 1.8) if ball <= 25.4 else 3.647 * math.pow(ball, 1.4))
        size = {"kind": kind, "bore": bore, "width": width, "ball": ball, "pitch": pitch, "balls": balls, "rating": rating}
        self.fit(bearing, size)
        if self.chance(0.3):
            bearing["inner_groove_curvature"] = self.between(0.506, 0.54)
        if self.chance(0.3):
            bearing["outer_groove_curvature"] = self.between(0.506, 0.54)
        materials = self.materials()
        size["hybrid"] = materials.get("ball") == "si3n4"
        if materials:
            bearing["materials"] = materials
        if self.chance(0.25):
            bearing["cage"] = self.cage(size)
        return bearing, size

    def fit(self, bearing, size):
        """Clearance or contact angle, in some bearings."""
        usual = 10.0 * math.pow(size["bore"] / 25.0, 0.7)
        if size["kind"] == "angular_contact":
            if self.chance(0.7):
                bearing["contact_angle_deg"] = self.one_of((12, 15, 18, 20, 25, 30, 40))
        elif self.chance(0.5):
            clearance = usual * self.between_decades(0.1, 3.0)
            bearing["radial_clearance_um"] = float(f"{-0.2 * clearance if self.chance(0.12) else clearance:.3g}")

    def materials(self):
        found = {}
        if self.chance(0.25):
            found["ball"] = "si3n4"
        if self.chance(0.08):
            found["inner_raceway"] = found["outer_raceway"] = "aisi-52100"
        if self.chance(0.08):
            steel = {"elastic_modulus_gpa": 200.0, "poisson_ratio": 0.28, "density_kg_m3": 7700.0}
            found["cage"] = self.one_of(("aisi-52100", steel))
        return found

    def cage(self, size):
        cage = {}
        if self.chance(0.4):
            cage["pocket_clearance_mm"] = float(f"{size['ball'] * self.between_decades(0.005, 0.08):.3g}")
        if self.chance(0.3):
            cage["friction"] = self.between(0.02, 0.2)
        if self.chance(0.4):
            film = {"stiffness_n_per_m": self.between_decades(1e3, 1e6), "damping_n_s_per_m": self.between_decades(0.05, 5.0)}
            cage["film"] = self.one_of(("none", "wedge", "empirical-11", film))
        if self.chance(0.2):
            cage["seat"] = "closed"
        if self.chance(0.15):
            cage["bar_stiffness_n_per_m"] = self.between_decades(1e5, 1e8)
        if self.chance(0.2):
            cage["land"] = {
                "clearance_mm": float(f"{size['pitch'] * self.between_decades(0.002, 0.01):.3g}"),
                "diameter_mm": round(size["pitch"] + 0.5 * size["ball"], 3), "width_mm": round(0.15 * size["width"], 3),
            }
        return cage

    # ---- operation, spindle, lubricant

    def operation(self, size):
        factor = self.between_decades(1e3, 1e4) if self.chance(0.1) else self.between_decades(1e4, 1e6)
        factor *= 2.0 if size["hybrid"] else 1.0
        speed = float(f"{factor / size['pitch']:.3g}")
        operation = {"speed_rpm": -speed if self.chance(0.1) else speed}
        if self.chance(0.9):
            load = size["rating"] * self.between_decades(1e-4, 0.25)
            kind = self.one_of(("radial", "radial", "axial", "both", "both"))
            angle = {"radial": 0.0, "axial": 0.5 * math.pi}.get(kind) if kind != "both" else math.radians(self.between(5, 85))
            radial, axial = load * math.cos(angle), self.signed(load * math.sin(angle))
            if kind != "axial":
                around = 0.0 if self.chance(0.7) else math.radians(self.between(-180, 180))
                operation["radial_load_y_n"] = float(f"{radial * math.cos(around):.3g}")
                if around:
                    operation["radial_load_z_n"] = float(f"{radial * math.sin(around):.3g}")
            if kind != "radial":
                operation["axial_load_n"] = float(f"{axial:.3g}")
        if self.chance(0.15):
            operation["misalignment_mrad"] = {axis: self.signed(self.between_decades(0.05, 2.0))
                                              for axis in self.one_of((("y",), ("z",), ("y", "z")))}
        return operation

    def spindle(self, size, operation):
        spindle = {}
        if self.chance(0.5):
            # A steel shaft with the diameter of the bore and 7 times its length.
            shaft = 7850e-9 * 0.25 * math.pi * size["bore"] ** 3 * 7.0
            spindle["mass_kg"] = float(f"{shaft * self.between_decades(0.1, 10.0):.3g}")
        if self.chance(0.4):
            spindle["balance_grade"] = self.one_of((0.4, 1.0, 2.5, 6.3, 16.0, 40.0))
        elif self.chance(0.15):
            shaft = 7850e-6 * 0.25 * math.pi * size["bore"] ** 3 * 7.0
            spindle["unbalance_g_mm"] = float(f"{shaft * self.between_decades(1e-4, 1e-2):.3g}")
        if "axial_load_n" not in operation and self.chance(0.3):
            offset = {"offset_um": self.signed(self.between_decades(1.0, 20.0))}
            spindle["axial"] = self.one_of(("free", "fixed", offset, offset))
        return spindle

    def lubricant(self):
        name = self.one_of(("grease", "grease", "oil", "oil", "oil", "dry"))
        if name == "dry" or self.chance(0.6):
            return name
        lubricant = {"kind": name}
        if self.chance(0.8):
            lubricant["viscosity_pa_s"] = self.between_decades(0.003, 0.3)
        if self.chance(0.3):
            lubricant["fill"] = self.between(0.01, 0.4)
        if self.chance(0.3):
            lubricant["traction"] = self.one_of((
                {"law": "coulomb", "coefficient": self.between(0.02, 0.15)},
                {"law": "eyring", "stress_pa": self.between_decades(2e6, 1e7)},
                {"law": "four_parameter", "maximum": self.between(0.03, 0.1)},
            ))
        return lubricant

    def damping(self):
        raceway = self.one_of((
            {"law": "restitution", "restitution": self.between(0.5, 0.99)},
            {"law": "hunt_crossley", "restitution": self.between(0.5, 0.99)},
            {"law": "lankarani_nikravesh", "restitution": self.between(0.7, 0.99)},
            {"law": "flores", "restitution": self.between(0.5, 0.99)},
            {"law": "viscous", "viscous_n_s_per_m": self.between_decades(10.0, 1000.0)},
        ))
        pocket = {"law": "restitution", "restitution": self.between(0.3, 0.9)}
        return self.one_of(({"raceway": raceway}, {"pocket": pocket}, {"raceway": raceway, "pocket": pocket}))

    def terms(self):
        if self.chance(0.5):
            return {"cage": "off"}
        return {self.one_of(("gravity", "drag", "churning", "hydrodynamics", "cage_tilt", "axial", "spin", "conformity",
                             "pocket_film", "pocket_friction", "ball_radial_dynamics", "ball_spin_dynamics")):
                self.one_of(("on", "off"))}

    # ---- times and outputs

    def times(self):
        """Default times, short ones, or some in between."""
        kind = self.one_of(("default", "default", "short", "recorded", "both"))
        if kind == "default":
            return {}
        if kind == "short":
            return {"settle_s": self.between_decades(0.003, 0.03), "duration_s": self.between_decades(0.003, 0.05)}
        duration = {"duration_s": self.between_decades(0.01, 0.4)}
        return duration if kind == "recorded" else duration | {"settle_s": self.between_decades(0.01, 0.5)}

    def profile(self, job):
        """A speed that changes during the startup, the recorded time, or both; to another speed, to rest or in reverse."""
        settle = job.setdefault("settle_s", self.between_decades(0.01, 0.2))
        duration = job.setdefault("duration_s", self.between_decades(0.03, 0.3))
        end = job["scene"]["operation"]["speed_rpm"]
        begin = end * self.one_of((0.0, 0.3, 0.8, 1.2, -1.0))
        first, last = settle * self.share(), settle + duration * self.share()
        points = [{"at_s": float(f"{first:.3g}"), "rpm": float(f"{begin:.3g}")}, {"at_s": float(f"{last:.3g}"), "rpm": end}]
        if self.chance(0.3):
            points.append({"at_s": float(f"{last + self.between(0.2, 1.0) * duration:.3g}"), "rpm": float(f"{begin:.3g}")})
        job["scene"]["operation"]["speed_rpm"] = points

    def metrics(self):
        if self.chance(0.5):
            return ["vibration"]
        return [name for name in METRICS if self.chance(0.6)] or ["contacts"]


def job(seed, index):
    return Draw(seed, index).job(has_surfaces=seed >= FIRST_WITH_SURFACES)
