"""What a user says of files in place of what a reader would find, checked at the door."""

from __future__ import annotations

from pathlib import Path

from lanindex.body import calibration
from lanindex.body.told import told_body
from lanindex.errors import UsageError
from lanindex.formats.rates import told_rate
from lanindex.model import Reading
from lanindex.notation import beats

COMPOSE = ("parent", "child")
"""Whose turn stands first."""


def check(told: Reading) -> None:
    """Refuse what no reader would understand, before any file is read."""
    if told.unit is not None:
        calibration.told_unit(told.unit)
    if told.up is not None:
        calibration.told_up(told.up)
    if told.rate is not None:
        told_rate(told.rate)
    if told.body is not None:
        told_body(told.body)
    if told.tempo not in (None, beats.AUTO):
        beats.read(Path(told.tempo))
    if told.compose not in (None, *COMPOSE):
        raise UsageError(f"compose {told.compose!r}", wanted=" or ".join(COMPOSE))
