"""The shared types are immutable and refuse invalid values."""

from dataclasses import FrozenInstanceError, fields, replace
from fractions import Fraction

import numpy as np
import pytest
from motions import motion_of, swung
from sample_library import sample_score

from lanindex.alphabet import DIRECTIONS, KINDS, LEVELS, MOST_AMOUNT, kind_of, mirrored_part
from lanindex.errors import EncodeError, LanindexError
from lanindex.model import SYMBOL, Capture, Hit, Meter, Reading, Span, Track
from lanindex.model.symbol import FIELDS, blank, listed

SCORE = sample_score()
MOTION = motion_of(swung(1, 40, Fraction(30), 0.0), Fraction(30))
CAPTURE = Capture(1, "a.bvh", "bvh", "", "", Fraction(30), 9)
OBJECTS = [
    Span(1, 2),
    Reading(),
    Meter(),
    SCORE,
    SCORE.tracks["head"],
    SCORE.symbols("head")[0],
    MOTION,
    MOTION.skeleton,
    MOTION.source,
    CAPTURE,
    Hit(CAPTURE, Span(0, 5), 1.0, ()),
    KINDS["gesture"],
    FIELDS["margin"],
]


@pytest.mark.parametrize("it", OBJECTS, ids=lambda it: type(it).__name__)
def test_nothing_can_be_changed(it: object) -> None:
    name = fields(it)[0].name  # type: ignore[arg-type]
    with pytest.raises(FrozenInstanceError):
        setattr(it, name, None)


def test_no_array_can_be_written_to() -> None:
    arrays = (
        MOTION.positions,
        MOTION.skeleton.parents,
        MOTION.skeleton.offsets,
        MOTION.skeleton.body,
        SCORE.heading,
        SCORE.tracks["head"].symbols,
    )
    assert not any(array.flags.writeable for array in arrays)
    own = np.zeros((2, 1, 3), np.float32)
    replace(MOTION, skeleton=one_joint(), positions=own)
    own[0] = 1  # the caller's array stays the caller's


def one_joint():
    return replace(
        MOTION.skeleton,
        names=("Hips",),
        parents=np.array([-1], np.int16),
        offsets=np.zeros((1, 3), np.float32),
    )


@pytest.mark.parametrize("shape", [(2, 3), (2, 1, 2), (2, 2, 3), (2, 1, 3, 1)])
def test_positions_have_the_skeletons_shape(shape: tuple[int, ...]) -> None:
    with pytest.raises(EncodeError, match=r"positions have shape .*, wanted \(T, 1, 3\)"):
        replace(MOTION, skeleton=one_joint(), positions=np.zeros(shape, np.float32))


def test_rotations_are_a_quaternion_a_joint() -> None:
    turned = np.zeros((2, 1, 4), np.float32)
    turned[..., 0] = 1
    still = np.zeros((2, 1, 3), np.float32)
    motion = replace(MOTION, skeleton=one_joint(), positions=still, rotations=turned)
    assert motion.rotations is not None
    assert not motion.rotations.flags.writeable
    assert MOTION.rotations is None
    with pytest.raises(EncodeError, match=r"rotations have shape \(1, 1, 4\), wanted \(2, 1, 4\)"):
        replace(motion, rotations=turned[:1])


@pytest.mark.parametrize("rate", [0, -30])
def test_a_rate_is_more_than_nothing(rate: int) -> None:
    with pytest.raises(EncodeError, match="wanted more than 0"):
        replace(MOTION, rate=Fraction(rate))


def test_rows_of_another_kind_are_refused() -> None:
    with pytest.raises(EncodeError, match=r"wanted model\.SYMBOL"):
        Track("head", np.zeros(2), ())
    with pytest.raises(EncodeError, match='the kind "dance", wanted one of gesture, support'):
        Track("head", blank(0), (), "dance")


def test_a_track_knows_its_kind() -> None:
    assert Track("r_support", blank(0), ()).kind == "support"
    assert {kind_of(part) for part in ("head", "l_arm", "tail", "support")} == {
        "gesture",
        "support",
    }
    assert kind_of("l_support") == kind_of("support") == "support"
    assert kind_of("x_support") == "gesture"


def test_the_other_side_of_a_part() -> None:
    pairs = {"r_arm": "l_arm", "l_foot": "r_foot", "head": "head", "r_": "l_", "right": "right"}
    assert {part: mirrored_part(part) for part in pairs} == pairs


def test_every_field_of_a_symbol_is_a_column_and_a_word() -> None:
    assert list(SYMBOL.names or ()) == list(FIELDS)
    rows = blank(3)
    rows["direction"], rows["level"] = [0, 8, -1], [2, 0, -1]
    rows["amount"] = [-1, 90, 0]
    rows["runner_direction"], rows["runner_level"] = [3, -1, 2], [1, 2, -1]
    first, second, third = listed("r_arm", rows)
    assert (first.direction, first.level, first.amount) == (DIRECTIONS[0], LEVELS[2], None)
    assert (first.words, second.words, third.words) == ("right high", "place low 90deg", "")
    assert (first.runner_up, second.runner_up, third.runner_up) == (
        ("l_forward", "mid"),
        None,
        None,
    )
    assert [it.ordinal for it in (first, second, third)] == [0, 1, 2]


def test_an_amount_has_room() -> None:
    assert FIELDS["amount"].most == MOST_AMOUNT


def test_bits_of_fields_that_share_a_column_do_not_overlap() -> None:
    taken: dict[str, int] = {}
    for name, how in FIELDS.items():
        mine = ((1 << how.bits) - 1) << how.shift
        assert not taken.get(how.column, 0) & mine, name
        assert how.shift + how.bits < 63, name
        taken[how.column] = taken.get(how.column, 0) | mine


def test_an_error_is_an_exception_with_what_was_found() -> None:
    error = LanindexError("is odd", place="a", wanted="even")
    assert error.args == ("is odd",)
    assert str(error) == "a: is odd, wanted even"
