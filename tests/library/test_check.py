"""Each thing that can be wrong inside a library is found and named."""

import pytest
from sample import fill, sql

from lanindex.library.migrate import check

WRONG = {
    "UPDATE symbol SET end_frame = 900 WHERE part = 'head' AND ordinal = 2 AND capture_id = 1": (
        "0.bvh: head, symbol 2 lies at [11, 900), outside the 60 frames"
    ),
    "UPDATE symbol SET direction = 'up' WHERE part = 'head' AND ordinal = 1 AND capture_id = 2": (
        "1.bvh: head, symbol 1 has the unknown direction up or forward"
    ),
    "UPDATE symbol SET runner_level = 'x' WHERE part = 'head' AND ordinal = 0 AND capture_id = 1": (
        "0.bvh: head, symbol 0 has the unknown level low or x"
    ),
    "DELETE FROM symbol WHERE part = 'head' AND ordinal = 3 AND capture_id = 2": (
        "1.bvh: head has 5 symbols, the last is number 5"
    ),
    "DELETE FROM track WHERE capture_id = 2 AND part = 'head'": (
        "a row of symbol hangs on a row of track that does not exist"
    ),
    "DELETE FROM capture WHERE id = 1": (
        "a row of track hangs on a row of capture that does not exist"
    ),
    "INSERT INTO profile VALUES (7, 'spare', 'x')": "the profile spare wrote nothing down",
    "UPDATE capture SET rate = '30/0' WHERE id = 1": "0.bvh: rate cannot be read: 30/0",
    "UPDATE capture SET speed = 'fast' WHERE id = 1": "0.bvh: speed cannot be read: fast",
    "UPDATE capture SET options = '{' WHERE id = 2": "1.bvh: options cannot be read: {",
    "UPDATE track SET known = '[[0' WHERE capture_id = 2 AND part = 'head'": (
        "1.bvh: head: known cannot be read: [[0"
    ),
}


def test_nothing_is_wrong_with_a_new_library(tmp_path):
    fill(tmp_path / "some.db", 3)
    assert check(tmp_path / "some.db") == []


@pytest.mark.parametrize("change", WRONG)
def test_what_is_wrong_is_named(tmp_path, change):
    fill(tmp_path / "some.db", 2)
    with sql(tmp_path / "some.db") as connection:
        connection.execute(change)
    assert WRONG[change] in check(tmp_path / "some.db")


def test_many_of_a_kind_are_cut_short(tmp_path):
    fill(tmp_path / "some.db", 3)
    with sql(tmp_path / "some.db") as connection:
        connection.execute("UPDATE symbol SET direction = 'up'")
    found = check(tmp_path / "some.db")
    assert len(found) == 6
    assert found[-1] == "… and 49 more like it"


def test_a_damaged_page_is_found(tmp_path):
    path = tmp_path / "some.db"
    fill(path, 40)
    content = bytearray(path.read_bytes())
    content[-4096:] = bytes(range(256)) * 16
    path.write_bytes(content)
    (found,) = check(path)[:1]
    assert found.startswith("the file is damaged: ")
