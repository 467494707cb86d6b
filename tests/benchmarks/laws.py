"""Print METHOD's laws on every real BVH: python tests/benchmarks/laws.py [FOLDER]."""

import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

from places import CAPTURES, changed

from lanindex.encoding import encode
from lanindex.encoding.profile import Profile, load
from lanindex.errors import LanindexError
from lanindex.formats import read
from lanindex.model import Motion, Score

Change = Callable[[Motion], Motion]


def captures(folder: Path) -> list[Motion]:
    found = []
    for path in sorted(folder.rglob("*.bvh")):
        try:
            found.append(read(path))
        except LanindexError as error:
            print(error, file=sys.stderr)
    return found


def exact(
    name: str,
    motions: list[Motion],
    profile: Profile,
    change: Change,
    image: Callable[[Score], dict],
) -> None:
    """Print how many tracks differ from what the law says."""
    tracks, limbs, differing = 0, 0, []
    for motion in motions:
        before, after = image(encode(motion, profile)), encode(change(motion), profile)
        tracks += len(before)
        for part in changed.changed_tracks(before, changed.rows(after)):
            limbs += part in changed.LIMBS
            differing.append(f"{part} of {Path(motion.source.path).name}")
    print(
        f"| {name} | {profile.name} | {len(differing)} of {tracks} tracks differ, limbs {limbs} |"
    )
    for one in differing[:5]:
        print(f"|   | | {one} |")


def near(name: str, motions: list[Motion], profile: Profile, change: Change) -> None:
    """Print how often limbs agree, and how many edits a symbol do not; all parts behind."""
    figures = []
    for parts in (changed.LIMBS, None):
        agree, clips, wrong, symbols = 0, 0, 0, 0
        for motion in motions:
            before, after = encode(motion, profile), encode(change(motion), profile)
            for part in parts or before.tracks:
                if part in before.tracks and part in after.tracks:
                    count, size = changed.edits(before, after, part)
                    agree, clips = agree + (count == 0), clips + 1
                    wrong, symbols = wrong + count, symbols + size
        figures.append(
            f"{agree}/{clips} = {agree / max(clips, 1):.3f}, {wrong / max(symbols, 1):.4f}"
        )
    print(f"| {name} | {profile.name} | limbs {figures[0]} | all parts {figures[1]} |")


def main() -> None:
    motions = captures(Path(sys.argv[1]) if len(sys.argv) > 1 else CAPTURES / "bvh")
    fast = [motion for motion in motions if 110 < motion.rate < 130 and len(motion) > 8]
    slow = [motion for motion in motions if 29 < motion.rate < 31]
    print(f"{len(motions)} captures; {len(fast)} of 120 and {len(slow)} of 30 frames a second")
    print("| law | profile | tracks that differ |")
    for profile in (load("default"), load("paper")):
        rows = changed.rows
        for degrees in (37, 90, 201.5):
            name = f"turned by {degrees}"
            exact(name, motions, profile, lambda m, by=degrees: changed.turned(m, by), rows)
        exact("moved", motions, profile, lambda m: changed.moved(m, (512, -64, 256)), rows)
        if profile.name == "default":
            for factor in (0.5, 1.7):
                name = f"scaled by {factor}"
                exact(name, motions, profile, lambda m, by=factor: changed.scaled(m, by), rows)
        exact("mirrored", motions, profile, changed.mirrored, changed.mirrored_rows)
    print("| law | profile | clips that agree, edits a symbol |")
    calm = replace(load("default"), name="default, 150 ms", smoothing=0.150)
    for profile in (load("default"), load("paper")):
        near("120 thinned to 60", fast, profile, lambda m: changed.thinned(m, 2))
        near("120 thinned to 30", fast, profile, lambda m: changed.thinned(m, 4))
        near("noise of 1 mm", slow, profile, lambda m: changed.noisy(m, 1.0))
    near("noise of 2 mm", slow, calm, lambda m: changed.noisy(m, 2.0))


if __name__ == "__main__":
    main()
