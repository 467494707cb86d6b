"""The clips that are most like one: whole or, where they are much longer, their best stretch."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from lanindex.search.example.align import compared
from lanindex.search.example.candidates import promises
from lanindex.search.example.moves import Clips
from lanindex.search.example.stretches import reach_of, stretches

LONGER = 4.0
"""From how many times the length of the example on a clip is looked through by stretches, too."""

MOST = 4096
"""Clips that are aligned at the most."""

_BLOCK = 256
"""Clips that are aligned at a time."""


class Near(NamedTuple):
    """A clip that is like the example, or a stretch of it.

    Attributes
    ----------
    clip : int
        Which.
    begin, end : int
        Frames of its source, half-open.
    likeness : float
        0 to 1.
    """

    clip: int
    begin: int
    end: int
    likeness: float


class Found(NamedTuple):
    """What is like an example.

    Attributes
    ----------
    near : list of Near
        The best first.
    aligned : int
        How many clips were aligned.
    sure : bool
        Whether no whole clip that was not aligned could be among them.
    """

    near: list[Near]
    aligned: int
    sure: bool


def nearest(
    query: Clips,
    seconds: float,
    clips: Clips,
    frames: Sequence[int],
    rates: Sequence[float],
    limit: int,
    *,
    most: int = MOST,
    watch: Callable[[int, int], None] = lambda done, total: None,
) -> Found:
    """Return the clips that are most like one.

    Parameters
    ----------
    query : Clips
        The one, with the same parts as `clips`.
    seconds : float
        How long it lasts.
    clips : Clips
        To choose from.
    frames, rates : sequence
        Of each clip: its length in frames, and frames a second.
    limit : int
        How many are wanted.
    most : int
        How many are aligned at the most.
    watch : callable, optional
        Is told how many of these are, and how many may be; it may raise.
    """
    promise = promises(query, clips)
    reach = reach_of(query, clips, promise)
    lasting = np.array(frames, np.int64)
    lengths = seconds * np.array(rates, np.float64)
    longer = lasting >= LONGER * lengths
    hope = np.where(longer, np.maximum(promise.whole, promise.stretch), promise.whole)
    order = np.argsort(-hope, kind="stable")
    near: list[Near] = []
    done, worst = 0, 0.0
    while done < min(most, len(order)) and hope[order[done]] > worst:
        watch(done, min(most, len(order)))
        block = order[done : done + _BLOCK]
        whole = compared(query, clips, clips.whole().some(block))
        whole_ones = zip(block.tolist(), lasting[block].tolist(), whole.tolist(), strict=True)
        near += [Near(clip, 0, last, alike) for clip, last, alike in whole_ones]
        near = _best(near, limit)
        worst = near[-1].likeness if len(near) == limit else 0.0
        some = block[longer[block] & (promise.stretch[block] > worst)].tolist()
        found = stretches(query, clips, reach, some, lasting, lengths, worst)
        near = _best([*near, *(Near(*one) for one in found)], limit)
        worst = near[-1].likeness if len(near) == limit else 0.0
        done += len(block)
    return Found(near, done, done >= len(order) or bool(hope[order[done]] <= worst))


def _best(near: list[Near], limit: int) -> list[Near]:
    """Return the best, each clip once."""
    kept: dict[int, Near] = {}
    for one in sorted(near, key=_rank):
        kept.setdefault(one.clip, one)
    return [one for one in kept.values() if one.likeness > 0][:limit]


def _rank(near: Near) -> tuple[float, int, int]:
    return -near.likeness, near.begin - near.end, near.clip
