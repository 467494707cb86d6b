"""The page of the method says what the code does: its tables, its examples, its sections."""

import ast
import re
import tomllib
from functools import cache
from pathlib import Path

import pytest

from lanindex.alphabet import PARTS
from lanindex.encoding.profile import BUILT_IN
from lanindex.notation import lnd
from lanindex.notation.lpd_ldd import parse_ldd, parse_lpd

PAGE = BUILT_IN.parent / "METHOD.md"
PACKAGE = BUILT_IN.parents[1]
PROFILES = ("paper", "default")
SOURCE = re.compile(r"encoding/METHOD\.md``,\s+(stages?\s[^;.:)]+|\"[^\"]+\")")


def table(first: str) -> list[dict[str, str]]:
    """Return the rows of the table whose first column is called so."""
    found = re.search(rf"^\| {first} \|[^\n]*\n\|---.*?\n\n", PAGE.read_text(), re.M | re.S)
    rows = [
        [cell.strip() for cell in line.strip("| ").split(" | ")]
        for line in found[0].splitlines()
        if line.startswith("| ")
    ]
    return [dict(zip(rows[0], row, strict=False)) for row in rows[1:]]


def examples(kind: str) -> list[str]:
    return re.findall(rf"^```{kind}\n(.*?)^```", PAGE.read_text(), re.MULTILINE | re.DOTALL)


@cache
def docstrings() -> dict[Path, str]:
    return {
        path: " ".join(
            node.value
            for node in ast.walk(ast.parse(path.read_text()))
            if isinstance(node, ast.Constant) and isinstance(node.value, str)
        )
        for path in sorted(PACKAGE.rglob("*.py"))
    }


@pytest.mark.parametrize("profile", PROFILES)
def test_parameters_are_those_of_the_profile(profile: str) -> None:
    values = tomllib.loads((BUILT_IN / profile / "profile.toml").read_text())
    assert values.pop("name") == profile
    said = {row["parameter"].strip("`"): row[f"`{profile}`"] for row in table("parameter")}
    assert said == {
        key: value if isinstance(value, str) else f"{value:g}" for key, value in values.items()
    }


def test_borders_are_those_of_the_lpd_files() -> None:
    said = {
        tuple(row[column].strip("`") for column in ("profile", "file")): tuple(
            row[column] for column in ("`place` within", "`mid` from", "`high` from")
        )
        for row in table("profile")
    }
    read = {path: parse_lpd(path.read_text()) for path in BUILT_IN.glob("*/*.lpd")}
    assert said == {
        (path.parent.name, path.name): (
            f"{ranges.place:g} {'L' if ranges.relative else 'mm'}",
            f"{ranges.mid:g}",
            f"{ranges.high:g}",
        )
        for path, ranges in read.items()
    }
    assert {ranges.starts for ranges in read.values()} == {parse_lpd(examples("lpd")[0]).starts}


def test_parts_are_those_of_the_alphabet() -> None:
    said = {
        name.strip("`"): (row["from"], *row.get("length through", "").split(), row["to"])
        for row in table("part")
        for name in row["part"].split()
    }
    assert said == {
        name: tuple(joint.removeprefix(part.side.upper()) for joint in part.chain)
        for name, part in PARTS.items()
    }


def test_examples_of_formats_are_read() -> None:
    (score,), (ranges,), (rules,) = map(examples, ("lnd", "lpd", "ldd"))
    assert lnd.write(lnd.read(score)).count("direction ") == score.count("direction ")
    assert parse_lpd(ranges).relative
    (rule,) = parse_ldd(rules)
    assert rule.cells in {
        one.cells for one in parse_ldd((BUILT_IN / "default" / "all.ldd").read_text())
    }


def stages(words: str) -> set[str]:
    """Return the stages named by "stages 2, 2b to 4 and 6"."""
    found = set(re.findall(r"\d[a-z]?", words))
    for first, last in re.findall(r"(\d) to (\d)", words):
        found |= set(map(str, range(int(first), int(last))))
    return found


def test_sections_that_docstrings_name_exist() -> None:
    titles = re.findall(r"^#+ (.*)$", PAGE.read_text(), re.MULTILINE)
    have = {title.split(":")[0].removeprefix("Stage ") for title in titles}
    named = 0
    for path, text in docstrings().items():
        for words in SOURCE.findall(text):
            wanted = {words.strip('"')} if words.startswith('"') else stages(words)
            assert wanted, f"{path}: {words}"
            assert wanted <= have, f"{path}: {words}"
            named += 1
    assert named >= 8


def test_docstrings_name_the_page_where_it_lies() -> None:
    assert [
        str(path) for path, text in docstrings().items() if re.search(r"(?<!/)METHOD\b", text)
    ] == []


def test_every_stage_is_obeyed_by_a_module() -> None:
    texts = {path: text for path, text in docstrings().items() if path.parent.name == "encoding"}
    obeyed = set().union(*(stages(w) for text in texts.values() for w in SOURCE.findall(text)))
    assert {"0", "1", "2", "2b", "3", "4", "5", "6"} <= obeyed


def test_links_within_the_page_lead_somewhere() -> None:
    text = PAGE.read_text()
    titles = re.findall(r"^#+ (.*)$", text, re.MULTILINE)
    anchors = {re.sub(r"[^\w -]", "", title).lower().replace(" ", "-") for title in titles}
    linked = set(re.findall(r"\]\(#([^)]+)\)", text))
    assert linked
    assert linked <= anchors
