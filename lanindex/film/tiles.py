"""The figure of a capture as a page is given it: its strokes, and its places in tiles."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from lanindex.alphabet import TRACKS
from lanindex.film.figure import JOINTS, Figure, Strokes

SECONDS = 10  # in a tile
UNKNOWN = -32768  # stands for a place that is not known, among whole millimetres


def described(figure: Figure) -> dict[str, Any]:
    """Return the body of a figure as JSON: its joints, and its strokes as in films.

    A stroke has the part of its bone, and the tracks that it shows: with each of them it is lit.
    """
    strokes, shown = Strokes(figure), {track: figure.shown([track]) for track in TRACKS}
    rows = zip(strokes.inner.tolist(), strokes.outer.tolist(), strokes.table, strict=True)
    return {
        "joints": [*JOINTS],
        "strokes": [
            {
                "from": inner,
                "to": outer,
                "share": round(share, 4),
                "width": width,
                "color": color,
                "part": figure.parts[bone],
                "shows": [track for track, bones in shown.items() if bones[bone]],
            }
            for inner, outer, (bone, share, width, color) in rows
        ],
    }


def packed(places: NDArray[np.float32]) -> bytes:
    """Return places, (F, 21, 3) mm, as a tile.

    It is three float32, an origin, and (F, 21, 3) int16, whole millimetres from there, all little
    end first; what is unknown, or further than 32 m away, is -32768.
    """
    known = np.isfinite(places)
    origin = np.zeros(3, "<f4")
    for axis in range(3):
        if (some := places[..., axis][known[..., axis]]).size:
            origin[axis] = np.rint((some.min() + some.max()) / 2)
    away = np.rint(places - origin)
    near = (known & (abs(np.nan_to_num(away)) < -UNKNOWN)).all(axis=2, keepdims=True)
    return origin.tobytes() + np.where(near, away, UNKNOWN).astype("<i2").tobytes()
