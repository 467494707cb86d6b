"""``lanindex export --dataset``: hits, or whole captures, as a data set to train on."""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import typer

from lanindex.app import meaning, options
from lanindex.app.output import Output, end_progress
from lanindex.errors import UsageError

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

    from lanindex.pipeline import Library
    from lanindex.pipeline.dataset import Found, Made

Range = tuple[str | None, int | None, int | None]
"""A capture, and from which frame to which."""


def run(
    out: Output,
    db: str,
    folder: Path,
    wished: Mapping[str, Any],
    what: str | None,
    patterns: Path | None,
    range: Range,
    how: Mapping[str, Any],
    words: Path | None,
) -> None:
    """Write a data set."""
    _check(what, patterns, range, how)
    from lanindex.pipeline import open_library
    from lanindex.pipeline.dataset import Wishes, write

    told = {name: value for name, value in wished.items() if value is not None}
    if "rate" in told:
        told["rate"] = options.rate(told["rate"])
    wishes = replace(Wishes(how=dict(_said(how))), **told)
    with open_library(db, readonly=True) as library:
        library.tell, library.watch, library.words = out.note, out.watch, words
        if patterns is not None:
            found = list(_labelled(library, patterns, how))
        elif range[0] is not None or what == "-":
            found = _listed(library, range)
        elif what is not None:
            found = [_asked(out, library, what, how, words)]
        else:
            found = [_whole(library, how)]
        end_progress()
        made = write(library, found, folder, wishes)
    end_progress()
    _tell(out, made, folder)
    if library.refused or not made.clips:
        raise typer.Exit(2 if library.refused else 1)


def _check(what: str | None, patterns: Path | None, range: Range, how: Mapping[str, Any]) -> None:
    """Refuse what does not go together."""
    named = {"a pattern": what, "--patterns": patterns, "--capture": range[0]}
    if len(given := [name for name, value in named.items() if value is not None]) > 1:
        raise UsageError(" and ".join(given), wanted="one of them")
    if range[0] is None and range[1:] != (None, None):
        raise UsageError("--from and --to", wanted="--capture beside them")
    chooses = how["where"] or how["within"] is not None
    if chooses and (what == "-" or range[0] is not None):
        raise UsageError("--in and --where", wanted="patterns, or whole captures, beside them")


def _tell(out: Output, made: Made, folder: Path) -> None:
    """Say what was written, and what was not."""
    from json import loads

    from lanindex.app.formatting import counted, duration

    if out.json:
        for line in made.clips.splitlines():
            out.record(loads(line))
    card = made.card
    for one in card["found"]:
        if one["label"]:
            out.note(f"{one['label']}: {counted(one['clips'], 'clip')}")
    for why, number in card["left_out"].items():
        out.note(f"left out: {counted(number, 'clip')}: {why}")
    splits = ", ".join(f"{one['clips']} {name}" for name, one in card["by_split"].items())
    time = duration(card["hours"] * 3600)
    out.note(f"{counted(card['clips'], 'clip')}, {time}, in {folder}: {splits}")
    out.note(f"splits by {card['split_by']}. {card['split_note']}".rstrip())


def _said(how: Mapping[str, Any]) -> Iterator[tuple[str, str]]:
    """Yield how clips were searched for, as a card says it."""
    names = {"within": "captures", "where": "captures where", "fuzzy": "edits allowed"}
    for name, value in how.items():
        if name == "where":
            value = ", ".join(f"{key}={glob}" for key, glob in value)
        if value or name == "tolerance":
            yield names.get(name, name), f"{value:g} s" if name == "tolerance" else str(value)


def _asked(
    out: Output, library: Library, what: str, how: Mapping[str, Any], words: Path | None
) -> Found:
    from lanindex.pipeline.dataset import of_hits
    from lanindex.pipeline.dataset.texts import of_pattern
    from lanindex.pipeline.words import meant, named
    from lanindex.search.hits import hits_in
    from lanindex.search.language.score import pattern_in

    text = pattern_in(what)
    entry = meant(text, words)
    pattern = meaning.of(out, library, text, words)
    found = hits_in(library.search(pattern, **how))
    said = entry.sentence if entry else of_pattern(str(pattern), named(str(pattern), words))
    return of_hits(found, sentence=said)


def _labelled(library: Library, patterns: Path, how: Mapping[str, Any]) -> Iterator[Found]:
    from lanindex.evaluate import read_patterns
    from lanindex.pipeline.dataset import of_hits
    from lanindex.pipeline.dataset.texts import of_pattern
    from lanindex.search.hits import hits_in
    from lanindex.search.language.score import pattern_in

    labels = library.called("label")
    for one in read_patterns(patterns):
        text = pattern_in(one.text, patterns.parent)
        found = of_hits(hits_in(library.search(text, **how)), one.name, of_pattern(text))
        wanted = frozenset(number for number, label in labels.items() if one.wants(label))
        yield replace(found, expected=wanted)


def _listed(library: Library, range: Range) -> list[Found]:
    from lanindex.pipeline.dataset import of_requests
    from lanindex.pipeline.dataset.texts import of_pattern
    from lanindex.pipeline.requests import from_lines, from_range

    capture, begin, end = range
    if capture is not None:
        return [of_requests([from_range(library, options.which(capture), begin, end)])]
    wanted = from_lines(library, sys.stdin.buffer if sys.stdin else ())
    kinds = list(dict.fromkeys(one.pattern for one in wanted))
    return [
        of_requests((it for it in wanted if it.pattern == kind), sentence=of_pattern(kind))
        for kind in kinds
    ]


def _whole(library: Library, how: Mapping[str, Any]) -> Found:
    from lanindex.pipeline.dataset import of_captures

    return of_captures(library.captures(how["within"], how["where"]))
