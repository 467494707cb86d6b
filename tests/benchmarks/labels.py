"""What captures from everywhere are labelled with, as patterns: found, or why not.

    python tests/benchmarks/labels.py

Prints for each line of labels.toml how many of the captures with such a label are found, then for
each that is missed what came nearest, and how many captures with other labels do the same. The
captures are those of LANINDEX_CAPTURES in every format, but the large collections, which have
tables of their own.
"""

from fnmatch import fnmatchcase
from pathlib import Path

from places import CAPTURES, HERE

from lanindex.encoding.profile import load as profile
from lanindex.evaluate import Clip, Expectation, evaluate, read_clips
from lanindex.notation.text import read_toml
from lanindex.pipeline.ingest import read_labels
from lanindex.search.dictionary import inside, load
from lanindex.search.language import parse

APART = ("bandai1", "bandai2", "mae_openni")


def clips() -> list[Clip]:
    """Return every labelled capture that can be read."""
    labels = read_labels(CAPTURES / "labels.csv")
    found = list(read_clips(CAPTURES, labels, profile("default"), jobs=1))
    return [
        one for one in found if one.tracks and not set(Path(one.capture.path).parts) & set(APART)
    ]


def main() -> None:
    captures, words = clips(), {name: inside(it.pattern) for name, it in load().items()}
    lines = {
        name: (it["labels"], it["pattern"]) for name, it in read_toml(HERE / "labels.toml").items()
    }
    asked = [
        Expectation(
            name,
            pattern,
            parse(pattern, names=words),
            frozenset(labels),
        )
        for name, (labels, pattern) in lines.items()
        if pattern
    ]
    results = {it.expectation.name: it for it in evaluate(captures, asked)}
    print(f"{len(captures)} captures\nlabel            found     others  pattern")
    told = []
    for name, (labels, pattern) in lines.items():
        wanted = [any(fnmatchcase(it.capture.label, one) for one in labels) for it in captures]
        if name not in results:
            print(f"{name:16} 0 of {sum(wanted):2}          no movement: whatever it may be")
            continue
        result = results[name]
        right, more, missed = result.counts()
        print(f"{name:16} {right} of {right + missed:2}  {more:8}  {pattern}")
        told += [
            f"{name}: {Path(one.capture.path).name} ({one.capture.label}): {result.obstacle(one)}"
            for one in result.misses
            if one.hit is None
        ]
    print("\n".join(["", *told]))


if __name__ == "__main__":
    main()
