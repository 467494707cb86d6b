"""A skeleton (ASF) and how it moves (AMC), made for tests."""

ASF = b"""# made
:version 1.10
:units
 length 2.54
 angle deg
:root
 order TX TY TZ RX RY RZ
 axis XYZ
 position 0 0 0
 orientation 0 0 0
:bonedata
"""
BONES = """lfemur root 9 -40 0|ltibia lfemur 0 -42 0|lfoot ltibia 0 0 20|rfemur root -9 -40 0
rtibia rfemur 0 -42 0|rfoot rtibia 0 0 20|lhumerus root 28 60 0|lradius lhumerus 28 0 0
lhand lradius 9 0 0|rhumerus root -28 60 0|rradius rhumerus -28 0 0|rhand rradius -9 0 0"""


def made() -> tuple[bytes, bytes]:
    """Return a small skeleton and how it moves."""
    bones = [bone.split() for bone in BONES.replace("\n", "|").split("|")]
    text = "".join(
        f" begin\n  name {name}\n  direction {' '.join(way)}\n  length 1\n"
        f"  axis 0 0 20 XYZ\n  dof rx rz\n end\n"
        for name, _, *way in bones
    )
    text += ":hierarchy\n begin\n" + "".join(f"  {up} {name}\n" for name, up, *_ in bones)
    frames = "".join(
        f"{number}\nroot 0 90 {number} 1 2 3\n"
        + "".join(f"{name} {number}.5 -2e-1\n" for name, *_ in bones)
        for number in range(1, 9)
    )
    return ASF + text.encode() + b" end\n", b":FULLY-SPECIFIED\n:DEGREES\n" + frames.encode()
