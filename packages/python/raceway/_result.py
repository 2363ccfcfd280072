"""Results of jobs: metrics, labelled spectra, series, tables, plots."""

from __future__ import annotations

import json
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any, Dict, Iterable, List, Mapping, Optional, Sequence, cast, overload

from ._errors import JobFailed, Problem, RacewayError
from ._flat import differing, flat
from ._optional import dataframe, needed

if TYPE_CHECKING:
    import matplotlib.axes
    import pandas

    from ._client import Client, Job
    from .schema import MessageAnswer, Metrics

#: Link of the main document of a job, where it is not the job's kind.
MAIN_LINK = {"simulation": "metrics", "study": "table"}


@dataclass(frozen=True)
class Line:
    """A line of a spectrum: frequency [Hz], amplitude in the channel's unit, label such as `2·BPFO`, empty where none is near."""

    channel: str
    frequency_hz: float
    amplitude: float
    label: str
    deviation_hz: float


@dataclass(frozen=True)
class Spectrum:
    """A one-sided spectrum of a channel with its lines. `answer` has window, resolution and limits."""

    channel: str
    unit: str
    frequency_hz: List[float]
    amplitude: List[float]
    lines: List[Line]
    answer: Mapping[str, Any]

    def labels(self) -> List[str]:
        """Label of each value: that of the line in its bin, else empty."""
        labels = [""] * len(self.frequency_hz)
        resolution_hz = float(self.answer["resolution_hz"])
        first_hz = self.frequency_hz[0] if self.frequency_hz else 0.0
        # From the weakest line on, so that the strongest line of a bin remains.
        for line in reversed(self.lines):
            place = round((line.frequency_hz - first_hz) / resolution_hz)
            if line.label and 0 <= place < len(labels):
                labels[place] = line.label
        return labels

    def to_dataframe(self) -> "pandas.DataFrame":
        """Columns `channel`, `frequency_hz`, `amplitude`, `unit`, `label`."""
        columns = {
            "channel": self.channel, "frequency_hz": self.frequency_hz, "amplitude": self.amplitude, "unit": self.unit,
            "label": self.labels(),
        }
        return dataframe(columns)

    def plot(self, ax: "Optional[matplotlib.axes.Axes]" = None, *, labels: int = 10) -> "matplotlib.axes.Axes":
        """Draws the spectrum with the labels of its strongest lines."""
        ax = _axes(ax, "plot_spectrum")
        ax.semilogy(self.frequency_hz, self.amplitude, linewidth=0.8)
        last_hz = self.frequency_hz[-1] if self.frequency_hz else 0.0
        named = [line for line in self.lines if line.label and line.frequency_hz <= last_hz][:labels]
        for line in named:
            ax.annotate(
                line.label, (line.frequency_hz, self._at(line.frequency_hz)), rotation=90, fontsize=8, ha="center", va="bottom",
                textcoords="offset points", xytext=(0, 3),
            )
        if named:
            # Room for the labels.
            ax.set_ylim(top=200 * max(self.amplitude))
        ax.set(xlabel="Frequency in Hz", ylabel=f"{self.channel} in {self.unit}")
        ax.grid(True, which="major", alpha=0.3)
        return ax

    def _at(self, frequency_hz: float) -> float:
        """Amplitude in the bin of a frequency."""
        place = round((frequency_hz - self.frequency_hz[0]) / float(self.answer["resolution_hz"]))
        return self.amplitude[min(max(place, 0), len(self.amplitude) - 1)]


@dataclass(frozen=True)
class Series:
    """A signal over time [s], settling included."""

    channel: str
    unit: str
    time_s: List[float]
    value: List[float]

    def to_dataframe(self) -> "pandas.DataFrame":
        """Columns `channel`, `time_s`, `value`, `unit`."""
        columns = {"channel": self.channel, "time_s": self.time_s, "value": self.value, "unit": self.unit}
        return dataframe(columns)

    def plot(self, ax: "Optional[matplotlib.axes.Axes]" = None) -> "matplotlib.axes.Axes":
        """Draws the signal."""
        ax = _axes(ax, "plot")
        ax.plot(self.time_s, self.value, linewidth=0.8)
        ax.set(xlabel="Time in s", ylabel=f"{self.channel} in {self.unit}")
        ax.grid(True, alpha=0.3)
        return ax


class Result:
    """A job with its result. Each part is read from the service when it is first used."""

    def __init__(
        self, client: "Client", job: "Optional[Job]", *, request: Optional[Dict[str, Any]] = None, problem: Optional[Problem] = None
    ) -> None:
        self._client = client
        self.job = job
        #: The job as it was requested.
        self.request: Mapping[str, Any] = (request or {}) if job is None else cast(Mapping[str, Any], job.data["request"])
        #: `succeeded`, `failed`, `cancelled` or `refused`.
        self.status = "refused" if job is None else job.status
        #: Why there is no result.
        self.error: Optional[Problem] = problem
        if job is not None and job.status != "succeeded":
            self.error = JobFailed(job.status, cast(Mapping[str, Any], job.data), job.data.get("error"))

    @cached_property
    def answer(self) -> Any:
        """Main document of the result: metrics of a simulation, else what the job's kind gives."""
        kind = str(self.request["kind"])
        return self.get(MAIN_LINK.get(kind, kind))

    @property
    def metrics(self) -> "Metrics":
        """Metrics of the simulation, with levels, frequencies and accuracy."""
        return cast("Metrics", self.answer)

    @property
    def messages(self) -> "Sequence[MessageAnswer]":
        """What a user should know about the result."""
        return self.answer.get("messages", [])  # type: ignore[no-any-return]

    @property
    def lines(self) -> List[Line]:
        """Strongest lines of all amplitude spectra."""
        return _lines(self.answer.get("lines", []))

    def spectrum(
        self,
        channel: Optional[str] = None,
        *,
        kind: Optional[str] = None,
        scaling: Optional[str] = None,
        quantity: Optional[str] = None,
        max_frequency_hz: Optional[float] = None,
    ) -> Spectrum:
        """Spectrum of a channel, by default of the first one. `kind="envelope"` is the envelope spectrum; `scaling` and
        `quantity` are those of the API."""
        query = {
            "channel": channel, "kind": kind, "scaling": scaling, "quantity": quantity, "max_frequency_hz": max_frequency_hz,
        }
        answer = self.get("spectrum", **query)
        lines = _lines(self.answer.get("envelope_lines" if answer["kind"] == "envelope" else "lines", []))
        lines = [line for line in lines if line.channel == answer["channel"]]
        return Spectrum(answer["channel"], answer["unit"], answer["frequency_hz"], answer["amplitude"], lines, answer)

    def series(
        self,
        channel: Optional[str] = None,
        *,
        from_s: Optional[float] = None,
        to_s: Optional[float] = None,
        max_points: Optional[int] = None,
    ) -> Series:
        """Time series of a channel that the job recorded (`outputs.series`), by default of the first one."""
        answer = self.get("series", channel=channel, from_s=from_s, to_s=to_s, max_points=max_points)
        return Series(answer["channel"], answer["unit"], answer["time_s"], answer["value"])

    def to_dataframe(self) -> "pandas.DataFrame":
        """The labelled amplitude spectra of all channels: `channel`, `frequency_hz`, `amplitude`, `unit`, `label`."""
        concat = needed("pandas", "to_dataframe").concat
        channels = self.get("channels")["spectra"]
        if not channels:
            raise RacewayError("the result has no spectrum: outputs.spectra is empty")
        frame: "pandas.DataFrame" = concat([self.spectrum(channel).to_dataframe() for channel in channels], ignore_index=True)
        return frame

    def row(self) -> Dict[str, Any]:
        """Status, error, and numbers of `answer` by JSON pointer: a row of `Results.to_dataframe`."""
        numbers = flat(self.answer) if self.error is None else {}
        return {"status": self.status, "error": None if self.error is None else str(self.error), **numbers}

    def plot_spectrum(
        self,
        channel: Optional[str] = None,
        ax: "Optional[matplotlib.axes.Axes]" = None,
        *,
        max_frequency_hz: Optional[float] = None,
        labels: int = 10,
        **query: Any,
    ) -> "matplotlib.axes.Axes":
        """Draws the spectrum of a channel with the labels of its strongest lines."""
        needed("matplotlib", "plot_spectrum")
        return self.spectrum(channel, max_frequency_hz=max_frequency_hz, **query).plot(ax, labels=labels)

    def plot_svg(self, name: str = "spectrum") -> str:
        """A plot of the service: `spectrum`, `envelope`, `velocity`, `orbit` and others among the job's links."""
        return self._read(f"{name}_svg", {}, "image/svg+xml").decode()

    def get(self, link: str, **query: Any) -> Any:
        """JSON behind one of the job's links, such as `orders`, `waterfall` or `channels`."""
        return json.loads(self._read(link, query, "application/json"))

    def _read(self, link: str, query: Mapping[str, Any], accept: str) -> bytes:
        if self.error is not None or self.job is None:
            raise self.error or RacewayError("the job was refused")
        links = cast(Mapping[str, str], self.job.data["links"])
        if link not in links:
            raise RacewayError(f"the job has no {link}; it has {', '.join(links)}")
        return self._client.transport.request("GET", links[link], query=query, headers={"Accept": accept}, survives_breaks=True).body

    def __repr__(self) -> str:
        return f"Result({self.request['kind']}, {self.status})"


class Results(Sequence[Result]):
    """Results in the order of their jobs."""

    def __init__(self, results: Iterable[Result]) -> None:
        self._results = list(results)

    @property
    def failed(self) -> "Results":
        """Those that have no result, with their `error`."""
        return Results(result for result in self._results if result.error is not None)

    def rows(self) -> List[Dict[str, Any]]:
        """One row for each job: the fields of the requests that differ, then `Result.row`. Fields of the scene have their JSON
        pointer in the scene, as in a study."""
        requests = [_fields(result.request) for result in self._results]
        inputs = differing(requests)
        return [
            {**{name: request.get(name) for name in inputs}, **result.row()} for request, result in zip(requests, self._results)
        ]

    def to_dataframe(self) -> "pandas.DataFrame":
        """One row for each job."""
        return dataframe(self.rows())

    @overload
    def __getitem__(self, place: int) -> Result: ...

    @overload
    def __getitem__(self, place: slice) -> "Results": ...

    def __getitem__(self, place: "int | slice") -> "Result | Results":
        return Results(self._results[place]) if isinstance(place, slice) else self._results[place]

    def __len__(self) -> int:
        return len(self._results)

    def __repr__(self) -> str:
        return f"Results({len(self)} jobs, {len(self.failed._results)} without result)"


def _fields(request: Mapping[str, Any]) -> Dict[str, Any]:
    """Fields of the scene and of the job by JSON pointer."""
    return {**flat(request.get("scene", {})), **flat({name: value for name, value in request.items() if name != "scene"})}


def _lines(lines: Iterable[Mapping[str, Any]]) -> List[Line]:
    names = ("channel", "frequency_hz", "amplitude", "label", "deviation_hz")
    return [Line(*(line[name] for name in names)) for line in lines]


def _axes(ax: Any, purpose: str) -> Any:
    """The axes, or those of a new figure."""
    return needed("matplotlib.pyplot", purpose).subplots()[1] if ax is None else ax
