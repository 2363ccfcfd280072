#!/usr/bin/env python3
"""Two servers on one PostgreSQL database accept no less than one on the same cores, because submissions wait for no lock of the database.
Prints rates, what the sessions of the database wait for, and the processor time of a submission."""

import collections
import json
import os
import re
import statistics
import subprocess
import sys
import tempfile
import threading
import time
import uuid

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), os.pardir))
from service import ROOT, Service, binary, check  # noqa: E402

GOAL = 0.95
# Pairs of measurements, one server and two in turn, and the time of each [s].
ROUNDS, SECONDS = int(os.environ.get("ROUNDS", "5")), int(os.environ.get("SECONDS", "4"))
CONNECTIONS = 64
SMALL = {"kind": "simulation", "reuse": False, "settle_s": 0, "duration_s": 0.001, "scene": {"bearing": "608", "operation": {"speed_rpm": 3000}}}
LUA = 'wrk.method, wrk.body = "POST", [[%s]]\nwrk.headers["Content-Type"] = "application/json"\n'
SERVER = os.environ.get("RACEWAY_TEST_POSTGRES")


def ask(database, sql):
    return subprocess.run(["psql", database, "-Atc", sql], capture_output=True, text=True, check=True).stdout.strip()


def accepted(servers, script):
    """Accepted submissions a second of all servers together."""
    command = ["wrk", "-t1", f"-c{CONNECTIONS // len(servers)}", f"-d{SECONDS}", "--timeout", "20", "-s", script]
    running = [subprocess.Popen([*command, f"{server.url}/v1/jobs"], stdout=subprocess.PIPE, text=True) for server in servers]
    told = [process.communicate(timeout=120)[0] for process in running]
    check(all(process.returncode == 0 for process in running) and "Non-2xx" not in "".join(told), f"{len(servers)} of 2 servers: none is refused")
    return sum(float(re.search(r"Requests/sec:\s+([\d.]+)", text)[1]) for text in told)


def watched(database, stop, waits):
    """Counts what the sessions of the database wait for, until `stop` is set."""
    sql = "SELECT coalesce(wait_event_type || ' ' || wait_event, 'processor') FROM pg_stat_activity WHERE application_name = 'raceway' AND state = 'active'"
    while not stop.wait(0.05):
        waits.update(line for line in ask(database, sql).splitlines() if line)


def processor_time(servers):
    """Processor time of servers [s]."""
    ticks = 0
    for server in servers:
        with open(f"/proc/{server.process.pid}/stat", encoding="ascii") as file:
            fields = file.read().rsplit(")", 1)[1].split()
        ticks += int(fields[11]) + int(fields[12])
    return ticks / os.sysconf("SC_CLK_TCK")


def run():
    name = f"raceway_{uuid.uuid4().hex}"
    ask(SERVER, f"CREATE DATABASE {name}")
    database = SERVER.rsplit("/", 1)[0] + "/" + name
    with tempfile.TemporaryDirectory(prefix="raceway-check-") as directory:
        script = os.path.join(directory, "post.lua")
        with open(script, "w", encoding="utf-8") as file:
            file.write(LUA % json.dumps(SMALL))
        servers = []
        for number in range(2):
            place = os.path.join(directory, str(number))
            os.mkdir(place)
            # Without workers: what is compared is the acceptance.
            command = [binary(), "serve", "--listen", "127.0.0.1:0", "--workers", "0", "--queue-limit", "10000000", "--database", database]
            servers.append(Service(place, command=command))
        try:
            accepted(servers, script)
            ratios, rates, waits, stop = [], [], collections.Counter(), threading.Event()
            watcher = threading.Thread(target=watched, args=(database, stop, waits))
            watcher.start()
            before, begin = processor_time(servers), time.monotonic()
            for number in range(ROUNDS):
                # In both orders: the tables grow.
                pair = [accepted(servers[:count], script) for count in ((1, 2) if number % 2 else (2, 1))]
                one, two = pair if number % 2 else pair[::-1]
                ratios.append(two / one)
                rates.append((one, two))
                print(f"one server accepts {one:.0f}/s, two {two:.0f}/s: {two / one:.2f}", flush=True)
            spent, took = processor_time(servers) - before, time.monotonic() - begin
            stop.set()
            watcher.join()
            count = sum(one + two for one, two in rates) * SECONDS
            print(f"processor time of the servers: {1e6 * spent / count:.0f} µs for each submission, {100 * spent / took:.0f} % of one core")
            total = sum(waits.values()) or 1
            print("sessions wait for: " + ", ".join(f"{what} {100 * number / total:.0f} %" for what, number in waits.most_common(6)))
            locks = sum(number for what, number in waits.items() if what.startswith("Lock "))
            check(locks <= 0.02 * total, f"sessions wait for locks in {100 * locks / total:.1f} % of the looks")
            ratio = statistics.median(ratios)
            check(ratio >= GOAL, f"two servers accept {ratio:.2f} of one, at least {GOAL}")
        finally:
            for server in servers:
                server.stop()


if not SERVER:
    again = [os.path.join(ROOT, ".ci", "with-postgres"), sys.executable, os.path.abspath(__file__)]
    sys.exit(subprocess.run(again).returncode)
run()
