import pickle

import pytest

from lanindex import errors
from lanindex.errors import LanindexError, PatternError, quoted, shown

KINDS = [
    kind
    for kind in vars(errors).values()
    if isinstance(kind, type) and issubclass(kind, LanindexError) and kind is not PatternError
]


@pytest.mark.parametrize("kind", KINDS)
def test_errors_come_whole_from_another_process(kind: type[LanindexError]) -> None:
    error = kind("is odd", place="a.bvh:3", wanted="even", remedy="Add one.")
    again = pickle.loads(pickle.dumps(error))
    assert type(again) is kind
    assert vars(again) == vars(error)
    assert str(again) == "a.bvh:3: is odd, wanted even. Add one."


def test_a_pattern_error_comes_whole_from_another_process() -> None:
    error = PatternError("No such level.", text="r_arm hihg", start=6, stop=10)
    again = pickle.loads(pickle.dumps(error))
    assert type(again) is PatternError
    assert vars(again) == vars(error)
    assert str(again) == str(error)


def test_long_texts_are_cut() -> None:
    assert shown("x" * 60) == "x" * 60
    assert shown("x" * 61) == "x" * 59 + "…"
    assert quoted("a\n") == "'a\\n'"
    assert len(quoted(["x" * 5000])) == 60
    assert quoted({"speed": 1 << 20_000}) == "something too large to show"
