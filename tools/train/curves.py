"""Write the curves of an expression that the codec's encoders keep: `python tools/train/curves.py [--output FILE]`.

They are those that tools/bench/expression_curves.py reports, independent ones, in distances of the outer eye corners
per FAPU unit of the mean face. Brows are measured from the bridge of the nose, which follows the control points as in
brow_reference.py.
"""

import argparse
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

import numpy as np
from numpy.typing import NDArray

from conf.face.control_points import CONTROL_POINT_COUNT, control_point_indices
from conf.face.fapu import Fapu
from conf.sender.motion.brow_reference import BRIDGE_WEIGHTS
from conf.sender.motion.mean_face import MEAN_FACE
from tools.bench.expression_curves import GRADIENTS, NAMES, REPORTED

OUTPUT = Path(__file__).resolve().parents[2] / "conf" / "assets" / "curves.npz"
_ABOVE_BRIDGE = ("inner brow", "outer brow")
_IMPLIED = "slant"  # the difference of these two


def curve_gradients() -> NDArray[np.float64]:
    """Return the gradients (R, 3 n) of REPORTED but one that others imply, eye distances per FAPU unit."""
    bridge = np.zeros((CONTROL_POINT_COUNT, 3))
    for name, weight in BRIDGE_WEIGHTS.items():
        bridge[control_point_indices(name), 1] = weight
    rows = []
    for curve, names in REPORTED.items():
        if curve == _IMPLIED:
            continue
        gradient = GRADIENTS[[NAMES.index(name) for name in names]].mean(axis=0)
        rows.append(gradient - bridge if curve in _ABOVE_BRIDGE else gradient)
    left, right = MEAN_FACE[control_point_indices("eye_outer_corner")]
    lengths = Fapu.measure(MEAN_FACE).lengths() / np.linalg.norm(left - right)
    return np.asarray((np.stack(rows) * lengths).reshape(len(rows), -1))


def main() -> None:
    """Write the file."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--output", type=Path, default=OUTPUT)
    options = parser.parse_args()
    np.savez_compressed(options.output, gradients=curve_gradients().astype(np.float32))
    print(f"{options.output}: {options.output.stat().st_size} B")


if __name__ == "__main__":
    main()
