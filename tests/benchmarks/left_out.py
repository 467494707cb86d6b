"""How well patterns find movement of people, styles and collections that they were not made on.

    python tests/benchmarks/left_out.py [bandai1 | bandai2 | mae | words ...]

Each group of clips is left out in turn: a style of Bandai-Namco, a performer of MAE; a collection
for words that were seen in several. What a pattern could do without is then chosen on the other
groups alone: an alternative, a condition or a line beside the first stays only if those clips need
it, and a time, an angle or a speed is a tenth more or less if that is better there. The pattern so
made is judged on the group that was left out. The figures stand beside those of the pattern as it
is written, which was made with all groups in view.

Ends with 1 where the numbers in dictionary.toml are not those that were measured, and prints the
lines to put there. The captures are the BVH files of LANINDEX_CAPTURES.
"""

import re
import sys
from collections import Counter
from collections.abc import Callable, Collection, Iterator, Sequence
from dataclasses import astuple, fields
from fnmatch import fnmatchcase
from functools import cache
from pathlib import Path
from statistics import mean

from places import CAPTURES, HERE

from lanindex.encoding.profile import load as profile
from lanindex.errors import PatternError
from lanindex.evaluate import Clip, read_clips, read_patterns
from lanindex.notation.text import read_toml
from lanindex.pipeline.ingest import read_labels
from lanindex.pipeline.search import SearchOptions, searcher
from lanindex.search.dictionary import Measured, entries, load
from lanindex.search.language import parse

FOLDER = CAPTURES / "bvh"
SETS = {"bandai1": "bandai1", "bandai2": "bandai2", "mae": "mae_openni"}
"""The collection of each file of patterns."""

GROUP = {"bandai1": 2, "bandai2": 2, "mae_openni": 0}
"""Which word of a file's name is the style or performer, by collection."""

BESIDE = ("with", "without", "never", "starting", "ending", "during", "after", "before")
BEGINS = (*BESIDE, "or", "where", "either")
FIRST_OF_TWO = ("starting", "ending")
NUMBER = re.compile(r"(?<![\w.])(\d+(?:\.\d+)?)(?=s\b|deg\b|\s*$)")

Counts = tuple[int, int, int]
"""Clips found rightly, found wrongly, and missed."""


def collection(clip: Clip) -> str:
    return Path(clip.capture.path).relative_to(FOLDER).parts[0]


def group(clip: Clip) -> str:
    """Return who moves, or how: the performer or style of a clip, else its collection."""
    folder, name = collection(clip), Path(clip.capture.path).stem.split("_")
    return f"{folder} {name[GROUP[folder]]}" if folder in GROUP else folder


def pieces(text: str) -> Iterator[str]:
    """Yield the first line of a pattern, then each relation, condition and alternative."""
    depth, piece = 0, []
    for word in re.sub(r"//[^\n]*", " ", text).split():
        begins = word.split("[")[0] in BEGINS and not (piece and piece[-1] in FIRST_OF_TWO)
        if piece and begins and not depth:
            yield " ".join(piece)
            piece = []
        piece.append(word)
        depth += word.count("(") - word.count(")")
    yield " ".join(piece)


class Judge:
    """What patterns find in some clips; each pattern is searched for once."""

    def __init__(self, clips: Sequence[Clip], labels: Collection[str]) -> None:
        self.wanted = {
            it.capture.id: any(fnmatchcase(it.capture.label, glob) for glob in labels)
            for it in clips
        }
        captures, tracks = [it.capture for it in clips], [it.tracks for it in clips]
        self.search = searcher(captures, tracks, SearchOptions.read())
        self.found = cache(self._found)

    def _found(self, text: str) -> frozenset[int] | None:
        """Return the numbers of the clips with a hit; None where the text is no pattern."""
        try:
            hits = self.search(parse(text), lambda *_: None, [])
        except PatternError:
            return None
        return frozenset(capture.id for capture, _ in hits.spans())

    def counts(self, text: str, numbers: Collection[int]) -> Counts:
        found = self.found(text)
        tally = Counter((number in found, self.wanted[number]) for number in numbers)
        return tally[True, True], tally[True, False], tally[False, True]

    def f1(self, text: str, numbers: Collection[int]) -> float:
        return -1.0 if self.found(text) is None else f1(self.counts(text, numbers))

    def made_on(self, text: str, numbers: Collection[int]) -> str:
        """Return the pattern that these clips alone would have left of a written one."""
        kept = list(pieces(text))
        best = self.f1(" ".join(kept), numbers)
        for piece in kept[:0:-1]:
            fewer = [it for it in kept if it is not piece]
            if piece != "either side" and self.f1(" ".join(fewer), numbers) >= best:
                kept, best = fewer, self.f1(" ".join(fewer), numbers)
        text = " ".join(kept)
        for place in range(len(NUMBER.findall(text))):
            for factor in (0.9, 1.1):
                number = list(NUMBER.finditer(text))[place]
                value = f"{float(number[1]) * factor:.4g}"
                other = f"{text[: number.start()]}{value}{text[number.end() :]}"
                if self.f1(other, numbers) > best:
                    text, best = other, self.f1(other, numbers)
                    break
        return text

    def left_out(self, text: str, folds: dict[str, list[int]]) -> dict[str, Counts]:
        """Return the counts of each group by a pattern that was made on the others."""
        told = {}
        for name, inside in folds.items():
            others = [it for other in folds if other != name for it in folds[other]]
            made = any(self.wanted[it] for it in others)
            told[name] = self.counts(self.made_on(text, others) if made else text, inside)
        return told


def f1(counts: Counts) -> float:
    right, wrong, missed = counts
    return 2 * right / max(1, 2 * right + wrong + missed)


def total(counts: Collection[Counts]) -> Counts:
    return tuple(map(sum, zip(*counts, strict=True)))


def folds_of(clips: Sequence[Clip], by: Callable[[Clip], str]) -> dict[str, list[int]]:
    folds: dict[str, list[int]] = {}
    for clip in clips:
        folds.setdefault(by(clip), []).append(clip.capture.id)
    return folds


def mistakes(told: dict[str, Counts]) -> str:
    """Return in which groups clips were judged wrongly."""
    return ", ".join(
        f"{name.split()[-1]}: {wrong} wrong, {missed} missed"
        for name, (_, wrong, missed) in told.items()
        if wrong or missed
    )


def tell_set(name: str, every: Sequence[Clip]) -> None:
    """Print the figures of a file of patterns."""
    clips = [it for it in every if collection(it) == SETS[name]]
    folds, columns = folds_of(clips, group), []
    print(f"\n{name}.toml: {len(clips)} clips, {len(folds)} groups")
    print("pattern          clips  as written  left out  judged wrongly where left out")
    for it in read_patterns(HERE / f"{name}.toml"):
        judge = Judge(clips, it.positives)
        written = judge.counts(it.text, judge.wanted)
        told = judge.left_out(it.text, folds)
        columns.append((f1(written), f1(total(told.values()))))
        figures = f"{columns[-1][0]:10.3f}  {columns[-1][1]:8.3f}"
        print(f"{it.name:15} {sum(judge.wanted.values()):6}  {figures}  {mistakes(told)}")
    written, made = (mean(column) for column in zip(*columns, strict=True))
    print(f"mean F1         {len(clips):6}  {written:10.3f}  {made:8.3f}", flush=True)


def tell_words(every: Sequence[Clip]) -> bool:
    """Print the figures of the dictionary; return whether those that it holds are others."""
    open_labels, stale = read_toml(HERE / "dictionary.toml"), []
    print("\nword            as written     left out  clips in collections  judged wrongly")
    for entry in entries(load()):
        judge = Judge(every, entry.labels)
        unjudged = [*open_labels["everywhere"], *open_labels.get(entry.name, ())]
        clips = [
            it
            for it in every
            if judge.wanted[it.capture.id]
            or not any(fnmatchcase(it.capture.label, glob) for glob in unjudged)
        ]
        among = {collection(it) for it in clips if judge.wanted[it.capture.id]}
        folds = folds_of(clips, collection if len(among) > 1 else group)
        told = judge.left_out(entry.pattern, folds)
        counts = Measured(*total(told.values()), len(clips), len(among))
        written = judge.counts(entry.pattern, [it.capture.id for it in clips])
        figures = "  ".join(
            f"{right / max(1, right + wrong):.2f} / {right / (right + missed):.2f}"
            for right, wrong, missed in (written, astuple(counts)[:3])
        )
        seen = f"{counts.wanted:5} in {len(among)}"
        print(f"{entry.name:14}  {figures}  {seen}  {mistakes(told)}", flush=True)
        if counts != entry.measured:
            values = ", ".join(f"{it.name} = {getattr(counts, it.name)}" for it in fields(counts))
            stale.append(f"[{entry.name}]\nmeasured = {{ {values} }}")
    if stale:
        print("\nThe numbers in dictionary.toml are others. Put there:\n" + "\n".join(stale))
    return bool(stale)


def main(asked: Sequence[str]) -> int:
    labels = read_labels(CAPTURES / "labels.csv")
    read = read_clips(FOLDER, labels, profile("default"), jobs=2)
    clips = [it for it in read if it.capture.label]
    for name in SETS:
        if not asked or name in asked:
            tell_set(name, clips)
    return int((not asked or "words" in asked) and tell_words(clips))


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
