"""``lanindex inspect``: which order of rotations was taken, and why."""

import json
from pathlib import Path

import pytest
from bvh_bodies import SCHEMES, SIMPLE, named, person
from typer.testing import CliRunner

from lanindex.app.cli import app


def said(path: Path, *words: str) -> str:
    done = CliRunner().invoke(app, ["inspect", str(path), *words])
    assert done.exit_code == 0, done.output
    return done.stdout


@pytest.mark.parametrize(
    ("words", "order"),
    [
        ((), "parent first (as BVH has it)"),
        (("--compose", "child"), "child first (as told)"),
    ],
)
def test_the_order_of_rotations_and_who_says_so(
    tmp_path: Path, words: tuple[str, ...], order: str
) -> None:
    path = tmp_path / "walk.bvh"
    path.write_bytes(person())
    assert f"\ncompose      {order}\n" in said(path, *words)
    assert json.loads(said(path, "--json", *words))["compose"] == order


def test_an_exporter_is_known_by_its_names(tmp_path: Path) -> None:
    path = tmp_path / "mae.bvh"
    names = named(SCHEMES["OpenNI"]) | {"Pelvis": "TORSO#", "Neck": "TN"}
    names |= {side + "Collar": f"T{side}S" for side in "LR"} | {"Head": "TLH", "LHand": "TRH"}
    path.write_bytes(person(names=names))
    order = "child first (its joints are named as MAE names them)"
    assert f"\ncompose      {order}\n" in said(path)


def test_a_body_without_legs_has_no_length_of_a_leg(tmp_path: Path) -> None:
    path = tmp_path / "upper.bvh"
    gone = ("Knee", "Ankle", "Toe")
    path.write_bytes(person(names={it: own for it, own in SIMPLE.items() if it[1:] not in gone}))
    assert "\nlimbs        no leg, arm 5" in said(path)
