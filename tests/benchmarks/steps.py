"""Steps against another rule, and against marks of laboratories.

    python tests/benchmarks/steps.py

For every labelled walk, run and gait of LANINDEX_CAPTURES: how many steps there are, how many there
should be (how often one ankle comes before the other, by a quarter of a leg or more, seen from the
hips), whether they alternate, and the share of flight. Then, for the C3D files whose laboratories
marked foot strikes, how far ours are off.
"""

import sys
from itertools import pairwise
from pathlib import Path

import numpy as np
from places import CAPTURES

from lanindex import formats
from lanindex.encoding.arithmetic import runs
from lanindex.encoding.ground import LEGS, Ground, grounds
from lanindex.encoding.joints import Body
from lanindex.encoding.limbs import heading
from lanindex.encoding.profile import load
from lanindex.encoding.steps import events, faced
from lanindex.errors import LanindexError
from lanindex.pipeline.ingest import read_labels

WANTED = ("walk", "run", "gait")
NOT = ("jump", "skeleton")
APART = 0.25
"""Lengths of a leg."""

STRIKES = {
    # seconds from the first frame: the events of the file, less its first frame
    "c3d/rehazenter_2014001_C1_01.c3d": {"L": [2.60], "R": [1.33, 3.81]},
    "c3d/qualisys_ezc3d.c3d": {"L": [0.135, 1.08], "R": [0.595, 1.575]},
}


def swings(values: np.ndarray) -> int:
    """Return how often a curve comes from one side to the other, by `APART` or more."""
    count, low, high, up = 0, values[0], values[0], None
    for value in values.tolist():
        low, high = min(low, value), max(high, value)
        if up is not True and value - low >= APART:
            count, up, high = count + 1, True, value
        if up is not False and high - value >= APART:
            count, up, low = count + 1, False, value
    return count


def apart(ground: Ground, turn: np.ndarray) -> np.ndarray:
    """Return how far the right ankle is before the left one, in lengths of a leg."""
    ankles = ground.places.take(("RAnkle", "LAnkle"), np.arange(len(turn)))
    way = (ankles["RAnkle"] - ankles["LAnkle"]) / ground.leg
    return np.array([faced(one, angle)[0] for one, angle in zip(way, turn.tolist(), strict=True)])


def main() -> int:
    profile, near, turns, flown, total = load("default"), 0, 0, 0, 0
    print(f"{'capture':44} steps rule alternate flight")
    for path, (label, _) in sorted(read_labels(CAPTURES / "labels.csv").items()):
        if not any(word in (label or "") for word in WANTED) or any(it in label for it in NOT):
            continue
        try:
            motion = formats.read(path)
        except LanindexError:
            continue
        body = Body(motion, profile)
        turn = heading(motion, profile.rate, body)
        steps, rule, alternate, air, frames = 0, 0, True, 0, 0
        for ground in grounds(body, body.length(LEGS)):
            front = turn[ground.places.frames.start : ground.places.frames.stop]
            found, flights = events(ground, front)
            steps, rule = steps + len(found), rule + swings(apart(ground, front))
            feet = [one.foot for one in found]
            alternate &= all(one != two for one, two in pairwise(feet))
            air += sum(one.stop - one.start for one in flights)
            frames += len(front)
        if frames:
            good = abs(steps - rule) <= 1
            near, turns, total = near + good, turns + alternate, total + 1
            flown += air
            name = f"{Path(path).stem[:43]:44}"
            share = f"{air / frames:6.2f}{'' if good else ' <'}"
            print(f"{name} {steps:5} {rule:4} {alternate!s:9} {share}")
    print(f"{near} of {total} within one of the rule, {turns} alternate")
    off = []
    for name, marked in STRIKES.items():
        body = Body(formats.read(CAPTURES / name), profile)
        (ground,) = grounds(body, body.length(LEGS))
        for foot, side in enumerate("RL"):
            begun = [start / ground.rate for start, _ in runs(ground.carries[foot]) if start]
            off += [min((it - wanted for it in begun), key=abs) for wanted in marked[side]]
    print(f"{len(off)} marked strikes: {', '.join(f'{1000 * it:+.0f}' for it in off)} ms")
    return 0


if __name__ == "__main__":
    sys.exit(main())
