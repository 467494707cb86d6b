"""The state of one search in one batch: claims, conditions, counts, and cached values of lines."""

from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np

from lanindex.search import limits
from lanindex.search.language.clauses import Condition
from lanindex.search.match.arrays import FAR, BoolArray, IntArray
from lanindex.search.match.backward import Backwards, ending_values
from lanindex.search.match.batch import Batch
from lanindex.search.match.conditions import Captures, Clauses, Evaluator, Facts
from lanindex.search.match.follow import NONE, roots
from lanindex.search.match.matches import Claims, in_sets, no_claims, single_claims
from lanindex.search.match.rewrites import MANNERS, Rewrites, manner_of
from lanindex.search.plan import NEGATIONS, Group, Program, State, followers, open_groups, reached


class Joins:
    """Which ends of other lines joined each match: noted only where symbols are traced."""

    def ended(self, line: Any, many: int) -> IntArray:
        """Return numbers for the ends of a line, (many,) int64."""
        return np.full(many, -1)

    def add(self, link: IntArray, end: IntArray) -> IntArray:
        """Return the links of matches that some ends join, (N,) int64 each."""
        return link


@dataclass(frozen=True, slots=True)
class SettledConditions:
    """Conditions that no later step can change, and the note columns that no other one needs."""

    conditions: tuple[Condition, ...] = ()
    columns: tuple[int, ...] = ()
    of_step: tuple[Condition, ...] = ()  # those that the symbols of this step alone decide


def _settled(clauses: Clauses, program: Program) -> list[SettledConditions]:
    """Return by state which conditions on labels of a line are settled there."""
    labelled = Counter(label for state in program.states for label in state.labels)
    following, found = followers(program), []
    for state in program.states:
        ahead = {
            it for place in reached(following, state.number) for it in program.states[place].labels
        }
        conditions, of_step, needed = list[Condition](), list[Condition](), set[str]()
        for condition in clauses.conditions:
            labels = clauses.labels[condition]
            if condition in clauses.of_all or not labels <= labelled.keys() or labels & ahead:
                needed |= labels
            elif all(it in state.labels and labelled[it] == 1 for it in labels):
                of_step.append(condition)
            else:
                conditions.append(condition)
        columns = [at for (label, _), at in clauses.columns.items() if label not in needed]
        found.append(SettledConditions(tuple(conditions), tuple(columns), tuple(of_step)))
    return found


def _labels_beside(group: Group) -> set[str]:
    """Return the labels in the lines beside a group."""
    found = set[str]()
    for companion in group.companions:
        for program in companion.programs:
            found.update(label for state in program.states for label in state.labels)
            found.update(*map(_labels_beside, (program.outermost, *program.brackets)))
    return found


class Context:
    """What the lines of one program share in one batch.

    `refused`, (captures,) bool, marks the captures in which more than `MOST_TRIED` partial matches
    were tried.
    """

    def __init__(
        self, batch: Batch, rewrites: Rewrites, clauses: Clauses, captures: Captures
    ) -> None:
        self.batch, self.rewrites, self.clauses = batch, rewrites, clauses
        self.program = rewrites.program
        self.evaluator = Evaluator(clauses, batch, captures)
        self.joins = Joins()
        self.refused = np.zeros(len(batch), bool)
        self._tried = np.zeros(len(batch), np.int64)
        self._backwards: dict[Program, Backwards] = {}
        self._alive: dict[Program, list[BoolArray]] = {}
        self._wanted: dict[tuple[Program, str], IntArray] = {}
        self._ends_of: dict[tuple[str, str], IntArray] = {}
        self._lanes: dict[str, int] = {}
        self._widths: list[int] = []
        self._begins = [0]
        self._settled: dict[Program, list[SettledConditions]] = {}
        self._hosts: dict[Program, BoolArray] = {}

    def count_tried(self, capture: IntArray) -> BoolArray | None:
        """Count matches by their captures; return which are not refused, None: all of them."""
        self._tried += np.bincount(capture, minlength=len(self.batch))
        self.refused |= self._tried > limits.MOST_TRIED
        return ~self.refused[capture] if self.refused.any() else None

    def settled(self, program: Program) -> list[SettledConditions]:
        """Return by state the conditions on labels of a line that are settled there."""
        if program not in self._settled:
            self._settled[program] = _settled(self.clauses, program)
        return self._settled[program]

    def backwards(self, program: Program) -> Backwards:
        """Return the values of a line."""
        if program not in self._backwards:
            fits = self._fitting(program)
            end_values = ending_values(self.batch, program)
            if program is self.program and self.clauses.of_last:
                end_values = [
                    np.where(self._meets_as_last(state), values, NONE)
                    for state, values in zip(program.states, end_values, strict=True)
                ]
            self._backwards[program] = Backwards(self.batch, program, end_values, fits)
        return self._backwards[program]

    def _fitting(self, program: Program) -> list[BoolArray]:
        """Tell by state which of its events meet the conditions on that step alone."""
        found, lacking = [], self._lacking(program)
        for state, settled in zip(program.states, self.settled(program), strict=True):
            many = len(self.batch.events(state))
            fits = np.broadcast_to(state.number not in lacking, many)
            if settled.of_step:
                notes = np.full((self.clauses.width, many), -1)
                notes = self.clauses.noted(self.batch, state, np.arange(many), notes)
                fits = np.zeros(many, bool)
                fits[self.met(settled.of_step, self.batch.events(state).capture, notes)] = True
            found.append(fits)
        return found

    def _lacking(self, program: Program) -> set[int]:
        """Return the states of the leading line on whose ways a label of a condition is missing."""
        if program is not self.program:
            return set()
        beside = {group: _labels_beside(group) for group in (program.outermost, *program.brackets)}
        own = [
            {*state.labels}.union(*(beside[it] for it in groups))
            for state, groups in zip(program.states, open_groups(program), strict=True)
        ]
        following = followers(program)
        ahead = [{it, *reached(following, it)} for it in range(len(own))]
        needed = set[str]().union(*self.clauses.labels.values()) - beside[program.outermost]
        found = set()
        for state in range(len(own)):
            on_way = ahead[state] | {it for it in range(len(own)) if state in ahead[it]}
            if not needed <= set[str]().union(*(own[it] for it in on_way)):
                found.add(state)
        return found

    def _meets_as_last(self, state: State) -> BoolArray:
        """Tell which events of a state meet the conditions on the last symbol, (N,) bool."""
        events, fits = self.batch.events(state), np.ones(len(self.batch.events(state)), bool)
        part = np.full(len(events), self.clauses.codes[state.members[-1]])
        notes = np.empty((0, len(events)), np.int64)
        row = events.last[-1]
        facts = Facts(events.capture, notes, events.start, events.end, part, row)
        for condition in self.clauses.of_last:
            fits &= self.evaluator.holds(condition, facts)
        return fits

    def alive(self, program: Program) -> list[BoolArray]:
        """Tell by state at which of its events a line may stand, whatever it remembers.

        An end can be reached from there, and the line may begin there if no state leads there.
        """
        if program not in self._alive:
            entered = {edge.entry.state for edges in program.edges for edge in edges}
            values = self.backwards(program).values
            self._alive[program] = found = []
            for state, exits, value in zip(program.states, program.exits, values, strict=True):
                fits = (value < NONE) | (self.batch.events(state).starting & bool(exits))
                fits &= self.backwards(program).fits[state.number]
                if state.number not in entered:
                    entries = [it for it in program.entries if it.state == state.number]
                    fits &= np.any([roots(self.batch, program, it) for it in entries], axis=0)
                found.append(fits)
        return self._alive[program]

    def roots(self, program: Program) -> list[BoolArray]:
        """Return, by entry, at which events of its state a line may begin.

        A line beside a group begins only in captures in which the group may open.
        """
        alive, found = self.alive(program), []
        for entry in program.entries:
            fits = roots(self.batch, program, entry) & alive[entry.state]
            if program is not self.program:
                capture = self.batch.events(program.states[entry.state]).capture
                fits &= self._hosting(program)[capture]
            found.append(fits)
        return found

    def _hosting(self, program: Program) -> BoolArray:
        """Tell in which captures a group may open that a line stands beside, (captures,) bool."""
        if program not in self._hosts:
            found = self._hosts[program] = np.zeros(len(self.batch), bool)
            for host, group in self.rewrites.hosts[program]:
                alive = self.alive(host)
                ways = [*zip(host.entries, self.roots(host), strict=True)]
                ways += [(it.entry, alive[it.entry.state]) for edges in host.edges for it in edges]
                for entry, fits in ways:
                    if group in entry.opens:
                        found[self.batch.events(host.states[entry.state]).capture[fits]] = True
        return self._hosts[program]

    def possible(self) -> BoolArray:
        """Tell in which captures all lines that a hit needs can begin, (captures,) bool."""
        found = self._begins_in(self.program)
        for companion, programs in self.rewrites.standing.items():
            if companion.relation not in NEGATIONS and found.any():
                found &= np.any([self._begins_in(it) for it in programs], axis=0)
        return found

    def _begins_in(self, program: Program) -> BoolArray:
        """Tell in which captures a line can begin, (captures,) bool."""
        found = np.zeros(len(self.batch), bool)
        for entry, fits in zip(program.entries, self.roots(program), strict=True):
            found[self.batch.events(program.states[entry.state]).capture[fits]] = True
        return found

    def _contested_before(self, program: Program, part: str) -> IntArray:
        """Return how many rows of a part before each one another line could want, (rows + 1,)."""
        if (program, part) not in self._wanted:
            opened = np.zeros(len(self.batch.rows(part)) + 1, np.int64)
            for other in self.rewrites.rivals[program]:
                alive = self.alive(other)
                for number in self.rewrites.contested[other]:
                    state = other.states[number]
                    events = self.batch.events(state)
                    for member, own in enumerate(state.members):
                        if own == part:
                            fits = alive[number]
                            np.add.at(opened, events.first[member][fits], 1)
                            np.add.at(opened, events.last[member][fits] + 1, -1)
            before = np.cumsum(np.cumsum(opened)[:-1] > 0)
            self._wanted[program, part] = np.append(0, before)
        return self._wanted[program, part]

    # A claim is a number: of a part, of what its symbol is taken as, and of the symbol.

    def claims(self, program: Program, state: State, events: IntArray) -> Claims:
        """Return what events claim at a state of a line, as far as another one could want it."""
        own = self.batch.events(state).at(events)
        found = no_claims(len(events))
        for part, first, last in zip(state.members, own.first, own.last, strict=True):
            before = self._contested_before(program, part)
            wanted = before[last + 1] > before[first]
            if not wanted.any():
                continue
            rows = self.batch.rows(part)
            lane = self.lane(manner_of(state), part)
            passing = rows.passing[first]
            begin = lane + np.where(passing, len(rows) + 1 + first, rows.rank[first])
            end = lane + np.where(passing, len(rows) + 1 + last, rows.rank[last])
            begin, end = np.where(wanted, begin, FAR), np.where(wanted, end, FAR)
            found = found.united_with(single_claims(begin, end))
        return found

    def unexpired(self, claims: Claims, capture: IntArray, since: IntArray) -> Claims:
        """Return the claims of movements, stays and rests that do not end before a frame."""
        first = claims.first.copy()
        for part in self._lanes:
            for manner in MANNERS:
                lane = self.lane(manner, part)
                own = (first >= lane) & (first <= lane + len(self.batch.rows(part)))
                if own.any():
                    ends = self._ends(part, manner)
                    begin = lane + np.searchsorted(ends, capture * FAR + since)
                    first = np.where(own, np.maximum(first, begin), first)
        return in_sets(first, claims.last)

    def _ends(self, part: str, manner: str) -> IntArray:
        """Return capture and end of all movements, stays or rests of a part as one number."""
        if (part, manner) not in self._ends_of:
            rows = self.batch.rows(part)
            shown = rows.shown
            ends = rows.stop[shown] if manner == "move" else rows.until(shown)
            self._ends_of[part, manner] = rows.capture[shown].astype(np.int64) * FAR + ends
        return self._ends_of[part, manner]

    def lane(self, manner: str, part: str) -> int:
        """Return the number from which a part's movements, stays or rests are counted."""
        if part not in self._lanes:
            self._lanes[part] = len(self._widths)
            self._widths.append(2 * len(self.batch.rows(part)) + 4)
            self._begins.append(self._begins[-1] + len(MANNERS) * self._widths[-1])
        lane = self._lanes[part]
        return self._begins[lane] + MANNERS.index(manner) * self._widths[lane]

    def excusing(self, claims: Claims) -> Claims:
        """Return claims together with the movements that led there, in no order."""
        if not claims:
            return claims
        begins, widths = np.array(self._begins), np.array([*self._widths, 1])
        lane = np.searchsorted(begins, claims.first, "right") - 1
        passed = (claims.first - begins[lane]) // widths[lane] * widths[lane]
        first = np.where(claims.first < FAR, claims.first - passed, FAR)
        last = np.where(claims.first < FAR, claims.last - passed, FAR)
        return Claims(np.concatenate((claims.first, first)), np.concatenate((claims.last, last)))

    def met(self, conditions: Iterable[Condition], capture: IntArray, notes: IntArray) -> IntArray:
        """Return the places of the matches that meet conditions on labels."""
        labels = Facts(capture, notes, capture, capture, capture, capture)
        fits = np.ones(len(capture), bool)
        for condition in conditions:
            fits &= self.evaluator.holds(condition, labels)
        return np.flatnonzero(fits)

    def met_where_known(self, capture: IntArray, notes: IntArray) -> IntArray:
        """Return the places of the matches that meet conditions on labels, or still lack one."""
        fits = np.ones(len(capture), bool)
        for condition in self.clauses.conditions:
            if condition in self.clauses.of_all:
                continue
            known = np.ones(len(capture), bool)
            for label in self.clauses.labels[condition]:
                known &= notes[self.clauses.place(label)] >= 0
            some = np.flatnonzero(known & fits)
            fits[some] = False
            fits[some[self.met([condition], capture[some], notes[:, some])]] = True
        return np.flatnonzero(fits)
