"""Perform every score of this folder: NAME.lnd becomes NAME.bvh, at 30 frames a second.

Run it as ``python corpus/build.py [FOLDER]``; the motions go to this folder unless told.
"""

import sys
from pathlib import Path

from lanindex.formats import bvh
from lanindex.notation import lnd
from lanindex.perform import perform

HERE = Path(__file__).parent
RATE = 30


def build(folder: Path) -> list[Path]:
    """Write the motion of every score into `folder`, and return the files."""
    built = []
    for path in sorted(HERE.glob("*.lnd")):
        motion = perform(lnd.read(path), rate=RATE)
        target = folder / f"{path.stem}.bvh"
        target.write_bytes(bvh.write(motion))
        built.append(target)
    return built


if __name__ == "__main__":
    for path in build(Path(sys.argv[1]) if len(sys.argv) > 1 else HERE):
        print(f"{path}  {path.stat().st_size / 1000:.0f} kB")
