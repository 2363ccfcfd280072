#!/usr/bin/env python3
"""What the service does while its surroundings fail, and afterwards: a full disk, a database that accepts no writes, a link to the server
that is cut or falls silent, a clock that is set back. Each time: problems as answers, readiness red with its reason, recovery
without help, nothing lost, every job ended once. With words, only those parts: disk, readonly, clock, link."""

import contextlib
import ctypes
import glob
import json
import os
import resource
import select
import shutil
import socket
import sqlite3
import struct
import subprocess
import sys
import tempfile
import threading
import time
import uuid

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), os.pardir))
from service import ARTICLE, ROOT, Service, binary, check, clean_environment  # noqa: E402

IS_ROOT = os.geteuid() == 0
NOBODY = 65534


def run(seconds, number):
    """A job of about this many seconds on one thread of an ordinary machine; no two jobs are identical."""
    operation = {"speed_rpm": 50000, "radial_load_y_n": 200 + number}
    return ARTICLE | {"scene": ARTICLE["scene"] | {"operation": operation}, "settle_s": 0, "duration_s": 0.12 * seconds,
                      "reuse": False, "solver": {"rung": "full", "relative_tolerance": 1e-6}}


class Jobs:
    """Submitted jobs by idempotency key, so that a job is submitted again after a lost response."""

    def __init__(self, service):
        self.service, self.paths, self.number = service, {}, 0

    def submit(self, seconds, padding=0):
        """Status of a submission. `settle` submits a refused job again."""
        self.number += 1
        job = run(seconds, self.number) | {"labels": [f"{self.number}"] + ["x" * 200] * padding}
        self.paths[str(uuid.uuid4())] = (job, None)
        return self._send(list(self.paths)[-1])

    def _send(self, key):
        job, _ = self.paths[key]
        try:
            status, headers, answer = self.service.request("POST", "/v1/jobs", job, {"Idempotency-Key": key}, timeout=40)
        except OSError as error:
            sys.exit(f"FAILED: a submission is not answered: {error}")
        if status == 202:
            self.paths[key] = (job, headers["Location"])
        self.answer, self.headers = answer, headers
        return status

    def last(self):
        return [path for _, path in self.paths.values() if path][-1]

    def settle(self, name, at_most=90):
        """Submits refused jobs again and checks that all have succeeded, each once."""
        for key, (_, path) in list(self.paths.items()):
            if path is None and self._send(key) != 202:
                sys.exit(f"FAILED: {name}: still refused afterwards: {self.answer}")
        ends = []
        for _, path in self.paths.values():
            job = self.service.ended(path, at_most)
            if job["status"] != "succeeded" or self.service.request("GET", f"{path}/metrics")[0] != 200:
                sys.exit(f"FAILED: {name}: {job}")
            ends.append((path, job["finished_at"]))
        count, page = 0, "/v1/jobs?limit=200"
        while page:
            listed = self.service.request("GET", page)[2]
            count, page = count + len(listed["jobs"]), listed["next"]
        check(count == len(self.paths) == len(set(ends)), f"{name}: all of {count} jobs have succeeded, each is there once")
        counted = self.service.request("GET", "/metrics")[2].decode()
        ended = [line for line in counted.splitlines() if line.startswith("raceway_runs_total")]
        check(ended == [f'raceway_runs_total{{end="succeeded"}} {count}'], f"{name}: each run has ended once {ended}")


@contextlib.contextmanager
def served(directory, command, **more):
    """A service that stops with status 0, unless it is killed or the check fails."""
    service = Service(directory, command=command, **more)
    try:
        yield service
    except BaseException:
        service.kill()
        sys.stderr.write(service.stderr()[-3000:])
        raise
    if service.process.poll() is None:
        check(service.stop() == 0, "the service stops with status 0")


def is_problem(answer, status, kind, found):
    what = answer["type"] if isinstance(answer, dict) and "type" in answer else answer
    check((found, what) == (status, f"urn:raceway:problem:{kind}"), f"answered with {found} {what}")


def until_ready(service, name, at_most):
    begin = time.monotonic()
    while (found := service.request("GET", "/health/ready"))[0] != 200:
        if time.monotonic() - begin > at_most:
            sys.exit(f"FAILED: {name}: not ready again after {at_most} s: {found[2]}\n{service.stderr()[-3000:]}")
        time.sleep(0.1)
    print(f"{name}: ready again after {time.monotonic() - begin:.1f} s")


def until_not_ready(service, words, at_most=20):
    begin = time.monotonic()
    while (found := service.request("GET", "/health/ready"))[0] == 200:
        if time.monotonic() - begin > at_most:
            sys.exit(f"FAILED: still ready after {at_most} s")
        time.sleep(0.1)
    check(found[0] == 503 and words in found[2]["detail"], f"not ready: {found[2]['detail']}")


@contextlib.contextmanager
def place():
    with tempfile.TemporaryDirectory(prefix="raceway-check-") as directory:
        yield directory


@contextlib.contextmanager
def small_disk(megabytes):
    """A disk of its own; a limit of the file size where this program may not mount one."""
    with place() as directory:
        command = ["mount", "-t", "tmpfs", "-o", f"size={megabytes}m,mode=777", "tmpfs", directory]
        mounted = IS_ROOT and subprocess.run(command, stderr=subprocess.DEVNULL).returncode == 0
        try:
            yield directory, mounted
        finally:
            if mounted:
                subprocess.run(["umount", "-l", directory], check=True)


class Ballast:
    """Fills a disk and empties it again."""

    def __init__(self, directory, mounted, service):
        self.path, self.mounted, self.pid = os.path.join(directory, "ballast"), mounted, service.process.pid
        self.log = os.path.join(directory, "raceway.db-wal")

    def fill(self):
        if not self.mounted:
            resource.prlimit(self.pid, resource.RLIMIT_FSIZE, (os.path.getsize(self.log), resource.RLIM_INFINITY))
            return
        with open(self.path, "wb", buffering=0) as file, contextlib.suppress(OSError):
            while True:
                file.write(bytes(4096))

    def remove(self):
        if self.mounted:
            os.remove(self.path)
        else:
            resource.prlimit(self.pid, resource.RLIMIT_FSIZE, (resource.RLIM_INFINITY, resource.RLIM_INFINITY))


def full_disk():
    with small_disk(16) as (directory, mounted), place() as elsewhere:
        name = "a full disk" if mounted else "a limit of the size of files"
        command = [binary(), "serve", "--listen", "127.0.0.1:0", "--workers", "1", "--database", f"sqlite://{directory}/raceway.db"]
        # The child inherits that this program ignores the signal of the limit.
        with served(elsewhere, command, restore_signals=False) as service:
            jobs, ballast = Jobs(service), Ballast(directory, mounted, service)
            jobs.submit(2)
            service.until(jobs.last(), lambda job: job["status"] == "running")
            running = jobs.last()
            waiting = [jobs.submit(0.1) for _ in range(3)]
            check(waiting == [202] * 3, f"{name}: jobs wait")
            ballast.fill()
            accepted = 0
            while (status := jobs.submit(0.02, padding=15)) == 202:
                accepted += 1
            is_problem(jobs.answer, *((507, "disk-full") if mounted else (503, "database-away")), status)
            check(jobs.headers["Retry-After"] is not None, f"{name}: {accepted} more are accepted, then none")
            until_not_ready(service, "no space is left" if mounted else "the database")
            # Longer than the run, so that the disk is full at its end.
            deadline = time.monotonic() + 60
            while "the end of a run could not be written" not in service.stderr() and time.monotonic() < deadline:
                time.sleep(0.2)
            check(service.request("GET", running)[2]["status"] == "running", f"{name}: a run whose end cannot be stored stays running")
            check(service.request("GET", "/health/live")[0] == 200, f"{name}: the service is alive")
            ballast.remove()
            until_ready(service, name, 20)
            jobs.settle(name)
        with contextlib.closing(sqlite3.connect(f"{directory}/raceway.db")) as connection:
            check(connection.execute("PRAGMA integrity_check").fetchall() == [("ok",)], f"{name}: the file is intact")


def refusal(program, database, **popen):
    told = subprocess.run([program, "serve", "--listen", "127.0.0.1:0", "--database", f"sqlite://{database}"], stdin=subprocess.DEVNULL,
                          capture_output=True, text=True, timeout=30, env=clean_environment(), **popen)
    check(told.returncode == 1 and told.stdout == "" and f"cannot open the database {database}: " in told.stderr
          or "cannot be locked" in told.stderr, f"refused: {told.stderr.strip().splitlines()[-1]}")
    return told.stderr


def read_only():
    """A read-only file, folder or disk prevents the start as an ordinary user. Its contents are unchanged afterwards."""
    user = {"user": NOBODY, "group": NOBODY, "extra_groups": []} if IS_ROOT else {}
    with small_disk(64) as (directory, mounted), place() as elsewhere:
        program = shutil.copy(binary(), os.path.join(elsewhere, "raceway"))
        os.chmod(elsewhere, 0o755)
        data = os.path.join(directory, "data")
        database = os.path.join(data, "raceway.db")
        os.mkdir(data)
        if IS_ROOT:
            os.chown(data, NOBODY, NOBODY)
        command = [program, "serve", "--listen", "127.0.0.1:0", "--workers", "1", "--database", f"sqlite://{database}"]

        def serves(paths):
            with served(elsewhere, command, **user) as service:
                if not paths:
                    paths.append(service.submit(run(0.02, 1))[0])
                check(all(service.ended(path)["status"] == "succeeded" for path in paths), "its job has succeeded")

        paths = []
        serves(paths)
        os.chmod(database, 0o444)
        refusal(program, database, **user)
        os.chmod(database, 0o644)
        serves(paths)
        # A writable file in a read-only folder: there is no place for the write-ahead log.
        os.chmod(data, 0o555)
        refusal(program, database, **user)
        os.chmod(data, 0o755)
        serves(paths)
        if mounted:
            subprocess.run(["mount", "-o", "remount,ro", directory], check=True)
            refusal(program, database, **user)
            subprocess.run(["mount", "-o", "remount,rw", directory], check=True)
            serves(paths)


def set_clock():
    """A clock that is set back by a day while jobs run and wait, then forward, and back again between two starts of the service."""
    libraries = glob.glob("/usr/lib/*/faketime/libfaketimeMT.so.1")
    check(libraries != [], "Debian's libfaketime is there")
    with place() as directory:
        offset = os.path.join(directory, "offset")

        def turn(by):
            with open(offset + ".new", "w", encoding="utf-8") as file:
                file.write(f"{by:+d}")
            os.rename(offset + ".new", offset)

        turn(0)
        # The monotonic clock is not faked, because nobody can set it.
        environment = clean_environment(LD_PRELOAD=libraries[0], FAKETIME_TIMESTAMP_FILE=offset, FAKETIME_NO_CACHE="1",
                                        FAKETIME_DONT_FAKE_MONOTONIC="1", DONT_FAKE_MONOTONIC="1")
        command = [binary(), "serve", "--listen", "127.0.0.1:0", "--workers", "1", "--lost-after-s", "1",
                   "--database", f"sqlite://{directory}/raceway.db"]
        with served(directory, command, environment=environment) as service:
            jobs = Jobs(service)
            jobs.submit(1)
            service.until(jobs.last(), lambda job: job["status"] == "running")
            jobs.submit(0.1)
            turn(-86_400)
            for _ in range(2):
                check(jobs.submit(0.1) == 202, "a clock set back: jobs are accepted")
            made = [service.request("GET", path)[2]["created_at"] for _, path in jobs.paths.values()]
            check(made[-1] < made[0], f"a clock set back: {made[0]}, then {made[-1]}")
            jobs.settle("a clock set back")
            figures = service.request("GET", "/metrics")[2].decode().splitlines()
            oldest = [line.split()[1] for line in figures if line.startswith("raceway_oldest_waiting_seconds ")]
            check(float(oldest[0]) >= 0, "a clock set back: no waiting time is negative")
            turn(+3600)
            jobs.submit(0.1)
            jobs.settle("a clock set forward")
            check(service.request("GET", "/health/ready")[0] == 200, "the service is ready")
            jobs.submit(3)
            service.until(jobs.last(), lambda job: job["status"] == "running")
            check(jobs.submit(0.1) == 202, "another job waits")
            service.kill()
            turn(-7 * 86_400)
            with served(directory, command, environment=environment) as again:
                ends = [again.ended(path)["status"] for _, path in jobs.paths.values()]
                check(set(ends) == {"succeeded"}, f"a clock set back between two starts: all of {len(ends)} jobs have succeeded")


# A packet filter (`man 7 socket`) that drops every packet. Data to such a socket are not even acknowledged.
NOTHING = ctypes.create_string_buffer(struct.pack("HBBI", 0x06, 0, 0, 0))
DROP_ALL = struct.pack("HxxxxxxP", 1, ctypes.addressof(NOTHING))
SO_ATTACH_FILTER, SO_DETACH_FILTER = 26, 27


class Link:
    """A relay to the server that can refuse or silence its connections."""

    def __init__(self, port):
        self.port, self.pairs, self.mode = port, [], "open"
        self.listener = None
        self._listen(0)
        self.own_port = self.listener.getsockname()[1]

    def _listen(self, port):
        self.listener = socket.create_server(("127.0.0.1", port))
        threading.Thread(target=self._accept, args=(self.listener,), daemon=True).start()

    def _accept(self, listener):
        while True:
            try:
                near, _ = listener.accept()
            except OSError:
                return
            far = socket.create_connection(("127.0.0.1", self.port))
            self.pairs.append((near, far))
            threading.Thread(target=self._relay, args=(near, far), daemon=True).start()

    def _relay(self, near, far):
        other = {near: far, far: near}
        with contextlib.suppress(OSError, ValueError):
            while True:
                for side in select.select([near, far], [], [])[0]:
                    data = side.recv(65536)
                    if self.mode == "silent":
                        return
                    if not data:
                        near.close()
                        far.close()
                        return
                    other[side].sendall(data)

    def refuse(self):
        """Resets all connections and refuses new ones."""
        self.mode = "refuse"
        self.listener.shutdown(socket.SHUT_RDWR)
        self.listener.close()
        for pair in self.pairs:
            for side in pair:
                with contextlib.suppress(OSError):
                    side.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
                    side.shutdown(socket.SHUT_RDWR)
                    side.close()
        self.pairs = []

    def fall_silent(self):
        """Drops all data without acknowledgement, on old and new connections. The side of the server stays open, as in a real outage."""
        self.mode = "silent"
        for near in [self.listener, *(near for near, _ in self.pairs)]:
            with contextlib.suppress(OSError):
                near.setsockopt(socket.SOL_SOCKET, SO_ATTACH_FILTER, DROP_ALL)

    def restore(self):
        """Opens new connections again. Silent ones stay silent."""
        if self.mode == "refuse":
            self.mode = "open"
            self._listen(self.own_port)
        else:
            self.mode = "open"
            self.listener.setsockopt(socket.SOL_SOCKET, SO_DETACH_FILTER, 0)


def psql(server, sql):
    program = sorted(glob.glob("/usr/lib/postgresql/*/bin/psql"))[-1]
    subprocess.run([program, server, "-q", "-o", "/dev/null", "-c", sql], check=True)


def lost_link(server):
    head, rest = server.rsplit("@", 1)
    address, _ = rest.split("/")
    for name, cut, away_s in (("a link that is cut", Link.refuse, 4), ("a link that falls silent", Link.fall_silent, 14)):
        database = "raceway_" + cut.__name__
        psql(server, f"CREATE DATABASE {database}")
        link = Link(int(address.split(":")[1]))
        with place() as directory:
            command = [binary(), "serve", "--listen", "127.0.0.1:0", "--workers", "1", "--lost-after-s", "5",
                       "--database", f"{head}@127.0.0.1:{link.own_port}/{database}"]
            with served(directory, command) as service:
                jobs = Jobs(service)
                jobs.submit(2)
                service.until(jobs.last(), lambda job: job["status"] == "running")
                waiting = [jobs.submit(0.1) for _ in range(3)]
                check(waiting == [202] * 3, f"{name}: jobs wait")
                path = jobs.last()
                cut(link)
                begin = time.monotonic()
                status = jobs.submit(0.1)
                print(f"{name}: a submission is answered after {time.monotonic() - begin:.1f} s")
                is_problem(jobs.answer, 503, "database-away", status)
                begin = time.monotonic()
                status, _, answer = service.request("GET", path)
                print(f"{name}: a look is answered after {time.monotonic() - begin:.1f} s")
                is_problem(answer, 503, "database-away", status)
                until_not_ready(service, "the database does not answer")
                check(service.request("GET", "/health/live")[0] == 200, f"{name}: the service is alive")
                time.sleep(max(0, away_s - (time.monotonic() - begin)))
                link.restore()
                until_ready(service, name, 30)
                jobs.settle(name)


def server_without_writes(server):
    """Refuses writes, like a server that became a replica or has a full disk."""
    with place() as directory:
        psql(server, "CREATE DATABASE raceway_reads")
        database = server.rsplit("/", 1)[0] + "/raceway_reads"

        def writes(may):
            psql(server, f"ALTER DATABASE raceway_reads SET default_transaction_read_only = {'off' if may else 'on'}")
            psql(server, "SELECT pg_terminate_backend(pid) FROM pg_stat_activity WHERE datname = 'raceway_reads'")

        command = [binary(), "serve", "--listen", "127.0.0.1:0", "--workers", "1", "--lost-after-s", "1", "--database", database]
        with served(directory, command) as service:
            jobs = Jobs(service)
            jobs.submit(1)
            service.until(jobs.last(), lambda job: job["status"] == "running")
            path = jobs.last()
            writes(False)
            time.sleep(1)
            status = jobs.submit(0.1)
            is_problem(jobs.answer, 503, "database-away", status)
            until_not_ready(service, "accepts no writes")
            check(service.request("GET", path)[0] == 200, "a server without writes: what is on record can be read")
            writes(True)
            until_ready(service, "a server without writes", 30)
            jobs.settle("a server without writes")


if __name__ == "__main__":
    parts = sys.argv[1:] or ["disk", "readonly", "clock", "link"]
    server = os.environ.get("RACEWAY_TEST_POSTGRES")
    for part in parts:
        begin = time.monotonic()
        if part == "link" and not server:
            again = [os.path.join(ROOT, ".ci", "with-postgres"), sys.executable, os.path.abspath(__file__), "link"]
            if (status := subprocess.run(again).returncode) != 0:
                sys.exit(status)
        elif part == "link":
            lost_link(server)
            server_without_writes(server)
        else:
            {"disk": full_disk, "readonly": read_only, "clock": set_clock}[part]()
        print(f"{part}: {time.monotonic() - begin:.0f} s")
