"""How well the words of the dictionary of movement find the labelled captures.

    python tests/benchmarks/dictionary.py

Prints a line a word, then what was judged wrongly, and ends with 1 where the numbers in
dictionary.toml are not those that were measured, with the lines to put there. The captures are the
BVH files of LANINDEX_CAPTURES.
"""

import sys
import time
from fnmatch import fnmatchcase
from pathlib import Path

from places import CAPTURES, HERE

from lanindex.encode.profile import load as profile
from lanindex.evaluate import Clip, read_clips
from lanindex.notation.text import read_toml
from lanindex.pipeline.labels import read_labels
from lanindex.search.dictionary import Entry, Measured, entries, load
from lanindex.search.language import parse
from lanindex.search.plain import find

FOLDER = CAPTURES / "bvh"


def fits(label: str, globs: list[str]) -> bool:
    return any(fnmatchcase(label, glob) for glob in globs)


def collection(clip: Clip) -> str:
    return Path(clip.capture.path).relative_to(FOLDER).parts[0]


def measured(entry: Entry, clips: list[Clip], unjudged: list[str]) -> tuple[Measured, list[str]]:
    """Return the counts of a word, and the captures that were judged wrongly."""
    wanted = list(entry.labels)
    judged = [
        clip
        for clip in clips
        if fits(clip.capture.label, wanted) or not fits(clip.capture.label, unjudged)
    ]
    recordings = [(clip.capture, clip.tracks) for clip in judged]
    found = {hit.capture.id for hit in find(parse(entry.pattern), recordings)}
    pairs = [(clip.capture.id in found, fits(clip.capture.label, wanted)) for clip in judged]
    right, wrong, missed = (pairs.count(it) for it in ((True, True), (True, False), (False, True)))
    among = {collection(clip) for clip, pair in zip(judged, pairs, strict=True) if all(pair)}
    mistakes = [
        f"{'missed' if should else 'wrong '} {Path(clip.capture.path).stem} ({clip.capture.label})"
        for clip, (got, should) in zip(judged, pairs, strict=True)
        if got != should
    ]
    return Measured(right, wrong, missed, len(judged), len(among)), mistakes


def line(counts: Measured) -> str:
    told = ", ".join(f"{name} = {getattr(counts, name)}" for name in Measured.__dataclass_fields__)
    return f"measured = {{ {told} }}"


def main() -> int:
    unjudged = read_toml(HERE / "dictionary.toml")
    labels = read_labels(CAPTURES / "labels.csv")
    read = read_clips(FOLDER, labels, profile("default"), jobs=2)
    clips = [clip for clip in read if clip.capture.label]
    print(f"{len(clips)} labelled captures\nword           prec   recall right wrong missed  s")
    stale, told = [], []
    for entry in entries(load()):
        begin = time.perf_counter()
        open_labels = [*unjudged["everywhere"], *unjudged.get(entry.name, ())]
        counts, mistakes = measured(entry, clips, open_labels)
        lasted = time.perf_counter() - begin
        print(
            f"{entry.name:14} {counts.precision:.3f}  {counts.recall:.3f}  {counts.right:5}"
            f" {counts.wrong:5} {counts.missed:6}  {lasted:.1f}",
            flush=True,
        )
        told += [f"{entry.name}: {mistake}" for mistake in mistakes]
        if counts != entry.measured:
            stale.append(f"[{entry.name}]\n{line(counts)}")
    print("\nJudged wrongly\n" + "\n".join(told))
    if stale:
        print("\nThe numbers in dictionary.toml are others. Put there:\n" + "\n".join(stale))
    return 1 if stale else 0


if __name__ == "__main__":
    sys.exit(main())
