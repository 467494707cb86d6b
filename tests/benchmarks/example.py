"""How well a search by example finds captures of the same kind, beside edit distance and warping.

    python tests/benchmarks/example.py

Of each labelled capture the others are ranked by how like it they are: 1-NN is how often the first
has the same label, MAP the mean average precision; "others" allows only captures of other styles
(or performers). Two sets of LANINDEX_CAPTURES: `bvh/bandai2`, 80 clips of ten classes (raise up
and wave: left, right and both hands; run; walk; walk and turn left, right), twice each in four
styles; `bvh/mae_openni`, 84 clips of fourteen gestures of the arms by depth camera, 6 a class by
three performers. No weight was fitted to labels: the costs were chosen by hand among a few values.

Milliseconds are of one ranking of all other clips of the set, of the processor, medians of rankings
that took turns: edit distance by rapidfuzz, the others in numpy.

bandai2                                       1-NN all, others  MAP all, others      ms
  edit distance of symbols                        .850  .675      .529  .580        0.8
  alignment with angles (whole clips)             .912  .725      .537  .641        4.9
  as `search --like` does (stretches, too)        .912  .725      .532  .635       25
  warped joint positions, by the frame            .675  .588      .429  .535      413
  warped joint positions, in all                  .662  .487      .403  .424
mae_openni
  edit distance of symbols                        .750  .786      .559  .577        0.8
  alignment with angles (whole clips)             .857  .845      .759  .797        1.9
  as `search --like` does (stretches, too)        .857  .845      .759  .797
  warped joint positions, by the frame            .810  .738      .633  .692      308
  warped joint positions, in all                  .750  .667      .588  .617

So what a search ranks by beats edit distance and warping in all four figures of both sets, plain in
an eighty-fifth (bandai2) and a hundred-and-sixtieth (mae_openni) of the processor's time that
warping takes, on a busy machine.

What was tried, on bandai2; on mae_openni:

    the bound alone: best partners, no order      .863 .750 .549 .647; .857 .821 .722 .763
    dwelling: time in cells, blurred              .650 .487 .433 .516; .714 .702 .568 .605
    all parts jointly: poses of symbols, warped   .637 .500 .407 .512; .774 .750 .648 .695
    without runner-up cells                       .900 .688 .532 .622; .833 .810 .722 .767
    without swings                                .900 .725 .541 .635; .833 .845 .760 .799
    SUBSTITUTED 0.4 in place of 0.8               .887 .775 .576 .644; .750 .798 .634 .676
    SUBSTITUTED 1.6                               .900 .750 .473 .607; .929 .917 .858 .883
    STEP 0.125 in place of 0.25                   .912 .713 .524 .633; .869 .881 .789 .833
    STEP 0.5                                      .900 .750 .553 .651; .810 .821 .700 .746
    stretches of clips from twice the length on   .875 .713 .508 .618; .845 .845 .779 .817

The last one is with STEP 0.2: a stretch of a clip that is merely somewhat longer than the example
beats clips that are of its kind, so that --like fell below edit distance.

Order matters little. The two sets pull opposite ways: whole limbs against small differences of one
arm; the values stand between. PACE and POSE change little. Left, too: weights of parts by how
rarely they move in the set (.01 to .03 worse in the mean of all figures), the logarithm of how far
each part moves added (MAP of bandai2 .02 better, of mae_openni .03 worse), the mean of what each
part shares (.03 to .2 worse), CALM 3 to 12 (changes little).
"""

import sys
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from statistics import median
from time import process_time

import numpy as np
import places
from made_clips import clips_of, source_of
from rapidfuzz.distance import Levenshtein

from lanindex.alphabet import PARTS
from lanindex.encoding import encode
from lanindex.formats import read
from lanindex.pipeline.ingest import read_labels
from lanindex.pipeline.warping import normalised, warped
from lanindex.search import sphere
from lanindex.search.example import likeness
from lanindex.search.example.likeness import Clips, ClipSource

STYLES: dict[str, Callable[[Path], str]] = {
    "bandai2": lambda path: path.stem.split("_")[-2],
    "mae_openni": lambda path: path.stem.split("_")[0],
}
"""What tells a clip's style or performer, by set."""

TIMED = 20
"""Rankings whose time is taken."""


@dataclass(frozen=True)
class Set:
    """Labelled clips: their words, their symbols, their joints."""

    name: str
    labels: np.ndarray
    styles: np.ndarray
    frames: list[int]
    rates: list[float]
    rows: list[dict[str, np.ndarray]]
    joints: list[np.ndarray]
    cells: list[list[bytes]]

    @property
    def parts(self) -> list[str]:
        return [part for part in PARTS if part in self.rows[0]]

    def clips(self, change: Callable[[np.ndarray], np.ndarray] = np.asarray) -> Clips:
        rows = [{part: change(own) for part, own in clip.items()} for clip in self.rows]
        return clips_of(rows, self.rates, self.parts)

    def source(self) -> ClipSource:
        return source_of(self.rows, self.rates, self.parts, self.frames)


def loaded(name: str) -> Set:
    captures = places.CAPTURES
    labels = {path: label for path, (label, _) in read_labels(captures / "labels.csv").items()}
    paths = sorted((captures / "bvh" / name).rglob("*.bvh"))
    motions = [read(path) for path in paths]
    scores = [encode(motion) for motion in motions]
    rows = [
        {part: np.array(track.symbols) for part, track in score.tracks.items()} for score in scores
    ]
    joints = []
    for motion in motions:
        body = motion.skeleton.body
        own = np.asarray(motion.positions[motion.first :])[:, body]
        own[:, body < 0] = np.nan
        joints.append(normalised(own, float(motion.rate)))
    return Set(
        name,
        np.array([labels[str(path)] for path in paths]),
        np.array([STYLES[name](path) for path in paths]),
        [len(motion) for motion in motions],
        [float(motion.rate) for motion in motions],
        rows,
        joints,
        [[cells(clip, part) for part in PARTS] for clip in rows],
    )


def cells(clip: dict[str, np.ndarray], part: str) -> bytes:
    if part not in clip:
        return b""
    shown = clip[part][~clip[part]["passing"]]
    return bytes((shown["direction"] * 3 + shown["level"]).astype(np.uint8))


Ranking = Callable[[int], np.ndarray]
"""From a clip to how far all are from it."""


def edited(own: Set) -> Ranking:
    def far(one: int) -> np.ndarray:
        mine = own.cells[one]
        pairs = (zip(mine, other, strict=True) for other in own.cells)
        return np.array([sum(Levenshtein.distance(*pair) for pair in each) for each in pairs])

    return far


def aligned(own: Set, change: Callable[[np.ndarray], np.ndarray] = np.asarray) -> Ranking:
    laid_out = own.clips(change)
    windows = laid_out.full_windows()
    each = [laid_out.cut(one, 0, frames) for one, frames in enumerate(own.frames)]
    return lambda one: -likeness.compared(each[one], windows)


def searched(own: Set) -> Ranking:
    laid_out, source = own.clips(), own.source()
    each = [laid_out.cut(one, 0, frames) for one, frames in enumerate(own.frames)]

    def far(one: int) -> np.ndarray:
        seconds = own.frames[one] / own.rates[one]
        found = likeness.nearest(each[one], seconds, source, len(own.frames))
        distance = np.zeros(len(own.frames))
        for near in found.near:
            distance[near.clip] = -near.likeness
        return distance

    return far


def bounded(own: Set) -> Ranking:
    laid_out = own.clips()
    each = [laid_out.cut(one, 0, frames) for one, frames in enumerate(own.frames)]
    return lambda one: -likeness.bounds_of(each[one], laid_out).full


def dwelling(own: Set) -> Ranking:
    """How long each part is in each cell, blurred over neighbouring ones: no order at all."""
    table = []
    middles = sphere.MIDDLES[sphere.CELLS]
    blur = np.exp(-np.square(middles[:, None] - middles).sum(axis=2) / 0.5)
    blur /= blur.sum(axis=1, keepdims=True)
    for clip, frames in zip(own.rows, own.frames, strict=True):
        there = np.zeros((len(PARTS), len(middles)))
        for number, part in enumerate(PARTS):
            if part in clip:
                shown = clip[part][~clip[part]["passing"]]
                until = np.append(shown["stop"][1:], frames)
                cell = shown["direction"].astype(int) * 3 + shown["level"]
                np.add.at(there[number], cell, (until - shown["stop"]) / frames)
        table.append((there @ blur).ravel())
    held = np.array(table)
    return lambda one: np.abs(held - held[one]).sum(axis=1)


def jointly(own: Set, rate: float = 10.0) -> Ranking:
    """All parts at once: poses made of the symbols, ten a second, warped upon each other."""
    poses = []
    for clip, frames, frequency in zip(own.rows, own.frames, own.rates, strict=True):
        times = np.arange(0, frames, frequency / rate)
        pose = np.zeros((len(times), len(PARTS), 3), np.float32)
        for number, part in enumerate(PARTS):
            if part in clip:
                own_clip = clips_of([{part: clip[part]}], [frequency], [part]).moves
                ends = np.stack([own_clip.starts, own_clip.stops], axis=1).ravel()
                before = np.concatenate([own_clip.points[:1], own_clip.points[:-1]])
                knots = np.stack([before, own_clip.points], axis=1).reshape(-1, 3)
                for axis in range(3):
                    pose[:, number, axis] = np.interp(times, ends, knots[:, axis])
        poses.append(pose)
    return lambda one: np.array([warped(poses[one], other) for other in poses])


def warping(own: Set, whole: bool = False) -> Ranking:
    def far(one: int) -> np.ndarray:
        mine = own.joints[one]
        return np.array(
            [warped(mine, other) * (len(mine) + len(other) if whole else 1) for other in own.joints]
        )

    return far


def figures(own: Set, table: np.ndarray) -> list[float]:
    """Return 1-NN and MAP over all others, and over those of other styles."""
    first: list[list[float]] = [[], []]
    precision: list[list[float]] = [[], []]
    for one in range(len(table)):
        for kind, allowed in enumerate((own.labels != "", own.styles != own.styles[one])):
            others = np.flatnonzero(allowed & (np.arange(len(table)) != one))
            order = others[np.argsort(table[one, others], kind="stable")]
            same = own.labels[order] == own.labels[one]
            places = np.flatnonzero(same)
            first[kind].append(bool(same[0]))
            precision[kind].append(float(np.mean(np.arange(1, len(places) + 1) / (places + 1))))
    return [
        float(np.mean(values)) for pair in zip(first, precision, strict=True) for values in pair
    ]


def without(name: str) -> Callable[[np.ndarray], np.ndarray]:
    def changed(rows: np.ndarray) -> np.ndarray:
        plain = rows.copy()
        plain[name] = {"margin": 1.0}.get(name, 0)
        return plain

    return changed


def told(name: str, own: Set, far: Ranking) -> None:
    table = np.array([far(one) for one in range(len(own.labels))])
    one, precision, other, others = figures(own, table)
    print(f"  {name:44} {one:.3f} {other:.3f}  {precision:.3f} {others:.3f}", flush=True)


def main() -> None:
    for name in STYLES:
        own = loaded(name)
        print(f"{name}: {len(own.labels)} clips        1-NN all, others; MAP all, others")
        ways = {
            "edit distance of symbols": edited(own),
            "alignment with angles (whole clips)": aligned(own),
            "as `search --like` does (stretches, too)": searched(own),
            "warped joint positions, by the frame": warping(own),
            "warped joint positions, in all": warping(own, whole=True),
        }
        for told_as, far in ways.items():
            told(told_as, own, far)
        print(" ideas")
        told("the bound alone: best partners, no order", own, bounded(own))
        told("dwelling: time in cells, blurred", own, dwelling(own))
        told("all parts jointly: poses of symbols, warped", own, jointly(own))
        told("without runner-up cells", own, aligned(own, without("margin")))
        told("without swings", own, aligned(own, without("swings")))
        for constant in ("SUBSTITUTED", "PACE", "POSE", "STEP"):
            kept = getattr(likeness, constant)
            for value in (0.0, kept / 2, 2 * kept):
                setattr(likeness, constant, value)
                told(f"{constant} {value:g} in place of {kept:g}", own, aligned(own))
            setattr(likeness, constant, kept)
        timed(own, ways)


def timed(own: Set, ways: dict[str, Ranking]) -> None:
    print(" milliseconds of a ranking")
    chosen = np.linspace(0, len(own.labels) - 1, TIMED).astype(int)
    took: dict[str, list[float]] = {name: [] for name in ways}
    for one in chosen:
        for name, far in ways.items():
            begin = process_time()
            far(int(one))
            took[name].append(1000 * (process_time() - begin))
    for name, times in took.items():
        print(f"  {name:44} {median(times):.2f}")
    many = replace(
        own,
        frames=own.frames * 25,
        rates=own.rates * 25,
        rows=own.rows * 25,
    )
    source, each = many.source(), own.clips()
    for limit in (10, 100):
        times = []
        for one in chosen:
            query = each.cut(int(one), 0, own.frames[one])
            seconds = own.frames[one] / own.rates[one]
            begin = process_time()
            likeness.nearest(query, seconds, source, limit)
            times.append(1000 * (process_time() - begin))
        print(f"  the best {limit} of {len(many.frames)} clips{'':24} {median(times):.1f}")


if __name__ == "__main__":
    sys.exit(main())
