"""The verbs for the library and its captures: list, show, remove, db."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable
from itertools import chain
from pathlib import Path
from typing import IO, TYPE_CHECKING

import lanindex
from lanindex import records
from lanindex.app import options
from lanindex.app.options import captures, dependent, exclusive, flag
from lanindex.app.output import Output, duration, print_staff, room
from lanindex.errors import LibraryError, UsageError, counted

if TYPE_CHECKING:
    from lanindex.library.migrate import Status
    from lanindex.model import Capture, Track
    from lanindex.pipeline.library import Library

CAPTURES_ON_TERMINAL = 1000  # captures that a terminal shows of a library
MEASURES_WIDTH = 94  # columns of a terminal that has room for measures


def list_captures(
    *,
    selection: options.Selected,
    doubts: bool = flag("--doubts", "Only those that were doubtful to read, and why."),
    db: options.Db = options.DB,
    out: options.Out,
) -> int:
    """List the captures in the library."""
    with options.opened(db, out) as library:
        numbers = library.store.numbers(selection)
        if doubts:
            captures = [it for it in library.store.each(numbers) if it.warnings]
            count, seconds = len(captures), sum(_seconds(it) for it in captures)
            _doubts(out, captures)
        else:
            roster, _ = library.store.columns([], numbers)
            count, rates = len(roster), roster.rate[:, 0] / roster.rate[:, 1]
            seconds = float((roster.frames / rates).sum())
            numbers = roster.number[: CAPTURES_ON_TERMINAL if out.terminal else None].tolist()
            if count:
                _table(out, library.store.each(numbers))
    shown = f"; the first {CAPTURES_ON_TERMINAL:,} are shown, a pipe or --json has all"
    cut = out.terminal and not doubts and count > CAPTURES_ON_TERMINAL
    out.note(f"{counted(count, 'capture')}, {duration(seconds)}{shown if cut else ''}")
    return not count


def _seconds(capture: Capture) -> float:
    """Return how long a capture is: as fractions divide, but in a fifth of the time."""
    return capture.frames * capture.rate.denominator / capture.rate.numerator


def _table(out: Output, captures: Iterable[Capture]) -> None:
    """Print a line for each capture; only those of a terminal are in memory together."""
    captures = list(captures) if out.terminal else captures
    folder = out.folder(it.path for it in captures) if out.terminal else ""
    rows = (
        (
            it.id,
            it.path.removeprefix(folder),
            it.label,
            f"{float(it.rate):g}",
            it.frames,
            f"{_seconds(it):.2f}",
        )
        for it in captures
    )
    head = ("id", "path", "label", "fps", "frames", "seconds")
    out.table(head, rows, map(records.of_capture, captures))


def _doubts(out: Output, captures: list[Capture]) -> None:
    """Print what was doubtful in captures: on a terminal, the captures of each doubt."""
    folder = out.folder(capture.path for capture in captures)
    if out.json:
        out.records(map(records.of_capture, captures))
    elif out.terminal:
        doubtful: dict[str, list[str]] = defaultdict(list)
        for capture in captures:
            for warning in capture.warnings:
                doubtful[warning].append(capture.path.removeprefix(folder))
        for warning, those in doubtful.items():
            out.line(warning)
            for path in those:
                out.line("  ", out.paint(path, "path"))
    else:
        for capture in captures:
            for warning in capture.warnings:
                out.row([capture.id, capture.path, warning])


def show(
    capture: str | None = captures(None, "CAPTURE", "Its number, path or end of path."),
    everything: bool = flag("--all", "All captures."),
    part: options.Part = None,
    staff: bool = flag("--staff", "Draw a staff, time downwards."),
    *,
    selection: options.Where,
    output: Path | None = options.output("FILE", "Write a table: .csv, .jsonl or .parquet."),
    force: options.Force = False,
    db: options.Db = options.DB,
    out: options.Out,
) -> int:
    """Show the symbols of a capture.

    A star marks what is only passed on the way; it stands in no score. Speed is the highest, in
    lengths of the part per second; size is the angle in degrees between where the part pointed
    and where it points. A table (--output) has a row for each symbol, with the keys of --json.
    """
    if (capture is None) != everything:
        raise UsageError("no capture" if capture is None else "a capture and --all", wanted="one")
    dependent("--where", selection.globs, on="--all", given=everything)
    exclusive("--staff", staff, {"--json": out.json})
    dependent("--force", force, on="--output", given=output)
    if output is not None and (out.json or staff):
        raise UsageError("--output beside --json or --staff", wanted="one of them")
    from lanindex.notation import TABLES

    form = options.ending(output, list(TABLES)) if output else ""
    with lanindex.open_library(db, readonly=True) as library:
        numbers = None
        if capture is not None:
            numbers = [library.capture(options.capture_id(capture)).id]
        elif selection.globs:
            numbers = library.store.numbers(selection)
        if part:
            library.store.check_parts(part)
        # a staff needs the other parts, too: feet that hold the weight
        captures = library.tracks(numbers, None if staff else part)
        if everything:
            count = library.store.capture_count() if numbers is None else len(numbers)
            captures = out.progress(captures, count, "captures")
        symbols = 0
        if output is not None:
            symbols = _save(output, form, captures, force)
            if not symbols:
                return 1
        for found, tracks in captures:  # none is left where they were saved
            shown = [it for it in tracks if len(tracks[it]) and it in (part or tracks)]
            symbols += sum(len(tracks[it]) for it in shown)
            if not staff:
                _show(out, found, tracks)
            elif shown:
                print_staff(out, found, tracks, part and shown)
    out.note(counted(symbols, "symbol"))
    return not symbols


def _save(
    output: Path, form: str, captures: Iterable[tuple[Capture, dict[str, Track]]], force: bool
) -> int:
    """Write symbols into a table as they come, and return their number; none: no file."""
    from lanindex.notation import TABLES
    from lanindex.notation.tables import rows_in
    from lanindex.pipeline.files import refuse, write_all

    refuse(output, force=force)
    rows = (row for capture, tracks in captures for row in rows_in(capture, tracks))
    first, count = next(rows, None), 0
    if first is None:
        return 0

    def write(file: IO[bytes]) -> None:
        nonlocal count
        count = TABLES[form].member("save")(chain([first], rows), file)

    write_all([(output, write)], force=force)
    return count


def _show(out: Output, capture: Capture, tracks: dict[str, Track]) -> None:
    """List the symbols of a capture's tracks."""
    from lanindex.alphabet import MEASURES

    symbols = [symbol for track in tracks.values() for symbol in track.listed()]
    if out.json:
        return out.records(records.of_row(capture, symbol) for symbol in symbols)
    more = MEASURES if not out.terminal or room() >= MEASURES_WIDTH else ()
    rows = []
    for symbol in symbols:
        record = records.of_row(capture, symbol)
        words = f"{symbol.words}{'*' if symbol.passing else ''}"
        frames = f"{symbol.span.start}-{symbol.span.stop}"
        seconds = f"{record['start']:.2f}-{record['end']:.2f}"
        row = [symbol.part, words, frames, seconds, f"{symbol.margin:.2f}", symbol.swings or ""]
        row.append(record["runner_up"] or "")
        for measure in (getattr(symbol, name) for name in more):
            row.append(f"{measure:.2f}" if isinstance(measure, float) else measure)
        rows.append(["" if cell is None else cell for cell in row])
    out.line(out.paint(capture.path, "path"))
    out.table(("part", "symbol", "frames", "seconds", "margin", "swings", "else", *more), rows)


def remove(
    captures: list[str] | None = captures(
        None, "CAPTURE...", "Their numbers, paths or ends of paths."
    ),
    missing: bool = flag("--missing", "All whose file is no longer there."),
    *,
    selection: options.Selected,
    dry_run: bool = flag("--dry-run", "Say what would be removed; change nothing."),
    db: options.Db = options.DB,
    out: options.Out,
) -> int:
    """Remove captures from the library, all or none; their files stay.

    Exits with 1 if there is nothing to remove.
    """
    exclusive("captures", captures, {"--missing": missing})
    if not (captures or missing or selection.globs):
        raise UsageError("nothing to remove", wanted="captures, --in, --where or --missing")
    with lanindex.open_library(db, readonly=dry_run) as library:
        # a damaged capture can be removed by its number, but neither shown nor filtered
        readable = dry_run or bool(selection.globs)
        chosen, damaged = _captures_by_name(library, captures or [], readable)
        if not damaged:
            found = library.captures(selection)
            wanted = {it.id for it in (chosen if captures else library.store.missing())}
            chosen = [it for it in found if it.id in wanted or not (captures or missing)]
        if not dry_run:
            library.remove(*damaged, *(capture.id for capture in chosen))
    if chosen:
        rows = ((capture.id, capture.path) for capture in chosen)
        out.table(("id", "path"), rows, map(records.of_capture, chosen))
    gone = len(chosen) + len(damaged)
    out.note(f"{counted(gone, 'capture')} {'would be ' if dry_run else ''}removed")
    return not gone


def _captures_by_name(
    library: Library, names: list[str], readable: bool
) -> tuple[list[Capture], list[int]]:
    """Return the named captures, and the numbers of damaged ones unless all must be `readable`."""
    found: dict[int, Capture] = {}
    damaged: list[int] = []
    for which in map(options.capture_id, names):
        try:
            capture = library.capture(which)
            found[capture.id] = capture
        except LibraryError:
            if readable or not isinstance(which, int):
                raise
            damaged.append(which)  # if it does not exist, the removal says so
    return list(found.values()), damaged


def status(db: options.Db = options.DB, *, out: options.DbOut) -> int:
    """Say whether the library fits this program; exits with 1 if it is older or newer."""
    from lanindex.library import migrate

    status = migrate.status(db)
    _print_status(out, status)
    return status.state != "current"


def upgrade(db: options.Db = options.DB, *, out: options.DbOut) -> None:
    """Bring the library to this program's revision; its content stays."""
    from lanindex.library import migrate

    _print_status(out, migrate.upgrade(db))


def check(db: options.Db = options.DB, *, out: options.DbOut) -> int:
    """Look for damage; exits with 1 if there is any."""
    from lanindex.library import migrate
    from lanindex.library.connect import target

    damage, place = migrate.check(db, out.watch), target(db).place
    for sentence in damage:
        out.row([sentence], {"damage": sentence})
    out.note(f"{place}: {len(damage) or 'no'} damage{'s' if len(damage) > 1 else ''} found")
    return bool(damage)


def segments(
    where: str | None = options.argument(
        None, "FOLDER|URL", "Where to keep the columns; a folder is named from the library's own."
    ),
    inside: bool = flag("--inside", "Keep the columns in the library again."),
    db: options.Db = options.DB,
    *,
    out: options.DbOut,
) -> None:
    """Say where the columns are, or keep them elsewhere, for many machines to read.

    What searches read is then in files that never change: in a folder, or in a bucket that fsspec
    knows (pip install 'lanindex[remote]'). A place belongs to one library. Machines keep copies of
    a bucket's files in ~/.cache/lanindex, or where LANINDEX_CACHE says.
    """
    exclusive("a folder or URL", where, {"--inside": inside})
    from lanindex.library import migrate
    from lanindex.library.connect import target

    if where or inside:
        migrate.keep_columns(db, where or "", out.note)
    library, (place, files, size) = target(db).place, migrate.files_of_columns(db)
    if out.json:
        values = {"place": place or None, "files": files, "size": size}
        return out.record({"library": library, **values})
    told = f"{place}, {counted(files, 'file')}, {size / 1e6:.1f} MB" if place else "the library"
    out.line(f"{library}: columns in {told}")


def copy(
    source: str = options.argument(..., "FROM", "The library, a path or URL."),
    to: str = options.argument(..., "TO", "A new one, a path or URL."),
    *,
    out: options.DbOut,
) -> None:
    """Copy a library into a new one: into PostgreSQL, out of it, or into another file.

    All captures keep their numbers, so both answer alike; their files stay where they are.
    """
    from lanindex.library.copy import copy

    count = copy(source, to, out.note, out.watch)
    out.note(f"{counted(count, 'capture')} copied")


db = {
    **{"status": status, "upgrade": upgrade, "check": check, "copy": copy},
    **{"segments": segments},
}


def _print_status(out: Output, status: Status) -> None:
    if out.json:
        keys = ("newest", "state", "segments", "symbols", "pending", "fault")
        values = {key: getattr(status, key) for key in keys}
        return out.record({"library": status.place, "revision": status.revision, **values})
    out.line(f"{status.place}: revision {status.revision}, {status.state}")
    if status.state != "current":
        return
    columns = f"{status.fault}; the next search or ingest makes them anew"
    if not status.fault:
        symbols, segments = counted(status.symbols, "symbol"), counted(status.segments, "segment")
        waiting = f"; {counted(status.pending, 'capture')} not in them yet"
        columns = f"{symbols} in {segments}{waiting if status.pending else ''}"
    out.line(f"columns: {columns}")
