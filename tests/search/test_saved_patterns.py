"""Patterns in files."""

import pickle
from pathlib import Path

import pytest

import lanindex
from lanindex.errors import NotationError, PatternError
from lanindex.notation import NOTATIONS, WRITTEN, write
from lanindex.search.language import parse
from lanindex.search.language.score import pattern_in


def test_a_pattern_in_a_file(tmp_path: Path):
    path = tmp_path / "raise.lq"
    path.write_bytes("\ufeff// up\r\nlet up = mid -> high;\r\nr_arm low\r\n  -> @up\r\n".encode())
    assert str(parse(pattern_in(f"@{path}"))) == "r_arm low -> (mid -> high)"
    assert str(parse(pattern_in("@raise.lq", tmp_path))) == "r_arm low -> (mid -> high)"


def test_a_score_in_a_file(tmp_path: Path):
    score = "#unit0\ndirection r_arm place low 0 0\n#unit1\ndirection r_arm right high 1 2\n"
    (tmp_path / "up.lnd").write_text(score)
    assert str(parse(pattern_in("@up.lnd", tmp_path))) == "r_arm place low -> right high"


@pytest.mark.parametrize("name", [name for name in WRITTEN if not NOTATIONS[name].parts])
def test_a_score_in_any_notation(tmp_path: Path, name: str):
    score = lanindex.read_lnd("#unit0\ndirection r_arm place low 0 0\n#unit1\n"
                              "direction r_arm right high 1 2\n")  # fmt: skip
    (tmp_path / f"up.{name}").write_bytes(write(score, name))
    assert str(parse(pattern_in(f"@up.{name}", tmp_path))) == "r_arm place low -> right high"
    (tmp_path / "bad.eaf").write_text("<a/>")
    with pytest.raises(NotationError, match="XML of <a>"):
        pattern_in("@bad.eaf", tmp_path)


@pytest.mark.parametrize("text", ["r_arm high", "@raise", "@raise x2", "@up...high", "r_arm @x.lq"])
def test_other_texts_stay_as_they_are(text: str):
    assert pattern_in(text) is text


def test_an_error_names_file_and_line(tmp_path: Path):
    path = tmp_path / "wave.lq"
    path.write_text("// a wave\nr_arm left\n  -> rihgt\n")
    with pytest.raises(PatternError) as caught:
        parse(pattern_in(f"@{path}"))
    assert str(caught.value) == (
        f'{path}:3:\n  -> rihgt\n     ^^^^^\nI don\'t know "rihgt". Did you mean "right"?'
    )
    assert str(pickle.loads(pickle.dumps(caught.value))) == str(caught.value)


def test_a_file_that_is_not_there_or_is_no_text(tmp_path: Path):
    with pytest.raises(NotationError, match=r"none\.lq: cannot be read: no such file"):
        pattern_in("@none.lq", tmp_path)
    with pytest.raises(NotationError, match="cannot be read: is a directory"):
        pattern_in("@./", tmp_path)
    (tmp_path / "bad.lq").write_bytes(b"r_arm \xff")
    with pytest.raises(NotationError, match="is no UTF-8"):
        pattern_in("@bad.lq", tmp_path)
