#!/usr/bin/env python3
"""Who may reach the service: nobody from outside without tokens, nobody with a wrong one, no foreign page. And what is secret stays
so: in no log, answer, figure, argument or row, however much is logged."""

import glob
import json
import os
import secrets
import socket
import subprocess
import sys
import tempfile
import time

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), os.pardir))
from service import ARTICLE, ROOT, Service, binary, check, clean_environment  # noqa: E402

TOKEN, OTHER, WRONG, PASSWORD = (f"{name}-{secrets.token_hex(16)}" for name in ("mine", "theirs", "wrong", "password"))
REQUEST = "portal-17/a"


def lan_address():
    """An address of this machine that others reach; none where there is no network."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        try:
            # Nothing is sent: only the way there is looked up.
            probe.connect(("192.0.2.1", 9))
            return [f"{probe.getsockname()[0]}:0"]
        except OSError:
            return []


def start(listen, tokens, insecure):
    """What becomes of a start: whether it is let happen, and what a stranger is answered."""
    with tempfile.TemporaryDirectory() as directory:
        command = [binary(), "serve", "--listen", listen, "--database", f"sqlite://{directory}/r.db", "--workers", "1"]
        command += ["--insecure-no-auth"] * insecure
        environment = clean_environment(**{"RACEWAY_API_TOKENS": tokens} if tokens else {})
        if not tokens and not insecure and not listen.startswith(("127.", "[::1]")):
            refused = subprocess.run(command, stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=20, env=environment)
            told = "RACEWAY_API_TOKENS" in refused.stderr and "--insecure-no-auth" in refused.stderr
            untouched = os.listdir(directory) == []
            return "refused" if refused.returncode == 1 and refused.stdout == "" and told and untouched else repr(refused)
        running = Service(directory, command=command, environment=environment)
        try:
            foreign = running.request("GET", "/v1/jobs", headers={"Host": "evil.example"})[0]
            local = running.request("GET", "/v1/jobs", headers={"Host": "localhost"})[0]
            warned = "whoever reaches the port may do everything" in running.stderr()
            return foreign, local, warned
        finally:
            running.stop()


def matrix():
    loopback, beyond = ["127.0.0.1:0", "[::1]:0"], ["0.0.0.0:0", "[::]:0", *lan_address()]
    for listen in loopback + beyond:
        is_open = listen in beyond
        wanted = {
            (None, False): "refused" if is_open else (421, 200, False),
            (TOKEN, False): (401, 401, False),
            (None, True): (200, 200, True) if is_open else (421, 200, False),
            (TOKEN, True): (401, 401, False),
        }
        for (tokens, insecure), expected in wanted.items():
            found = start(listen, tokens, insecure)
            what = f"{'a token' if tokens else 'no token'}{', --insecure-no-auth' * insecure}"
            check(found == expected, f"{listen} with {what}: {found}")


def a_whole_run(directory, database):
    """Everything that a service does with its secrets, while it logs all it can: what it logged, and what it answered."""
    environment = clean_environment(RACEWAY_API_TOKENS=f"{TOKEN},{OTHER}", RACEWAY_DATABASE=database, RACEWAY_LOG="trace", RUST_LOG="trace",
                                    RACEWAY_LOG_FORMAT="json")
    command = [binary(), "serve", "--listen", "0.0.0.0:0", "--workers", "1"]
    running = Service(directory, command=command, environment=environment)
    answers = []

    def ask(method, path, body=None, **headers):
        status, fields, content = running.request(method, path, body, headers)
        answers.append(f"{method} {status} {fields} {content}")
        return status, fields

    try:
        for path in ("/health/live", "/health/ready", "/openapi.json", "/docs/", "/"):
            check(ask("GET", path)[0] == 200, f"{path} is open")
        status, fields = ask("GET", "/v1/jobs")
        check(status == 401 and fields["WWW-Authenticate"] == "Bearer", "jobs need a token")
        for wrong in (WRONG, TOKEN[:-1], TOKEN + "x", f"{TOKEN},{OTHER}"):
            check(ask("GET", "/v1/jobs", Authorization=f"Bearer {wrong}")[0] == 401, "a wrong token is refused")
        check(ask("GET", "/v1/jobs", Authorization=f"Basic {TOKEN}")[0] == 401, "and so is a right one in the wrong words")
        for query in (f"token={TOKEN}", f"access_token={TOKEN}", f"limit={TOKEN}"):
            check(ask("GET", f"/v1/jobs?{query}")[0] == 401, "a token in the query lets nobody in")
            check(ask("GET", f"/v1/jobs?{query}", Authorization=f"Bearer {TOKEN}")[0] == 400, "and is a mistake")
        mine = {"Authorization": f"Bearer {TOKEN}"}
        status, fields = ask("POST", "/v1/jobs", ARTICLE | {"duration_s": 0.02}, Prefer="wait=60", **mine,
                             **{"Idempotency-Key": "a-key", "X-Request-Id": REQUEST})
        check(status == 200 and fields["X-Request-Id"] == REQUEST, "a job runs, and its request keeps its name")
        path = fields["Location"]
        for rest in ("", "/metrics", "/events", "/spectrum?channel=spindle.y.acceleration", "/plots/spectrum.svg"):
            check(ask("GET", path + rest, **mine)[0] == 200, f"…{rest or '/'} is there")
        check(ask("GET", path, Authorization=f"Bearer {OTHER}")[0] == 404, "for its owner alone")
        check(ask("GET", "/metrics", **mine)[0] == 200 and ask("POST", "/v1/jobs", {"kind": 7}, **mine)[0] == 422, "figures and refusals")
        with open(f"/proc/{running.process.pid}/cmdline", encoding="utf-8") as file:
            answers.append(file.read())
        if database.startswith("postgres"):
            worker = subprocess.Popen([binary(), "worker"], env=environment, stdin=subprocess.DEVNULL, text=True,
                                      stdout=subprocess.PIPE, stderr=running.log)
            answers.append(worker.stdout.readline())
            worker.terminate()
            worker.wait()
            # Sessions that break off are told of in the log.
            tell("SELECT pg_terminate_backend(pid) FROM pg_stat_activity WHERE application_name = 'raceway'")
            time.sleep(3)
            check(ask("GET", path, **mine)[0] == 200, "a session that was cut is made again")
        second = subprocess.run(command, env=environment | {"RACEWAY_DATABASE": f"postgres://raceway:{PASSWORD}@127.0.0.1:1/r"},
                                capture_output=True, text=True, timeout=30)
        check(second.returncode == 1 and "127.0.0.1:1" in second.stderr, "a server that is not there is named")
        answers.append(second.stdout + second.stderr)
    finally:
        running.stop()
    return running.stderr(), "\n".join(answers)


def postgres(program):
    return sorted(glob.glob(f"/usr/lib/postgresql/*/bin/{program}"))[-1]


def tell(sql):
    subprocess.run([postgres("psql"), os.environ["RACEWAY_TEST_POSTGRES"], "-q", "-o", "/dev/null", "-c", sql], check=True)


def check_lines(log):
    """Each line is an object, and those of a request name it."""
    lines = [json.loads(line) for line in log.splitlines()]
    mine = [line["message"] for line in lines if line.get("span", {}).get("id") == REQUEST]
    check({"accepted", "answered"} <= set(mine), f"lines of a request name it: {mine}")
    check(not any("spans" in line for line in lines), "and once")
    said = {line["message"]: line for line in lines if line["level"] == "INFO"}
    check({"version", "address", "database", "workers"} <= set(said["serving"]), "the start is told")
    check("stopping; running jobs go back into the queue" in said and "stopped" in said, "and the stop")
    ended = said.get("a run has succeeded", {})
    check({"job", "seconds", "rung"} <= set(ended), f"and the end of a run: {ended}")


def check_secrets(name, log, answers, rows):
    check_lines(log)
    print(f"{name}: {len(log)} bytes of log, {len(answers)} of answers, {len(rows)} of records")
    check("TRACE" in log or "DEBUG" in log, f"{name}: much is logged")
    for secret in (TOKEN, OTHER, WRONG, PASSWORD):
        kind = secret.split("-")[0]
        for where, text in (("log", log), ("answer or argument", answers), ("record", rows)):
            check(secret not in text, f"{name}: {kind} is in no {where}")


with tempfile.TemporaryDirectory(prefix="raceway-check-") as directory:
    server = os.environ.get("RACEWAY_TEST_POSTGRES")
    if server:
        log, answers = a_whole_run(directory, server.replace("raceway@", f"raceway:{PASSWORD}@"))
        dump = subprocess.run([postgres("pg_dump"), server], capture_output=True, text=True, check=True).stdout
        check("COPY public.jobs" in dump, "what is on record can be read")
        check_secrets("PostgreSQL", log, answers, dump)
    else:
        matrix()
        log, answers = a_whole_run(directory, f"sqlite://{directory}/raceway.db")
        with open(os.path.join(directory, "raceway.db"), encoding="latin-1") as file:
            check_secrets("SQLite", log, answers, file.read())
        again = [os.path.join(ROOT, ".ci", "with-postgres"), sys.executable, os.path.abspath(__file__)]
        sys.exit(subprocess.run(again).returncode)
