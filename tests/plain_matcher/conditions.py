"""Whether a condition of ``where`` is true of a hit with its labels."""

from fractions import Fraction

from lanindex.alphabet import DIRECTION_CODES, DIRECTIONS, LEVELS, MIRRORED, mirrored_part
from lanindex.model import Hit, Symbol
from lanindex.search.hits import COMPARE, Value, about, number_of, value_of
from lanindex.search.language.clauses import Condition, Mirrors, Reference, Sum, Term
from lanindex.search.language.times import Clock, Time


def holds(condition: Condition, hit: Hit) -> bool:
    """Return whether a condition is true of a hit with its labels."""
    if isinstance(condition, Mirrors):
        one, other = (hit.labels.get(name, ()) for name in (condition.first, condition.second))
        return 0 < len(one) == len(other) and all(map(_mirrors, one, other))
    left, right = _sum(condition.left, hit), _sum(condition.right, hit)
    if left is None or right is None:
        return False
    if isinstance(left, Fraction) != isinstance(right, Fraction):
        left, right = number_of(left), number_of(right)
        if left is None or right is None:  # a word is no number
            return condition.compare == "!="
    if left in LEVELS and right in LEVELS:  # by height, not by letter
        left, right = (Fraction(LEVELS.index(str(side))) for side in (left, right))
    return COMPARE[condition.compare](left, right)


def _sum(said: Sum, hit: Hit) -> Value:
    values = [_term(term, hit) for _, term in said.terms]
    if len(values) == 1:
        return values[0]
    total = Fraction(0)
    for (sign, _), value in zip(said.terms, map(number_of, values), strict=True):
        if value is None:
            return None
        total += sign * value
    return total


def _term(term: Term, hit: Hit) -> Value:
    match term:
        case Reference():
            return value_of(term, hit)
        case Time():
            rate = hit.capture.rate
            return term.frames(Clock(rate, hit.capture.meter.speed / 60)) / rate
    return term.value


def _mirrors(one: Symbol, other: Symbol) -> bool:
    """Return whether a symbol is the mirror image of another."""
    direction = one.direction and DIRECTIONS[MIRRORED[DIRECTION_CODES[one.direction]]]
    amounts = [about(it.part, -1 if it.amount is None else it.amount) for it in (one, other)]
    image = mirrored_part(one.part), direction, one.level, amounts[0]
    return image == (other.part, other.direction, other.level, amounts[1])
