"""Derive action units and emotions from the sculpted blendshapes: `python tools/assets/build_action_units.py`.

Writes conf/assets/action_units.epc and conf/assets/emotions/*.epc. The same blendshapes give the same files.
"""

import sys
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

from conf.face.animation.action_units import (
    ACTION_UNIT_NAMES,
    ASSETS,
    EMOTIONS,
    action_unit_label,
    combine_action_units,
)
from conf.face.control_points import CONTROL_POINT_COUNT
from conf.face.formats.epc import ExpressionSet, write_epc
from conf.face.symmetry import mirror_motion
from tools.assets.arkit_shapes import load_arkit_shapes

# Weights of the sculpted blendshapes of each action unit at full strength; a name without a side means both sides.
RECIPES: dict[int, dict[str, float]] = {
    1: {"browInnerUp": 1.2},
    2: {"browOuterUp": 1.2},
    4: {"browDown": 1.0},
    5: {"eyeWide": 1.0},
    6: {"cheekSquint": 0.7, "eyeSquint": 0.4},
    7: {"eyeSquint": 0.9, "eyeBlink": 0.15},
    9: {"noseSneer": 1.2},
    10: {"mouthUpperUp": 1.2},
    12: {"mouthSmile": 1.0},
    14: {"mouthDimple": 1.0},
    15: {"mouthFrown": 1.2},
    16: {"mouthLowerDown": 1.2},
    20: {"mouthStretch": 1.2},
    23: {"mouthRollLower": 0.6, "mouthRollUpper": 0.35, "mouthPucker": 0.3},
    26: {"jawOpen": 0.55},
    45: {"eyeBlink": 1.0},
}
COLUMNS = "dx dy dz of each control point: x to the subject's left, y up, z forward, 1/1024 of its face distance"
SOURCE = "from CC0 sculpted shapes (MakeHuman faceunits01) by tools/assets/build_action_units.py"


def main() -> None:
    """Write the files."""
    shapes = load_arkit_shapes()
    units = {unit: blend(shapes, recipe) for unit, recipe in RECIPES.items()}
    action_units = ExpressionSet(
        tuple(action_unit_label(unit) for unit in ACTION_UNIT_NAMES),
        np.stack([units[unit] for unit in ACTION_UNIT_NAMES]),
    )
    write_epc(
        ASSETS / "action_units.epc", action_units, comments=[f"FACS action units at full strength, {SOURCE}", COLUMNS]
    )
    (ASSETS / "emotions").mkdir(exist_ok=True)
    for name, strengths in EMOTIONS.items():
        note = "composed of " + ", ".join(f"AU {unit} x {strength}" for unit, strength in strengths.items())
        emotion = ExpressionSet((name,), combine_action_units(strengths, units=units)[None])
        write_epc(ASSETS / "emotions" / f"{name}.epc", emotion, comments=[f"{note}, {SOURCE}", COLUMNS])
    print(f"{len(units)} action units, {len(EMOTIONS)} emotions written to {ASSETS}")


def blend(shapes: dict[str, NDArray[np.float32]], recipe: dict[str, float]) -> NDArray[np.float32]:
    """Return the (n, 3) weighted sum of blendshapes, made symmetric: the sculpted ones are not exactly symmetric."""
    total = np.zeros((CONTROL_POINT_COUNT, 3), np.float32)
    for name, weight in recipe.items():
        sides = [name] if name in shapes else [f"{name}Left", f"{name}Right"]
        total += np.float32(weight) * np.sum([shapes[side] for side in sides], axis=0)
    return ((total + mirror_motion(total)) / 2).astype(np.float32)


if __name__ == "__main__":
    main()
