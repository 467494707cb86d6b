"""Our scores of LabanotationSuite's gestures beside its own, position by position.

python tests/benchmarks/suite.py FOLDER: its scores, ``Ges01_wavehand.total.json`` and so on; the
captures are those of ``$LANINDEX_CAPTURES/csv/kinect``.
"""

from __future__ import annotations

import json
import os
import sys
from collections import Counter
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

import lanindex
from lanindex.model import Score
from lanindex.notation.suite import ARMS, _nearest, _our_words, _vector

Vector = NDArray[np.float64]
UP = np.array([0.0, 1.0, 0.0])
ROWS = ("their rule in the trunk's axes", "their rule, upright", "our score")


def main(folder: str) -> None:
    """Print how many positions say the same or not, and how far the trunk leans."""
    captures = Path(os.environ["LANINDEX_CAPTURES"]) / "csv/kinect"
    counts: dict[str, Counter[str]] = {row: Counter() for row in ROWS}
    leans = []
    for path in sorted(Path(folder).glob("Ges*.json")):
        motion = lanindex.read(captures / f"{path.name.split('.')[0]}.csv")
        score, joints = lanindex.encode(motion), motion.skeleton.names
        ((_, gesture),) = json.loads(path.read_text()).items()
        for position in gesture.values():
            time = float(position["start time"][0]) / 1000
            frame = min(round(time * motion.rate), len(motion.positions) - 1)
            at = dict(zip(joints, motion.positions[frame].astype(np.float64), strict=True))
            left = at["ShoulderLeft"] - at["ShoulderRight"]
            ahead = np.cross(at["SpineMid"] - at["ShoulderRight"], left)
            trunk = axes(-left, np.cross(ahead, left))
            leans.append(np.degrees(np.arccos(trunk[2] @ UP)))
            for column, (part, _) in ARMS.items():
                side, end = (word.title() for word in column.split())
                bone = at[f"{end}{side}"] - at[f"{'Shoulder' if end == 'Elbow' else 'Elbow'}{side}"]
                theirs = _our_words(column, position[column], path.name)
                said = (
                    pointed(bone, trunk),
                    pointed(bone, axes(-left, UP)),
                    standing(score, part, frame),
                )
                for row, ours in zip(ROWS, said, strict=True):
                    counts[row][apart(theirs, ours)] += 1
    for row, found in counts.items():
        print(row, dict(found))
    print(f"the trunk's axis leans by {np.median(leans):.0f} degrees, at most {max(leans):.0f}")


def axes(right: Vector, up: Vector) -> tuple[Vector, Vector, Vector]:
    """Return right, ahead and up, at right angles, up as told."""
    up = up / np.linalg.norm(up)
    right = right - (right @ up) * up
    right /= np.linalg.norm(right)
    return right, np.cross(up, right), up


def pointed(bone: Vector, seen: tuple[Vector, Vector, Vector]) -> str:
    """Return the direction and level that a bone is nearest to, by its angles."""
    return _nearest(*(float(bone @ axis) for axis in seen))


def standing(score: Score, part: str, frame: int) -> str:
    """Return where a part is by a score: where it went last, if it is more than half way there."""
    shown = (it for it in score.symbols(part) if not it.passing and it.start + it.stop <= 2 * frame)
    return " ".join([it.words for it in shown][-1].split()[:2])


def apart(one: str, two: str) -> str:
    """Return how far two directions are from each other."""
    a, b = (np.array(_vector(words)) for words in (one, two))
    return "same" if one == two else "neighbours" if a @ b > 0.49 else "farther"


if __name__ == "__main__":
    main(sys.argv[1])
