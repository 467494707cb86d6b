"""What a verb's argument names: a capture, a hit or a stretch of one, a file."""

from __future__ import annotations

from typing import TYPE_CHECKING

from lanindex.app import options
from lanindex.app.output import Output

if TYPE_CHECKING:
    from lanindex.model import Reading
    from lanindex.pipeline.named import Named


def found(
    out: Output, text: str, db: str, told: Reading, profile: str | None, tempo: str | None
) -> Named:
    """Return what is named, and say what its reader has to say of a file."""
    from lanindex.pipeline import open_library
    from lanindex.pipeline.named import named

    one = named(
        options.one_line(text),
        lambda: open_library(db, readonly=True),
        told,
        profile=profile,
        tempo=tempo,
    )
    for warning in () if one.capture else one.score.warnings:
        out.note(f"{one.path}: {warning}")
    return one
