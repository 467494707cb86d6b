"""What a query says in English, and why it finds nothing."""

from lanindex.search.explain.english import sentence
from lanindex.search.explain.reasons import explanation, obstacle, order, step_counts

__all__ = ["explanation", "obstacle", "order", "sentence", "step_counts"]
