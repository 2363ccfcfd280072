"""Packages that only some methods need."""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import pandas


def needed(module: str, purpose: str) -> Any:
    """The imported module, or an ImportError that says how to install it."""
    package = module.partition(".")[0]
    try:
        return importlib.import_module(module)
    except ImportError as error:
        raise ImportError(f"{purpose} needs {package}: pip install {package}") from error


def dataframe(data: Any) -> "pandas.DataFrame":
    """A DataFrame of columns or rows."""
    frame: "pandas.DataFrame" = needed("pandas", "to_dataframe").DataFrame(data)
    return frame
