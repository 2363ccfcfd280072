#!/usr/bin/env python3
"""Slow, silent, greedy and broken clients. Meanwhile the service answers other clients, and afterwards it has released every
connection. Times are printed. Their limits are generous, because machines differ."""

import contextlib
import http.client
import json
import multiprocessing
import os
import random
import resource
import socket
import statistics
import struct
import sys
import tempfile
import time

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), os.pardir))
from service import ARTICLE, Service, check  # noqa: E402

FEW, MANY = 200, 10_000
# The limits in OPERATIONS.md.
FIRST_BYTE_S, HEADER_S, CONNECTIONS, FOLLOWERS = 10, 30, 1024, 256
# Limit of open sockets of this program. A child process inherits it.
resource.setrlimit(resource.RLIMIT_NOFILE, (min(4096, resource.getrlimit(resource.RLIMIT_NOFILE)[1]),) * 2)


def probe(address, paths, stop, told):
    """Sends requests until told to stop, each over its own connection. Returns all response times and each status other than 200."""
    took, others = [], []
    while not stop.is_set():
        for path in paths:
            begin = time.perf_counter()
            try:
                client = http.client.HTTPConnection(address, timeout=20)
                client.request("GET", path)
                status = client.getresponse().status
                client.close()
            except OSError as error:
                status = repr(error)
            took.append(time.perf_counter() - begin)
            if status != 200:
                others.append(f"{path}: {status}")
        time.sleep(0.005)
    told.put((took, others))


@contextlib.contextmanager
def watched(service, name, *paths):
    """Measurements of a well-behaved client, in a process of its own, so that they are those of the service and not of this program."""
    stop, told = multiprocessing.Event(), multiprocessing.Queue()
    watch = multiprocessing.Process(target=probe, args=(service.url.split("//")[1], paths, stop, told), daemon=True)
    watch.start()
    yield
    stop.set()
    took, others = told.get(timeout=30)
    watch.join()
    took.sort()
    median, high = statistics.median(took), took[int(0.99 * (len(took) - 1))]
    print(f"{name}: {len(took)} answers meanwhile, {1e3 * median:.1f} ms in the median, {1e3 * high:.1f} ms at the 99th "
          f"percentile, {1e3 * took[-1]:.0f} ms at most")
    check(not others, f"{name}: each is 200 {others[:3]}")
    check(median < 0.05 and took[-1] < 5, f"{name}: they arrive soon")


def connect(service, data=b"", **options):
    stream = socket.create_connection(service.url.split("//")[1].split(":"), timeout=20)
    for option, value in options.items():
        stream.setsockopt(socket.SOL_SOCKET, getattr(socket, option), value)
    stream.sendall(data)
    return stream


def header(line, *more):
    return "\r\n".join([line, "Host: localhost", *more, "", ""]).encode()


def post(length):
    return header("POST /v1/jobs HTTP/1.1", "Content-Type: application/json", length)


def answer(stream):
    """The bytes until the other end closes the connection or pauses."""
    text = b""
    try:
        while piece := stream.recv(65536):
            text += piece
            if b"\r\n\r\n" in text:
                break
    except ConnectionResetError:
        pass
    return text.decode(errors="replace")


def is_closed(stream):
    """Whether the other end has closed the connection."""
    stream.setblocking(False)
    try:
        while stream.recv(1 << 20):
            pass
        return True
    except BlockingIOError:
        return False
    except ConnectionError:
        return True


def until(holds, at_most):
    deadline = time.monotonic() + at_most
    while not holds() and time.monotonic() < deadline:
        time.sleep(0.2)
    return holds()


def memory(service):
    """Current and largest memory [MB]."""
    with open(f"/proc/{service.process.pid}/status", encoding="utf-8") as file:
        fields = dict(line.split(":", 1) for line in file)
    return [int(fields[name].split()[0]) / 1024 for name in ("VmRSS", "VmHWM")]


def sockets(service):
    """Number of open sockets. Other files do not count, because the database opens and closes connections on demand."""
    directory = f"/proc/{service.process.pid}/fd"
    count = 0
    for name in os.listdir(directory):
        with contextlib.suppress(FileNotFoundError):
            count += os.readlink(f"{directory}/{name}").startswith("socket:")
    return count


def big_bodies(service):
    statuses = set()
    for number in range(FEW):
        body = b" " * (2 << 20)
        stream = connect(service, post(f"Content-Length: {len(body)}") if number % 2 else post("Transfer-Encoding: chunked"))
        with contextlib.suppress(ConnectionError):
            stream.sendall(body if number % 2 else b"%x\r\n%s\r\n0\r\n\r\n" % (len(body), body))
        # A client that still sends may find the connection closed before it reads the response.
        statuses.add(answer(stream)[9:12])
        stream.close()
    check(statuses <= {"413", ""} and "413" in statuses, f"bodies of 2 MB are refused: {statuses}")


def deep_bodies(service):
    for opening in ('{"a":', "[", '{"scene":{"bearing":{"inner_groove_curvature":['):
        body = opening.encode() * (100_000 if len(opening) < 9 else 20_000)
        stream = connect(service, post(f"Content-Length: {len(body)}") + body)
        check(answer(stream)[9:12] in ("400", "422"), f"{len(body)} bytes of {opening} are refused")
        stream.close()


def aborted(service, job):
    body = json.dumps(ARTICLE | {"duration_s": 1e9}).encode()
    starts = [header(f"GET {job} HTTP/1.1"), post(f"Content-Length: {len(body)}") + body[:40],
              post(f"Content-Length: {len(body)}") + body, header("GET /v1/jobs HTTP/1.1")[:30]]
    for number in range(MANY):
        # Closed at once with a reset.
        connect(service, starts[number % 4], SO_LINGER=struct.pack("ii", 1, 0)).close()


def rubbish(service):
    rng = random.Random(7)
    for _ in range(FEW):
        stream = connect(service, header("GET /health/live HTTP/1.1") * 20)
        with contextlib.suppress(ConnectionError):
            stream.sendall(rng.randbytes(4096) + b"\r\n\r\n")
        if not until(lambda: is_closed(stream), 20):
            sys.exit("FAILED: a connection with rubbish is kept")
        stream.close()
    stream = connect(service, header("GET /v1/jobs HTTP/1.1", "X: " + "x" * 200_000))
    check(answer(stream)[9:12] == "431", "a header of 200 kB is refused")


def streams(service, job):
    """More event streams than the service serves at once."""
    opened = [connect(service, header(f"GET {job}/events HTTP/1.1")) for _ in range(FOLLOWERS + 44)]
    answers = [answer(stream) for stream in opened]
    served = [text for text in answers if text.startswith("HTTP/1.1 200")]
    others = [text for text in answers if not text.startswith("HTTP/1.1 200")]
    check(len(served) == FOLLOWERS, f"{len(served)} of {len(opened)} event streams are served")
    check(all(text.startswith("HTTP/1.1 503") and "retry-after: 1" in text and "problem:overloaded" in text for text in others),
          "others are told to come back")
    status, headers, _ = service.request("POST", "/v1/jobs", ARTICLE | {"duration_s": 900}, {"Prefer": "wait=30"})
    check(status == 202 and "Preference-Applied" not in headers, "a request with `Prefer: wait` is answered without waiting")
    service.request("POST", f"{headers['Location']}/cancel")
    return opened


with tempfile.TemporaryDirectory(prefix="raceway-check-") as directory:
    service = Service(directory, "--workers", "1")
    try:
        job, _ = service.submit(ARTICLE | {"duration_s": 1000, "settle_s": 100, "solver": {"rung": "full"}})
        service.until(job, lambda job: job["status"] == "running")
        sockets_before, (before, _) = sockets(service), memory(service)
        begin = time.monotonic()
        with watched(service, "half a header, silence, slow bodies, unread answers", "/health/live", job):
            silent = [connect(service) for _ in range(FEW)]
            half = [connect(service, header("GET /v1/jobs HTTP/1.1")[:30]) for _ in range(FEW)]
            slow = [connect(service, post("Content-Length: 500")) for _ in range(FEW)]
            # Small windows, so that responses wait in the service and not in the kernel.
            unread = [connect(service, header("GET /openapi.json HTTP/1.1") * 50, SO_RCVBUF=4096) for _ in range(FEW)]
            for _ in range(8):
                for stream in slow:
                    stream.sendall(b" ")
                time.sleep(1)
        with watched(service, f"bodies of 2 MB, nested, {MANY} aborted requests, rubbish", "/health/live", job):
            big_bodies(service)
            deep_bodies(service)
            aborted(service, job)
            rubbish(service)
        check(all(map(is_closed, silent)) or until(lambda: all(map(is_closed, silent)), begin + FIRST_BYTE_S + 5 - time.monotonic()),
              f"who says nothing is cut off after {FIRST_BYTE_S} s")
        with watched(service, f"{FOLLOWERS} event streams", "/health/live", job):
            follow = streams(service, job)
            time.sleep(2)
        for stream in follow:
            stream.close()

        # Half a header, a slow body, responses that are not read: each has its timeout.
        left = begin + HEADER_S + 20
        for name, those in (("half a header", half), ("a body that trickles", slow)):
            check(until(lambda: all(map(is_closed, those)), left - time.monotonic()), f"{name} is closed after {HEADER_S} s")
        # This program does not test these sockets, because a test would read. The kernel accepts more data for some of them, which
            # restarts their timeout.
        check(until(lambda: sockets(service) <= sockets_before + 4, 2 * HEADER_S),
              f"an answer is unread for {HEADER_S} s at most: {sockets(service)} sockets are open, as before ({sockets_before})")
        for stream in unread:
            stream.close()

        # Connections without a request would give way.
        crowd = []
        for _ in range(CONNECTIONS):
            crowd.append(connect(service, header(f"GET {job} HTTP/1.1")))
            if answer(crowd[-1])[9:12] != "200":
                sys.exit(f"FAILED: client {len(crowd)} of {CONNECTIONS} is not served")
        with watched(service, f"all {CONNECTIONS} connections taken", "/health/live"):
            status, headers, problem = service.request("GET", job)
            check(status == 503 and headers["Retry-After"] == "1" and problem["type"].endswith(":overloaded"),
                  "others are told to come back")
            time.sleep(2)
        for stream in crowd:
            stream.close()

        check(until(lambda: sockets(service) <= sockets_before + 4, 10), f"{sockets(service)} sockets are open, as before ({sockets_before})")
        after, most = memory(service)
        print(f"memory: {before:.0f} MB before, {most:.0f} MB at most, {after:.0f} MB after")
        check(most < 256, "memory stays within the limit of OPERATIONS.md")
        service.request("POST", f"{job}/cancel")
        service.ended(job)
        path, _ = service.submit(ARTICLE | {"duration_s": 0.02})
        check(service.ended(path)["status"] == "succeeded", "and the service still works")
        check("panic" not in service.stderr(), "nothing has panicked")
    finally:
        service.stop()
