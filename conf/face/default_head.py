"""The default head: its files, control points and joints."""

from functools import cache
from importlib.resources import files
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from conf.face.formats.ppc import read_ppc

if TYPE_CHECKING:
    from conf.face.deformation.rig_builder import RigJoints

DEFAULT_HEAD = Path(str(files("conf"))) / "assets" / "head" / "head.obj"
EYE_MIDPOINT = np.array([0.0, 2.845, 3.8])  # of the pupils, model centimetres


@cache
def default_points() -> NDArray[np.float64]:
    """Return the (n, 3) control points, model centimetres."""
    return read_ppc(DEFAULT_HEAD.with_suffix(".ppc"))


@cache
def default_joints() -> "RigJoints":
    """Return the joints of the rigid parts, model centimetres."""
    from conf.face.deformation.rig_builder import read_joints  # with SciPy

    return read_joints(DEFAULT_HEAD.with_name("rig.json"))
