"""Predict 52 blendshape weights, such as how far the jaw is open or an eye shut. Used for calibration, and for ARKit
weights where the tracker runs.

Source: MediaPipe's face_blendshapes_graph.cc; the names are ARKit's. Left and right are the subject's.
"""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from conf.face.retargeting.arkit_csv import SHAPES
from conf.sender.tracking.inference import Backend, load_network
from conf.sender.tracking.model_files import BLENDSHAPES

BLENDSHAPE_NAMES = tuple(
    """
    neutral browDownLeft browDownRight browInnerUp browOuterUpLeft browOuterUpRight cheekPuff cheekSquintLeft
    cheekSquintRight eyeBlinkLeft eyeBlinkRight eyeLookDownLeft eyeLookDownRight eyeLookInLeft eyeLookInRight
    eyeLookOutLeft eyeLookOutRight eyeLookUpLeft eyeLookUpRight eyeSquintLeft eyeSquintRight eyeWideLeft eyeWideRight
    jawForward jawLeft jawOpen jawRight mouthClose mouthDimpleLeft mouthDimpleRight mouthFrownLeft mouthFrownRight
    mouthFunnel mouthLeft mouthLowerDownLeft mouthLowerDownRight mouthPressLeft mouthPressRight mouthPucker mouthRight
    mouthRollLower mouthRollUpper mouthShrugLower mouthShrugUpper mouthSmileLeft mouthSmileRight mouthStretchLeft
    mouthStretchRight mouthUpperUpLeft mouthUpperUpRight noseSneerLeft noseSneerRight
    """.split()
)
INDEX = {name: i for i, name in enumerate(BLENDSHAPE_NAMES)}

# The 146 landmarks that are the network's input.
_INPUTS = np.fromstring(
    """
    0 1 4 5 6 7 8 10 13 14 17 21 33 37 39 40 46 52 53 54 55 58 61 63 65 66 67 70 78 80 81 82 84 87 88 91 93 95 103 105
    107 109 127 132 133 136 144 145 146 148 149 150 152 153 154 155 157 158 159 160 161 162 163 168 172 173 176 178 181
    185 191 195 197 234 246 249 251 263 267 269 270 276 282 283 284 285 288 291 293 295 296 297 300 308 310 311 312 314
    317 318 321 323 324 332 334 336 338 356 361 362 365 373 374 375 377 378 379 380 381 382 384 385 386 387 388 389 390
    397 398 400 402 405 409 415 454 466 468 469 470 471 472 473 474 475 476 477
    """,
    dtype=np.intp,
    sep=" ",
)


def to_arkit_order(shapes: NDArray[np.floating], /) -> NDArray[np.float32]:
    """Return (N, 52) weights in the order of ARKit's SHAPES, of (N, 52) in the network's. Unknown ones are 0."""
    known = [INDEX.get(name) for name in SHAPES]
    return np.stack([np.zeros(len(shapes)) if i is None else shapes[:, i] for i in known], axis=1).astype(np.float32)


class BlendshapeNetwork:
    """The blendshape network."""

    def __init__(self, models: Path, /, *, backend: Backend = "auto") -> None:
        """Load the network from a folder of the tracker's files. Raises ModelError."""
        self._network = load_network(models / BLENDSHAPES, ("StatefulPartitionedCall:0",), backend=backend)

    def predict(self, landmarks: NDArray[np.float32], /) -> NDArray[np.float32]:
        """Return the weights (52,) float32, 0 to 1, of landmarks (478, 3) px."""
        [weights] = self._network(np.ascontiguousarray(landmarks[None, _INPUTS, :2]))
        return weights.reshape(len(BLENDSHAPE_NAMES))
