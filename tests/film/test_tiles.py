"""Tiles of movement, and the description of a body, as a page is given them."""

from pathlib import Path

import numpy as np
import pytest

import lanindex
from lanindex.film.figure import JOINTS, Strokes, figure
from lanindex.film.tiles import UNKNOWN, described, packed


def unpacked(tile: bytes) -> np.ndarray:
    origin = np.frombuffer(tile, "<f4", 3)
    whole = np.frombuffer(tile, "<i2", offset=12).reshape(-1, 21, 3)
    return np.where(whole == UNKNOWN, np.nan, whole + origin)


def test_places_come_back_to_a_millimetre() -> None:
    places = np.random.default_rng(1).uniform(-2000, 2000, (5, 21, 3)).astype(np.float32)
    places += (123_456, 1000, -98_765)  # a stage far from the origin
    places[2, 3] = np.nan
    found = unpacked(packed(places))
    assert (np.isnan(found) == np.isnan(places)).all()
    assert np.nanmax(abs(found - places)) <= 0.51


def test_a_joint_that_flies_away_is_unknown_as_a_whole() -> None:
    places = np.zeros((2, 21, 3), np.float32)
    places[0, 0, 1], places[1, 0, 1] = 100_000, -100_000
    found = unpacked(packed(places))
    assert np.isnan(found[:, 0]).all()
    assert (found[:, 1:] == 0).all()


def test_nothing_known_is_a_tile_too() -> None:
    assert np.isnan(unpacked(packed(np.full((3, 21, 3), np.nan, np.float32)))).all()


@pytest.mark.parametrize("name", ["marching.bvh", "greetings.bvh"])
def test_strokes_are_those_of_films(repository: Path, name: str) -> None:
    body = figure(lanindex.read(repository / "corpus" / name))
    told, strokes = described(body), Strokes(body)
    assert told["joints"] == [*JOINTS]
    rows = [(it["width"], it["color"]) for it in told["strokes"]]
    assert rows == [(width, color) for *_, width, color in strokes.table]
    ends = [(it["from"], it["to"]) for it in told["strokes"]]
    assert ends == [*zip(strokes.inner.tolist(), strokes.outer.tolist(), strict=True)]
    assert {it["part"] for it in told["strokes"]} == set(body.parts)
    for track in ("r_arm", "l_leg_bend", "body_travel", "step", "r_forearm"):
        lit = {it["part"] for it in told["strokes"] if track in it["shows"]}
        assert lit == {part for part, on in zip(body.parts, body.shown([track]), strict=True) if on}
        assert lit
