"""What Blender makes of the files that LanIndex writes, and LanIndex of FBX that Blender writes.

``python tests/benchmarks/blender.py`` in an environment with LanIndex's requirements, ``ufbx`` and
``bpy`` (pip install bpy==5.0.1, 1.1 GB). Motions of several sources are written as GLB and as BVH,
imported, and every joint that has a bone is compared with the motion in up to 60 frames; the same
BVH is exported as FBX, read, and compared in all frames. Printed is the largest distance, in mm and
in hundredths of the body's height.

With Blender 5.0.1 and ufbx 0.0.5::

    source                       way  joints       mm % of height
    compass.bvh                  glb      28   0.0003     0.00002
    compass.bvh                  bvh      23   0.0009     0.00005
    compass.bvh                  fbx      23   0.0014     0.00008
    jesse_dance.bvh              glb      73   0.0009     0.00006
    jesse_dance.bvh              bvh      60   0.0028     0.00017
    jesse_dance.bvh              fbx      60   0.0038     0.00023
    dataset-2_walk_active_005.bv glb      27   0.0024     0.00017
    dataset-2_walk_active_005.bv bvh      22   0.0061     0.00043
    dataset-2_walk_active_005.bv fbx      22   0.0072     0.00051
    10_01.bvh                    glb      57   0.0007     0.00005
    10_01.bvh                    bvh      43   0.0034     0.00024
    10_01.bvh                    fbx      43   0.0042     0.00029
    aitviewer_sample.bvh         glb      28   0.0006     0.00004
    aitviewer_sample.bvh         bvh      23   0.0251     0.00157
    aitviewer_sample.bvh         fbx      23   0.0254     0.00159
    CesiumMan.glb                glb      19   0.0027     0.00023
    CesiumMan.glb                bvh      19   0.0039     0.00034
    CesiumMan.glb                fbx      19   0.0040     0.00035
"""

import contextlib
import io
import os
import sys
import tempfile
from fractions import Fraction
from pathlib import Path
from typing import Any

import bpy
import numpy as np
from places import CAPTURES, HERE

from lanindex import formats
from lanindex.formats import bvh, gltf
from lanindex.model import Motion

SOURCES = (
    HERE.parents[1] / "corpus" / "compass.bvh",
    CAPTURES / "bvh" / "rokoko" / "jesse_dance.bvh",
    CAPTURES / "bvh" / "bandai2" / "walk" / "dataset-2_walk_active_005.bvh",
    CAPTURES / "bvh" / "cmu_daz" / "10_01.bvh",
    CAPTURES / "bvh" / "xsens" / "aitviewer_sample.bvh",
    CAPTURES / "gltf" / "CesiumMan.glb",
)
MOST = 60


@contextlib.contextmanager
def quiet() -> Any:
    """Keep from the terminal what Blender says."""
    kept = os.dup(1)
    with open(os.devnull, "w") as nothing, contextlib.redirect_stdout(io.StringIO()):
        os.dup2(nothing.fileno(), 1)
        try:
            yield
        finally:
            os.dup2(kept, 1)
            os.close(kept)


def clear(rate: Fraction) -> None:
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.render.fps = round(rate)
    scene.render.fps_base = float(round(rate) / rate)


def joints(frame: float) -> dict[str, np.ndarray]:
    """Return where bones begin, y up."""
    bpy.context.scene.frame_set(int(frame), subframe=frame - int(frame))
    (armature,) = (it for it in bpy.context.scene.objects if it.type == "ARMATURE")
    found = {}
    for bone in armature.pose.bones:
        x, y, z = armature.matrix_world @ bone.head
        found[bone.name] = np.array([x, z, -y])
    return found


def distance(motion: Motion, first: int, scale: float) -> tuple[float, int]:
    """Return the largest distance of a bone from its joint, mm, and how many are compared."""
    worst, count = 0.0, 0
    for frame in np.unique(np.linspace(0, len(motion) - 1, MOST).astype(int)).tolist():
        seen = joints(first + frame)
        both = [name for name in motion.skeleton.names if name in seen]
        count = len(both)
        for name in both:
            place = motion.positions[frame, motion.skeleton.names.index(name)]
            worst = max(worst, float(np.linalg.norm(seen[name] * scale - place)))
    return worst, count


def main() -> None:
    print(f"{'source':28} {'way':4} {'joints':>6} {'mm':>8} {'% of height':>11}")
    with tempfile.TemporaryDirectory() as folder:
        for source in [Path(it) for it in sys.argv[1:]] or SOURCES:
            motion = formats.read(source)
            height = float(np.ptp(motion.positions[len(motion) // 2, :, 1]))
            for way, error, count in ways(motion, Path(folder)):
                share = 100 * error / height
                print(f"{source.name[:28]:28} {way:4} {count:6} {error:8.4f} {share:11.5f}")


def ways(motion: Motion, folder: Path) -> Any:
    for way, module in (("glb", gltf), ("bvh", bvh)):
        path = folder / f"a.{way}"
        path.write_bytes(module.write(motion))
        with quiet():
            clear(motion.rate)
            if way == "glb":
                bpy.ops.import_scene.gltf(filepath=str(path))
                found = distance(motion, 0, 1000.0)
            else:
                bpy.ops.import_anim.bvh(filepath=str(path), rotate_mode="NATIVE")
                found = distance(motion, 1, 10.0)
        yield way, *found
    path = folder / "a.fbx"
    with quiet():
        bpy.context.scene.frame_start, bpy.context.scene.frame_end = 1, len(motion)
        bpy.ops.export_scene.fbx(
            filepath=str(path),
            object_types={"ARMATURE"},
            global_scale=0.01,
            bake_anim_simplify_factor=0.0,
            bake_anim_use_nla_strips=False,
            bake_anim_use_all_actions=False,
        )
    back = formats.read(path, unit="cm")
    both = [name for name in motion.skeleton.names if name in back.skeleton.names]
    mine = motion.positions[:, [motion.skeleton.names.index(name) for name in both]]
    theirs = back.positions[:, [back.skeleton.names.index(name) for name in both]]
    count = min(len(mine), len(theirs))
    error = np.linalg.norm(mine[:count] - theirs[:count], axis=2).max()
    yield "fbx", float(error), len(both)


if __name__ == "__main__":
    main()
