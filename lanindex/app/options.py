"""The options that several verbs share, and groups of them that arrive as one value."""

from __future__ import annotations

import inspect
import sys
from collections.abc import Callable, Mapping, Sequence
from fractions import Fraction
from pathlib import Path
from typing import Annotated, Any

import typer

from lanindex.app import completion
from lanindex.app.output import Output, choice
from lanindex.errors import UsageError
from lanindex.library.selection import Selection

DB = "lanindex.db"
"""The default library."""

STDOUT = Path("-")
"""The output file name that means standard output."""


def option(metavar: str, help: str, *names: str, **settings: Any) -> Any:
    """Return an option; without `names` it is called like its parameter."""
    return typer.Option(*names, metavar=metavar, help=help, **settings)


def flag(name: str, help: str) -> Any:
    """Return an option without a value."""
    return typer.Option(name, help=help)


def captures(metavar: str, help: str) -> Any:
    """Return an argument that names captures."""
    return typer.Argument(metavar=metavar, help=help, autocompletion=completion.captures)


def pattern(metavar: str, help: str) -> Any:
    """Return an argument that is a pattern."""
    return typer.Argument(metavar=metavar, help=help, autocompletion=completion.patterns)


def file(metavar: str, help: str) -> Any:
    """Return an argument that is a file or folder; who reads it says what is wrong with it."""
    return typer.Argument(metavar=metavar, help=help, readable=False)


CaptureArgument = Annotated[
    str,
    captures(
        "CAPTURE|FILE|-",
        "A capture or file; NAME:FROM-TO for a stretch; - for a hit from search --json.",
    ),
]
Db = Annotated[str, option("PATH|URL", "The library to use.", envvar="LANINDEX_DB")]
Force = Annotated[bool, flag("--force", "Replace an existing file.")]
Profile = Annotated[str, option("NAME|FOLDER", "default, paper, or a folder of yours.")]
FileProfile = Annotated[str | None, option("NAME|FOLDER", "The profile to read a file with.")]
Origin = Annotated[bool, flag("--origin", "Begin at the floor's origin, facing forward.")]
Jobs = Annotated[
    int | None,
    typer.Option("--jobs", "-j", min=1, help="Processes to use; by default one per processor."),
]
Parts = Annotated[str | None, option("PART,...", "Only these tracks.")]
Part = Annotated[list[str] | None, option("PART", "Only this part; repeatable.")]
FromSeconds = Annotated[float | None, option("SECONDS", "Where to begin.", "--from", min=0.0)]
ToSeconds = Annotated[float | None, option("SECONDS", "Where to end.", "--to", min=0.0)]
Bars = Annotated[int | None, option("N", "Bars (or five-second stretches) per staff: 4.", min=1)]
Scale = Annotated[float | None, option("N", "Magnification: 1.", min=0.1, max=20.0)]
Words = Annotated[
    Path | None,
    option(
        "FILE", "Your own words for movement, added to the dictionary.", envvar="LANINDEX_WORDS"
    ),
]
Tolerance = Annotated[float, option("SECONDS", "How far apart matching edges may lie.")]
Near = Annotated[bool, flag("--near", "Symbols near the border of a cell match from both sides.")]
Fuzzy = Annotated[str | None, option("N|N%", "Edits a match may cost, in all or per step.")]
Limit = Annotated[
    int | None,
    typer.Option("--limit", "-n", min=1, help="How many to show: 20 on a terminal, else all."),
]
Timeout = Annotated[float | None, option("SECONDS", "Give up after this many seconds.", min=0)]


class Group:
    """An annotation: the options that `make` takes, but some, arrive as the value it returns."""

    def __init__(self, make: Callable[..., Any], *, but: Sequence[str] = ()) -> None:
        self.make = make
        parameters = inspect.signature(make, eval_str=True).parameters
        self.options = [one for name, one in parameters.items() if name not in but]


def ungrouped(verb: Callable[..., None]) -> Callable[..., None]:
    """Return a verb that takes each option of its groups by itself, as typer wants it."""
    signature = inspect.signature(verb, eval_str=True)
    groups: dict[str, Group] = {}
    parameters: list[inspect.Parameter] = []
    for parameter in signature.parameters.values():
        options = [parameter]
        for item in getattr(parameter.annotation, "__metadata__", ()):
            if isinstance(item, Group):
                groups[parameter.name], options = item, item.options
        parameters += [option.replace(kind=option.KEYWORD_ONLY) for option in options]

    def call(**values: Any) -> None:
        for name, group in groups.items():
            values[name] = group.make(**{one.name: values.pop(one.name) for one in group.options})
        verb(**values)

    call.__doc__ = verb.__doc__
    call.__annotations__ = {parameter.name: parameter.annotation for parameter in parameters}
    call.__signature__ = signature.replace(parameters=parameters)  # type: ignore[attr-defined]
    return call


def _reading(
    unit: Annotated[
        str | None, option("mm|cm|m|inch|cmu", "Unit of the file, if you know it.")
    ] = None,
    up: Annotated[str | None, option("x|y|z|-x|-y|-z", "Vertical axis of the file.")] = None,
    fps: Annotated[str | None, option("RATE", "Frames per second: 30, 29.97, 30000/1001.")] = None,
    compose: Annotated[
        str | None, option("parent|child", "Which rotation a BVH applies first.")
    ] = None,
    skeleton: Annotated[
        str | None, option("FILE", "The ASF file for AMC files without one.")
    ] = None,
    body: Annotated[
        str | None, option("FILE", 'Which name is which joint, a line each: RWrist = "hand_r".')
    ] = None,
    columns: Annotated[str | None, option("FILE", "What the columns of other tables mean.")] = None,
    take: Annotated[str | None, option("NAME", "Which take to read, if several.")] = None,
    tempo: Annotated[
        str | None, option("auto|FILE", "Count beats: detect them, or read them from a file.")
    ] = None,
) -> Any:
    """Return the options for reading a file; the readers check the words themselves."""
    from lanindex.model import Reading

    return Reading(unit, up, fps and rate(fps), compose, skeleton, body, columns, take, tempo)


def _selection(
    within: Annotated[
        str | None, option("GLOB", "Only captures whose path matches.", "--in")
    ] = None,
    where: Annotated[
        list[str] | None,
        option("KEY=GLOB", "Only captures whose label, format or other column matches."),
    ] = None,
) -> Selection:
    """Return the captures that --in and --where select."""
    pairs = []
    for text in where or ():
        key, equals, glob = text.partition("=")
        if not (key and equals):
            raise UsageError(f'"{text}"', place="--where", wanted="KEY=GLOB, such as label=walk*")
        pairs.append((key, glob))
    return Selection(within, pairs)


def _matching(
    overlaps: Annotated[str, option("none|all", "Whether to keep overlapping hits.")] = "none",
    tolerance: Tolerance = 0.1,
    near: Near = False,
    fuzzy: Fuzzy = None,
    strict: Annotated[bool, flag("--strict", "Match the timing of pasted LND, too.")] = False,
) -> dict[str, Any]:
    """Return how patterns match, as the methods of a library take it."""
    choice("--overlaps", overlaps, ("none", "all"))
    how = {"tolerance": tolerance, "overlaps": overlaps, "strict": strict}
    return {**how, "near": near, "fuzzy": fuzzy}


Out = Annotated[Output, Group(Output)]
"""--json, --quiet, --verbose and --color."""

PlainOut = Annotated[Output, Group(Output, but=["json"])]
ColorOut = Annotated[Output, Group(Output, but=["json", "quiet", "verbose"])]
DbOut = Annotated[Output, Group(Output, but=["verbose"])]

Reading = Annotated[Any, Group(_reading)]
"""What a reader wants to know of a file: --unit, --up, --fps and so on."""

FilmReading = Annotated[Any, Group(_reading, but=["fps"])]
"""The same where --fps is that of a film."""

Selected = Annotated[Selection, Group(_selection)]
"""--in and --where."""

Where = Annotated[Selection, Group(_selection, but=["within"])]

Matching = Annotated[dict[str, Any], Group(_matching)]
"""--overlaps, --tolerance, --near, --fuzzy and --strict."""


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


def ending(path: Path, allowed: Sequence[str]) -> str:
    """Return the ending of a file to write, without its dot."""
    form = path.suffix.lower().removeprefix(".")
    if form not in allowed:
        *others, last = allowed
        wanted = f"an ending of {', '.join(others)} or {last}"
        raise UsageError(f'"{path}"', place="--output", wanted=wanted)
    return form


def exclusive(name: str, value: object, others: Mapping[str, object]) -> None:
    """Refuse options that cannot be used beside another."""
    for other, given in others.items():
        if value and given:
            raise UsageError(f"{name} and {other}", wanted="one of them")


def dependent(name: str, value: object, *, on: str, given: object) -> None:
    """Refuse an option that means nothing without another."""
    if value and not given:
        raise UsageError(name, wanted=f"{on} beside it")
