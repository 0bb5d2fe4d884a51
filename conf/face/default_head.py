"""The shipped head: where its files are, and what other faces are compared with."""

from functools import cache
from importlib.resources import files
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from conf.face.deformation.rig_builder import RigJoints
from conf.face.deformation.rig_json import read_joints
from conf.face.formats.ppc import read_ppc

DEFAULT_HEAD = Path(str(files("conf"))) / "assets" / "head" / "head.obj"
EYE_MIDPOINT = np.array([0.0, 2.845, 3.8])  # between its pupils, model centimetres


@cache
def default_points() -> NDArray[np.float64]:
    """Return its (n, 3) control points, model centimetres."""
    return read_ppc(DEFAULT_HEAD.with_suffix(".ppc"))


@cache
def default_joints() -> RigJoints:
    """Return what its parts turn about, model centimetres."""
    return read_joints(DEFAULT_HEAD.with_name("rig.json"))
