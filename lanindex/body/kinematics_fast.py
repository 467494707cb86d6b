"""From channels to places, frame by frame, by a compiled loop (extra ``fast``).

It does the same operations in the same order as `kinematics`, so that both give the same bits.
"""

import numba
import numpy as np

from lanindex.body.kinematics import COSINE, RADIANS, SINE, Array, Plan

_S, _C = SINE, COSINE


@numba.njit
def _sine_cosine(row, columns, sines, cosines, child_first):
    """Do one frame; the second loop has neither branches nor strides, so that it is vectorised."""
    for turn in range(len(columns)):
        sines[turn] = row[columns[turn]]
    for turn in range(len(columns)):
        degrees = sines[turn]
        quarter = np.rint(degrees / 90.0)
        rest = (degrees - 90.0 * quarter) * RADIANS
        x = rest * rest
        sine = (((_S[0] * x + _S[1]) * x + _S[2]) * x + _S[3]) * x + _S[4]
        sine = ((sine * x + _S[5]) * x + _S[6]) * x + _S[7]
        cosine = (((_C[0] * x + _C[1]) * x + _C[2]) * x + _C[3]) * x + _C[4]
        cosine = (((cosine * x + _C[5]) * x + _C[6]) * x + _C[7]) * x + _C[8]
        sine = sine * rest
        quarter -= 4.0 * np.floor(quarter * 0.25)
        odd = (quarter == 1.0) | (quarter == 3.0)
        turned = (cosine if odd else sine) * (-1.0 if quarter >= 2.0 else 1.0)
        opposite = (quarter == 1.0) | (quarter == 2.0)
        cosines[turn] = (sine if odd else cosine) * (-1.0 if opposite else 1.0)
        sines[turn] = -turned if child_first else turned


@numba.njit
def _turn(source, target, axis, sine, cosine):
    """Turn three rows of `source` into `target`, which may be the same."""
    one = axis + 1 if axis < 2 else 0
    other = axis - 1 if axis > 0 else 2
    for k in range(3):
        first = cosine * source[one, k] + sine * source[other, k]
        target[other, k] = cosine * source[other, k] - sine * source[one, k]
        target[one, k] = first
        target[axis, k] = source[axis, k]


@numba.njit
def _place(base, shift, origin, child_first, place):
    for k in range(3):
        if child_first:
            moved = base[k, 0] * shift[0]
            moved += base[k, 1] * shift[1]
            moved += base[k, 2] * shift[2]
        else:
            moved = base[0, k] * shift[0]
            moved += base[1, k] * shift[1]
            moved += base[2, k] * shift[2]
        place[k] = origin[k] + moved


@numba.njit(cache=True, nogil=True)
def _positions(parents, offsets, columns_of, turns, axes, columns, child_first, values, places):
    joints = len(parents)
    turned = np.zeros((joints + 1, 3, 3))
    for k in range(3):
        turned[joints, k, k] = 1.0
    sines, cosines = np.empty(len(columns)), np.empty(len(columns))
    shift = np.empty(3)
    for frame in range(len(values)):
        row = values[frame]
        _sine_cosine(row, columns, sines, cosines, child_first)
        for joint in range(joints):
            parent = parents[joint]
            for k in range(3):
                column = columns_of[joint, k]
                shift[k] = row[column] if column >= 0 else offsets[joint, k]
            if parent < 0:
                for k in range(3):
                    places[frame, joint, k] = shift[k]
                parent = joints
            else:
                _place(
                    turned[parent], shift, places[frame, parent], child_first, places[frame, joint]
                )
            source, target = turned[parent], turned[joint]
            count = turns[joint + 1] - turns[joint]
            for step in range(count):
                index = turns[joint] + (count - 1 - step if child_first else step)
                _turn(source, target, axes[index], sines[index], cosines[index])
                source = target
            if count == 0:
                for k in range(3):
                    for m in range(3):
                        target[k, m] = source[k, m]


def positions(plan: Plan, values: Array) -> Array:
    """Carry out a plan: see `lanindex.body.kinematics.positions`."""
    places = np.empty((len(values), len(plan.parents), 3))
    _positions(*plan, values, places)
    return places
