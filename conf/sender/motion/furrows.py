"""Measure the furrows between the brows in the image: a frown that folds the skin hardly moves the landmarks.

Strategy. A patch between the brows is sampled in face axes at a fixed resolution, so that size and pose of the head do
not matter; its logarithm does not change with the light. Vertical lines a few millimetres wide are what remains of it
after smoothing along them and a band-pass across. The weaker of the two sides counts: a strand of hair is on one.
Everybody has some lines: the person's own quiet level, a slow low quantile of their energy, counts as none, and furrows
begin well above it. A face that comes with lines and is at rest otherwise is believed to have them always, until they
are gone: a frown that is missed is better than an old face that looks angry. Measured on fifteen people, in percent of
the brightness: 0.4 to 1.5 at rest, within a factor of 2 for each; 2 to 3.5 in the frowns of the two who frown.
"""

from dataclasses import replace

import cv2
import numpy as np
from numpy.typing import NDArray

from conf.face.head_pose import HeadPose
from conf.face.interpolation import smoothstep
from conf.protocol.messages import MotionFrame
from conf.sender.motion.neutral_pose import ACTIVITY_SCALE
from conf.sender.tracking.blendshape_network import INDEX as SHAPE
from conf.sender.tracking.tracker import TrackedFace

GLABELLA = 9  # landmark between the brows
SIDE_CM, BELOW_CM, ABOVE_CM = 0.8, 0.6, 1.2  # from there: between the hair of the brows, up to the forehead
MARGIN_CM = 0.5  # around it, for the filters
PX_PER_CM = 12.0  # of the patch
BLUR_CM = 0.05  # standard deviation of a blur of the image: finer pixels give the same energy
ALONG_CM, FINE_CM, COARSE_CM = 0.35, 0.07, 0.3  # standard deviations of the smoothing, and of the band-pass
BLACK = 8  # added to the brightness, 0 to 255: noise of dark pixels is no furrow
MIN_PX_PER_CM = 6.0  # of the image: a smaller face does not resolve furrows
TURN_BEGIN, TURN_END = np.radians([22.0, 32.0]).tolist()  # of the head from the camera, in which furrows fade out

QUIET = 1.4  # quiet level before any is known, percent: above that of nearly all
ARRIVAL_S = 0.5  # of a face, in which its lines are believed to be always there if the rest of it is at rest
MIN_CALM = 0.5  # from which it is at rest
FALL_S = 2.0  # time constant with which the quiet level falls
DOUBLE_S, CALM_DOUBLE_S = 40.0, 8.0  # in which it may double; the second while the rest of the face is at rest
BEGIN_RATIO, BEGIN_ABOVE = 1.6, 0.7  # furrows begin at so many times the quiet level, and at so much above it
SPAN = 1.5  # percent, from there to furrows of full depth
SMOOTH_S = 0.15  # time constant of the depth
MAX_STEP_S = 0.2  # between two frames, after a pause
# What shows that lines may be an expression: a face whose lines are always there is known to be at rest within seconds.
_ACTIVE = [
    SHAPE[f"{name}{side}"]
    for name in ("browDown", "eyeBlink", "mouthFrown", "mouthSmile")
    for side in ("Left", "Right")
]


class FurrowEstimator:
    """Measures the furrows of one person, in order of time."""

    def __init__(self) -> None:
        self._quiet = QUIET
        self._depth = 0.0
        self._seen_s = 0.0
        self._timestamp: float | None = None

    def add_furrows(self, motion: MotionFrame, tracked: TrackedFace, pixels: NDArray[np.uint8], /) -> MotionFrame:
        """Return a frame's motion with the furrows of the face in it. pixels : (H, W, 3) uint8 BGR"""
        pose = HeadPose.from_vector(motion.pose)
        energy = furrow_energy(pixels, tracked.landmarks, pose)
        turn = float(np.arccos(np.clip(pose.matrix()[2, 2], -1, 1)))
        facing = 1 - float(smoothstep((turn - TURN_BEGIN) / (TURN_END - TURN_BEGIN)))
        calm = float(np.exp(-tracked.blendshapes[_ACTIVE].max() / ACTIVITY_SCALE))
        depth = self.update(energy if facing else None, motion.timestamp, calm=calm)
        return replace(motion, furrow=facing * depth)

    def update(self, energy: float | None, timestamp: float, /, *, calm: float = 1.0) -> float:
        """Return the depth of the furrows, 0 to 1.

        energy : percent, None if they are not seen
        calm : 0 to 1, how sure it is that the rest of the face is at rest
        """
        elapsed = MAX_STEP_S if self._timestamp is None else min(max(timestamp - self._timestamp, 0.0), MAX_STEP_S)
        self._timestamp = timestamp
        target = 0.0
        if energy is not None:
            self._seen_s += elapsed
            if self._seen_s < ARRIVAL_S and calm > MIN_CALM:
                self._quiet = max(self._quiet, energy)
            begin = max(BEGIN_RATIO * self._quiet, self._quiet + BEGIN_ABOVE)
            target = min(max((energy - begin) / SPAN, 0.0), 1.0)
            if energy < self._quiet:
                self._quiet += (energy - self._quiet) * (1 - float(np.exp(-elapsed / FALL_S)))
            else:
                doublings = elapsed * (calm / CALM_DOUBLE_S + (1 - calm) / DOUBLE_S)
                self._quiet = min(energy, self._quiet * 2**doublings)
        self._depth += (target - self._depth) * (1 - float(np.exp(-elapsed / SMOOTH_S)))
        return self._depth


def furrow_energy(pixels: NDArray[np.uint8], landmarks: NDArray[np.floating], pose: HeadPose, /) -> float | None:
    """Return the energy of vertical lines between the brows, of the side with fewer, percent of the brightness.

    pixels : (H, W, 3) uint8 BGR; landmarks : (478, 3) px
    None if the face is too small, or the patch reaches out of the image.
    """
    patch = sample_patch(pixels, landmarks, pose)
    if patch is None:
        return None
    brightness = np.log(patch.astype(np.float32) + BLACK)
    along, fine, coarse = (length * PX_PER_CM for length in (ALONG_CM, FINE_CM, COARSE_CM))
    narrow, wide = (cv2.GaussianBlur(brightness, (0, 0), sigmaX=across, sigmaY=along) for across in (fine, coarse))
    margin = round(MARGIN_CM * PX_PER_CM)
    squares = np.square(narrow - wide)[margin:-margin, margin:-margin]
    middle = squares.shape[1] // 2
    return 100 * float(np.sqrt(min(squares[:, :middle].mean(), squares[:, middle:].mean())))


def sample_patch(
    pixels: NDArray[np.uint8], landmarks: NDArray[np.floating], pose: HeadPose, /
) -> NDArray[np.uint8] | None:
    """Return the brightness between the brows, with the margin, as seen from the front; None as `furrow_energy`."""
    height, width = pixels.shape[:2]
    px_per_cm = float(np.exp(pose.log_scale)) * height
    if px_per_cm < MIN_PX_PER_CM:
        return None
    step = pose.matrix()[:2, :2] * [[1, -1], [-1, 1]] * (px_per_cm / PX_PER_CM)  # from pixels of the patch to image
    side, above, below = ((reach + MARGIN_CM) * PX_PER_CM for reach in (SIDE_CM, ABOVE_CM, BELOW_CM))
    size = round(2 * side) + 1, round(above + below) + 1
    origin = landmarks[GLABELLA, :2] - step @ [side, above]
    corners = origin + np.array([[0, 0], [size[0], 0], [0, size[1]], size]) @ step.T
    blur = BLUR_CM * px_per_cm
    low = np.floor(corners.min(axis=0) - 2 * blur).astype(int)
    high = np.ceil(corners.max(axis=0) + 2 * blur).astype(int) + 1
    if low.min() < 0 or high[0] > width or high[1] > height:
        return None
    grey = cv2.cvtColor(pixels[low[1] : high[1], low[0] : high[0]], cv2.COLOR_BGR2GRAY)
    grey = cv2.GaussianBlur(grey, (0, 0), blur)
    matrix = np.column_stack([step, origin - low])
    return np.asarray(cv2.warpAffine(grey, matrix, size, flags=cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP), np.uint8)
