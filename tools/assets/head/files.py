"""Write the files of the head: OBJ with its material, rig and blendshapes."""

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

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


def write_rig(folder: Path, rig: Mapping[str, object]) -> None:
    """Write rig.json: centres of rotation of eyes and jaw, and the static anchors."""
    (folder / "rig.json").write_text(json.dumps(rig, indent=1) + "\n")


def write_shapes(folder: Path, names: Sequence[str], shapes: NDArray[np.float64]) -> None:
    """Write shapes.npz: the sculpted blendshapes, float16, cm."""
    np.savez_compressed(folder / "shapes.npz", names=np.array(names), offsets=shapes.astype(np.float16))


@dataclass(frozen=True)
class Variant:
    """What a head with the topology of the default head has of its own.

    vertices : (V, 3) cm, those of the default head's parts but hair, then its own hair
    hair : (F, 4, 2) corners of its hair, counted from its first vertex and texture coordinate; hair_uvs : (T, 2)
    turn : (3, 3) from the default head's blendshapes to its own, as row @ turn; scales : (52,) of each of them
    points : (50, 3) control points; rig : as rig.json has it
    """

    vertices: NDArray[np.float64]
    hair: NDArray[np.int64]
    hair_uvs: NDArray[np.float64]
    turn: NDArray[np.float64]
    scales: NDArray[np.float64]
    points: NDArray[np.float64]
    rig: Mapping[str, object]


def write_variant(path: Path, variant: Variant) -> None:
    """Write a variant: positions as 16-bit numbers between their extremes, 0.01 mm apart."""
    low, high = variant.vertices.min(axis=0), variant.vertices.max(axis=0)
    steps = np.rint((variant.vertices - low) / (high - low) * 65535).astype(np.uint16)
    np.savez_compressed(
        path,
        bounds=np.stack([low, high]).astype(np.float32),
        vertices=np.diff(steps, axis=0, prepend=np.zeros((1, 3), np.uint16)),  # modulo 2^16; smaller when compressed
        hair=np.where(variant.hair < 0, -1, variant.hair).astype(np.int16),
        hair_uvs=np.rint(variant.hair_uvs * 65535).astype(np.uint16),
        turn=variant.turn.astype(np.float32),
        scales=variant.scales.astype(np.float32),
        points=variant.points.astype(np.float32),
        rig=np.frombuffer(json.dumps(variant.rig).encode(), np.uint8),
    )
