"""Data that comes with the program: tables in TOML beside the modules that use them."""

import tomllib
from functools import cache
from importlib import resources
from typing import Any


@cache
def shipped(name: str) -> dict[str, Any]:
    """Return the table of a file of the package: ``search/language/english.toml``."""
    return tomllib.loads(resources.files("lanindex").joinpath(name).read_text("utf-8"))
