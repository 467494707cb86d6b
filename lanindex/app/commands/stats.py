"""``lanindex stats``: what the library holds."""

from __future__ import annotations

from dataclasses import asdict

from lanindex.app import options
from lanindex.app.output import Output


def run(
    db: options.Db = options.DB,
    json: options.Json = False,
    quiet: options.Quiet = False,
    verbose: options.Verbose = False,
    color: options.Color = "auto",
) -> None:
    """Say what the library holds."""
    out = Output(json, quiet, verbose, color)
    from lanindex.alphabet import TRACKS
    from lanindex.app.formatting import duration
    from lanindex.pipeline import open_library

    with open_library(db, readonly=True) as library:
        found = library.stats()
    if json:
        out.record(asdict(found))
        return
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
