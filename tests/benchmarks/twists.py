"""How far people twist, turn their heads and lean in real captures.

    python tests/benchmarks/twists.py

For every label of LANINDEX_CAPTURES, most clips first: how many clips there are, in how many there
is a twist, how far the farthest twist and lean come, and where chest and head usually are turned,
of the clip in which that is farthest away.
"""

import csv
import sys
from collections import defaultdict

import numpy as np
from places import CAPTURES

from lanindex.encoding.joints import Body
from lanindex.encoding.limbs import heading
from lanindex.encoding.places import stretches
from lanindex.encoding.profile import load
from lanindex.encoding.twists import TRUNK, TWISTED, head_turn, leaning, torso_twist, trunk_line
from lanindex.errors import LanindexError
from lanindex.formats import read


def measured(path: str, profile) -> dict[str, np.ndarray]:
    """Return the angles of a capture, degrees."""
    body = Body(read(path, body_only=True), profile)
    turn = heading(body.motion, profile.rate, body)
    found = defaultdict(list)
    for needed in (TRUNK, (*TRUNK, "Head right")):
        for over in stretches(body, needed):
            front = turn[over.frames.start : over.frames.stop]
            for block, places in over.blocks():
                if len(needed) > len(TRUNK):
                    found["head"].append(head_turn(places).real)
                else:
                    found["twist"].append(torso_twist(places).real)
                    found["lean"].append(np.abs(leaning(trunk_line(places), front[block.inner])))
    return {name: np.concatenate(parts) for name, parts in found.items()}


def main() -> int:
    profile, by_label = load("default"), defaultdict(list)
    with (CAPTURES / "labels.csv").open() as file:
        for row in csv.DictReader(file):
            try:
                by_label[row["label"]].append(measured(str(CAPTURES / row["file"]), profile))
            except LanindexError as error:
                print(error, file=sys.stderr)
    print(
        "label, clips; clips with a twist, farthest twist; farthest lean; usual twist, usual turn"
    )
    for label, those in sorted(by_label.items(), key=lambda pair: -len(pair[1])):
        twists = [np.abs(it["twist"]).max() for it in those if "twist" in it]
        leans = [it["lean"].max() for it in those if "lean" in it]
        usual = [
            max((abs(np.median(it[name])) for it in those if name in it), default=np.nan)
            for name in ("twist", "head")
        ]
        print(
            f"{label[:50]:50} {len(those):3}; {sum(it >= TWISTED for it in twists):3}, "
            f"{max(twists, default=np.nan):4.0f}; {max(leans, default=np.nan):4.0f}; "
            f"{usual[0]:4.0f}, {usual[1]:4.0f}"
        )
    return 0


if __name__ == "__main__":
    sys.exit(main())
