"""How well patterns tell labelled captures apart: precision, recall and F1.

A capture counts as found if a pattern has at least one hit in it.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from fnmatch import fnmatchcase
from fractions import Fraction
from functools import partial
from itertools import chain, pairwise
from pathlib import Path
from typing import TYPE_CHECKING, Any

from lanindex import records
from lanindex.errors import LanindexError, PatternError, UsageError, quoted, shown
from lanindex.library.connect import Progress, no_progress
from lanindex.model import Capture, Meter, Score
from lanindex.notation.text import read_toml
from lanindex.pipeline.ingest import Labels, discover, key_of
from lanindex.pipeline.prepare import Task, prepared
from lanindex.pipeline.search import SearchOptions, query_of, searcher
from lanindex.search.language import Query
from lanindex.search.language.score import pattern_in
from lanindex.search.limits import deadline

if TYPE_CHECKING:
    from lanindex.encoding.profile import Profile
    from lanindex.model import Hit, Track
    from lanindex.pipeline.spread import Spread, Tick

BOUND_REMEDY = 'Bound what the patterns try: write "...[<5s]" for "...".'

FEWEST = 64
"""Clips at least that another process searches at once."""

RESAMPLES = 2000  # draws of the bootstrap that estimates the standard error


@dataclass(frozen=True, slots=True)
class Expectation:
    """A pattern, and the labels (or globs: ``walk*``) of the captures that it should find."""

    name: str
    text: str
    query: Query
    positives: frozenset[str]

    def wants(self, label: str) -> bool:
        """Return whether captures of this label should be found."""
        return any(_label_matches(label, positive) for positive in self.positives)

    def unused(self, labels: Iterable[str]) -> list[str]:
        """Return the positives that none of these labels fits, in order."""
        known = set(labels)
        used = {it for it in self.positives for label in known if _label_matches(label, it)}
        return sorted(self.positives - used)


def _label_matches(label: str, positive: str) -> bool:
    return label == positive or (bool(label) and fnmatchcase(label, positive))


@dataclass(frozen=True, slots=True)
class Clip:
    """A labelled capture and its tracks; of an unreadable one, the error."""

    capture: Capture
    tracks: Mapping[str, Track]
    error: str | None


@dataclass(frozen=True, slots=True)
class Miss:
    """A wrongly judged capture: with a hit it should not have, or without one (None)."""

    capture: Capture
    hit: Hit | None
    tracks: Mapping[str, Track]


@dataclass(frozen=True, slots=True)
class Result:
    """What a pattern found, clip by clip; clips that are too rich for it count as not found."""

    expectation: Expectation
    found: tuple[bool, ...]
    wanted: tuple[bool, ...]
    misses: tuple[Miss, ...]
    refused: tuple[LanindexError, ...] = ()

    def counts(self) -> tuple[int, int, int]:
        """Return the number of clips found rightly, found wrongly, and missed."""
        pairs = list(zip(self.found, self.wanted, strict=True))
        return pairs.count((True, True)), pairs.count((True, False)), pairs.count((False, True))

    def record(self, *, misses: bool = False) -> dict[str, Any]:
        """Return the figures, and the wrongly judged clips if `misses`, as one JSON line."""
        right, wrong, missed = self.counts()
        return {
            "name": self.expectation.name,
            "pattern": self.expectation.text,
            "precision": _ratio(right, right + wrong),
            "recall": _ratio(right, right + missed),
            "f1": _ratio(2 * right, 2 * right + wrong + missed) if right + missed else None,
            "found_rightly": right,
            "found_wrongly": wrong,
            "missed": missed,
            "positives": right + missed,
            "clips": len(self.found),
            **({"misses": [self._record(miss) for miss in self.misses]} if misses else {}),
        }

    def obstacle(self, miss: Miss) -> str:
        """Return why a pattern missed a capture."""
        from lanindex.search.explain.why import trace

        return trace(self.expectation.query, miss.capture, miss.tracks).obstacle

    def _record(self, miss: Miss) -> dict[str, Any]:
        clip = {"capture": miss.capture.path, "label": miss.capture.label}
        if miss.hit is None:
            return {**clip, "kind": "missed", "obstacle": self.obstacle(miss)}
        return {**clip, "kind": "wrong", "hit": records.of_hit(miss.hit)}


def _ratio(part: int, total: int) -> float:
    return part / total if total else 0.0


def read_patterns(
    path: str | os.PathLike[str], words: str | os.PathLike[str] | None = None
) -> list[Expectation]:
    """Read TOML: ``name = {pattern = "...", positives = ["label", "glob*", ...]}``.

    Patterns may be words of the dictionary, and of the file `words`, or name them.
    """
    expectations = []
    for name, entry in read_toml(Path(path)).items():
        match entry:
            case {"pattern": str(text), "positives": [*positives]} if len(entry) == 2 and all(
                isinstance(label, str) for label in positives
            ):
                pass
            case _:
                wanted = 'name = {pattern = "...", positives = ["label", ...]}'
                found = f"{shown(name)} = {quoted(entry)}"
                raise UsageError(found, place=str(path), wanted=wanted)
        place = f"{path}: {shown(name)}"
        try:
            query = query_of(pattern_in(text, Path(path).parent), words=words)
        except PatternError as error:
            raise UsageError(f"the pattern is not understood\n{error}", place=place) from error
        if query.stages:
            found = f'"| {query.stages[0]}"'
            raise UsageError(found, place=place, wanted="a pattern without a pipe: its hits count")
        expectations.append(Expectation(name, text, query, frozenset(positives)))
    if not expectations:
        raise UsageError("no patterns", place=str(path), wanted="one at least")
    return expectations


def read_clips(
    folder: str | os.PathLike[str],
    labels: Labels,
    profile: Profile,
    *,
    jobs: int = 1,
    spread: Spread | None = None,
) -> Iterator[Clip]:
    """Yield the labelled captures of a folder, written down, in order of path."""
    paths = [path for path in discover([folder]) if key_of(path) in labels]
    tasks = (Task(path, profile) for path in paths)
    for number, outcome in enumerate(prepared(tasks, jobs, spread), 1):
        label, metadata = labels[key_of(outcome.path)]
        score = outcome.score or Score(Fraction(1), 0, Meter(), {})
        capture = Capture(
            *(number, outcome.path, outcome.format, outcome.sha256, label or ""),
            *(score.rate, score.frames, score.meter),
            metadata=metadata,
        )
        yield Clip(capture, score.tracks, outcome.error)


def evaluate(
    clips: Sequence[Clip],
    expectations: Sequence[Expectation],
    *,
    near: bool = False,
    fuzzy: str | float | None = None,
    timeout: float | None = None,
    progress: Progress = no_progress,
    spread: Spread | None = None,
) -> list[Result]:
    """Search all clips for each pattern, here or in batches by other processes.

    Examples
    --------
    >>> from pathlib import Path
    >>> from lanindex.encoding.profile import load
    >>> from lanindex.evaluate import evaluate, read_clips, read_patterns, summary
    >>> from lanindex.pipeline.ingest import read_labels
    >>> _ = Path("own.toml").write_text("bow = {pattern='torso forward', positives=['greeting']}")
    >>> labels = read_labels("corpus/labels.csv")
    >>> clips = list(read_clips("corpus/greetings.bvh", labels, load()))
    >>> (bow,) = evaluate(clips, read_patterns("own.toml"))
    >>> bow.counts()  # rightly found, wrongly found, missed
    (1, 0, 0)
    >>> summary([bow])["mean_f1"]
    1.0
    """
    options, many = SearchOptions.read(near=near, fuzzy=fuzzy), len(expectations)
    with deadline(progress, timeout, "evaluation", BOUND_REMEDY) as in_time:
        if spread is None or not clips:
            watch = partial(in_time, "patterns")
            return list(_results(clips, expectations, options, lambda done: watch(done, many)))
        done, by_batch = 0, list[list[Result]]()

        def tick() -> None:
            in_time("clips", done, len(clips))

        # to search a few clips takes about as long as to search one
        count = max(1, min(spread.tasks, len(clips) // FEWEST))
        edges = [len(clips) * place // count for place in range(count + 1)]
        batches = [clips[first:last] for first, last in pairwise(edges)]
        items = ((batch, expectations, options) for batch in batches)
        for batch, results in zip(batches, spread.results(_in_batch, items, tick), strict=True):
            by_batch.append(results)
            done += len(batch)
    return [_joined(results) for results in zip(*by_batch, strict=True)]


def _results(
    clips: Sequence[Clip],
    expectations: Sequence[Expectation],
    options: SearchOptions,
    watch: Callable[[int], None],
) -> Iterator[Result]:
    """Yield what each pattern finds; `watch` is told of how many that is known, often."""
    search = searcher([clip.capture for clip in clips], [clip.tracks for clip in clips], options)
    for done, expectation in enumerate(expectations):

        def tick(*_: int, done: int = done) -> None:
            watch(done)  # however far the search of one is

        tick()
        refused: list[LanindexError] = []
        hits = search(expectation.query, tick, refused)
        first: dict[int, int] = {}
        for index, (capture, _) in enumerate(hits.spans()):
            first.setdefault(capture.id, index)
        found = tuple(clip.capture.id in first for clip in clips)
        wanted = tuple(expectation.wants(clip.capture.label) for clip in clips)
        misses = tuple(
            Miss(clip.capture, hits[first[clip.capture.id]] if is_found else None, clip.tracks)
            for clip, is_found, is_wanted in zip(clips, found, wanted, strict=True)
            if is_found != is_wanted
        )
        yield Result(expectation, found, wanted, misses, tuple(refused))


def _in_batch(
    item: tuple[Sequence[Clip], Sequence[Expectation], SearchOptions], tick: Tick
) -> list[Result]:
    """Return what each pattern finds in some clips, in another process."""
    return list(_results(*item, lambda _: tick()))


def _joined(results: Sequence[Result]) -> Result:
    """Return what a pattern found in batches of clips as one."""
    names = "found", "wanted", "misses", "refused"
    rows = (tuple(chain.from_iterable(getattr(it, name) for it in results)) for name in names)
    return Result(results[0].expectation, *rows)


def summary(results: Sequence[Result]) -> dict[str, Any]:
    """Return mean F1 over patterns with positives, and its standard error (seeded bootstrap)."""
    import numpy as np

    judged = [result for result in results if any(result.wanted)]
    clips = len(results[0].found) if results else 0
    values: dict[str, Any] = {"mean_f1": None, "standard_error": None}
    if judged:
        values["mean_f1"] = sum(result.record()["f1"] for result in judged) / len(judged)
        found = np.array([result.found for result in judged], dtype=float)
        wanted = np.array([result.wanted for result in judged], dtype=float)
        draw = np.random.default_rng(0).multinomial(clips, [1 / clips] * clips, size=RESAMPLES)
        both, either = (found * wanted) @ draw.T, (found + wanted) @ draw.T
        # a draw with nothing to find, in which nothing is found, is all right
        f1 = np.divide(2 * both, either, out=np.ones_like(both), where=either > 0)
        values["standard_error"] = float(f1.mean(axis=0).std())
    return {**values, "clips": clips, "patterns": len(results)}
