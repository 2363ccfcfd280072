#!/usr/bin/env python3
"""Time series are sent in parts, and those of a killed run are removed. With a URL as argument the first cases talk to a service that runs
there."""

import contextlib
import hashlib
import os
import sqlite3
import struct
import sys
import tempfile
import time

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), os.pardir))
from cases import run_cases, verdict  # noqa: E402
from service import ARTICLE, Service  # noqa: E402

CHANNEL = "spindle.y.displacement"
JOB = ARTICLE | {"settle_s": 0.02, "duration_s": 0.5, "outputs": {"series": [CHANNEL]}, "solver": {"rung": "radially_condensed"}}
NPY = {"Accept": "application/x-npy"}


def recorded(running):
    path, _ = running.submit(JOB)
    running.ended(path)
    return f"{path}/series"


def case_a_transfer_goes_on(running):
    """The parts of a NumPy file, each with the tag of the first answer, are the whole file."""
    path = recorded(running)
    status, fields, whole = running.request("GET", path, headers=NPY)
    verdict(status == 200 and fields.get("Accept-Ranges") == "bytes", f"the file announces parts: {fields.get('Accept-Ranges')}")
    parts, size = [], 100_003
    for begin in range(0, len(whole), size):
        headers = NPY | {"Range": f"bytes={begin}-{begin + size - 1}", "If-Range": fields["ETag"]}
        status, of_part, part = running.request("GET", path, headers=headers)
        end = min(begin + size, len(whole)) - 1
        if status != 206 or of_part.get("Content-Range") != f"bytes {begin}-{end}/{len(whole)}":
            return verdict(False, f"a part is answered with {status} {of_part.get('Content-Range')}")
        parts.append(part)
    verdict(hashlib.sha256(b"".join(parts)).digest() == hashlib.sha256(whole).digest(), f"{len(parts)} parts are the whole file")
    status, _, last = running.request("GET", path, headers=NPY | {"Range": "bytes=-16"})
    time_s, _ = struct.unpack("<dd", last) if len(last) == 16 else (0, 0)
    verdict(status == 206 and abs(time_s - 0.52 + 1 / 102_400) < 1e-9, f"the last record is that of the last value: {time_s} s")


def case_no_such_part(running):
    path = recorded(running)
    status, fields, answer = running.request("GET", path, headers=NPY | {"Range": "bytes=100000000-"})
    kind = answer.get("type", "").rsplit(":", 1)[-1] if isinstance(answer, dict) else ""
    verdict((status, kind) == (416, "range-not-satisfiable") and fields.get("Content-Range", "").startswith("bytes */"),
            f"bytes behind the end: {status} {kind} {fields.get('Content-Range')}")
    status = running.request("GET", path, headers=NPY | {"Range": "bytes=0-15", "If-Range": '"another"'})[0]
    verdict(status == 200, f"a part of another file is answered with the whole file: {status}")


def case_formats_agree(running):
    """JSON, CSV and NumPy file have the same bits."""
    path = recorded(running)
    series = running.request("GET", path)[2]
    lines = running.request("GET", path, headers={"Accept": "text/csv"})[2].decode().splitlines()[1:]
    whole = running.request("GET", path, headers=NPY)[2]
    records = list(struct.iter_unpack("<dd", whole[-16 * len(lines):]))
    points = list(zip(series["time_s"], series["value"]))
    verdict(len(points) == 51_200 and points == records, f"JSON and NumPy file have the same {len(points)} points")
    verdict(points == [tuple(map(float, line.split(","))) for line in lines], "CSV has them, too")
    thin = running.request("GET", f"{path}?from_s=0.1&to_s=0.2&max_points=100")[2]
    kept = [point for point in points if 0.1 <= point[0] <= 0.2]
    values = [value for _, value in kept]
    verdict(len(thin["value"]) <= 100 and max(thin["value"]) == max(values) and min(thin["value"]) == min(values),
            "a thinned part keeps its peaks")
    verdict(set(zip(thin["time_s"], thin["value"])) <= set(kept), "and has points of the series only")


def ask(database, sql):
    with contextlib.closing(sqlite3.connect(f"file:{database}?mode=ro", uri=True, timeout=30)) as connection:
        return [row[0] for row in connection.execute(sql)]


def case_a_killed_run_leaves_nothing(_):
    """Chunks of a killed run are removed after the next start. The job ends with its whole series."""
    if sys.argv[1:]:
        return
    long = JOB | {"duration_s": 20}
    with tempfile.TemporaryDirectory(prefix="raceway-check-") as directory:
        database = os.path.join(directory, "raceway.db")
        first = Service(directory, "--workers", "1")
        path, _ = first.submit(long)
        deadline = time.monotonic() + 60
        while not (killed := ask(database, "SELECT result_id FROM series_chunks")) and time.monotonic() < deadline:
            time.sleep(0.02)
        first.kill()
        verdict(len(killed) > 0, f"chunks are stored during the run: {len(killed)}")
        second = Service(directory, "--workers", "1")
        deadline = time.monotonic() + 30
        while killed[0] in ask(database, "SELECT id FROM results") and time.monotonic() < deadline:
            time.sleep(0.1)
        left = ask(database, "SELECT result_id FROM series_chunks").count(killed[0])
        verdict(left == 0, f"those of the killed run are removed: {left} are left")
        ended = second.ended(path)
        status, fields, _ = second.request("GET", f"{path}/series", headers=NPY | {"Range": "bytes=0-0"})
        verdict(ended["status"] == "succeeded" and fields.get("Content-Range") == f"bytes 0-0/{128 + 16 * 2_048_000}",
                f"the job ends with its whole series: {ended['status']} {status} {fields.get('Content-Range')}")
        chunks = ask(database, "SELECT number FROM series_chunks")
        verdict(sorted(chunks) == list(range(125)) and not ask(database, "SELECT 1 FROM recordings"), f"which has 125 chunks: {len(chunks)}")
        second.stop()


run_cases(globals())
