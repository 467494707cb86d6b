"""For people: what a query says in English, how the search runs, and why it finds nothing."""

from lanindex.search.explain.advice import Advice, advise
from lanindex.search.explain.english import explanation, planned, sentence
from lanindex.search.explain.why import Trace, trace

__all__ = ["Advice", "Trace", "advise", "explanation", "planned", "sentence", "trace"]
