"""``lanindex language``: the language of patterns on a page."""

from __future__ import annotations

from lanindex.app import options
from lanindex.app.output import Output


def run(color: options.Color = "auto") -> None:
    """Show the language of patterns on a page: parts, directions, heights, times, and all else."""
    from importlib.resources import files

    page = files("lanindex.search").joinpath("LANGUAGE.md").read_text(encoding="utf-8")
    Output(color=color).content(page)
