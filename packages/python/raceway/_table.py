"""The table of a study."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Dict, List, Mapping

from ._flat import flat
from ._optional import dataframe

if TYPE_CHECKING:
    import pandas

    from ._client import Job
    from .schema import TableAnswer


class Table:
    """Points of a study with their metrics. `answer` is the table as the service gives it, with axes, trends and best points."""

    def __init__(self, job: "Job", answer: "TableAnswer") -> None:
        self.job = job
        self.answer = answer

    @property
    def best(self) -> Mapping[str, Any]:
        """The best point by each metric that has a best value."""
        return self.answer["best"]

    def rows(self) -> List[Dict[str, Any]]:
        """One row for each point: values of the axes, status, error, and metrics by JSON pointer."""
        rows = []
        for row in self.answer["rows"]:
            error: Mapping[str, Any] = row.get("error") or {}
            rows.append({**row["point"], "status": row["status"], "error": error.get("detail"), **flat(row.get("metrics") or {})})
        return rows

    def to_dataframe(self) -> "pandas.DataFrame":
        """One row for each point."""
        return dataframe(self.rows())

    def __repr__(self) -> str:
        return f"Table({self.answer['succeeded']} of {self.answer['points']} points)"
