"""The verbs for single files, without a library: inspect, convert, animate."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from lanindex.app import options
from lanindex.errors import UsageError

if TYPE_CHECKING:
    from lanindex.model import Motion


def animate(
    score: Annotated[
        Path,
        typer.Argument(metavar="SCORE", readable=False, help="An .lnd file or another score."),
    ],
    output: Annotated[
        Path | None,
        typer.Option(
            *("--output", "-o"),
            metavar="FILE",
            help="Where to write (-: standard output); by default beside the score.",
        ),
    ] = None,
    fps: Annotated[str, typer.Option("--fps", metavar="RATE", help="Frames per second.")] = "30",
    noise: Annotated[
        float,
        typer.Option(metavar="MM", min=0.0, help="Shake every joint by this standard deviation."),
    ] = 0.0,
    seed: Annotated[int, typer.Option(min=0, help="Seed of the noise.")] = 0,
    force: options.Force = False,
    *,
    out: options.PlainOut,
) -> None:
    """Turn a score into motion of a standard body, as a BVH file."""
    from lanindex import notation
    from lanindex.formats import bvh
    from lanindex.perform import perform
    from lanindex.pipeline.files import write_all

    rate = options.rate(fps)
    motion = perform(notation.read(str(score)), rate=rate, noise=noise, seed=seed)
    target = output or score.with_suffix(".bvh")
    content = bvh.write(motion)
    if target == options.STDOUT:
        out.content(content.decode())
    else:
        write_all([(target, content)], force=force, sources=[score])
    for warning in motion.warnings:
        out.note(f"{score}: {warning}")
    out.note(f"{target}: {len(motion)} frames at {float(rate):g} Hz, {motion.seconds:.2f} s")


def convert(
    file: Annotated[
        Path, typer.Argument(metavar="FILE", readable=False, help="A capture or score.")
    ],
    to: Annotated[
        Path | None,
        typer.Argument(metavar="[OUT]", help="The file to write; its ending gives the format."),
    ] = None,
    output: Annotated[
        Path,
        typer.Option("--output", "-o", metavar="FILE", help="The same; - is standard output."),
    ] = options.STDOUT,
    form: Annotated[
        str | None,
        typer.Option("--to", metavar="lnd|bvh|c3d|...", help="The format, whatever the ending."),
    ] = None,
    into: Annotated[
        Path | None,
        typer.Option("--into", metavar="FILE", help="Add tiers to an existing .eaf file."),
    ] = None,
    media: Annotated[
        Path | None,
        typer.Option("--media", metavar="FILE", help="A recording that the .eaf opens with."),
    ] = None,
    origin: options.Origin = False,
    profile: options.Profile = "default",
    *,
    reading: options.Reading,
    tempo: options.Tempo = None,
    force: options.Force = False,
    out: options.PlainOut,
) -> None:
    """Write a capture as LND or in another notation or format, without a library.

    Joints keep their positions. Where only positions are known, bones are turned by the rule of
    lanindex.rotation, starting from a body that stands with its arms to the sides.
    """
    from lanindex.notation import NOTATIONS, WRITTEN, left_out
    from lanindex.pipeline import convert
    from lanindex.pipeline.files import write_all

    target = to or (into if into and output == options.STDOUT else output)
    if form is None and target == options.STDOUT:
        form = "lnd"
    form = convert.target_of(str(target), form)
    if target == options.STDOUT and (form not in WRITTEN or not NOTATIONS[form].text):
        raise UsageError(f"{form} on standard output", wanted="a file to write it to")
    if form != "lnd" and tempo is not None:
        raise UsageError(f"beats in {form}", place="--tempo", wanted="--to lnd, which counts them")
    if form in WRITTEN:
        score = convert.score_of(file, reading, profile, tempo=tempo, origin=origin)
        for line in score.warnings:
            out.note(f"{file}: {line}")
        if lost := left_out(score, form):
            out.note(f"{NOTATIONS[form].title} has no room for {' '.join(lost)}")
        content = convert.notated(score, form, into, force=force, media=media)
        files = [(target, content)]
    else:
        motion = convert.motion_of(file, reading, origin=origin)
        files, notes = convert.files_of(motion, form, target)
        for line in (*motion.warnings, *notes):
            out.note(f"{file}: {line}")
    if target == options.STDOUT:
        out.content(content.decode())
        return
    write_all(files, force=force or target == into, sources=[file])
    for path, _ in files:
        out.note(str(path))


def inspect(
    file: Annotated[Path, typer.Argument(metavar="FILE", readable=False, help="A capture.")],
    *,
    reading: options.Reading,
    tempo: options.Tempo = None,
    out: options.Out,
) -> None:
    """Show what a reader sees in a capture file.

    Joints and the body they map to, rate, unit, up axis, facing, and what is doubtful.
    """
    from lanindex.formats import Wanted, opened, read_file

    motion = read_file(opened(file), reading, Wanted(body_only=True))
    facts = _facts(motion)
    if tempo is not None:
        from lanindex.encoding import encode
        from lanindex.notation.beats import describe_tempo

        score = encode(motion, tempo=tempo)
        facts["tempo"] = describe_tempo(score.meter, score.other)
        facts["warnings"] += score.warnings
    if out.json:
        rest = {key.replace(" ", "_"): facts[key] for key in facts if key not in ("file", "rate")}
        out.record({"capture": facts["file"], "fps": round(float(motion.rate), 6), **rest})
        return
    body, warnings, joints = (facts.pop(key) for key in ("body", "warnings", "joints"))
    for key, value in facts.items():
        out.line(f"{key:12} {value}")
    kind = "markers" if motion.source.set else "joints"
    out.line(f"{kind:12} {len(joints)}: {' '.join(joints)}")
    out.line("body")
    for joint, name in body.items():
        out.line(f"  {joint:10} {name or '(absent)'}")
    for warning in warnings:
        out.line(out.paint(f"warning      {warning}", "warn"))


def _facts(motion: Motion) -> dict[str, Any]:
    import numpy as np

    from lanindex.alphabet import JOINTS
    from lanindex.encoding.heading import heading
    from lanindex.encoding.joints import Body
    from lanindex.encoding.profile import load

    turn = float(np.degrees(heading(motion, motion.rate)[motion.first]))
    names = motion.source.made or motion.skeleton.played()
    leg, arm = Body(motion, load("default")).lengths(["r_leg", "r_arm"])
    guessed = " (by a unit that is a guess)" if "guessed" in motion.source.unit else ""
    first = motion.first
    before = "frame 0 is" if first == 1 else f"frames 0 to {first - 1} are"
    return {
        "file": motion.source.path,
        "format": motion.source.format,
        "frames": len(motion),
        "rate": f"{float(motion.rate):g} Hz ({motion.rate})",
        "seconds": round(motion.seconds, 3),
        "unit": f"{motion.source.unit}: {motion.source.scale:g} mm",
        "up": motion.source.up,
        "compose": motion.source.compose or "the format leaves no choice",
        "height": f"{_height(motion):.0f} mm{guessed}",
        "limbs": f"leg {leg:.0f} mm, arm {arm:.0f} mm",
        "facing": f"{(turn + 90) % 360:.0f} degrees from +z towards +x, in the first frame",
        **({"marker set": motion.source.set} if motion.source.set else {}),
        "palms": _palms(motion),
        "calibration": f"{before} a pose, frame {first} stands in" if first else "none",
        "joints": list(motion.source.joints),
        "body": {joint: names.get(joint) for joint in JOINTS},
        "warnings": list(motion.warnings),
    }


def _height(motion: Motion) -> float:
    """Return the median height; joint by joint, for long captures have too many to hold."""
    import numpy as np

    from lanindex.alphabet import JOINTS
    from lanindex.encoding.joints import body

    highest, lowest = np.full(len(motion), -np.inf), np.full(len(motion), np.inf)
    for joint in JOINTS:
        level = body(motion, [joint])[joint][:, 1]
        if not np.isnan(level).all():
            np.maximum(highest, level, out=highest)
            np.minimum(lowest, level, out=lowest)
    return float(np.nanmedian(highest - lowest))


def _palms(motion: Motion) -> str:
    """Say which palms are known, and why others are not."""
    from lanindex.alphabet import FACING, PALMS, PARTS

    known = [part for part in FACING if PALMS[PARTS[part].child] in motion.axes]
    if known:
        return f"{' and '.join(known)} {'are' if len(known) > 1 else 'is'} told"
    if any(warning.startswith(FACING) for warning in motion.warnings):
        return "not told: nobody measured how the hands are turned"
    return "not told: neither fingers nor markers say how the hands are turned"
