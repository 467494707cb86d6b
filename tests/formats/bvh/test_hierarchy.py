"""Valid and invalid hierarchies."""

import pytest
from bvh_bodies import SIMPLE, hierarchy, person, still

from lanindex import formats
from lanindex.errors import CaptureError
from lanindex.formats.bvh import parse

MINIMAL = """HIERARCHY
ROOT Hips
{
  OFFSET 1 2 3
  CHANNELS 6 Xposition Yposition Zposition Zrotation Xrotation Yrotation
  JOINT Spine
  {
    OFFSET 0.0 10 -1e-1
    CHANNELS 3 Zrotation Yrotation Xrotation
    End Site
    {
      OFFSET 0 5 0
    }
  }
}
MOTION
"""


def read(text: str):
    return parse(text.encode(), "walk.bvh")


def test_a_small_hierarchy():
    joints, behind = read(MINIMAL)
    assert joints.names == ("Hips", "Spine", "Spine End")
    assert joints.parents == (-1, 0, 1)
    assert joints.offsets == ((1, 2, 3), (0, 10, -0.1), (0, 5, 0))
    assert joints.channels == ((0, 1, 2, 5, 3, 4), (5, 4, 3), ())
    assert joints.width == 9
    assert MINIMAL[:behind].endswith("MOTION")


@pytest.mark.parametrize(
    "change",
    [
        lambda text: text.replace("\n", "\r\n"),
        lambda text: text.replace("\n", "\r"),
        lambda text: text.replace("  ", "\t"),
        lambda text: text.replace("Hips\n{", "Hips {").replace("Site\n", "Site"),
        lambda text: text.lower().replace("hips", "Hips").replace("spine", "Spine"),
        lambda text: text.upper().replace("HIPS", "Hips").replace("SPINE", "Spine"),
        lambda text: "\ufeff" + text,
        lambda text: "\n\n " + text.replace("\n", " \n\n"),
        lambda text: text.replace("Yrotation\n", "Yrotation "),
        lambda text: " ".join(text.split()),
    ],
)
def test_layouts_that_mean_the_same(change):
    assert read(change(MINIMAL))[0] == read(MINIMAL)[0]


@pytest.mark.parametrize("name", ["Bip01 L UpperArm", "TORSO#", "a:b|c", "左ひじ", "J-1.2", "Root"])
def test_names_as_they_are(name):
    assert read(MINIMAL.replace("Spine", name))[0].names == ("Hips", name, f"{name} End")


def test_names_that_are_not_utf8():
    data = MINIMAL.encode().replace(b"Spine", b"H\xfcfte")
    assert parse(data)[0].names[1] == "Hüfte"


def test_end_sites_get_names_of_their_own():
    text = MINIMAL.replace("End Site", "End Site\n{\nOFFSET 1 1 1\n}\nEnd Site")
    assert read(text)[0].names == ("Hips", "Spine", "Spine End", "Spine End 2")
    text = MINIMAL.replace("ROOT Hips", "ROOT Spine End")
    assert read(text)[0].names == ("Spine End", "Spine", "Spine End 2")


def test_several_roots():
    second = MINIMAL.replace("HIERARCHY", "").replace("Hips", "Other").replace("Spine", "Thing")
    joints, _ = read(MINIMAL.replace("MOTION\n", "") + second)
    assert joints.parents == (-1, 0, 1, -1, 3, 4)


def test_a_joint_without_channels_stands_still():
    text = MINIMAL.replace("CHANNELS 3 Zrotation Yrotation Xrotation", "")
    assert read(text)[0].channels[1] == ()


def test_depth_and_width():
    deep = "".join(f"JOINT j{k} {{ OFFSET 0 1 0 CHANNELS 0 " for k in range(5000)) + "}" * 5000
    assert len(read(MINIMAL.replace("End Site", deep + " End Site"))[0].names) == 5003
    wide = "".join(f"JOINT j{k} {{ OFFSET 0 1 0 CHANNELS 0 }}\n" for k in range(10000))
    assert len(read(MINIMAL.replace("End Site", wide + "End Site"))[0].names) == 10003


BROKEN = {
    "no name": ("ROOT Hips", "ROOT", 2, "'ROOT'", "a name and {"),
    "no brace": ("Hips\n{", "Hips\n", 2, "'ROOT Hips'", "{"),
    "two numbers": ("OFFSET 1 2 3", "OFFSET 1 2", 4, "OFFSET of Hips is '1 2 CHANNELS'", "three"),
    "a word": ("OFFSET 1 2 3", "OFFSET 1 x 3", 4, "OFFSET of Hips is '1 x 3'", "three"),
    "nan": ("OFFSET 1 2 3", "OFFSET 1 nan 3", 4, "OFFSET of Hips is '1 nan 3'", "finite"),
    "huge": ("OFFSET 1 2 3", "OFFSET 1 1e300 3", 4, "OFFSET of Hips is '1 1e300 3'", "finite"),
    "underscore": ("OFFSET 1 2 3", "OFFSET 1_0 2 3", 4, "'1_0 2 3'", "finite"),
    "no offset": ("OFFSET 0 5 0", "", 13, "the End Site of Spine has no OFFSET", "one a joint"),
    "too few channels": ("CHANNELS 3", "CHANNELS 4", 9, "says 4 and names 3", "as many"),
    "too many channels": ("CHANNELS 3", "CHANNELS 2", 9, "says 2 and names 3", "as many"),
    "unknown channel": ("Zrotation Yr", "Wrotation Yr", 9, "of Spine says 3 and names 0", "Zrot"),
    "no count": ("CHANNELS 3", "CHANNELS", 9, "'CHANNELS Zrotation", "how many"),
    "duplicate": ("Spine", "Hips", 6, "a second joint named 'Hips', the first is joint 1", "own"),
    "joint as root": ("ROOT", "JOINT", 2, "JOINT outside any ROOT", "ROOT"),
    "root as joint": ("JOINT", "ROOT", 6, "ROOT inside a joint", "JOINT"),
    "stray brace": ("HIERARCHY", "HIERARCHY }", 1, "} outside any joint", "ROOT"),
    "not closed": ("}\nMOTION", "MOTION", 15, "MOTION before the } of Hips", "}"),
    "closed twice": ("}\nMOTION", "}\n}\nMOTION", 16, "} outside any joint", "ROOT"),
    "offset outside": ("ROOT", "OFFSET 1 2 3 ROOT", 2, "OFFSET outside any joint", "ROOT"),
    "channels outside": ("ROOT", "CHANNELS 0 ROOT", 2, "CHANNELS outside any joint", "ROOT"),
    "end outside": ("ROOT Hips", "End Site", 2, "End Site outside any joint", "ROOT"),
    "joint in an end": ("OFFSET 0 5 0", "OFFSET 0 5 0 JOINT a { }", 12, "inside an End", "only"),
    "nonsense": ("OFFSET 1 2 3", "OFSET 1 2 3", 4, "'OFSET 1 2 3' in Hips", "OFFSET"),
    "not a hierarchy": ("HIERARCHY", "HIERARCHIE", 1, "'HIERARCHIE'", "HIERARCHY"),
}


@pytest.mark.parametrize("case", BROKEN)
def test_broken_hierarchies_name_their_line(case):
    old, new, line, found, wanted = BROKEN[case]
    assert old in MINIMAL
    with pytest.raises(CaptureError) as caught:
        read(MINIMAL.replace(old, new, 1))
    assert caught.value.place == f"walk.bvh:{line}"
    assert found in caught.value.found
    assert wanted in caught.value.wanted


def test_no_joints_at_all():
    with pytest.raises(CaptureError, match="a hierarchy without joints"):
        read("HIERARCHY\nMOTION\n")


def test_more_joints_than_an_index_can_hold():
    many = "".join(f"JOINT j{k} {{ OFFSET 0 1 0 }}\n" for k in range(32_000))
    with pytest.raises(CaptureError, match="more than 32000 joints"):
        read(MINIMAL.replace("End Site", many + "End Site"))


def test_cut_anywhere_says_so():
    text = hierarchy().removesuffix("\n") + "\n"
    for cut in range(0, len(text), 7):
        with pytest.raises(CaptureError) as caught:
            read(text[:cut])
        assert caught.value.place.startswith("walk.bvh:")
        assert caught.value.wanted


def test_the_last_line_is_named_where_a_file_is_cut():
    text = person().decode()
    cut = text.index("JOINT LHip")
    with pytest.raises(CaptureError) as caught:
        read(text[:cut])
    assert str(caught.value).startswith(f"walk.bvh:{text[:cut].count(chr(10)) + 1}: the file ends")
    assert "cut short" in caught.value.remedy


def test_wrists_without_channels_are_read() -> None:
    roles = {role: role for role in SIMPLE if "Hand" not in role}
    text = hierarchy(roles).split("\n")
    for number, line in enumerate(text):
        if line.endswith("Wrist"):
            text[number + 3] = "CHANNELS 0"
    data = still("\n".join(text)).encode()
    assert len(formats.read("x.bvh", data=data)) == 3
