"""``lanindex export``: write hits as clips or, with --dataset, as a data set to train on."""

from __future__ import annotations

import sys
from collections.abc import Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from lanindex.app import completion, options
from lanindex.app.commands.words import pattern_of
from lanindex.app.output import Output, counted, duration, end_progress
from lanindex.errors import UsageError

if TYPE_CHECKING:
    from lanindex.pipeline import Library
    from lanindex.pipeline.dataset import ClipGroup, Made

    Stretch = tuple[str | None, int | None, int | None]  # a capture, its first frame and its end


def run(
    what: Annotated[
        str | None,
        typer.Argument(
            metavar="PATTERN|-",
            help="A pattern, or - for hits from search --json.",
            autocompletion=completion.patterns,
        ),
    ] = None,
    output: Annotated[
        Path | None, typer.Option("--output", "-o", metavar="FOLDER", help="Where to write: clips.")
    ] = None,
    capture: Annotated[
        str | None,
        typer.Option(
            "--capture",
            metavar="PATH|ID",
            help="Cut from this capture.",
            autocompletion=completion.captures,
        ),
    ] = None,
    begin: Annotated[
        int | None, typer.Option("--from", metavar="FRAME", min=0, help="First frame.")
    ] = None,
    end: Annotated[
        int | None, typer.Option("--to", metavar="FRAME", min=1, help="Frame after the last.")
    ] = None,
    format: Annotated[
        str,
        typer.Option(
            metavar="native|bvh|c3d|...|lnd", help="The format to write; --format ? lists them."
        ),
    ] = "native",
    origin: options.Origin = False,
    preview: Annotated[
        str | None,
        typer.Option("--preview", metavar="webp|gif|mp4", help="Write a film beside each clip."),
    ] = None,
    pad: Annotated[
        str, typer.Option(metavar="TIME", help="Time around each hit: 0.5s, 200ms, 10f.")
    ] = "0",
    dataset: Annotated[
        Path | None,
        typer.Option(metavar="FOLDER", help="Write a data set to train on, instead of clips."),
    ] = None,
    patterns: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="Its labels, each with its pattern, as for evaluate."),
    ] = None,
    layout: Annotated[
        str | None, typer.Option(metavar="npz|humanml3d", help="The files of a data set.")
    ] = None,
    fps: Annotated[
        str | None, typer.Option(metavar="RATE", help="Frame rate of a data set.")
    ] = None,
    split: Annotated[
        str | None,
        typer.Option(metavar="80/10/10", help="Per cent for training, validation, test."),
    ] = None,
    split_by: Annotated[
        str | None, typer.Option(metavar="COLUMN", help="What must stay in one split: performer.")
    ] = None,
    seed: Annotated[int | None, typer.Option(metavar="N", help="Seed of the splits.")] = None,
    within: options.In = None,
    where: options.Where = None,
    overlaps: options.Overlaps = "none",
    strict: options.Strict = False,
    tolerance: options.Tolerance = 0.1,
    near: options.Near = False,
    fuzzy: options.Fuzzy = None,
    words: options.Words = None,
    force: options.Force = False,
    db: options.Db = options.DB,
    *,
    out: options.Out,
) -> None:
    """Write hits as clips, in their own format or another.

    A clip in its source's format is cut out of it, byte for byte where the format allows that. In
    another format (--format), or at the origin (--origin), it is written anew. Each clip comes
    with its score (.lnd) and, with --preview, a film; a manifest lists them all. With --dataset,
    hits become arrays of joints, symbols and words, in splits, with a card; without a pattern,
    whole captures do.
    """
    how: dict[str, Any] = {"tolerance": tolerance, "overlaps": overlaps, "strict": strict}
    how |= {"near": near, "fuzzy": fuzzy, "selection": options.selection(within, where)}
    stretch = (capture, begin, end)
    of_dataset: dict[str, Any] = {
        "--patterns": patterns,
        "--layout": layout,
        "--fps": fps,
        "--split": split,
    }
    of_dataset |= {"--split-by": split_by, "--seed": seed}
    if dataset is None:
        _refuse({name: it is not None for name, it in of_dataset.items()}, "--dataset beside it")
    else:
        of_clips = {"--output": output is not None, "--format": format != "native"}
        of_clips |= {"--origin": origin, "--preview": preview is not None}
        _refuse(of_clips, "nothing of the kind beside --dataset")
    _check_source(what, patterns, stretch, how, whole=dataset is not None)
    from lanindex.pipeline import open_library

    with open_library(db, readonly=True, words=words, note=out.note, progress=out.watch) as library:
        if dataset is None:
            written = _clips(
                out, library, what, stretch, how, output or Path("clips"),
                {"pad": pad, "force": force, "format": format, "origin": origin,
                 "preview": preview},
            )  # fmt: skip
        else:
            dataset_options: dict[str, Any] = {
                "layout": layout,
                "rate": fps and options.rate(fps),
                "shares": split,
            }
            dataset_options |= {"split_by": split_by, "seed": seed, "pad": pad, "force": force}
            written = _dataset(out, library, what, patterns, stretch, how, dataset, dataset_options)
    if library.refused or not written:
        raise typer.Exit(2 if library.refused else 1)


def _refuse(given: Mapping[str, bool], wanted: str) -> None:
    """Refuse the first option that is given."""
    for name, is_given in given.items():
        if is_given:
            raise UsageError(name, wanted=wanted)


def _check_source(
    what: str | None, patterns: Path | None, stretch: Stretch, how: dict[str, Any], *, whole: bool
) -> None:
    """Refuse several sources of clips, or none; a data set may be of `whole` captures."""
    capture = stretch[0]
    named = {"a pattern": what, "--patterns": patterns, "--capture": capture}
    given = [name for name, value in named.items() if value is not None]
    if not whole and len(given) != 1:
        found = "two things to export" if given else "nothing to export"
        raise UsageError(found, wanted="a pattern, - or --capture")
    if len(given) > 1:
        raise UsageError(" and ".join(given), wanted="one of them")
    if capture is None and stretch != (None, None, None):
        raise UsageError("--from and --to", wanted="--capture beside them")
    filtered = bool(how["selection"].globs)
    if filtered and (capture is not None or what == "-"):
        wanted = "patterns, or whole captures, beside them" if whole else "a pattern beside them"
        raise UsageError("--in and --where", wanted=wanted)


def _clips(
    out: Output,
    library: Library,
    what: str | None,
    stretch: Stretch,
    how: dict[str, Any],
    folder: Path,
    form: dict[str, Any],
) -> int:
    """Write clips, and return how many."""
    from lanindex.pipeline.export import export, from_hits, from_lines, from_range
    from lanindex.search.hits import hits_in
    from lanindex.search.language.score import pattern_in

    capture, begin, end = stretch
    if capture is not None:
        requests = iter([from_range(library.store, options.capture_id(capture), begin, end)])
    elif what == "-":
        requests = iter(from_lines(library.store, sys.stdin.buffer if sys.stdin else ()))
    else:
        pattern = pattern_of(out, library, pattern_in(str(what)), library.words)
        found = library.search(pattern, **how)
        end_progress()
        requests = iter(from_hits(hits_in(found), found.pattern))
    manifest = export(library.store, requests, folder, **form)
    for row in manifest:
        if out.json:
            out.record(row)
        else:
            out.line(str(folder / row["clip"]))
    out.note(f"{counted(len(manifest), 'clip')} in {folder}")
    return len(manifest)


def _dataset(
    out: Output,
    library: Library,
    what: str | None,
    patterns: Path | None,
    stretch: Stretch,
    how: dict[str, Any],
    folder: Path,
    dataset_options: dict[str, Any],
) -> int:
    """Write a data set, and return its size in bytes."""
    from lanindex.pipeline.dataset import DatasetOptions, of_captures, write

    given = {name: value for name, value in dataset_options.items() if value is not None}
    if patterns is not None:
        found = list(_of_labels(library, patterns, how))
    elif stretch[0] is not None or what == "-":
        found = _of_requests(library, stretch)
    elif what is not None:
        found = [_of_pattern(out, library, what, how)]
    else:
        found = [of_captures(library.captures(how["selection"]))]
    end_progress()
    made = write(
        library.store, found, folder, replace(DatasetOptions(how=dict(_on_card(how))), **given)
    )
    end_progress()
    _report(out, made, folder)
    return len(made.clips)


def _on_card(how: Mapping[str, Any]) -> Iterator[tuple[str, str]]:
    """Yield how clips were searched for, as a card has it."""
    selection = how["selection"]
    rest = {name: value for name, value in how.items() if name != "selection"}
    rest["captures"] = selection.path
    rest["captures where"] = ", ".join(f"{key}={glob}" for key, glob in selection.where)
    for name, value in rest.items():
        if value or name == "tolerance":
            name = "edits allowed" if name == "fuzzy" else name
            yield name, f"{value:g} s" if name == "tolerance" else str(value)


def _of_pattern(out: Output, library: Library, what: str, how: dict[str, Any]) -> ClipGroup:
    """Return the hits of one pattern, with a sentence for it."""
    from lanindex.pipeline.dataset import of_hits
    from lanindex.pipeline.dataset.texts import of_pattern
    from lanindex.pipeline.words import meant, named
    from lanindex.search.hits import hits_in
    from lanindex.search.language.score import pattern_in

    text = pattern_in(what)
    entry = meant(text, library.words)
    pattern = pattern_of(out, library, text, library.words)
    found = hits_in(library.search(pattern, **how))
    sentence = of_pattern(str(pattern), named(str(pattern), library.words))
    return of_hits(found, sentence=entry.sentence if entry else sentence)


def _of_labels(library: Library, patterns: Path, how: dict[str, Any]) -> Iterator[ClipGroup]:
    """Yield the hits of each pattern in a file, and the captures that should have some."""
    from lanindex.evaluate import read_patterns
    from lanindex.pipeline.dataset import of_hits
    from lanindex.pipeline.dataset.texts import of_pattern
    from lanindex.search.hits import hits_in
    from lanindex.search.language.score import pattern_in

    labels = library.store.texts("label")
    for label in read_patterns(patterns):
        text = pattern_in(label.text, patterns.parent)
        found = of_hits(hits_in(library.search(text, **how)), label.name, of_pattern(text))
        wanted = frozenset(number for number, it in labels.items() if label.wants(it))
        yield replace(found, expected=wanted)


def _of_requests(library: Library, stretch: Stretch) -> list[ClipGroup]:
    """Return a stretch of a capture, or the hits on standard input by their pattern."""
    from lanindex.pipeline.dataset import of_requests
    from lanindex.pipeline.dataset.texts import of_pattern
    from lanindex.pipeline.export import from_lines, from_range

    capture, begin, end = stretch
    if capture is not None:
        return [of_requests([from_range(library.store, options.capture_id(capture), begin, end)])]
    requests = from_lines(library.store, sys.stdin.buffer if sys.stdin else ())
    return [
        of_requests((it for it in requests if it.pattern == pattern), sentence=of_pattern(pattern))
        for pattern in dict.fromkeys(request.pattern for request in requests)
    ]


def _report(out: Output, made: Made, folder: Path) -> None:
    """Say what was written, and what was left out."""
    from json import loads

    if out.json:
        for line in made.clips.splitlines():
            out.record(loads(line))
    card = made.card
    for found in card["found"]:
        if found["label"]:
            out.note(f"{found['label']}: {counted(found['clips'], 'clip')}")
    for why, number in card["left_out"].items():
        out.note(f"left out: {counted(number, 'clip')}: {why}")
    splits = ", ".join(f"{split['clips']} {name}" for name, split in card["by_split"].items())
    time = duration(card["hours"] * 3600)
    out.note(f"{counted(card['clips'], 'clip')}, {time}, in {folder}: {splits}")
    out.note(f"splits by {card['split_by']}. {card['split_note']}".rstrip())
