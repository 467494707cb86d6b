"""Score to Motion: a standard body carries out a score.

Tracks become directions of bones, bones become joints. Source: ``encoding/BODY.md``, "Touch",
"Palms", "Twists" and "Inclines", read backwards.
"""

from collections.abc import Iterator, Mapping
from fractions import Fraction
from math import ceil, isfinite
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lanindex.alphabet import (
    BENDS,
    DIRECTION_CODES,
    FACING,
    HIGH,
    JOINT_CODES,
    LOW,
    MID,
    PARTS,
    PLACE,
    TOUCHED,
    TRACKS,
    amounts_of,
)
from lanindex.body.axes import facing, planes
from lanindex.data import shipped
from lanindex.errors import UsageError
from lanindex.model import Motion, Score, Source
from lanindex.model.score import rows_of
from lanindex.perform.limbs import (
    FOLDED,
    UP,
    Body,
    Cell,
    Floats,
    Limb,
    direction_vector,
    dot,
    great_circle,
    minimum_jerk,
    reach_when_bent,
    reaches,
    share_done,
    standard,
    turned,
    unit,
)
from lanindex.perform.travel import Travel, travel_of

REST: dict[str, Cell] = {
    **{"torso": (PLACE, HIGH), "head": (PLACE, HIGH)},
    **{"r_palm": (DIRECTION_CODES["left"], MID), "l_palm": (DIRECTION_CODES["right"], MID)},
}
"""Where a part is without a symbol; the others hang, palms face the thighs."""

# A limb folds straight towards its beginning; nearer than this, in place, its end turns
TURNING = 0.19
_SLIGHT = 1e-6  # a part of a unit vector that tells nothing: what is shorter has no direction
IN_PLACE = 0.3  # how much of its length a limb reaches at most that is in place and bent as told
NEARLY = 0.92  # cosine of 23 degrees: a palm farther off than that is reported
FASTEST = 10_000  # frames a second, at most
LONGEST = 100_000  # frames, at most: a slip in a file's number of units shall not take all memory


def perform(
    score: Score, *, rate: Fraction | int = 60, noise: float = 0.0, seed: int = 0
) -> Motion:
    """Carry out a score.

    Limbs are straight. Each symbol is one reach along the great circle from the direction in
    force to the symbol's, with minimum jerk, from its first frame to its end; between symbols the
    part rests. Forearm and shank have tracks of their own or follow the arm and leg, hands follow
    the forearms, the head the torso, feet their shanks. The lower foot stands on the floor. Chest
    and head twist and lean on straight ways.
    Parts without a track hang or stand; passing symbols are passed over. The body kneels, sits,
    lies or props itself while something else than feet carries. Hands come to what they
    touch, whatever their arms' tracks say, if they reach it.

    Parameters
    ----------
    score : Score
        Of a capture, or read from LND.
    rate : Fraction or int
        Frames a second of the motion.
    noise : float
        Standard deviation, mm, of each coordinate of every joint.
    seed : int
        Of the noise; the same seed gives the same motion.

    Returns
    -------
    Motion
        Facing +z, y up, left +x. What the body could not do is among its warnings.

    Raises
    ------
    UsageError
        Where rate or noise make no sense, or there would be too many frames.

    Examples
    --------
    >>> import lanindex
    >>> motion = lanindex.animate(lanindex.read_lnd("corpus/jumping_jacks.lnd"), rate=30)
    >>> len(motion), motion.rate, motion.warnings
    (360, Fraction(30, 1), ())
    >>> lanindex.encode(motion).symbols("r_arm")[2].words
    'right mid'
    """
    rate = Fraction(rate)
    if not 0 < rate <= FASTEST:
        raise UsageError(f"{rate} frames a second", wanted=f"more than 0, at most {FASTEST}")
    if not (isfinite(noise) and noise >= 0):
        raise UsageError(f"noise of {noise} mm", wanted="0 or more")
    frames = max(1, ceil(score.frames * rate / score.rate))
    if frames > LONGEST:
        found = f"a score of {frames} frames at {float(rate):g} Hz"
        remedy = "Perform it slower, or a part of it."
        raise UsageError(found, wanted=f"at most {LONGEST}", remedy=remedy)
    times = np.arange(frames) / float(rate)
    body = standard(frozenset(score.tracks).intersection(FACING))
    bones, warnings = _bones(score, times, body), _left_out(score, body)
    travel = travel_of(score, times, body, bones)
    if travel is not None:
        bones, warnings = bones | travel.bones, warnings + travel.warnings
    twist = angles(score, "torso_twist", times).real
    joints = _joints(body, bones, chest_axes(bones["torso"], twist), travel)
    warnings += bring_hands(joints, score, times, body)
    palms = {}
    for part in (part for part in FACING if part in bones):
        ends = rows_of(score, part)["stop"] / float(score.rate)
        arrived = np.minimum(np.searchsorted(times, ends), frames - 1)
        palms[part] = _fronted(_on_stage(bones[part])[:, None], travel)[:, 0], arrived
    warnings += face_palms(joints, palms, body)
    axes = dict[str, NDArray[np.float32]]()
    if {"head_turn", "head_incline"} & score.tracks.keys():
        turn = twist + angles(score, "head_turn", times).real
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
    strange = [f"the standard body has no {it}" for it in score.tracks if it not in TRACKS]
    stiff = [
        f"{part} is one bone and cannot come to place mid: it stays where it is"
        for part in _single_bones(score, body)
        if _folds(rows_of(score, part)).any()
    ]
    return [*strange, *stiff]


def _single_bones(score: Score, body: Body) -> list[str]:
    return [it for it in score.tracks if it in PARTS and PARTS[it].group not in body.limbs]


def _bones(score: Score, times: Floats, body: Body) -> dict[str, Floats]:
    """Return each bone's direction, (T, 3): by its own track, its limb's, or the upper bone's."""
    own = {it: _bone_directions(score, it, times) for it in _single_bones(score, body)}
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


def _folds(rows: NDArray[Any]) -> Any:
    """Return which rows, (S,), fold a limb."""
    return (rows["direction"] == FOLDED[0]) & (rows["level"] == FOLDED[1])


def _side(part: str) -> float:
    """Return the sign of a part's own side; the right for head and torso."""
    return -1.0 if part.startswith("l_") else 1.0


def _bone_directions(score: Score, part: str, times: Floats) -> Floats:
    """Return where a single bone points, (T, 3)."""
    rows = rows_of(score, part)
    points = np.empty((len(times), 3))
    side = np.array([0.0, 0.0, _side(part)])
    rest = REST.get(part, (PLACE, LOW))
    for frames, begin, end, share in reaches(rows[~_folds(rows)], times, score.rate, rest):
        ends = direction_vector(begin), direction_vector(end)
        points[frames] = great_circle(*ends, share, side)
    return points


def _bent_limb_directions(
    score: Score, part: str, limb: Limb, times: Floats
) -> tuple[Floats, Floats]:
    """Return where the upper and the lower bone of a limb point, (T, 3) each."""
    directions, aside = np.empty((2, len(times), 3))
    reach_of = np.empty(len(times))
    mirror = np.array([1.0, 1.0, _side(part)])
    for frames, begin, end, share in reaches(rows_of(score, part), times, score.rate, (PLACE, LOW)):
        ways = _limb_directions(begin, end, share, limb, mirror)
        directions[frames], aside[frames], reach_of[frames] = ways
    if BENDS[part] in score.tracks:
        bent_reach = reach_when_bent(rows_of(score, BENDS[part]), times, score.rate)
        reach_of = np.minimum(np.maximum(reach_of, IN_PLACE), bent_reach)
    along = reach_of[:, None] * directions
    across = np.sqrt(np.maximum(1 - reach_of**2, 0))[:, None] * aside
    return along + across, along - across


def _limb_directions(
    begin: Cell, end: Cell, share: Floats, limb: Limb, mirror: Floats
) -> tuple[Floats, Floats, Floats]:
    """Return a limb's direction and where its joint goes, (T, 3), and how far it reaches, (T,)."""
    toward, side = limb.toward * mirror, mirror * [0, 0, 1]
    start, stop = (toward if it == FOLDED else direction_vector(it) for it in (begin, end))
    lengths = [limb.near if it == FOLDED else 1.0 for it in (begin, end)]
    length = lengths[0] + (lengths[1] - lengths[0]) * share
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

    `across, ends` (3, 3) at the beginning, half-way and at the end; `share` (T,) is what is done.
    """
    # they turn about the way by as much as is missing at the end, and never leap
    axis = np.cross(ends[0], ends[1])
    sine = float(np.linalg.norm(axis))
    axis, whole = axis / max(sine, _SLIGHT), 2 * np.arctan2(sine, ends[0] @ ends[1])
    there = _rotated(across[0], axis, whole)
    missing = np.arctan2(np.cross(there, across[2]) @ ends[2], there @ across[2])
    carried = _rotated(across[0], axis, whole * share[:, None])
    return _rotated(carried, directions, missing * share[:, None])


def _rotated(vectors: Floats, axis: Floats, angle: Any) -> Floats:
    """Turn vectors about an axis by angles, radians."""
    return _spun(vectors, axis, np.cos(angle), np.sin(angle))


def _spun(vectors: Floats, axis: Floats, cosine: Any, sine: Any) -> Floats:
    along = dot(axis, vectors) * axis
    spun: Floats = along + cosine * (vectors - along) + sine * np.cross(axis, vectors)
    return spun


def _turned(vectors: Floats, start: Floats, stop: Floats) -> Floats:
    """Turn vectors, (T, 3), as the smallest turn takes `start`, (3,), to `stop`, (T, 3)."""
    axis = np.cross(start, stop)
    sine, cosine = np.linalg.norm(axis, axis=1, keepdims=True), (stop @ start)[:, None]
    turned = _spun(vectors, axis / np.where(sine > 0, sine, 1), cosine, sine)
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
    return vectors if travel is None else turned(vectors, travel.front[:, None])


def _on_stage(vectors: Floats) -> Floats:
    """Turn vectors from the body frame to the stage: right is -x, forward +z."""
    return np.stack([-vectors[..., 2], vectors[..., 1], vectors[..., 0]], axis=-1)


def face_palms(
    joints: Floats, wanted: Mapping[str, tuple[Floats, NDArray[np.int64]]], body: Body
) -> list[str]:
    """Place knuckles, in (T, J, 3) mm, as palms shall face, (T, 3) by part; return what fails."""
    warnings = []
    for part, (out, arrived) in wanted.items():
        names = part[0].upper() + "Wrist", part[0].upper() + "Hand"
        wrist, tip = (int(body.skeleton.body[JOINT_CODES[name]]) for name in names)
        along = unit(joints[:, tip] - joints[:, wrist])
        palm = out - dot(out, along) * along
        size = np.linalg.norm(palm, axis=1)
        if (size[arrived] < NEARLY).any():
            warnings.append(f"{part} cannot face along the hand: it comes as near as it can")
        none = size < _SLIGHT
        palm[none] = np.cross(along[none], np.eye(3)[np.abs(along[none]).argmin(axis=1)])
        thumb = np.cross(along, unit(palm)) * (1 if part[0] == "r" else -1)
        for joint in (number for number, bone in enumerate(body.bones) if bone == part):
            far, _, aside = body.skeleton.offsets[joint].tolist()
            above = joints[:, body.skeleton.parents[joint]]
            joints[:, joint] = above + abs(far) * along + aside * thumb
    return warnings


def palm_axes(joints: Floats, body: Body) -> dict[str, NDArray[np.float32]]:
    """Return the axes of the hands of a body with knuckles, as in `Motion.axes`."""
    found = {}
    for hand, (first, last, _) in planes(body.skeleton.names).items():
        wrist = joints[:, body.skeleton.body[JOINT_CODES[hand[0] + "Wrist"]]]
        across, along = joints[:, first] - joints[:, last], joints[:, first] - wrist
        found[hand] = facing(hand, across, along).astype(np.float32)
    return found


def angles(score: Score, part: str, times: Floats) -> NDArray[np.complex128]:
    """Return the twist or lean of a part, (T,) degrees: real to the right, imaginary forward."""
    found, now = np.zeros(len(times), np.complex128), 0j
    for row in rows_of(score, part):
        start, stop = (float(Fraction(int(row[end])) / score.rate) for end in ("start", "stop"))
        some = slice(int(np.searchsorted(times, start)), None)
        code, degrees, there = int(row["direction"]), int(row["amount"]), 0j
        if 0 <= code < PLACE and degrees >= 0:
            there = complex(degrees * np.exp(1j * np.radians(45 * code)))
        found[some] = now + (there - now) * share_done(times[some], start, stop)
        now = there
    return found


def lean_direction(lean: NDArray[np.complex128]) -> Floats:
    """Return the unit vectors, (T, 3), of a lean in degrees, (T,) as `twists` tells them."""
    size = np.abs(lean)
    way = lean / np.maximum(size, _SLIGHT)
    flat = np.sin(np.radians(size))
    return np.stack((flat * way.imag, np.cos(np.radians(size)), flat * way.real), axis=1)


def chest_axes(trunk: Floats, twist: Floats) -> tuple[Floats, Floats]:
    """Return the chest's front and right, (T, 3), from the trunk, (T, 3), and its twist, (T,)."""
    right = np.array([0.0, 0.0, 1.0])
    across = right - trunk[:, 2:] * trunk
    size = np.linalg.norm(across, axis=1, keepdims=True)
    aside = size < _SLIGHT  # as the torso lay down on its side, its right went down
    across = np.where(aside, -np.sign(trunk[:, 2:]) * [0.0, 1.0, 0.0], across / (size + aside))
    front = np.cross(trunk, across)
    cosine, sine = np.cos(np.radians(twist))[:, None], np.sin(np.radians(twist))[:, None]
    return cosine * front + sine * across, cosine * across - sine * front


def head_right(up: Floats, trunk: Floats, across: Floats) -> Floats:
    """Return a head's right, (T, 3), by its top and the chest's up and right, turned as it."""
    along = dot(up, trunk)
    along = np.where(np.abs(along) < _SLIGHT, _SLIGHT, along)
    return unit(across - dot(up, across) / along * trunk)


# The tracks that are carried out here, and whose hands they are of
TOUCHES = {"hands_touch": "RL", "r_hand_touch": "R", "l_hand_touch": "L"}
# Seconds that a hand is on its way, that it still comes nearer when touch begins, and that it has
# been on its way back when touch ends
COMES, NEARS, LEAVES = 0.5, 0.06, 0.12
PALM = 0.15  # lengths of an arm from the wrist to the middle of the palm
FARTHEST = 0.97  # part of its length, to the palm, that an arm reaches
_BEND = np.array([-0.3, -0.8, 0.6])  # forward, up, out: where an elbow goes


def bring_hands(joints: Floats, score: Score, times: Floats, body: Body) -> list[str]:
    """Bring hands to what they touch, (T, J, 3) mm in place; return what is out of reach."""
    numbers = {name: int(body.skeleton.body[code]) for name, code in JOINT_CODES.items()}
    places = {name: joints[:, number].copy() for name, number in numbers.items()}
    arm, left_out = sum(body.arm[:2]), list[str]()
    for side, thing, share in _touches(score, times):
        some = np.flatnonzero(share > 0)
        if not len(some):
            continue
        done, seen = share[some], {name: it[some] for name, it in places.items()}
        shoulder, elbow, wrist, hand = (
            seen[side + it] for it in ("Shoulder", "Elbow", "Wrist", "Hand")
        )
        up = unit(seen["Neck"] - seen["Pelvis"])
        right = seen["RHip"] - seen["LHip"]
        right = unit(right - dot(right, up) * up)
        out = right * (1 if side == "R" else -1)
        axes = np.stack([np.cross(up, right), up, out], axis=1)  # of the trunk, (T, 3, 3)
        ends, along, way = shipped("perform/figure.toml")["touched"][thing]
        other = {"R": "L", "L": "R"}[side]
        first, last = (it.replace("other ", other).replace("own ", side) for it in ends)
        target = seen[first] + along * (seen[last] - seen[first])
        target = target + arm * np.einsum("i,tij->tj", np.array(way), axes)
        near = np.linalg.norm(target - shoulder, axis=1) <= FARTHEST * (arm + PALM * arm)
        if not near[done > 0.99].all():
            failure = f"{side.lower()}_hand does not reach the {thing}"
            left_out.append(f"{failure}: it stays where its arm points")
            continue
        palm = wrist + PALM * arm * unit(hand - wrist)
        palm += (target - palm) * done[:, None]
        elbow, wrist = _folded_arm(shoulder, palm, axes, elbow, done, body)
        joints[some, numbers[side + "Elbow"]] = elbow
        joints[some, numbers[side + "Wrist"]] = wrist
        before, far = numbers[side + "Wrist"], 0.0
        for number, parent in enumerate(body.skeleton.parents):
            if parent == before:  # those beyond the wrist are in line
                far += float(np.linalg.norm(body.skeleton.offsets[number]))
                joints[some, number] = wrist + far * unit(palm - wrist)
                before = number
        for name in (side + it for it in ("Elbow", "Wrist", "Hand")):
            places[name][some] = joints[some, numbers[name]]
    return list(dict.fromkeys(left_out))


def _touches(score: Score, times: Floats) -> Iterator[tuple[str, str, Floats]]:
    """Yield whose palm comes to what, and how much it is there, (T,); hands to hands last."""
    for part, sides in reversed(TOUCHES.items()):
        if part not in score.tracks:
            continue
        rows = score.tracks[part].symbols
        starts, stops = (rows[it].astype(float) / float(score.rate) for it in ("start", "stop"))
        rests = np.maximum(starts[1:] - stops[:-1], 0.2) / 2
        before = np.minimum(np.concatenate([[COMES], rests]), COMES)
        after = np.minimum(np.concatenate([rests, [COMES]]), COMES)
        when = np.stack([starts, stops, before[: len(rows)], after[len(after) - len(rows) :]], 1)
        for row, (start, stop, coming, going) in zip(rows, when.tolist(), strict=True):
            thing = TOUCHED[row["amount"]] if 0 <= row["amount"] < len(TOUCHED) else ""
            if row["passing"] or thing not in amounts_of(part):
                continue
            begin, end = start + NEARS - coming, stop - LEAVES + going
            comes = np.clip((times - begin) / coming, 0, 1)
            goes = np.clip((end - times) / going, 0, 1)
            share = minimum_jerk(np.minimum(comes, goes))
            yield from ((side, thing, share) for side in sides)


def _folded_arm(
    shoulder: Floats, palm: Floats, axes: Floats, elbow: Floats, share: Floats, body: Body
) -> tuple[Floats, Floats]:
    """Return elbow and wrist of an arm whose palm lies there, the hand in line with the forearm."""
    upper, forearm, _ = body.arm
    lower = forearm + PALM * (upper + forearm)
    direction = palm - shoulder
    far = np.clip(np.linalg.norm(direction, axis=1, keepdims=True), 1e-9, upper + lower)
    direction = unit(direction)
    bend = np.einsum("i,tij->tj", _BEND, axes) * share[:, None]
    bend += (elbow - shoulder) / upper * (1 - share[:, None])
    bend = unit(bend - dot(bend, direction) * direction)
    along = (upper**2 - lower**2 + far**2) / (2 * far)
    out = np.sqrt(np.maximum(upper**2 - along**2, 0))
    found = shoulder + along * direction + out * bend
    return found, found + forearm * unit(palm - found)
