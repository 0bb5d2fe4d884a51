"""Where the vertices of a photograph's mesh lie in a patch: its control points say so, the rest lies between them.

Lips that press on one another or lids that are shut would turn triangles over there too, and a patch would be shown
folded. So they are parted and unfolded as the moved photograph is, and what is drawn fits what it is drawn from.
"""

import numpy as np
from numpy.typing import NDArray

from conf.face.control_points import CONTROL_POINT_COUNT
from conf.face.deformation.kernels import KERNELS
from conf.face.deformation.rbf import build_operator
from conf.face.portrait import contours
from conf.face.portrait.lip_lid_gaps import enforce_min_gap
from conf.face.portrait.patch_features import PatchRegion
from conf.face.portrait.untangle import untangle
from conf.face.portrait.warp import PortraitWarp

SMOOTHING = 1e-3


class PatchMapping:
    """For one feature on one photograph: from the control points in a patch to all vertices in it."""

    def __init__(self, feature: PatchRegion, warp: PortraitWarp, /) -> None:
        self.feature = feature
        self.weights = feature.weights(warp.positions_cm)  # (V,)
        self._warp = warp
        space = np.column_stack([warp.positions_cm, np.zeros(len(warp.positions_cm))])
        kernel = KERNELS["thin-plate"]
        others = [i for i in range(CONTROL_POINT_COUNT) if i not in feature.points]
        operator = build_operator(
            space,
            space[:CONTROL_POINT_COUNT],
            kernel=kernel,
            epsilon=kernel.epsilon,
            regions=warp.fields.excluding(others),
            smoothing=SMOOTHING,
        )
        self._matrix = operator.matrix[:, list(feature.points)]

    def map_vertices(self, points: NDArray[np.float64], size: tuple[int, int], /) -> NDArray[np.float64]:
        """Return the places (V, 2) of all vertices in a patch whose control points lie at (m, 2).

        points, places : 0 to 1 from the patch's upper left corner; size : its width and height in px
        """
        mesh, shape = self._warp.mesh, self._warp.shape
        pixels = points * size * (1, -1)
        spread = [
            float(np.linalg.norm(p - p.mean(axis=0))) for p in (mesh.positions[list(self.feature.points)], pixels)
        ]
        scale = spread[0] / max(spread[1], 1e-9)  # from the patch's px to the photograph's picture heights
        places = self._matrix.astype(np.float64) @ (pixels * scale)
        outlines = len(contours.PORTRAIT_LANDMARKS)
        places[:outlines] = enforce_min_gap(places[:outlines], float(np.exp(shape.pose.log_scale)))
        return np.asarray(untangle(places, mesh) / scale / size * (1, -1))
