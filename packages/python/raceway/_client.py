"""A client of the HTTP API."""

from __future__ import annotations

import time
import uuid
from typing import TYPE_CHECKING, Any, Dict, Iterable, Iterator, List, Mapping, Optional, Sequence, Union, cast

from ._errors import JobFailed, Problem
from ._http import Transport
from ._progress import Progress
from ._result import Result, Results
from ._table import Table

if TYPE_CHECKING:
    from .schema import AxisInput, JobAnswer, JobInput, PresetsAnswer, ResolveAnswer, RotorSceneInput, SceneInput, UploadedSeriesAnswer

    #: What is simulated: a bearing, or a shaft on bearings.
    Scene = Union[SceneInput, RotorSceneInput]
    #: A job with its kind; `raceway.schema` has the types of all fields.
    JobRequest = JobInput

#: Pause between two looks at a job [s]: it grows from the first to the second.
FIRST_PAUSE_S, LONGEST_PAUSE_S = 0.02, 0.5
#: Jobs of one request of `run_many`; the service accepts up to 1000.
BATCH = 100


class Job:
    """A job as the service described it when it was asked last. `data` is that answer."""

    def __init__(self, data: "JobAnswer") -> None:
        self.data = data
        self.id = str(data["id"])
        self.kind = str(data["kind"])
        #: `queued`, `running`, `succeeded`, `failed` or `cancelled`.
        self.status = str(data["status"])
        #: Finished share, 0 to 1.
        self.progress = float(data["progress"])
        self.labels = list(data["labels"])

    @property
    def has_ended(self) -> bool:
        return self.status not in ("queued", "running")

    def __repr__(self) -> str:
        return f"Job({self.id}, {self.kind}, {self.status}, {self.progress:.0%})"


class Client:
    """A service at `url`.

    Requests that the service asks to repeat later are repeated for up to `patience_s`; so are requests of a wait that the service
    does not answer. `timeout_s` limits one request.
    """

    def __init__(
        self, url: str = "http://127.0.0.1:8080", token: Optional[str] = None, *, timeout_s: float = 60, patience_s: float = 120
    ) -> None:
        self.transport = Transport(url, token, timeout_s, patience_s)

    def run(
        self, scene: "Scene | JobRequest", *, progress: Optional[bool] = None, timeout_s: Optional[float] = None, **fields: Any
    ) -> Result:
        """Result of a scene, or of a whole job with `scene`. `fields` are further fields of the job, such as `duration_s`,
        `solver`, `outputs` or `kind`. An interruption (Ctrl-C, the stop button of a notebook) and `timeout_s` cancel the job.
        Raises `Problem` if the service refuses the job, and `JobFailed` if it fails."""
        return Result(self, self._run(_request(scene, fields), progress, timeout_s))

    def run_many(
        self, scenes: "Iterable[Scene | JobRequest]", *, progress: Optional[bool] = None, **fields: Any
    ) -> Results:
        """Results of many scenes or jobs, in their order; the service runs them side by side. A refused or failed one is among
        the results, with its `status` and `error`. An interruption cancels the unfinished ones."""
        requests = [_request(scene, fields) for scene in scenes]
        line = Progress(progress)
        jobs: Dict[int, Job] = {}
        try:
            refused = self._submit_all(requests, jobs, line)
            for place in sorted(jobs):
                ended = len(refused) + sum(job.has_ended for job in jobs.values())
                jobs[place] = self._ended(jobs[place], line, None, ended, len(requests))
        except KeyboardInterrupt:
            for job in jobs.values():
                if not job.has_ended:
                    self.cancel(job)
            raise
        finally:
            line.close()
        return Results(
            Result(self, jobs.get(place), request=request, problem=refused.get(place)) for place, request in enumerate(requests)
        )

    def study(
        self,
        scene: "Scene",
        axes: "Sequence[AxisInput]",
        *,
        progress: Optional[bool] = None,
        timeout_s: Optional[float] = None,
        **fields: Any,
    ) -> Table:
        """Table of a run for each point of a grid; `axes` are `{"path", "values"}` or ranges. Failed points are rows with their
        error."""
        request = _request(scene, {"kind": "study", "axes": list(axes), **fields})
        job = self._run(request, progress, timeout_s)
        return Table(job, self.transport.request("GET", _link(job, "table"), survives_breaks=True).json())

    def submit(self, scene: "Scene | JobRequest", **fields: Any) -> Job:
        """The accepted job of a scene or of a whole job. It runs without this program."""
        return self._submit(_request(scene, fields))

    def wait(self, job: "Job | str", *, progress: Optional[bool] = None, timeout_s: Optional[float] = None) -> Job:
        """The job once it has ended, in whatever way. Raises `TimeoutError` after `timeout_s`; the job goes on."""
        line = Progress(progress)
        try:
            return self._ended(self.job(job), line, timeout_s)
        finally:
            line.close()

    def result(self, job: "Job | str", *, progress: Optional[bool] = None) -> Result:
        """Result of a job, after its end. Raises `JobFailed` if it has none."""
        return Result(self, _succeeded(self.wait(job, progress=progress)))

    def job(self, job: "Job | str") -> Job:
        """The present state of a job, by its id."""
        name = job.id if isinstance(job, Job) else job
        return Job(self.transport.request("GET", f"/v1/jobs/{name}", survives_breaks=True).json())

    def jobs(
        self,
        *,
        status: "str | Sequence[str] | None" = None,
        kind: "str | Sequence[str] | None" = None,
        label: "str | Sequence[str] | None" = None,
        limit: Optional[int] = None,
    ) -> Iterator[Job]:
        """Jobs of the service, newest first, read page by page; `limit` is the length of a page."""
        query = {"status": status, "kind": kind, "label": label, "limit": limit}
        page = self.transport.request("GET", "/v1/jobs", query=query).json()
        while True:
            yield from map(Job, page["jobs"])
            if page["next"] is None:
                return
            page = self.transport.request("GET", page["next"]).json()

    def cancel(self, job: "Job | str") -> Job:
        """Cancels a job, which ends soon after."""
        name = job.id if isinstance(job, Job) else job
        return Job(self.transport.request("POST", f"/v1/jobs/{name}/cancel", survives_breaks=True).json())

    def resolve(self, scene: "Scene | JobRequest", **fields: Any) -> "ResolveAnswer":
        """The scene with every default, derived values, omitted terms and cost. Nothing runs."""
        answer = self.transport.request("POST", "/v1/scenes/resolve", _request(scene, fields), survives_breaks=True)
        return cast("ResolveAnswer", answer.json())

    def presets(self) -> "PresetsAnswer":
        """Names with their numbers: bearings, materials, lubricants, surfaces."""
        return cast("PresetsAnswer", self.transport.request("GET", "/v1/presets", survives_breaks=True).json())

    def catalogue(self, **query: Any) -> List[Dict[str, Any]]:
        """Bearings by designation; `query` takes `series`, `bore_mm`, `min_c_kn` and `q`."""
        return list(self.transport.request("GET", "/v1/catalogue", query=query, survives_breaks=True).json()["bearings"])

    def upload_series(self, values: Sequence[float], rate_hz: float) -> "UploadedSeriesAnswer":
        """Uploads the values of a load. A load names them by the `hash` of the answer."""
        body = {"rate_hz": rate_hz, "values": values}
        return cast("UploadedSeriesAnswer", self.transport.request("POST", "/v1/series", body, survives_breaks=True).json())

    def _submit(self, request: Dict[str, Any]) -> Job:
        # A repetition with the same key makes no second job.
        key = {"Idempotency-Key": uuid.uuid4().hex}
        return Job(self.transport.request("POST", "/v1/jobs", request, headers=key, survives_breaks=True).json())

    def _submit_all(self, requests: List[Dict[str, Any]], jobs: Dict[int, Job], line: Progress) -> Dict[int, Problem]:
        """Fills in the accepted jobs by their place; returns why others were refused. Waits where the queue is full."""
        refused: Dict[int, Problem] = {}
        waiting = list(range(len(requests)))
        while waiting:
            places, waiting = waiting[:BATCH], waiting[BATCH:]
            body = {"jobs": [requests[place] for place in places]}
            key = {"Idempotency-Key": uuid.uuid4().hex}
            answers = self.transport.request("POST", "/v1/jobs/batch", body, headers=key, survives_breaks=True).json()["answers"]
            pause_s, later = 0.0, []
            for place, answer in zip(places, answers):
                if "job" in answer:
                    jobs[place] = Job(answer["job"])
                elif "retry_after_s" in answer:
                    later.append(place)
                    pause_s = max(pause_s, float(answer["retry_after_s"]))
                else:
                    refused[place] = Problem(answer["status"], answer["problem"])
            if later:
                line.update(0, f"{len(later)} wait for a place in the queue")
                time.sleep(max(pause_s, FIRST_PAUSE_S))
            waiting = later + waiting
        return refused

    def _run(self, request: Dict[str, Any], progress: Optional[bool], timeout_s: Optional[float]) -> Job:
        """The succeeded job of a request."""
        line = Progress(progress)
        job = self._submit(request)
        try:
            return _succeeded(self._ended(job, line, timeout_s))
        except (KeyboardInterrupt, TimeoutError):
            self.cancel(job)
            raise
        finally:
            line.close()

    def _ended(self, job: Job, line: Progress, timeout_s: Optional[float], before: int = 0, of: int = 1) -> Job:
        """The job after its end. `before` of `of` jobs had ended before."""
        begin, pause_s = time.monotonic(), FIRST_PAUSE_S
        while not job.has_ended:
            what = job.status if of == 1 else f"{before} of {of} jobs"
            line.update((before + job.progress) / of, what)
            if timeout_s is not None and time.monotonic() - begin > timeout_s:
                raise TimeoutError(f"job {job.id} is still {job.status} after {timeout_s} s")
            time.sleep(pause_s)
            pause_s = min(1.5 * pause_s, LONGEST_PAUSE_S)
            job = self.job(job)
        return job


def _request(scene: Mapping[str, Any], fields: Mapping[str, Any]) -> Dict[str, Any]:
    """The job of a scene, or a job, with further fields."""
    job = scene if "scene" in scene else {"scene": scene}
    return {"kind": "simulation", **job, **fields}


def _succeeded(job: Job) -> Job:
    if job.status != "succeeded":
        raise JobFailed(job.status, cast(Mapping[str, Any], job.data), job.data.get("error"))
    return job


def _link(job: Job, name: str) -> str:
    return str(cast(Mapping[str, Any], job.data["links"])[name])
