"""How well the words of the dictionary of movement find the labelled captures.

    python tests/benchmarks/dictionary.py

Prints a line a word, then what was judged wrongly, and ends with 1 where the numbers in
dictionary.toml are not those that were measured, with the lines to put there. The captures are the
BVH files of LANINDEX_CAPTURES.
"""

import sys
from fnmatch import fnmatchcase
from pathlib import Path

from places import CAPTURES, HERE

from lanindex.encoding.profile import load as profile
from lanindex.evaluate import Clip, Expectation, Result, evaluate, read_clips
from lanindex.notation.text import read_toml
from lanindex.pipeline.ingest import read_labels
from lanindex.search.dictionary import Measured, entries, load
from lanindex.search.language import parse

FOLDER = CAPTURES / "bvh"


def collection(clip: Clip) -> str:
    return Path(clip.capture.path).relative_to(FOLDER).parts[0]


def judged(result: Result, clips: list[Clip], unjudged: list[str]) -> tuple[Measured, list[str]]:
    """Return the counts of a word, and the captures that were judged wrongly."""
    triples = [
        (clip, found, wanted)
        for clip, found, wanted in zip(clips, result.found, result.wanted, strict=True)
        if wanted or not any(fnmatchcase(clip.capture.label, glob) for glob in unjudged)
    ]
    pairs = [triple[1:] for triple in triples]
    right, wrong, missed = (pairs.count(it) for it in ((True, True), (True, False), (False, True)))
    among = {collection(clip) for clip, found, wanted in triples if found and wanted}
    mistakes = [
        f"{'missed' if wanted else 'wrong '} {Path(clip.capture.path).stem} ({clip.capture.label})"
        for clip, found, wanted in triples
        if found != wanted
    ]
    return Measured(right, wrong, missed, len(triples), len(among)), mistakes


def line(counts: Measured) -> str:
    told = ", ".join(f"{name} = {getattr(counts, name)}" for name in Measured.__dataclass_fields__)
    return f"measured = {{ {told} }}"


def main() -> int:
    unjudged = read_toml(HERE / "dictionary.toml")
    labels = read_labels(CAPTURES / "labels.csv")
    read = read_clips(FOLDER, labels, profile("default"), jobs=2)
    clips = [clip for clip in read if clip.capture.label]
    print(f"{len(clips)} labelled captures\nword           prec   recall right wrong missed")
    words = entries(load())
    wanted = [
        Expectation(it.name, it.pattern, parse(it.pattern), frozenset(it.labels)) for it in words
    ]
    stale, told = [], []
    for entry, result in zip(words, evaluate(clips, wanted), strict=True):
        open_labels = [*unjudged["everywhere"], *unjudged.get(entry.name, ())]
        counts, mistakes = judged(result, clips, open_labels)
        print(
            f"{entry.name:14} {counts.precision:.3f}  {counts.recall:.3f}  {counts.right:5}"
            f" {counts.wrong:5} {counts.missed:6}"
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
