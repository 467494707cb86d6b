"""A small person in MVNX."""

from collections.abc import Iterable

import numpy as np

TREE = (  # segment, the one above, where it begins there (m: forwards, left, up)
    ("Pelvis", "", (0, 0, 0.95)),
    ("T8", "Pelvis", (0, 0, 0.35)),
    ("Neck", "T8", (0, 0, 0.15)),
    ("Head", "Neck", (0, 0, 0.1)),
    ("RightShoulder", "T8", (0, -0.03, 0.1)),
    ("RightUpperArm", "RightShoulder", (0, -0.14, 0)),
    ("RightForeArm", "RightUpperArm", (0, -0.28, 0)),
    ("RightHand", "RightForeArm", (0, -0.25, 0)),
    ("LeftShoulder", "T8", (0, 0.03, 0.1)),
    ("LeftUpperArm", "LeftShoulder", (0, 0.14, 0)),
    ("LeftForeArm", "LeftUpperArm", (0, 0.28, 0)),
    ("LeftHand", "LeftForeArm", (0, 0.25, 0)),
    ("RightUpperLeg", "Pelvis", (0, -0.09, 0)),
    ("RightLowerLeg", "RightUpperLeg", (0, 0, -0.42)),
    ("RightFoot", "RightLowerLeg", (0, 0, -0.41)),
    ("RightToe", "RightFoot", (0.15, 0, -0.07)),
    ("LeftUpperLeg", "Pelvis", (0, 0.09, 0)),
    ("LeftLowerLeg", "LeftUpperLeg", (0, 0, -0.42)),
    ("LeftFoot", "LeftLowerLeg", (0, 0, -0.41)),
    ("LeftToe", "LeftFoot", (0.15, 0, -0.07)),
)
NAMES = tuple(name for name, *_ in TREE)
REST = np.zeros((len(TREE), 3))
for _number, (_, _above, _away) in enumerate(TREE):
    REST[_number] = np.array(_away) + (REST[NAMES.index(_above)] if _above else 0)
POINTS = {
    "Head": ("pTopOfHead", (0, 0, 0.18)),
    "RightHand": ("pRightTopOfHand", (0, -0.17, 0)),
    "LeftHand": ("pLeftTopOfHand", (0, 0.17, 0)),
    "RightToe": ("pRightToe", (0.06, 0, 0)),
    "LeftToe": ("pLeftToe", (0.06, 0, 0)),
}


def frame(places: np.ndarray, turns: np.ndarray | None, said: str) -> str:
    text = f"\t\t\t<frame {said}>\n"
    if turns is not None:
        text += f"<orientation>{' '.join(f'{it:.6f}' for it in turns.flat)}</orientation>\n"
    text += f"<position>{' '.join(f'{it:.6f}' for it in places.flat)}</position>\n"
    return text + "<velocity>0 0 0</velocity>\n\t\t\t</frame>\n"


def subject(
    frames: int = 5,
    label: str = "Ada",
    said: str = 'frameRate="60" configuration="FullBody"',
    names: Iterable[str] = NAMES,
    turned: bool = True,
) -> str:
    """Return a person who walks along x at 1 m a second and turns about the vertical."""
    kept = [NAMES.index(name) for name in names]
    text = f'<subject label="{label}" {said}>\n<segments>\n'
    for number in kept:
        point = POINTS.get(NAMES[number])
        text += f'<segment label="{NAMES[number]}" id="{number + 1}"><points>\n'
        if point:
            way = " ".join(map(str, point[1]))
            text += f'<point label="{point[0]}"><pos_b>{way}</pos_b></point>\n'
        text += "</points></segment>\n"
    text += f'</segments>\n<frames segmentCount="{len(kept)}">\n'
    still = np.tile([1.0, 0, 0, 0], (len(kept), 1))
    for pose in ("identity", "tpose", "npose"):
        text += frame(REST[kept], still, f'time="0" type="{pose}"')
    for index in range(frames):
        angle = 0.05 * index
        cosine, sine = np.cos(angle), np.sin(angle)
        turn = np.array([[cosine, -sine, 0], [sine, cosine, 0], [0, 0, 1]])
        places = REST[kept] @ turn.T + (index / 60, 0, 0)
        turns = np.tile([np.cos(angle / 2), 0, 0, np.sin(angle / 2)], (len(kept), 1))
        at = f'time="{index * 16}" index="{index}" ms="{1542082631842 + index * 16}" type="normal"'
        text += frame(places, turns if turned else None, at)
    return text + "\t\t</frames>\n\t</subject>\n"


def mvnx(*subjects: str, version: str = "4") -> bytes:
    text = f'<?xml version="1.0" encoding="UTF-8"?>\n<!-- made -->\n<mvnx version="{version}">\n'
    return (text + "".join(subjects) + '<securityCode code="x"/>\n</mvnx>\n').encode()
