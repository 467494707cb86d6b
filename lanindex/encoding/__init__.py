"""Motion to Score, one module a stage.

`encode` does it all; `trace` shows how: every curve, candidate, move and run, and what became of
it.
"""

from __future__ import annotations

from fractions import Fraction
from typing import TYPE_CHECKING

from lanindex.errors import EncodeError

if TYPE_CHECKING:
    from pathlib import Path

    from lanindex.encoding.profile import Profile
    from lanindex.encoding.written import Trace
    from lanindex.model import Motion, Score


def _profile(profile: Profile | str | Path) -> Profile:
    from lanindex.encoding.profile import Profile, load

    return profile if isinstance(profile, Profile) else load(profile)


def encode(
    motion: Motion, profile: Profile | str | Path = "default", *, tempo: str | Path | None = None
) -> Score:
    """Write a motion down.

    Parameters
    ----------
    motion : Motion
        As read from a capture.
    profile : Profile, str or Path
        ``default``, ``paper``, a folder, or a profile already loaded.
    tempo : str or Path, optional
        ``auto``: count by the beat of the movement; or a file of beats; else by the profile's.

    Returns
    -------
    Score
        A track for every part whose ends the capture has, and those of the whole body.

    Raises
    ------
    NotationError
        Where the profile or the file of beats cannot be read.
    UsageError
        Where the beats come after the motion.
    EncodeError
        Where the motion has no part that could be written down.

    Notes
    -----
    The method is that of Matsumoto and Hachimura (2001), section 4, made exact:
    ``encoding/METHOD.md``. What the whole body does is told in ``encoding/BODY.md``.

    Examples
    --------
    >>> import lanindex
    >>> score = lanindex.encode(lanindex.read("corpus/jumping_jacks.bvh"))
    >>> score
    <Score 38 parts, 507 symbols, 360 frames at 30 Hz>
    >>> for symbol in score.symbols("r_arm")[:4]:  # the * says: only passed on the way
    ...     print(symbol)
    r_arm place low [0, 0)
    r_arm right low* [60, 67)
    r_arm right mid [60, 70)
    r_arm right high [70, 76)
    """
    import numpy as np

    from lanindex.encoding.joints import Body, known_parts, unmeasured
    from lanindex.encoding.limbs import heading, limbs
    from lanindex.encoding.timing import count
    from lanindex.encoding.whole import whole
    from lanindex.encoding.written import Written, together, written
    from lanindex.model import Score, Track
    from lanindex.model.derived import with_derived
    from lanindex.model.score import HEADING_RATE

    chosen = _profile(profile)
    if not len(motion):
        raise EncodeError("no frames", place=motion.source.path, wanted="one at least")
    body = Body(motion, chosen)
    turn = heading(motion, chosen.rate, body)
    names = known_parts(motion)
    # feet take the most memory beside their rows, which are the fewest: they come first
    of_all, doubts = whole(body, turn)
    of_limbs = list[Written]()
    for group in limbs(body, turn, names):
        of_limbs += written(group, chosen, body.fast)
        del group
    if not of_limbs:
        raise EncodeError(
            "no part of the body is known", place=motion.source.path, wanted="an arm or a leg"
        )
    parts = together((*of_limbs, *of_all))
    del of_limbs, of_all
    time = count(tempo, motion, chosen, {part: rows for part, (rows, _) in parts.items()})
    tracks = with_derived({part: Track(part, *found) for part, found in parts.items()})
    if chosen.rate != HEADING_RATE:
        turn = heading(motion, Fraction(HEADING_RATE), body)
    degrees = (np.round(np.degrees(turn), 1) + 0.0).astype(np.float32)  # -0 would be another
    lost = unmeasured(body, [part for part in names if part not in tracks])
    said = (f"{part} is left out: how long it is was never seen" for part in lost)
    doubts = (*doubts, *time.doubts, *said)
    return Score(motion.rate, len(motion), time.meter, tracks, degrees, time.header, doubts)


def trace(motion: Motion, part: str, profile: Profile | str | Path = "default") -> list[Trace]:
    """Show how one part is written down, stage by stage.

    Parameters
    ----------
    motion : Motion
        As read from a capture.
    part : str
        ``r_arm`` ...
    profile : Profile, str or Path
        As for `encode`.

    Returns
    -------
    list of Trace
        One for each stretch in which the part is known; each prints what became of every run.

    Raises
    ------
    NotationError
        Where the profile cannot be read.
    EncodeError
        Where the part is not known.

    Examples
    --------
    >>> import lanindex
    >>> (found,) = lanindex.trace(lanindex.read("corpus/jumping_jacks.bvh"), "r_arm")
    >>> for run in found.runs[0]:  # of the first move, in resampled frames
    ...     print(run.start, run.stop, run.cell, run.outcome)
    118 129 24 in force
    129 135 0 passing
    135 142 1 symbol
    142 151 2 symbol
    """
    from lanindex.encoding.joints import Body, known_parts
    from lanindex.encoding.limbs import heading, limbs
    from lanindex.encoding.written import write_limbs

    chosen = _profile(profile)
    body = Body(motion, chosen)
    turn = heading(motion, chosen.rate, body)
    parts = [name for name in known_parts(motion) if name == part]
    found = [one for group in limbs(body, turn, parts) for one in write_limbs(group, chosen)]
    if not found:
        raise EncodeError(f'no part "{part}" is known', place=motion.source.path)
    return found
