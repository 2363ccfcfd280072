"""Structured meshes of a ball and of the body it is pressed into, in mm; the ball moves along -y.

Bodies are made of columns that start on the contact surface and run away from it: point 0 of every column lies on the
surface, the last point where displacements are prescribed. Points 0 of ball and body face one another.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from math import asin, asinh, ceil, cos, log, pi, sin, sinh, sqrt

Point = tuple[float, ...]
Column = list[Point]

# Steps in depth over steps along the surface: stresses are smooth in depth, with a kink along the surface at the
# contact's edge.
DEPTH_STEP = 1.5
# Bore of the ball over its radius. The ball is moved by its bore; steel holds 0.5 % of the compliance, so that the bore
# is not felt.
BORE = 0.2
# Thickness over radius of what is meshed of the ball in three dimensions.
BALL_SHELL = 0.4
# Beyond this angle [rad] ball and flat are so far apart that their points need not face one another.
FACING = 1.2


@dataclass(frozen=True)
class Mesh:
    """Nodes count from 0. Face 1 of the elements in `surface` lies on the contact surface."""

    element_type: str
    nodes: list[Point]
    elements: list[list[int]]
    surface: list[int]
    far_end: list[int]
    # Nodes that do not move along an axis, 1 to 3; without those of the far end.
    symmetry: dict[int, list[int]]


@dataclass(frozen=True)
class Grading:
    """Steps along a line: even within `finest`, a length over the ball's radius, and geometric beyond.

    Whatever the radius of a contact, its edge then meets elements of the same size relative to it, so that one mesh
    serves all loads. Level n splits each element of level 1 into n along every line.
    """

    finest: float
    step: float
    level: int

    def points(self, end: float, radius: float = 1.0, coarser: float = 1.0) -> list[float]:
        """From 0 to `end`."""
        finest = self.finest * radius
        length = asinh(end / finest)
        count = self.level * ceil(length / (self.step * coarser))
        return [finest * sinh(length * i / count) for i in range(count)] + [end]


@dataclass(frozen=True)
class Wall:
    """What holds a seat: the part of a hollow sphere of this outside radius [mm] within the angle `rim` [rad] of the
    lowest direction; with a half width [mm], a strip of it."""

    outside: float
    rim: float
    half_width: float | None = None


def seat(radius: float, clearance: float, wall: Wall, grading: Grading) -> tuple[Mesh, Mesh]:
    """Ball and axisymmetric seat, which touch at the lowest point."""
    inside = radius + clearance
    angles = grading.points(wall.rim)
    depths = grading.points(wall.outside - inside, radius, DEPTH_STEP)
    body = [[((inside + d) * sin(t), -(inside + d) * cos(t)) for d in depths] for t in angles]
    # Along the seat's normals, seen from the ball's centre, which is `clearance` below the seat's.
    facing = [t + asin(clearance * sin(t) / radius) for t in angles]
    return ball(radius, [t for t in facing if t <= pi / 2], -clearance, grading), axisymmetric(body)


def flat(radius: float, outside: float, grading: Grading) -> tuple[Mesh, Mesh]:
    """Ball and a cylinder of radius and height `outside`, whose top it touches."""
    angles = grading.points(pi / 2)
    across = [radius * sin(t) for t in angles if t < FACING]
    beyond = log(outside / across[-1])
    count = grading.level * ceil(beyond / grading.step)
    across += [outside ** (i / count) * across[-1] ** (1 - i / count) for i in range(1, count + 1)]
    depths = grading.points(outside, radius, DEPTH_STEP)
    return ball(radius, angles, radius, grading), axisymmetric([[(x, -d) for d in depths] for x in across])


def ball(radius: float, angles: list[float], centre: float, grading: Grading) -> Mesh:
    """Lower half of a ball with its centre at height `centre`; angles are from its lowest point."""
    reach = [radius - d for d in grading.points((1 - BORE) * radius, radius, DEPTH_STEP)]
    return axisymmetric([[(r * sin(t), centre - r * cos(t)) for r in reach] for t in angles])


def strip(radius: float, clearance: float, wall: Wall, half_width: float, grading: Grading) -> tuple[Mesh, Mesh]:
    """A quarter of ball and seat, x across the wall; the outside is a cylinder about x.

    Of the ball there is what faces the seat: too stiff to be felt.
    """
    inside = radius + clearance
    across = grading.points(half_width, radius)
    depths = grading.points(wall.outside - inside, radius, DEPTH_STEP)
    shell = grading.points(BALL_SHELL * radius, radius, 2 * DEPTH_STEP)
    body, facing = [], []
    for angle in grading.points(wall.rim):
        for x in across:
            floor = sqrt(inside**2 - x**2)
            stretch = (wall.outside - floor) / (wall.outside - inside)
            body.append([(x, -r * cos(angle), r * sin(angle)) for r in (floor + stretch * d for d in depths)])
            normal = (x / inside, -floor / inside * cos(angle), floor / inside * sin(angle))
            facing.append(shell_column(radius, clearance, normal, shell))
    return solid(facing, len(across)), solid(body, len(across))


def shell_column(radius: float, clearance: float, normal: Point, depths: list[float]) -> Column:
    """From where a normal of the seat meets the ball, towards the ball's centre."""
    centre = (0.0, -clearance, 0.0)
    along = -clearance * normal[1]
    distance = along + sqrt(along**2 - clearance**2 + radius**2)
    outward = [(distance * n - c) / radius for n, c in zip(normal, centre)]
    return [tuple(c + (radius - d) * n for n, c in zip(outward, centre)) for d in depths]


def axisymmetric(columns: list[Column]) -> Mesh:
    """Of columns from the axis outwards."""
    rows = len(columns[0])
    elements = []
    for column in range(len(columns) - 1):
        here, after = column * rows, (column + 1) * rows
        # Counterclockwise, beginning with the side nearest to the surface.
        left, right = (here, after) if is_upward(columns) else (after, here)
        elements += [[left + j, right + j, right + j + 1, left + j + 1] for j in range(rows - 1)]
    return Mesh("CAX4", joined(columns), elements, surface(columns, elements), far_end(columns), {1: near([0], rows)})


def solid(columns: list[Column], across: int) -> Mesh:
    """Of columns by angle and, at each angle, `across` of them from the middle of the wall."""
    rows = len(columns[0])
    elements = []
    for first in range(len(columns) - across):
        if first % across == across - 1:
            continue
        corners = [first, first + 1, first + across + 1, first + across]
        # Counterclockwise, seen from within.
        ring = [rows * corner for corner in (corners[::-1] if is_upward(columns) else corners)]
        elements += [[c + j for c in ring] + [c + j + 1 for c in ring] for j in range(rows - 1)]
    middle, lowest = range(0, len(columns), across), range(across)
    symmetry = {1: near(middle, rows), 3: near(lowest, rows)}
    return Mesh("C3D8I", joined(columns), elements, surface(columns, elements), far_end(columns), symmetry)


def is_upward(columns: list[Column]) -> bool:
    return columns[0][1][1] > columns[0][0][1]


def joined(columns: list[Column]) -> list[Point]:
    return [point for column in columns for point in column]


def surface(columns: list[Column], elements: list[list[int]]) -> list[int]:
    return list(range(0, len(elements), len(columns[0]) - 1))


def far_end(columns: list[Column]) -> list[int]:
    rows = len(columns[0])
    return [rows * (column + 1) - 1 for column in range(len(columns))]


def near(columns: Iterable[int], rows: int) -> list[int]:
    """Nodes of columns but for the far end."""
    return [rows * column + j for column in columns for j in range(rows - 1)]
