"""What a data set is: its counts, where it comes from, on what terms; for people and programs."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any

from lanindex.model import Capture
from lanindex.pipeline.dataset.splits import SPLITS

LICENCES = ("licence", "license")
"""Columns of the user's that tell on what terms a capture may be used."""

UNTOLD = "not told"


def licence_of(capture: Capture) -> str:
    """Return on what terms a capture may be used, as the user told."""
    return next((capture.metadata[name] for name in LICENCES if capture.metadata.get(name)), UNTOLD)


@dataclass
class Tally:
    """Clips, captures and seconds of some of a data set."""

    clips: int = 0
    seconds: float = 0.0
    frames: int = 0
    captures: set[int] = field(default_factory=set)
    units: set[str] = field(default_factory=set)

    def add(self, capture: int, unit: str, frames: int, seconds: float) -> None:
        """Count one clip."""
        self.clips += 1
        self.frames += frames
        self.seconds += seconds
        self.captures.add(capture)
        self.units.add(unit)

    def record(self) -> dict[str, Any]:
        """Return the counts."""
        return {
            "clips": self.clips,
            "captures": len(self.captures),
            "frames": self.frames,
            "hours": round(self.seconds / 3600, 6),
        }


@dataclass
class Counts:
    """A data set as it grows, counted."""

    by: dict[str, dict[str, Tally]] = field(
        default_factory=lambda: {
            "split": {name: Tally() for name in SPLITS},
            **{name: {} for name in ("label", "licence", "format")},
        }
    )
    label_splits: dict[str, Counter[str]] = field(default_factory=dict)
    profiles: Counter[str] = field(default_factory=Counter)
    left_out: Counter[str] = field(default_factory=Counter)
    whole: Tally = field(default_factory=Tally)

    def add(self, row: Mapping[str, Any], unit: str, form: str) -> None:
        """Count one clip, by its line in the index."""
        counted = row["capture_id"], unit, row["frames"], row["seconds"]
        keys = {**{name: row[name] for name in ("split", "label", "licence")}, "format": form}
        for name, key in keys.items():
            self.by[name].setdefault(key, Tally()).add(*counted)
        self.whole.add(*counted)
        self.label_splits.setdefault(row["label"], Counter())[row["split"]] += 1

    def record(self) -> dict[str, Any]:
        """Return the counts as a card has them."""
        groups = {
            f"by_{name}": {key: tally.record() for key, tally in sorted(tallies.items())}
            for name, tallies in self.by.items()
        }
        groups["by_split"] = {name: self.by["split"][name].record() for name in SPLITS}
        for name in SPLITS:
            groups["by_split"][name]["groups"] = len(self.by["split"][name].units)
        for label, splits in self.label_splits.items():
            groups["by_label"][label]["splits"] = {name: splits[name] for name in SPLITS}
        return {
            **self.whole.record(),
            **groups,
            "profiles": dict(sorted((+self.profiles).items())),
            "left_out": dict(sorted(self.left_out.items())),
        }


def page(card: Mapping[str, Any], layout: Iterable[str]) -> str:
    """Return a card as a page for people."""
    lines = ["# A data set of movement", "", *_summary(card), "", "## Clips", ""]
    lines += _table(("split", "clips", "captures", "groups", "hours"),
                    [(name, one["clips"], one["captures"], one["groups"], _hours(one))
                     for name, one in card["by_split"].items()])  # fmt: skip
    lines += ["", *_table(("label", *SPLITS, "clips", "captures", "hours"),
                          [(name or "(none)", *one["splits"].values(), one["clips"],
                            one["captures"], _hours(one))
                           for name, one in card["by_label"].items()])]  # fmt: skip
    lines += ["", "## Terms", "", *_table(("licence, as told", "clips", "captures"),
              [(name, one["clips"], one["captures"])
               for name, one in card["by_licence"].items()])]  # fmt: skip
    lines += ["", "## How it was found", ""]
    for one in card["found"]:
        said = f"{one['label'] or 'each by its own label'}: "
        said += f"`{one['pattern']}`. {one['sentence']}" if one["pattern"] else "whole captures."
        lines.append(f"- {said.rstrip()} {_checked(one)}".rstrip())
    lines += [f"- {name}: {value}" for name, value in card["how"].items()]
    if card["left_out"]:
        lines += ["", "## Left out", ""]
        lines += [
            f"- {number} clip{'s' if number > 1 else ''}: {why}"
            for why, number in card["left_out"].items()
        ]
    lines += ["", "## Files", "", *layout, ""]
    lines += ["`clips.jsonl` has a line for each clip, with the keys", ""]
    lines += [" ".join(f"`{name}`" for name in card["columns"]) + ".", ""]
    return "\n".join(lines)


def _checked(found: Mapping[str, Any]) -> str:
    if found.get("expected") is None:
        return ""
    return f"{found['expected']} of {found['clips']} clips are of captures with an expected label."


def _summary(card: Mapping[str, Any]) -> list[str]:
    profiles = ", ".join(name or "scores as they came" for name in card["profiles"]) or "none"
    who = card["split_by"] if card["split_by"] == "capture" else f"the column {card['split_by']}"
    return [
        f"{card['clips']:,} clips of {card['captures']:,} captures, {card['hours']:.2f} hours, "
        f"at {card['fps'] or 'the rates of their captures'}"
        f"{' frames a second' if card['fps'] else ''}.",
        f"Made by {card['made_by']}; written down with the profile {profiles}.",
        f"Splits ({card['shares']}, seed {card['seed']}) are by {who}: no group is in two. "
        f"{card['split_note']}".rstrip(),
        "Joints unknown for a fifth of a second at most are filled in straight lines.",
    ]


def _hours(one: Mapping[str, Any]) -> str:
    return f"{one['hours']:.3f}"


def _table(head: Iterable[object], rows: Iterable[Iterable[object]]) -> list[str]:
    cells = [[str(cell).replace("|", "\\|").replace("\n", " ") for cell in row] for row in rows]
    titles = [str(name) for name in head]
    lines = [titles, ["---"] * len(titles), *cells]
    return [f"| {' | '.join(line)} |" for line in lines]
