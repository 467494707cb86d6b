"""Names: of people in a file, of joints, of columns; how each is made one that can be told."""

import pytest

from lanindex.formats import File, parted
from lanindex.formats.file import together
from lanindex.formats.people import distinct, named, others, plain
from lanindex.formats.text_rows import triples, twice


def test_a_capture_is_a_file_and_a_person() -> None:
    assert parted("in/trial.c3d#Ada") == ("in/trial.c3d", "Ada")
    assert parted("in/take#2.bvh") == ("in/take#2.bvh", "")


@pytest.mark.parametrize(
    ("name", "wanted"),
    [(" Ada/left#2 ", "Ada_left_2"), ("Zoe\u0308", "Zo\u00eb"), ("a\\b\x00", "a_b_")],
)
def test_a_name_can_stand_in_a_path(name: str, wanted: str) -> None:
    assert plain(name) == wanted
    assert plain(name * 100) == plain(name * 100)[:100].strip()


def test_each_has_its_own_name() -> None:
    assert named({"a/b": 1, "a#b": 2, "": 3, " ": 4}) == {"a_b": 1, "a_b 2": 2, "": 3, "4": 4}
    assert distinct(["Hips", "", "Hips"], [4, 5, 6]) == ("Hips", "node 5", "Hips 6")


def test_others_are_not_too_many() -> None:
    assert others("abc", "b") == "a, c"
    assert others(map(str, range(20))) == "0, 1, 2, 3, 4, 5, 6, 7, 8, 9 and 10 more"


def test_columns_of_points() -> None:
    assert triples(["t", "head_x", "head_y", "head_z", "q_x"]) == ({"head": (1, 2, 3)}, None)
    assert triples(["Hand.X [mm]", "Hand.Y [mm]", "Hand.Z [mm]"]) == ({"Hand": (0, 1, 2)}, "mm")


def test_points_of_one_name() -> None:
    doubts = ("several points are called 'hand': the first is read",)
    assert twice(["hand", "head", "hand"], "points") == doubts
    assert twice(["hand", "head"], "points") == ()


def test_content_that_is_equal() -> None:
    assert together([]) == ""
    assert together([File("a", b"1")]) == together([File("b", b"1")])
    assert together([File("a", b"1")]) != together([File("a", b"2")])
