"""Conditions of `where`, evaluated one by one on the matches of the plain matcher."""

from fractions import Fraction

from plain_events import AMOUNTS

from lanindex.alphabet import DIRECTIONS, KINDS, LEVELS, MIRRORED, kind_of, mirrored_part
from lanindex.search.language.clauses import Constant, Mirrors, Reference
from lanindex.search.language.times import Clock


def symbols_of(tracks, thing):
    """Yield the symbols of a thing as dictionaries; a stay or rest lends them its frames."""
    for part, rows in thing.members:
        for row in rows:
            symbol = tracks[part].symbols[row]
            own = thing.manner == "move"
            yield {
                "part": part,
                "direction": direction_of(int(symbol["direction"])),
                "level": LEVELS[symbol["level"]] if symbol["level"] >= 0 else None,
                "swings": Fraction(int(symbol["swings"])),
                **amounts(part, int(symbol["amount"])),
                **{name: measure(symbol, name) for name in ("speed", "size", "straightness")},
                "else": direction_of(int(symbol["runner_direction"])),
                "margin": Fraction(round(1000 * float(symbol["margin"])), 1000),
                "start": int(symbol["start"]) if own else thing.start,
                "end": int(symbol["stop"]) if own else thing.end,
            }


def direction_of(code):
    return DIRECTIONS[code] if code >= 0 else None


def measure(symbol, name):
    hundredths = round(100 * float(symbol[name]))
    return None if hundredths < 0 else Fraction(hundredths, 100)


def names_of(condition):
    if isinstance(condition, Mirrors):
        return {condition.first, condition.second}
    terms = [term for side in (condition.left, condition.right) for _, term in side.terms]
    return {term.name for term in terms if isinstance(term, Reference)} - {"clip"}


def is_true(condition, capture, told):
    """Return whether a condition holds; `told` has the symbols by name, in order."""
    if isinstance(condition, Mirrors):
        one, two = told.get(condition.first, []), told.get(condition.second, [])
        return bool(one) and [mirror(it) for it in one] == [
            (it["part"], it["direction"], it["level"], it["about"]) for it in two
        ]
    left, right = (total(side, capture, told) for side in (condition.left, condition.right))
    if left is None or right is None:
        return False
    if left in LEVELS and right in LEVELS:
        left, right = LEVELS.index(left), LEVELS.index(right)
    return {
        "<": lambda: left < right,
        "<=": lambda: left <= right,
        ">": lambda: left > right,
        ">=": lambda: left >= right,
        "=": lambda: left == right,
        "!=": lambda: left != right,
    }[condition.compare]()


def mirror(symbol):
    direction = symbol["direction"]
    if direction is not None:
        direction = DIRECTIONS[MIRRORED[DIRECTIONS.index(direction)]]
    return mirrored_part(symbol["part"]), direction, symbol["level"], symbol["about"]


def amounts(part, amount):
    """Return what a symbol says by its amount, and what its mirror image must have, too."""
    kinds = KINDS[kind_of(part)].words
    degrees = amount if "degrees" in kinds and amount >= 0 else None
    own = amount if part.endswith("_bend") else None
    bent = amount if part[2:] in ("arm", "leg", "arm_bend", "leg_bend") and amount >= 0 else None
    said = {
        kind: names[amount]
        for kind, names in AMOUNTS.items()
        if names and amount >= 0 and kind in kinds
    }
    return {
        **dict.fromkeys(AMOUNTS),
        **said,
        "bend": None if bent is None else Fraction(bent if bent < 7 else bent - 7),
        "degrees": None if degrees is None else Fraction(degrees),
        "about": (said, None if degrees is None else round(degrees / 45), own),
    }


def total(side, capture, told):
    values = [value(term, capture, told) for _, term in side.terms]
    if len(values) == 1 or None in values:
        return None if None in values else values[0]
    return sum(sign * it for (sign, _), it in zip(side.terms, values, strict=True))


def value(term, capture, told):
    if isinstance(term, Constant):
        return term.value
    if not isinstance(term, Reference):
        clock = Clock(capture.rate, capture.meter.speed / 60)
        return term.frames(clock) / capture.rate
    if term.name == "clip":
        return {"label": capture.label, "path": capture.path}[term.field] or None
    symbols = told.get(term.name)
    if not symbols:
        return None
    start, end = min(it["start"] for it in symbols), max(it["end"] for it in symbols)
    times = {"start": start, "end": end, "length": end - start}
    if term.field in times:
        return Fraction(times[term.field]) / capture.rate
    return symbols[-1][term.field]
