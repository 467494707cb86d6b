"""How well the eight patterns of bandai2.toml tell the labelled clips apart.

    python tests/benchmarks/retrieval.py

Prints a table a profile, and the mean F1 of `default` where the clips are played slower or faster,
mirrored (labels too) or noisy: what is to be feared for performers who were not seen. The captures
are those of LANINDEX_CAPTURES.
"""

from collections.abc import Callable
from dataclasses import replace
from fractions import Fraction
from pathlib import Path

from places import CAPTURES, HERE, changed

from lanindex.app.cli import app
from lanindex.encode import encode
from lanindex.evaluate import Clip, evaluate, read_patterns, summary
from lanindex.formats import read
from lanindex.model import Capture, Motion
from lanindex.pipeline.labels import read_labels

PATTERNS = HERE / "bandai2.toml"
SIDES = {"left": "right", "right": "left"}


def played(speed: Fraction) -> Callable[[Motion], Motion]:
    return lambda motion: replace(motion, rate=motion.rate * speed)


CHANGES: dict[str, Callable[[Motion], Motion]] = {
    **{f"played at {speed}": played(Fraction(speed)) for speed in ("0.8", "0.9", "1.1", "1.25")},
    "mirrored": changed.mirrored,
    "noise of 3 mm": lambda motion: changed.noisy(motion, 3.0),
    "noise of 6 mm": lambda motion: changed.noisy(motion, 6.0),
}


def mirrored_label(label: str) -> str:
    return "-".join(SIDES.get(word, word) for word in label.split("-"))


def clip(number: int, path: Path, label: str, motion: Motion) -> Clip:
    score = encode(motion)
    capture = Capture(number, str(path), "bvh", "", label, score.rate, score.frames)
    return Clip(capture, score.tracks, None)


def sensitivity(labels: dict[str, str]) -> None:
    motions = {path: read(path) for path in sorted((CAPTURES / "bvh" / "bandai2").rglob("*.bvh"))}
    for name, change in CHANGES.items():
        swap = mirrored_label if name == "mirrored" else str
        clips = [
            clip(number, path, swap(labels[str(path)]), change(motion))
            for number, (path, motion) in enumerate(motions.items())
        ]
        results = evaluate(clips, read_patterns(PATTERNS))
        figures = {it.expectation.name: it.record()["f1"] for it in results}
        low = [f"{told} {f1:.2f}" for told, f1 in figures.items() if f1 < 1]
        print(f"{name:16} mean F1 {summary(results)['mean_f1']:.3f}  {', '.join(low)}", flush=True)


def main() -> None:
    folder, table = CAPTURES / "bvh" / "bandai2", CAPTURES / "labels.csv"
    for profile, more in {"default": ["--misses"], "paper": []}.items():
        print(f"profile {profile}", flush=True)
        words = ["evaluate", str(folder), "--labels", str(table), "--patterns", str(PATTERNS)]
        app([*words, "--profile", profile, *more], standalone_mode=False)
    sensitivity({path: label for path, (label, _) in read_labels(table).items()})


if __name__ == "__main__":
    main()
