"""``lanindex db``: look after the library."""

from __future__ import annotations

from typing import TYPE_CHECKING

import typer

from lanindex.app import options
from lanindex.app.cli import SETTINGS
from lanindex.app.output import Output

if TYPE_CHECKING:
    from lanindex.library.migrate import Status

app = typer.Typer(help="Look after the library.", no_args_is_help=True, **SETTINGS)


@app.command()
def status(
    db: options.Db = options.DB,
    json: options.Json = False,
    quiet: options.Quiet = False,
    color: options.Color = "auto",
) -> None:
    """Say whether the library fits this program; exits with 1 if it is older or newer."""
    from lanindex.library import migrate

    found = migrate.status(db)
    _say(Output(json, quiet, color=color), found)
    if found.state != "current":
        raise typer.Exit(1)


@app.command()
def upgrade(
    db: options.Db = options.DB,
    json: options.Json = False,
    quiet: options.Quiet = False,
    color: options.Color = "auto",
) -> None:
    """Bring the library to this program's revision; its content stays."""
    from lanindex.library import migrate

    _say(Output(json, quiet, color=color), migrate.upgrade(db))


@app.command()
def check(
    db: options.Db = options.DB,
    json: options.Json = False,
    quiet: options.Quiet = False,
    color: options.Color = "auto",
) -> None:
    """Look for damage; exits with 1 if there is any."""
    out = Output(json, quiet, color=color)
    from lanindex.library import migrate

    found = migrate.check(db)
    for sentence in found:
        if json:
            out.record({"damage": sentence})
        else:
            out.line(sentence)
    out.note(f"{db}: {len(found) or 'no'} damage{'s' if len(found) > 1 else ''} found")
    if found:
        raise typer.Exit(1)


def _say(out: Output, found: Status) -> None:
    if out.json:
        out.record(
            {
                "library": found.place,
                "revision": found.found,
                "newest": found.newest,
                "state": found.state,
                "segments": found.segments,
                "symbols": found.symbols,
                "pending": found.pending,
                "fault": found.fault,
            }
        )
        return
    out.line(f"{found.place}: revision {found.found}, {found.state}")
    if found.state == "current":
        out.line(f"columns: {_columns(found)}")


def _columns(found: Status) -> str:
    from lanindex.app.formatting import counted

    if found.fault:
        return f"{found.fault}; the next search or ingest makes them anew"
    held = f"{counted(found.symbols, 'symbol')} in {counted(found.segments, 'segment')}"
    waiting = f"; {counted(found.pending, 'capture')} not in them yet" if found.pending else ""
    return held + waiting
