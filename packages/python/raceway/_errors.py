"""Errors of this package."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, List, Mapping, Optional


class RacewayError(Exception):
    """Any error of this package."""


class Unreachable(RacewayError):
    """The service does not answer."""


@dataclass(frozen=True)
class FieldError:
    """One invalid field: JSON pointer from the root of the request, and the reason."""

    pointer: str
    detail: str


class Problem(RacewayError):
    """Error response of the service (RFC 9457). `errors` lists every invalid field."""

    def __init__(self, status: Optional[int], problem: Mapping[str, Any]) -> None:
        self.status = status
        #: Last part of the problem's `type`, such as `invalid-request`; programs branch on it.
        self.kind = str(problem.get("type", "")).rpartition(":")[2]
        self.title = str(problem.get("title", ""))
        self.detail = str(problem.get("detail", ""))
        self.errors: List[FieldError] = [FieldError(error["pointer"], error["detail"]) for error in problem.get("errors", [])]
        self.problem = dict(problem)
        head = f"{self.title}: {self.detail}" if self.detail else self.title
        fields = [f"{error.pointer}: {error.detail}" for error in self.errors]
        # The detail of a problem with one field is that field.
        super().__init__("\n  ".join([head, *(field for field in fields if field not in head)]))


class JobFailed(Problem):
    """A job that has no result: `status_name` is `failed`, `cancelled` or `refused`."""

    def __init__(self, status_name: str, job: Optional[Mapping[str, Any]], problem: Optional[Mapping[str, Any]]) -> None:
        super().__init__(None, problem or {"title": f"The job is {status_name}"})
        self.status_name = status_name
        #: The job as the service last described it; None if it was refused.
        self.job = None if job is None else dict(job)
