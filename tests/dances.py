"""Small dances made for tests, as BVH files and scores."""

from fractions import Fraction
from functools import cache
from pathlib import Path

from lanindex.formats import bvh
from lanindex.notation import lnd
from lanindex.perform import perform

RAISE = """\
#speed=60
#rhythm 4/4
#unit_total 2
#unit0
direction r_arm place low 0 0
direction l_arm place low 0 0
#unit1
direction r_arm right mid 0.5 1.25
direction r_arm place high 1.25 2
direction l_arm left mid 0.5 1.25
#unit2
direction r_arm right mid 0.5 1
direction r_arm place low 1 2
"""
BOW = """\
#speed=60
#rhythm 4/4
#unit_total 1
#unit0
direction r_arm place low 0 0
#unit1
direction r_arm forward mid 1 2
direction r_arm place low 2.5 3.25
"""


def dance(path: Path, text: str = RAISE, rate: int = 30) -> Path:
    """Write a dance as a BVH file and return its path."""
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(dance_bytes(text, rate))
    return path


@cache
def dance_bytes(text: str, rate: int = 30) -> bytes:
    """Return a dance as the content of a BVH file."""
    return bvh.write(perform(lnd.read(text.encode()), rate=Fraction(rate)))
