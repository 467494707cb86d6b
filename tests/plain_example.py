"""Search by example as plain loops, one clip at a time."""

import math
from functools import cache

from lanindex.alphabet import DIRECTIONS

Point = tuple[float, float, float]


def middle(direction: int, level: int) -> Point:
    """Return the middle of a cell: x right, y up, z forward."""
    if direction < 0 or level < 0:
        return 0.0, 0.0, 0.0
    if DIRECTIONS[direction] == "place":
        return 0.0, float(level) - 1, 0.0
    azimuth, elevation = math.radians(45 * int(direction)), math.radians(45 * (int(level) + 1))
    flat = math.sin(elevation)
    return flat * math.cos(azimuth), -math.cos(elevation), flat * math.sin(azimuth)


def point(row) -> Point:
    cell = middle(row["direction"], row["level"])
    if min(row[name] for name in ("direction", "level", "runner_direction", "runner_level")) < 0:
        return cell
    other = middle(row["runner_direction"], row["runner_level"])
    share = 0.5 * (1 - row["margin"])
    return tuple(a + share * (b - a) for a, b in zip(cell, other, strict=True))


class Move:
    """A movement: from where, to where, how long, with how many swings."""

    def __init__(self, before, row, rate: float) -> None:
        self.to = point(row)
        self.begins = before is None or row["start"] == row["stop"]
        self.source = self.to if before is None else point(before)
        self.pace = math.log(max((row["stop"] - row["start"]) / rate, 1 / 60))
        self.swings = 0.2 * row["swings"]
        way = 0 if self.begins else 0.25 + math.dist(self.source, self.to)
        self.size = way + self.swings


def moves(rows, rate: float) -> list[Move]:
    shown = [row for row in rows if not row["passing"]]
    return [Move(*pair, rate) for pair in zip([None, *shown], shown, strict=False)]


def difference(one: list[Move], two: list[Move]) -> float:
    """Return what it costs to turn one part's movements into another's."""
    if not one or not two:
        return sum(move.size for move in [*one, *two])

    @cache
    def cost(i: int, j: int) -> float:
        if i == j == 0:
            return 0.5 * math.dist(one[0].to, two[0].to) + abs(one[0].swings - two[0].swings)
        ways = []
        if i:
            ways.append(cost(i - 1, j) + one[i].size)
        if j:
            ways.append(cost(i, j - 1) + two[j].size)
        if i and j:
            a, b = one[i], two[j]
            apart = math.dist(a.source, b.source) + math.dist(a.to, b.to)
            change = 0.8 * apart + 0.05 * abs(a.pace - b.pace) + abs(a.swings - b.swings)
            ways.append(cost(i - 1, j - 1) + change)
        return min(ways)

    return cost(len(one) - 1, len(two) - 1)


def likeness(one, two, parts, rates=(30.0, 30.0)) -> float:
    """Return how alike two clips are, given as rows by part."""
    total = sizes = 0.0
    for part in parts:
        a, b = (
            moves(clip.get(part, []), rate) for clip, rate in zip((one, two), rates, strict=True)
        )
        total += difference(a, b)
        sizes += sum(move.size for move in [*a, *b])
    return min(1.0, max(0.0, 1 - total / (sizes + 1)))


def warped(one, two) -> float:
    """Return the cost of warping frames upon frames, joints in every frame known."""

    def apart(i: int, j: int) -> float:
        pairs = zip(one[i], two[j], strict=True)
        return sum(math.dist(a, b) for a, b in pairs) / len(one[i])

    table: dict[tuple[int, int], float] = {}
    for i in range(len(one)):
        for j in range(len(two)):
            here = apart(i, j)
            ways = [2 * here] if i == j == 0 else []
            if i:
                ways.append(table[i - 1, j] + here)
            if j:
                ways.append(table[i, j - 1] + here)
            if i and j:
                ways.append(table[i - 1, j - 1] + 2 * here)
            table[i, j] = min(ways)
    return table[len(one) - 1, len(two) - 1] / (len(one) + len(two))
