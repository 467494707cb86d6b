"""``lanindex guide``: the guide and the reference pages, a topic at a time."""

from __future__ import annotations

from typing import Annotated

import typer

from lanindex.app import options
from lanindex.app.output import Output
from lanindex.errors import UsageError, guess

TOPICS = {
    "first-steps": ("guide/first-steps.md", "Ingest a folder, search it, export clips"),
    "asking": ("guide/asking.md", "Patterns, words, and search by example"),
    "looking": ("guide/looking.md", "Symbols, staves, scores, sheets of hits, films"),
    "labels": ("guide/labels.md", "Evaluate patterns; compare groups of captures"),
    "programs": ("guide/programs.md", "Blender, OpenSim, ELAN, LabanotationSuite, pandas"),
    "formats": ("guide/formats.md", "What can be read, and what clips keep"),
    "data-sets": ("guide/data-sets.md", "Write hits as arrays for training"),
    "profile": ("guide/profile.md", "Change the numbers of the method"),
    "lnd": ("guide/lnd.md", "Write a score by hand"),
    "python": ("guide/python.md", "Use LanIndex from Python and Jupyter"),
    "json": ("guide/json.md", "The keys that --json prints"),
    "language": ("search/LANGUAGE.md", "Reference: the language of patterns"),
    "method": ("encoding/METHOD.md", "Reference: how movement becomes symbols"),
    "body": ("encoding/BODY.md", "Reference: steps, jumps, turns, touches, bends"),
    "notations": ("notation/NOTATIONS.md", "Reference: LND, ELAN, Praat and other notations"),
    "architecture": ("ARCHITECTURE.md", "For developers: modules, data, glossary"),
}
"""Topics: page in the package, and what it is about."""


def run(
    topic: Annotated[
        str | None, typer.Argument(help="A topic; without one they are listed.")
    ] = None,
    color: options.Color = "auto",
) -> None:
    """Print a page of the guide, or list its topics."""
    from importlib.resources import files

    out = Output(color=color)
    if topic is None:
        out.table(["topic", "about"], [[name, about] for name, (_, about) in TOPICS.items()])
        return
    if topic not in TOPICS:
        near = guess(topic, TOPICS)
        remedy = f"Did you mean {near}?" if near else "All are shown by: lanindex guide"
        raise UsageError(f'the guide has no topic "{topic}"', remedy=remedy)
    out.content(files("lanindex").joinpath(TOPICS[topic][0]).read_text(encoding="utf-8"))
