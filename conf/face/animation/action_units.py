"""FACS action units: what single muscles of a face do, as displacements of the control points, and emotions made of
them.

The displacements lie in assets/action_units.epc, which tools/assets/build_action_units.py derives from sculpted shapes.
They are in FAPU units, so that they fit any face.
Source: Ekman, Friesen 1978 (FACS); tables 3.2 and 3.3 of the thesis, where action unit 10 bears the name of 5: it
raises the upper lip.
"""

from collections.abc import Mapping
from functools import cache
from importlib.resources import files
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from conf.errors import ConfError
from conf.face.control_points import CONTROL_POINT_COUNT
from conf.face.formats.epc import ExpressionSet, read_epc
from conf.face.symmetry import SIDE_WEIGHTS

ACTION_UNIT_NAMES = {
    1: "inner brow raiser",
    2: "outer brow raiser",
    4: "brow lowerer",
    5: "upper lid raiser",
    6: "cheek raiser",
    7: "lid tightener",
    9: "nose wrinkler",
    10: "upper lip raiser",
    12: "lip corner puller",
    14: "dimpler",
    15: "lip corner depressor",
    16: "lower lip depressor",
    20: "lip stretcher",
    23: "lip tightener",
    26: "jaw drop",
    45: "blink",
}

Intensity = float | tuple[float, float]  # of both sides, or of the subject's left and right; 0 none, 1 full

# Which action units make an emotion, by table 3.3 of the thesis, and how strongly, by eye: each must be known for what
# it is on the shipped head. Where units pull against each other one of them leads. Doubt is in one brow and one corner
# of the mouth: section 3.3 of the thesis warns of faces that do the same on both sides.
EMOTIONS: dict[str, dict[int, Intensity]] = {
    "joy": {1: 0.2, 6: 0.7, 12: 1.0, 14: 0.3},
    "surprise": {1: 1.0, 2: 1.0, 5: 1.0, 15: 0.1, 16: 0.2, 20: 0.1, 26: 0.9},
    "doubt": {2: (1.2, 0.0), 6: (0.1, 0.3), 7: (0.3, 0.7), 14: (0.2, 1.2)},
    "fear": {1: 1.0, 2: 0.5, 4: 0.4, 5: 1.0, 15: 0.5, 20: 1.0, 26: 0.4},
    "anger": {2: 0.5, 4: 1.0, 7: 0.45, 9: 0.5, 10: 0.5, 20: 0.6, 26: 0.3},
    "sadness": {1: 1.0, 4: 0.4, 15: 1.0, 23: 0.5},
}

ASSETS = Path(str(files("conf"))) / "assets"


@cache
def load_action_units() -> dict[int, NDArray[np.float32]]:
    """Return the (n, 3) displacements, FAPU units, of every action unit at full strength.

    Raises FileFormatError if the asset is missing or damaged.
    """
    expressions = read_epc(ASSETS / "action_units.epc")
    return {unit: expressions[action_unit_label(unit)] for unit in ACTION_UNIT_NAMES}


@cache
def load_emotions() -> ExpressionSet:
    """Return the six emotions that come with the program, in the order of EMOTIONS.

    Raises FileFormatError if an asset is missing or damaged.
    """
    poses = [read_epc(ASSETS / "emotions" / f"{name}.epc")[name] for name in EMOTIONS]
    return ExpressionSet(tuple(EMOTIONS), np.stack(poses))


def load_expression(name: str, /) -> ExpressionSet:
    """Return one of the six emotions by name, or what an EPC file holds.

    Raises ConfError that names the six if it is neither, FileFormatError if the file is not EPC.
    """
    emotions = load_emotions()
    if name in emotions.names:
        return ExpressionSet((name,), emotions[name][None])
    if not name.lower().endswith(".epc"):
        raise ConfError(
            f"there is no emotion {name!r}: choose one of {', '.join(emotions.names)}, or give an .epc file"
        )
    return read_epc(name)


def combine_action_units(
    strengths: Mapping[int, Intensity], /, *, units: Mapping[int, NDArray[np.float32]] | None = None
) -> NDArray[np.float32]:
    """Return the (n, 3) displacements, FAPU units, of action units together.

    strengths : action unit -> 0 none to 1 full, of both sides or of (left, right)
    units : displacements of the action units; without them those of the program
    Raises ValueError for an action unit that is not known.
    """
    units = load_action_units() if units is None else units
    unknown = sorted(set(strengths) - set(units))
    if unknown:
        raise ValueError(f"strengths must be of action units {sorted(units)}, got {unknown}")
    total = np.zeros((CONTROL_POINT_COUNT, 3), np.float32)
    for unit, strength in strengths.items():
        left, right = strength if isinstance(strength, tuple) else (strength, strength)
        total += (left * SIDE_WEIGHTS["l"] + right * SIDE_WEIGHTS["r"])[:, None] * units[unit]
    return total


def action_unit_label(unit: int, /) -> str:
    """Return the name of an action unit in a file: `AU 12 lip corner puller`."""
    return f"AU {unit} {ACTION_UNIT_NAMES[unit]}"
