"""How well the patterns of bandai1.toml, bandai2.toml and mae.toml tell the labelled clips apart.

    python tests/benchmarks/retrieval.py

Prints a table a profile, and the mean F1 of `default` where the clips are changed: played slower or
faster, noisy, mirrored (labels too), with arms that are aimed elsewhere: what is to be feared for
performers who were not seen. The captures are those of LANINDEX_CAPTURES.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import partial
from itertools import pairwise
from pathlib import Path
from zlib import crc32

import numpy as np
from places import CAPTURES, HERE, changed

from lanindex.alphabet import JOINTS
from lanindex.app.cli import app
from lanindex.encoding import encode
from lanindex.evaluate import Clip, evaluate, read_patterns, summary
from lanindex.formats import read
from lanindex.model import Capture, Motion
from lanindex.pipeline.ingest import read_labels

SIDES = {"left": "right", "right": "left"}
ARMS = tuple(
    tuple(JOINTS.index(f"{side}{joint}") for joint in ("Shoulder", "Elbow", "Wrist", "Hand"))
    for side in "RL"
)


def played(speed: Fraction) -> Callable[[Motion], Motion]:
    return lambda motion: replace(motion, rate=motion.rate * speed)


def aimed(motion: Motion, up: float, out: float) -> Motion:
    """Return both arms' bones turned up, and out to their own sides, by so many degrees at most."""
    before = motion.positions.astype(np.float64)
    after, body = before.copy(), motion.skeleton.body
    for own, other in (ARMS, ARMS[::-1]):
        outward = before[:, body[own[0]]] - before[:, body[other[0]]]
        side = np.arctan2(outward[:, 2], outward[:, 0])
        chain = [body[joint] for joint in own if body[joint] >= 0]
        for near, far in pairwise(chain):
            x, y, z = (before[:, far] - before[:, near]).T
            length, level = np.sqrt(x * x + y * y + z * z), np.hypot(x, z)
            way = np.arctan2(z, x)
            apart = (side - way + np.pi) % (2 * np.pi) - np.pi
            way += np.sign(apart) * np.minimum(np.radians(out), np.abs(apart))
            rise = np.arctan2(y, level) + np.radians(up)
            rise = np.clip(rise, -np.pi / 2, np.pi / 2)
            flat = length * np.cos(rise)
            bone = np.stack((flat * np.cos(way), length * np.sin(rise), flat * np.sin(way)), axis=1)
            after[:, far] = after[:, near] + bone
    return replace(motion, positions=after.astype(np.float32))


def of_another_habit(motion: Motion, seed: int) -> Motion:
    """Return arms aimed as some other person might, the same for all clips of a performer."""
    assert motion.source is not None
    performer = Path(motion.source.path).name.split("_")[0]
    up, out = np.random.default_rng([seed, crc32(performer.encode())]).normal(0, 8, 2)
    return aimed(motion, up, out)


CHANGES: dict[str, Callable[[Motion], Motion]] = {
    **{f"played at {speed}": played(Fraction(speed)) for speed in ("0.8", "0.9", "1.1", "1.25")},
    "mirrored": changed.mirrored,
    "noise of 3 mm": lambda motion: changed.noisy(motion, 3.0),
    "noise of 6 mm": lambda motion: changed.noisy(motion, 6.0),
    "arms 8° higher": partial(aimed, up=8.0, out=0.0),
    "arms 8° lower": partial(aimed, up=-8.0, out=0.0),
    "arms 8° wider": partial(aimed, up=0.0, out=8.0),
    "arms 8° closer": partial(aimed, up=0.0, out=-8.0),
    **{f"other habits {seed}": partial(of_another_habit, seed=seed) for seed in range(5)},
}


@dataclass(frozen=True)
class Collection:
    """Labelled clips, the patterns for them, and the changes that say something about those."""

    folder: str
    patterns: str
    changes: tuple[str, ...]


COLLECTIONS = (
    Collection("bandai1", "bandai1.toml", tuple(CHANGES)[:7]),
    Collection("bandai2", "bandai2.toml", tuple(CHANGES)[:7]),
    Collection("mae_openni", "mae.toml", tuple(it for it in CHANGES if it != "mirrored")),
)


def mirrored_label(label: str) -> str:
    return "-".join(SIDES.get(word, word) for word in label.split("-"))


def clip(number: int, path: Path, label: str, motion: Motion) -> Clip:
    score = encode(motion)
    capture = Capture(number, str(path), "bvh", "", label, score.rate, score.frames)
    return Clip(capture, score.tracks, None)


def sensitivity(collection: Collection, labels: dict[str, str]) -> None:
    folder = CAPTURES / "bvh" / collection.folder
    motions = {path: read(path) for path in sorted(folder.rglob("*.bvh"))}
    for name in collection.changes:
        swap = mirrored_label if name == "mirrored" else str
        clips = [
            clip(number, path, swap(labels[str(path)]), CHANGES[name](motion))
            for number, (path, motion) in enumerate(motions.items())
        ]
        results = evaluate(clips, read_patterns(HERE / collection.patterns))
        figures = {it.expectation.name: it.record()["f1"] for it in results}
        low = [f"{told} {f1:.2f}" for told, f1 in figures.items() if f1 < 1]
        print(f"{name:16} mean F1 {summary(results)['mean_f1']:.3f}  {', '.join(low)}", flush=True)


def main() -> None:
    table = CAPTURES / "labels.csv"
    labels = {path: label for path, (label, _) in read_labels(table).items()}
    for collection in COLLECTIONS:
        folder, patterns = CAPTURES / "bvh" / collection.folder, HERE / collection.patterns
        for profile, more in {"default": ["--misses"], "paper": []}.items():
            print(f"\n{collection.patterns}, profile {profile}", flush=True)
            words = ["evaluate", str(folder), "--labels", str(table), "--patterns", str(patterns)]
            app([*words, "--profile", profile, *more], standalone_mode=False)
        sensitivity(collection, labels)


if __name__ == "__main__":
    main()
