"""Predicts the vibration of rolling bearings.

    result = raceway.run({"bearing": "6205", "operation": {"speed_rpm": 3000, "radial_load_y_n": 500}})
    result.metrics["headline"]     levels
    result.spectrum().lines        labelled lines
    result.to_dataframe()          labelled spectrum; needs pandas

`run`, `run_many` and `study` start the binary of this package as a private service. `Client(url, token)` has the same methods
for a service elsewhere.
"""

from __future__ import annotations

from importlib.metadata import PackageNotFoundError, version
from typing import TYPE_CHECKING, Any, Iterable, Optional, Sequence

from ._client import Client, Job
from ._errors import FieldError, JobFailed, Problem, RacewayError, Unreachable
from ._result import Line, Result, Results, Series, Spectrum
from ._server import binary, local_client
from ._table import Table

if TYPE_CHECKING:
    from ._client import JobRequest, Scene
    from .schema import AxisInput

try:
    __version__ = version("raceway")
except PackageNotFoundError:  # From a checkout, which has no metadata.
    __version__ = "0"
__all__ = [
    "Client", "FieldError", "Job", "JobFailed", "Line", "Problem", "RacewayError", "Result", "Results", "Series", "Spectrum", "Table",
    "Unreachable", "binary", "local_client", "run", "run_many", "study",
]


def run(scene: "Scene | JobRequest", *, progress: Optional[bool] = None, **fields: Any) -> Result:
    """Result of a scene or job on the private service. See `Client.run`."""
    return local_client().run(scene, progress=progress, **fields)


def run_many(scenes: "Iterable[Scene | JobRequest]", *, progress: Optional[bool] = None, **fields: Any) -> Results:
    """Results of many scenes or jobs on the private service, on all cores. See `Client.run_many`."""
    return local_client().run_many(scenes, progress=progress, **fields)


def study(scene: "Scene", axes: "Sequence[AxisInput]", *, progress: Optional[bool] = None, **fields: Any) -> Table:
    """Table of a study on the private service. See `Client.study`."""
    return local_client().study(scene, axes, progress=progress, **fields)
