"""The stick figure of a capture, a window at a time.

The figure of a capture is worked out once and kept (`lanindex.pipeline.kept`); windows are read
from there. While that of a large file is being worked out, windows come from the file itself where
its format tells some frames without all others.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterable, Mapping
from concurrent.futures import Future
from contextlib import suppress
from dataclasses import dataclass, field, replace
from fractions import Fraction
from functools import partial
from math import ceil
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lanindex import formats, locations
from lanindex.draw.staff import last_second
from lanindex.errors import CaptureError, ExportError, UsageError
from lanindex.film.figure import Figure, figure
from lanindex.formats.file import on_disk
from lanindex.library.store import Store
from lanindex.model import Capture, Motion, Reading
from lanindex.notation import NOTATIONS
from lanindex.perform import perform
from lanindex.perform.stage import LONGEST
from lanindex.pipeline.export import check_source, source_of
from lanindex.pipeline.kept import CACHE, Cache, Kept, Latest, Made

PERFORMED = Fraction(60)
"""Frames a second in which a score is performed."""

MANY = 1000
"""Symbols from which on a score is performed by another process: each takes a third of a ms."""

STRETCHES = Latest["Figure | None"](8)
"""Windows that were read without all others: the first one is asked for twice."""


def motion(
    store: Store,
    which: int | str,
    start: float = 0.0,
    stop: float | None = None,
    fps: float | Fraction | None = None,
    cache: Cache = CACHE,
    *,
    wait: bool = True,
) -> Figure:
    """Return the figure of a capture in a window: see `lanindex.Library.motion`.

    Without `wait`, that of a large file may come before it is known to be the one that was
    ingested: `check` tells.
    """
    capture = store.capture(which)
    performed, rate = capture.format in NOTATIONS, rate_of(capture)
    stop = last_second(float(capture.frames / capture.rate), start, stop)
    shown, rate_shown = frames_shown(start, stop, rate, fps)
    if performed:
        library = store.session.target
        long = sum(store.counts(capture.id).values()) > MANY and not library.in_memory
        opened = {"library": str(library.name), "path": capture.path}
        where = opened if long else {"store": store}
        job: dict[str, Any] = {**where, "capture": capture.id}
        key, work = ("performed", capture.location, capture.sha256), aside if long else _performed
        return _window(cache.get(key, work, job, aside=long), shown, rate_shown)
    source = SOURCES.of(store, capture)
    key, large = ("figure", *source.key), source.large
    job = {"path": capture.location, "options": source.options, "frames": capture.frames}
    if large is None:
        return _window(cache.get(key, figured, job, aside=False), shown, rate_shown)
    body = None
    reading = replace(source.reading, rate=rate)  # which the times of some frames do not tell
    if not cache.holds(key):  # first: a process would slow it
        window = *key, *source.states.items(), int(shown[0]), int(shown[-1]), rate_shown
        body = STRETCHES.made(
            window, lambda: _stretch(large, reading, shown, rate_shown, capture.frames)
        )
    if body is not None and not wait and not source.same.done():
        begin = partial(cache.begin, key, figured, job, aside=True)
        source.same.add_done_callback(lambda same: same.exception() or begin())
        return body
    source.check()
    made = cache.begin(key, figured, job, aside=True)
    return body or _window(made.result(), shown, rate_shown)


def check(store: Store, which: int | str) -> None:
    """Raise where the source of a capture is gone or has changed since it was ingested."""
    capture = store.capture(which)
    if capture.format not in NOTATIONS:
        SOURCES.of(store, capture).check()


def frames_shown(
    start: float, stop: float, rate: Fraction, fps: float | Fraction | None
) -> tuple[NDArray[np.int64], Fraction]:
    """Return the frames of a source that a window shows, and how many a second.

    They are counted from the beginning of the source, so that windows fit together.
    """
    if fps is not None and not 0 < fps < float("inf"):
        raise UsageError(f"{fps} frames a second", wanted="more than 0")
    wanted = rate if fps is None else min(Fraction(fps).limit_denominator(10**6), rate)
    first, last = (ceil(it * float(wanted) - 1e-6) for it in (start, stop))
    over, under = (rate / wanted).as_integer_ratio()
    return np.arange(first, max(last, first + 1)) * over // under, wanted


def figured(path: str, options: Mapping[str, str], frames: int) -> Made:
    """Return the figure of a file as it is kept."""
    motion = formats.read_file(formats.opened(path), Reading(**options), formats.Wanted(True))
    if len(motion) != frames:
        found, remedy = "reads otherwise than when it was ingested", "Ingest it again."
        wanted = f"{frames} frames, not {len(motion)}"
        raise ExportError(found, place=path, wanted=wanted, remedy=remedy)
    return _made(motion)


def rate_of(capture: Capture) -> Fraction:
    """Return the frames a second of a capture's figure; a long score has as many as it may."""
    if capture.format not in NOTATIONS:
        return capture.rate
    return min(PERFORMED, Fraction(max((LONGEST - 1) * capture.rate // capture.frames, 1)))


def aside(library: str, path: str, capture: int) -> Made:
    """Return the figure of a score of a library, in a process of its own; `path` is for errors."""
    with Store.open(library, readonly=True) as store:
        return _performed(store, capture)


def _performed(store: Store, capture: int) -> Made:
    score = store.score(capture)
    return _made(perform(score, rate=rate_of(store.capture(capture))))


def _made(motion: Motion) -> Made:
    body = figure(motion)
    about = {"parts": body.parts, "bones": body.bones.tolist()}
    return about, {"places": body.places, "fronts": body.fronts}


def _window(kept: Kept, shown: NDArray[np.int64], rate: Fraction) -> Figure:
    """Return some frames of a figure that is kept."""
    first, stop = int(shown[0]), int(shown[-1]) + 1
    places, fronts = (kept.window(name, first, stop) for name in ("places", "fronts"))
    some = np.minimum(shown - first, len(places) - 1)  # a score may end between two frames
    bones, parts = np.array(kept.about["bones"], np.int64), tuple(kept.about["parts"])
    return Figure(places[some], bones, parts, rate, fronts[some])


def _stretch(
    file: formats.File, reading: Reading, shown: NDArray[np.int64], rate: Fraction, count: int
) -> Figure | None:
    """Return some frames of a figure, read without all others; None: its format needs them."""
    wanted = formats.Wanted(True, (int(shown[0]), int(shown[-1]) + 1))
    ranged = formats.ranged(file, reading)
    if ranged is None:
        return None
    body = figure(formats.read_file(file, reading, wanted))
    some = np.searchsorted(ranged(wanted, count), shown)
    return replace(body, places=body.places[some], fronts=body.fronts[some], rate=rate)


@dataclass(frozen=True, slots=True)
class Source:
    """The file of a capture, which is as it was when it was ingested, and how it is read."""

    key: tuple[Any, ...]  # what tells what is read from all else
    options: Mapping[str, str]
    reading: Reading
    states: Mapping[str, locations.Mark]  # of the files that are read, what changes when one does
    large: formats.File | None  # the file, if it is large and not held in memory
    checking: Callable[[], Any]  # raises if it is not the file that was ingested
    same: Future[None] = field(default_factory=Future)  # the outcome of `checking`
    turn: threading.Lock = field(default_factory=threading.Lock)

    def check(self) -> None:
        """Raise where it is not the file that was ingested; of a large one that takes time."""
        with self.turn:
            if not self.same.done():
                try:
                    self.checking()
                    self.same.set_result(None)
                except Exception as error:
                    self.same.set_exception(error)
        self.same.result()


class Sources:
    """The files of captures, looked through once and then only asked whether they changed."""

    def __init__(self) -> None:
        self._known: dict[tuple[Any, ...], Source] = {}
        self._lock = threading.Lock()

    def of(self, store: Store, capture: Capture) -> Source:
        """Return the source of a capture; an error says that it is gone or has changed."""
        encoding = store.encoding(capture.id)
        options = dict(sorted(encoding.options.items()))
        key = capture.location, capture.sha256, encoding.beside, *options.items()
        with self._lock:
            known = self._known.get(key)
        if known is not None and known.states == _states(known.states):
            return known
        before = _states([on_disk(capture.location)])
        large, reading = None, Reading(**options)
        with suppress(CaptureError):  # `source_of` says what is wrong with it
            file = formats.opened(capture.location)
            large = None if isinstance(file.content, bytes) else file
        if large is None:
            file, reading = source_of(store, capture)
        beside = [on_disk(it.name) for it in formats.companions(file, reading)]
        states, checking = before | _states(beside), partial(check_source, capture, encoding, large)
        found = Source(key, options, reading, states, large, checking)
        if large is None:
            found.same.set_result(None)
        with self._lock:
            while len(self._known) >= MOST:
                del self._known[next(iter(self._known))]
            self._known[key] = found
        return found


MOST = 1024
"""Sources that are remembered."""

SOURCES = Sources()


def _states(paths: Iterable[str]) -> dict[str, locations.Mark]:
    """Return of files what changes when one does; of one that is gone nothing."""
    found = dict[str, locations.Mark]()
    for path in paths:
        with suppress(OSError, CaptureError):  # `source_of` says what is wrong with it
            found[path] = locations.mark(path)
    return found
