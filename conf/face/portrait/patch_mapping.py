"""Map the vertices of a photo's mesh into a patch: texture coordinates interpolated from its control points.

Lips that press together and closed lids would fold triangles in the patch, as in a deformed photo. They get the same
minimum gap and untangling, so that texture coordinates and positions match.
"""

import numpy as np
from numpy.typing import NDArray

from conf.face.control_points import CONTROL_POINT_COUNT
from conf.face.portrait import contours
from conf.face.portrait.lip_lid_gaps import enforce_min_gap
from conf.face.portrait.patch_features import PatchRegion
from conf.face.portrait.untangle import untangle
from conf.face.portrait.warp import PortraitWarp, thin_plate_matrix

SMOOTHING = 1e-3


class PatchMapping:
    """The mapping of one region of one photo, from the control points in a patch to all vertices in it."""

    def __init__(self, region: PatchRegion, warp: PortraitWarp, /) -> None:
        self.weights = region.weights(warp.positions_cm)  # (V,)
        self._points = list(region.points)
        self._warp = warp
        others = [i for i in range(CONTROL_POINT_COUNT) if i not in region.points]
        centres, regions = warp.positions_cm[:CONTROL_POINT_COUNT], warp.fields.excluding(others)
        matrix = thin_plate_matrix(warp.positions_cm, centres, regions=regions, smoothing=SMOOTHING)
        self._matrix = matrix[:, self._points].astype(np.float64)

    def map_vertices(self, points: NDArray[np.float64], size: tuple[int, int], /) -> NDArray[np.float64]:
        """Return the positions (V, 2) of all vertices in a patch with the control points (m, 2).

        points and result : 0 to 1 from the patch's upper left corner; size : its width and height in px
        """
        mesh = self._warp.mesh
        pixels = points * size * (1, -1)
        spread = [float(np.linalg.norm(p - p.mean(axis=0))) for p in (mesh.positions[self._points], pixels)]
        scale = spread[0] / max(spread[1], 1e-9)  # from the patch's px to image heights of the photo
        positions = self._matrix @ (pixels * scale)
        count = len(contours.PORTRAIT_LANDMARKS)
        positions[:count] = enforce_min_gap(positions[:count], self._warp.scale)
        return np.asarray(untangle(positions, mesh) / scale / size * (1, -1))
