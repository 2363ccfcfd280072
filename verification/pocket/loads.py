"""Largest pocket loads of runs of the service: `loads.py PROGRAM`, the release binary."""

import argparse
import json
import subprocess
from itertools import product
from pathlib import Path
from tempfile import TemporaryDirectory

SPEEDS_RPM = {
    "article-integrated": (50_000, 60_000),
    "article-deep-groove": (50_000, 60_000),
    "608": (10_000, 20_000),
    "6204": (10_000, 20_000),
    "6205": (10_000, 20_000),
}
LOADS = ({"radial_load_y_n": 200}, {"radial_load_z_n": 200}, {"radial_load_z_n": 20})
FILMS = ("wedge", "none")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("program", type=Path, help="the service's binary")
    program = parser.parse_args().program.resolve()
    print("| bearing | r/min | film | largest pocket load of three radial loads, N |")
    print("|---|---:|---|---|")
    for (bearing, speeds), film in product(SPEEDS_RPM.items(), FILMS):
        for speed in speeds:
            loads = [largest_load_n(program, scene(bearing, speed, film, load)) for load in LOADS]
            print(f"| {bearing} | {speed} | {film} | {', '.join(f'{load:.2f}' for load in loads)} |")


def scene(bearing: str, speed_rpm: int, film: str, load: dict[str, int]) -> dict[str, object]:
    return {
        "bearing": {"preset": bearing, "cage": {"film": film}},
        "operation": {"speed_rpm": speed_rpm, **load},
    }


def largest_load_n(program: Path, scene: dict[str, object]) -> float:
    job = {"kind": "simulation", "scene": scene, "settle_s": 0.02, "duration_s": 0.1, "solver": {"rung": "full"}}
    with TemporaryDirectory() as directory:
        file = Path(directory) / "job.json"
        file.write_text(json.dumps(job))
        done = subprocess.run([program, "simulate", file], capture_output=True, text=True, check=True)
    return json.loads(done.stdout)["contacts"]["pocket"]["max_load_n"]


if __name__ == "__main__":
    main()
