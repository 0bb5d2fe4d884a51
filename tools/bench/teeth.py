"""Count the frames in which a drawn head shows upper teeth and the person does not, at small openings of the mouth.

    python tools/bench/teeth.py CLIP... [--face FACE.obj] [--pictures FOLDER] [--json]

Teeth of the person are bright pixels of little saturation between the lips, compared with the skin of their cheeks.
Teeth of the drawn head are counted by their height below the upper lip. The motion passes through the codec.
"""

import argparse
import json
import os
import sys
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

import cv2
import numpy as np
from numpy.typing import NDArray

from conf.face.control_points import CONTROL_POINT_LANDMARKS, control_point_indices
from conf.face.deformation.face_model import FaceModel
from conf.face.deformation.lip_opening import LipOpening
from conf.face.fapu import Fapu
from conf.face.loading import load_face
from conf.protocol.codec.profiles import LIVE
from conf.protocol.messages import MotionFrame
from conf.sender.capture.clip import open_clip
from conf.sender.frame_pacer import FramePacer
from conf.sender.motion.extractor import MotionExtractor
from conf.sender.tracking.canonical_face import load_canonical_face, remove_head_pose
from conf.sender.tracking.model_files import fetch_models
from conf.sender.tracking.tracker import FaceTracker
from tools.bench.fidelity_tracks import code_track
from tools.bench.tracks import Track

SMALL_CM = 0.5  # from lip to lip, of a small opening
MIN_OPENING_CM = 0.1  # below which a mouth is shut
MIN_SHOWN = 0.1  # of the area between the lips: less is a reflection
MIN_DRAWN_CM = 0.03  # of teeth below the lip: less is not a pixel
_BRIGHTNESS, _SATURATION = 0.62, 0.7  # of the skin's: teeth are brighter than the one and less than the other
_CHEEKS = (50, 280, 205, 425)  # landmarks
INNER_LIPS = (78, 191, 80, 81, 82, 13, 312, 311, 310, 415, 308, 324, 318, 402, 317, 14, 87, 178, 88, 95)
_SCALE = 4  # by which the image is enlarged, so that a slit has an inside
_MIDDLE_LIPS = control_point_indices("inner_lip_upper_mid", "inner_lip_lower_mid")


@dataclass(frozen=True)
class TeethCount:
    """Frames of one clip. small : with a small opening, on the person; shown, drawn : of these, with upper teeth

    drawn_alone : with teeth on the drawn head and none on the person
    """

    small: int
    shown: int
    drawn: int
    drawn_alone: int


@dataclass(frozen=True)
class TrackedMouth:
    """A frame. mouth : BGR around the person's mouth; opening : of the person, cm; shown : share of teeth, 0 to 1"""

    motion: MotionFrame
    aligned: NDArray[np.float64]
    mouth: NDArray[np.uint8]
    opening: float
    shown: float


def main() -> None:
    """Print a row for each clip, or one JSON object."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("clips", nargs="+", type=Path, metavar="CLIP")
    parser.add_argument("--face", type=Path, help="mesh of another face, with its PPC in the same folder")
    parser.add_argument("--pictures", type=Path, help="write the mouths that show none, but are drawn with some")
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args()
    face = load_face(options.face)
    counts = {clip.name: count_teeth(clip, face, options.pictures) for clip in options.clips}
    if options.json:
        print(json.dumps({name: asdict(count) for name, count in counts.items()}))
        return
    print(f"{'clip':<28}{'small openings':>15}{'teeth shown':>13}{'drawn':>8}{'drawn alone':>13}")
    for name, count in counts.items():
        print(f"{name:<28}{count.small:>15}{count.shown:>13}{count.drawn:>8}{count.drawn_alone:>13}")


def count_teeth(clip: Path, face: FaceModel, folder: Path | None = None) -> TeethCount:
    """Return the figures of one clip."""
    frames, fapu = track_clip(clip)
    aligned = np.stack([frame.aligned for frame in frames])
    track = Track(clip.stem, [frame.motion for frame in frames], np.ones(len(frames)), fapu, aligned)
    lips = LipOpening(face)
    drawn = np.array([visible_teeth(face, lips, motion, fapu) for motion in code_track(track)])
    small = np.array([MIN_OPENING_CM <= frame.opening < SMALL_CM for frame in frames])
    shown = np.array([frame.shown >= MIN_SHOWN for frame in frames])
    is_drawn = drawn >= MIN_DRAWN_CM
    if folder is not None:
        folder.mkdir(parents=True, exist_ok=True)
        for number in np.flatnonzero(small).tolist():
            name = f"{clip.stem}_{number:04}_{'shown' if shown[number] else 'none'}_{10 * drawn[number]:.1f}mm.png"
            cv2.imwrite(str(folder / name), frames[number].mouth)
    return TeethCount(*(int(np.sum(small & which)) for which in (True, shown, is_drawn, is_drawn & ~shown)))


def track_clip(clip: Path) -> tuple[Sequence[TrackedMouth], Fapu]:
    """Return the frames of a clip as they are sent, and the FAPU of the person."""
    with open_clip(clip) as source:
        extractor = MotionExtractor(load_canonical_face(), source.size)
        tracker, pace = FaceTracker(fetch_models()), FramePacer(LIVE.fps)

        def frames() -> Iterator[TrackedMouth]:
            for frame in iter(source.read, None):
                tracking = tracker.track(frame.pixels)
                if tracking is None or pace.delay_for(frame.timestamp, frame.timestamp) is None:
                    continue
                motion = extractor.update(tracking, frame.timestamp)
                aligned, _ = remove_head_pose(tracking.landmarks, load_canonical_face(), source.size)
                upper, lower = aligned[CONTROL_POINT_LANDMARKS[_MIDDLE_LIPS], 1].tolist()
                shown = teeth_between_lips(frame.pixels, tracking.landmarks)
                yield TrackedMouth(motion, aligned, mouth_of(frame.pixels, tracking.landmarks), upper - lower, shown)

        return list(frames()), extractor.fapu


def visible_teeth(face: FaceModel, lips: LipOpening, displacements: NDArray[np.floating], sender: Fapu, /) -> float:
    """Return the height of the upper teeth that a drawn mouth shows, cm."""
    vertices = face.deform(displacements, sender=sender)
    if face.rig is None or (teeth := face.rig.upper_teeth) is None:
        return 0.0
    edge = face.control_points[_MIDDLE_LIPS[0], 1] - teeth.overhang  # neutral, of the incisors
    raised = float(vertices[teeth.vertices[0], 1]) - float(face.neutral[teeth.vertices[0], 1])
    upper = lips.upper(vertices) - lips.upper(face.neutral) + face.control_points[_MIDDLE_LIPS[0], 1]
    return float(min(max(upper - edge - raised, 0.0), max(lips.measure(vertices), 0.0)))


def teeth_between_lips(pixels: NDArray[np.uint8], landmarks: NDArray[np.floating], /) -> float:
    """Return the share of the upper half of the area between the lips that teeth cover, 0 to 1.

    pixels : (height, width, 3) BGR; landmarks : (478, 3) px
    """
    low, high = _mouth_box(pixels, landmarks)
    image = cv2.resize(pixels[low[1] : high[1], low[0] : high[0]], None, fx=_SCALE, fy=_SCALE)
    ring = (landmarks[list(INNER_LIPS), :2] - low) * _SCALE
    middle = (ring[1:10] + ring[:10:-1]) / 2  # between the lips, from the right corner to the left one
    area = np.vstack([ring[:11], middle[::-1]])
    mask = np.zeros(image.shape[:2], np.uint8)
    cv2.fillPoly(mask, [area.round().astype(np.int32)], 1)
    if not mask.any():
        return 0.0
    hsv = cv2.cvtColor(image, cv2.COLOR_BGR2HSV)[mask > 0]
    skin = np.median([_skin(pixels, landmarks[point]) for point in _CHEEKS], axis=0)
    is_tooth = (hsv[:, 2] > _BRIGHTNESS * skin[2]) & (hsv[:, 1] < _SATURATION * max(skin[1], 40.0))
    return float(is_tooth.mean())


def _skin(pixels: NDArray[np.uint8], landmark: NDArray[np.floating]) -> NDArray[np.float64]:
    """Return the median colour around a landmark, HSV."""
    x, y = landmark[:2].astype(int).tolist()
    patch = pixels[max(y - 3, 0) : y + 4, max(x - 3, 0) : x + 4]
    return np.asarray(np.median(cv2.cvtColor(patch, cv2.COLOR_BGR2HSV).reshape(-1, 3), axis=0), np.float64)


def _mouth_box(pixels: NDArray[np.uint8], landmarks: NDArray[np.floating]) -> tuple[NDArray[np.int64], ...]:
    ring = landmarks[list(INNER_LIPS), :2]
    low, high = ring.min(axis=0), ring.max(axis=0)
    pad = 0.3 * (high - low)[0]
    size = pixels.shape[1::-1]
    return tuple(np.clip(corner, 0, size).astype(np.int64) for corner in (low - pad, high + pad))


def mouth_of(pixels: NDArray[np.uint8], landmarks: NDArray[np.floating], /) -> NDArray[np.uint8]:
    """Return the image around a mouth."""
    low, high = _mouth_box(pixels, landmarks)
    return pixels[low[1] : high[1], low[0] : high[0]].copy()


if __name__ == "__main__":
    main()
