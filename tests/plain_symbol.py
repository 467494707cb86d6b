"""Stages 3 to 5 as plain loops: cells, runs, what is achieved, and the rules."""

import math
from dataclasses import dataclass

from plain_body import Vector, distance
from plain_profile import Cells, Rule, amount

Cell = tuple[str, str]

WHOLE_AZIMUTH = 22.5
WHOLE_LEVEL = 22.5
ORIGIN = (0.0, 0.0, 0.0)
REFERENCE_ELEVATION = {"low": 45.0, "mid": 90.0, "high": 135.0}
REFERENCE_HEIGHT = {"low": -1.0, "mid": 0.0, "high": 1.0}


@dataclass
class Row:
    """One symbol of a track, in frames of the grid; `ends` is its last frame."""

    direction: str
    level: str
    begins: int
    ends: int
    achieved: int
    passing: bool = False
    rule: int = 0
    swings: int = 0
    margin: float = 0.0
    runner: Cell | None = None
    start: int = 0
    stop: int = 0

    @property
    def cell(self) -> Cell:
        return (self.direction, self.level)


@dataclass
class Run:
    """Frames of one cell in a row; `nearest` is at `angle` from the cell's reference."""

    cell: Cell
    first: int
    last: int
    nearest: int
    angle: float
    nearness: float
    dropped: bool = False


def azimuth(vector: Vector) -> float:
    return math.degrees(math.atan2(vector[0], vector[2])) % 360.0


def elevation(vector: Vector) -> float:
    """Return degrees from straight down; a vector without length is level."""
    x, y, z = vector
    return math.degrees(math.atan2(y, math.sqrt(x * x + z * z))) + 90.0


def horizontal(vector: Vector) -> float:
    return math.sqrt(vector[0] * vector[0] + vector[2] * vector[2])


class Space:
    """The cells around a parent joint, for a limb of one length."""

    def __init__(self, cells: Cells, length: float) -> None:
        self.length = length
        self.radius = amount(cells.place, length)
        self.sectors = sorted((start, name) for name, start in cells.sectors.items())
        self.levels = cells.levels

    @staticmethod
    def _within(borders: list[tuple[float, str]], angle: float) -> str:
        inside = borders[-1][1]
        for start, name in borders:
            if start <= angle:
                inside = name
        return inside

    def cell(self, vector: Vector) -> Cell:
        level = self._within(self.levels, elevation(vector))
        if horizontal(vector) <= self.radius:
            return ("place", level)
        return (self._within(self.sectors, azimuth(vector)), level)

    def middle(self, direction: str) -> float:
        """Return the azimuth in the middle of a sector."""
        names = [name for _, name in self.sectors]
        index = names.index(direction)
        start = self.sectors[index][0]
        following = self.sectors[(index + 1) % len(names)][0]
        return start + (following - start) % 360.0 / 2.0

    def reference(self, cell: Cell) -> Vector:
        """Return the point that a straight limb reaches in the middle of a cell, mm."""
        direction, level = cell
        if direction == "place":
            return (0.0, REFERENCE_HEIGHT[level] * self.length, 0.0)
        around = math.radians(self.middle(direction))
        up = math.radians(REFERENCE_ELEVATION[level])
        out = self.length * math.sin(up)
        return (out * math.sin(around), -self.length * math.cos(up), out * math.cos(around))

    def angle(self, vector: Vector, cell: Cell) -> float:
        """Return the angle to a cell's reference direction, degrees; place mid has none."""
        if cell == ("place", "mid"):
            return 0.0
        one, other = vector, self.reference(cell)
        size = distance(one, ORIGIN) * distance(other, ORIGIN)
        if size == 0.0:
            return 90.0
        dot = sum(a * b for a, b in zip(one, other, strict=True)) / size
        return math.degrees(math.acos(max(-1.0, min(1.0, dot))))

    def nearness(self, vector: Vector, cell: Cell) -> float:
        """Return what is least where a cell is achieved: an angle, or a distance for place."""
        if cell[0] != "place":
            return self.angle(vector, cell)
        return distance(vector, self.reference(cell))

    def _choices(self, vector: Vector) -> list[tuple[float, Cell]]:
        """Return how far every border is, as a margin, with the cell behind it."""
        direction, level = self.cell(vector)
        around, up, out = azimuth(vector), elevation(vector), horizontal(vector)
        choices: list[tuple[float, Cell]] = []
        if direction != "place":
            for index, (border, name) in enumerate(self.sectors):
                before = self.sectors[index - 1][1]
                if direction in (name, before):
                    away = abs((around - border + 180.0) % 360.0 - 180.0)
                    other = before if direction == name else name
                    choices.append((away / WHOLE_AZIMUTH, (other, level)))
        for index, (border, name) in enumerate(self.levels):
            before = self.levels[index - 1][1]
            if level in (name, before):
                away = abs((up - border + 180.0) % 360.0 - 180.0)
                other = before if level == name else name
                choices.append((away / WHOLE_LEVEL, (direction, other)))
        across = "place" if direction != "place" else self._within(self.sectors, around)
        away = abs(out - self.radius) / self.radius if self.radius > 0 else 1.0
        choices.append((away, (across, level)))
        return choices

    def margin(self, vector: Vector) -> tuple[float, Cell]:
        """Return the least margin, 0 to 1, and the cell across that border."""
        least, runner = min(self._choices(vector), key=lambda choice: choice[0])
        return min(1.0, least), runner


def runs(curve: list[Vector], start: int, stop: int, space: Space) -> list[Run]:
    """Return the runs of equal cells from `start` to `stop`, both included."""
    found: list[Run] = []
    for frame in range(start, stop + 1):
        cell = space.cell(curve[frame])
        angle = space.angle(curve[frame], cell)
        nearness = space.nearness(curve[frame], cell)
        if not found or found[-1].cell != cell:
            found.append(Run(cell, frame, frame, frame, angle, nearness))
            continue
        run = found[-1]
        run.last = frame
        if nearness < run.nearness:
            run.nearest, run.nearness, run.angle = frame, nearness, angle
    return found


def achieved(found: list[Run], within: float) -> list[Run]:
    """Return the runs that come near their reference, equal neighbours as one, and the last."""
    kept: list[Run] = []
    for index, run in enumerate(found):
        is_last = index == len(found) - 1
        run.dropped = not is_last and run.angle > within
        if run.dropped:
            continue
        if kept and kept[-1].cell == run.cell:
            same = kept[-1]
            nearest = min(same, run, key=lambda choice: choice.nearness)
            kept[-1] = Run(**vars(nearest))
        else:
            kept.append(Run(**vars(run)))
    kept[-1].nearest = found[-1].last
    return kept


def apply_rules(context: Cell, rows: list[Row], rules: list[Rule]) -> None:
    """Mark rows as passing until no rule matches any more."""
    while _apply_one(context, rows, rules):
        pass


def _apply_one(context: Cell, rows: list[Row], rules: list[Rule]) -> bool:
    living = [row for row in rows if not row.passing]
    cells = [context, *(row.cell for row in living)]
    for position in range(len(cells)):
        for rule in rules:
            wanted = [(direction, level) for _, direction, level in rule.rows]
            if cells[position : position + len(wanted)] != wanted:
                continue
            deleted = [
                position + offset - 1
                for offset, (action, _, _) in enumerate(rule.rows)
                if action == "D"
            ]
            if all(0 <= index < len(living) - 1 for index in deleted):
                for index in deleted:
                    living[index].passing = True
                    living[index].rule = rule.line
                return True
    return False


def joined(rows: list[Row]) -> list[Row]:
    """Return a segment's rows: equal neighbours as one, all begin with what passes before them."""
    result: list[Row] = []
    last: Row | None = None
    waiting: list[Row] = []
    for row in rows:
        if row.passing:
            waiting.append(row)
            continue
        if waiting:
            row.begins = waiting[0].begins
        if last is not None and last.cell == row.cell:
            row.begins = last.begins
            result.remove(last)
        result += [*waiting, row]
        last, waiting = row, []
    return result


def rows_of(kept: list[Run], begins: int, ends: int) -> list[Row]:
    """Return a segment's symbols before any rule, from `begins` to `ends`, both included.

    A run achieved before `begins` or after `ends` (they are other frames than the segment's own,
    stage 2b) is left without a frame.
    """
    rows: list[Row] = []
    for run in kept:
        last = max(begins - 1, min(run.nearest, ends))
        if run is kept[-1]:
            last = max(begins - 1, ends)
        rows.append(Row(*run.cell, begins, last, run.nearest))
        begins = last + 1
    return rows
