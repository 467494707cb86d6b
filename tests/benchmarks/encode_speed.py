"""How fast motions that have been read are written down, stage by stage.

    python tests/benchmarks/encode_speed.py [FOLDER ...]

Writes down the BVH files of each folder of LANINDEX_CAPTURES (all of them, by default), those of
12 seconds and more once more by themselves, and made dances of a minute: with the extra ``fast``
and without, in turns. Printed are frames of the body a second, 60 of which are a second of movement
whatever the capture's rate, of CPU time: the medians of five; then how the time is shared.
"""

import sys
import tempfile
import time
from collections import Counter
from collections.abc import Callable
from importlib import import_module
from pathlib import Path
from statistics import median
from typing import Any

from made import captures
from places import CAPTURES

from lanindex import compiled, formats
from lanindex.encoding import encode
from lanindex.encoding.profile import load
from lanindex.model import Motion

ROUNDS = 5
LONG = 12.0
STAGES = {
    "heading": "limbs.heading",
    "joints": "joints.body",
    "lengths": "joints._sums joints._medians",
    "curves": "limbs._curve",
    "limbs": "written.written",
    "ticks": "timing.count",
    "whole body": "whole.whole",
}


def timed(stage: str, function: Callable[..., Any], spent: Counter[str], inner: list[float]) -> Any:
    def call(*told: Any, **named: Any) -> Any:
        inner.append(0.0)
        begun = time.process_time()
        try:
            return function(*told, **named)
        finally:
            taken = time.process_time() - begun
            spent[stage] += taken - inner.pop()
            if inner:
                inner[-1] += taken

    return call


def clocked() -> Counter[str]:
    """Clock each stage from now on, without what others within it take."""
    spent, inner = Counter[str](), list[float]()
    for stage, names in STAGES.items():
        for name in names.split():
            place, function = name.split(".")
            module = import_module(f"lanindex.encoding.{place}")
            setattr(module, function, timed(stage, getattr(module, function), spent, inner))
    return spent


def taken(motions: list[Motion], fast: bool) -> float:
    compiled.chosen = lambda name, size: fast
    begun = time.process_time()
    for motion in motions:
        encode(motion, PROFILE)
    return time.process_time() - begun


def compare(name: str, motions: list[Motion]) -> None:
    frames = sum(float(len(one) / one.rate * 60) for one in motions)
    times: dict[bool, list[float]] = {}
    for _ in range(ROUNDS + 1):
        for fast in (False, True):
            times.setdefault(fast, []).append(taken(motions, fast))
    speeds = [f"{frames / median(runs[1:]):10,.0f}" for runs in times.values()]
    print(f"{name:16} {len(motions):6} {frames:9,.0f}", *speeds, flush=True)


def share(name: str, motions: list[Motion], spent: Counter[str]) -> None:
    for way in ("plain", "fast"):
        taken(motions, way == "fast")
        spent.clear()
        whole = taken(motions, way == "fast")
        spent["the rest"] = whole - spent.total()
        told = (f"{stage} {seconds / whole:.0%}" for stage, seconds in spent.most_common())
        print(f"{name}, {way}: " + ", ".join(told))


def main(names: list[str]) -> None:
    folders = [path for path in sorted((CAPTURES / "bvh").iterdir()) if path.is_dir()]
    motions = {
        path.name: [formats.read(file) for file in sorted(path.rglob("*.bvh"))]
        for path in folders
        if not names or path.name in names
    }
    every = [one for some in motions.values() for one in some]
    motions["all"] = every
    motions["long ones"] = [one for one in every if len(one) / one.rate >= LONG]
    with tempfile.TemporaryDirectory() as folder:
        motions["made, 1 min"] = [formats.read(path) for path in captures(Path(folder), 4)]
    print(f"{'captures':16} {'':6} {'frames':>9} {'plain':>10} {'fast':>10}")
    for name, some in motions.items():
        if some:
            compare(name, some)
    spent = clocked()
    for name in ("all", "long ones", "made, 1 min"):
        if motions[name]:
            share(name, motions[name], spent)


PROFILE = load("default")

if __name__ == "__main__":
    main(sys.argv[1:])
