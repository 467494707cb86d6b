"""``lanindex export``: write hits as clips or, with --dataset, as a data set to train on."""

from __future__ import annotations

import sys
from collections import defaultdict
from collections.abc import Iterable
from dataclasses import dataclass, replace
from itertools import islice
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from lanindex.app import options
from lanindex.app.commands.search import pattern_of
from lanindex.app.options import argument, data_set_option, option
from lanindex.app.output import Output, duration
from lanindex.errors import UsageError, counted

if TYPE_CHECKING:
    from lanindex.library.selection import Selection
    from lanindex.pipeline.dataset import ClipGroup, DatasetOptions
    from lanindex.pipeline.library import Library
    from lanindex.pipeline.named import Request


@dataclass(frozen=True)
class Source:
    """Arguments: a pattern, hits on standard input, or a stretch of a capture."""

    pattern: str | None = argument(
        None,
        "PATTERN|-",
        "A pattern, or - for hits from search --json.",
        autocompletion=options.complete_pattern,
    )
    capture: str | None = option(
        None, "PATH|ID", "Cut from this capture.", autocompletion=options.complete_capture
    )
    begin: int | None = option(None, "FRAME", "First frame.", "--from", min=0)
    end: int | None = option(None, "FRAME", "Frame after the last.", "--to", min=1)

    def requests(self, library: Library) -> Iterable[Request] | None:
        """Return a stretch of a capture or the hits on standard input; None: of a pattern."""
        from lanindex.pipeline.named import from_lines, from_range

        if self.capture is not None:
            capture = options.capture_id(self.capture)
            return [from_range(library.store, capture, self.begin, self.end)]
        if self.pattern == "-":
            return from_lines(library.store, sys.stdin.buffer if sys.stdin else ())
        return None


@dataclass(frozen=True)
class Clips:
    """Options of clips that a data set does not have."""

    output: Path | None = options.output("FOLDER", "Where to write: clips.")
    format: str = option(
        "native", "native|bvh|c3d|...|lnd", "The format to write; --format ? lists them."
    )
    origin: options.Origin = False
    preview: str | None = option(None, "webp|gif|mp4", "Write a film beside each clip.")
    limit: int | None = option(
        None, "N", "Only the first; of words the best.", "--limit", "-n", min=1
    )


@dataclass(frozen=True)
class Dataset:
    """Options of a data set that clips do not have."""

    patterns: Path | None = data_set_option(
        None, "FILE", "Its labels, each with its pattern, as for evaluate."
    )
    layout: str | None = data_set_option(None, "npz|humanml3d", "The files of a data set.")
    fps: str | None = data_set_option(None, "RATE", "Frame rate of a data set.")
    split: str | None = data_set_option(
        None, "80/10/10", "Per cent for training, validation, test."
    )
    split_by: str | None = data_set_option(
        None, "COLUMN", "What must stay in one split: performer."
    )
    seed: int | None = data_set_option(None, "N", "Seed of the splits.")

    def form(self, **values: Any) -> DatasetOptions:
        """Return how the data set is written: `values`, and the options that are not defaults."""
        from lanindex.pipeline.dataset import DatasetOptions

        values |= {"layout": self.layout, "rate": self.fps and options.rate(self.fps)}
        values |= {"shares": self.split, "split_by": self.split_by, "seed": self.seed}
        return DatasetOptions(**{key: it for key, it in values.items() if it is not None})


def run(
    *,
    source: Annotated[Source, options.Group(Source)],
    clips: Annotated[Clips, options.Group(Clips)],
    pad: str = option("0", "TIME", "Time around each hit: 0.5s, 200ms, 10f."),
    folder: Path | None = data_set_option(
        None, "FOLDER", "Write a data set to train on, instead of clips.", "--dataset"
    ),
    dataset: Annotated[Dataset, options.Group(Dataset)],
    selection: options.Selected,
    matching: options.Matching,
    words: options.Words = None,
    cluster: options.Cluster = None,
    force: options.Force = False,
    db: options.Db = options.DB,
    out: options.Out,
) -> int:
    """Write hits as clips, in their own format or another.

    A clip in its source's format is cut out of it, byte for byte where the format allows that. In
    another format (--format), or at the origin (--origin), it is written anew. Each clip comes
    with its score (.lnd) and, with --preview, a film; a manifest lists them all. With --dataset,
    hits become arrays of joints, symbols and words, in splits, with a card; without a pattern,
    whole captures do.
    """
    from lanindex.pipeline.export import ClipOptions, export
    from lanindex.pipeline.named import from_hits
    from lanindex.search.hits import hits_in
    from lanindex.search.language.score import pattern_in

    unfit, wanted = vars(dataset), "--dataset beside it"
    if folder is not None:
        unfit = {**vars(clips), "format": clips.format != "native"}
        wanted = "nothing of the kind beside --dataset"
    for name, value in unfit.items():
        if value is not None and value is not False:
            raise UsageError(f"--{name.replace('_', '-')}", wanted=wanted)
    _check_source(source, dataset.patterns, selection, captures_allowed=folder is not None)
    search_options = {**matching, "selection": selection}
    with options.opened(db, out, words, cluster) as library:
        if folder is None:
            requests = source.requests(library)
            if requests is None:
                query = pattern_in(str(source.pattern))
                pattern = pattern_of(out, library, query, library.words)
                hits = hits_in(library.search(pattern, **search_options))
                if clips.limit is not None and pattern != query:
                    hits = hits.by_fit(clips.limit)
                requests = from_hits(hits, hits.pattern)
            folder = clips.output or Path("clips")
            form = ClipOptions(pad, clips.format, clips.origin, clips.preview)
            chosen = islice(requests, clips.limit)
            manifest = export(
                library.store, chosen, folder, form, force=force, spread=library.spread
            )
            for clip in manifest:
                out.row([folder / clip["clip"]], clip)
            out.note(f"{counted(len(manifest), 'clip')} in {folder}")
            return 2 if library.refused else not manifest
        from lanindex.pipeline.dataset import write

        groups = _groups(out, library, source, dataset.patterns, search_options)
        card_options = _card_options(search_options)
        how = dataset.form(pad=pad, force=force, search_options=card_options)
        index, card = write(library.store, groups, folder, how)
    _report(out, index, card, folder)
    return 2 if library.refused else not index


def _check_source(
    source: Source, patterns: Path | None, selection: Selection, *, captures_allowed: bool
) -> None:
    """Refuse several sources of clips, or none; a data set takes whole captures."""
    sources = {"a pattern": source.pattern, "--patterns": patterns, "--capture": source.capture}
    named = [name for name, value in sources.items() if value is not None]
    if not captures_allowed and len(named) != 1:
        found = "two things to export" if named else "nothing to export"
        raise UsageError(found, wanted="a pattern, - or --capture")
    if len(named) > 1:
        raise UsageError(" and ".join(named), wanted="one of them")
    if source.capture is None and not (source.begin is None and source.end is None):
        raise UsageError("--from and --to", wanted="--capture beside them")
    if selection.globs and (source.capture is not None or source.pattern == "-"):
        searched = "patterns, or whole captures," if captures_allowed else "a pattern"
        raise UsageError("--in and --where", wanted=f"{searched} beside them")


def _groups(
    out: Output,
    library: Library,
    source: Source,
    patterns: Path | None,
    search_options: dict[str, Any],
) -> list[ClipGroup]:
    """Return the clips of a data set, those of each pattern together."""
    from lanindex.pipeline.dataset import of_captures, of_hits, of_requests
    from lanindex.pipeline.search import entry_of_query
    from lanindex.search.hits import hits_in
    from lanindex.search.language.score import pattern_in

    if patterns is not None:
        from lanindex.evaluate import read_patterns

        labels, groups = library.store.texts("label"), []
        for label in read_patterns(patterns, library.words):
            text = pattern_in(label.text, patterns.parent)
            hits = hits_in(library.search(text, **search_options))
            wanted = frozenset(number for number, it in labels.items() if label.wants(it))
            group = of_hits(hits, label.name)
            groups.append(replace(group, expected=wanted))
        return groups
    requests = source.requests(library)
    if requests is not None:
        by_pattern: dict[str, list[Request]] = defaultdict(list)
        for request in requests:
            by_pattern[request.pattern].append(request)
        return [
            of_requests((it for it in requests if it.pattern == pattern), pattern)
            for pattern in dict.fromkeys(request.pattern for request in requests)
        ]
    if source.pattern is None:
        return [of_captures(library.captures(search_options["selection"]))]
    text = pattern_in(source.pattern)
    entry = entry_of_query(text, library.words)
    pattern = pattern_of(out, library, text, library.words)
    hits = hits_in(library.search(pattern, **search_options))
    sentence = entry.sentence if entry else None
    return [of_hits(hits, sentence=sentence, words=library.words)]


def _card_options(search_options: dict[str, Any]) -> dict[str, str]:
    """Return how clips were searched for, as a card has it."""
    selection = search_options["selection"]
    values = {
        "tolerance": f"{search_options['tolerance']:g} s",
        "overlaps": search_options["overlaps"],
        "strict": search_options["strict"],
        "near": search_options["near"],
        "edits allowed": search_options["fuzzy"],
        "captures": selection.path,
        "captures where": ", ".join(f"{key}={glob}" for key, glob in selection.where),
    }
    return {name: str(value) for name, value in values.items() if value}


def _report(out: Output, index: bytes, card: dict[str, Any], folder: Path) -> None:
    """Say what was written, and what was left out."""
    from json import loads

    if out.json:
        out.records(map(loads, index.splitlines()))
    for found in card["found"]:
        if found["label"]:
            out.note(f"{found['label']}: {counted(found['clips'], 'clip')}")
    for why, number in card["left_out"].items():
        out.note(f"left out: {counted(number, 'clip')}: {why}")
    splits = ", ".join(f"{split['clips']} {name}" for name, split in card["by_split"].items())
    time = duration(card["hours"] * 3600)
    out.note(f"{counted(card['clips'], 'clip')}, {time}, in {folder}: {splits}")
    out.note(f"splits by {card['split_by']}. {card['split_note']}".rstrip())
