"""The options that several verbs share, and groups of them that arrive as one value."""

from __future__ import annotations

import inspect
import sys
from collections.abc import Callable, Sequence
from fractions import Fraction
from pathlib import Path
from typing import Annotated, Any

import typer

from lanindex.app import completion
from lanindex.app.output import Output
from lanindex.errors import UsageError
from lanindex.library.selection import Selection

DB = "lanindex.db"
"""The default library."""

STDOUT = Path("-")
"""The output file name that means standard output."""

Db = Annotated[
    str,
    typer.Option("--db", envvar="LANINDEX_DB", metavar="PATH|URL", help="The library to use."),
]
Json = Annotated[bool, typer.Option("--json", help="Print JSON lines.")]
Quiet = Annotated[bool, typer.Option("-q", "--quiet", help="Print results and errors only.")]
Verbose = Annotated[bool, typer.Option("-v", "--verbose", help="Print more on standard error.")]
Color = Annotated[
    str, typer.Option("--color", metavar="auto|always|never", help="When to use colour.")
]
Force = Annotated[bool, typer.Option("--force", help="Replace an existing file.")]
CaptureArgument = Annotated[
    str,
    typer.Argument(
        metavar="CAPTURE|FILE|-",
        help="A capture or file; NAME:FROM-TO for a stretch; - for a hit from search --json.",
        autocompletion=completion.captures,
    ),
]
Profile = Annotated[
    str,
    typer.Option("--profile", metavar="NAME|FOLDER", help="default, paper, or a folder of yours."),
]
FileProfile = Annotated[
    str | None,
    typer.Option("--profile", metavar="NAME|FOLDER", help="The profile to read a file with."),
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
    typer.Option("--fps", metavar="RATE", help="Frames per second: 30, 29.97, 30000/1001."),
]
Compose = Annotated[
    str | None,
    typer.Option("--compose", metavar="parent|child", help="Which rotation a BVH applies first."),
]
Skeleton = Annotated[
    str | None,
    typer.Option("--skeleton", metavar="FILE", help="The ASF file for AMC files without one."),
]
Body = Annotated[
    str | None,
    typer.Option(
        "--body", metavar="FILE", help='Which name is which joint, a line each: RWrist = "hand_r".'
    ),
]
Columns = Annotated[
    str | None,
    typer.Option("--columns", metavar="FILE", help="What the columns of other tables mean."),
]
Take = Annotated[
    str | None, typer.Option("--take", metavar="NAME", help="Which take to read, if several.")
]
Tempo = Annotated[
    str | None,
    typer.Option(
        "--tempo", metavar="auto|FILE", help="Count beats: detect them, or read them from a file."
    ),
]
Origin = Annotated[
    bool, typer.Option("--origin", help="Begin at the floor's origin, facing forward.")
]
Jobs = Annotated[
    int | None,
    typer.Option("--jobs", "-j", min=1, help="Processes to use; by default one per processor."),
]
Parts = Annotated[
    str | None, typer.Option("--parts", metavar="PART,...", help="Only these tracks.")
]
Part = Annotated[
    list[str] | None, typer.Option("--part", metavar="PART", help="Only this part; repeatable.")
]
FromSeconds = Annotated[
    float | None, typer.Option("--from", metavar="SECONDS", min=0.0, help="Where to begin.")
]
ToSeconds = Annotated[
    float | None, typer.Option("--to", metavar="SECONDS", min=0.0, help="Where to end.")
]
Bars = Annotated[
    int | None,
    typer.Option(
        "--bars", metavar="N", min=1, help="Bars (or five-second stretches) per staff: 4."
    ),
]
Scale = Annotated[
    float | None, typer.Option("--scale", metavar="N", min=0.1, max=20.0, help="Magnification: 1.")
]
Tolerance = Annotated[
    float,
    typer.Option("--tolerance", metavar="SECONDS", help="How far apart matching edges may lie."),
]
Words = Annotated[
    Path | None,
    typer.Option(
        "--words",
        envvar="LANINDEX_WORDS",
        metavar="FILE",
        help="Your own words for movement, added to the dictionary.",
    ),
]
Overlaps = Annotated[
    str, typer.Option("--overlaps", metavar="none|all", help="Whether to keep overlapping hits.")
]
Limit = Annotated[
    int | None,
    typer.Option("--limit", "-n", min=1, help="How many to show: 20 on a terminal, else all."),
]
Timeout = Annotated[
    float | None,
    typer.Option("--timeout", metavar="SECONDS", min=0, help="Give up after this many seconds."),
]
Memory = Annotated[
    float | None,
    typer.Option(
        "--memory",
        metavar="MB",
        min=64,
        help="Megabytes a search may use; by default a quarter of free memory.",
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
    typer.Option("--fuzzy", metavar="N|N%", help="Edits a match may cost, in all or per step."),
]
Strict = Annotated[bool, typer.Option("--strict", help="Match the timing of pasted LND, too.")]


class Group:
    """An annotation: the options that `make` takes are joined into the value it returns."""

    def __init__(self, make: Callable[..., Any]) -> None:
        self.make = make


def ungrouped(verb: Callable[..., None]) -> Callable[..., None]:
    """Return a verb that takes each option of its groups by itself, as typer wants it."""
    signature = inspect.signature(verb, eval_str=True)
    groups: dict[str, tuple[Group, list[str]]] = {}
    parameters: list[inspect.Parameter] = []
    for parameter in signature.parameters.values():
        metadata = getattr(parameter.annotation, "__metadata__", ())
        group = next((item for item in metadata if isinstance(item, Group)), None)
        added = [parameter]
        if group is not None:
            added = list(inspect.signature(group.make, eval_str=True).parameters.values())
            groups[parameter.name] = group, [option.name for option in added]
        parameters += [option.replace(kind=option.KEYWORD_ONLY) for option in added]

    def call(**given: Any) -> None:
        for name, (group, options) in groups.items():
            given[name] = group.make(**{option: given.pop(option) for option in options})
        verb(**given)

    call.__doc__ = verb.__doc__
    call.__annotations__ = {parameter.name: parameter.annotation for parameter in parameters}
    call.__signature__ = signature.replace(parameters=parameters)  # type: ignore[attr-defined]
    return call


def _output(
    json: Json = False, quiet: Quiet = False, verbose: Verbose = False, color: Color = "auto"
) -> Output:
    return Output(json, quiet, verbose, color)


def _plain_output(quiet: Quiet = False, verbose: Verbose = False, color: Color = "auto") -> Output:
    return Output(False, quiet, verbose, color)


def reading(
    unit: Unit = None,
    up: Up = None,
    fps: Fps = None,
    compose: Compose = None,
    skeleton: Skeleton = None,
    body: Body = None,
    columns: Columns = None,
    take: Take = None,
) -> Any:
    """Return the options for reading a file; the readers check the words themselves."""
    from lanindex.model import Reading

    given = None if fps is None else rate(fps)
    return Reading(unit, up, given, compose, skeleton, body, columns, take)


def _db_output(json: Json = False, quiet: Quiet = False, color: Color = "auto") -> Output:
    return Output(json, quiet, color=color)


Out = Annotated[Output, Group(_output)]
"""--json, --quiet, --verbose and --color."""

PlainOut = Annotated[Output, Group(_plain_output)]
"""The same without --json."""

DbOut = Annotated[Output, Group(_db_output)]
"""The same without --verbose."""

Reading = Annotated[Any, Group(reading)]
"""What a reader wants to know of a file: --unit, --up, --fps and so on."""


def where(given: list[str] | None) -> list[tuple[str, str]]:
    """Return pairs of a column and the glob that it must match."""
    pairs = []
    for text in given or []:
        key, equals, glob = text.partition("=")
        if not (key and equals):
            raise UsageError(f'"{text}"', place="--where", wanted="KEY=GLOB, such as label=walk*")
        pairs.append((key, glob))
    return pairs


def selection(within: str | None, globs: list[str] | None) -> Selection:
    """Return the captures that --in and --where select."""
    return Selection(within, where(globs))


def rate(text: str) -> Fraction:
    """Return a frame rate above 0."""
    try:
        value = Fraction(text)
    except (ValueError, ZeroDivisionError):
        value = Fraction(0)
    if not 0 < value < 100_000:
        raise UsageError(f'"{text}"', place="--fps", wanted="30, 29.97 or 30000/1001")
    return value


def names(text: str | None) -> list[str] | None:
    """Return the names between commas; None where the option is not given."""
    return None if text is None else [name.strip() for name in text.split(",")]


def one_line(text: str) -> str:
    """Return an argument, or for ``-`` the only line on standard input."""
    if text != str(STDOUT):
        return text
    lines = [line for line in sys.stdin or () if line.strip()]
    if len(lines) != 1:
        raise UsageError(f"{len(lines)} lines", place="standard input", wanted="one hit")
    return lines[0]


def capture_id(text: str) -> int | str:
    """Return a capture's number if the argument is one, else its path."""
    return int(text) if text.isdecimal() else text


def ending(path: Path, allowed: Sequence[str], option: str = "--output") -> str:
    """Return the ending of a file to write, without its dot."""
    form = path.suffix.lower().removeprefix(".")
    if form not in allowed:
        *others, last = allowed
        raise UsageError(
            f'"{path}"', place=option, wanted=f"an ending of {', '.join(others)} or {last}"
        )
    return form


def exclusive(given: dict[str, Any]) -> None:
    """Refuse two options that cannot be used together."""
    names = [name for name, value in given.items() if value]
    if len(names) > 1:
        raise UsageError(f"{names[0]} and {names[1]}", wanted="one of them")
