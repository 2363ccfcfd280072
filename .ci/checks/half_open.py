#!/usr/bin/env python3
"""Connections without an authorised request take no place from clients with a token: half headers, wrong tokens, silence."""

import os
import resource
import secrets
import socket
import statistics
import sys
import threading
import time

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), os.pardir))
from service import check, clean_environment, service  # noqa: E402

# More than the 1024 places and the 64 of the overflow.
CROWD = 1120
TOKEN = secrets.token_hex(16)
HALF = b"GET /v1/jobs HTTP/1.1\r\nHost: localhost\r\nX: "
WRONG = b"GET /v1/jobs HTTP/1.1\r\nHost: localhost\r\nAuthorization: Bearer wrong\r\n\r\n"
RIGHT = WRONG.replace(b"wrong", TOKEN.encode())
resource.setrlimit(resource.RLIMIT_NOFILE, (min(4096, resource.getrlimit(resource.RLIMIT_NOFILE)[1]),) * 2)


def connect(running, data=b"", source="127.0.0.1"):
    host, port = running.url.removeprefix("http://").split(":")
    stream = socket.create_connection((host, int(port)), timeout=10, source_address=(source, 0))
    stream.sendall(data)
    return stream


def crowd(running, data, source="127.0.0.1", count=CROWD):
    """Connections that all send `data` and stay open."""
    return [connect(running, data, source) for _ in range(count)]


def close(streams):
    for stream in streams:
        stream.close()


def status(stream):
    """The status of the next answer, or what happened in its place."""
    try:
        return stream.recv(65536)[9:12].decode() or "closed"
    except OSError as error:
        return type(error).__name__


def served(running, what, times=100):
    """Requests with the token, each over a new connection."""
    statuses, took = [], []
    for _ in range(times):
        begin = time.perf_counter()
        with connect(running, RIGHT) as stream:
            statuses.append(status(stream))
        took.append(1e3 * (time.perf_counter() - begin))
    took.sort()
    print(f"{what}: {statistics.median(took):.1f} ms in the median, {took[int(0.99 * (times - 1))]:.1f} ms at the 99th percentile")
    refused = sorted({status for status in statuses if status != "200"})
    check(not refused, f"{what}: {statuses.count('200')} of {times} requests with a token are served {refused}")


def case_half_headers(running):
    streams = crowd(running, HALF)
    time.sleep(0.5)
    served(running, f"{CROWD} half headers")
    close(streams)


def case_wrong_tokens(running):
    streams = crowd(running, WRONG)
    time.sleep(0.5)
    served(running, f"{CROWD} connections with a wrong token")
    close(streams)


def case_silence(running):
    streams = crowd(running, b"")
    time.sleep(0.5)
    served(running, f"{CROWD} silent connections")
    close(streams)


def case_authorised_connections_stay(running):
    kept = crowd(running, RIGHT, count=100)
    before = [status(stream) for stream in kept]
    streams = crowd(running, HALF)
    time.sleep(0.5)
    for stream in kept:
        stream.sendall(RIGHT)
    after = [status(stream) for stream in kept]
    close(kept + streams)
    check(set(before + after) == {"200"}, f"connections with an authorised request stay: {sorted(set(before + after))}")


def case_one_address_does_not_displace_others(running):
    slow = connect(running, RIGHT[:20])
    streams = crowd(running, HALF, source="127.0.0.2")
    time.sleep(0.5)
    streams += crowd(running, HALF, source="127.0.0.2", count=200)
    slow.sendall(RIGHT[20:])
    answer = status(slow)
    close([slow, *streams])
    check(answer == "200", f"a slow client keeps its place beside {CROWD + 200} connections of another address: {answer}")


def case_reconnecting(running):
    stop, opened = threading.Event(), []

    def reconnect():
        while not stop.wait(0.001):
            opened.append(connect(running, HALF, source="127.0.0.2"))

    streams = crowd(running, HALF, source="127.0.0.2")
    time.sleep(0.5)
    thread = threading.Thread(target=reconnect)
    thread.start()
    served(running, "beside new half headers at up to 1000/s", times=1000)
    stop.set()
    thread.join()
    close(streams + opened)


CASES = (
    case_half_headers, case_wrong_tokens, case_silence, case_authorised_connections_stay,
    case_one_address_does_not_displace_others, case_reconnecting,
)
failed = []
for case in CASES:
    with service("--workers", "1", environment=clean_environment(RACEWAY_API_TOKENS=TOKEN)) as running:
        try:
            case(running)
        except SystemExit as error:
            print(error)
            failed.append(case.__name__)
if failed:
    sys.exit(f"FAILED: {', '.join(failed)}")
