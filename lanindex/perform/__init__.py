"""Score to Motion: a standard body carries out a score."""

from __future__ import annotations

from fractions import Fraction
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from lanindex.model import Motion, Score


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
    from lanindex.perform.stage import carry_out

    return carry_out(score, Fraction(rate), noise, seed)
