"""Write the files of the head: OBJ with its material, control points, rig and blendshapes."""

import json
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from conf.face.control_points import CONTROL_POINTS
from tools.assets.head.part import Part

TEXTURE = "skin.webp"
_HEADER = "Default head of conf, made by tools/assets/build_head.py from the MakeHuman base mesh (CC0). Centimetres."
_MATERIAL = f"# {_HEADER}\nnewmtl head\nKa 0 0 0\nKd 1 1 1\nKs 0 0 0\nillum 1\nmap_Kd {TEXTURE}\n"


def write_obj(folder: Path, head: Part) -> None:
    """Write head.obj and head.mtl."""
    lines = [f"# {_HEADER}", "mtllib head.mtl", "usemtl head"]
    lines += ["v {:.4f} {:.4f} {:.4f}".format(*v) for v in head.vertices]
    lines += ["vt {:.5f} {:.5f}".format(*t) for t in head.uvs]
    for name, corners in head.groups.items():
        lines.append(f"g {name}")
        for face in corners + 1:
            lines.append("f " + " ".join(f"{v}/{t}" for v, t in face if v > 0))
    (folder / "head.obj").write_text("\n".join(lines) + "\n")
    (folder / "head.mtl").write_text(_MATERIAL)


def write_ppc(folder: Path, points: NDArray[np.float64]) -> None:
    """Write head.ppc: the (50, 3) control points."""
    lines = [f"# {_HEADER}", "# Control points: x y z, x to the subject's left, y up, z to the viewer."]
    for point, (x, y, z) in zip(CONTROL_POINTS, points, strict=True):
        lines.append(f"{x:.4f} {y:.4f} {z:.4f}  # {point.index} {point.name}")
    (folder / "head.ppc").write_text("\n".join(lines) + "\n")


def write_rig(folder: Path, rig: Mapping[str, object]) -> None:
    """Write rig.json: centres of rotation of eyes and jaw, and the static anchors."""
    (folder / "rig.json").write_text(json.dumps(rig, indent=1) + "\n")


def write_shapes(folder: Path, names: Sequence[str], shapes: NDArray[np.float64]) -> None:
    """Write shapes.npz: the sculpted blendshapes, float16, cm."""
    np.savez_compressed(folder / "shapes.npz", names=np.array(names), offsets=shapes.astype(np.float16))
