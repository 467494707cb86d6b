import pytest

from lanindex.errors import NotationError
from lanindex.notation.lpd_ldd import parse_ldd

PAPER = """\
#rule_start#
L	l_forward mid
L	l_forward low
D	place low
#rule_end#

// with the other spelling
#rule_start
L place low
D right low
#rule_end
"""


def test_both_spellings() -> None:
    first, second = parse_ldd(PAPER)
    assert (first.line, first.cells, first.deleted) == (
        1,
        ((3, 1), (3, 0), (8, 0)),
        (False, False, True),
    )
    assert (second.line, second.cells, second.deleted) == (8, ((8, 0), (0, 0)), (False, True))


def test_upper_case_and_windows_lines() -> None:
    assert parse_ldd(PAPER.upper().replace("\n", "\r\n")) == parse_ldd(PAPER)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("L place low", 'r.ldd:1: "L place low", wanted #rule_start#'),
        ("#rule_start#\nX place low", 'r.ldd:2: "X place low", wanted "L direction level"'),
        ("#rule_start#\nD up low", 'r.ldd:2: "up", wanted a direction'),
        ("x" * 5000, f'r.ldd:1: "{"x" * 59}…", wanted #rule_start#'),
        ("#rule_start#\nD left " + "x" * 5000, f'r.ldd:2: "{"x" * 59}…", wanted high'),
        ("#rule_start#\nD " + "x" * 5000 + " low", f'r.ldd:2: "{"x" * 59}…", wanted a direction'),
        ("#rule_start#\nD left x " + "x" * 5000, f'r.ldd:2: "D left x {"x" * 50}…", wanted "L'),
        ("#rule_start#\nD left lower", 'r.ldd:2: "lower", wanted high, mid or low'),
        (
            "#rule_start#\nL left low\nL left mid\n#rule_end#",
            "r.ldd:1: a rule that deletes nothing",
        ),
        ("#rule_start#\nD left low\n#rule_end#", "r.ldd:1: a rule of 1 rows, wanted two or three"),
        ("#rule_start#\nD left low", "r.ldd:1: a rule without an end, wanted #rule_end#"),
        ("#rule_start#\n#rule_start#", "wanted a row of the rule or #rule_end#"),
    ],
    ids=lambda text: text[:40],
)
def test_errors_name_the_line(text: str, message: str) -> None:
    with pytest.raises(NotationError) as error:
        parse_ldd(text, "r.ldd")
    assert message in str(error.value)
