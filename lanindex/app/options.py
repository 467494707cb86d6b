"""The options that several verbs share."""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

if TYPE_CHECKING:
    from fractions import Fraction

    from lanindex.model import Reading


def offered(what: str) -> Callable[[typer.Context, str], list[str]]:
    """Return what offers completions to a shell: a function of `lanindex.app.offers`, by name."""

    def offer(ctx: typer.Context, incomplete: str) -> list[str]:
        from lanindex.app import offers

        return list(getattr(offers, what)(ctx, incomplete))

    return offer


Db = Annotated[
    str,
    typer.Option("--db", envvar="LANINDEX_DB", metavar="PATH|URL", help="The library to use."),
]
DB = "lanindex.db"
"""The library that is used where none is named."""

STDOUT = Path("-")
"""An output file's name that means standard output."""

Json = Annotated[bool, typer.Option("--json", help="Print JSON lines.")]
Quiet = Annotated[bool, typer.Option("-q", "--quiet", help="Print results and errors only.")]
Verbose = Annotated[bool, typer.Option("-v", "--verbose", help="Say more on standard error.")]
Color = Annotated[str, typer.Option("--color", metavar="auto|always|never", help="Use colour.")]
Profile = Annotated[
    str, typer.Option("--profile", metavar="NAME|FOLDER", help="default, paper, or your own.")
]
OwnProfile = Annotated[
    str | None, typer.Option("--profile", metavar="NAME|FOLDER", help="Of a file: else default.")
]
Unit = Annotated[
    str | None,
    typer.Option("--unit", metavar="mm|cm|m|inch|cmu", help="Unit of the file, if you know it."),
]
Up = Annotated[
    str | None, typer.Option("--up", metavar="x|y|z|-x|-y|-z", help="Vertical axis of the file.")
]
Fps = Annotated[
    str | None,
    typer.Option("--fps", metavar="RATE", help="Frames a second: 30, 29.97, 30000/1001."),
]
Compose = Annotated[
    str | None,
    typer.Option("--compose", metavar="parent|child", help="Which rotation a BVH applies first."),
]
Skeleton = Annotated[
    str | None,
    typer.Option("--skeleton", metavar="FILE", help="The ASF of AMC files that have none beside."),
]
Body = Annotated[
    str | None,
    typer.Option(
        "--body", metavar="FILE", help='What plays which joint: RWrist = "hand_r", line by line.'
    ),
]
Columns = Annotated[
    str | None,
    typer.Option("--columns", metavar="FILE", help="What the columns of other tables are."),
]
Take = Annotated[
    str | None, typer.Option("--take", metavar="NAME", help="Which of several takes in a file.")
]
Tempo = Annotated[
    str | None,
    typer.Option(
        "--tempo", metavar="auto|FILE", help="Count by the movement's beat, or by a file of beats."
    ),
]
Tolerance = Annotated[
    float,
    typer.Option("--tolerance", metavar="SECONDS", help="How far edges may lie apart to agree."),
]
Words = Annotated[
    Path | None,
    typer.Option(
        "--words",
        envvar="LANINDEX_WORDS",
        metavar="FILE",
        help="Your own words for movement, beside the dictionary's.",
    ),
]
Overlaps = Annotated[
    str, typer.Option("--overlaps", metavar="none|all", help="Keep hits that overlap, or not.")
]
Timeout = Annotated[
    float | None,
    typer.Option("--timeout", metavar="SECONDS", min=0, help="Give up after so many seconds."),
]
Memory = Annotated[
    float | None,
    typer.Option(
        "--memory",
        metavar="MB",
        min=64,
        help="Megabytes that a search may take; a quarter of what is free.",
    ),
]
In = Annotated[
    str | None, typer.Option("--in", metavar="GLOB", help="Only captures whose path matches.")
]
Where = Annotated[
    list[str] | None,
    typer.Option(
        "--where",
        metavar="KEY=GLOB",
        help="Only captures whose label, format or other column matches.",
    ),
]
Near = Annotated[
    bool, typer.Option("--near", help="Symbols near the border of a cell match from both sides.")
]
Fuzzy = Annotated[
    str | None,
    typer.Option("--fuzzy", metavar="N|N%", help="Edits a match may cost, in all or a step: 15%."),
]
Strict = Annotated[bool, typer.Option("--strict", help="Let the timing of pasted LND count.")]


def where(given: list[str] | None) -> list[tuple[str, str]]:
    """Return columns of captures, each with the glob that it shall match."""
    from lanindex.errors import UsageError

    pairs = []
    for text in given or []:
        key, equals, glob = text.partition("=")
        if not (key and equals):
            raise UsageError(f'"{text}"', place="--where", wanted="KEY=GLOB, such as label=walk*")
        pairs.append((key, glob))
    return pairs


def rate(text: str) -> Fraction:
    """Return a number of frames a second."""
    from fractions import Fraction

    from lanindex.errors import UsageError

    try:
        value = Fraction(text)
    except (ValueError, ZeroDivisionError):
        value = Fraction(0)
    if not 0 < value < 100_000:
        raise UsageError(f'"{text}"', place="--fps", wanted="30, 29.97 or 30000/1001")
    return value


def one_line(named: str) -> str:
    """Return what a person names: for ``-`` the one line that stands on standard input."""
    if named != str(STDOUT):
        return named
    from lanindex.errors import UsageError

    lines = [line for line in sys.stdin or () if line.strip()]
    if len(lines) != 1:
        raise UsageError(f"{len(lines)} lines", place="standard input", wanted="one hit")
    return lines[0]


def which(named: str) -> int | str:
    """Return a capture's number where that is what was typed, else the path."""
    return int(named) if named.isdecimal() else named


def reading(
    unit: str | None, up: str | None, fps: str | None, compose: str | None, **files: str | None
) -> Reading:
    """Return what the reader is told; it checks the words itself."""
    from lanindex.model import Reading

    return Reading(unit, up, None if fps is None else rate(fps), compose, **files)
