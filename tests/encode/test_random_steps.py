"""Random steps, jumps and turns, performed and encoded again."""

import numpy as np
import pytest
from random_steps import RATE, Tally, compared, drawn

from lanindex import encode, read_lnd, write_lnd
from lanindex.alphabet import FACING
from lanindex.perform import perform
from tests import random_palms, random_twists

SEEDS = range(6)


@pytest.mark.parametrize(("noise", "least"), [(0.0, 0.99), (2.0, 0.97)])
def test_what_is_carried_out_comes_back(noise, least):
    tally: dict[str, Tally] = {}
    for seed in SEEDS:
        score = drawn(seed)
        compared(score, encode(perform(score, rate=RATE, noise=noise, seed=seed)), tally)
    assert sum(it.wanted for it in tally.values()) > 200
    for part, counts in tally.items():
        assert counts.exact >= least * counts.wanted, part
        assert counts.added == 0, part
        most = 5 if noise else 3
        assert np.percentile(counts.starts, 95) <= most, part
        assert np.percentile(counts.stops, 95) <= most, part


def test_the_body_goes_where_the_steps_lead():
    text = "#unit1\nsupport r_support forward mid 0 1\nsupport l_support forward mid 1 2\n"
    there = perform(read_lnd(text), rate=30)
    back = perform(read_lnd(text.replace("forward", "back")), rate=30)
    ways = [motion.positions[-1, 0] - motion.positions[0, 0] for motion in (there, back)]
    np.testing.assert_allclose(ways[0], [0, 0, 2 * 0.45 * 820], atol=1)
    assert ways[1][0] == pytest.approx(0, abs=1)  # steps back are shorter: toes stay on the floor
    assert -ways[0][2] < ways[1][2] < -0.9 * ways[0][2]


@pytest.mark.parametrize("way", ["forward", "right", "back"])
@pytest.mark.parametrize("level", ["low", "mid", "high"])
def test_the_foot_that_is_left_behind_stays_on_the_floor(way, level):
    text = f"#unit1\nsupport r_support {way} {level} 0 1\nsupport l_support place mid 3 3.6\n"
    found = encode(perform(read_lnd(text), rate=RATE))
    (step,) = (it for it in found.symbols("l_support") if it.start < it.stop)
    assert step.start == pytest.approx(3 * RATE, abs=6)  # it leaves when its own step begins


def test_a_score_without_weight_is_carried_out_on_the_spot():
    motion = perform(read_lnd("#unit1\ndirection r_arm right mid 0 1\n"), rate=30)
    assert np.ptp(motion.positions[:, 0], axis=0).max() == 0


def test_what_goes_through_lnd_is_carried_out_the_same():
    score = drawn(1)
    ours, theirs = (perform(one, rate=RATE) for one in (score, read_lnd(write_lnd(score))))
    frames = min(len(ours), len(theirs))
    apart = np.abs(ours.positions[:frames] - theirs.positions[:frames]).max(axis=(1, 2))
    assert np.percentile(apart, 95) < 150  # ticks are an eighth of a second


@pytest.mark.parametrize(("noise", "least"), [(0.0, 0.99), (2.0, 0.97)])
def test_twists_and_inclines_come_back(noise, least):
    tally: dict[str, Tally] = {}
    for seed in SEEDS:
        score = random_twists.drawn(seed)
        found = encode(perform(score, rate=RATE, noise=noise, seed=seed))
        compared(score, found, tally, random_twists.TURNED)
    for part, counts in tally.items():
        assert counts.wanted > 50, part
        assert counts.exact >= least * counts.wanted, part
        assert counts.added <= 1, part
        most = 5 if noise else 3
        assert np.percentile(counts.starts, 95) <= most, part
        assert np.percentile(counts.stops, 95) <= most, part


@pytest.mark.parametrize(("noise", "least", "most"), [(0.0, 1.0, 3), (2.0, 0.85, 25)])
def test_palms_come_back(noise, least, most):
    tally: dict[str, Tally] = {}
    for seed in SEEDS:
        score = random_palms.drawn(seed)
        motion = perform(score, rate=RATE, noise=noise, seed=seed)
        assert motion.warnings == ()
        compared(score, encode(motion), tally, FACING)
    for part, counts in tally.items():
        assert counts.wanted > 100, part
        assert counts.exact >= least * counts.wanted, part
        assert counts.added <= counts.wanted - counts.exact, part
        assert np.percentile(counts.starts, 95) <= most, part
        assert np.percentile(counts.stops, 95) <= most, part


def test_a_body_that_turns_without_a_step_takes_its_feet_along():
    motion = perform(read_lnd("#unit1\nrotation body_turn left 90 0 2\n"), rate=30)
    toes = motion.positions[:, motion.skeleton.names.index("LeftToeBase")]
    assert toes[-1][[0, 2]] == pytest.approx([toes[0][2], -toes[0][0]], abs=1)
