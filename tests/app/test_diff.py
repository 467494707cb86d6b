"""``diff`` as a user types it."""

import json
from pathlib import Path
from xml.etree import ElementTree

import pytest
from click.testing import Result
from dances import RAISE, dance
from typer.testing import CliRunner

from lanindex.app.cli import app

SVG = "{http://www.w3.org/2000/svg}"
ONE = "#unit1\ndirection r_arm right low 0 1\ndirection r_arm right high 1 2\n"
OTHER = "#unit1\ndirection r_arm right low 0 1\ndirection r_arm right mid 1 2\n"


@pytest.fixture
def place(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    (tmp_path / "one.lnd").write_text(ONE)
    (tmp_path / "other.lnd").write_text(OTHER)
    (tmp_path / "arm.lnd").write_text(ONE.replace("r_arm", "l_arm"))
    monkeypatch.chdir(tmp_path)
    return tmp_path


def run(*words: str) -> Result:
    return CliRunner().invoke(app, ["diff", *words])


@pytest.mark.usefixtures("place")
def test_what_differs_is_told() -> None:
    done = run("one.lnd", "other.lnd")
    assert done.exit_code == 1
    assert done.stdout.splitlines()[1:] == [
        "r_arm\tright high\t1.00-2.00\tright mid\t1.00-2.00\treplaced"
    ]
    assert "1 difference in 1 track, 1 symbol the same" in done.stderr


@pytest.mark.usefixtures("place")
def test_nothing_differs() -> None:
    done = run("one.lnd", "one.lnd")
    assert (done.exit_code, done.stdout) == (0, "")
    assert "0 differences in 1 track, 2 symbols the same" in done.stderr


@pytest.mark.usefixtures("place")
def test_records_are_json() -> None:
    (record,) = map(json.loads, run("one.lnd", "other.lnd", "--json").stdout.splitlines())
    assert [*record] == ["part", "difference", "one", "other", "later", "longer"]
    assert (record["one"]["level"], record["other"]["level"]) == ("high", "mid")
    assert (record["one"]["start"], record["one"]["end"]) == (1.0, 2.0)


def test_both_staves_are_drawn_with_bands(place: Path) -> None:
    assert run("one.lnd", "other.lnd", "-o", "both.svg").exit_code == 1
    root = ElementTree.parse(place / "both.svg").getroot()
    groups = [it for it in root.iter(f"{SVG}g") if "data-part" in it.attrib]
    assert [it.attrib["data-level"] for it in groups] == ["low", "high", "low", "mid"]
    bands = [it for it in root.iter(f"{SVG}path") if it.get("fill-opacity") == ".3"]
    assert len(bands) == 2
    left, right = (float(it.attrib["d"][1:].split()[0]) for it in bands)
    assert left < right
    assert run("one.lnd", "other.lnd", "-o", "both.svg").exit_code == 2  # it is there
    assert run("one.lnd", "other.lnd", "-o", "one.lnd").exit_code == 2


def test_a_score_and_its_motion_and_a_stretch_of_the_library(place: Path) -> None:
    (place / "raise.lnd").write_text(RAISE)
    dance(place / "raise.bvh")
    assert CliRunner().invoke(app, ["ingest", "raise.bvh", "-q"]).exit_code == 0
    done = run("raise.lnd", "1")
    assert done.exit_code == 0, done.output
    assert "only raise.bvh tells of " in done.stderr
    same = run("1:0-30", "raise.bvh:0-30")
    assert (same.exit_code, same.stdout) == (0, "")
    assert run("1:0-30", "raise.bvh:15-45").exit_code == 1


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("one.lnd", "none.bvh"), "there is no"),
        (("one.lnd", "arm.lnd"), "no track that both have"),
        (("one.lnd", "other.lnd", "--parts", "wing"), 'there is no part "wing"'),
        (("one.lnd", "other.lnd", "--tolerance", "-1"), "a tolerance of -1 s"),
        (("one.lnd", "other.lnd", "-o", "a.gif"), "wanted an ending of svg, png or pdf"),
        (("one.lnd", "other.lnd", "--bars", "2"), "wanted --output beside them"),
        (("one.lnd:7-7", "other.lnd"), "frames 7 to 7"),
    ],
)
@pytest.mark.usefixtures("place")
def test_mistakes_are_said(words: tuple[str, ...], said: str) -> None:
    done = run(*words)
    assert (done.exit_code, done.stdout) == (2, "")
    assert said in done.stderr
