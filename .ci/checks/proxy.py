#!/usr/bin/env python3
"""The proxy configuration of OPERATIONS.md in nginx: TLS, tokens, events without delay, half-open connections."""

import contextlib
import json
import os
import re
import secrets
import shutil
import socket
import ssl
import subprocess
import sys
import tempfile
import time
import urllib.request

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), os.pardir))
from service import ARTICLE, ROOT, check, clean_environment, free_port, service  # noqa: E402

TOKEN = secrets.token_hex(16)
HALF_OPEN = 1120
# It runs for several seconds and is cancelled.
LONG = ARTICLE | {"duration_s": 100, "settle_s": 10, "solver": {"rung": "full"}}


def configuration(place, upstream, port):
    """The block of OPERATIONS.md with the ports and the certificate of this check."""
    with open(os.path.join(ROOT, "OPERATIONS.md"), encoding="utf-8") as file:
        block = re.search(r"```nginx\n(.*?)```", file.read(), re.DOTALL).group(1)
    changes = {
        "127.0.0.1:8080": upstream,
        "listen 443 ssl": f"listen 127.0.0.1:{port} ssl",
        "/etc/ssl/raceway.crt": f"{place}/raceway.crt",
        "/etc/ssl/raceway.key": f"{place}/raceway.key",
    }
    for written, used in changes.items():
        check(block.count(written) == 1, f"OPERATIONS.md has {written} once")
        block = block.replace(written, used)
    paths = "".join(f"{name}_temp_path {place}/{name};\n" for name in ("client_body", "proxy", "fastcgi", "uwsgi", "scgi"))
    return f"""
daemon off; pid {place}/nginx.pid; error_log {place}/error.log; worker_rlimit_nofile 4096;
events {{ worker_connections 2048; }}
http {{ access_log off; {paths} {block} }}
"""


@contextlib.contextmanager
def proxy(running):
    """nginx before a service; the URL of the proxy and a TLS context that trusts it."""
    place = tempfile.mkdtemp(prefix="raceway-proxy-")
    port = free_port()
    subprocess.run(
        ["openssl", "req", "-x509", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:prime256v1", "-nodes", "-days", "2",
         "-subj", "/CN=localhost", "-addext", "subjectAltName=IP:127.0.0.1", "-keyout", f"{place}/raceway.key",
         "-out", f"{place}/raceway.crt"], check=True, capture_output=True)
    with open(f"{place}/nginx.conf", "w", encoding="utf-8") as file:
        file.write(configuration(place, running.url.removeprefix("http://"), port))
    # Debian's workers otherwise become another user, who may not enter the folder.
    os.chmod(place, 0o755)
    program = shutil.which("nginx") or "/usr/sbin/nginx"
    nginx = subprocess.Popen([program, "-e", f"{place}/error.log", "-c", f"{place}/nginx.conf"], stdin=subprocess.DEVNULL)
    try:
        deadline = time.monotonic() + 10
        while socket.socket().connect_ex(("127.0.0.1", port)):
            if nginx.poll() is not None or time.monotonic() > deadline:
                with open(f"{place}/error.log", encoding="utf-8") as log:
                    sys.exit(f"FAILED: nginx does not start: {log.read()}")
            time.sleep(0.05)
        yield port, ssl.create_default_context(cafile=f"{place}/raceway.crt")
    finally:
        nginx.terminate()
        nginx.wait(timeout=20)
        shutil.rmtree(place)


def ask(to, method, path, body=None, **headers):
    port, trust = to
    request = urllib.request.Request(f"https://127.0.0.1:{port}{path}", method=method, headers={"Authorization": f"Bearer {TOKEN}"} | headers)
    if body is not None:
        request.data = json.dumps(body).encode()
        request.add_header("Content-Type", "application/json")
    return urllib.request.urlopen(request, timeout=90, context=trust)


def case_events_arrive_at_once(to):
    job = json.load(ask(to, "POST", "/v1/jobs", LONG))
    path = job["links"]["self"]
    begin, arrivals = time.monotonic(), []
    with ask(to, "GET", f"{path}/events") as events:
        for line in events:
            if line.startswith(b"event:"):
                arrivals.append(time.monotonic() - begin)
            if len(arrivals) == 4:
                break
        status = json.load(ask(to, "GET", path))["status"]
    ask(to, "POST", f"{path}/cancel", {}).close()
    # The service looks at the run ten times a second. Events from a buffer arrive together.
    told = ", ".join(f"{at:.2f} s" for at in arrivals)
    check(status == "running" and arrivals[-1] - arrivals[0] > 0.1, f"events of a {status} job arrive one by one: after {told}")


def case_waiting_requests_pass(to):
    with ask(to, "POST", "/v1/jobs", ARTICLE | {"duration_s": 0.01, "settle_s": 0}, Prefer="wait=60") as answer:
        job = json.load(answer)
    check(job["status"] == "succeeded", f"`Prefer: wait` passes the proxy: {job['status']}")


def case_half_open_connections_do_not_reach_the_service(to):
    streams = []
    for _ in range(HALF_OPEN):
        streams.append(socket.create_connection(("127.0.0.1", to[0]), timeout=10))
    for stream in streams:
        stream.sendall(b"\x16\x03")
    statuses = [ask(to, "GET", "/v1/jobs").status for _ in range(50)]
    for stream in streams:
        stream.close()
    check(set(statuses) == {200}, f"beside {HALF_OPEN} half-open connections requests with a token are served")


with service("--workers", "1", environment=clean_environment(RACEWAY_API_TOKENS=TOKEN)) as running, proxy(running) as to:
    case_events_arrive_at_once(to)
    case_waiting_requests_pass(to)
    case_half_open_connections_do_not_reach_the_service(to)
