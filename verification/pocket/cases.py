"""What is computed, and how fine."""

from dataclasses import dataclass
from math import pi, radians

from calculix import Body, Contact, Material, forces_n
from laws import contact_modulus_mpa, hertz_penetration_mm, relative_radius_mm
from meshes import Grading, Mesh, Wall, flat, seat, strip

STEEL = Material(219_000, 0.3)
POLYAMIDE = Material(1_000, 0.39)
BRASS = Material(105_000, 0.34)

# About 144 ball radii: what a half-space yields beyond is 0.3 % of the penetration at 10 N.
FAR_MM = 200.0
HALF_SPACE = Wall(outside=FAR_MM, rim=pi / 2)

# At these loads by Hertz [N]; the range that runs of the service reach.
LOADS_N = (0.02, 0.1, 0.5, 2.0, 5.0, 10.0, 20.0)

# Coarse, medium and fine mesh: parts into which each element of the coarse one is split along every line.
LEVELS = (1, 2, 3)


@dataclass(frozen=True)
class Case:
    name: str
    # Diametral, as in the service; None for a flat.
    pocket_clearance_mm: float | None
    ball_radius_mm: float = 1.389
    wall: Wall = HALF_SPACE
    material: Material = POLYAMIDE
    loads_n: tuple[float, ...] = LOADS_N
    penalty_n_per_mm3: float = 1e8
    nonlinear: bool = False

    @property
    def clearance_mm(self) -> float | None:
        return None if self.pocket_clearance_mm is None else self.pocket_clearance_mm / 2

    @property
    def contact_modulus_mpa(self) -> float:
        return contact_modulus_mpa(STEEL, self.material)

    @property
    def relative_radius_mm(self) -> float:
        return relative_radius_mm(self.ball_radius_mm, self.clearance_mm)

    @property
    def penetrations_mm(self) -> list[float]:
        return [hertz_penetration_mm(self.contact_modulus_mpa, self.relative_radius_mm, load) for load in self.loads_n]

    def forces_n(self, level: int) -> list[float]:
        ball, body = self.meshes(level)
        contact = Contact(
            Body("BALL", ball, STEEL), Body("SEAT", body, self.material), self.penalty_n_per_mm3, self.nonlinear
        )
        return forces_n(contact, self.penetrations_mm)

    def meshes(self, level: int) -> tuple[Mesh, Mesh]:
        if self.clearance_mm is None:
            return flat(self.ball_radius_mm, self.wall.outside, Grading(0.03, 0.2, level))
        if self.wall.half_width is None:
            return seat(self.ball_radius_mm, self.clearance_mm, self.wall, Grading(0.05, 0.2, level))
        grading = Grading(0.1, 0.75, level)
        return strip(self.ball_radius_mm, self.clearance_mm, self.wall, self.wall.half_width, grading)


def bar(thickness_mm: float) -> Wall:
    """Wall of a crown cage, 1.2 mm wide, held at a depth below the seat."""
    return Wall(outside=1.389 + 0.0255 + thickness_mm, rim=radians(65), half_width=0.6)


FLAT = Case("flat", None, loads_n=(0.02, 0.1, 0.5, 2.0))
ARTICLE = Case("clearance-51", 0.051)
BAR = Case("bar-1.5", 0.051, wall=bar(1.5), loads_n=LOADS_N[1:-1], penalty_n_per_mm3=1e7)

CASES = (
    FLAT,
    ARTICLE,
    Case("clearance-1", 0.001),
    Case("clearance-10", 0.010),
    Case("clearance-20", 0.020),
    Case("clearance-100", 0.100),
    Case("bearing-6205", 0.1458, ball_radius_mm=3.97002),
    Case("rim-65", 0.051, wall=Wall(FAR_MM, radians(65))),
    Case("rim-115", 0.051, wall=Wall(FAR_MM, radians(115))),
    Case("rim-150", 0.051, wall=Wall(FAR_MM, radians(150))),
    Case("outside-3", 0.051, wall=Wall(3.0, pi / 2)),
    Case("outside-6", 0.051, wall=Wall(6.0, pi / 2)),
    Case("outside-28", 0.051, wall=Wall(28.0, pi / 2)),
    Case("poisson-0.30", 0.051, material=Material(1_000, 0.30)),
    Case("poisson-0.45", 0.051, material=Material(1_000, 0.45)),
    Case("brass", 0.051, material=BRASS, penalty_n_per_mm3=1e10),
    Case("large-strain", 0.051, nonlinear=True),
    Case("softer-penalty", 0.051, penalty_n_per_mm3=1e7),
    BAR,
    Case("bar-3", 0.051, wall=bar(3.0), loads_n=LOADS_N[1:-1], penalty_n_per_mm3=1e7),
    Case("bar-6", 0.051, wall=bar(6.0), loads_n=LOADS_N[1:-1], penalty_n_per_mm3=1e7),
)
