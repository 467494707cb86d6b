"""Perform every score of this folder: NAME.lnd becomes NAME.bvh, at 30 frames a second.

Run it as ``python corpus/build.py [FOLDER]``; the motions go to this folder unless told, and with
them ``signs.png``, all signs of a staff.
"""

import sys
from pathlib import Path

from lanindex.alphabet import DIRECTIONS, LEVELS
from lanindex.draw import draw
from lanindex.draw.svg import rendered
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


LIMBS = ("r_arm", "l_arm", "r_leg", "l_leg", "torso", "head")
"""Whose columns show each direction at each level."""

OTHERS = """\
support r_support place mid 16 16.5
support l_support forward mid 16.5 17.5
jump jump forward leap 17.5 18.5
support r_support forward low 18.5 19.5
jump jump place assemble 20 21
stance r_stance mid 21 31
stance l_stance mid 21 31
rotation body_turn right 90 16 17.5
rotation body_turn left 180 18 19.5
rotation body_turn right 360 28.5 30
twist torso_twist right 45 16 17.5
twist torso_twist left 30 18 19.5
twist torso_twist place 0 20 21
twist head_turn left 60 16 17.5
twist head_turn place 0 18 19
incline torso_incline forward 45 16 18
incline torso_incline place 0 19 20
incline head_incline right 20 16 17.5
travel body_travel forward 0 16 20
travel body_travel l_forward 90 21 25
bend r_arm_bend bend3 16 17
bend r_arm_bend stretch0 18 19
bend l_leg_bend bend5 16 18
bend l_leg_bend stretch1 19 20
touch hands_touch hand 22 23
touch r_hand_touch head 24 24.5
touch l_hand_touch knee 26 26.5
carrier other_support knee 22 24
carrier other_support seat 25 27
"""


def signs() -> bytes:
    """Return a picture of each direction at each level in its column, and of all other signs."""
    cells = [f"{direction} {level}" for level in LEVELS for direction in DIRECTIONS]
    lines = ["#unit0", *(f"direction {part} place low 0 0" for part in LIMBS), "#unit1"]
    for at, cell in enumerate(cells):
        when = f"{at / 2} {at / 2 + 0.5}"
        lines += [f"direction {part} {cell} {when}" for part in LIMBS]
        lines.append(f"support {'rl'[at % 2]}_support {cell} {when}")
    score = lnd.read("\n".join(lines) + "\n" + OTHERS)
    return rendered(draw(score, title="signs", bars=4, legend=True), "png", 1.5)


if __name__ == "__main__":
    folder = Path(sys.argv[1]) if len(sys.argv) > 1 else HERE
    (folder / "signs.png").write_bytes(signs())
    for path in build(folder):
        print(f"{path}  {path.stat().st_size / 1000:.0f} kB")
