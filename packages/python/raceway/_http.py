"""Requests to a service, with the standard library only."""

from __future__ import annotations

import http.client
import ipaddress
import json
import time
import urllib.error
import urllib.parse
import urllib.request
from typing import Any, Mapping, NamedTuple, Optional, Tuple

from ._errors import Problem, Unreachable

#: Status codes of "later", with `Retry-After`.
LATER = (429, 503)


class Answer(NamedTuple):
    """Status, header fields and body of an answer."""

    status: int
    headers: Mapping[str, str]
    body: bytes

    def json(self) -> Any:
        """The body as JSON."""
        return json.loads(self.body)


class _NoRedirect(urllib.request.HTTPRedirectHandler):
    """No redirection is followed: it would carry the token to another host."""

    def redirect_request(self, *_: Any) -> None:
        return None


def _is_loopback(host: str) -> bool:
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return host == "localhost"


class Transport:
    """Requests to one service."""

    def __init__(self, url: str, token: Optional[str], timeout_s: float, patience_s: float) -> None:
        parts = urllib.parse.urlsplit(url)
        if parts.scheme not in ("http", "https") or not parts.hostname:
            raise ValueError(f"url {url!r}: must begin with http:// or https:// and name a host")
        self.url = url.rstrip("/")
        self._token, self._timeout_s, self._patience_s = token, timeout_s, patience_s
        handlers: Tuple[urllib.request.BaseHandler, ...] = (_NoRedirect(),)
        if _is_loopback(parts.hostname):
            # A proxy of the environment does not reach this machine's loopback.
            handlers += (urllib.request.ProxyHandler({}),)
        self._opener = urllib.request.build_opener(*handlers)

    def request(
        self,
        method: str,
        path: str,
        body: Any = None,
        *,
        query: Optional[Mapping[str, Any]] = None,
        headers: Optional[Mapping[str, str]] = None,
        survives_breaks: bool = False,
    ) -> Answer:
        """The answer to a request. Waits and repeats for up to `patience_s` where the service asks for it, and, if
        `survives_breaks`, where it does not answer. Raises `Problem` or `Unreachable`."""
        fields = {"Accept": "application/json", **(headers or {})}
        if self._token is not None:
            fields["Authorization"] = f"Bearer {self._token}"
        data = None
        if body is not None:
            data = body if isinstance(body, bytes) else json.dumps(body, allow_nan=False, default=_plain).encode()
            fields.setdefault("Content-Type", "application/json")
        given = [(name, value) for name, value in (query or {}).items() if value is not None]
        if given:
            path += ("&" if "?" in path else "?") + urllib.parse.urlencode(given, doseq=True)
        deadline = time.monotonic() + self._patience_s
        pause_s = 0.25
        while True:
            request = urllib.request.Request(self.url + path, data=data, headers=fields, method=method)
            try:
                with self._opener.open(request, timeout=self._timeout_s) as answer:
                    return Answer(answer.status, answer.headers, answer.read())
            except urllib.error.HTTPError as error:
                with error:
                    content, kind = error.read(), error.headers.get_content_type()
                    wait_s = _seconds(error.headers.get("Retry-After"))
                if error.code in LATER and time.monotonic() + wait_s < deadline:
                    time.sleep(wait_s)
                    continue
                raise _problem(error, kind, content) from None
            except (OSError, http.client.HTTPException) as error:
                if survives_breaks and time.monotonic() + pause_s < deadline:
                    time.sleep(pause_s)
                    pause_s = min(2 * pause_s, 5)
                    continue
                reason = getattr(error, "reason", None) or error
                raise Unreachable(f"{self.url} does not answer: {reason}") from error


def _plain(value: Any) -> Any:
    """Numbers and arrays of NumPy as those of Python."""
    if hasattr(value, "tolist"):
        return value.tolist()
    raise TypeError(f"{type(value).__name__} has no form in JSON")


def _seconds(retry_after: Optional[str]) -> float:
    """Pause [s] that the header `Retry-After` asks for."""
    try:
        return max(0.0, float(retry_after or 1))
    except ValueError:
        return 1.0


def _problem(error: urllib.error.HTTPError, kind: str, content: bytes) -> Problem:
    """The problem of an error response; one without problem document has the status line."""
    if kind == "application/problem+json":
        try:
            return Problem(error.code, json.loads(content))
        except ValueError:
            pass
    return Problem(error.code, {"title": f"{error.code} {error.reason}"})
