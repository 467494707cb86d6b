"""``lanindex inspect``: what a reader sees in a capture file."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from lanindex.app import options
from lanindex.app.output import Output

if TYPE_CHECKING:
    from lanindex.model import Motion

_GUESSED = " (by a unit that is a guess)"


def run(
    file: Annotated[Path, typer.Argument(metavar="FILE", readable=False, help="A capture.")],
    unit: options.Unit = None,
    up: options.Up = None,
    fps: options.Fps = None,
    compose: options.Compose = None,
    skeleton: options.Skeleton = None,
    body: options.Body = None,
    columns: options.Columns = None,
    take: options.Take = None,
    tempo: options.Tempo = None,
    json: options.Json = False,
    quiet: options.Quiet = False,
    verbose: options.Verbose = False,
    color: options.Color = "auto",
) -> None:
    """Say what a reader sees in a capture file.

    Joints and the body they map to, rate, unit, up axis, facing, and what is doubtful.
    """
    out = Output(json, quiet, verbose, color)
    from lanindex.formats import Wanted, opened, read_file

    given = options.reading(
        unit, up, fps, compose, skeleton=skeleton, body=body, columns=columns, take=take
    )
    motion = read_file(opened(file), given, Wanted(body_only=True))
    seen = _seen(motion) | _counted(motion, tempo)
    if json:
        told = {key.replace(" ", "_"): seen[key] for key in seen if key not in ("file", "rate")}
        out.record({"capture": seen["file"], "fps": round(float(motion.rate), 6), **told})
        return
    played = seen.pop("body")
    warnings = seen.pop("warnings")
    joints = seen.pop("joints")
    for key, value in seen.items():
        out.line(f"{key:12} {value}")
    kind = "markers" if motion.source.set else "joints"
    out.line(f"{kind:12} {len(joints)}: {' '.join(joints)}")
    out.line("body")
    for joint, name in played.items():
        out.line(f"  {joint:10} {name or '(absent)'}")
    for warning in warnings:
        out.line(out.paint(f"warning      {warning}", "warn"))


def _seen(motion: Motion) -> dict[str, Any]:
    import numpy as np

    from lanindex.alphabet import JOINTS
    from lanindex.encode.heading import heading
    from lanindex.encode.joints import Body
    from lanindex.encode.profile import load

    turn = float(np.degrees(heading(motion, motion.rate)[motion.first]))
    played = motion.source.made or motion.skeleton.played()
    leg, arm = Body(motion, load("default")).lengths(["r_leg", "r_arm"])
    return {
        "file": motion.source.path,
        "format": motion.source.format,
        "frames": len(motion),
        "rate": f"{float(motion.rate):g} Hz ({motion.rate})",
        "seconds": round(motion.seconds, 3),
        "unit": f"{motion.source.unit}: {motion.source.scale:g} mm",
        "up": motion.source.up,
        "compose": motion.source.compose or "the format leaves no choice",
        "height": f"{_height(motion):.0f} mm{_GUESSED * ('guessed' in motion.source.unit)}",
        "limbs": f"leg {leg:.0f} mm, arm {arm:.0f} mm",
        "facing": f"{(turn + 90) % 360:.0f} degrees from +z towards +x, in the first frame",
        **({"marker set": motion.source.set} if motion.source.set else {}),
        "palms": _palms(motion),
        "calibration": _calibration(motion.first),
        "joints": list(motion.source.joints),
        "body": {joint: played.get(joint) for joint in JOINTS},
        "warnings": list(motion.warnings),
    }


def _counted(motion: Motion, tempo: str | None) -> dict[str, Any]:
    """Return how time would be counted, where that is asked for."""
    if tempo is None:
        return {}
    from lanindex.encode import encode
    from lanindex.notation.beats import said

    score = encode(motion, tempo=tempo)
    return {
        "tempo": said(score.meter, score.other),
        "warnings": [*motion.warnings, *score.warnings],
    }


def _height(motion: Motion) -> float:
    """Return the median height, joint by joint: all of a long capture are many."""
    import numpy as np

    from lanindex.alphabet import JOINTS
    from lanindex.encode.joints import body

    highest, lowest = np.full(len(motion), -np.inf), np.full(len(motion), np.inf)
    for joint in JOINTS:
        level = body(motion, [joint])[joint][:, 1]
        if not np.isnan(level).all():
            np.maximum(highest, level, out=highest)
            np.minimum(lowest, level, out=lowest)
    return float(np.nanmedian(highest - lowest))


def _palms(motion: Motion) -> str:
    """Say which palms are told, and why others are not."""
    from lanindex.alphabet import FACING, PALMS, PARTS

    told = [part for part in FACING if PALMS[PARTS[part].child] in motion.axes]
    if told:
        return f"{' and '.join(told)} {'are' if len(told) > 1 else 'is'} told"
    if any(warning.startswith(FACING) for warning in motion.warnings):
        return "not told: nobody measured how the hands are turned"
    return "not told: neither fingers nor markers say how the hands are turned"


def _calibration(first: int) -> str:
    """Say which frames come before the movement."""
    frames = "frame 0 is" if first == 1 else f"frames 0 to {first - 1} are"
    return f"{frames} a pose, frame {first} stands in" if first else "none"
