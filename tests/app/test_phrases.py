"""What people type leads to the movement that they mean: one line to paste, or hits at once."""

import re

import pytest
from command import run


def steps(ways: str, first: str) -> list[str]:
    """Return eight steps, one way with one foot and one with the other."""
    feet = [f"{first}_support", "l_support" if first == "r" else "r_support"]
    return [
        f"support {feet[number % 2]} {ways.split()[number % 2]} mid {1 + 0.6 * number:.1f} "
        f"{1.6 + 0.6 * number:.1f}"
        for number in range(8)
    ]


def fist(upper_arm: str, forearm: str, begin: float, end: float) -> list[str]:
    return [
        f"direction r_upper_arm {upper_arm} {begin} {end}",
        f"direction r_forearm {forearm} {begin} {end}",
    ]


GUARD = "forward low", "place high"
MADE = {
    "walk backwards": steps("back back", "r"),
    "walk to the left": steps("left place", "l"),
    "look left": ["twist head_turn left 45 1 1.6"],
    "look back": ["twist head_turn right 80 1 1.6"],
    "shake head": [
        f"twist head_turn {side} 40 {1 + 0.4 * number:.1f} {1.4 + 0.4 * number:.1f}"
        for number, side in enumerate(["left", "right", "left", "right"])
    ],
    "left hand touches head": ["touch l_hand_touch head 1 2.5"],
    "sit down": ["carrier other_support seat 1.5 5"],
    "turn around": ["rotation body_turn left 180 1 2.2"],
    "kneel": ["carrier other_support knee 1.5 5"],
    "lying on the floor": ["carrier other_support trunk 1.5 5"],
    "punch": [
        *fist(*GUARD, 0.5, 1),
        *fist("forward mid", "forward mid", 2, 2.25),
        *fist(*GUARD, 2.25, 2.6),
    ],
    "point forward": ["direction r_arm forward mid 1 1.8"],
    "arms crossed": [
        "direction r_forearm left mid 0.5 1.5",
        "direction l_forearm right mid 0.5 1.5",
    ],
    "stand still": [],
}
"""By what somebody types, the symbols of a score that shows it; the arms hang before. The last is
asked for by nobody here."""

BESIDE = {"point forward": {"lying on the floor"}, "look left": {"shake head"}}
"""What a phrase finds, too: who lies comes there with arms held forward."""


@pytest.fixture(scope="module")
def performed(tmp_path_factory):
    """Return a folder with a library of those motions."""
    folder = tmp_path_factory.mktemp("performed")
    for phrase, symbols in MADE.items():
        head = ["#speed=60", "#rhythm 4/4", "#unit_total 2", "#unit0"]
        arms = [f"direction {side}_arm place low 0 0" for side in "rl"]
        (folder / "score.lnd").write_text("\n".join([*head, *arms, "#unit1", *symbols, ""]))
        run("animate", "score.lnd", "-o", f"{phrase}.bvh", cwd=folder)
    (folder / "score.lnd").unlink()
    assert run("ingest", ".", "--db", "made.db", cwd=folder).returncode == 0
    return folder


@pytest.mark.parametrize("phrase", [phrase for phrase in MADE if MADE[phrase]])
def test_a_phrase_leads_to_the_movement(performed, phrase):
    asked = phrase
    done = run("search", phrase, "--db", "made.db", "--count", cwd=performed)
    if done.returncode == 2:
        # the phrase, where in it, what is meant; of a word that the dictionary lacks why
        assert len(done.stderr.splitlines()) <= 4
        asked = re.search("Did you mean:  (.+)", done.stderr)[1]
        done = run("search", asked, "--db", "made.db", "--count", cwd=performed)
    found = set(re.findall(r"([\w ]+)\.bvh", done.stdout))
    assert found == {phrase} | BESIDE.get(phrase, set()), asked
