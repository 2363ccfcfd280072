#!/usr/bin/env python3
"""Two services on one PostgreSQL server whose answers to commits are lost: a relay cuts the connection after a write was committed,
or instead of sending it. Clients with idempotency keys repeat what was not answered, at either service, and cancel some jobs.

Afterwards each key has one job, each job has ended once, and a cancellation that was answered is kept. A trigger records every
change of a status; the reads of a job show these states in their order. JOBS, SECONDS (for the ends after the last submission),
SEED and PERCENT (writes that are cut) are 60, 60, 1 and 14 by default."""

import collections
import contextlib
import glob
import os
import random
import socket
import struct
import subprocess
import sys
import tempfile
import threading
import time

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), os.pardir))
from service import ROOT, Service, binary, check, clean_environment  # noqa: E402

JOBS = int(os.environ.get("JOBS", "60"))
SECONDS = float(os.environ.get("SECONDS", "60"))
SEED = int(os.environ.get("SEED", "1"))
CUT = float(os.environ.get("PERCENT", "14")) / 100
CLIENTS = 6
LONGEST_S = 30
ENDS = ("succeeded", "failed", "cancelled")
# A run whose claim was committed but not answered counts as lost, so that many losses are expected here.
OPTIONS = ["--workers", "1", "--lost-after-s", "2", "--max-lost-runs", "1000"]


class Relay:
    """A relay to PostgreSQL that loses commits and answers to them. It reads the protocol, so the link must not be encrypted."""

    def __init__(self, port, seed):
        self.server, self.random, self.lock = port, random.Random(seed), threading.Lock()
        self.cuts, self.writes, self.share = collections.Counter(), 0, 0.0
        self.listener = socket.create_server(("127.0.0.1", 0))
        self.port = self.listener.getsockname()[1]
        threading.Thread(target=self._accept, daemon=True).start()

    def _accept(self):
        while True:
            near, _ = self.listener.accept()
            far = socket.create_connection(("127.0.0.1", self.server))
            for side in (near, far):
                side.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            link = Link(self, near, far)
            threading.Thread(target=link.guarded, args=(link.requests,), daemon=True).start()
            threading.Thread(target=link.guarded, args=(link.answers,), daemon=True).start()

    def fate(self):
        """Fate of a write: `kept`, `unsent`, or `unanswered` although it is committed."""
        with self.lock:
            self.writes += 1
            return self.random.choice(["unsent", "unanswered", "unanswered"]) if self.random.random() < self.share else "kept"

    def count(self, fate):
        with self.lock:
            self.cuts[fate] += 1


class Link:
    """One connection through the relay."""

    def __init__(self, relay, near, far):
        self.relay, self.near, self.far = relay, near, far
        # Names of prepared statements that write, and the fates of the requests without an answer.
        self.writing, self.fates = set(), collections.deque()

    def guarded(self, work):
        with contextlib.suppress(OSError, EOFError, IndexError):
            work()
        self.cut()

    def cut(self):
        for side in (self.near, self.far):
            with contextlib.suppress(OSError):
                side.shutdown(socket.SHUT_RDWR)

    @staticmethod
    def read(file, count):
        data = file.read(count)
        if len(data) < count:
            raise EOFError
        return data

    def message(self, file):
        head = self.read(file, 5)
        return head[:1], head + self.read(file, struct.unpack("!I", head[1:])[0] - 4)

    def requests(self):
        """Forwards requests as a whole: up to a simple query or a synchronization."""
        file = self.near.makefile("rb")
        head = self.read(file, 4)
        self.far.sendall(head + self.read(file, struct.unpack("!I", head)[0] - 4))
        held, writes = b"", False
        while True:
            kind, message = self.message(file)
            held += message
            body = message[5:]
            if kind == b"P":
                name, sql = body.split(b"\0")[:2]
                (self.writing.add if is_write(sql) else self.writing.discard)(name)
            elif kind == b"B":
                writes |= body.split(b"\0")[1] in self.writing
            elif kind == b"Q":
                writes = is_write(body)
            elif kind not in b"SXp":
                continue
            if kind in b"QS":
                fate = self.relay.fate() if writes else "kept"
                if fate == "unsent":
                    self.relay.count(fate)
                    return
                self.fates.append(fate)
            if kind in b"QSXp":
                self.far.sendall(held)
                held, writes = b"", False

    def answers(self):
        """Forwards answers; that of an unanswered write is read to its end and dropped with the connection."""
        file, held = self.far.makefile("rb"), b""
        while True:
            kind, message = self.message(file)
            if self.fates and self.fates[0] == "unanswered":
                held += message
            else:
                self.near.sendall(message)
            if kind == b"Z" and self.fates:
                # Within a transaction nothing is committed yet.
                if self.fates.popleft() == "unanswered" and message[5:] == b"I":
                    self.relay.count("unanswered")
                    return
                self.near.sendall(held)
                held = b""


def is_write(sql):
    """Whether a statement may commit a change. Within a transaction its answer shows that it has not."""
    words = sql.upper()
    return any(word in words for word in (b"COMMIT", b"INSERT", b"UPDATE", b"DELETE"))


def psql(server, sql):
    program = sorted(glob.glob("/usr/lib/postgresql/*/bin/psql"))[-1]
    command = [program, server, "-qAt", "-F", " ", "-c", sql]
    told = subprocess.run(command, check=True, capture_output=True, text=True, stdin=subprocess.DEVNULL)
    return [line.split(" ") for line in told.stdout.splitlines()]


RECORDER = """
CREATE TABLE changes (number BIGSERIAL, job UUID, before TEXT, after TEXT, claim BIGINT);
CREATE FUNCTION record_change() RETURNS trigger LANGUAGE plpgsql AS $$ BEGIN
INSERT INTO changes (job, before, after, claim) VALUES (NEW.id, CASE TG_OP WHEN 'INSERT' THEN 'none' ELSE OLD.status END, NEW.status, NEW.claim);
RETURN NEW; END $$;
CREATE TRIGGER inserted AFTER INSERT ON jobs FOR EACH ROW EXECUTE FUNCTION record_change();
CREATE TRIGGER changed AFTER UPDATE ON jobs FOR EACH ROW WHEN (OLD.status <> NEW.status OR OLD.claim <> NEW.claim) EXECUTE FUNCTION record_change();
"""


def job(number, long):
    """A job of some tens of milliseconds, or one that is long enough to be cancelled during its run."""
    operation = {"speed_rpm": 20000 + 1000 * (number % 10), "radial_load_y_n": 150}
    run = {"settle_s": 0, "duration_s": 100, "solver": {"rung": "full"}} if long else {"duration_s": 0.2, "solver": {"rung": "radially_condensed"}}
    return {"kind": "simulation", "scene": {"bearing": "article-integrated", "operation": operation}, "reuse": False, **run}


class Client:
    """Submits, repeats, reads and cancels at random services."""

    def __init__(self, services, seed):
        self.services, self.random = services, random.Random(seed)
        # Reads (path and record), answers to submissions (key and path), and paths of jobs whose cancellation was answered.
        self.reads, self.made, self.cancelled = [], [], set()
        self.refused, self.slowest_s, self.fault = collections.Counter(), 0, None

    def request(self, method, path, body=None, key=None, expected=(200, 202)):
        """Answer to a request, which is repeated at a random service until it is an expected one."""
        deadline = time.monotonic() + LONGEST_S
        while time.monotonic() < deadline:
            service, begin = self.random.choice(self.services), time.monotonic()
            status, headers, answer = service.request(method, path, body, {"Idempotency-Key": key} if key else None, LONGEST_S)
            self.slowest_s = max(self.slowest_s, time.monotonic() - begin)
            if status in expected:
                return status, headers, answer
            kind = answer.get("type", "").removeprefix("urn:raceway:problem:")
            if (status, kind) != (503, "database-away"):
                raise AssertionError(f"{method} {path} is answered with {status}: {answer}")
            self.refused[f"{status} {kind}"] += 1
            time.sleep(self.random.uniform(0.01, 0.1))
        raise AssertionError(f"{method} {path} is refused for {LONGEST_S} s")

    def look(self, path):
        record = self.request("GET", path)[2]
        self.reads.append((path, record))
        return record

    def submit(self, number):
        long, key = number % 6 == 0, f"key-{number}"
        for _ in range(self.random.choice([1, 1, 2])):
            path = self.request("POST", "/v1/jobs", job(number, long), key)[1]["Location"]
            self.made.append((key, path))
        for _ in range(3):
            self.look(path)
        if long:
            status = self.request("POST", f"{path}/cancel", expected=(200, 202, 409))[0]
            if status != 409:
                self.cancelled.add(path)
        return path

    def work(self, numbers):
        try:
            paths, deadline = [self.submit(number) for number in numbers], time.monotonic() + SECONDS
            while paths and time.monotonic() < deadline:
                self.random.shuffle(paths)
                paths = [path for path in paths if self.look(path)["status"] not in ENDS]
                time.sleep(0.05)
            assert not paths, f"{len(paths)} jobs have not ended: {[self.look(path) for path in paths[:2]]}"
        except (AssertionError, OSError) as error:
            self.fault = repr(error)


def check_reads(reads, history):
    """Checks that the reads of each job, one after another, show its recorded states in their order."""
    place, ends = collections.Counter(), {}
    for path, record in reads:
        states = history[path.rsplit("/", 1)[1]]
        while place[path] < len(states) and states[place[path]] != record["status"]:
            place[path] += 1
        check_quietly(place[path] < len(states), f"{path} was {states} and is read as {record['status']} again")
        if record["status"] in ENDS:
            end = [record[field] for field in ("started_at", "finished_at", "error")]
            check_quietly(ends.setdefault(path, end) == end, f"the end of {path} was {ends[path]} and is {end}")


def check_quietly(holds, what):
    if not holds:
        sys.exit(f"FAILED: {what}")


def check_changes(changes, count):
    """Recorded states of each job. It begins once and ends once, and its claims only grow."""
    of_job = collections.defaultdict(list)
    for job_id, before, after, claim in changes:
        of_job[job_id].append((before, after, int(claim)))
    check_quietly(len(of_job) == count, f"{len(of_job)} jobs are recorded, {count} were made")
    for job_id, steps in of_job.items():
        check_quietly([step[0] for step in steps].count("none") == 1 and steps[0][0] == "none", f"{job_id} does not begin once: {steps}")
        check_quietly([step[1] in ENDS for step in steps].count(True) == 1 and steps[-1][1] in ENDS, f"{job_id} does not end once: {steps}")
        check_quietly(all(one[2] <= two[2] for one, two in zip(steps, steps[1:])), f"a claim of {job_id} is older than its predecessor: {steps}")
    return {job_id: [after for _, after, _ in steps] for job_id, steps in of_job.items()}


def main(server):
    head, rest = server.rsplit("@", 1)
    address, _ = rest.split("/")
    psql(server, "CREATE DATABASE raceway_history")
    relay = Relay(int(address.split(":")[1]), SEED)
    through = f"{head}@127.0.0.1:{relay.port}/raceway_history?sslmode=disable"
    direct = f"{head}@{address}/raceway_history"
    with tempfile.TemporaryDirectory(prefix="raceway-check-") as directory, contextlib.ExitStack() as stop:
        command = [binary(), "serve", "--listen", "127.0.0.1:0", "--database", through, *OPTIONS]
        services = []
        for name in ("one", "two"):
            os.mkdir(os.path.join(directory, name))
            services.append(Service(os.path.join(directory, name), command=command, environment=clean_environment()))
            stop.callback(services[-1].kill)
        psql(direct, RECORDER)
        relay.share = CUT
        clients = [Client(services, SEED + k) for k in range(1, CLIENTS + 1)]
        begin = time.monotonic()
        threads = [threading.Thread(target=client.work, args=(range(k, JOBS, CLIENTS),), daemon=True) for k, client in enumerate(clients)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join(SECONDS + 4 * LONGEST_S)
        took = time.monotonic() - begin
        relay.share = 0.0
        for client, thread in zip(clients, threads):
            check_quietly(not thread.is_alive(), "a client does not end")
            check_quietly(client.fault is None, f"{client.fault}\n{services[0].stderr()[-2000:]}\n{services[1].stderr()[-2000:]}")
        refused = sum((client.refused for client in clients), collections.Counter())
        print(f"history: {JOBS} jobs in {took:.0f} s; of {relay.writes} writes {relay.cuts['unsent']} were not sent and {relay.cuts['unanswered']} "
              f"were committed without answer; refused requests: {dict(refused)}; slowest answer {max(c.slowest_s for c in clients):.1f} s")
        check(relay.cuts["unanswered"] >= JOBS / 4, "answers to commits were lost")
        paths = collections.defaultdict(set)
        for client in clients:
            for key, path in client.made:
                paths[key].add(path)
        check(len(paths) == JOBS and all(len(made) == 1 for made in paths.values()), f"each of {JOBS} keys gives one job")
        made = {path for one in paths.values() for path in one}
        check(len(made) == JOBS, "no two keys give the same job")
        for path in made:
            record = clients[0].look(path)
            expected = "cancelled" if any(path in client.cancelled for client in clients) else "succeeded"
            check_quietly(record["status"] == expected, f"{path} is not {expected} but {record}")
            if expected == "succeeded":
                check_quietly(services[1].request("GET", f"{path}/metrics")[0] == 200, f"{path} has no metrics")
        check(True, "the answered cancellations are kept, the others have succeeded with a result")
        history = check_changes(psql(direct, "SELECT job, before, after, claim FROM changes ORDER BY number"), JOBS)
        returned = sum(pair == ("running", "queued") for states in history.values() for pair in zip(states, states[1:]))
        check(True, f"each job has ended once; {returned} runs were lost and returned to the queue")
        # Each job is read by one client, and by the first one at the end.
        reads = [read for client in [*clients[1:], clients[0]] for read in client.reads]
        check_reads(reads, history)
        check(True, f"{len(reads)} reads show the recorded states in their order")
        (results,), = psql(direct, "SELECT count(*) FROM results")
        (succeeded,), = psql(direct, "SELECT count(*) FROM jobs WHERE status = 'succeeded'")
        check(results == succeeded, f"{results} results are stored, one for each succeeded job")
        for service in services:
            check(service.stop() == 0, "a service stops with status 0")


if __name__ == "__main__":
    server = os.environ.get("RACEWAY_TEST_POSTGRES")
    if not server:
        again = [os.path.join(ROOT, ".ci", "with-postgres"), sys.executable, os.path.abspath(__file__)]
        sys.exit(subprocess.run(again).returncode)
    main(server)
