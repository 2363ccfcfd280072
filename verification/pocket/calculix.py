"""Frictionless contact of a ball and a body by CalculiX: writes the input, runs `ccx` and reads the force."""

import os
import re
import shutil
import subprocess
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

from meshes import Mesh

TIME_LIMIT_S = 600
# Parts of the whole that a model holds: CalculiX turns axisymmetric elements into wedges of 2 degrees and gives the
# reactions of one wedge; solids are a quarter between two planes of symmetry.
PARTS = {"CAX4": 180, "C3D8I": 4}
# Largest residual force and largest correction of displacements, over their means, at which iterations end. By default
# 5e-3 and 1e-2, with which a few forces came out up to 2 % off.
RESIDUALS = "1e-5, 1e-4"
# What moves the ball must be what holds the body.
LARGEST_IMBALANCE = 1e-3
TOTAL = re.compile(r"total force .* for set (\w+) and time +(\S+)\s+\S+\s+(\S+)")


@dataclass(frozen=True)
class Material:
    modulus_mpa: float
    poisson: float

    @property
    def compliance_per_mpa(self) -> float:
        return (1 - self.poisson**2) / self.modulus_mpa


@dataclass(frozen=True)
class Body:
    name: str
    mesh: Mesh
    material: Material


@dataclass(frozen=True)
class Contact:
    """The far end of the ball is moved down, that of the body is held."""

    ball: Body
    body: Body
    penalty_n_per_mm3: float
    nonlinear: bool


class SolverError(Exception):
    """CalculiX is missing, stopped, or gave what cannot be right."""


def forces_n(contact: Contact, penetrations_mm: list[float]) -> list[float]:
    """Force on the ball at each penetration, on the way from the first to the last."""
    with TemporaryDirectory() as directory:
        job = Path(directory) / "contact"
        job.with_suffix(".inp").write_text("\n".join(deck(contact, penetrations_mm)) + "\n")
        run(job)
        reactions = totals(job.with_suffix(".dat").read_text())
    parts = PARTS[contact.ball.mesh.element_type]
    return [parts * balanced_force(reactions, float(step + 1)) for step in range(len(penetrations_mm))]


def run(job: Path) -> None:
    program = shutil.which("ccx")
    if program is None:
        raise SolverError("ccx is not installed; on Debian: apt-get install calculix-ccx")
    command = [program, job.name]
    environment = {**os.environ, "OMP_NUM_THREADS": "1"}
    try:
        done = subprocess.run(
            command, cwd=job.parent, env=environment, capture_output=True, text=True, timeout=TIME_LIMIT_S
        )
    except subprocess.TimeoutExpired as late:
        raise SolverError(f"ccx took more than {TIME_LIMIT_S} s") from late
    if done.returncode != 0:
        raise SolverError(f"ccx ended with {done.returncode}:\n{(done.stdout + done.stderr)[-2000:]}")


def totals(text: str) -> dict[tuple[str, float], float]:
    """Sum of the reactions along y by set and time. Steps end at whole times; what lies between are cut increments."""
    return {(found[1], float(found[2])): float(found[3]) for found in TOTAL.finditer(text)}


def balanced_force(reactions: dict[tuple[str, float], float], time: float) -> float:
    moving, holding = -reactions["MOVED", time], reactions["HELD", time]
    if not abs(moving - holding) <= LARGEST_IMBALANCE * abs(moving):
        raise SolverError(f"forces out of balance at step {time:g}: {moving} N and {holding} N")
    return moving


def deck(contact: Contact, penetrations_mm: list[float]) -> Iterator[str]:
    ball, body = contact.ball, contact.body
    after_ball = len(ball.mesh.nodes)
    yield from definition(ball, "MOVED", 1, 1)
    yield from definition(body, "HELD", 1 + after_ball, 1 + len(ball.mesh.elements))
    yield from [
        "*SURFACE INTERACTION, NAME=PENALTY",
        "*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=LINEAR",
        # The second value is the tension of an open contact, in MPa, which must not be 0.
        f"{contact.penalty_n_per_mm3:g}, 1e-3",
        # Node to surface does not converge here, see README.md.
        "*CONTACT PAIR, INTERACTION=PENALTY, TYPE=SURFACE TO SURFACE",
        f"{ball.name}, {body.name}",
        "*BOUNDARY",
        "MOVED, 1",
        "MOVED, 3",
        "HELD, 1, 3",
    ]
    for penetration in penetrations_mm:
        yield from step(penetration, contact.nonlinear)


def definition(body: Body, far_end: str, first_node: int, first_element: int) -> Iterator[str]:
    mesh = body.mesh
    yield "*NODE, NSET=ALL"
    for number, point in enumerate(mesh.nodes, first_node):
        yield f"{number}, " + ", ".join(f"{coordinate:.12g}" for coordinate in point)
    yield f"*ELEMENT, TYPE={mesh.element_type}, ELSET={body.name}"
    for number, corners in enumerate(mesh.elements, first_element):
        yield f"{number}, " + ", ".join(str(first_node + corner) for corner in corners)
    yield f"*SURFACE, NAME={body.name}, TYPE=ELEMENT"
    yield from (f"{first_element + element}, S1" for element in mesh.surface)
    yield f"*NSET, NSET={far_end}"
    yield from (f"{first_node + node}," for node in mesh.far_end)
    yield "*BOUNDARY"
    for axis, nodes in mesh.symmetry.items():
        yield from (f"{first_node + node}, {axis}" for node in nodes)
    yield from [
        f"*MATERIAL, NAME={body.name}",
        "*ELASTIC",
        f"{body.material.modulus_mpa:.12g}, {body.material.poisson:.12g}",
        f"*SOLID SECTION, ELSET={body.name}, MATERIAL={body.name}",
    ]


def step(penetration_mm: float, nonlinear: bool) -> Iterator[str]:
    yield "*STEP, INC=1000" + (", NLGEOM" if nonlinear else "")
    yield from ["*CONTROLS, PARAMETERS=FIELD", RESIDUALS]
    yield from ["*STATIC", "1., 1.", "*BOUNDARY", f"MOVED, 2, 2, {-penetration_mm:.12g}"]
    for nodes in ("MOVED", "HELD"):
        yield from [f"*NODE PRINT, NSET={nodes}, TOTALS=ONLY", "RF"]
    yield "*END STEP"
