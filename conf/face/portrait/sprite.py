"""Where the vertices of a photograph's mesh lie in a patch: its control points say so, the rest lies between them."""

import numpy as np
from numpy.typing import NDArray

from conf.face.control_points import CONTROL_POINT_COUNT
from conf.face.kernels import KERNELS
from conf.face.portrait.features import Feature
from conf.face.rbf import build_operator
from conf.face.regions import Regions

SMOOTHING = 1e-3


class FeatureMap:
    """For one feature on one photograph: from the control points in a patch to all vertices in it."""

    def __init__(self, feature: Feature, flat: NDArray[np.float64], fields: Regions, /) -> None:
        """flat : (V, 2) cm, picture axes, the first n are the control points; fields : as `split_fields` gives."""
        self.feature = feature
        self.weights = feature.weights(flat)  # (V,)
        space = np.column_stack([flat, np.zeros(len(flat))])
        kernel = KERNELS["thin-plate"]
        others = [i for i in range(CONTROL_POINT_COUNT) if i not in feature.points]
        operator = build_operator(
            space,
            space[:CONTROL_POINT_COUNT],
            kernel=kernel,
            epsilon=kernel.epsilon,
            regions=fields.without(others),
            smoothing=SMOOTHING,
        )
        self._matrix = operator.matrix[:, list(feature.points)]

    def place(self, points: NDArray[np.float64], /) -> NDArray[np.float32]:
        """Return the places (V, 2) of all vertices in a patch whose control points lie at (m, 2)."""
        return np.asarray(self._matrix @ points.astype(np.float32))
