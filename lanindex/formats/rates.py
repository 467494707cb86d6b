"""Frames a second: what a file says, what its times tell, what its user says instead."""

from fractions import Fraction
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from lanindex.errors import CaptureError, UsageError
from lanindex.model import Reading

WITHIN = 0.01  # of the duration: what a rate and the times may differ by
ROUNDED = 0.006  # seconds: what two times may be wrong by, where they are written in hundredths
MEASURED = 0.02  # of the rate: what a whole number may be away from it, where times were measured
UNEVEN = 0.5  # of the usual step: what a step may differ by

_USUAL = (10, 500)
_SLOWEST = 1  # frames a second: a Frame Time of 30 is a rate in the wrong place
_SNAP = Fraction(2, 10_000)


def rate_of(text: str | None, place: str, wanted: Fraction | float | str | None) -> Fraction:
    """Return the frames a second."""
    if wanted is not None:
        return given_rate(wanted)
    time = _fraction(text) if text is not None else None
    if time is None or 1 / time < _SLOWEST:
        raise CaptureError(
            "no Frame Time: line" if text is None else f"Frame Time: {text[:40]!r}",
            place=place,
            wanted=f"seconds a frame, above 0 and at most {1 / _SLOWEST:g}",
            remedy="Give the rate with --fps, in Python rate.",
        )
    return nearest_rate(1 / time)


def given_rate(wanted: Fraction | float | str) -> Fraction:
    """Return the frames a second that the user says."""
    given = _fraction(str(wanted))
    if given is None or given < _SLOWEST:
        raise UsageError(
            f"a rate of {wanted} frames a second", wanted=f"a number of {_SLOWEST} or more"
        )
    return nearest_rate(given)


@lru_cache(maxsize=64)
def _fraction(text: str) -> Fraction | None:
    """Return a number between a millionth and 1000000 exactly, else None."""
    try:
        value = Fraction(text) if len(text) < 24 and "e" not in text.lower() else float(text)
        if not 1e-6 <= value <= 1e6 or "_" in text:
            return None
        return Fraction(value).limit_denominator(10**9)
    except (ValueError, ZeroDivisionError):
        return None


@lru_cache(maxsize=64)
def nearest_rate(rate: Fraction) -> Fraction:
    """Return the nearest n or n * 1000/1001 within 0.02 %, else `rate` itself."""
    slow = Fraction(1000, 1001)
    best = min((Fraction(round(rate)), round(rate / slow) * slow), key=lambda n: abs(n - rate))
    return best if best > 0 and abs(best - rate) <= _SNAP * rate else rate.limit_denominator(10**6)


def rate_doubt(rate: Fraction) -> tuple[str, ...]:
    """Return a warning where a rate is unusual."""
    if _USUAL[0] <= rate <= _USUAL[1]:
        return ()
    return (f"{float(rate):g} frames a second is unusual: if it is wrong, give --fps",)


def rate_by(
    options: Reading, place: str, text: str, times: NDArray[np.float64] | None = None
) -> tuple[Fraction, tuple[str, ...]]:
    """Return the frames a second: what a header says, unless its times, (T,), contradict it."""
    if options.rate is not None:
        return given_rate(options.rate), ()
    stated = _fraction(text)
    stated = stated if stated and stated >= _SLOWEST else None
    seen, doubts = (None, ()) if times is None else _by_times(times)
    if stated is None and seen is None:
        raise CaptureError(
            f"a rate of {text[:40]!r}" if text else "nothing tells its rate",
            place=place,
            wanted="1 to 1000000 frames a second" + ", or times that grow" * (times is not None),
            remedy="Give the rate with --fps, in Python rate.",
        )
    if times is None or stated is None or seen is None:
        return nearest_rate(stated or seen or Fraction(1)), doubts
    first, last = np.flatnonzero(np.isfinite(times))[[0, -1]].tolist()
    lasts, should = float(times[last] - times[first]), (last - first) / float(stated)
    if doubts or abs(should - lasts) <= WITHIN * lasts + ROUNDED:
        return nearest_rate(stated), doubts
    found = f"says {float(stated):g} frames a second, its times say {float(seen):g}"
    return seen, (f"{found}: the times believed",)


def _by_times(times: NDArray[np.float64]) -> tuple[Fraction | None, tuple[str, ...]]:
    """Return the rate by which times grow, and whether they do so unevenly."""
    steps = np.diff(times)
    steps = steps[np.isfinite(steps)]
    usual = float(np.median(steps)) if len(steps) else 0.0
    if not 1e-6 <= usual <= 1:
        return None, ()
    away = np.abs(steps - usual)
    off = away > UNEVEN * usual + ROUNDED * (usual > ROUNDED)
    doubts: tuple[str, ...] = ()
    if off.any():
        many = f"{np.count_nonzero(off)} of {len(steps)} steps in time"
        doubts = (f"{many} differ from the usual {usual:.4g} s: frames may be missing",)
    near = steps[~off]
    rate = Fraction(1 / (float(near.mean()) if len(near) else usual))
    if away.max() > ROUNDED * usual and abs(round(rate) - rate) <= MEASURED * rate:
        rate = Fraction(round(rate))  # a clock that measures frames does not part them
    return nearest_rate(rate), doubts
