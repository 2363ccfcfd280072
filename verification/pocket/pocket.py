"""Checks the pocket contact of the service by finite elements (CalculiX); see README.md."""

import argparse
import csv
import sys
from collections.abc import Iterable, Iterator
from itertools import groupby
from pathlib import Path

from calculix import SolverError
from cases import ARTICLE, BAR, CASES, FLAT, LEVELS, Case
from laws import hertz_n, hertz_penetration_mm, service_n

RESULTS = Path(__file__).with_name("results.csv")
QUICK = (FLAT, ARTICLE, BAR)
# The same mesh by another build of CalculiX: what its rounding and its iterations may do.
REPEATED = 0.005
# Law and stored converged force: the article's figure, over the range of loads.
AGREED = 0.13
HERTZ_AGREED = 0.01

Row = dict[str, str]


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    commands = parser.add_subparsers(dest="command", required=True)
    commands.add_parser("run", help="compute all cases on three meshes and write results.csv (12 minutes)")
    commands.add_parser("quick", help="compute three cases on the coarsest mesh and compare with results.csv")
    commands.add_parser("table", help="print results.csv as tables")
    command = parser.parse_args().command
    try:
        return {"run": run, "quick": quick, "table": table}[command]()
    except SolverError as error:
        print(error, file=sys.stderr)
        return 2


def run() -> int:
    rows = []
    for case in CASES:
        print(case.name, file=sys.stderr, flush=True)
        rows += compared(case, [case.forces_n(level) for level in LEVELS])
    with RESULTS.open("w", newline="") as file:
        writer = csv.DictWriter(file, rows[0], lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)
    return 0


def quick() -> int:
    stored = read()
    complaints = [complaint for case in QUICK for complaint in differences(case, stored.get(case.name, []))]
    for complaint in complaints:
        print(complaint)
    if not complaints:
        print(f"{', '.join(case.name for case in QUICK)}: as in {RESULTS.name}")
    return 1 if complaints else 0


def table() -> int:
    for name, rows in read().items():
        print(f"\n{name}\n")
        columns = list(rows[0])[1:]
        print_row(columns)
        print_row(["---:"] * len(columns))
        for row in rows:
            print_row(row[column] for column in columns)
    return 0


def print_row(cells: Iterable[str]) -> None:
    print(f"| {' | '.join(cells)} |")


def read() -> dict[str, list[Row]]:
    with RESULTS.open(newline="") as file:
        return {name: list(rows) for name, rows in groupby(csv.DictReader(file), lambda row: row["case"])}


def differences(case: Case, stored: list[Row]) -> Iterator[str]:
    """What a coarse run, or the law as it is now, has else than the stored results."""
    if len(stored) != len(case.loads_n):
        yield f"{case.name}: {len(case.loads_n)} loads, but {len(stored)} in {RESULTS.name}"
        return
    for row, force, penetration in zip(stored, case.forces_n(LEVELS[0]), case.penetrations_mm, strict=True):
        place = f"{case.name} at {row['penetration_um']} µm"
        coarse, converged = float(row["force_fe_coarse_n"]), float(row["force_fe_converged_n"])
        if abs(force / coarse - 1) > REPEATED:
            yield f"{place}: {force:.5g} N on the coarse mesh, stored {coarse:.5g} N"
        law = law_n(case, penetration)
        if abs(law / converged - 1) > (HERTZ_AGREED if case is FLAT else AGREED):
            yield f"{place}: {law:.5g} N by the law, {converged:.5g} N by finite elements"


def compared(case: Case, meshes: list[list[float]]) -> Iterator[Row]:
    """One row for each penetration, from forces on the coarse, medium and fine mesh."""
    clearance = case.clearance_mm
    for penetration, *forces in zip(case.penetrations_mm, *meshes, strict=True):
        # As written, so that the rest of a row follows from what stands in it.
        coarse, medium, fine = (float(f"{force:.5g}") for force in forces)
        converged = extrapolated(medium, fine)
        hertz = hertz_n(case.contact_modulus_mpa, case.relative_radius_mm, penetration)
        law = law_n(case, penetration)
        yield {
            "case": case.name,
            "pocket_clearance_mm": "" if clearance is None else f"{2 * clearance:g}",
            "penetration_um": f"{1e3 * penetration:.5g}",
            "penetration_over_half_clearance": "" if clearance is None else f"{penetration / clearance:.4f}",
            "force_fe_coarse_n": f"{coarse:.5g}",
            "force_fe_medium_n": f"{medium:.5g}",
            "force_fe_fine_n": f"{fine:.5g}",
            "force_fe_converged_n": f"{converged:.5g}",
            "mesh_error_percent": f"{100 * abs(converged / fine - 1):.2f}",
            "force_hertz_n": f"{hertz:.5g}",
            "hertz_over_fe": f"{hertz / converged:.3f}",
            "force_law_n": f"{law:.5g}",
            "law_over_fe": f"{law / converged:.3f}",
            **series(case, penetration, converged),
        }


def law_n(case: Case, penetration_mm: float) -> float:
    """The law of the service; on a flat there is no seat, and it is Hertz's."""
    if case.clearance_mm is None:
        return hertz_n(case.contact_modulus_mpa, case.relative_radius_mm, penetration_mm)
    return service_n(case.contact_modulus_mpa, case.ball_radius_mm, case.clearance_mm, penetration_mm)


def series(case: Case, penetration_mm: float, force_n: float) -> Row:
    """Stiffness of a bar in series by which Hertz gives the force of the finite elements, for bars softer than it."""
    if case.wall.half_width is None:
        return {"bar_stiffness_n_per_m": ""}
    taken = penetration_mm - hertz_penetration_mm(case.contact_modulus_mpa, case.relative_radius_mm, force_n)
    return {"bar_stiffness_n_per_m": f"{1e3 * force_n / taken:.2g}" if taken > 0 else ""}


def extrapolated(medium: float, fine: float) -> float:
    """Richardson, to elements of size 0: they are linear, their error falls by the square of their size."""
    _, medium_level, fine_level = LEVELS
    return fine + (fine - medium) / ((fine_level / medium_level) ** 2 - 1)


if __name__ == "__main__":
    sys.exit(main())
