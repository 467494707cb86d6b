"""What a user says of a body: which joints, or which markers, play it.

A file with a line for each joint that is told, the others are found as ever::

    RWrist = "hand_r"                  # a joint or marker of the capture
    RElbow = ["elbow_in", "elbow_out"] # the middle of several markers
"""

from __future__ import annotations

import tomllib
from collections.abc import Mapping

from lanindex.alphabet import JOINTS
from lanindex.errors import UsageError

LARGEST = 1 << 20
"""Bytes that such a file has at most."""


def told_body(path: str) -> Mapping[str, tuple[str, ...]]:
    """Return what plays each joint that a file tells, by ``alphabet.JOINTS``."""
    try:
        with open(path, "rb") as file:
            said = tomllib.loads(file.read(LARGEST).decode())
    except (OSError, ValueError, RecursionError) as error:
        raise UsageError(
            f"cannot be read ({error})", place=path, wanted='lines such as RWrist = "hand_r"'
        ) from error
    body = {joint: tuple([names] if isinstance(names, str) else _listed(names, joint, path))
            for joint, names in said.items()}  # fmt: skip
    strange = [joint for joint in body if joint not in JOINTS]
    if strange or not body:
        found = f'"{strange[0]}"' if strange else "nothing"
        raise UsageError(found, place=path, wanted=f"one of {', '.join(JOINTS)}")
    return body


def _listed(names: object, joint: str, path: str) -> list[str]:
    if isinstance(names, list) and names and all(isinstance(name, str) for name in names):
        return names
    raise UsageError(
        f"{joint} = {names!r}"[:60], place=path, wanted="a name in quotes, or a list of names"
    )
