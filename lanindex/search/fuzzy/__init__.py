"""Search that forgives: what is nearly what a pattern says, found and ranked by how nearly.

Symbols may differ from a step by an angle, others may lie between two steps, and steps may be
missing; each costs a part of an edit or more, and a match may cost so many. ``costs`` says what a
symbol costs for a step, ``align`` what whole lines cost, for all captures at once, ``trace`` which
symbols those were, ``find`` sets the lines side by side.
"""

from lanindex.search.fuzzy.allowance import Allowance
from lanindex.search.fuzzy.find import find

__all__ = ["Allowance", "find"]
