"""The binary of this package, as a private service of this process."""

from __future__ import annotations

import atexit
import os
import pathlib
import queue
import secrets
import shutil
import signal
import subprocess
import tempfile
import threading
from typing import Optional

from ._client import Client
from ._errors import RacewayError, Unreachable

#: Longest start of the service [s].
START_S = 60
# Stops the service when its standard input ends: this process then has closed it or has died, in whatever way.
_SUPERVISOR = (
    'folder=$1; shift; "$@" & service=$!; exec >&-; read -r _; kill "$service" 2>/dev/null; wait "$service"; rm -rf "$folder"'
)


def binary() -> pathlib.Path:
    """Path of the binary."""
    name = "raceway.exe" if os.name == "nt" else "raceway"
    path = pathlib.Path(__file__).parent / "bin" / name
    if not path.exists():
        raise RacewayError(f"{path} does not exist: this package was installed without its binary")
    return path


class _Private:
    """A service on loopback with its own database and a random token, until `close` or the end of this process."""

    def __init__(self) -> None:
        self.owner = os.getpid()
        folder = tempfile.mkdtemp(prefix="raceway-")
        self._folder = folder
        database = pathlib.Path(folder, "raceway.db").as_posix()
        token = secrets.token_hex(32)
        # Settings of a service in the environment are meant for another one.
        environment = {name: value for name, value in os.environ.items() if not name.startswith("RACEWAY_")}
        environment["RACEWAY_API_TOKENS"] = token
        command = [str(binary()), "serve", "--listen", "127.0.0.1:0", "--database", f"sqlite://{database}"]
        if os.name == "posix":
            command = ["/bin/sh", "-c", _SUPERVISOR, "raceway", folder, *command]
        log = pathlib.Path(folder, "log")
        with open(log, "wb") as file:
            # In a session of its own, so that Ctrl-C does not stop it.
            self._process = subprocess.Popen(
                command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=file, env=environment, start_new_session=True
            )
        try:
            line = self._first_line()
            if not line.startswith("listening on "):
                said = log.read_text(encoding="utf-8", errors="replace").strip()
                raise RacewayError(f"the private service did not start: {said or 'it said nothing'}")
            self.client = Client(line[len("listening on ") :], token)
        except BaseException:
            self.close()
            raise

    def _first_line(self) -> str:
        lines: "queue.Queue[bytes]" = queue.Queue()
        stdout = self._process.stdout
        assert stdout is not None
        threading.Thread(target=lambda: lines.put(stdout.readline()), daemon=True).start()
        try:
            return lines.get(timeout=START_S).decode(errors="replace").strip()
        except queue.Empty:
            return ""

    def is_alive(self) -> bool:
        try:
            self.client.transport.request("GET", "/health/live")
        except Unreachable:
            return False
        return True

    def close(self) -> None:
        """Stops the service and removes its database. In a fork of its process nothing happens."""
        if self.owner != os.getpid() or self._process.stdin is None or self._process.stdin.closed:
            return
        self._process.stdin.close()
        if os.name != "posix":
            self._process.terminate()
        try:
            self._process.wait(timeout=20)
        except subprocess.TimeoutExpired:
            if os.name == "posix":
                os.killpg(self._process.pid, signal.SIGKILL)
            else:
                self._process.kill()
            self._process.wait()
        if self._process.stdout is not None:
            self._process.stdout.close()
        shutil.rmtree(self._folder, ignore_errors=True)


_lock = threading.Lock()
_private: Optional[_Private] = None


def local_client() -> Client:
    """Client of the private service of this process, which the first call starts."""
    global _private
    with _lock:
        # A fork has its own service, because that of its parent ends with the parent.
        if _private is None or _private.owner != os.getpid() or not _private.is_alive():
            if _private is not None:
                _private.close()
            _private = _Private()
            atexit.register(_private.close)
        return _private.client
