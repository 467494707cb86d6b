"""The body by the names of its joints (`names.toml`).

Nothing is invented: a joint that is not there stays absent.
"""

from __future__ import annotations

from collections.abc import Mapping

from lanindex.body.names import candidates
from lanindex.body.rig import Rig, near_hips

Candidates = Mapping[tuple[str, str, str], tuple[int, ...]]
_Limb = tuple[str, str, str]

LIMBS: tuple[_Limb, ...] = (("Shoulder", "Elbow", "Wrist"), ("Hip", "Knee", "Ankle"))
_TIPS = {"Wrist": "Hand", "Ankle": "Toe"}


def by_name(rig: Rig) -> dict[str, int]:
    """Find the body by the names of joints."""
    found = candidates(rig.names)
    body: dict[str, int] = {}
    for side in "RL":
        for limb in LIMBS:
            _limb(rig, found, side, limb, body)
    _pelvis(rig, found, body)
    _neck_head(rig, found, body)
    _chest(rig, found, body)
    return body


def _limb(rig: Rig, found: Candidates, side: str, limb: _Limb, body: dict[str, int]) -> None:
    """Walk from the trunk outwards; each joint lies below the one before."""
    last: int | None = None
    for joint in limb:
        for index in found["limbs", side, joint]:
            if last is None or rig.beyond(index, last) > 0.0:
                body[side + joint] = last = index
                break
    inner, outer = (body.get(side + joint) for joint in limb[1:])
    if outer is not None:
        named = found["tips", side, _TIPS[limb[-1]]]
        tip = rig.tip(outer, named, inner if limb[-1] == "Ankle" else None)
        if tip is not None:
            body[side + _TIPS[limb[-1]]] = tip


def _pelvis(rig: Rig, found: Candidates, body: dict[str, int]) -> None:
    named = found["middle", "", "Pelvis"]
    if not {"RHip", "LHip", "RKnee"} <= body.keys():
        if named:
            body["Pelvis"] = named[0]
        return
    meeting = rig.meeting(body["RHip"], body["LHip"])
    chest = next(iter(found["middle", "", "Chest"]), None)  # what names call so lies low in some
    for index in (*named, *([meeting] if meeting not in (None, chest) else [])):
        if near_hips(rig, index, body):
            body["Pelvis"] = index
            return


def _neck_head(rig: Rig, found: Candidates, body: dict[str, int]) -> None:
    """Find neck and head; a head that stands for both (no neck, or in one place) gives its tip."""
    neck, head = (next(iter(found["middle", "", joint]), None) for joint in ("Neck", "Head"))
    tips = found["tips", "", "Head"]
    if head is None:
        head = rig.tip(neck, tips) if neck is not None else None
    elif neck is None or rig.distance(neck, head) <= rig.nothing:
        tip = rig.tip(head, tips)
        neck, head = (head, tip) if tip is not None else (neck, head if neck is None else None)
    body |= {joint: index for joint, index in (("Neck", neck), ("Head", head)) if index is not None}


def _chest(rig: Rig, found: Candidates, body: dict[str, int]) -> None:
    """Take the joint where the arms part from the trunk; where all part at the pelvis, a name."""
    taken = set(body.values())
    if {"RShoulder", "LShoulder"} <= body.keys():
        meeting = rig.meeting(body["RShoulder"], body["LShoulder"])
        above_pelvis = rig.above(body["Pelvis"]) if "Pelvis" in body else ()
        if meeting is not None and meeting not in taken and meeting not in above_pelvis:
            body["Chest"] = meeting
            return
    free = (index for index in found["middle", "", "Chest"] if index not in taken)
    first = next(free, None)
    if first is not None:
        body["Chest"] = first
