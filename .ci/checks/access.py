#!/usr/bin/env python3
"""Access to the service: none from outside without tokens, none with a wrong token, none from a foreign page. Secrets appear in no
log, response, metric, argument or database row at any log level."""

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
    """An address of this machine that others reach; None without a network."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        try:
            # Nothing is sent. The call only selects the route.
            probe.connect(("192.0.2.1", 9))
            return [f"{probe.getsockname()[0]}:0"]
        except OSError:
            return []


def start(listen, tokens, insecure):
    """Result of a start: whether the service starts, and its response to an unknown client."""
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
    """Every use of secrets by a service with the most verbose log; returns its log and its responses."""
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
        check(ask("GET", "/v1/jobs", Authorization=f"Basic {TOKEN}")[0] == 401, "a right token in another scheme is refused")
        for query in (f"token={TOKEN}", f"access_token={TOKEN}", f"limit={TOKEN}"):
            check(ask("GET", f"/v1/jobs?{query}")[0] == 401, "a token in the query gives no access")
            check(ask("GET", f"/v1/jobs?{query}", Authorization=f"Bearer {TOKEN}")[0] == 400, "a token in the query is a bad request")
        mine = {"Authorization": f"Bearer {TOKEN}"}
        status, fields = ask("POST", "/v1/jobs", ARTICLE | {"duration_s": 0.02}, Prefer="wait=60", **mine,
                             **{"Idempotency-Key": "a-key", "X-Request-Id": REQUEST})
        check(status == 200 and fields["X-Request-Id"] == REQUEST, "a job runs, and its request keeps its identifier")
        path = fields["Location"]
        for rest in ("", "/metrics", "/events", "/spectrum?channel=spindle.y.acceleration", "/plots/spectrum.svg"):
            check(ask("GET", path + rest, **mine)[0] == 200, f"…{rest or '/'} is there")
        check(ask("GET", path, Authorization=f"Bearer {OTHER}")[0] == 404, "a job exists for its owner only")
        check(ask("GET", "/metrics", **mine)[0] == 200 and ask("POST", "/v1/jobs", {"kind": 7}, **mine)[0] == 422, "metrics and error responses are available")
        with open(f"/proc/{running.process.pid}/cmdline", encoding="utf-8") as file:
            answers.append(file.read())
        if database.startswith("postgres"):
            worker = subprocess.Popen([binary(), "worker"], env=environment, stdin=subprocess.DEVNULL, text=True,
                                      stdout=subprocess.PIPE, stderr=running.log)
            answers.append(worker.stdout.readline())
            worker.terminate()
            worker.wait()
            # Broken database sessions appear in the log.
            tell("SELECT pg_terminate_backend(pid) FROM pg_stat_activity WHERE application_name = 'raceway'")
            time.sleep(3)
            check(ask("GET", path, **mine)[0] == 200, "a broken database session is replaced")
        second = subprocess.run(command, env=environment | {"RACEWAY_DATABASE": f"postgres://raceway:{PASSWORD}@127.0.0.1:1/r"},
                                capture_output=True, text=True, timeout=30)
        check(second.returncode == 1 and "127.0.0.1:1" in second.stderr, "the error names the unreachable server")
        answers.append(second.stdout + second.stderr)
    finally:
        running.stop()
    return running.stderr(), "\n".join(answers)


def postgres(program):
    return sorted(glob.glob(f"/usr/lib/postgresql/*/bin/{program}"))[-1]


def tell(sql):
    subprocess.run([postgres("psql"), os.environ["RACEWAY_TEST_POSTGRES"], "-q", "-o", "/dev/null", "-c", sql], check=True)


def check_lines(log):
    """Each line is an object, and each line of a request contains its identifier."""
    lines = [json.loads(line) for line in log.splitlines()]
    mine = [line["message"] for line in lines if line.get("span", {}).get("id") == REQUEST]
    check({"accepted", "answered"} <= set(mine), f"log lines of a request contain its identifier: {mine}")
    check(not any("spans" in line for line in lines), "they contain it once")
    said = {line["message"]: line for line in lines if line["level"] == "INFO"}
    check({"version", "address", "database", "workers"} <= set(said["serving"]), "the log contains the start")
    check("stopping; running jobs go back into the queue" in said and "stopped" in said, "the log contains the stop")
    ended = said.get("a run has succeeded", {})
    check({"job", "seconds", "rung"} <= set(ended), f"the log contains the end of a run: {ended}")


def check_secrets(name, log, answers, rows):
    check_lines(log)
    print(f"{name}: {len(log)} bytes of log, {len(answers)} of answers, {len(rows)} of records")
    check("TRACE" in log or "DEBUG" in log, f"{name}: the log is verbose")
    for secret in (TOKEN, OTHER, WRONG, PASSWORD):
        kind = secret.split("-")[0]
        for where, text in (("log", log), ("answer or argument", answers), ("record", rows)):
            check(secret not in text, f"{name}: {kind} is in no {where}")


with tempfile.TemporaryDirectory(prefix="raceway-check-") as directory:
    server = os.environ.get("RACEWAY_TEST_POSTGRES")
    if server:
        log, answers = a_whole_run(directory, server.replace("raceway@", f"raceway:{PASSWORD}@"))
        dump = subprocess.run([postgres("pg_dump"), server], capture_output=True, text=True, check=True).stdout
        check("COPY public.jobs" in dump, "the database dump can be read")
        check_secrets("PostgreSQL", log, answers, dump)
    else:
        matrix()
        log, answers = a_whole_run(directory, f"sqlite://{directory}/raceway.db")
        with open(os.path.join(directory, "raceway.db"), encoding="latin-1") as file:
            check_secrets("SQLite", log, answers, file.read())
        again = [os.path.join(ROOT, ".ci", "with-postgres"), sys.executable, os.path.abspath(__file__)]
        sys.exit(subprocess.run(again).returncode)
