"""What is usual of measures, by group of parts: what ``fast`` and ``small`` are made of.

    python tests/benchmarks/measures.py

Over all captures of LANINDEX_CAPTURES but those that were made of others: the percentiles of speed,
size and straightness of the symbols that a score shows. Each dataset (a folder) that has `FEWEST`
symbols of a group (of the whole body `FEW`) weighs the same. Then how steady measures are, in
tracks that keep their symbols: at half the frames a second and at a quarter, and with noise of 2 mm
on every coordinate.
"""

import csv
import sys
from collections import defaultdict
from collections.abc import Callable, Iterator
from dataclasses import replace

import numpy as np
from places import CAPTURES, changed

from lanindex.alphabet import MEASURES, PARTS
from lanindex.encoding import encode
from lanindex.errors import LanindexError
from lanindex.formats import read
from lanindex.model import Motion, Score
from lanindex.model.columns import LIMITS

FEWEST, FEW = 20, 5
SHARES = (5, 20, 50, 80, 95)
"""Percentiles."""

CHANGES: dict[str, Callable[[Motion], Motion]] = {
    "1/2 of the frames": lambda motion: changed.thinned(motion, 2),
    "1/4 of the frames": lambda motion: changed.thinned(motion, 4),
    "noise of 2 mm": lambda motion: changed.noisy(motion, 2.0),
}
"""Frames are left out of captures that have 100 a second at least."""

Told = list[tuple[float, ...]]


def captures() -> Iterator[tuple[str, Motion]]:
    """Yield all captures that were not made of others, with the names of their datasets."""
    with (CAPTURES / "provenance.csv").open(encoding="utf-8") as table:
        made = {
            row["file"] for row in csv.DictReader(table) if row["origin_repo"].startswith("derived")
        }
    for path in sorted(CAPTURES.rglob("*.*")):
        name = path.relative_to(CAPTURES)
        if name.as_posix() in made or len(name.parts) < 2 or path.suffix == ".lnd":
            continue
        try:
            yield "/".join(name.parts[:-1][:2]), read(path)
        except LanindexError:
            continue


def measured(score: Score, part: str) -> Told:
    """Return the measures of a part's symbols, without those on the way."""
    shown = [one for one in score.symbols(part) if not one.passing and one.speed is not None]
    return [tuple(float(getattr(one, name) or 0) for name in MEASURES) for one in shown]


def group(part: str) -> str:
    return PARTS[part].group if part in PARTS else part


def percentiles(datasets: list[np.ndarray]) -> np.ndarray:
    """Return the percentiles of values, all datasets weighing the same: (5,)."""
    values = np.concatenate(datasets)
    weights = np.concatenate([np.full(len(one), 1 / len(one)) for one in datasets])
    order = np.argsort(values, kind="stable")
    reached = np.cumsum(weights[order]) / weights.sum()
    return values[order][np.searchsorted(reached, np.array(SHARES) / 100).clip(max=len(values) - 1)]


def main() -> int:
    told: dict[str, dict[str, Told]] = defaultdict(lambda: defaultdict(list))
    steady: dict[str, dict[str, list[np.ndarray]]] = defaultdict(lambda: defaultdict(list))
    for dataset, motion in captures():
        score = encode(motion)
        parts = [part for part in score.tracks if group(part) in LIMITS]
        for part in parts:
            told[group(part)][dataset] += measured(score, part)
        for name, change in CHANGES.items():
            if "noise" not in name and motion.rate < 100:
                continue
            other = encode(change(replace(motion, rotations=None)))
            for part in parts:
                same = part in other.tracks
                if same and changed.shown(score, part) == changed.shown(other, part):
                    pair = np.array([measured(score, part), measured(other, part)])
                    steady[name][group(part)] += [pair] * bool(pair.size)
    for place, measure in enumerate(MEASURES):
        heads = " ".join(f"{f'p{share}':>6}" for share in SHARES)
        print(f"{measure:14} {heads}  symbols datasets  called")
        for name, limits in LIMITS.items():
            if name.startswith("body") and measure != "speed":
                continue
            fewest = FEW if name.startswith("body") else FEWEST
            held = [np.array(it)[:, place] for it in told[name].values() if len(it) >= fewest]
            said = " ".join(f"{it:6.2f}" for it in percentiles(held))
            called = limits.get(measure, "")
            print(f"{name:14} {said} {sum(map(len, held)):8} {len(held):8}  {called}")
    for change, groups in steady.items():
        print(f"{change}: how far measures move, half of them and nine of ten")
        for name, pairs in groups.items():
            one, other = np.concatenate(pairs, axis=1)
            apart = np.abs(one - other)
            apart[:, 0] /= np.maximum(one[:, 0], 0.01)
            said = [f"{a:.3f} {b:.3f}" for a, b in np.percentile(apart, (50, 90), axis=0).T]
            print(f"  {name:12} speed (share) {said[0]}, size {said[1]}, straightness {said[2]}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
