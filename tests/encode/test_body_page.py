"""The page of the whole body says what the code does."""

import re

from lanindex.body import axes
from lanindex.encoding import (
    bends,
    curves,
    ground,
    measures,
    rests,
    steps,
    timing,
    touch,
    twists,
    whole,
)
from lanindex.encoding.profile import BUILT_IN
from lanindex.model.columns import LIMITS
from lanindex.notation import beats

PAGE = (BUILT_IN.parent / "BODY.md").read_text()
MODULES = (curves, bends, ground, twists, steps, rests, whole, touch, measures, timing, beats, axes)


def test_every_number_is_that_of_the_code():
    said = dict(re.findall(r"^\| `([A-Z]+)` \| ([\d.]+) \|", PAGE, re.MULTILINE))
    held = {
        name: value
        for module in MODULES
        for name, value in vars(module).items()
        if name.isupper() and not name.startswith("_") and isinstance(value, float)
    }
    del held["SECTOR"]  # half of a direction: METHOD.md
    del held["FASTEST"]  # what a row can hold: alphabet
    held |= {"FEWEST": timing.FEWEST, "AHEAD": timing.AHEAD}
    assert {name: float(value) for name, value in said.items()} == held


def test_the_feet_of_a_jump_are_those_of_the_code():
    rows = re.findall(r"^\| (\d) \| (both|one) \| ([a-z ]+) \| (\w+) \|", PAGE, re.MULTILINE)
    names = ("BOTH_BOTH", "HOP", "LEAP", "ONE_BOTH", "BOTH_ONE")
    assert [int(row[0]) for row in rows] == [getattr(steps, name) for name in names]


def test_what_is_fast_and_large_is_that_of_the_code():
    rows = re.findall(r"^\| (\w+) \|((?: [\d.]+ \|){2,})$", PAGE, re.MULTILINE)
    said = {name: [float(it) for it in numbers.replace("|", "").split()] for name, numbers in rows}
    held = {name: [end for ends in it.values() for end in ends] for name, it in LIMITS.items()}
    assert said == held


def test_every_section_that_a_module_obeys_is_there():
    for module in MODULES:
        for section in re.findall(r'"([^"]+)"', (module.__doc__ or "").split("BODY.md")[1]):
            assert f"## {section}" in PAGE
