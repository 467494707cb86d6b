"""MVNX → Motion: segments, which begin at joints."""

from __future__ import annotations

import re
from fractions import Fraction
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from lanindex.body import Stated, sampled
from lanindex.errors import CaptureError, quoted
from lanindex.formats.amc.kinematics import END, carried
from lanindex.formats.file import File, Wanted
from lanindex.formats.mvnx.walk import Row, Subject, chosen, walk
from lanindex.formats.points import Points, motion_of
from lanindex.formats.rates import nearest_rate, told_rate
from lanindex.model import Motion, Reading

Floats = NDArray[np.float64]
Rows = NDArray[np.float32]

TRUNK = ("Pelvis", "L5", "L3", "T12", "T8", "Neck", "Head")
ARM = ("Shoulder", "UpperArm", "ForeArm", "Hand")
LEG = ("UpperLeg", "LowerLeg", "Foot", "Toe")
ABOVE = {
    **dict(zip(TRUNK, ("", *TRUNK), strict=False)),
    **{
        side + below: side + above if above in limb else above
        for trunk, limb in (("T8", ARM), ("Pelvis", LEG))
        for side in ("Right", "Left")
        for above, below in zip((trunk, *limb), limb, strict=False)
    },
}
"""Segment: the one that it hangs on."""

TIPS = {
    "Head": "pTopOfHead",
    **{f"{side}Hand": f"p{side}TopOfHand" for side in ("Right", "Left")},
    **{f"{side}Toe": f"p{side}Toe" for side in ("Right", "Left")},
}
"""Segment: the point on it where it ends."""

_LEGS = frozenset(f"{side}{part}" for side in ("Right", "Left") for part in LEG[1:])
_ARMS = frozenset(f"{side}{part}" for side in ("Right", "Left") for part in ARM)
UNSEEN = {
    "UpperBody": _LEGS,
    "UpperBodyNoHands": _LEGS,
    "LowerBody": _ARMS | {"L3", "T12", "T8", "Neck", "Head"},
    "LowerBodyWithSternum": _ARMS | {"Head"},
}
"""By configuration of the suit: segments that begin where nothing is measured."""

_SLOWEST = 1  # frames a second
_UNIT = (0.5, 2.0)  # lengths of quaternions that tell a turn


def read(file: File, told: Reading, wanted: Wanted) -> Motion:
    """Read an MVNX file: see `lanindex.formats.read_file`.

    A joint is where a segment begins, and has its name; hands, toes and the head end in one
    more. Poses of the calibration are left out, and what the suit has no sensors for.
    """
    people = walk(file, True)
    subject = chosen(people, file)
    rate = _rate(subject, file, told)
    joints, doubts = _joints(subject)
    places, turns, offsets = _placed(subject, joints)
    others = ", ".join(quoted(one.name) for one in people[:20] if one is not subject)
    if others and not file.subject:
        doubts += (f"{quoted(subject.name)} is read; it holds also {others}",)
    if subject.gap:
        doubts += (f"frame {subject.gap[1]} follows frame {subject.gap[0]}: taken for the next",)
    points = Points(
        tuple(joint.name for joint in joints),
        places,
        rate,
        Stated("m", "z"),
        tuple(joint.parent for joint in joints),
        offsets,
        turns,
        doubts,
        not subject.said.get("configuration", "").endswith("NoHands"),
    )
    return motion_of(points, file, "mvnx", told, wanted)


class _Joint(NamedTuple):
    """Where a segment begins, or a point on it; `parent` is another joint, by its number."""

    name: str
    segment: int
    parent: int
    point: Row | None = None


def _joints(subject: Subject) -> tuple[list[_Joint], tuple[str, ...]]:
    """Return the joints that are measured, and what is left out; parents before children."""
    configuration = subject.said.get("configuration", "")
    unseen = UNSEEN.get(configuration, frozenset())
    index = {name: number for number, name in reversed(list(enumerate(subject.segments)))}
    known = [name for name in ABOVE if name in index and name not in unseen]
    known += [name for name in index if name and name not in ABOVE]
    number = {name: joint for joint, name in enumerate(known)}
    joints = []
    for name in known:
        above = ABOVE.get(name, "")
        while above and above not in number:
            above = ABOVE[above]
        joints.append(_Joint(name, index[name], number.get(above, -1)))
    handless = configuration.endswith("NoHands")
    for name, label in TIPS.items() if subject.rows["orientation"] else ():
        point = subject.points[index[name]].get(label) if name in number else None
        if point is not None and not (handless and name.endswith("Hand")):
            joints.append(_Joint(name + END, index[name], number[name], point))
    left = [name for name in subject.segments if name in unseen]
    said = f"{configuration}: nothing is measured at {', '.join(left)}, which are left out"
    return joints, (said,) if left else ()


def _placed(subject: Subject, joints: list[_Joint]) -> tuple[Rows, Rows | None, Floats | None]:
    """Return where joints are, how they are turned, and where they are at rest."""
    count = len(subject.frames)
    segments = [joint.segment for joint in joints]
    places = _taken(subject.rows["position"]).reshape(count, -1, 3)[:, segments]
    if not subject.rows["orientation"]:
        return places, None, None
    turns = _taken(subject.rows["orientation"]).reshape(count, -1, 4)[:, segments]
    length = np.sqrt(np.einsum("tji,tji->tj", turns, turns))[..., None]
    unit = (length > _UNIT[0]) & (length < _UNIT[1])
    turns = np.divide(turns, length, out=np.full_like(turns, np.nan), where=unit)
    few = sampled(count)
    offsets = np.zeros((len(joints), 3))
    for number, joint in enumerate(joints):
        if joint.point is not None:
            offsets[number] = joint.point
            places[:, number] += carried(turns[:, number].T, joint.point.tolist()).T
        elif joint.parent >= 0:
            away = places[few, number] - places[few, joint.parent]
            back = turns[few, joint.parent] * np.array([1, -1, -1, -1], np.float32)
            ways = carried(back.T, away.T).T
            known = ways[np.isfinite(ways).all(axis=1)]
            offsets[number] = np.median(known, axis=0) if len(known) else 0.0
    return places, turns, offsets


def _taken(rows: list[Row]) -> Rows:
    """Return rows as one array, and leave none of them behind."""
    array = np.array(rows)
    rows.clear()
    return array


def _rate(subject: Subject, file: File, told: Reading) -> Fraction:
    if told.rate is not None:
        return told_rate(told.rate)
    said = subject.said.get("frameRate", "")
    digits = re.fullmatch(r"\s*(\d{1,6}(?:[.,]\d{1,12})?)\s*", said)
    rate = Fraction(digits.group(1).replace(",", ".")) if digits else Fraction(0)
    if rate < _SLOWEST:
        raise CaptureError(
            f"frameRate {quoted(said, 40)}" if said else "no frameRate",
            place=f"{file.name}:{subject.line}",
            wanted=f"{_SLOWEST} or more frames a second",
            remedy="Give the rate with --fps.",
        )
    return nearest_rate(rate)
