"""Films and pictures of hits: the motion of what is shown, and the files that show it."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Iterator, Sequence
from fractions import Fraction
from functools import partial
from pathlib import Path

from lanindex import formats
from lanindex.draw.svg import image
from lanindex.errors import LanindexError, UsageError
from lanindex.film.figure import Figure, figure
from lanindex.film.film import RATE as FILM_RATE
from lanindex.film.film import RATES, Film
from lanindex.film.hits import PAGE_HITS, RATE, SHEET_HITS, HitPreview, HitPreviews, page, sheet
from lanindex.library.store import Store
from lanindex.model import Capture, Hit, Motion, Reading, Score, Span
from lanindex.model.derived import STEP
from lanindex.notation import NOTATIONS
from lanindex.perform import perform
from lanindex.pipeline import convert
from lanindex.pipeline.export import Request, matched, unchanged
from lanindex.pipeline.named import Named, counts_beats
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
    store: Store, hits: Hits, path: Path, watch: Watch = lambda *done: None
) -> Iterator[tuple[Path, bytes, list[str]]]:
    """Yield the files that show hits, and of each what cannot be seen."""
    form = form_of(path)
    each = len(hits) if form == "html" else SHEET_HITS
    for first in range(0, len(hits), each):
        some = list(hits[first : first + each])  # each is made when it is looked at
        shots = _shots(store, some, partial(_passed, watch, first, len(hits)))
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


def _shots(store: Store, hits: Sequence[Hit], watch: Callable[[int], None]) -> list[HitPreview]:
    """Return hits to look at, in their order; each capture is read once, and let go of."""
    found: dict[int, HitPreview] = {}
    where = defaultdict[int, list[int]](list)
    for number, hit in enumerate(hits):
        where[hit.capture.id].append(number)
    for numbers in where.values():
        capture = hits[numbers[0]].capture
        shots = HitPreviews(_score(store, capture, [hits[number] for number in numbers]))
        body, trouble = _body(store, capture)
        for number in numbers:
            found[number] = shots.shot(hits[number], body, trouble)
        watch(len(found))
    return [found[number] for number in range(len(hits))]


def _score(store: Store, capture: Capture, hits: Sequence[Hit]) -> Score:
    """Return what a capture's score says of the parts that matched."""
    parts = {symbol.part for hit in hits for symbol in hit.symbols}
    if STEP in parts:  # they are drawn as what the feet do
        parts |= {"r_support", "l_support"}
    ((_, tracks),) = store.tracks([capture.id], sorted(parts))
    return Score(capture.rate, capture.frames, capture.meter, tracks)


def _body(store: Store, capture: Capture) -> tuple[Figure | None, str]:
    """Return what moves in a capture, or why nothing does."""
    try:
        return figure(stored_motion(store, capture, Fraction(RATE))), ""
    except LanindexError as error:
        return None, f"{error.found}. {error.remedy}".removesuffix(". ")


def stored_motion(store: Store, capture: Capture, rate: Fraction) -> Motion:
    """Return the motion of a capture of a library, read anew from its file."""
    if capture.format in NOTATIONS:
        return perform(store.score(capture.id), rate=rate)
    encoding = store.encoding(capture.id)
    file, reading = unchanged(capture, encoding), Reading(**encoding.options)
    return formats.read_file(file, reading, formats.Wanted(body_only=True))


class Previews:
    """Films of the clips of one capture."""

    def __init__(self, store: Store, capture: Capture, form: str) -> None:
        self.capture, self.form, self.rate = capture, form, RATES.get(form, FILM_RATE)
        self.score = store.score(capture.id)
        self.figure = figure(stored_motion(store, capture, self.rate))

    def film(self, span: Span, request: Request) -> bytes:
        """Return the film of a clip, what matched in colour."""
        start, stop = (float(it / self.capture.rate) for it in (span.start, span.stop))
        beats = counts_beats(self.capture.format, self.score)
        marked = matched(self.score, request)
        film = Film(
            self.figure,
            self.score,
            start=start,
            stop=stop,
            rate=self.rate,
            marked=marked,
            seconds=not beats,
        )
        return film.written(self.form)


def motion_of(found: Named, store: Callable[[], Store], reading: Reading, rate: Fraction) -> Motion:
    """Return the motion of what a person names."""
    if found.format in NOTATIONS:
        return perform(found.score, rate=rate)
    if found.capture is None:
        return convert.motion_of(Path(found.path), reading, body_only=True)
    with store() as opened:
        return stored_motion(opened, found.capture, rate)
