"""Options about files are checked before any file is read."""

import pytest

from lanindex import formats
from lanindex.errors import UsageError
from lanindex.model import Reading


@pytest.mark.parametrize(
    ("told", "message"),
    [
        (Reading(unit="furlong"), "unit 'furlong', wanted one of mm, cm"),
        (Reading(up="w"), "up axis 'w', wanted one of y, z"),
        (Reading(rate="fast"), "a rate of fast frames a second"),
        (Reading(rate=0), "a rate of 0 frames a second"),
        (Reading(compose="both"), "compose 'both', wanted parent or child"),
    ],
)
def test_unknown_words_are_refused(told: Reading, message: str) -> None:
    with pytest.raises(UsageError, match=message):
        formats.check(told)
    with pytest.raises(UsageError, match=message):  # before a look at what is no capture
        formats.read_file(formats.File("x", b"nothing"), told, formats.Wanted())


def test_known_words_pass() -> None:
    formats.check(Reading())
    formats.check(Reading("CMU", "-Z", "30000/1001", "child"))
