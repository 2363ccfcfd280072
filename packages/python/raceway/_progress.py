"""Progress of a wait: an updated line in a notebook or a terminal, nothing elsewhere."""

from __future__ import annotations

import sys
import time
from typing import Any, Optional

#: Time until the line appears, and between two updates [s]. Short runs show none.
FIRST_S, EVERY_S = 0.5, 0.1


class Progress:
    """A line of progress. `shown` forces or forbids it; None decides by where the program runs."""

    def __init__(self, shown: Optional[bool]) -> None:
        self._notebook = _is_notebook()
        self._shown = (self._notebook or sys.stderr.isatty()) if shown is None else shown
        self._begin = time.monotonic()
        self._next = self._begin + FIRST_S
        self._handle: Any = None
        self._width = 0

    def update(self, share: float, what: str) -> None:
        """Shows share (0 to 1) and state, unless the last update was a moment ago."""
        now = time.monotonic()
        if not self._shown or now < self._next:
            return
        self._next = now + EVERY_S
        filled = int(20 * share)
        self._write(f"raceway [{'#' * filled}{'.' * (20 - filled)}] {share:4.0%} {what}, {now - self._begin:.0f} s")

    def close(self) -> None:
        """Removes the line."""
        if self._width == 0:
            return
        if self._handle is not None:
            self._handle.update(_plain(""), raw=True)
        else:
            sys.stderr.write("\r" + " " * self._width + "\r")
            sys.stderr.flush()

    def _write(self, line: str) -> None:
        if self._notebook:
            if self._handle is None:
                from IPython.display import display  # type: ignore[import-not-found, unused-ignore]

                self._handle = display(_plain(line), raw=True, display_id=True)
            else:
                self._handle.update(_plain(line), raw=True)
        else:
            sys.stderr.write("\r" + line.ljust(self._width))
            sys.stderr.flush()
        self._width = max(self._width, len(line))


def _plain(line: str) -> "dict[str, str]":
    return {"text/plain": line}


def _is_notebook() -> bool:
    """Whether this process is the kernel of a notebook."""
    ipython = sys.modules.get("IPython")
    shell = ipython.get_ipython() if ipython is not None else None
    return shell is not None and hasattr(shell, "kernel")
