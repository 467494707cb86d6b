"""``lanindex db``: look after the library."""

from __future__ import annotations

import typer

from lanindex.app import options
from lanindex.app.cli import SETTINGS
from lanindex.app.screen import Screen

app = typer.Typer(help="Look after the library.", no_args_is_help=True, **SETTINGS)
