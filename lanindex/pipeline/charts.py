"""Statistics as a picture, by the extra ``plots``: cells by level, ways between them, rates.

A part is a row. Of each group its cells are laid flat: low, mid and high beside each other, each
seen from above, forward up, with place in the middle.
"""

from __future__ import annotations

from collections.abc import Iterator
from io import BytesIO
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from lanindex.alphabet import DIRECTIONS, LEVELS
from lanindex.errors import UsageError, extra
from lanindex.pipeline.movement import BINS, CELLS, Difference, Movement, Moves

if TYPE_CHECKING:
    from matplotlib.axes import Axes

FORMS = ("svg", "png", "pdf")
"""What a picture can be written as."""

MOST = 4
"""Groups that find room beside each other."""

TRANSITIONS = 12
"""Transitions that are drawn of each part: the most frequent."""

_AT = {
    name: (0 if name == "place" else round(np.cos(k * np.pi / 4)),
           0 if name == "place" else round(np.sin(k * np.pi / 4)))
    for k, name in enumerate(DIRECTIONS)
}  # fmt: skip
"""Where each direction lies in its field of nine, right and forward of the middle."""

_SPACING = 3.6
_SPOTS = np.array([
    (_AT[direction][0] + _SPACING * level, _AT[direction][1])
    for direction in DIRECTIONS for level in range(len(LEVELS))
])  # fmt: skip


def charted(movement: Movement, form: str) -> bytes:
    """Return statistics as a picture."""
    if form not in FORMS:
        raise UsageError(f'"{form}"', place="--plot", wanted=f"an ending: {', '.join(FORMS)}")
    if not 0 < len(movement.groups) <= MOST:
        raise UsageError(
            f"{len(movement.groups)} groups",
            place="--plot",
            wanted=f"1 to {MOST}",
            remedy="Choose two with --compare A B, or captures with --in and --where.",
        )
    with extra("plots", form):
        from matplotlib import rc_context
        from matplotlib.backends.backend_agg import FigureCanvasAgg
        from matplotlib.figure import Figure
    two = len(movement.groups) == 2
    columns = len(movement.groups) * 2 + two + 1
    with rc_context({"svg.hashsalt": "lanindex", "font.size": 8, "svg.fonttype": "none"}):
        figure = Figure(
            figsize=(2.7 * columns, 1.45 * len(movement.parts) + 1.3), layout="constrained"
        )
        FigureCanvasAgg(figure)  # no display
        axes = figure.subplots(len(movement.parts), columns, squeeze=False)
        for row, part in zip(axes, movement.parts, strict=True):
            _row(movement, part, list(row))
        for axis, title in zip(axes[0], _titles(movement), strict=True):
            axis.set_title(title, fontsize=8)
        if len(movement.groups) > 1:
            axes[0][-1].legend(fontsize=6, frameon=False)
        figure.suptitle(_title(movement))
        content = BytesIO()
        metadata = {"svg": {"Date": None}, "pdf": {"CreationDate": None}}.get(form)
        figure.savefig(content, format=form, dpi=110, metadata=metadata)
    return content.getvalue()


def _title(movement: Movement) -> str:
    groups = ", ".join(f"{name or '(none)'} ({count})" for name, count in movement.groups.items())
    text = f"{movement.by or 'captures'}: {groups}"
    if len(movement.groups) == 2:
        many = sum(one.matters for one in movement.differences)
        text += f"; {many} of {len(movement.differences)} differences matter (framed)"
    return f"{text}\nlow, mid, high from left to right, forward up, place in the middle"


def _titles(movement: Movement) -> Iterator[str]:
    for group in movement.groups:
        yield f"{group or '(none)'}: where to"
        yield f"{group or '(none)'}: the {TRANSITIONS} most frequent ways"
    if len(movement.groups) == 2:
        yield "second less first, % (mean of captures)"
    yield "movements a second"


def _row(movement: Movement, part: str, axes: list[Axes]) -> None:
    """Draw a part: cells and ways of each group, the difference of two, and rates."""
    moves = [movement.of(group, part) for group in movement.groups]
    shares = [one.cells / max(int(one.cells.sum()), 1) for one in moves]
    top = max(float(max(it.max() for it in shares)), 1e-9)
    for place, (one, share) in enumerate(zip(moves, shares, strict=True)):
        cells, ways = axes[2 * place : 2 * place + 2]
        _field(cells, share, "Blues", 0.0, top)
        cells.set_xlabel(f"{int(one.cells.sum())} movements, {one.captures} captures")
        _transitions(ways, one.transitions)
        ways.set_xlabel(f"known {one.coverage:.0%} of the time")
    axes[0].set_ylabel(part)
    differences = [one for one in movement.differences if one.part == part]
    if len(moves) == 2:
        _difference(axes[-2], [one for one in differences if one.what != "rate"])
    _rates(axes[-1], moves, frame=any(one.matters for one in differences if one.what == "rate"))


def _clear_axes(axis: Axes) -> None:
    axis.set_xlim(-1.7, 2 * _SPACING + 1.7)
    axis.set_ylim(-1.7, 1.7)
    axis.set_aspect("equal")
    axis.set_xticks([])
    axis.set_yticks([])
    for side in axis.spines.values():
        side.set_visible(False)


def _field(axis: Axes, values: NDArray[Any], colors: str, least: float, most: float) -> None:
    """Draw a value in each cell; what is shown of it is in per cent."""
    from matplotlib import colormaps

    _clear_axes(axis)
    for (x, y), value in zip(_SPOTS, values.tolist(), strict=True):
        share = (value - least) / (most - least)
        color = colormaps[colors](0.85 * share if least == 0 else share)
        _square(axis, x, y, facecolor=color, edgecolor="0.8")
        if abs(value) >= 0.005:
            dark = share > 0.6 if least == 0 else abs(share - 0.5) > 0.35
            shade = "white" if dark else "black"
            axis.text(x, y, f"{value * 100:.0f}", ha="center", va="center", color=shade, fontsize=6)


def _square(axis: Axes, x: float, y: float, **style: Any) -> None:
    from matplotlib.patches import Rectangle

    axis.add_patch(Rectangle((x - 0.47, y - 0.47), 0.94, 0.94, **style))


def _transitions(axis: Axes, transitions: NDArray[Any]) -> None:
    """Draw arrows from cell to cell, as wide as they are frequent."""
    _clear_axes(axis)
    axis.scatter(_SPOTS[:, 0], _SPOTS[:, 1], s=6, color="0.75")
    came, went = np.nonzero(transitions)
    counts = transitions[came, went]
    most = max(int(counts.max()), 1) if len(counts) else 1
    for it in np.argsort(-counts, kind="stable")[:TRANSITIONS].tolist():
        share = float(counts[it]) / most
        style = {"arrowstyle": "-|>", "color": "tab:blue", "alpha": 0.35 + 0.6 * share,
                 "linewidth": 0.4 + 2.4 * share, "mutation_scale": 4 + 3 * share,
                 "connectionstyle": "arc3,rad=0.18", "shrinkA": 2, "shrinkB": 2}  # fmt: skip
        if came[it] == went[it]:  # there and back within a cell: a ring
            x, y = _SPOTS[came[it]].tolist()
            axis.scatter(x, y, s=30 + 60 * share, facecolors="none",
                         edgecolors="tab:blue", linewidths=0.4 + 2 * share)  # fmt: skip
        else:
            axis.annotate("", _SPOTS[went[it]], _SPOTS[came[it]], arrowprops=style)


def _difference(axis: Axes, differences: list[Difference]) -> None:
    """Draw how much more of a capture's movements go to a cell in the second group."""
    gaps = np.zeros(len(CELLS))
    for one in differences:
        gaps[CELLS.index(one.what)] = one.values[1] - one.values[0]
    top = max(float(np.abs(gaps).max()), 0.25)
    _field(axis, gaps, "PuOr_r", -top, top)
    for one in differences:
        if one.matters:
            _square(axis, *_SPOTS[CELLS.index(one.what)], fill=False, linewidth=1.6)


def _rates(axis: Axes, moves: list[Moves], *, frame: bool) -> None:
    """Draw movements a second over the captures' time."""
    time = (np.arange(BINS) + 0.5) / BINS * 100
    for one in moves:
        axis.plot(time, one.over_time, label=one.group or "(none)", linewidth=1)
    axis.set_ylim(bottom=0)
    for side in axis.spines.values():
        side.set_linewidth(1.8 if frame else 0.5)
    axis.tick_params(labelsize=6)
    axis.set_xlabel("% of the capture", fontsize=6)
