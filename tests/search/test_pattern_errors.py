"""Errors in patterns: the marked text and the message."""

import pickle
import re

import pytest
from effort import examples
from hypothesis import example, given
from hypothesis import strategies as st

from lanindex import records
from lanindex.alphabet import TRACKS
from lanindex.data import shipped
from lanindex.errors import PatternError
from lanindex.search.language import Query, parse
from lanindex.search.language.words import LANGUAGE, VALUES, Vocabulary

# The text between « and » is what the caret points at.
ERRORS = [
    ("«»", "Nothing to look for"),
    ("«» // a comment", "Nothing to look for"),
    # Words
    ("r_arm «rihgt» mid -> high", 'I don\'t know "rihgt". Did you mean "right"?'),
    ("R_ARM «RIHGT»", 'I don\'t know "RIHGT". Did you mean "right"?'),
    ("«rarm» high", 'Did you mean "r_arm"?'),
    ("r_arm low -> «hihg»", 'Did you mean "high"?'),
    ("r_arm low ... high\n  -> «hihg» <1s", 'Did you mean "high"?'),
    ("r_arm high «wiht» l_arm low", 'Did you mean "with"?'),
    ("r_arm high «and» l_arm low", "Did you mean:  r_arm high with l_arm low"),
    ("r_arm «up»", "Did you mean:  r_arm high"),
    ("hand «up»", "Did you mean:  arm high"),
    ("r_arm «down»", "Did you mean:  r_arm low"),
    ("both arms «raised»", "Did you mean:  arms high"),
    ("right arm not «lowered»", 'Did you mean "low"?'),
    ("r_arm low -> «lifts» <1s", 'Did you mean "rising"?'),
    ("«right_knee» high", 'Did you mean "r_thigh"?'),
    ("«l_lower_leg» high", 'Did you mean "l_shank"?'),
    ("«trunk» forward <1s", 'Did you mean "torso"?'),
    ("«rigth_arm» high", 'Did you mean "right_arm"?'),
    ("r_arm high «overlaps» l_arm low", 'Did you mean "overlapping"?'),
    ("r_arm high «simultaneously» l_arm low", 'Did you mean "with"?'),
    ("r_arm high «while» l_arm at low", 'Did you mean "during"?'),
    ("r_arm high «bevore» head", 'Did you mean "before"?'),
    ("r_arm not «lwo»", 'Did you mean "low"?'),
    ("r_arm low/«hgih»", 'Did you mean "high"?'),
    ("«tail» high", 'There is no part "tail". The parts are: head torso '),
    ("r_arm high with «tail»", 'There is no part "tail".'),
    ("r_arm «%» high", 'I don\'t know "%".'),
    ("r_arm «ärmel»", 'I don\'t know "ärmel".'),
    ('r_arm «"high"»', "quotation marks"),
    ("r_arm high«,» low", "No commas"),
    ("r_arm high «=» low", "Conditions stand behind where"),
    # One movement
    ("r_arm high «low»", 'One movement has one level. "high/low" means either; "high -> low"'),
    ("r_arm right «forward»", "One movement has one direction."),
    ("r_arm right mid «left/back»", '"right/left/back" means either'),
    ("r_arm rising «sinking»", "one change of level"),
    ("r_arm «right/high»", "one kind"),
    ("r_arm not «right/high»", "one kind"),
    ("r_arm «not any»", "leaves nothing"),
    ("r_arm high «not high»", "leaves nothing"),
    ("r_arm not low «not mid/high»", "leaves nothing"),
    ("r_arm «not low/mid/high»", "leaves nothing"),
    ("«head» «side»", "no side of its own"),
    ("head low -> «across_back»", "The head has no side of its own"),
    ("r_arm at «rising»", "at is being there"),
    ("r_arm hold «sinking»", "hold is staying put"),
    ("r_arm «at»", "At what?"),
    ("r_arm «at» 2s", "At what?"),
    ("r_arm «not»", "Not what?"),
    ("r_arm «not» -> high", "Not what?"),
    ("r_arm not «l_arm»", "Here goes a direction or a level"),
    ("r_arm high«/»", "Or what?"),
    ("r_arm high/«l_arm»", "Here goes a direction or a level"),
    ("r_arm«/»l_arm high", '"or" joins lines'),
    ("r_arm high «hold»", '"hold" is a step of its own: r_arm right -> hold'),
    ("r_arm high «at» low", '"at" is a step of its own'),
    ("r_arm high <1s «right»", "Direction and level stand before length and count"),
    ("(r_arm high) «low»", "The next movement has an arrow: -> low"),
    # Who
    ("«high»", "Name the part first: r_arm high"),
    ("«hold» 2s", "Name the part first"),
    ("start -> «high»", "Name the part here: start -> r_arm high"),
    ("r_arm high or «low»", 'Name the part here; "/" is either-or between words: high/low.'),
    ("r_arm high with «low»", 'nothing carries over "with"'),
    ("r_arm high starting with «not» low", 'nothing carries over "starting with"'),
    ("r_arm high -> (low with «low»)", 'nothing carries over "with"'),
    ("(r_arm high or l_leg mid) -> «low»", "end with different parts (l_leg, r_arm)"),
    ("r_arm «l_arm» high", "Another part"),
    ("r_arm high «l_arm» low", "Another part"),
    # Arrows
    ("«->» high", "Nothing before the arrow. Name a part first"),
    ("«...» r_arm high", "Nothing before the arrow"),
    ("r_arm high «->»", "Nothing after the arrow"),
    ("r_arm high «then»", "Nothing after the arrow"),
    ("r_arm high «...» // later", "Nothing after the arrow"),
    ("r_arm high -> «->» low", "Two arrows"),
    ("r_arm high -> «...» low", "Two arrows"),
    ("r_arm «->[2]» high", "-> skips nothing"),
    ("r_arm high «->[<=2]» low", "-> skips nothing"),
    ("r_arm ...«[»] high", "A limit goes into the brackets"),
    ("r_arm ...«[»2 high", 'a "]" is missing'),
    ("r_arm ...«[»<2s high", 'a "]" is missing'),
    ("r_arm ...[«1.5»] high", "whole numbers"),
    ("r_arm «[»<2s] high", "Square brackets follow an arrow"),
    ("r_arm high «]»", "never opened"),
    ("«start»", 'An arrow follows "start"'),
    ("«start» r_arm high", 'An arrow follows "start"'),
    ("r_arm high -> «start»", '"start" begins a line'),
    ("r_arm high «end»", 'An arrow goes before "end"'),
    ("r_arm high -> end «->» low", 'After "end" the line does not go on'),
    ("r_arm high -> end «low»", 'After "end" the line does not go on'),
    # Lengths and counts
    ("r_arm high «2»", "2 what? 2s is seconds, 2b beats, 2f frames; x2 means twice."),
    ("r_arm high «3»x", "3 what? 3s is seconds, 3b beats, 3f frames; x3 means 3 times."),
    ("r_arm high «2.5»", "2.5 what?"),
    ("r_arm high <«2»", "2 what?"),
    ("r_arm high 1s..«2»", "2 what?"),
    ("r_arm high «<»", "A time goes here"),
    ("r_arm high «<»high", "A time goes here"),
    ("r_arm high 1s«..»", "A time goes here"),
    ("r_arm high «2s..1s»", "write 1s..2s"),
    ("r_arm high 1s «<2s»", "Two lengths"),
    ("r_arm high «123456789012»s", "digits"),
    ("r_arm high x2 «<1s»", "bracket it: (r_arm high x2) <1s; to time each, length first"),
    ("r_arm low? «2s» -> high", "bracket it: (r_arm low?) 2s"),
    ("r_arm high x2 «x3»", "bracket it: (r_arm high x2) x3"),
    ("r_arm high «x0»", "is never"),
    ("r_arm high «x3..2»", "write x2..3"),
    ("r_arm high «x3..»", "From how often to how often?"),
    ("r_arm high «x1234567890»", "digits"),
    ("«r_arm high x1001»", "1000 is the most"),
    ("(«(r_arm high x40) x40») x40", "This asks for 1600 movements in a row"),
    ("«r_arm high?»", "may be left out"),
    ("«r_arm high? -> low x0+»", "may be left out"),
    ("r_arm low -> («high?») -> low", "may be left out"),
    # Brackets, lines, clauses
    ("«(»r_arm high", "never closed"),
    ("r_arm low -> «(»high -> (low)", "never closed"),
    ("r_arm high«)»", "never opened"),
    ("r_arm low -> «()»", "Nothing between these brackets"),
    ("r_arm «(»high)", "missing before the bracket"),
    ("«mirror» r_arm", "mirror(r_arm right)"),
    ("r_arm high «mirror»(low)", 'missing before "mirror"'),
    ("«with» l_arm", 'Nothing before "with"'),
    ("r_arm high «with»", 'Nothing after "with"'),
    ("r_arm high «with» with l_arm", 'Nothing after "with"'),
    ("r_arm high «or»", 'Nothing after "or"'),
    ("r_arm high «starting» l_arm", '"with" follows'),
    ("r_arm high «either»", '"either side": the pattern or its mirror image'),
    ("r_arm high either side «->» low", '"either side" ends the pattern'),
    ("(r_arm high «either» side)", '"either side" speaks of the whole pattern'),
    ("(" * 40 + "«(»r_arm", "More than 40 brackets"),
    # Going through
    ("r_arm «via»", "Via what? Say where it goes through"),
    ("r_arm low -> «via» <1s", "Via what?"),
    ("r_arm high «via» right", '"via" is a step of its own'),
    ("start -> «via» high", "Name the part here: start -> r_arm high"),
    ("r_arm via right «left»", "One movement has one direction."),
    ("head via «side»", "no side of its own"),
    # Lines before, behind, nowhere and near
    ("«after» head", 'Nothing before "after"'),
    ("r_arm high «after»", 'Nothing after "after"'),
    ("r_arm high before «low»", 'nothing carries over "before"'),
    ("r_arm high «never»", 'Nothing after "never"'),
    ("r_arm high with«[»] l_arm", "A time goes into the brackets"),
    ("r_arm high after«[»] l_arm", "A time goes into the brackets: after[<1s]"),
    ("r_arm high after[«2»] l_arm", "2 what?"),
    ("r_arm high with[«<»1s] l_arm", "A plain time: with[1s] is less than 1s between."),
    ("r_arm high without[1s«+»] l_arm", "A plain time: without[1s]"),
    ("r_arm high with[1s«..»2s] l_arm", "A plain time"),
    ("r_arm high with«[0s]» l_arm", "Nothing is less than no time"),
    ("r_arm high with«[»1s l_arm", 'a "]" is missing'),
    ("r_arm high before«[»<1s l_arm", 'a "]" is missing'),
    ("r_arm high «during[»1s] l_arm", 'No time goes with "during"'),
    ("r_arm high «overlapping[»1s] l_arm", 'No time goes with "overlapping": half of the other'),
    ("r_arm high «never[»1s] l_arm", 'No time goes with "never"'),
    ("r_arm high starting «with[»1s] l_arm", "--tolerance"),
    ("r_arm high after «2»s head", "A time goes into square brackets: after[<1s]"),
    ("r_arm high with «<»1s l_arm", "A time goes into square brackets: with[1s]"),
    ("r_arm high with[«1»] l_arm", "x1 means once"),
    # Labels
    ("r_arm «a:» high", "A label goes before a step, behind the arrow"),
    ("a: r_arm high with «a:» l_arm high", 'The label "a" stands once.'),
    ("a: r_arm high or «a:» l_arm high", "stands once"),
    ("(«a:» r_arm high) x2", 'The label "a" stands inside a repeat'),
    ("r_arm low -> («b:» high)? -> low", "inside a repeat"),
    ("r_arm high without «a:» head", 'The label "a" stands inside "without"'),
    ("r_arm high never (head with «a:» torso)", 'inside "never"'),
    ("«high»: r_arm low", "choose another name"),
    ("«arm»: r_arm low", '"arm" is a part: choose another name'),
    ("r_arm low -> «x2»: low", '"x2" is a count: choose another name'),
    ("«clip»: r_arm low", "choose another name"),
    ("a: «b:» r_arm low", "One label is enough"),
    ("a: «start» -> r_arm low", '"start" begins a line'),
    ("r_arm «high:» low", "A label goes before a step, behind the arrow"),
    ("r_arm high «->» : low", "Nothing after the arrow"),
    # Conditions
    ("r_arm high where «b».start > 1s", 'There is no label "b". It stands before a step: b: r_arm'),
    ("a: r_arm high where «b».start > 1s", 'There is no label "b". There is: a'),
    ("a: r_arm high where a.«begin» > 1s", "Did you mean a.start?"),
    ("a: r_arm high where a.«qqq» > 1s", "It has: part direction level start end length"),
    ("a: r_arm high where a.«strat» > 1s", "Did you mean a.start?"),
    ("a: r_arm high where «a» > 1s", "What of it? a.start"),
    ("a: r_arm high where «start» > 1s", '"start" of what? match.start, a.start'),
    ("r_arm high where «clip» = 1", "What of it? clip.label"),
    ("r_arm high where «clip.» = 1", "A field follows: clip.label"),
    ("r_arm high «where»", "A condition goes here"),
    ("r_arm high where match.length < 1s «and»", "A condition goes here"),
    ("r_arm high where «match.length»", "Compared with what?"),
    ("r_arm high where match.length «<»", "A condition goes here"),
    ("r_arm high where «match.length < 2»", "2 what? 2s is seconds"),
    ("r_arm high where «match.margin > 0.5s»", "they cannot be compared"),
    ("r_arm high where match.length «==» 2s", 'One "=" is enough'),
    ("a: r_arm high where «a.direction < right»", "use = or !="),
    ("a: r_arm high where «a.direction = high»", "a.direction is a direction, high is a level"),
    ('a: r_arm high where «a.level = "high"»', "Take the quotation marks away: high"),
    ("a: r_arm where «a.level = bend»", "is a level, bend is a degree of bending"),
    ("a: turn where «a.degrees = circling»", "is a number, >=45deg is an angle"),
    ("a: turn where «a.part > circling»", "is a part, >=45deg is an angle"),
    ("r_arm bend «" + "9" * 5000 + "»", "A limb is bent by 0, straight, to 6 degrees"),
    ("«#speed=1/0» direction r_arm place high 0 1", "A speed is beats a minute"),
    ("«#speed=" + "9" * 5000 + "» direction r_arm place high 0 1", "A speed is beats a minute"),
    ("a: r_arm high where a.level = «rising»", "compares with the symbol before"),
    ("a: r_arm high where a.direction = «side»", "say right or left here"),
    ("a: r_arm high where a.direction = «any»", "nothing to compare"),
    ("a: r_arm high where a.part = «arm»", "r_arm or l_arm"),
    ('a: r_arm high where «a.part = "r_amr"»', 'Did you mean "r_arm"?'),
    ("a: r_arm high where «a.part < l_arm»", "use = or !="),
    ("r_arm high where clip.label = «wave»", 'clip.label = "wave"'),
    ('r_arm high where clip.label = «"wave»', "never closed"),
    ("r_arm high where «clip.label = high»", 'A text has quotation marks: "high"'),
    ("r_arm high where «1s < 2s»", "Neither side speaks of"),
    ("a: r_arm high where a.level + «1s» > 2s", "only times and numbers have a sum"),
    ("a: r_arm high where a.start - «1» > 2s", "1 what?"),
    ("a: r_arm high with b: l_arm where a mirrors «c»", 'There is no label "c". There is: a b'),
    ("a: r_arm high where a mirrors «a»", "Two labels: a mirrors b"),
    ("r_arm high where match.length < 1s «or» head", '"and" joins conditions'),
    ("r_arm high where match.length < 1s «with» head", '"where" ends the pattern'),
    ("r_arm high where match.length < 1s «where» match.start < 1s", '"where" stands once'),
    ("(r_arm high «where» match.length < 1s)", '"where" speaks of the whole pattern'),
    ("a: r_arm high where a.length > 1s «<» 2s", "One comparison in each condition"),
    ("a: r_arm high where a.level = high«/»mid", "A condition has one word"),
    ("a: r_arm high where a.direction «is» right", "Here goes =, !=,"),
    ("a: r_arm high where a.start «*» 2 > 1s", "Here goes =, !=,"),
    ("a: r_arm high where a.start «/» 2 > 1s", "Here goes =, !=,"),
    ("a: r_arm high where «not» a.level = high", "a.level != high"),
    ("a: r_arm high where «(»a.start > 1s)", "without brackets"),
    ("a: r_arm high where a.start > «-»1s", "0 or more"),
    ("a: r_arm high where clip.label = «'»wave'", "Double quotation marks"),
    ("a: r_arm high where a.«duration» > 1s", "Did you mean a.length?"),
    ('r_arm high where «label» = "wave"', '"label" of what? clip.label'),
    # Rhythm
    ("r_arm low -> high «rhythm»", "Numbers go here, one a step"),
    ("r_arm low -> high rhythm 1«:»", "Numbers go here"),
    ("r_arm low -> high «rhythm 1»", "two numbers or more"),
    ("r_arm low -> high rhythm 1:«0»", "No step lasts for nothing"),
    ("r_arm low -> high «rhythm 1:1:2»", "3 numbers, but the first line has 2 steps"),
    ("r_arm low x3+ «rhythm 1:2»", "the first line has 3 steps or more"),
    ("r_arm low -> mid? -> high «rhythm 1:1:1:1»", "has 2 to 3 steps"),
    ("(r_arm low «rhythm» 1:1)", '"rhythm" speaks of the whole pattern'),
    # Names
    ("r_arm low -> «@zzzzz»", 'There is no pattern "@zzzzz". A let before gives one its name'),
    ("let raise = mid -> high; r_arm low -> «@rise»", 'Did you mean "@raise"?'),
    ("r_arm low -> «@»", "The name of a pattern follows"),
    ("let «high» = mid; r_arm", "choose another name"),
    ("«let up» mid; r_arm", "An = follows"),
    ("«let up = mid -> high»", 'A ";" ends it, and the pattern follows'),
    ("let up = mid -> «hihg»; r_arm low -> @up", 'Did you mean "high"?'),
    ("let up = mid; let «up» = low; r_arm", "choose another name"),
    ("let up = low -> «@up»; r_arm -> @up", '"@up" speaks of itself'),
    (
        "let up = mid -> high; «@up»",
        "@up begins without a part. Let one carry into it: r_arm low -> @up",
    ),
    ("let up = side; head low -> «@up»", "@up: The head has no side of its own"),
    ("let up = a: mid; r_arm low -> @up -> «@up»", 'The label "a" stands once'),
    ("let up = a: mid; r_arm low -> («@up») x2", "inside a repeat"),
    ("r_arm low «let» up = mid; high", '"let" stands before the whole pattern'),
    ("r_arm low «;» r_arm high", 'A ";" ends a let'),
    ("r_arm low «@»up", "Something is missing before the name"),
    ("let up «=»; r_arm", 'Nothing after "="'),
    ("«@raise.lq»", "A pattern in a file stands alone"),
    # The pipe
    ("r_arm high | sort by match.start «desc»", "Behind a stage comes another one"),
    ("r_arm high | first 3 «hits»", "Behind a stage comes another one"),
    ("r_arm high | «count» clip.label", '"by" is missing: count by clip.label'),
    ("r_arm high «|»", 'A stage follows "|"'),
    ("r_arm high | «head»", 'A stage follows "|"'),
    ("r_arm high | «sort»", "By what? sort by match.start"),
    ("r_arm high | sort by «start»", "match.start"),
    ("r_arm high | sort by «fit»", "match.start, clip.label"),
    ("r_arm high | count by «label»", "clip.label"),
    ("r_arm high | count by «a».part", 'There is no label "a"'),
    ("r_arm high | «first»", "The first how many?"),
    ("r_arm high | «first 0»", "The first how many?"),
    ("r_arm high | count | «count»", 'only "first" may follow'),
    ("r_arm high | count by clip.label | «sort by match.start»", 'only "first" may follow'),
    ("(r_arm high «|» count)", "Stages stand behind the whole pattern"),
    ("r_arm high «count»", 'A "|" goes before count'),
    ("r_arm high «sort» by match.start", 'A "|" goes before sort'),
    ("«first» 3", 'A "|" goes before first'),
    # Lines of a score
    ("«direction r_arm» mid right 0 1", "five words behind direction"),
    ("«direction r_arm right mid 1»", "five words behind direction"),
    ("direction «arm» right mid 1 2", "LND names one part: r_arm or l_arm"),
    ("direction «tail» right mid 1 2", 'no part "tail"'),
    ("direction r_arm «rihgt» mid 1 2", 'Did you mean "right"?'),
    ("«direction r_arm right mid 2 1»", "before the start"),
    ("r_arm high «direction» r_arm right mid 1 2", "A line of LND stands where a step could"),
    ("«#unit1»", "A score without symbols"),
    ("«#untl1» direction r_arm place low 0 0", "No such heading"),
    ("#unit1 direction r_arm right mid 0 2 «direction r_arm right low 1 3»", "one at a time"),
    # Habits from elsewhere
    ("«^»r_arm low", '"start ->" is the beginning'),
    ("r_arm low «.»* high", '"..." leads to a later movement'),
    ("r_arm low«*»", '"x0+" is any number of times'),
    ("r_arm high«+»", '"x1+" is once or more'),
    ("r_arm high «{»2}", '"x2..3" is two or three times'),
    ("r_arm low | «r_arm» high", 'A stage follows "|"'),
    ("r_arm high «&» l_arm high", '"with" sets side by side'),
    ('r_arm high «clip».label = "wave"', "Conditions stand behind where"),
]


@pytest.mark.parametrize(("marked", "sentence"), ERRORS)
def test_an_error_points_at_its_place(marked: str, sentence: str):
    before, _, rest = marked.rpartition("«")
    place, _, after = rest.partition("»")
    before = before.replace("«", "").replace("»", "")
    text = before + place + after
    with pytest.raises(PatternError) as caught:
        parse(text)
    error = caught.value
    assert text[error.start : error.stop] == place
    assert error.start == len(before)
    assert sentence in error.found
    assert error.text == text


READ = {
    "r_arm high <0.05s": "r_arm high <0.05s",
    "r_arm high 010.500s": "r_arm high 10.5s",
    "r_arm high .5b..20f": "r_arm high 0.5b..20f",
    "right_arm high": "r_arm high",
    "Left Hand right -> left": "l_hand right -> left",
    "both arms high -> both_arms low": "arms high -> arms low",
    "either leg forward": "leg forward",
    "r_arm low -> right -> right arm high": "r_arm low -> right -> r_arm high",
    "mirror(right arm right)": "(l_arm left)",
}


@pytest.mark.parametrize("text", READ)
def test_what_is_read_in_other_words(text: str):
    assert str(parse(text)) == READ[text]


@pytest.mark.parametrize(
    ("text", "shown"),
    [
        ("r_arm " + "x" * 5000, "r_arm " + "x" * 90 + "…"),
        ("r_arm " + "high/" * 1000 + "high low", "…igh/high/high/high/high low"),
        ("l_arm low with " + "head -> " * 100 + "hihg" + " -> low" * 300, "-> hihg -> low ->"),
        ("r_arm high -> @" + "u" * 5000, "r_arm high -> @uuuuuuuu"),
        ("(r_arm low x2 x3" + " -> high" * 1000, "(r_arm low x2 x3 -> high"),
        ("r_arm not " + "low/" * 1000 + "mid/high", "…"),
    ],
    ids=lambda text: text[:20],
)
def test_an_error_shows_what_is_near(text: str, shown: str):
    with pytest.raises(PatternError) as caught:
        parse(text)
    line, caret, sentence = str(caught.value).split("\n")
    assert shown in line
    assert len(line) <= 98
    assert len(caret) <= len(line)
    assert len(sentence) < 240
    begin = caret.index("^")
    near = line[begin : len(caret)].rstrip("…")
    assert text[caught.value.start :].startswith(near)


def test_an_error_draws_a_caret():
    with pytest.raises(PatternError) as caught:
        parse("l_arm low\nwith r_arm rihgt mid")
    assert str(caught.value) == (
        'with r_arm rihgt mid\n           ^^^^^\nI don\'t know "rihgt". Did you mean "right"?'
    )


def test_a_part_that_neither_library_nor_alphabet_has():
    parts = ("l_arm", "head", "r_arm", "torso")
    for text in ("tail high", "head -> tail low", "l_tail high", "head with tails high"):
        with pytest.raises(PatternError) as caught:
            parse(text, parts)
        word = caught.value.text[caught.value.start : caught.value.stop]
        assert caught.value.found == (
            f'There is no part "{word}". The parts are: head torso l_arm r_arm'
        )
    assert parse("tails low -> l_tail high", ("r_tail", "l_tail")).parts == {"r_tail", "l_tail"}


@pytest.mark.parametrize("held", [(), ("l_arm",), ("r_tail",)])
def test_a_part_of_the_alphabet_is_never_unknown(held):
    for part in TRACKS:
        assert parse(f"{part} any", held) == parse(f"{part} any")
    for text in ("arm high never turn", "arm high without hands touch", "r_palm high with leg low"):
        assert parse(text, held) == parse(text)


def test_every_part_of_the_alphabet_can_be_named():
    vocabulary = Vocabulary()
    assert {"arm", "arms", "feet", "support", "supports", "upper_arms"} <= set(vocabulary.movers)
    for name, mover in vocabulary.movers.items():
        assert parse(f"{name} any").parts == set(mover.members)


_SOUP = [
    *VALUES,
    *LANGUAGE,
    *("r_arm", "l_arm", "arm", "arms", "head", "feet", "tail", "rihgt", "x2", "x3+", "x0", "x"),
    *("->", "->", "...", "→", "(", ")", "[", "]", "[<2s]", "[2]", "/", "?", ":", ";", "@", "|"),
    *("<1s", ">=", "1s..2s", "2s+", "..", "+", "-", "=", "!=", ".", ",", '"', '"a"', "//", "\n"),
    *("2", "2s", "0.5", "99f", "ms", "b", "side", "either side", "starting with", "mirror("),
    *("é", "\x00", "\t", "ß", "İ", "٣", "٣s", "x٣", "²", "🙂", "{", "}", "\\", "`", "a:", "@up"),
]


def outcome(text: str) -> Query | PatternError:
    try:
        return parse(text)
    except PatternError as error:
        return error


def check(text: str) -> None:
    """A text is understood, and then printed so that it is again; or it is a PatternError."""
    found = outcome(text)
    if isinstance(found, Query):
        assert parse(str(found)) == found
    else:
        assert 0 <= found.start <= found.stop <= len(text)
        assert found.found
        assert str(found).count("\n") == 2


@examples(600)
@given(st.lists(st.sampled_from(_SOUP), max_size=14), st.sampled_from(["", " "]))
@example(["right", "\n", ":"], "")
@example(["r_arm", "x2", "\n", "x3"], " ")
def test_any_soup_of_tokens_is_a_query_or_an_error(words, space):
    check(space.join(words))


@examples(200)
@given(st.text(max_size=40))
def test_any_text_is_a_query_or_an_error(text):
    check(text)


@pytest.mark.parametrize(
    "text",
    [
        "(" * 100_000,
        "r_arm high -> " * 20_000,
        "r_arm " + "not low " * 20_000,
        "r_arm " + "high/" * 50_000 + "high",
        "mirror(" * 100_000,
        "r_arm high" + " with l_arm" * 20_000,
        "r_arm high" + " or l_arm" * 20_000,
        "x" * 1_000_000,
        "9" * 1_000_000 + "s",
        "r_arm high x" + "9" * 1_000_000,
        "let a = " * 20_000,
        "let a = r_arm high; " * 20_000,
        "let a = r_arm high; @a" + " -> @a" * 20_000,
        "r_arm high where " + "match.start > 1s and " * 20_000,
        "r_arm high where match.start > 1s" + " + 1s" * 40_000,
        "r_arm high rhythm 1" + ":1" * 60_000,
        "r_arm high" + " | first 1" * 20_000,
        "direction r_arm right mid 0 1 " * 10_000,
        "#unit1 " * 20_000,
        "r_arm low" + " after[<1s] head" * 20_000,
    ],
    ids=lambda text: text[:20],
)
def test_endless_texts_come_to_an_end(text):
    check(text[:10_000])
    with pytest.raises(PatternError, match="10000 is the most"):
        parse(text)


def test_how_long_a_pattern_may_be():
    text = "r_arm high//"
    assert str(parse(text + "x" * (10_000 - len(text)))) == "r_arm high"
    with pytest.raises(PatternError, match="A pattern of 10001 characters; 10000 is the most"):
        parse(text + "x" * (10_001 - len(text)))


def test_what_is_said_where_nothing_is_like_a_word():
    with pytest.raises(PatternError) as caught:
        parse("r_arm qqq")
    assert caught.value.found == (
        'I don\'t know "qqq". A movement has a direction (right, r_forward, forward, l_forward …) '
        "and a level (high, mid, low)."
    )


def test_every_rule_has_a_sentence_and_is_named_somewhere(repository):
    folder = repository / "lanindex" / "search" / "language"
    rules = shipped("search/language/remedies.toml")["rules"]
    source = "".join(path.read_text() for path in folder.glob("*.py"))
    used = {literal for literal in re.findall(r'"([^"\n]+)"', source) if literal in rules}
    assert used == rules.keys()
    assert set(re.findall(r'\.fault\(\s*"([^"]+)"', source)) <= rules.keys()


@pytest.mark.slow
@examples(5_000)
@given(st.lists(st.sampled_from(_SOUP), max_size=25), st.sampled_from(["", " "]))
def test_many_soups(words, space):
    check(space.join(words))


@pytest.mark.parametrize(
    ("text", "instead"),
    [
        ("r_arm hgih -> low", "r_arm high -> low"),
        ("r_amr high", "r_arm high"),
        ("raise the right arm", "r_arm high"),
        ("r_arm high ->", ""),
    ],
)
def test_what_was_meant_is_a_whole_pattern(text: str, instead: str) -> None:
    with pytest.raises(PatternError) as caught:
        parse(text)
    record = records.of_error(pickle.loads(pickle.dumps(caught.value)))
    assert record["instead"] == instead
    assert record["text"] == text
    assert 0 <= record["start"] <= record["stop"] <= len(text)
    assert not instead or parse(instead)


def test_an_empty_part_is_refused() -> None:
    with pytest.raises(PatternError, match="There is no part"):
        parse('a: r_arm where a.part = ""')
