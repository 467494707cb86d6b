"""The options that several verbs share, groups of them, and what a shell offers to complete."""

from __future__ import annotations

import inspect
import sys
from collections.abc import Callable, Collection, Mapping
from contextlib import AbstractContextManager, nullcontext
from fractions import Fraction
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

import lanindex
from lanindex.app.output import Output, choice
from lanindex.errors import LanindexError, UsageError, writable
from lanindex.library.selection import Selection

if TYPE_CHECKING:
    from lanindex.pipeline.library import Library
    from lanindex.pipeline.spread import Spread

DB = "lanindex.db"  # the default library
STDOUT = Path("-")  # the output file name that means standard output

_MOST = 200  # captures offered at once; a longer list helps nobody


def complete_pattern(ctx: typer.Context, incomplete: str) -> list[str]:
    """Return the continuations of a pattern, each behind what was typed before."""
    if incomplete.startswith("@"):
        return sorted(f"@{path}" for path in _pattern_files(incomplete[1:]))
    from lanindex.search.language.completion import complete

    parts = _from_library(ctx, lambda library: library.store.parts(checked=False))
    found = complete(incomplete, parts=parts or None, words=ctx.params.get("words"))
    begin = min((it.start for it in found), default=0)  # what follows a whole word can wait
    return [incomplete[:begin] + it.text for it in found if it.start == begin]


def complete_capture(ctx: typer.Context, incomplete: str) -> list[str]:
    """Return captures whose path, or whose file's name, begins with what was typed."""
    return _from_library(ctx, lambda library: library.store.paths_starting(incomplete, _MOST))


def _pattern_files(begun: str) -> list[str]:
    from lanindex.notation import notation_of

    folder, name = begun.rpartition("/")[::2]
    prefix = f"{folder}/" if folder or begun.startswith("/") else ""
    return [
        prefix + path.name
        for path in Path(folder or ".").glob("*")
        if path.name.startswith(name) and (path.suffix.lower() == ".lq" or notation_of(path.name))
    ]


def _from_library(ctx: typer.Context, query: Callable[[Library], list[str]]) -> list[str]:
    """Return what the library answers; nothing where it cannot be read."""
    from lanindex.pipeline.library import open_library

    try:
        with open_library(ctx.params["db"], readonly=True) as library:
            return query(library)
    except (LanindexError, OSError):
        return []


def option(default: Any, metavar: str | None, help: str, *names: str, **settings: Any) -> Any:
    """Return an option; without `names` it is called like its parameter."""
    return typer.Option(default, *names, metavar=metavar, help=help, **settings)


data_set_option = partial(option, rich_help_panel="Data sets")


def output(metavar: str, help: str, default: Path | None = None) -> Any:
    """Return the option that says where to write."""
    return option(default, metavar, help, "--output", "-o")


def flag(name: str, help: str) -> Any:
    """Return an option that is on or off."""
    return typer.Option(False, name, help=help)


def argument(default: Any, metavar: str | None, help: str, **settings: Any) -> Any:
    """Return an argument."""
    return typer.Argument(default, metavar=metavar, help=help, **settings)


def captures(default: Any, metavar: str, help: str) -> Any:
    """Return an argument that names captures."""
    return argument(default, metavar, help, autocompletion=complete_capture)


CaptureArgument = Annotated[
    str,
    captures(
        ...,
        "CAPTURE|FILE|-",
        "A capture or file; NAME:FROM-TO for a stretch; - for a hit from search --json.",
    ),
]
Db = Annotated[str, option(..., "PATH|URL", "The library to use.", envvar="LANINDEX_DB")]
Force = Annotated[bool, option(..., None, "Replace an existing file.", "--force")]
Profile = Annotated[str, option(..., "NAME|FOLDER", "default, paper, or a folder of yours.")]
FileProfile = Annotated[str | None, option(..., "NAME|FOLDER", "The profile to read a file with.")]
Origin = Annotated[
    bool, option(..., None, "Begin at the floor's origin, facing forward.", "--origin")
]
Jobs = Annotated[
    int | None,
    option(
        ...,
        None,
        "Processes to use; by default one per processor for 16 files or more.",
        "--jobs",
        "-j",
        min=1,
    ),
]
Cluster = Annotated[
    str | None,
    option(..., "ADDRESS", "Spread the work with Dask: tcp://HOST:PORT, local[:N], slurm[:N]."),
]
Parts = Annotated[str | None, option(..., "PART,...", "Only these tracks.")]
Part = Annotated[list[str] | None, option(..., "PART", "Only this part; repeatable.")]
FromSeconds = Annotated[float | None, option(..., "SECONDS", "Where to begin.", "--from", min=0.0)]
ToSeconds = Annotated[float | None, option(..., "SECONDS", "Where to end.", "--to", min=0.0)]
Bars = Annotated[
    int | None, option(..., "N", "Bars (or five-second stretches) per staff: 4, in a PDF 2.", min=1)
]
Scale = Annotated[
    float | None, option(..., "N", "Magnification: 1.5, in a PDF 1.", min=0.1, max=20.0)
]
Words = Annotated[
    Path | None,
    option(
        *(..., "FILE", "Your own words for movement, added to the dictionary."),
        envvar="LANINDEX_WORDS",
    ),
]
Tolerance = Annotated[float, option(..., "SECONDS", "How far apart matching edges may lie.")]
Near = Annotated[
    bool, option(..., None, "Symbols near the border of a cell match from both sides.", "--near")
]
Fuzzy = Annotated[str | None, option(..., "N|N%", "Edits a match may cost, in all or per step.")]
Limit = Annotated[
    int | None,
    option(..., None, "How many to show: 20 on a terminal, else all.", "--limit", "-n", min=1),
]
Timeout = Annotated[float | None, option(..., "SECONDS", "Give up after this many seconds.", min=0)]


class Group:
    """An annotation of a parameter: `make` returns its value from options, some of them `fixed`."""

    def __init__(self, make: Callable[..., Any], **fixed: Any) -> None:
        self.make = partial(make, **fixed)
        parameters = inspect.signature(make, eval_str=True).parameters
        self.options = [one for name, one in parameters.items() if name not in fixed]


def ungrouped(verb: Callable[..., int | None]) -> Callable[..., None]:
    """Return a verb that takes each option of its groups by itself, as typer wants it.

    What the verb returns is its exit code.
    """
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
        if code := verb(**values):
            raise typer.Exit(int(code))

    call.__doc__ = verb.__doc__
    call.__annotations__ = {parameter.name: parameter.annotation for parameter in parameters}
    call.__signature__ = signature.replace(parameters=parameters)  # type: ignore[attr-defined]
    return call


def _reading(
    unit: str | None = option(None, "mm|cm|m|inch|cmu", "Unit of the file, if you know it."),
    up: str | None = option(None, "x|y|z|-x|-y|-z", "Vertical axis of the file."),
    file_fps: str | None = option(
        None, "RATE", "Frames a second of the file: 30, 29.97, 30000/1001.", "--fps"
    ),
    compose: str | None = option(None, "parent|child", "Which rotation a BVH applies first."),
    skeleton: str | None = option(None, "FILE", "The ASF file for AMC files without one."),
    body: str | None = option(
        None, "FILE", 'Which name is which joint, a line each: RWrist = "hand_r".'
    ),
    columns: str | None = option(None, "FILE", "What the columns of other tables mean."),
    take: str | None = option(None, "NAME", "Which take to read, if several."),
    tempo: str | None = option(
        None, "auto|FILE", "Count beats: detect them, or read them from a file."
    ),
) -> Any:
    """Return the options for reading a file; the readers check the words themselves."""
    from lanindex.model import Reading

    own = file_fps and rate(file_fps)
    return Reading(unit, up, own, compose, skeleton, body, columns, take, tempo)


def _selection(
    within: str | None = option(None, "GLOB", "Only captures whose path matches.", "--in"),
    where: list[str] | None = option(
        None, "KEY=GLOB", "Only captures whose label, format or other column matches."
    ),
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
    overlaps: str = option("none", "none|all", "Whether to keep overlapping hits."),
    tolerance: Tolerance = 0.1,
    near: Near = False,
    fuzzy: Fuzzy = None,
    strict: bool = flag("--strict", "Match the timing of pasted LND, too."),
) -> dict[str, Any]:
    """Return how patterns match, as the methods of a library take it."""
    choice("--overlaps", overlaps, ("none", "all"))
    timing = {"tolerance": tolerance, "overlaps": overlaps, "strict": strict}
    return {**timing, "near": near, "fuzzy": fuzzy}


Out = Annotated[Output, Group(Output)]
PlainOut = Annotated[Output, Group(Output, json=False)]
ColorOut = Annotated[Output, Group(Output, json=False, quiet=False, verbose=False)]
DbOut = Annotated[Output, Group(Output, verbose=False)]
Reading = Annotated[Any, Group(_reading)]
Selected = Annotated[Selection, Group(_selection)]
Where = Annotated[Selection, Group(_selection, within=None)]
Matching = Annotated[dict[str, Any], Group(_matching)]


def rate(text: str, place: str = "--fps") -> Fraction:
    """Return a frame rate above 0."""
    try:
        value = Fraction(text)
    except (ValueError, ZeroDivisionError):
        value = Fraction(0)
    if not 0 < value < 100_000:
        raise UsageError(f'"{text}"', place=place, wanted="30, 29.97 or 30000/1001")
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


def opened(db: str, out: Output, words: Path | None = None, cluster: str | None = None) -> Library:
    """Open a library to be read; show its notes, and the progress of its jobs."""
    told: dict[str, Any] = {"note": out.note, "progress": out.watch}
    return lanindex.open_library(db, readonly=True, words=words, cluster=cluster, **told)


def spread(cluster: str | None, out: Output) -> AbstractContextManager[Spread | None]:
    """Return the processes of a cluster, which are let go at the end of the block."""
    if cluster is None:
        return nullcontext()
    from lanindex.pipeline.cluster import Cluster

    return Cluster(cluster, out.note)


def capture_id(text: str) -> int | str:
    """Return a capture's number if the argument is one, else its path."""
    return int(text) if text.isdecimal() else text


def ending(path: Path, allowed: Collection[str], option: str = "--output") -> str:
    """Return the ending of a file that can be written, without its dot."""
    form = path.suffix.lower().removeprefix(".")
    if form not in allowed:
        *others, last = allowed
        endings = f"{', '.join(others)} or {last}" if others else last
        raise UsageError(f'"{path}"', place=option, wanted=f"an ending of {endings}")
    writable(form)
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
