"""``lanindex diff``: what two captures or scores differ in, in words and as a picture."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from lanindex.app import named, options
from lanindex.app.output import Output
from lanindex.errors import UsageError

if TYPE_CHECKING:
    from lanindex.compare import Comparison, Difference, Timed
    from lanindex.model import Score
    from lanindex.pipeline.named import Named

_MOST = 6
"""Tracks that only one has, as many as are named."""


def run(
    one: Annotated[
        str,
        typer.Argument(
            metavar="A",
            help="A capture of the library or a file; :FROM-TO (frames) behind it: a stretch.",
            autocompletion=options.offered("captures"),
        ),
    ],
    other: Annotated[
        str,
        typer.Argument(metavar="B", help="Likewise.", autocompletion=options.offered("captures")),
    ],
    output: Annotated[
        Path | None,
        typer.Option("--output", "-o", metavar="FILE.svg|png|pdf", help="Draw both staves."),
    ] = None,
    parts: Annotated[
        str | None, typer.Option("--parts", metavar="PART,...", help="Only these tracks.")
    ] = None,
    tolerance: options.Tolerance = 0.1,
    bars: Annotated[
        int | None,
        typer.Option("--bars", metavar="N", min=1, help="Bars, or five seconds, a staff: 4."),
    ] = None,
    scale: Annotated[
        float | None, typer.Option("--scale", metavar="N", min=0.1, max=20.0, help="How large: 1.")
    ] = None,
    profile: options.OwnProfile = None,
    force: Annotated[bool, typer.Option("--force", help="Replace a file that is there.")] = False,
    db: options.Db = options.DB,
    json: options.Json = False,
    quiet: options.Quiet = False,
    verbose: options.Verbose = False,
    color: options.Color = "auto",
) -> None:
    """Say what two captures or scores differ in, symbol by symbol.

    Symbols of a track are laid beside each other in their order, so that as few as can be are left
    out, added or replaced; those that are the same but at another time are moved; not seen is what
    stands where the other lost the part. Tracks that only one of the two has are named, and not
    compared. Exits with 0 where nothing differs, else 1.
    """
    out = Output(json, quiet, verbose, color)
    if output is None and not (bars is None and scale is None):
        raise UsageError("--bars and --scale", wanted="--output beside them")
    from lanindex.compare import compare
    from lanindex.pipeline.files import write_all

    found = [named.found(out, it, db, options.reading(None, None, None, None), profile, None)
             for it in (one, other)]  # fmt: skip
    scores = [_stretch(it) for it in found]
    wanted = None if parts is None else [part.strip() for part in parts.split(",")]
    compared = compare(*scores, parts=wanted, tolerance=tolerance)
    if output is not None:
        content = _drawn(out, output, found, scores, compared, wanted, bars, scale or 1.0)
        write_all([(output, content)], force=force, sources=[it.path for it in found])
    if json:
        from lanindex import records

        for it in compared.differences:
            out.record(records.of_difference(it))
    elif compared.differences:
        out.table(("part", "A", "seconds", "B", "seconds", "B is"), _rows(compared.differences))
    _summary(out, found, compared)
    if compared.differences:
        raise typer.Exit(1)


def _stretch(one: Named) -> Score:
    from lanindex.notation.excerpt import excerpt

    return excerpt(one.score, one.span)


def _rows(differences: Sequence[Difference]) -> Iterator[tuple[str, ...]]:
    for it in differences:
        yield (it.part, *_cells(it.one), *_cells(it.other), _how(it))


def _cells(it: Timed | None) -> tuple[str, str]:
    return ("", "") if it is None else (it.symbol.words, f"{it.start:.2f}-{it.stop:.2f}")


def _how(it: Difference) -> str:
    if it.kind != "moved":
        return it.kind
    later, longer = round(it.later, 2), round(it.longer, 2)
    told = [
        f"{abs(seconds):.2f} s {words[seconds > 0]}"
        for seconds, words in ((later, ("earlier", "later")), (longer, ("shorter", "longer")))
        if seconds
    ]
    return ", ".join(told)


def _drawn(
    out: Output,
    target: Path,
    found: Sequence[Named],
    scores: Sequence[Score],
    compared: Comparison,
    parts: list[str] | None,
    bars: int | None,
    scale: float,
) -> bytes:
    """Return both staves, with bands over what differs."""
    from lanindex.draw.score import BARS, both
    from lanindex.draw.svg import FORMS, rendered

    form = target.suffix.lower().removeprefix(".")
    if form not in FORMS:
        raise UsageError(f'"{target}"', place="--output", wanted="an ending of svg, png or pdf")
    differ = compared.differences
    marked = [
        [it.one.symbol for it in differ if it.one],
        [it.other.symbol for it in differ if it.other],
    ]
    same = found[0].counted and found[1].counted and scores[0].meter == scores[1].meter
    picture = both(
        scores,
        marked,
        titles=[it.title for it in found],
        parts=parts,
        bars=bars or BARS,
        seconds=not same,
    )
    for warning in picture.warnings:
        out.note(warning)
    return rendered(picture, form, scale)


def _summary(out: Output, found: Sequence[Named], compared: Comparison) -> None:
    from lanindex.app.formatting import counted

    for it, only in zip(found, compared.only, strict=True):
        if only:
            more = f" and {len(only) - _MOST} more" if len(only) > _MOST else ""
            out.note(f"only {it.title} tells of {', '.join(only[:_MOST])}{more}")
    count, tracks = len(compared.differences), counted(len(compared.parts), "track")
    same = counted(compared.same, "symbol")
    out.note(f"{counted(count, 'difference')} in {tracks}, {same} the same")
