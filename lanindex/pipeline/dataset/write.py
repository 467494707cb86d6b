"""From hits to a data set: a capture is read once, its clips are written, and it is let go."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from heapq import merge
from importlib.metadata import version
from itertools import groupby, pairwise
from pathlib import Path, PurePath
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lanindex import formats
from lanindex.encoding.joints import body
from lanindex.encoding.resample import resample
from lanindex.errors import ExportError, UsageError
from lanindex.library.selection import is_gone
from lanindex.library.store import Store
from lanindex.model import Capture, Reading, Score, Span
from lanindex.notation import NOTATIONS
from lanindex.pipeline.dataset.card import Counts, licence_of, page
from lanindex.pipeline.dataset.layouts import Clip, Layout, layout_of
from lanindex.pipeline.dataset.splits import performers, read_shares, split, units
from lanindex.pipeline.dataset.texts import of_symbols, of_what_is_done, several
from lanindex.pipeline.export import (
    Request,
    free,
    from_hits,
    held_as,
    pad_frames,
    padded,
    suspects,
    unchanged,
)
from lanindex.pipeline.files import safe_stem, write_all
from lanindex.search.hits import Hits

INDEX, CARD, PAGE = "clips.jsonl", "card.json", "README.md"

COLUMNS = (
    *("clip", "split", "label", "texts", "capture", "capture_id", "capture_label", "performer"),
    *("licence", "fps", "frames", "seconds", "start_frame", "end_frame", "fit", "known"),
)
"""The keys of a clip's line in the index, in order."""


@dataclass(frozen=True, slots=True)
class ClipGroup:
    """Clips of a data set that share a label and a pattern."""

    label: str
    pattern: str
    sentence: str
    tally: Sequence[tuple[int, int]]
    requests: Iterable[Request]
    expected: frozenset[int] | None = None


def of_hits(hits: Hits, label: str = "", sentence: str = "") -> ClipGroup:
    """Return the hits of a pattern as a group."""
    numbers = [capture.id for capture, _ in hits.spans()]
    if any(one > other for one, other in pairwise(numbers)):
        hits = hits.arranged(sorted(range(len(numbers)), key=numbers.__getitem__))
    tally = list(Counter(numbers).items())
    return ClipGroup(label, hits.pattern, sentence, tally, from_hits(hits, hits.pattern))


def of_requests(wanted: Iterable[Request], label: str = "", sentence: str = "") -> ClipGroup:
    """Return listed clips as a group."""
    ordered = sorted(wanted, key=lambda one: one.capture.id)
    patterns = {one.pattern for one in ordered}
    tally = list(Counter(one.capture.id for one in ordered).items())
    return ClipGroup(label, " or ".join(sorted(patterns - {""})), sentence, tally, ordered)


def of_captures(captures: Iterable[Capture], label: str = "") -> ClipGroup:
    """Return whole captures as a group."""
    return of_requests((Request(one, Span(0, one.frames)) for one in captures), label)


@dataclass(frozen=True, slots=True)
class DatasetOptions:
    """How a data set is made."""

    layout: str = "npz"
    rate: Fraction | None = None
    pad: str = "0"
    shares: str = "80/10/10"
    split_by: str | None = None
    seed: int = 0
    force: bool = False
    how: Mapping[str, str] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class Made:
    """A data set that was written."""

    clips: bytes
    card: Mapping[str, Any]


def write(store: Store, groups: Sequence[ClipGroup], folder: Path, options: DatasetOptions) -> Made:
    """Write a data set, all or nothing; where there is no clip, nothing."""
    job = _Job(store, groups, options)
    before = _before(folder, options.force)
    write_all(
        ((folder / name, content) for name, content in job.files()),
        force=options.force,
        suspects=lambda replaced: suspects(store, replaced),
    )
    if job.written:
        for name in before - job.written:
            (folder / name).unlink(missing_ok=True)
    return Made(bytes(job.index), job.card)


class _Job:
    """One data set while it is made."""

    def __init__(self, store: Store, groups: Sequence[ClipGroup], options: DatasetOptions) -> None:
        self.store, self.groups, self.options = store, groups, options
        self.layout: Layout = layout_of(options.layout)
        rate, own = options.rate, self.layout.rate
        if rate and own and rate != own:
            wanted = f"{own}, as {options.layout} has it"
            raise UsageError(f"{float(rate):g} frames a second", place="--fps", wanted=wanted)
        self.rate = own or rate
        pad_frames(options.pad, Fraction(1))
        shares = read_shares(options.shares)
        numbers: Counter[int] = Counter()
        for one in groups:
            numbers.update(dict(one.tally))
        chosen = [capture for capture in store.captures() if capture.id in numbers]
        self.column = performers(chosen, options.split_by)
        moving = [capture for capture in chosen if capture.format not in NOTATIONS]
        _all_there(moving)
        self.unit = units(moving, self.column)
        weights: Counter[str] = Counter()
        for capture in moving:
            weights[self.unit[capture.id]] += numbers[capture.id]
        self.split = split(weights, shares, options.seed)
        self.total = len(chosen)
        self.untold = sum(not capture.metadata.get(self.column) for capture in moving)
        self.counts, self.index = Counts(), bytearray()
        self.clips, self.expected = Counter[int](), Counter[int]()
        self.written: set[str] = set()
        self.card: dict[str, Any] = {}

    def files(self) -> Iterator[tuple[str, bytes]]:
        """Yield each file's name and content; what tells of all of them comes last."""
        taken: set[str] = set()
        streams = [_numbered(number, one.requests) for number, one in enumerate(self.groups)]
        ordered = merge(*streams, key=lambda one: one[1].capture.id)
        groups = groupby(ordered, key=lambda one: one[1].capture.id)
        for done, (_, group) in enumerate(groups):
            self.store.session.progress("captures", done, self.total)
            wanted = list(group)
            held = held_as(self.store, wanted[0][1].capture)
            if held.format in NOTATIONS:
                why = f"a score ({held.format}) has no motion"
                self.counts.left_out[why] += len(wanted)
                continue
            before = self.counts.whole.clips
            for clip, source, request in self._clips(held, wanted, taken):
                yield from self._kept(clip, source, held, request)
            profile = self.store.encoding(held.id).profile
            self.counts.profiles[profile] += self.counts.whole.clips - before
        self.store.session.progress("captures", self.total, self.total)
        self.card = self._card()
        if self.index:
            last = [*self.layout.last(), (INDEX, bytes(self.index))]
            for name, content in (*last, *self._texts()):
                self.written.add(name)
                yield name, content

    def _clips(
        self, held: Capture, wanted: Sequence[tuple[int, Request]], taken: set[str]
    ) -> Iterator[tuple[Clip, int, Request]]:
        places, score = _read(self.store, held)
        pad = pad_frames(self.options.pad, held.rate)
        for source, request in wanted:
            group = self.groups[source]
            hit = request.hit
            if not 0 <= hit.start < hit.stop <= held.frames:
                wanted_range = f"a range inside 0 to {held.frames}, not empty"
                raise ExportError(
                    f"frames {hit.start} to {hit.stop}", place=held.path, wanted=wanted_range
                )
            span = padded(hit, pad, held.frames)
            here, rate = places[span.start : span.stop] / 1000, held.rate
            if self.rate:
                here, rate = resample(here, 0, rate, self.rate)[1], self.rate
            label = group.label or held.label
            texts = several((label, of_what_is_done(group.sentence), of_symbols(request.symbols)))
            name = free(f"{safe_stem(held.path)}_{span.start}-{span.stop}", taken)
            part = self.split[self.unit[held.id]]
            yield Clip(name, part, here, rate, score, span, texts, label), source, request

    def _kept(
        self, clip: Clip, source: int, held: Capture, request: Request
    ) -> Iterator[tuple[str, bytes]]:
        """Yield the files of a clip, and take note of it; nothing where it has no room."""
        if why := self.layout.lacking(clip):
            self.counts.left_out[why] += 1
            return
        for name, content in self.layout.files(clip):
            self.written.add(name)
            yield name, content
        row = {
            "clip": self.layout.names(clip.name, clip.split)[0],
            "split": clip.split,
            "label": clip.kind,
            "texts": list(clip.texts),
            "capture": held.path,
            "capture_id": held.id,
            "capture_label": held.label,
            "performer": held.metadata.get(self.column, "") if self.column else "",
            "licence": licence_of(held),
            "fps": round(float(clip.rate), 6),
            "frames": len(clip.places),
            "seconds": round(float(len(clip.places) / clip.rate), 6),
            "start_frame": clip.span.start,
            "end_frame": clip.span.stop,
            "fit": request.fit,
            "known": round(float(np.isfinite(clip.places).all(axis=2).mean()), 4),
        }
        self.index += json.dumps(row, ensure_ascii=False).encode() + b"\n"
        self.counts.add(row, self.unit[held.id], held.format)
        self.clips[source] += 1
        self.expected[source] += held.id in (self.groups[source].expected or ())

    def _card(self) -> dict[str, Any]:
        found = [
            {
                "label": one.label,
                "pattern": one.pattern,
                "sentence": one.sentence,
                "clips": self.clips[number],
                "expected": None if one.expected is None else self.expected[number],
            }
            for number, one in enumerate(self.groups)
        ]
        return {
            "made_by": f"LanIndex {version('lanindex')}",
            "layout": self.options.layout,
            "fps": float(self.rate) if self.rate else None,
            **self.counts.record(),
            "found": found,
            "how": {"time around each hit": self.options.pad, **self.options.how},
            "shares": self.options.shares,
            "seed": self.options.seed,
            "split_by": self.column or "capture",
            "split_note": self._note(),
            "columns": list(COLUMNS),
        }

    def _note(self) -> str:
        said = []
        if not self.column:
            said.append("Nobody told who performs: one performer may be in several splits.")
        elif self.untold:
            said.append(f"{self.untold} captures tell no {self.column}: each is by itself.")
        if empty := [name for name, one in self.counts.by["split"].items() if not one.clips]:
            said.append(f"No clip is in {' and '.join(empty)}.")
        return " ".join(said)

    def _texts(self) -> Iterator[tuple[str, bytes]]:
        text = json.dumps(self.card, ensure_ascii=False, indent=1) + "\n"
        yield CARD, text.encode()
        yield PAGE, page(self.card, self.layout.said).encode()


def _numbered(number: int, requests: Iterable[Request]) -> Iterator[tuple[int, Request]]:
    return ((number, one) for one in requests)


def _read(store: Store, held: Capture) -> tuple[NDArray[np.float64], Score]:
    """Return the joints of a capture, (T, 20, 3) mm, and its score."""
    encoding = store.encoding(held.id)
    file = unchanged(held, encoding)
    reading = Reading(**encoding.options)
    motion = formats.read_file(file, reading, formats.Wanted(body_only=True))
    return body(motion).places, store.score(held.id)


def _all_there(captures: Sequence[Capture]) -> None:
    """Refuse to begin where files are surely gone: it would be said after hours."""
    lost = [one for one in captures if is_gone(one.location)]
    if lost:
        more = f", nor are those of {len(lost) - 1} others" if lost[1:] else ""
        raise ExportError(
            f"is no longer there{more}",
            place=lost[0].location,
            wanted="the file that was ingested",
            remedy="Ingest it again, or let go of it: lanindex remove --missing",
        )


def _before(folder: Path, force: bool) -> set[str]:
    """Return the files of a data set that is in a folder; refuse a folder that holds things."""
    try:
        holds = any(folder.iterdir())
    except FileNotFoundError:
        return set()
    except OSError as error:
        raise ExportError(f"is no folder ({error.strerror})", place=str(folder)) from error
    if holds and not force:
        raise ExportError(
            "holds things already",
            place=str(folder),
            wanted="a new or an empty folder",
            remedy="Choose another one, or --force: an earlier data set in it is replaced.",
        )
    try:
        card = json.loads((folder / CARD).read_bytes())
        layout = layout_of(card["layout"])
        rows = [json.loads(line) for line in (folder / INDEX).read_bytes().splitlines()]
        clips = [(PurePath(row["clip"]).stem, str(row["split"])) for row in rows]
    except (OSError, ValueError, KeyError, TypeError, UsageError):
        return set()  # no data set of ours: what it holds is left alone
    named = {name for stem, part in clips for name in layout.names(stem, part)}
    more = {"train.txt", "val.txt", "test.txt", "all.txt", "Mean.npy", "Std.npy"}
    kept = {name for name in named if ".." not in PurePath(name).parts}
    return kept | (more if card["layout"] == "humanml3d" else set())
