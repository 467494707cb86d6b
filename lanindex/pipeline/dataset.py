"""Hits as a data set to train on: clips of joints, symbols and words, in splits, with a card.

A capture is read once, its clips are written, and it is let go.
"""

import json
import re
from collections import Counter, defaultdict
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from functools import partial
from hashlib import sha256
from heapq import merge
from importlib.metadata import version
from itertools import groupby, pairwise, repeat
from os import PathLike
from pathlib import Path, PurePath
from typing import Any, NamedTuple

import numpy as np

from lanindex.alphabet import KINDS, kind_of
from lanindex.data import shipped
from lanindex.encoding.joints import body
from lanindex.encoding.places import resample
from lanindex.errors import ExportError, LanindexError, UsageError, shown
from lanindex.formats.file import SUBJECT
from lanindex.library.selection import is_gone
from lanindex.library.store import Store
from lanindex.model import Capture, Span
from lanindex.notation import NOTATIONS
from lanindex.pipeline.export import (
    clip_name,
    clip_span,
    held_as,
    pad_frames,
    stored_motion,
    suspects,
)
from lanindex.pipeline.files import write_all
from lanindex.pipeline.layouts import SPLITS, Clip, layout_of
from lanindex.pipeline.manifest import in_words
from lanindex.pipeline.named import Request, from_hits
from lanindex.records import of_name
from lanindex.search.dictionary import named_patterns
from lanindex.search.explain.english import sentence as english
from lanindex.search.hits import Hits
from lanindex.search.language import parse

INDEX, CARD, PAGE = "clips.jsonl", "card.json", "README.md"

COLUMNS = (
    *("clip", "split", "label", "texts", "capture", "capture_id", "capture_label", "performer"),
    *("licence", "fps", "frames", "seconds", "start_frame", "end_frame", "fit", "known"),
)
"""The keys of a clip's line in the index, in order."""

PERFORMERS = ("performer", "subject", "actor", "dancer", "participant", "signer", "person")
"""Columns of the user's that tell who moves, the first that any capture has."""

LICENCES = ("licence", "license")
"""Columns of the user's that tell on what terms a capture may be used."""


@dataclass(frozen=True, slots=True)
class ClipGroup:
    """Clips of a data set that share a label and a pattern; `tally` counts them by capture."""

    label: str
    pattern: str
    sentence: str
    tally: Counter[int]
    requests: Iterable[Request]
    expected: frozenset[int] | None = None


def of_hits(
    hits: Hits,
    label: str = "",
    sentence: str | None = None,
    words: str | PathLike[str] | None = None,
) -> ClipGroup:
    """Return the hits of a pattern as a group; without a sentence, that of the pattern."""
    if sentence is None:
        sentence = sentence_of(hits.pattern, named_patterns(hits.pattern, words))
    numbers = [capture.id for capture, _ in hits.spans()]
    if any(one > other for one, other in pairwise(numbers)):
        hits = hits.arranged(sorted(range(len(numbers)), key=numbers.__getitem__))
    requests = from_hits(hits, hits.pattern)
    return ClipGroup(label, hits.pattern, sentence, Counter(numbers), requests)


def of_requests(requests: Iterable[Request], pattern: str = "") -> ClipGroup:
    """Return listed clips as a group, those of one pattern or of none."""
    ordered = sorted(requests, key=lambda one: one.capture.id)
    tally = Counter(one.capture.id for one in ordered)
    return ClipGroup("", pattern, sentence_of(pattern) if pattern else "", tally, ordered)


def of_captures(captures: Iterable[Capture]) -> ClipGroup:
    """Return whole captures as a group."""
    return of_requests(Request(one, Span(0, one.frames)) for one in captures)


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
    search_options: Mapping[str, str] = field(default_factory=dict)


def write(
    store: Store, groups: Sequence[ClipGroup], folder: Path, options: DatasetOptions
) -> tuple[bytes, dict[str, Any]]:
    """Write a data set, all or nothing, and return its index and card; without clips, no file."""
    job = _Job(store, groups, options)
    before, written = _existing_files(folder, options.force), set[str]()

    def files() -> Iterator[tuple[Path, bytes]]:
        for name, content in job.files():
            written.add(name)
            yield folder / name, content

    write_all(files(), force=options.force, suspects=partial(suspects, store))
    for name in before - written if written else ():
        (folder / name).unlink(missing_ok=True)
    return bytes(job.index), job.card


class ClipFacts(NamedTuple):
    """What a card counts of a clip; `group` is the place of its `ClipGroup`."""

    split: str
    label: str
    licence: str
    format: str
    profile: str
    capture: int
    unit: str
    group: int
    frames: int
    seconds: float


class _Job:
    """One data set while it is made."""

    def __init__(self, store: Store, groups: Sequence[ClipGroup], options: DatasetOptions) -> None:
        self.store, self.groups, self.options = store, groups, options
        self.layout = layout_of(options.layout)
        rate, layout_rate = options.rate, self.layout.rate
        if rate and layout_rate and rate != layout_rate:
            wanted = f"{layout_rate}, as {options.layout} has it"
            raise UsageError(f"{float(rate):g} frames a second", place="--fps", wanted=wanted)
        self.rate = layout_rate or rate
        pad_frames(options.pad, Fraction(1))
        shares = read_shares(options.shares)
        numbers = sum((one.tally for one in groups), Counter[int]())
        chosen = [capture for capture in store.captures() if capture.id in numbers]
        self.column = performers(chosen, options.split_by)
        moving = [capture for capture in chosen if capture.format not in NOTATIONS]
        _check_sources(moving)
        self.unit = units(moving, self.column)
        weights: Counter[str] = Counter()
        for capture in moving:
            weights[self.unit[capture.id]] += numbers[capture.id]
        self.split = split(weights, shares, options.seed)
        self.total = len(chosen)
        self.untold = sum(not capture.metadata.get(self.column) for capture in moving)
        self.clips, self.left_out = list[ClipFacts](), Counter[str]()
        self.index, self.card = bytearray(), dict[str, Any]()
        self.used_names: set[str] = set()

    def files(self) -> Iterator[tuple[str, bytes]]:
        """Yield each file's name and content; what tells of all of them comes last."""
        streams = [zip(repeat(number), one.requests) for number, one in enumerate(self.groups)]
        ordered = merge(*streams, key=lambda one: one[1].capture.id)
        by_capture = groupby(ordered, key=lambda one: one[1].capture.id)
        for done, (_, requests) in enumerate(by_capture):
            self.store.session.progress("captures", done, self.total)
            yield from self._of_capture(list(requests))
        self.store.session.progress("captures", self.total, self.total)
        self.card = self._card()
        if self.index:
            yield from zip(self.layout.shared, self.layout.shared_contents(), strict=False)
            yield INDEX, bytes(self.index)
            yield CARD, (json.dumps(self.card, ensure_ascii=False, indent=1) + "\n").encode()
            yield PAGE, page(self.card).encode()

    def _of_capture(self, requests: Sequence[tuple[int, Request]]) -> Iterator[tuple[str, bytes]]:
        """Yield the files of a capture's clips; requests are each with the place of its group."""
        capture = held_as(self.store, requests[0][1].capture)
        if capture.format in NOTATIONS:
            self.left_out[f"a score ({capture.format}) has no motion"] += len(requests)
            return
        places = body(stored_motion(self.store, capture, capture.rate)).places / 1000
        score = self.store.score(capture.id)
        profile = self.store.encoding(capture.id).profile
        unit = self.unit[capture.id]
        for number, request in requests:
            group = self.groups[number]
            span = clip_span(capture, request.hit, self.options.pad)
            joints, rate = places[span.start : span.stop], capture.rate
            if self.rate:
                joints, rate = resample(joints, 0, rate, self.rate)[1], self.rate
            label = group.label or capture.label
            seen = sentence_of_symbols(request.symbols)
            texts = distinct((label, as_seen(group.sentence), seen))
            name = clip_name(capture, span, self.used_names)
            clip = Clip(name, self.split[unit], joints, rate, score, span, texts, label)
            if why := self.layout.lacking(clip):
                self.left_out[why] += 1
                continue
            names = self.layout.names(name, clip.split)
            yield from zip(names, self.layout.contents(clip), strict=True)
            row = self._row(clip, names[0], capture, request)
            self.index += json.dumps(row, ensure_ascii=False).encode() + b"\n"
            told = clip.split, label, row["licence"], capture.format, profile, capture.id, unit
            self.clips.append(ClipFacts(*told, number, row["frames"], row["seconds"]))

    def _row(self, clip: Clip, name: str, capture: Capture, request: Request) -> dict[str, Any]:
        """Return a clip's line in the index: `COLUMNS`."""
        return {
            "clip": name,
            "split": clip.split,
            "label": clip.label,
            "texts": list(clip.texts),
            **of_name(capture),
            "capture_label": capture.label,
            "performer": capture.metadata.get(self.column, "") if self.column else "",
            "licence": next(filter(None, map(capture.metadata.get, LICENCES)), "not told"),
            "fps": round(float(clip.rate), 6),
            "frames": len(clip.places),
            "seconds": round(float(len(clip.places) / clip.rate), 6),
            "start_frame": clip.span.start,
            "end_frame": clip.span.stop,
            "fit": request.fit,
            "known": round(float(np.isfinite(clip.places).all(axis=2).mean()), 4),
        }

    def _card(self) -> dict[str, Any]:
        by_group, counts = _by("group", self.clips), counts_of(self.clips)
        found = []
        for place, group in enumerate(self.groups):
            captures, expected = [clip.capture for clip in by_group[place]], group.expected
            right = None if expected is None else sum(it in expected for it in captures)
            names = {"label": group.label, "pattern": group.pattern, "sentence": group.sentence}
            found.append({**names, "clips": len(captures), "expected": right})
        notes = []
        if not self.column:
            notes.append("Nobody told who performs: one performer may be in several splits.")
        elif self.untold:
            notes.append(f"{self.untold} captures tell no {self.column}: each is by itself.")
        if empty := [name for name, count in counts["by_split"].items() if not count["clips"]]:
            notes.append(f"No clip is in {' and '.join(empty)}.")
        return {
            "made_by": f"LanIndex {version('lanindex')}",
            "layout": self.options.layout,
            "fps": float(self.rate) if self.rate else None,
            **counts,
            "left_out": dict(sorted(self.left_out.items())),
            "found": found,
            "how": {"time around each hit": self.options.pad, **self.options.search_options},
            "shares": self.options.shares,
            "seed": self.options.seed,
            "split_by": self.column or "capture",
            "split_note": " ".join(notes),
            "columns": list(COLUMNS),
        }


def _check_sources(captures: Sequence[Capture]) -> None:
    """Refuse to begin if a source is missing: its clips may come only after hours."""
    if lost := [one for one in captures if is_gone(one.location)]:
        more = f", nor are those of {len(lost) - 1} others" if lost[1:] else ""
        raise ExportError(
            f"is no longer there{more}",
            place=lost[0].location,
            wanted="the file that was ingested",
            remedy="Ingest it again, or let go of it: lanindex remove --missing",
        )


def _existing_files(folder: Path, force: bool) -> set[str]:
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
            remedy="Choose another one, or replace a data set: --force, in Python force=True.",
        )
    try:
        layout = layout_of(json.loads((folder / CARD).read_bytes())["layout"])
        rows = [json.loads(line) for line in (folder / INDEX).read_bytes().splitlines()]
        clips = [(PurePath(row["clip"]).stem, str(row["split"])) for row in rows]
    except (OSError, ValueError, KeyError, TypeError, UsageError):
        return set()  # no data set of ours: what it holds is left alone
    named = {name for stem, part in clips for name in layout.names(stem, part)}
    return {name for name in named if ".." not in PurePath(name).parts} | {*layout.shared}


# Splits: no performer is in two; where none is told, no capture is. The same content under two
# paths is one, and so are people of one recording who are not told apart.


def performers(captures: Sequence[Capture], column: str | None = None) -> str:
    """Return the column that tells who moves; empty where none does."""
    columns = {name for one in captures for name, value in one.metadata.items() if value}
    if column is None:
        return next((name for name in PERFORMERS if name in columns), "")
    if column not in columns:
        listed = f"one of {', '.join(sorted(columns))}"
        wanted = listed if columns else "captures with columns (--labels)"
        raise UsageError(f'no column "{shown(column)}"', place="--split-by", wanted=wanted)
    return column


def units(captures: Iterable[Capture], column: str) -> dict[int, str]:
    """Return the unit of each capture by its number; captures of one unit stay in one split."""
    above: dict[str, str] = {}

    def top(key: str) -> str:
        while (over := above.setdefault(key, key)) != key:
            above[key] = above[over]
            key = over
        return key

    own: dict[int, str] = {}
    for one in captures:
        who = one.metadata.get(column, "") if column else ""
        person = one.path.partition(SUBJECT)[2] if who else ""
        content = f"content {one.sha256} {person}"
        own[one.id] = content
        if who:
            first, last = sorted((top(content), top(f"performer {who}")))
            above[first] = last  # a performer's name stays on top: it sorts behind contents
    return {number: top(key) for number, key in own.items()}


def read_shares(text: str) -> tuple[Fraction, ...]:
    """Return the shares of training, validation and testing: ``80/10/10``."""
    try:
        shares = tuple(Fraction(one) / 100 for one in text.split("/"))
    except (ValueError, ZeroDivisionError):
        shares = ()
    if len(shares) != len(SPLITS) or sum(shares) != 1 or min(shares) < 0:
        wanted = "training/validation/testing in per cent, such as 80/10/10"
        raise UsageError(f'"{shown(text)}"', place="--split", wanted=wanted)
    return shares


def split(weights: Mapping[str, int], shares: Sequence[Fraction], seed: int = 0) -> dict[str, str]:
    """Return the split of each unit."""
    total = sum(weights.values())
    lacking = {name: share * total for name, share in zip(SPLITS, shares, strict=True) if share}
    order = sorted(weights, key=lambda unit: sha256(f"{seed} {unit}".encode()).digest())
    splits: dict[str, str] = {}
    used: set[str] = set()
    for left, unit in zip(range(len(order), 0, -1), order, strict=True):
        empty = [name for name in lacking if name not in used]
        choice = empty if left <= len(empty) else list(lacking)
        name = splits[unit] = max(choice, key=lambda one: lacking[one])
        lacking[name] -= weights[unit]
        used.add(name)
    return splits


# What a clip is in words: its label, what was searched for, and what was seen. The English is that
# of ``lanindex search --explain``.

_LONGEST = 16
"""Symbols that a sentence may tell: nobody reads longer ones."""

_AS_SEEN = {
    r" \(or begins? there\)": "",
    r"; and in the meantime, sharing a frame at least,": ", while",
}
"""Phrases about a pattern that may match in several ways, and what replaces them for a clip."""


def sentence_of(pattern: str, names: Mapping[str, str] | None = None) -> str:
    """Return the English sentence of a pattern; empty if it cannot be parsed."""
    try:
        return english(parse(pattern, names=names))
    except LanindexError:
        return ""


def sentence_of_symbols(symbols: Sequence[Mapping[str, Any]]) -> str:
    """Return the English sentence of some symbols; empty if there are none, or too many."""
    if not 0 < len(symbols) <= _LONGEST:
        return ""
    order = list(dict.fromkeys(one["part"] for one in symbols))
    rows = sorted(
        {(order.index(one["part"]), one["start_frame"], one["end_frame"], _step(one))
         for one in symbols}
    )  # fmt: skip
    lines = [
        f"{order[part]} {' -> '.join(row[-1] for row in steps)}"
        for part, steps in groupby(rows, key=lambda row: row[0])
    ]
    return as_seen(sentence_of(" with ".join(lines)))


def as_seen(text: str) -> str:
    """Turn the sentence of a pattern into that of a clip in which it was found."""
    for pattern, instead in _AS_SEEN.items():
        text = re.sub(pattern, instead, text)
    return text


def _step(symbol: Mapping[str, Any]) -> str:
    stands = symbol["start_frame"] == symbol["end_frame"] and KINDS[kind_of(symbol["part"])].lasts
    return f"at {in_words(symbol)}" if stands else in_words(symbol)


def distinct(texts: Iterable[str]) -> list[str]:
    """Return the texts that are not blank, each once, in order."""
    tidy = (" ".join(text.split()) for text in texts)
    return list(dict.fromkeys(text for text in tidy if text))


# The card: its counts, and the page for people.


def _by(key: str, clips: Iterable[ClipFacts]) -> defaultdict[Any, list[ClipFacts]]:
    groups = defaultdict[Any, list[ClipFacts]](list)
    for clip in clips:
        groups[getattr(clip, key)].append(clip)
    return groups


def _tally(clips: Sequence[ClipFacts]) -> dict[str, Any]:
    return {
        "clips": len(clips),
        "captures": len({clip.capture for clip in clips}),
        "frames": sum(clip.frames for clip in clips),
        "hours": round(sum(clip.seconds for clip in clips) / 3600, 6),
    }


def counts_of(clips: Sequence[ClipFacts]) -> dict[str, Any]:
    """Return the counts of a data set, as its card has them."""
    counts = {
        f"by_{key}": {name: _tally(group) for name, group in sorted(_by(key, clips).items())}
        for key in ("split", "label", "licence", "format")
    }
    splits = _by("split", clips)
    counts["by_split"] = {
        name: {**_tally(splits[name]), "groups": len({clip.unit for clip in splits[name]})}
        for name in SPLITS
    }
    for label, group in _by("label", clips).items():
        number = Counter(clip.split for clip in group)
        counts["by_label"][label]["splits"] = {name: number[name] for name in SPLITS}
    profiles = Counter(clip.profile for clip in clips)
    return {**_tally(clips), **counts, "profiles": dict(sorted(profiles.items()))}


def page(card: Mapping[str, Any]) -> str:
    """Return a card as a page for people."""
    lines = ["# A data set of movement", "", *_summary(card), "", "## Clips", ""]
    lines += _table(
        ("split", "clips", "captures", "groups", "hours"),
        ((name, one["clips"], one["captures"], one["groups"], f"{one['hours']:.3f}")
         for name, one in card["by_split"].items()),
    )  # fmt: skip
    lines += ["", *_table(
        ("label", *SPLITS, "clips", "captures", "hours"),
        ((name or "(none)", *one["splits"].values(), one["clips"], one["captures"],
          f"{one['hours']:.3f}") for name, one in card["by_label"].items()),
    )]  # fmt: skip
    lines += ["", "## Terms", "", *_table(
        ("licence, as told", "clips", "captures"),
        ((name, one["clips"], one["captures"]) for name, one in card["by_licence"].items()),
    )]  # fmt: skip
    lines += ["", "## How it was found", ""]
    for one in card["found"]:
        line = f"- {one['label'] or 'each by its own label'}: "
        line += f"`{one['pattern']}`. {one['sentence']}" if one["pattern"] else "whole captures."
        if one["expected"] is not None:
            line = f"{line.rstrip()} {one['expected']} of {one['clips']} clips are of captures "
            line += "with an expected label."
        lines.append(line.rstrip())
    lines += [f"- {name}: {value}" for name, value in card["how"].items()]
    if card["left_out"]:
        lines += ["", "## Left out", ""]
        lines += [
            f"- {number} clip{'s' if number > 1 else ''}: {why}"
            for why, number in card["left_out"].items()
        ]
    layout = shipped("pipeline/layouts.toml")["cards"][card["layout"]]
    lines += ["", "## Files", "", layout, ""]
    lines += ["`clips.jsonl` has a line for each clip, with the keys", ""]
    lines += [" ".join(f"`{name}`" for name in card["columns"]) + ".", ""]
    return "\n".join(lines)


def _summary(card: Mapping[str, Any]) -> list[str]:
    profiles = ", ".join(name or "scores as they came" for name in card["profiles"]) or "none"
    who = card["split_by"] if card["split_by"] == "capture" else f"the column {card['split_by']}"
    rate = f"{card['fps']} frames a second" if card["fps"] else "the rates of their captures"
    return [
        f"{card['clips']:,} clips of {card['captures']:,} captures, {card['hours']:.2f} hours, "
        f"at {rate}.",
        f"Made by {card['made_by']}; written down with the profile {profiles}.",
        f"Splits ({card['shares']}, seed {card['seed']}) are by {who}: no group is in two. "
        f"{card['split_note']}".rstrip(),
        "Joints unknown for a fifth of a second at most are filled in straight lines.",
    ]


def _table(head: Sequence[str], rows: Iterable[Iterable[object]]) -> list[str]:
    cells = [[str(cell).replace("|", "\\|").replace("\n", " ") for cell in row] for row in rows]
    lines = [head, ["---"] * len(head), *cells]
    return [f"| {' | '.join(line)} |" for line in lines]
