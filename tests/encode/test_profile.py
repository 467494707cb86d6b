import shutil
from pathlib import Path

import pytest

from lanindex.alphabet import DIRECTION_CODES, LEVEL_CODES, PARTS, PLACE
from lanindex.encoding.profile import BUILT_IN, Measure, load
from lanindex.errors import NotationError
from lanindex.notation.lpd_ldd import parse_ldd


@pytest.fixture
def own(tmp_path: Path) -> Path:
    return Path(shutil.copytree(BUILT_IN / "default", tmp_path / "mine"))


def test_built_in_profiles_differ() -> None:
    default, paper = load("default"), load("paper")
    assert default.digest != paper.digest
    assert paper.candidate_speed == Measure(600, False)
    assert default.candidate_speed.of(500) == pytest.approx(545)
    assert {profile.ranges["r_arm"].relative for profile in (default, paper)} == {True, False}


def test_every_part_has_ranges_and_rules() -> None:
    for name in ("default", "paper"):
        profile = load(name)
        assert set(profile.ranges) == set(profile.rules) == set(PARTS)


def test_default_rules_are_the_pages() -> None:
    rules = parse_ldd((BUILT_IN / "default" / "all.ldd").read_text())
    low, mid, high = (LEVEL_CODES[name] for name in ("low", "mid", "high"))
    wanted = set()
    for direction in range(PLACE):
        for end, between in ((low, low), (high, high)):
            row = ((PLACE, end), (direction, between), (direction, mid))
            wanted |= {row, row[::-1]}
    assert {rule.cells for rule in rules} == wanted
    assert {rule.deleted for rule in rules} == {(False, True, False)}


def test_a_copy_encodes_the_same_and_an_edit_does_not(own: Path) -> None:
    assert load(own).digest == load("default").digest
    text = (own / "profile.toml").read_text()
    (own / "profile.toml").write_text(text.replace("0.09 L", "50 mm"))
    assert load(own).digest != load("default").digest
    assert load(own).distance == Measure(50, False)


def test_a_part_has_its_own_file_before_its_group(own: Path) -> None:
    arm = (own / "all.lpd").read_text()
    (own / "arm.lpd").write_text(arm.replace("place\t0.38268 L", "place\t100"))
    (own / "l_arm.lpd").write_text(arm.replace("place\t0.38268 L", "place\t200"))
    ranges = load(own).ranges
    assert (ranges["r_arm"].place, ranges["l_arm"].place) == (100, 200)
    assert ranges["head"].place == pytest.approx(0.34202)
    assert DIRECTION_CODES["right"] == 0


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('smoothing = "83 ms"', 'smoothing = "83"', "smoothing = '83', wanted \"83 ms\""),
        ("rate = 60", "rate = 0", "rate = 0, wanted a number from 0.1 to 1000"),
        ("rate = 60", "rate = true", "rate = True, wanted a number from 0.1"),
        ("rate = 60", "rate = 1001", "rate = 1001, wanted a number from 0.1 to 1000"),
        ('still = "0.02 L/s"', "", "no still, wanted a line for it"),
        ("division = 32", "divisions = 32", '"divisions", wanted one of name, rate'),
        ("division = 32", "division = 1.5", "division = 1.5, wanted a whole number"),
        ("onset = 0.03", "onset = 2.0", "onset = 2.0, wanted a number from 0 to 0.25"),
        ('rhythm = "4/4"', 'rhythm = "4"', "rhythm = '4', wanted \"4/4\""),
        ('distance = "0.09 L"', 'distance = "9 cm"', 'wanted "50 mm" or "0.09 L"'),
        ("rate = 60", "rate = = 60", "wanted TOML"),
        ("rate = 60", "rate = 1e-300", "rate = 1e-300, wanted a number from 0.1 to 1000"),
        ("rate = 60", "rate = nan", "rate = nan, wanted a number from 0.1 to 1000"),
        ("rate = 60", f"rate = {'9' * 5000}", "a number without end, wanted at most 4300 digits"),
        ("rate = 60", f"rate = 0x{'f' * 5000}", "rate = something too large to show"),
        ("rate = 60", f"rate = {'[' * 100_000}", "brackets inside brackets, too many, wanted TOML"),
        ('"83 ms"', f'"{"9" * 400} ms"', "wanted a number of at most 1000000"),
        ('"83 ms"', f'"{"x" * 5000}"', f"smoothing = '{'x' * 58}…, wanted"),
        ("division = 32", f"{'d' * 5000} = 32", f'"{"d" * 59}…", wanted one of'),
    ],
    ids=lambda text: text[:40],
)
def test_errors_name_the_file(own: Path, old: str, new: str, message: str) -> None:
    path = own / "profile.toml"
    path.write_text(path.read_text().replace(old, new, 1))
    with pytest.raises(NotationError) as error:
        load(own)
    assert message in str(error.value)
    assert str(path) in str(error.value)
    assert len(str(error.value)) < 1000


def test_unknown_profile() -> None:
    with pytest.raises(NotationError, match="default, paper, or a folder"):
        load("papre")
    with pytest.raises(NotationError, match=r"n{59}…"):
        load("n" * 5000)


@pytest.mark.parametrize("name", ["tail.lpd", "r-arm.ldd", "ARM.lpd"])
def test_a_file_that_no_part_reads_is_refused(own: Path, name: str) -> None:
    (own / name).write_text("whatever")
    with pytest.raises(NotationError, match="no part is called") as caught:
        load(own)
    assert caught.value.place == str(own / name)


def test_missing_file_of_a_part(own: Path) -> None:
    (own / "all.ldd").unlink()
    with pytest.raises(NotationError, match=r"r_arm\.ldd, arm\.ldd or all\.ldd"):
        load(own)
