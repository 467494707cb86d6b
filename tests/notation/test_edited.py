import json

import pytest
from hypothesis import given, settings
from random_scores import scores, seconds

from lanindex.alphabet import KINDS, TRACKS, kind_of
from lanindex.errors import NotationError
from lanindex.model import Score
from lanindex.notation import edited, lnd

WRITTEN = [part for part in TRACKS if KINDS[kind_of(part)].keyword and kind_of(part) != "touch"]
ONE = {
    **{"speed": "60", "beats": 4, "beat": 4, "division": 96, "units": 2, "other": []},
    "symbols": [["r_arm", 0, 0, "place", "low"], ["r_arm", 24, 48, "right", "high"]],
}


@settings(max_examples=60)
@given(score=scores((*WRITTEN, "tail")))
def test_a_score_that_an_editor_holds_is_the_score(score: Score) -> None:
    data = json.loads(json.dumps(edited.of_score(score)))
    again = edited.score_of(data)
    assert again.meter.speed == score.meter.speed
    assert (again.meter.beats, again.meter.beat) == (score.meter.beats, score.meter.beat)
    whole = lnd.read(lnd.write(score))
    assert seconds(again) == seconds(whole)
    assert {it: own.known for it, own in again.tracks.items()} == {
        it: own.known for it, own in whole.tracks.items()
    }
    assert lnd.write(again) == lnd.write(whole)
    assert edited.of_score(again) == data


def test_touches_have_words() -> None:
    symbols = [["hands_touch", 0, 24, "hand"], ["r_hand_touch", 24, 48, "knee"]]
    assert edited.of_score(edited.score_of(ONE | {"symbols": symbols}))["symbols"] == symbols


def test_symbols_are_numbered_as_in_their_tracks() -> None:
    score = edited.score_of(ONE)
    assert [str(it) for it in score.symbols("r_arm")] == [
        "r_arm place low [0, 0)",
        "r_arm right high [8, 16)",
    ]


def test_lines_that_are_not_understood_and_uneven_beats_stay() -> None:
    text = "// a dance\n#speed=60\n#unit1\nsparkle r_arm 1 2\ndirection r_arm right mid 0 1\n"
    kept = edited.score_of(edited.of_score(lnd.read(text)))
    assert lnd.write(kept) == lnd.write(lnd.read(text))
    uneven = ONE | {"other": ["// beats from 0: 0 1 3 4"]}
    assert edited.score_of(uneven).symbols("r_arm")[1].stop > 2 * edited.score_of(uneven).rate


@pytest.mark.parametrize(
    ("change", "place", "found"),
    [
        ({"speed": 60}, "speed", "60"),
        ({"division": 0}, "division", "0"),
        ({"beats": True}, "beats", "True"),
        ({"symbols": None}, "symbols", "None"),
        ({"speed": "1e9"}, "symbol:1", "1e9"),
        ({"symbols": [["r_arm", 0, 24, "up", "high"]]}, "symbol:1", '"up"'),
        ({"symbols": [["r_arm", 0, 24, "right"]]}, "symbol:1", "words behind direction"),
        ({"symbols": [["step", 0, 24, "right", "mid"]]}, "symbol:1", '"step"'),
        ({"symbols": [["r_arm", 24, 0, "right", "mid"]]}, "symbol:1", "r_arm"),
        ({"symbols": [["r_arm", 0, 1, "right mid 0 1\n#unit2"]]}, "symbol:1", "r_arm"),
        ({"symbols": [*ONE["symbols"], ["r_arm", 40, 60, "left", "mid"]]}, "symbol:3", "line 2"),
    ],
)
def test_what_lnd_cannot_say_is_refused_with_its_place(
    change: dict[str, object], place: str, found: str
) -> None:
    with pytest.raises(NotationError) as caught:
        edited.score_of(ONE | change)
    assert caught.value.place == place
    assert found in caught.value.found


def test_what_was_read_once_is_checked_and_numbered_all_the_same() -> None:
    symbols = ONE["symbols"]
    assert edited.score_of(ONE).tracks.keys() == edited.score_of(ONE).tracks.keys()
    part, start, stop, *words = symbols[0]
    for wrong in ([part, float(start), stop, *words], [part, start, stop, words], None):
        with pytest.raises(NotationError) as refused:
            edited.score_of({**ONE, "symbols": [*symbols, wrong]})
        assert refused.value.place == f"symbol:{len(symbols) + 1}"
