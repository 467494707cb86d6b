"""Praat's TextGrids: written as Praat writes them, read as Praat reads them."""

import re

import pytest

import lanindex
from lanindex.errors import NotationError
from lanindex.notation import textgrid

LND = """\
#unit0
direction r_arm place low 0 0
#unit1
direction r_arm right mid 0 1.5
direction r_arm place high 2 2.25
rotation body_turn left 90 1 2
"""

LONG = """\
File type = "ooTextFile"
Object class = "TextGrid"

xmin = 0
xmax = 4
tiers? <exists>
size = 3
item []:
    item [1]:
        class = "IntervalTier"
        name = "r_arm"
        xmin = 0
        xmax = 4
        intervals: size = 4
        intervals [1]:
            xmin = 0
            xmax = 1.5
            text = "right mid"
        intervals [2]:
            xmin = 1.5
            xmax = 2
            text = ""
        intervals [3]:
            xmin = 2
            xmax = 2.25
            text = "place high"
        intervals [4]:
            xmin = 2.25
            xmax = 4
            text = ""
    item [2]:
        class = "TextTier"
        name = "r_arm starts"
        xmin = 0
        xmax = 4
        points: size = 1
        points [1]:
            number = 0
            mark = "place low"
    item [3]:
        class = "IntervalTier"
        name = "body_turn"
        xmin = 0
        xmax = 4
        intervals: size = 3
        intervals [1]:
            xmin = 0
            xmax = 1
            text = ""
        intervals [2]:
            xmin = 1
            xmax = 2
            text = "left 90deg"
        intervals [3]:
            xmin = 2
            xmax = 4
            text = ""
"""

SHORT = '''\
File type = "ooTextFile"
Object class = "TextGrid"

0
4.00000000000001
<exists>
2
"IntervalTier"
"say ""a"""
0 4 1
0 4 "! hm"
"IntervalTier"
"r_arm"
0
4
2 ! of them
0
1.49999999999999
"Right MID"
1.49999999999999
4e0
" "
'''


def test_the_long_form() -> None:
    assert textgrid.write(lanindex.read_lnd(LND)) == LONG
    for text in (LONG, LONG.replace("\n", "\r\n"), re.sub(" +", " ", LONG)):
        assert lanindex.write_lnd(textgrid.read(text.encode(), "x")) == lanindex.write_lnd(
            lanindex.read_lnd(LND)
        )


@pytest.mark.parametrize("encoding", ["utf-8", "utf-16", "utf-8-sig"])
def test_the_short_form(encoding: str) -> None:
    score = textgrid.read(SHORT.encode(encoding), "x")
    assert [str(it) for it in score.symbols()] == ["r_arm right mid [0, 12)"]
    assert score.warnings == ('the tier "say "a"" is no part of the body: left out',)


def test_intervals_follow_each_other_to_the_end() -> None:
    text = textgrid.write(lanindex.encode(lanindex.read("corpus/jumping_jacks.bvh")))
    for tier in text.split('class = "IntervalTier"')[1:]:
        tier = tier.split("class =")[0]
        times = re.findall(r"xmin = (\S+)\s+xmax = (\S+)", tier)
        (begin, end), *spans = [(float(a), float(b)) for a, b in times]
        assert [a for a, _ in spans] == [begin, *(b for _, b in spans[:-1])]
        assert spans[-1][1] == end
        assert all(a < b for a, b in spans)
        assert int(re.search(r"size = (\d+)", tier)[1]) == len(spans)


@pytest.mark.parametrize(
    ("change", "line", "said"),
    [
        (("ooTextFile", "ooText"), 1, '"ooText", wanted "ooTextFile"'),
        (('"TextGrid"', '"Pitch 1"'), 2, '"Pitch 1", wanted "TextGrid"'),
        (("<exists>", "<absent>"), 0, "no tier of a part"),
        (("\nsize = 3", "\nsize = 4"), 0, "the end of the file, wanted what kind of tier it is"),
        (("\nsize = 3", "\nsize = 2.5"), 7, "2.5, wanted how many tiers there are"),
        (("\nsize = 3", "\nsize = three"), 10, '"IntervalTier", wanted how many tiers there are'),
        (('class = "TextTier"', 'class = "Tier"'), 32, 'a tier of "Tier", wanted "IntervalTier"'),
        (("xmin = 2\n", "xmin = -2\n"), 24, "a time of -2 s, wanted 0 or later"),
        (("xmax = 2.25", "xmax = 2.0001"), 26, '"place high" from 2 to 2 s, wanted an end 1 ms'),
        (("xmin = 2\n", "xmin = 1.4\n"), 0, "r_arm at 1.4 s: begins before what begins at 0 s is"),
        (("right mid", "rihgt mid"), 0, 'r_arm at 0 s: "rihgt mid", wanted right r_forward'),
        (("right mid", 'right "mid'), 18, "wanted"),
        (("r_arm", "arm"), 0, "wanted"),
        (("xmax = 1.5", "xmax = " + "1" * 50), 17, "wanted a time in seconds"),
        (("xmax = 2.25", "xmax = 86401"), 0, "wanted at most 24 hours"),
    ],
)
def test_what_is_wrong_is_said(change: tuple[str, str], line: int, said: str) -> None:
    text = LONG.replace(*change)
    if change[0] == "r_arm":
        text = text.replace("body_turn", "turn").replace("arm", "limb")
    if change[1] == "<absent>":
        text = text.replace("r_arm", "arm").replace("body_turn", "turn")
        text = text.replace("<absent>", "<exists>")
    with pytest.raises(NotationError) as caught:
        textgrid.read(text.encode(), "x.TextGrid")
    assert said in str(caught.value)
    if line:
        assert caught.value.place == f"x.TextGrid:{line}"


@pytest.mark.parametrize("content", [b"", b"\xff\xfe\x00", LONG.encode("latin-1") + b"\xe9", b"\0"])
def test_what_is_no_text(content: bytes) -> None:
    with pytest.raises(NotationError):
        textgrid.read(content, "x.TextGrid")
