"""Columns as tables of other libraries, by the extra ``tables``."""

from __future__ import annotations

from collections.abc import Mapping
from importlib import import_module
from typing import Any

from lanindex.errors import LanindexError


def pandas_of(columns: Mapping[str, Any]) -> Any:
    """Return columns as a ``pandas.DataFrame``."""
    return _library("pandas").DataFrame(columns)


def arrow_of(columns: Mapping[str, Any]) -> Any:
    """Return columns as a ``pyarrow.Table``."""
    return _library("pyarrow").table(columns)


def frame_of(columns: Mapping[str, Any]) -> Any:
    """Return columns as a data frame of pandas, or else of polars."""
    for name in ("pandas", "polars"):
        try:
            return import_module(name).DataFrame(columns)
        except ModuleNotFoundError as error:
            if error.name != name:
                raise
    raise LanindexError(
        "no library of data frames is installed",
        wanted="pandas or polars",
        remedy="Type: pip install pandas",
    )


def _library(name: str) -> Any:
    try:
        return import_module(name)
    except ImportError as error:
        remedy = "It comes with: pip install 'lanindex[tables]'."
        raise LanindexError(f"{error.name} is not installed", remedy=remedy) from error
