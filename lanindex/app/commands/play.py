"""``lanindex play``: a capture as a film, its figure beside its staff."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from lanindex.app import options
from lanindex.app.output import Output
from lanindex.errors import LanindexError, UsageError

if TYPE_CHECKING:
    from lanindex.model import Motion, Symbol
    from lanindex.pipeline.named import Named


def run(
    capture: Annotated[
        str,
        typer.Argument(
            metavar="CAPTURE|FILE|-",
            help="Of the library or a file; with :FROM-TO a stretch; -: a hit of search --json.",
            autocompletion=options.offered("captures"),
        ),
    ],
    output: Annotated[
        Path | None,
        typer.Option(
            *("--output", "-o"),
            metavar="FILE.webp|gif|mp4",
            help="Where to; else a .webp file here.",
        ),
    ] = None,
    highlight: Annotated[
        str | None,
        typer.Option("--highlight", metavar="PATTERN", help="Colour the limbs of its hits."),
    ] = None,
    words: options.Words = None,
    view: Annotated[
        str,
        typer.Option(
            metavar="auto|front|side|DEGREES", help="From where: auto sees most of the movement."
        ),
    ] = "auto",
    parts: Annotated[
        str | None,
        typer.Option("--parts", metavar="PART,...", help="Only these tracks on the staff."),
    ] = None,
    start: Annotated[
        float | None, typer.Option("--from", metavar="SECONDS", min=0.0, help="Begin there.")
    ] = None,
    stop: Annotated[
        float | None, typer.Option("--to", metavar="SECONDS", min=0.0, help="End there.")
    ] = None,
    fps: Annotated[
        str | None,
        typer.Option(metavar="RATE", help="Frames a second of the film: MP4 25, WebP and GIF 20."),
    ] = None,
    size: Annotated[
        str, typer.Option(metavar="WIDTHxHEIGHT", help="Of the film, pixels.")
    ] = "640x480",
    profile: options.OwnProfile = None,
    unit: options.Unit = None,
    up: options.Up = None,
    file_fps: Annotated[
        str | None, typer.Option(metavar="RATE", help="Frames a second of a file.")
    ] = None,
    compose: options.Compose = None,
    skeleton: options.Skeleton = None,
    body: options.Body = None,
    columns: options.Columns = None,
    take: options.Take = None,
    tempo: options.Tempo = None,
    force: Annotated[bool, typer.Option("--force", help="Replace a file that is there.")] = False,
    db: options.Db = options.DB,
    quiet: options.Quiet = False,
    verbose: options.Verbose = False,
    color: options.Color = "auto",
) -> None:
    """Let a stick figure move beside its staff of Labanotation, in real time.

    The parts that matched are coloured while they do, and the way over the floor is drawn. A score
    without a motion is carried out. Options of reading (--unit, --profile and so on) are for files.
    """
    out = Output(False, quiet, verbose, color)
    from lanindex.film.figure import figure
    from lanindex.film.film import RATE, RATES, Film, form_of
    from lanindex.pipeline import open_library
    from lanindex.pipeline.files import refuse, safe_stem, write_all
    from lanindex.pipeline.named import named
    from lanindex.pipeline.playing import motion_of

    target = output or Path(f"{safe_stem('hit' if capture == '-' else capture)}.webp")
    form = form_of(str(target))
    rate = RATES.get(form, RATE) if fps is None else options.rate(fps)
    told = options.reading(
        unit, up, file_fps, compose, skeleton=skeleton, body=body, columns=columns, take=take
    )
    refuse(target, force=force)
    opened = partial(open_library, db, readonly=True)
    with _file_fps():
        found = named(options.one_line(capture), opened, told, profile=profile, tempo=tempo)
        motion = motion_of(found, opened, told, rate)
    if not found.capture:
        _doubts(out, found, motion)
    film = Film(
        figure(motion),
        found.score,
        start=found.seconds[0] if start is None else start,
        stop=found.seconds[1] if stop is None else stop,
        rate=rate,
        size=_size(size),
        view=view,
        parts=None if parts is None else [part.strip() for part in parts.split(",")],
        marked=_marked(out, found, highlight, words),
        seconds=not found.counted,
    )
    shown = partial(out.progress, total=len(film), noun="frames")
    write_all([(target, film.written(form, shown))], force=force, sources=[found.path])
    for warning in film.staff.warnings:
        out.note(f"{found.title}: {warning}")
    lasts = float(len(film) / film.rate)
    out.note(f"{target}: {len(film)} frames at {float(rate):g} Hz, {lasts:.2f} s")


def _doubts(out: Output, found: Named, motion: Motion) -> None:
    """Say what was doubtful in a file, or could not be carried out."""
    for warning in dict.fromkeys((*found.score.warnings, *motion.warnings)):
        out.note(f"{found.path}: {_ours(warning)}")


def _marked(out: Output, found: Named, pattern: str | None, words: Path | None) -> list[Symbol]:
    """Return what is coloured: what a hit matched, or a pattern matches."""
    if pattern is None:
        return list(found.matched)
    from lanindex.pipeline.apart import matched

    hits = matched(found.score, pattern, words)
    out.note(f"{len(hits)} hit{'s' * (len(hits) != 1)}")
    return [symbol for hit in hits for symbol in hit]


def _size(text: str) -> tuple[int, int]:
    width, _, height = text.lower().partition("x")
    if not (width.isdecimal() and height.isdecimal()):
        raise UsageError(f'"{text}"', place="--size", wanted="WIDTHxHEIGHT, such as 640x480")
    return int(width), int(height)


@contextmanager
def _file_fps() -> Iterator[None]:
    """Let what readers say of ``--fps`` be said of the option that it is here."""
    try:
        yield
    except LanindexError as error:
        error.found, error.remedy = _ours(error.found), _ours(error.remedy)
        raise


def _ours(text: str) -> str:
    return text.replace("--fps", "--file-fps")
