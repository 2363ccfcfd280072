"""Nested JSON as columns of a table."""

from __future__ import annotations

from typing import Any, Dict, Iterator, Mapping, Tuple


def flat(value: Any, pointer: str = "") -> Dict[str, Any]:
    """The values of nested objects by JSON pointer, as in the service's CSV. Lists of objects are left out, other lists kept."""
    return dict(_leaves(value, pointer))


def _leaves(value: Any, pointer: str) -> Iterator[Tuple[str, Any]]:
    if isinstance(value, Mapping):
        for name, part in value.items():
            yield from _leaves(part, f"{pointer}/{str(name).replace('~', '~0').replace('/', '~1')}")
    elif not (isinstance(value, list) and any(isinstance(part, (Mapping, list)) for part in value)):
        yield pointer, value


def differing(rows: "list[Dict[str, Any]]") -> "list[str]":
    """Names of the columns whose values are not equal in all rows, in the order of their first appearance."""
    names = {name: None for row in rows for name in row}
    missing = object()
    return [name for name in names if any(row.get(name, missing) != rows[0].get(name, missing) for row in rows)]
