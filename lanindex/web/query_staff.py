"""What the staff of a query is drawn with: who may move, how lines lie, and the signs."""

from __future__ import annotations

from functools import lru_cache
from itertools import product
from typing import Any

from lanindex.alphabet import DIRECTIONS, LEVELS, TRACKS
from lanindex.draw import svg
from lanindex.draw.picture import C, Picture, sign
from lanindex.draw.staff import staff_columns
from lanindex.search.language.words import RELATIONS, RELATIVE, Vocabulary
from lanindex.web.routes import Call

_EDGE = C // 12  # round a sign
_HEIGHTS = {"short": C * 2 // 3, "usual": C, "long": C * 2}  # of a sign, by how long it lasts


def about(call: Call) -> dict[str, Any]:
    """Return the names of parts, the relations of lines, and the signs of directions and levels."""
    vocabulary = Vocabulary(call.site.parts())
    movers = [it for name, it in vocabulary.movers.items() if name == it.name]
    places = staff_columns(TRACKS).places  # from left to right, 0 in the middle
    return {
        "movers": [
            {
                "name": it.name,
                "parts": it.members,
                "form": it.form,
                "place": places.get(it.members[0], 0),
            }
            for it in sorted(movers, key=lambda it: _rank(vocabulary, it.members[0]))
            if not vocabulary.held.isdisjoint(it.members)
        ],
        "relations": list(RELATIONS.values()),
        "relative": list(RELATIVE),
        "signs": _signs(),
    }


def _rank(vocabulary: Vocabulary, part: str) -> int:
    return vocabulary.parts.index(part) if part in vocabulary.held else len(vocabulary.parts)


@lru_cache(maxsize=1)
def _signs() -> dict[str, str]:
    """Return the signs by height, direction and level, `?` where none is said."""
    return {
        f"{size} {way} {level}": _picture(way, level, height)
        for (size, height), way, level in product(
            _HEIGHTS.items(), (*DIRECTIONS, "?"), (*LEVELS, "?")
        )
    }


def _picture(way: str, level: str, height: int) -> str:
    marks = sign(
        _EDGE,
        height + _EDGE,
        None if way == "?" else way,
        None if level == "?" else level,
        height,
    )
    return svg.write(Picture(C + 2 * _EDGE, height + 2 * _EDGE, "", "", tuple(marks)))
