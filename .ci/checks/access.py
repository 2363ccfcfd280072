#!/usr/bin/env python3
"""Who may reach the service: nobody from outside without tokens, nobody with a wrong one, no foreign page."""

import os
import subprocess
import sys
import tempfile

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), os.pardir))
from service import Service, binary, check, clean_environment, service  # noqa: E402

for address in ("0.0.0.0:0", "[::]:0"):
    with tempfile.TemporaryDirectory() as directory:
        refused = subprocess.run([binary(), "serve", "--listen", address, "--database", f"sqlite://{directory}/r.db"],
                                 stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=20,
                                 env=clean_environment())
        check(refused.returncode != 0 and refused.stdout == "", f"serve refuses {address} without tokens")
        check("RACEWAY_API_TOKENS" in refused.stderr, "and says what to do")
        check(os.listdir(directory) == [], "and has not touched the database")

with service() as running:
    status = running.request("GET", "/v1/presets", headers={"Host": "evil.example"})[0]
    check(status == 421, "without tokens a foreign Host is refused with 421")
    status = running.request("GET", "/v1/presets", headers={"Host": "localhost"})[0]
    check(status == 200, "localhost is not foreign")

token = "a-token-for-this-check"
with tempfile.TemporaryDirectory() as directory:
    command = [binary(), "serve", "--listen", "0.0.0.0:0", "--database", f"sqlite://{directory}/raceway.db"]
    running = Service(directory, command=command, environment=clean_environment(RACEWAY_API_TOKENS=token))
    try:
        for path in ("/health/live", "/health/ready", "/openapi.json", "/docs/"):
            check(running.request("GET", path)[0] == 200, f"{path} is open")
        status, headers, _ = running.request("GET", "/v1/jobs")
        check(status == 401 and headers["WWW-Authenticate"] == "Bearer", "jobs need a token")
        running.token = token + "x"
        check(running.request("GET", "/v1/jobs")[0] == 401, "a wrong token is refused")
        running.token = token
        check(running.request("GET", "/v1/jobs")[0] == 200, "the right one is let in")
        check(token not in running.stderr(), "the log does not hold the token")
    finally:
        running.stop()
