#!/usr/bin/env python3
"""A job through the client that openapi-python-client generates, with the generated types only: submit, wait, metrics, spectrum. The
argument is the URL of the service. The package raceway_client must be importable."""

import sys
import time

from raceway_client import Client
from raceway_client.api.jobs import list_jobs, show_job, submit_job
from raceway_client.api.results import get_metrics, get_plot, get_spectrum
from raceway_client.api.scenes import resolve_scene
from raceway_client.models import (
    JobAnswer, JobKindName, JobList, Metrics, OperationInput, Problem, ResolveAnswer, SceneInput, SceneRequest,
    SimulationJob, SimulationJobKind, SpectrumAnswer, StatusName,
)


def of(kind, answer):
    """The response, which must have this type."""
    if not isinstance(answer, kind):
        sys.exit(f"FAILED: {kind.__name__} was due, not {answer}")
    return answer


def scene(speed_rpm):
    return SceneInput(bearing="6205", operation=OperationInput(speed_rpm=speed_rpm, radial_load_y_n=500))


def simulation(speed_rpm):
    return SimulationJob(kind=SimulationJobKind.SIMULATION, scene=scene(speed_rpm))


client = Client(base_url=sys.argv[1])
resolved = of(ResolveAnswer, resolve_scene.sync(client=client, body=SceneRequest(scene=scene(6000))))
print(f"BPFO: {resolved.derived.frequencies_hz.ball_pass_outer:.1f} Hz")

refused = of(Problem, submit_job.sync(client=client, body=simulation(6e6)))
print(f"refused: {refused.status}, {refused.errors[0].pointer}: {refused.errors[0].detail}")

job = of(JobAnswer, submit_job.sync(client=client, body=simulation(6000)))
while job.status in (StatusName.QUEUED, StatusName.RUNNING):
    time.sleep(0.1)
    job = of(JobAnswer, show_job.sync(job.id, client=client))
if not isinstance(job.request, SimulationJob):
    sys.exit(f"FAILED: the request has become {job.request}")
if job.status != StatusName.SUCCEEDED:
    sys.exit(f"FAILED: {job.error}")
listed = of(JobList, list_jobs.sync(client=client, kind=[JobKindName.SIMULATION], limit=1))
if listed.jobs[0].id != job.id:
    sys.exit("FAILED: the job is not the first of the list")

metrics = of(Metrics, get_metrics.sync(job.id, client=client))
level = metrics.channels["spindle.y.acceleration"].level_db
print(f"level: {level:.1f} dB; strongest line {metrics.lines[0].label}")
spectrum = of(SpectrumAnswer, get_spectrum.sync(job.id, client=client, channel="spindle.y.acceleration", max_frequency_hz=5000))
print(f"{len(spectrum.frequency_hz)} points in {spectrum.unit}")
picture = get_plot.sync(job.id, "spectrum.svg", client=client)
if "<svg" not in str(picture):
    sys.exit(f"FAILED: no picture but {picture}")
