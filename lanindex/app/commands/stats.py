"""``lanindex stats``: what the library holds, and how movement is spread in it."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from lanindex.app import options
from lanindex.app.output import Output
from lanindex.errors import UsageError

if TYPE_CHECKING:
    from lanindex.library.stats import Stats
    from lanindex.pipeline.movement import Movement


def run(
    by: Annotated[
        str | None,
        typer.Option(metavar="COLUMN", help="How movement is spread, by label or another column."),
    ] = None,
    compare: Annotated[
        tuple[str, str] | None, typer.Option(metavar="A B", help="Two of its values alone.")
    ] = None,
    part: Annotated[
        list[str] | None, typer.Option(metavar="PART", help="Only this part; can be repeated.")
    ] = None,
    plot: Annotated[
        Path | None, typer.Option(metavar="FILE.svg|png|pdf", help="Draw it.", readable=False)
    ] = None,
    within: options.In = None,
    where: options.Where = None,
    force: Annotated[
        bool, typer.Option("--force", help="Replace a picture that is there.")
    ] = False,
    db: options.Db = options.DB,
    json: options.Json = False,
    quiet: options.Quiet = False,
    verbose: options.Verbose = False,
    color: options.Color = "auto",
) -> None:
    """Say what the library holds; with --by or --plot, how movement is spread.

    Where each part goes, from where, how often: by group. Of two groups, in what they differ, with
    a capture as one observation, and intervals that hold for all that is looked at together.
    """
    out = Output(json, quiet, verbose, color)
    spread = any((by, part, plot, within is not None, where))
    if compare and not by:
        raise UsageError("--compare", wanted="--by beside it")
    if force and not plot:
        raise UsageError("--force", wanted="--plot beside it")
    from lanindex.pipeline import open_library

    with open_library(db, readonly=True) as library:
        if not spread:
            _held(out, library.stats())
            return
        found = library.movement(
            by=by or "", compared=compare, parts=part or (), within=within,
            where=options.where(where),
        )  # fmt: skip
    if plot:
        from lanindex.pipeline.charts import charted
        from lanindex.pipeline.files import write_all

        content = charted(found, plot.suffix.lower().removeprefix("."))
        write_all([(plot, content)], force=force)
        out.note(str(plot))
    _spread(out, found, compare is not None)
    if not any(found.groups.values()):
        raise typer.Exit(1)


def _held(out: Output, found: Stats) -> None:
    """Say what the library holds."""
    if out.json:
        out.record(asdict(found))
        return
    from lanindex.alphabet import TRACKS
    from lanindex.app.formatting import duration

    rows = [
        ("captures", f"{found.captures}"),
        ("movement", f"{duration(found.seconds)}, {found.frames} frames"),
        ("symbols", f"{found.symbols}"),
        ("size", f"{found.size / 1e6:.1f} MB"),
    ]
    for name, counts in (
        ("format", found.formats),
        ("profile", found.profiles),
        ("label", found.labels),
        ("part", found.parts),
    ):
        rows += [(f"{name} {key or '(none)'}", f"{number}") for key, number in counts.items()]
    rows += [
        (f"coverage {part}", f"{share:.1%}") for part, share in found.coverage.items() if share < 1
    ]
    never = [part for part in TRACKS if part not in found.parts]
    rows += [("in no capture", " ".join(never))] if found.captures and never else []
    out.table(("what", "how much"), rows)


def _spread(out: Output, found: Movement, compared: bool) -> None:
    """Say how movement is spread: a line a group's part, or a difference."""
    pair = tuple(found.groups)
    if out.json:
        for one in found.differences if compared else ():
            out.record(one.record(found.by, (pair[0], pair[1])))
        for moves in () if compared else found.moves:
            out.record(moves.record(found.by))
        return
    from lanindex.pipeline.movement import CELLS

    rows = []
    for moves in found.moves:
        order = (-moves.cells).argsort(kind="stable")[:3].tolist()
        most = ", ".join(f"{CELLS[it]} {moves.cells[it]}" for it in order if moves.cells[it])
        rows.append(
            (moves.group or "(none)", moves.part, moves.captures, int(moves.cells.sum()),
             f"{moves.rate:.2f}", f"{moves.coverage:.0%}", most)
        )  # fmt: skip
    head = (found.by or "group", "part", "captures", "moves", "a second", "known", "most often")
    out.table(head, rows)
    if len(pair) == 2:
        out.line()
        _differences(out, found, (pair[0] or "(none)", pair[1] or "(none)"))


def _differences(out: Output, found: Movement, pair: tuple[str, str]) -> None:
    rows = []
    for one in found.differences:
        if not one.matters:
            continue
        unit, factor = ("/s", 1) if one.what == "rate" else ("%", 100)
        numbers = [f"{it * factor:.{2 if unit == '/s' else 1}f}" for it in
                   (*one.values, one.values[1] - one.values[0], one.least, one.most)]  # fmt: skip
        rows.append(
            (one.part, one.what, *(f"{it} {unit} ({count})" for it, count in
             zip(numbers, one.movements, strict=False)),
             f"{numbers[2]} {unit}", f"{numbers[3]} to {numbers[4]}", f"{one.p:.3f}")
        )  # fmt: skip
    if rows:
        out.table(("part", "where", *pair, "difference", "95% interval", "p"), rows)
    out.note(
        f"{len(rows)} of {len(found.differences)} differences matter: means over captures, the "
        "number of movements in brackets; intervals and p hold for all of them together"
    )
