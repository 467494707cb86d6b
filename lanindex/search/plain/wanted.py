"""Which symbols more than one line of a pattern may want.

"One movement, stay or rest cannot serve two lines", and what must not happen is forgiven where the
hit uses it, or came there by it: so a walk must remember what it has used; but only of that which
another line might want, or no two ways would remember the same.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from functools import cached_property

from lanindex.search.automaton import Program
from lanindex.search.plain.candidates import Recording
from lanindex.search.plain.track import Symbol, symbols_of

Sides = tuple[Program, ...]
"""A line that stands beside another, as programs: one a side."""


class Wanted:
    """What the lines of one query may want in one capture.

    Parameters
    ----------
    recording : Recording
        The capture.
    programs : sequence of Program
        Of the leading lines.
    """

    def __init__(self, recording: Recording, programs: Sequence[Program]) -> None:
        self._recording, self._programs = recording, programs

    @cached_property
    def twice(self) -> frozenset[Symbol]:
        """What more than one line may want."""
        return frozenset(it for tally in self._tallies for it, lines in tally.items() if lines > 1)

    def outside(self, line: Sides) -> frozenset[Symbol]:
        """Return what others may want than a line that stands beside another."""
        own = self._tally(line)
        return frozenset(
            it for tally in self._tallies for it, lines in tally.items() if lines > own[it]
        )

    @cached_property
    def _tallies(self) -> list[Counter[Symbol]]:
        """By leading line that has others beside it: for how many lines a symbol may serve."""
        return [
            self._tally((program,))
            for program in self._programs
            if any(group.companions for group in (program.whole, *program.brackets))
        ]

    def _tally(self, line: Sides) -> Counter[Symbol]:
        """Count for how many lines a symbol may serve, this one and those beside it.

        A line is of one side at a time; one in a bracket may come again.
        """
        most: Counter[Symbol] = Counter()
        for program in line:
            tally = Counter(self._own(program))
            for group in (program.whole, *program.brackets):
                times = 1 if group is program.whole else 2
                for companion in group.companions:
                    for symbol, lines in self._tally(companion.programs).items():
                        tally[symbol] += times * lines
            most |= tally
        return most

    def _own(self, program: Program) -> set[Symbol]:
        return {
            symbol
            for state in program.states
            for events in self._recording.events(state)
            for event in events
            for symbol in symbols_of(event.claims)
        }
