#!/usr/bin/env python3
"""SIGKILL at random times: of a service on SQLite, and of a service and two workers on PostgreSQL. Jobs are submitted with idempotency
keys. Each ends once, with the result of an undisturbed run to the bit. KILLS and JOBS set their numbers on each database (20 and
200 by default), SEED the times. `.ci/long kills` is the long form."""

import atexit
import json
import os
import random
import signal
import sqlite3
import subprocess
import sys
import tempfile
import threading
import time
import urllib.error

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), os.pardir))
from service import ROOT, Service, binary, check, clean_environment, free_port  # noqa: E402

KILLS = int(os.environ.get("KILLS", "20"))
JOBS = int(os.environ.get("JOBS", "200"))
SEED = int(os.environ.get("SEED", "1"))
# Scenes that run repeatedly. Their results are known from an undisturbed run.
SCENES = 10
PATIENCE = ["--max-lost-runs", "1000", "--lost-after-s", "1"]


# The last scene is that of a shaft on two bearings.
SHAFT = {"shaft": {"sections": [{"length_mm": 300, "outer_diameter_mm": 25}], "unbalances": [{"at_mm": 150, "unbalance_g_mm": 20}]},
         "bearings": [{"name": "A", "bearing": "6205", "at_mm": 40, "faces": "+x"}, {"name": "B", "bearing": "6205", "at_mm": 260, "faces": "-x"}],
         "preloads": [{"between": ["A", "B"], "force_n": 200}], "operation": {"speed_rpm": 12000}}


def job(number):
    """A job of some tens of milliseconds; that of a shaft takes tenths of a second and keeps a series."""
    if number % SCENES == SCENES - 1:
        return {"kind": "machine", "scene": SHAFT, "reuse": False, "settle_s": 0, "duration_s": 0.02,
                "outputs": {"series": ["A.y.acceleration"]}, "labels": [f"job-{number}"]}
    operation = {"speed_rpm": 20000 + 1000 * (number % SCENES), "radial_load_y_n": 150}
    return {"kind": "simulation", "scene": {"bearing": "article-integrated", "operation": operation}, "reuse": False,
            "duration_s": 0.2, "solver": {"rung": "radially_condensed"}, "labels": [f"job-{number}"]}


def result(service, path, number):
    """The result of a job without measured times."""
    if number % SCENES == SCENES - 1:
        series = service.request("GET", f"{path}/series")[2]
        return json.dumps([service.request("GET", f"{path}/machine")[2], series], sort_keys=True)
    metrics = service.request("GET", f"{path}/metrics")[2]
    solver = {name: value for name, value in metrics["solver"].items() if name not in ("wall_time_s", "real_time_factor")}
    return json.dumps({**metrics, "solver": solver}, sort_keys=True)


def undisturbed():
    with tempfile.TemporaryDirectory(prefix="raceway-check-") as directory:
        service = Service(directory)
        paths = [service.submit(job(number))[0] for number in range(SCENES)]
        results = []
        for number, path in enumerate(paths):
            check_succeeded(service.ended(path))
            results.append(result(service, path, number))
        service.stop()
        return results


def check_succeeded(job):
    if job["status"] != "succeeded":
        sys.exit(f"FAILED: a job has {job['status']}: {job['error']}")


class Worker:
    """`raceway worker`."""

    def __init__(self, database, log):
        command = [binary(), "worker", "--database", database, "--workers", "1", *PATIENCE]
        self.process = subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=log,
                                        env=clean_environment())
        STARTED.append(self.process)

    def kill(self):
        self.process.kill()
        self.process.wait()


# All started processes, so that none outlives a failed check.
STARTED = []
atexit.register(lambda: [process.kill() for process in STARTED])


def serve(directory, database, port, *options):
    command = [binary(), "serve", "--listen", f"127.0.0.1:{port}", "--database", database, *PATIENCE, *options]
    service = Service(directory, command=command)
    STARTED.append(service.process)
    return service


def hand_in(client, paths):
    """Submits every job until it is answered. Its key creates it once."""
    for number in range(JOBS):
        while paths[number] is None:
            try:
                key = {"Idempotency-Key": f"key-{number}"}
                status, headers, answer = client["service"].request("POST", "/v1/jobs", job(number), key, timeout=10)
                if status != 202:
                    sys.exit(f"FAILED: a submission is answered with {status}: {answer}")
                paths[number] = headers["Location"]
            except (urllib.error.URLError, OSError):
                time.sleep(0.02)
        time.sleep(0.01)


def storm(name, start, expected):
    """Kills processes until the number of kills is reached and all jobs have ended."""
    rng = random.Random(SEED)
    processes = [one() for one in start]
    client = {"service": processes[0]}
    paths = [None] * JOBS
    hands = threading.Thread(target=hand_in, args=(client, paths), daemon=True)
    hands.start()
    begin = time.monotonic()
    for _ in range(KILLS):
        time.sleep(rng.uniform(0.05, 0.8))
        which = rng.randrange(len(processes))
        processes[which].kill()
        processes[which] = start[which]()
        client["service"] = processes[0]
    hands.join(timeout=300)
    check(not hands.is_alive(), f"{name}: all of {JOBS} jobs are submitted")
    service = processes[0]
    for path in paths:
        check_succeeded(service.ended(path, at_most=300))
    check(True, f"{name}: all have succeeded, {time.monotonic() - begin:.0f} s after the first, through {KILLS} kills")
    check(len(set(paths)) == JOBS, f"{name}: all jobs have different identifiers")
    for number, path in enumerate(paths):
        if result(service, path, number) != expected[number % SCENES]:
            sys.exit(f"FAILED: {path} differs from the undisturbed run")
    check(True, f"{name}: results equal those of undisturbed runs, to the bit")
    count, page = 0, "/v1/jobs?limit=200"
    while page:
        listed = service.request("GET", page)[2]
        count, page = count + len(listed["jobs"]), listed["next"]
    check(count == JOBS, f"{name}: {count} jobs are stored, each once")
    return processes


def on_sqlite(expected):
    with tempfile.TemporaryDirectory(prefix="raceway-check-") as directory:
        database, port = os.path.join(directory, "raceway.db"), free_port()
        service, = storm("SQLite", [lambda: serve(directory, f"sqlite://{database}", port)], expected)
        check(service.stop() == 0, "SQLite: the service stops with status 0")
        with sqlite3.connect(database) as connection:
            told = connection.execute("PRAGMA integrity_check").fetchall()
            results, = connection.execute("SELECT count(*) FROM results").fetchone()
        check(told == [("ok",)] and results == JOBS, f"SQLite: the file is intact and holds {results} results")


def on_postgres(expected, server):
    with tempfile.TemporaryDirectory(prefix="raceway-check-") as directory:
        port = free_port()
        with open(os.path.join(directory, "workers.log"), "ab") as log:
            start = [lambda: serve(directory, server, port, "--workers", "0"), lambda: Worker(server, log), lambda: Worker(server, log)]
            processes = storm("PostgreSQL", start, expected)
            # A worker that sleeps past its lease and wakes up does not change a finished job.
            service, sleeper, other = processes
            other.kill()
            path = service.submit({**job(0), "duration_s": 100})[0]
            service.until(path, lambda job: job["status"] == "running")
            sleeper.process.send_signal(signal.SIGSTOP)
            processes[2] = start[2]()
            ended = service.ended(path)
            check_succeeded(ended)
            sleeper.process.send_signal(signal.SIGCONT)
            time.sleep(3)
            now = service.request("GET", path)[2]
            check(now["finished_at"] == ended["finished_at"], "PostgreSQL: a worker that slept past its lease changes nothing")
            for process in processes:
                process.kill()


if __name__ == "__main__":
    server = os.environ.get("RACEWAY_TEST_POSTGRES")
    expected = undisturbed()
    if sys.argv[1:] != ["postgres"]:
        on_sqlite(expected)
        again = [os.path.join(ROOT, ".ci", "with-postgres"), sys.executable, os.path.abspath(__file__), "postgres"]
        sys.exit(subprocess.run(again).returncode)
    on_postgres(expected, server)
