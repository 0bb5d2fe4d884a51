"""FACS action units as displacements of the control points, and emotions composed of them.

The displacements are in assets/action_units.epc, which tools/assets/build_action_units.py derives from sculpted shapes.
They are in FAPU units, so that they fit any face.
Source: Ekman, Friesen 1978 (FACS); tables 3.2 and 3.3 of the thesis, where action unit 10 has the name of 5, although
it raises the upper lip.
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

Intensity = float | tuple[float, float]  # of both sides, or of the subject's left and right; 0 to 1

# The action units of each emotion are from table 3.3 of the thesis, their intensities were chosen by eye such that each
# emotion is recognisable on the shipped head. Of opposing units one dominates. Doubt is asymmetric, because section 3.3
# of the thesis warns of symmetric faces.
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
    """Return the (n, 3) displacements, FAPU units, of every action unit at full intensity.

    Raises FileFormatError if the asset is missing or damaged.
    """
    expressions = read_epc(ASSETS / "action_units.epc")
    return {unit: expressions[action_unit_label(unit)] for unit in ACTION_UNIT_NAMES}


@cache
def load_emotions() -> ExpressionSet:
    """Return the six shipped emotions, in the order of EMOTIONS.

    Raises FileFormatError if an asset is missing or damaged.
    """
    poses = [read_epc(ASSETS / "emotions" / f"{name}.epc")[name] for name in EMOTIONS]
    return ExpressionSet(tuple(EMOTIONS), np.stack(poses))


def load_expression(name: str, /) -> ExpressionSet:
    """Return one of the six emotions by name, or the expressions of an EPC file.

    Raises ConfError if it is neither, FileFormatError if the file is not EPC.
    """
    emotions = load_emotions()
    if name in emotions.names:
        return ExpressionSet((name,), emotions[name][None])
    if not name.lower().endswith(".epc"):
        names = ", ".join(emotions.names)
        raise ConfError(f"there is no emotion {name!r}: choose one of {names}, or give an .epc file")
    return read_epc(name)


def combine_action_units(
    intensities: Mapping[int, Intensity], /, *, units: Mapping[int, NDArray[np.float32]] | None = None
) -> NDArray[np.float32]:
    """Return the (n, 3) displacements, FAPU units, of a combination of action units.

    intensities : action unit -> intensity
    units : displacements of the action units, by default those of load_action_units
    Raises ValueError for an unknown action unit.
    """
    units = load_action_units() if units is None else units
    unknown = sorted(set(intensities) - set(units))
    if unknown:
        raise ValueError(f"intensities must be of action units {sorted(units)}, got {unknown}")
    total = np.zeros((CONTROL_POINT_COUNT, 3), np.float32)
    for unit, intensity in intensities.items():
        left, right = intensity if isinstance(intensity, tuple) else (intensity, intensity)
        total += (left * SIDE_WEIGHTS["l"] + right * SIDE_WEIGHTS["r"])[:, None] * units[unit]
    return total


def action_unit_label(unit: int, /) -> str:
    """Return the name of an action unit in a file, such as `AU 12 lip corner puller`."""
    return f"AU {unit} {ACTION_UNIT_NAMES[unit]}"
