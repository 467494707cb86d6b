"""Search that forgives: the operators of the matcher with costs, best matches first.

A symbol may differ from its step by an angle, others may lie between two steps, and steps may be
missing (`follow`); lines beside each other add what they cost (`find`).
"""

from lanindex.search.fuzzy.find import find
from lanindex.search.fuzzy.follow import Allowance

__all__ = ["Allowance", "find"]
