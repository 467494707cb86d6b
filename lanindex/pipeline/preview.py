"""Hits to look at, on a sheet or on a page: each of their captures is read once."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Iterator, Sequence
from fractions import Fraction
from functools import partial
from pathlib import Path

from lanindex.draw.svg import image
from lanindex.errors import LanindexError, UsageError
from lanindex.film.figure import Figure, figure
from lanindex.film.hits import PAGE_HITS, RATE, SHEET_HITS, HitPreview, HitPreviews, page, sheet
from lanindex.library.store import Store
from lanindex.model import Capture, Hit, Score
from lanindex.model.derived import STEP
from lanindex.pipeline.playing import stored_motion
from lanindex.search.hits import Hits

FORMS = {"png": SHEET_HITS, "svg": SHEET_HITS, "html": PAGE_HITS}
"""What hits can be shown as, and how many of them where nobody says."""

Watch = Callable[[str, int, int], None]


def form_of(path: Path) -> str:
    """Return as what hits are shown in a file, by its ending."""
    form = path.suffix.lower().removeprefix(".")
    if form not in FORMS:
        raise UsageError(f'"{path}"', place="--preview", wanted="an ending of png, svg or html")
    return form


def preview(
    library: Store, hits: Hits, path: Path, watch: Watch = lambda *told: None
) -> Iterator[tuple[Path, bytes, list[str]]]:
    """Yield the files that show hits, and of each what cannot be seen."""
    form = form_of(path)
    each = len(hits) if form == "html" else SHEET_HITS
    for first in range(0, len(hits), each):
        some = list(hits[first : first + each])  # each is made when it is looked at
        shots = _shots(library, some, partial(_passed, watch, first, len(hits)))
        troubles = [f"{it.path} {it.when}: {it.trouble}" for it in shots if it.trouble]
        number = first // each + 1
        own = path if number == 1 else path.with_stem(f"{path.stem}-{number}")
        if form == "html":
            yield own, page(shots, hits.pattern).encode(), troubles
        else:
            text = sheet(shots, hits.pattern)
            yield own, text.encode() if form == "svg" else image(text), troubles


def _passed(watch: Watch, before: int, total: int, done: int) -> None:
    watch("hits", before + done, total)


def _shots(library: Store, hits: Sequence[Hit], watch: Callable[[int], None]) -> list[HitPreview]:
    """Return hits to look at, in their order; each capture is read once, and let go of."""
    found: dict[int, HitPreview] = {}
    where = defaultdict[int, list[int]](list)
    for number, hit in enumerate(hits):
        where[hit.capture.id].append(number)
    for numbers in where.values():
        capture = hits[numbers[0]].capture
        shots = HitPreviews(_score(library, capture, [hits[number] for number in numbers]))
        body, trouble = _body(library, capture)
        for number in numbers:
            found[number] = shots.shot(hits[number], body, trouble)
        watch(len(found))
    return [found[number] for number in range(len(hits))]


def _score(library: Store, capture: Capture, hits: Sequence[Hit]) -> Score:
    """Return what a capture's score says of the parts that matched."""
    parts = {symbol.part for hit in hits for symbol in hit.symbols}
    if STEP in parts:  # they are drawn as what the feet do
        parts |= {"r_support", "l_support"}
    ((_, tracks),) = library.tracks([capture.id], sorted(parts))
    return Score(capture.rate, capture.frames, capture.meter, tracks)


def _body(library: Store, capture: Capture) -> tuple[Figure | None, str]:
    """Return what moves in a capture, or why nothing does."""
    try:
        return figure(stored_motion(library, capture, Fraction(RATE))), ""
    except LanindexError as error:
        return None, f"{error.found}. {error.remedy}".removesuffix(". ")
