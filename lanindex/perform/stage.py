"""The standard body on stage: tracks to directions of bones, bones to joints."""

from __future__ import annotations

from fractions import Fraction
from math import ceil, isfinite
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lanindex.alphabet import BENDS, DIRECTION_CODES, FACING, HIGH, LOW, MID, PARTS, PLACE
from lanindex.errors import UsageError
from lanindex.model import Motion, Score, Source
from lanindex.perform.limbs import (
    FOLDED,
    TOUCHES,
    TURNED,
    UP,
    Body,
    Cell,
    Limb,
    Reach,
    angles,
    bring_hands,
    chest_axes,
    direction_vector,
    dot,
    face_palms,
    great_circle,
    head_right,
    lean_direction,
    palm_axes,
    reach_when_bent,
    reaches,
    shown,
    standard,
    unit,
)
from lanindex.perform.resting import OTHER, rest_bones
from lanindex.perform.travel import WEIGHT, Travel, travel_of

Floats = NDArray[np.float64]

CARRIED = (
    *WEIGHT,
    *TOUCHES,
    *TURNED,
    "step",
    "body_travel",
    *BENDS.values(),
    "r_stance",
    "l_stance",
    OTHER,
)
"""Tracks of the whole body: what others of them tell is not carried out twice."""

REST: dict[str, Cell] = {
    **{"torso": (PLACE, HIGH), "head": (PLACE, HIGH)},
    **{"r_palm": (DIRECTION_CODES["left"], MID), "l_palm": (DIRECTION_CODES["right"], MID)},
}
"""Where a part is without a symbol; the others hang, palms face the thighs."""

# A limb folds straight towards its beginning; nearer than this, in place, its end turns
TURNING = 0.19
_SLIGHT = 1e-6  # a part of a unit vector: where the joint of a limb that points there goes up
IN_PLACE = 0.3  # how much of its length a limb reaches at most that is in place and bent as told
FASTEST = 10_000  # frames a second, at most
LONGEST = 100_000  # frames, at most: a slip in a file's number of units shall not take all memory


def carry_out(score: Score, rate: Fraction, noise: float, seed: int) -> Motion:
    """Carry out a score; see `perform.perform`."""
    if not 0 < rate <= FASTEST:
        raise UsageError(f"{rate} frames a second", wanted=f"more than 0, at most {FASTEST}")
    if not (isfinite(noise) and noise >= 0):
        raise UsageError(f"noise of {noise} mm", wanted="0 or more")
    frames = max(1, ceil(score.frames * rate / score.rate))
    if frames > LONGEST:
        raise UsageError(
            f"a score of {frames} frames at {float(rate):g} Hz",
            wanted=f"at most {LONGEST}",
            remedy="Perform it slower, or a part of it.",
        )
    times = np.arange(frames) / float(rate)
    body = standard(frozenset(score.tracks).intersection(FACING))
    bones, warnings = _bones(score, times, body), _left_out(score, body)
    travel = travel_of(score, times, body, bones)
    if travel is not None and travel.resting.rests:
        own, unrested = rest_bones(score, travel.resting, times, travel.hips[:, 1], bones, body)
        bones, warnings = bones | own, [*warnings, *travel.left_out, *unrested]
    twist = angles(score, "torso_twist", times).real
    joints = _joints(body, bones, chest_axes(bones["torso"], twist), travel)
    warnings += bring_hands(joints, score, times, body)
    palms = {}
    for part in (part for part in FACING if part in bones):
        ends = shown(score, part)["stop"] / float(score.rate)
        arrived = np.minimum(np.searchsorted(times, ends), frames - 1)
        palms[part] = _fronted(_on_stage(bones[part])[:, None], travel)[:, 0], arrived
    warnings += face_palms(joints, palms, body)
    axes = dict[str, NDArray[np.float32]]()
    if {"head_turn", "head_incline"} & score.tracks.keys():
        turn = np.zeros(frames) + twist + angles(score, "head_turn", times).real
        _, across = chest_axes(bones["torso"], turn)
        right = head_right(bones["head"], bones["torso"], across)
        head = np.stack((_on_stage(right), _on_stage(bones["head"])), axis=1)
        axes["Head"] = _fronted(head, travel).astype(np.float32)
    if noise:
        skeleton = body.skeleton
        shaken = np.random.default_rng(seed).normal(0, noise, (frames, len(skeleton.names), 3))
        for joint, name in enumerate(skeleton.names):
            if name.endswith(" End"):  # it shakes with its joint
                shaken[:, joint] = shaken[:, skeleton.parents[joint]]
        joints += shaken
    axes |= palm_axes(joints, body)
    source, places = Source("", "score", "mm", 1.0, "y"), joints.astype(np.float32)
    return Motion(body.skeleton, rate, places, source, warnings=tuple(warnings), axes=axes)


def _left_out(score: Score, body: Body) -> list[str]:
    """Return what the standard body cannot do."""
    strange = [
        f"the standard body has no {part}"
        for part in score.tracks
        if part not in PARTS and part not in CARRIED
    ]
    stiff = [
        f"{part} is one bone and cannot come to place mid: it stays where it is"
        for part in score.tracks
        if part in PARTS
        and PARTS[part].group not in body.limbs
        and _folds(shown(score, part)).any()
    ]
    return [*strange, *stiff]


def _bones(score: Score, times: Floats, body: Body) -> dict[str, Floats]:
    """Return each bone's direction, (T, 3): by its own track, its limb's, or the upper bone's."""
    own = {
        part: _bone_directions(score, part, times)
        for part in score.tracks
        if part in PARTS and PARTS[part].group not in body.limbs
    }
    own |= {  # inclines are finer than the tracks of torso and head
        part: lean_direction(angles(score, f"{part}_incline", times))
        for part in ("torso", "head")
        if f"{part}_incline" in score.tracks
    }
    bones = {"torso": own.get("torso", np.broadcast_to(UP, (len(times), 3)))}
    bones["head"] = own.get("head", bones["torso"])
    for side in "rl":
        for group, limb in body.limbs.items():
            part = f"{side}_{group}"
            upper, lower = (f"{side}_{bone}" for bone in limb.bones)
            bones[upper], bones[lower] = _bent_limb_directions(score, part, limb, times)
            if upper in own:
                bones[upper] = own[upper]
                bones[lower] = bones[lower] if part in score.tracks else own[upper]
            bones[lower] = own.get(lower, bones[lower])
        bones[f"{side}_hand"] = own.get(f"{side}_hand", bones[f"{side}_forearm"])
        standing = np.broadcast_to(unit(body.toe), (len(times), 3))
        turned = _turned(standing, -UP, bones[f"{side}_shank"])
        bones[f"{side}_foot"] = bones[f"{side}_toes"] = own.get(f"{side}_foot", turned)
        bones |= {part: own[part] for part in FACING if part in own}
    return bones


def _folds(rows: NDArray[Any]) -> NDArray[np.bool_]:
    folds: NDArray[np.bool_] = (rows["direction"] == FOLDED[0]) & (rows["level"] == FOLDED[1])
    return folds


def _side(part: str) -> float:
    """Return the sign of a part's own side; the right for head and torso."""
    return -1.0 if part.startswith("l_") else 1.0


def _bone_directions(score: Score, part: str, times: Floats) -> Floats:
    """Return where a single bone points, (T, 3)."""
    rows = shown(score, part)
    points = np.empty((len(times), 3))
    side = np.array([0.0, 0.0, _side(part)])
    for reach in reaches(rows[~_folds(rows)], times, score.rate, REST.get(part, (PLACE, LOW))):
        ends = direction_vector(reach.start), direction_vector(reach.stop)
        points[reach.frames] = great_circle(*ends, reach.share, side)
    return points


def _bent_limb_directions(
    score: Score, part: str, limb: Limb, times: Floats
) -> tuple[Floats, Floats]:
    """Return where the upper and the lower bone of a limb point, (T, 3) each."""
    directions, aside = np.empty((2, len(times), 3))
    reach_of = np.empty(len(times))
    mirror = np.array([1.0, 1.0, _side(part)])
    for reach in reaches(shown(score, part), times, score.rate, REST.get(part, (PLACE, LOW))):
        frames = reach.frames
        directions[frames], aside[frames], reach_of[frames] = _limb_directions(reach, limb, mirror)
    if BENDS[part] in score.tracks:
        bent_reach = reach_when_bent(shown(score, BENDS[part]), times, score.rate)
        reach_of = np.minimum(np.maximum(reach_of, IN_PLACE), bent_reach)
    along = reach_of[:, None] * directions
    across = np.sqrt(np.maximum(1 - reach_of**2, 0))[:, None] * aside
    return along + across, along - across


def _limb_directions(reach: Reach, limb: Limb, mirror: Floats) -> tuple[Floats, Floats, Floats]:
    """Return a limb's direction and where its joint goes, (T, 3), and how far it reaches, (T,)."""
    toward, side = limb.toward * mirror, mirror * [0, 0, 1]
    start, stop = (
        toward if cell == FOLDED else direction_vector(cell) for cell in (reach.start, reach.stop)
    )
    lengths = [limb.near if cell == FOLDED else 1.0 for cell in (reach.start, reach.stop)]
    length = lengths[0] + (lengths[1] - lengths[0]) * reach.share
    share = reach.share
    if lengths[0] != lengths[1]:
        turn = np.clip((TURNING - length) / (TURNING - limb.near), 0, 1)
        share = turn if lengths[1] < lengths[0] else 1 - turn
    directions = great_circle(start, stop, share, side)
    bend = limb.bend * mirror + _SLIGHT * UP
    if lengths[0] != lengths[1]:
        return directions, _across(bend, directions), length
    ends = np.stack((start, great_circle(start, stop, np.array([0.5]), side)[0], stop))
    return directions, _transported(_across(bend, ends), ends, directions, share), length


def _across(vector: Floats, directions: Floats) -> Floats:
    """Return the directions at right angles to ways, (T, 3), that are nearest to a vector."""
    return unit(vector - (directions @ vector)[:, None] * directions)


def _transported(across: Floats, ends: Floats, directions: Floats, share: Floats) -> Floats:
    """Return directions at right angles to a great circle, (T, 3), from the first to the last.

    They go along with `directions`, and turn about them by as much as is missing at the end: none
    leaps where these come past where the limb's joint would go.

    `across, ends`: (3, 3) such directions, and ways, at the beginning, half-way and at the end;
    `directions, share`: (T, 3), and (T,) how much of it is done.
    """
    axis = np.cross(ends[0], ends[1])
    sine = float(np.linalg.norm(axis))
    axis, whole = axis / max(sine, _SLIGHT), 2 * np.arctan2(sine, ends[0] @ ends[1])
    there = _rotated(across[0], axis, whole)
    missing = np.arctan2(np.cross(there, across[2]) @ ends[2], there @ across[2])
    return _rotated(
        _rotated(across[0], axis, whole * share[:, None]), directions, missing * share[:, None]
    )


def _rotated(vectors: Floats, axis: Floats, angle: Any) -> Floats:
    """Turn vectors about an axis by angles, radians."""
    along = dot(axis, vectors) * axis
    spun: Floats = (
        along + np.cos(angle) * (vectors - along) + np.sin(angle) * np.cross(axis, vectors)
    )
    return spun


def _turned(vectors: Floats, start: Floats, stop: Floats) -> Floats:
    """Turn vectors, (T, 3), as the smallest turn takes `start`, (3,), to `stop`, (T, 3)."""
    axis = np.cross(start, stop)
    sine, cosine = np.linalg.norm(axis, axis=1, keepdims=True), (stop @ start)[:, None]
    axis = axis / np.where(sine > 0, sine, 1)
    along = dot(axis, vectors) * axis
    turned: Floats = cosine * (vectors - along) + along + sine * np.cross(axis, vectors)
    # half a turn is made about the axis from left to right
    opposite = (sine[:, 0] < 1e-9) & (cosine[:, 0] < 0)
    turned[opposite] = vectors[opposite] * [-1, -1, 1]
    return turned


def _joints(
    body: Body, bones: dict[str, Floats], chest: tuple[Floats, Floats], travel: Travel | None
) -> Floats:
    """Return positions (T, J, 3), mm, y up; facing +z, left +x at first."""
    skeleton = body.skeleton
    offsets = skeleton.offsets.astype(np.float64)
    frames = len(bones["torso"])
    bones = bones if travel is None else bones | travel.legs
    joints = np.empty((frames, len(offsets), 3))
    for joint, (parent, bone) in enumerate(zip(skeleton.parents, body.bones, strict=True)):
        offset = np.broadcast_to(offsets[joint], (frames, 3))
        if bone == "torso":
            axes = np.stack((chest[0], bones[bone], chest[1]), axis=1)
            own = offset[:, ::-1] * [1, 1, -1]  # in the body frame
            offset = _on_stage(np.einsum("ti,tij->tj", own, axes))
        elif bone and bone not in FACING:
            offset = np.linalg.norm(offsets[joint]) * _on_stage(bones[bone])
        joints[:, joint] = offset + (joints[:, parent] if parent >= 0 else 0)
    if travel is not None:
        moved: Floats = _fronted(joints - joints[:, :1], travel) + _on_stage(travel.hips)[:, None]
        return moved
    # a body that goes nowhere has the lower foot on the floor
    feet = [index for index, bone in enumerate(body.bones) if bone.endswith(("_foot", "_toes"))]
    joints[..., 1] += body.sole - joints[:, feet, 1].min(axis=1, keepdims=True)
    return joints


def _fronted(vectors: Floats, travel: Travel | None) -> Floats:
    """Turn vectors, (T, K, 3), as a body has turned."""
    if travel is None:
        return vectors
    sine, cosine = np.sin(travel.front)[:, None], np.cos(travel.front)[:, None]
    x, y, z = np.moveaxis(vectors, -1, 0)
    return np.stack((x * cosine + z * sine, y, z * cosine - x * sine), axis=-1)


def _on_stage(vectors: Floats) -> Floats:
    """Turn vectors from the body frame to the stage: right is -x, forward +z."""
    return np.stack([-vectors[..., 2], vectors[..., 1], vectors[..., 0]], axis=-1)
