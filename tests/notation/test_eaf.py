"""ELAN files: valid by schema and pympi, extended without changing what is there."""

from itertools import pairwise
from pathlib import Path
from xml.etree import ElementTree

import pytest
from effort import examples
from hypothesis import given
from pympi.Elan import Eaf
from random_scores import scores

import lanindex
from lanindex.errors import ExportError, LanindexError, NotationError
from lanindex.model import Score
from lanindex.notation import eaf
from lanindex.notation.tiers import TierEntry

LND = """\
#unit0
direction r_arm place low 0 0
twist torso_twist place 0 0 0
#unit1
direction r_arm right mid 0 1.5
direction r_arm place high 2 2.25
rotation body_turn left 90 1 2
direction r_arm back low 3 3
"""

OTHERS = """\
<?xml version="1.0" encoding="UTF-8"?>
<ANNOTATION_DOCUMENT AUTHOR="A" DATE="2020-01-01T12:00:00+01:00" FORMAT="3.0" VERSION="3.0"
    xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance"
    xsi:noNamespaceSchemaLocation="http://www.mpi.nl/tools/elan/EAFv3.0.xsd">
    <HEADER MEDIA_FILE="" TIME_UNITS="milliseconds">
        <MEDIA_DESCRIPTOR MEDIA_URL="file:///v.mp4" MIME_TYPE="video/mp4" TIME_ORIGIN="5"/>
        <PROPERTY NAME="lastUsedAnnotationId">7</PROPERTY>
    </HEADER>
    <TIME_ORDER>
        <TIME_SLOT TIME_SLOT_ID="ts1" TIME_VALUE="100"/>
        <TIME_SLOT TIME_SLOT_ID="ts2"/>
        <TIME_SLOT TIME_SLOT_ID="ts3" TIME_VALUE="1900"/>
    </TIME_ORDER>
    <TIER LINGUISTIC_TYPE_REF="speech" PARTICIPANT="Ada" TIER_ID="words &amp; all">
        <ANNOTATION>
            <ALIGNABLE_ANNOTATION ANNOTATION_ID="a1" TIME_SLOT_REF1="ts1" TIME_SLOT_REF2="ts3">
                <ANNOTATION_VALUE>  and &lt;one&gt; é </ANNOTATION_VALUE>
            </ALIGNABLE_ANNOTATION>
        </ANNOTATION>
        <!-- by hand -->
    </TIER>
    <TIER LINGUISTIC_TYPE_REF="gloss" PARENT_REF="words &amp; all" TIER_ID="gloss">
        <ANNOTATION>
            <REF_ANNOTATION ANNOTATION_ID="a7" ANNOTATION_REF="a1">
                <ANNOTATION_VALUE/>
            </REF_ANNOTATION>
        </ANNOTATION>
    </TIER>
    <LINGUISTIC_TYPE GRAPHIC_REFERENCES="false" LINGUISTIC_TYPE_ID="speech" TIME_ALIGNABLE="true"/>
    <LINGUISTIC_TYPE CONSTRAINTS="Symbolic_Association" GRAPHIC_REFERENCES="false"
        LINGUISTIC_TYPE_ID="gloss" TIME_ALIGNABLE="false"/>
    <CONSTRAINT DESCRIPTION="1-1" STEREOTYPE="Symbolic_Association"/>
</ANNOTATION_DOCUMENT>
""".encode()

SCHEMA = {
    "ANNOTATION_DOCUMENT": (
        "LICENSE* HEADER TIME_ORDER TIER* LINGUISTIC_TYPE* LOCALE* LANGUAGE* CONSTRAINT* "
        "CONTROLLED_VOCABULARY* LEXICON_REF* REF_LINK_SET* EXTERNAL_REF*",
        "AUTHOR DATE VERSION",
        "FORMAT",
    ),
    "HEADER": ("MEDIA_DESCRIPTOR* LINKED_FILE_DESCRIPTOR* PROPERTY*", "", "MEDIA_FILE TIME_UNITS"),
    "MEDIA_DESCRIPTOR": ("", "MEDIA_URL MIME_TYPE", "RELATIVE_MEDIA_URL TIME_ORIGIN"),
    "PROPERTY": ("", "", "NAME"),
    "TIME_ORDER": ("TIME_SLOT*", "", ""),
    "TIME_SLOT": ("", "TIME_SLOT_ID", "TIME_VALUE"),
    "TIER": (
        "ANNOTATION*",
        "TIER_ID LINGUISTIC_TYPE_REF",
        "PARTICIPANT ANNOTATOR DEFAULT_LOCALE PARENT_REF EXT_REF LANG_REF",
    ),
    "ALIGNABLE_ANNOTATION": (
        "ANNOTATION_VALUE",
        "ANNOTATION_ID TIME_SLOT_REF1 TIME_SLOT_REF2",
        "SVG_REF EXT_REF LANG_REF CVE_REF",
    ),
    "REF_ANNOTATION": ("ANNOTATION_VALUE", "ANNOTATION_ID ANNOTATION_REF", "PREVIOUS_ANNOTATION"),
    "ANNOTATION_VALUE": ("", "", ""),
    "LINGUISTIC_TYPE": (
        "",
        "LINGUISTIC_TYPE_ID",
        "TIME_ALIGNABLE CONSTRAINTS GRAPHIC_REFERENCES CONTROLLED_VOCABULARY_REF EXT_REF",
    ),
    "CONSTRAINT": ("", "STEREOTYPE", "DESCRIPTION"),
}
"""Of EAFv3.0, by element: its children in order, the attributes it must and may have."""


def assert_valid(content: bytes) -> None:
    """Hold a file against the schema, with the references that it asks for."""
    root = ElementTree.fromstring(content)
    for one in root.iter():
        if one.tag == "ANNOTATION":
            assert [it.tag in ("ALIGNABLE_ANNOTATION", "REF_ANNOTATION") for it in one] == [True]
            continue
        children, needed, allowed = (words.split() for words in SCHEMA[one.tag])
        order = [it.rstrip("*") for it in children]
        places = [order.index(child.tag) for child in one]
        assert places == sorted(places), one.tag
        for name in order:
            often = sum(child.tag == name for child in one)
            assert often == 1 or f"{name}*" in children, name
        own = {name for name in one.attrib if not name.startswith("{")}
        assert set(needed) <= own <= {*needed, *allowed}, one.tag
    ids = [it.get(name) for it in root.iter() for name in ("TIME_SLOT_ID", "ANNOTATION_ID")
           if it.get(name)]  # fmt: skip
    assert len(ids) == len(set(ids))
    slots = {it.get("TIME_SLOT_ID"): it.get("TIME_VALUE") for it in root.iter("TIME_SLOT")}
    types = {it.get("LINGUISTIC_TYPE_ID") for it in root.iter("LINGUISTIC_TYPE")}
    names = [it.get("TIER_ID") for it in root.iter("TIER")]
    assert len(names) == len(set(names))
    for tier in root.iter("TIER"):
        assert tier.get("LINGUISTIC_TYPE_REF") in types
        for one in tier.iter("ALIGNABLE_ANNOTATION"):
            times = [slots[one.get(f"TIME_SLOT_REF{end}")] for end in (1, 2)]
            assert None in times or int(times[0]) < int(times[1])
    values = [int(value) for value in slots.values() if value is not None]
    assert all(a <= b for a, b in pairwise(values))


def opened(content: bytes, folder: Path) -> Eaf:
    path = folder / "x.eaf"
    path.write_bytes(content)
    return Eaf(str(path))


@given(scores())
@examples(40)
def test_every_file_is_as_the_schema_wants_it(score: Score) -> None:
    if score.rate <= 1000:
        for into in (None, OTHERS):
            content = eaf.write(score, into=into)
            assert_valid(content)
            assert_valid(eaf.write(score, into=content, force=True))


def test_pympi_reads_it(tmp_path: Path) -> None:
    found = opened(eaf.write(lanindex.read_lnd(LND)), tmp_path)
    assert list(found.get_tier_names()) == ["r_arm", "body_turn", "torso_twist"]
    assert found.get_annotation_data_for_tier("r_arm") == [
        (0, 1500, "right mid"),
        (2000, 2250, "place high"),
    ]
    assert found.get_annotation_data_for_tier("body_turn") == [(1000, 2000, "left 90deg")]
    assert ("lanindex.starts.r_arm", "0 place low; 3000 back low") in found.properties
    again = tmp_path / "again.eaf"
    found.to_file(str(again))
    assert lanindex.write_lnd(eaf.read(again.read_bytes(), "x")) == lanindex.write_lnd(
        lanindex.read_lnd(LND)
    )


def test_the_date_can_be_told(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "0")
    assert b'DATE="1970-01-01T00:00:00+00:00"' in eaf.write(lanindex.read_lnd(LND))
    for wrong in ("", "today", "9" * 30):
        monkeypatch.setenv("SOURCE_DATE_EPOCH", wrong)
        assert b'DATE="20' in eaf.write(lanindex.read_lnd(LND))


def test_a_recording(tmp_path: Path) -> None:
    content = eaf.write(lanindex.read_lnd(LND), media=tmp_path / "Tänze 1.mp4")
    assert_valid(content)
    (media,) = opened(content, tmp_path).media_descriptors
    assert media["MEDIA_URL"].endswith("/T%C3%A4nze%201.mp4")
    assert media["MIME_TYPE"] == "video/mp4"


def other_tiers(content: bytes) -> list[str]:
    root = ElementTree.fromstring(content)
    tiers = [it for it in root.iter("TIER") if it.get("LINGUISTIC_TYPE_REF") != eaf.TYPE]
    return [ElementTree.canonicalize(ElementTree.tostring(it), strip_text=False).strip()
            for it in tiers]  # fmt: skip


def test_other_tiers_stay(tmp_path: Path) -> None:
    content = eaf.write(lanindex.read_lnd(LND), into=OTHERS, media=tmp_path / "v.wav")
    assert_valid(content)
    assert other_tiers(content) == other_tiers(OTHERS)
    assert b"<!-- by hand -->" in content
    assert b"  and &lt;one&gt; \xc3\xa9 </ANNOTATION_VALUE>" in content
    found, before = opened(content, tmp_path), opened(OTHERS, tmp_path)
    for tier in before.get_tier_names():
        assert found.get_annotation_data_for_tier(tier) == before.get_annotation_data_for_tier(tier)
    order = [
        (it.get("TIME_SLOT_ID") in ("ts1", "ts2", "ts3"), it.get("TIME_VALUE"))
        for it in ElementTree.fromstring(content).iter("TIME_SLOT")
    ]
    assert order == [
        *((False, "0"), (True, "100"), (True, None), (False, "1000"), (False, "1500")),
        *((True, "1900"), (False, "2000"), (False, "2000"), (False, "2250")),
    ]
    names = [it.get("ANNOTATION_ID") for it in ElementTree.fromstring(content).iter()]
    assert min(int(name[1:]) for name in names if name and name not in ("a1", "a7")) > 7
    score = eaf.read(content, "x")
    assert score.warnings == (
        'the tier "words & all" is no part of the body: left out',
        'the tier "gloss" is no part of the body: left out',
    )
    assert lanindex.write_lnd(score) == lanindex.write_lnd(lanindex.read_lnd(LND))


def test_a_tier_that_is_there_is_replaced_only_when_told() -> None:
    first = eaf.write(lanindex.read_lnd(LND), into=OTHERS)
    other = lanindex.read_lnd("#unit1\ndirection r_arm left mid 0 1\n")
    with pytest.raises(ExportError, match=r"has a tier r_arm already, wanted none\. --force"):
        eaf.write(other, into=first)
    content = eaf.write(other, into=first, force=True)
    assert_valid(content)
    assert other_tiers(content) == other_tiers(OTHERS)
    assert [str(it) for it in eaf.read(content, "x").symbols()] == [
        "r_arm left mid [0, 8)",
        "body_turn left 90deg [8, 16)",
        "torso_twist place [0, 0)",
    ]
    slots, used = (set(it) for it in _slots(content))
    assert slots - used == {"ts2"}


def _slots(content: bytes) -> tuple[list[str], list[str]]:
    root = ElementTree.fromstring(content)
    used = [it.get(f"TIME_SLOT_REF{end}", "") for it in root.iter() for end in (1, 2)]
    return [it.get("TIME_SLOT_ID", "") for it in root.iter("TIME_SLOT")], used


def test_tiers_made_by_hand(tmp_path: Path) -> None:
    made = Eaf(author="hand")
    made.remove_tier("default")
    for tier in ("r_arm", "head", "l_leg", "step"):
        made.add_tier(tier)
    made.add_annotation("r_arm", 1000, 2000, "Right  HIGH bent 3")
    made.add_annotation("head", 0, 500, "nod")
    path = tmp_path / "hand.eaf"
    made.to_file(str(path))
    score = eaf.read(path.read_bytes(), "hand.eaf")
    assert [str(it) for it in score.symbols()] == ["r_arm right high bent 3 [8, 16)"]
    assert sorted(score.warnings) == [
        'the tier "head" is left out: "nod" is no symbol',
        'the tier "step" is no part of the body: left out',
    ]


def test_a_limb_is_bent_as_its_own_words_say() -> None:
    text = "#unit1\ndirection r_arm right mid 0 2\ndirection r_arm left mid 2 3\n"
    own = eaf.write(lanindex.read_lnd(text + "bend r_arm_bend bend3 0 1.9\n"))
    assert [it.amount for it in eaf.read(own, "x").symbols("r_arm")] == [3, 3]
    changed = own.replace(b"right mid bent 3", b"right mid bent 2")
    changed = changed.replace(b"left mid bent 3", b"left mid")
    assert [it.amount for it in eaf.read(changed, "x").symbols("r_arm")] == [2, 1]


def test_a_starting_position_under_an_annotation_is_left_out() -> None:
    content = eaf.write(lanindex.read_lnd(LND)).replace(b"3000 back", b"2100 back")
    score = eaf.read(content, "x.eaf")
    said = "r_arm: a starting position at 2.1 s is left out, an annotation lies over it"
    assert score.warnings == (said,)


GOOD = eaf.write(lanindex.read_lnd(LND))


@pytest.mark.parametrize(
    ("content", "said"),
    [
        (b"", "x.eaf:1: damaged XML (no element found), wanted a whole file"),
        (GOOD[:-9], "damaged XML"),
        (b"#speed=60\n#unit1\n", "x.eaf:1: damaged XML (not well-formed"),
        (b"<a/>", "x.eaf: XML of <a>, wanted <ANNOTATION_DOCUMENT>"),
        (b"<ANNOTATION_DOCUMENT/>", "no header or no time slots, wanted an ELAN file"),
        (b"<!DOCTYPE x [<!ENTITY a 'aa'>]><x>&a;</x>", "x.eaf:1: a DTD, wanted XML without one"),
        (b"<!DOCTYPE x SYSTEM 'file:///etc/passwd'><x/>", "x.eaf:1: a DTD"),
        (b"<a>" * 200, "x.eaf:1: more than 100 elements inside each other"),
        (GOOD.replace(b"UTF-8", b"latin-13"), "unknown encoding"),
        (GOOD.replace(b"right mid", b"right \xff"), "damaged XML (not well-formed"),
        (GOOD.replace(b"milliseconds", b"PAL-frames", 1), "times in PAL-frames, wanted millisec"),
        (
            GOOD.replace(b"right mid", b"rihgt mid"),
            'x.eaf: r_arm at 0 s: "rihgt mid", wanted right',
        ),
        (GOOD.replace(b"right mid", b"right"), 'r_arm at 0 s: "right", wanted low mid high'),
        (GOOD.replace(b"right mid", b""), 'r_arm at 0 s: "", wanted right r_forward'),
        (GOOD.replace(b"right mid", b"right mid now"), 'mid now", wanted no more than direction'),
        (GOOD.replace(b"90deg", b"90"), 'body_turn at 1 s: "left 90", wanted degrees at its end'),
        (GOOD.replace(b"90deg", b"90000deg"), "like 90deg, at most 32766"),
        (GOOD.replace(b'"1500"', b'"-500"'), '"right mid" at 0--500, wanted times in milliseconds'),
        (GOOD.replace(b'"1500"', b'"0"'), '"right mid" from 0 to 0 s, wanted an end behind its'),
        (GOOD.replace(b'"1500"', b'"2100"'), "r_arm at 2 s: begins before what begins at 0 s is"),
        (GOOD.replace(b'TIME_VALUE="1500"', b""), '"right mid" at 0-, wanted times'),
        (GOOD.replace(b'"2250"', b'"86400001"'), "wanted at most 24 hours"),
        (GOOD.replace(b"3000 back", b"x back"), 'the starting position "x back low", wanted one'),
        (GOOD.replace(b'D="r_arm"', b'D="R Arm"'), 'the part "R Arm"'),
    ],
)
def test_what_is_wrong_is_said(content: bytes, said: str) -> None:
    assert content != GOOD
    with pytest.raises(NotationError) as caught:
        eaf.read(content, "x.eaf")
    assert said in str(caught.value)


def test_a_file_without_our_tiers_holds_no_score() -> None:
    with pytest.raises(NotationError, match="no tier of a part of the body, wanted one of the"):
        eaf.read(OTHERS, "x.eaf")


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ((b'TIER_ID="words &amp; all"', b'TIER_ID="r_arm"'), "has a tier r_arm already"),
        ((b'PARENT_REF="words &amp; all"', b'PARENT_REF="r_arm"'), '"gloss" hangs on r_arm'),
        ((b'TYPE_ID="gloss"', b'TYPE_ID="labanotation"'), "bound to a parent"),
        ((b"</TIER>", b""), "damaged XML"),
    ],
)
def test_what_cannot_be_added_to(change: tuple[bytes, bytes], said: str) -> None:
    into = OTHERS.replace(*change)
    force = "hangs" in said
    if force:
        into = into.replace(b'TIER_ID="words &amp; all"', b'TIER_ID="r_arm"')
    with pytest.raises(LanindexError, match=said):
        eaf.write(lanindex.read_lnd(LND), into=into, force=force)


def test_other_encodings() -> None:
    text = GOOD.decode().replace("UTF-8", "UTF-16")
    assert lanindex.write_lnd(eaf.read(text.encode("utf-16"), "x")) == lanindex.write_lnd(
        eaf.read(GOOD, "x")
    )


HITS = [TierEntry("r_arm high 0.50", 2000, 2500), TierEntry("r_arm high 1.00", 100, 900)]


def test_a_tier_of_hits(tmp_path: Path) -> None:
    content = eaf.mark(OTHERS, "found & kept", HITS, place="x")
    assert_valid(content)
    assert other_tiers(content)[:2] == other_tiers(OTHERS)
    assert opened(content, tmp_path).get_annotation_data_for_tier("found & kept") == [
        (100, 900, "r_arm high 1.00"),
        (2000, 2500, "r_arm high 0.50"),
    ]
    with pytest.raises(
        ExportError, match=r"has a tier found & kept already, wanted none\. --force"
    ):
        eaf.mark(content, "found & kept", HITS, place="x")
    again = eaf.mark(content, "found & kept", HITS[:1], place="x", force=True)
    assert_valid(again)
    assert len(opened(again, tmp_path).get_annotation_data_for_tier("found & kept")) == 1
    both = eaf.write(lanindex.read_lnd(LND), into=content)
    assert_valid(both)
    assert "hits" not in str(eaf.read(both, "x").tracks.keys())


@pytest.mark.parametrize(
    ("into", "tier", "entries", "said"),
    [
        (OTHERS, "r_arm", HITS, 'the tier "r_arm", wanted a name that can be read, and no part'),
        (OTHERS, " ", HITS, "wanted a name that can be read"),
        (OTHERS, "\x1b", HITS, "wanted a name that can be read"),
        (OTHERS, "words & all", HITS, "has a tier words & all already"),
        (
            OTHERS,
            "a",
            [*HITS, TierEntry("b", 800, 950)],
            "x: a: what begins at 0.1 and 0.8 s shares",
        ),
        (OTHERS[:-20], "a", HITS, "damaged XML"),
    ],
)
def test_hits_that_no_tier_takes(
    into: bytes, tier: str, entries: list[TierEntry], said: str
) -> None:
    with pytest.raises(LanindexError) as caught:
        eaf.mark(into, tier, entries, place="x")
    assert said in str(caught.value)


def test_a_tier_on_which_another_hangs() -> None:
    with pytest.raises(ExportError, match='the tier "gloss" hangs on words & all'):
        eaf.mark(OTHERS, "words & all", HITS, place="x", force=True)
