"""The tempo of a movement: found, refused where there is none, or given."""

import random
from dataclasses import replace

import numpy as np
import pytest
from effort import seeds
from motions import mirrored, moved, scaled, turned
from random_tempos import RATE, danced, verdict, walked

import lanindex
from lanindex import encode
from lanindex.encoding.timing import Tempo, activity, estimated
from lanindex.errors import NotationError, UsageError
from lanindex.model import Motion
from lanindex.perform import perform

PROFILE = lanindex.load_profile()


def found(motion: Motion) -> Tempo | None:
    rows = {name: track.symbols for name, track in encode(motion).tracks.items()}
    return estimated(motion, PROFILE, rows)


@pytest.mark.parametrize("seed", seeds(4))
def test_steps_tell_their_tempo(seed: int) -> None:
    speed = random.Random(seed).uniform(60, 150)
    tempo = found(perform(walked(seed, speed), rate=RATE, noise=2.0, seed=seed))
    assert tempo is not None
    assert (tempo.clear, tempo.source) == (True, "steps")
    assert verdict(float(tempo.speed), speed) == "right"


def test_limbs_tell_theirs_or_nothing() -> None:
    told = []
    for seed in range(8):
        speed = random.Random(seed).uniform(60, 150)
        tempo = found(perform(danced(seed, speed), rate=RATE, noise=2.0, seed=seed))
        if tempo is not None and tempo.clear:
            told.append(verdict(float(tempo.speed), speed))
    assert len(told) >= 4
    assert set(told) == {"right"}


@pytest.mark.parametrize("seed", seeds(6))
def test_what_keeps_no_time_has_no_tempo(seed: int) -> None:
    tempo = found(perform(danced(seed, 0), rate=RATE, noise=2.0, seed=seed))
    assert tempo is None or not tempo.clear


@pytest.mark.parametrize(
    "change",
    [
        lambda motion: turned(motion, 77),
        lambda motion: moved(motion, (900, 0, -400)),
        lambda motion: scaled(motion, 0.5),
        mirrored,
    ],
)
@pytest.mark.parametrize("score", [walked(1, 96), danced(2, 110)])
def test_how_it_is_seen_changes_nothing(score, change) -> None:
    motion = perform(score, rate=RATE)
    one, other = found(motion), found(change(motion))
    assert one is not None
    assert other is not None
    assert (one.speed, one.source) == (other.speed, other.source)
    assert one.confidence == pytest.approx(other.confidence, abs=1e-3)


def test_a_score_counts_by_it_and_says_so() -> None:
    motion = perform(walked(3, 120), rate=RATE)
    plain, score = encode(motion), encode(motion, tempo="auto")
    assert float(score.meter.speed) == pytest.approx(120, abs=1)
    assert plain.meter.speed == 60
    assert score.other[0].startswith(f"// tempo: {float(score.meter.speed):g} beats a minute (conf")
    assert score.other[0] in lanindex.write_lnd(score)
    assert all(
        np.array_equal(
            track.symbols[["start", "stop"]], score.tracks[part].symbols[["start", "stop"]]
        )
        for part, track in plain.tracks.items()
    )
    steps = score.tracks["step"].symbols
    beats = steps["ticks"] * score.meter.beats / score.meter.division
    assert np.median(beats) == 1


def test_where_there_is_none_the_profiles_stays_with_a_word() -> None:
    still = perform(danced(1, 0), rate=RATE)
    still = replace(still, positions=np.repeat(still.positions[:1], 300, axis=0))
    for motion, said in (
        (still, "it is too short, or nothing moves"),
        (replace(still, positions=still.positions[:1]), "it is too short, or nothing moves"),
        (perform(danced(4, 0), rate=RATE), "at most "),
    ):
        score = encode(motion, tempo="auto")
        assert (score.meter.speed, score.other) == (60, ())
        (warning,) = [one for one in score.warnings if "no tempo" in one]
        assert warning.startswith(f"no tempo was found, {said}")
        assert warning.endswith("beats are counted at 60 a minute")


def test_gaps_are_no_movement() -> None:
    motion = perform(danced(2, 110), rate=RATE)
    places = motion.positions.copy()
    places[200:320] = np.nan
    moved = activity(replace(motion, positions=places), PROFILE)
    assert (moved[200:320] == 0).all()
    assert np.isfinite(moved).all()


def test_beats_that_are_told_are_counted_by(tmp_path) -> None:
    file = tmp_path / "beats.txt"
    file.write_text("0.5\t1\n1.0\t2\n1.5\t3\n2.2\t1\n")
    motion = perform(walked(3, 120), rate=RATE)
    score = encode(motion, tempo=file)
    assert (score.meter.beats, float(score.meter.speed)) == (3, 105.88)
    assert score.other == ("// beats from 3: 0.5 1 1.5 2.2",)
    assert any("beats come 0.5 to 0.7 s apart" in one for one in score.warnings)
    file.write_text("0.5\n1.0\n1.5\n")
    assert not any("apart" in one for one in encode(motion, tempo=file).warnings)


def test_beats_after_the_capture_are_refused(tmp_path) -> None:
    file = tmp_path / "beats.txt"
    file.write_text("1000\n1001\n")
    motion = perform(walked(3, 120), rate=RATE)
    with pytest.raises(UsageError, match="beats from 1000 s on"):
        encode(motion, tempo=file)
    with pytest.raises(NotationError, match="no such file"):
        encode(motion, tempo=tmp_path / "none.txt")
