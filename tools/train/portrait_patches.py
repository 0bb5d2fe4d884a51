"""Extract patches from a clip as the sender does, and count their coefficients, for tools/train/portrait.py."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from conf.face.portrait.patch_features import FEATURES
from conf.face.portrait.patch_prediction import forward_dct
from conf.protocol.codec.range_coder import TOTAL
from conf.protocol.codec.symbol_coder import SCALES_PER_OCTAVE
from conf.protocol.portrait.dct_coding import Planes
from conf.protocol.portrait.objects import encode_object
from conf.protocol.portrait.patch import Patch, encode_patch, step_size
from conf.protocol.portrait.probability_model import BlockModel, PortraitModel
from conf.sender.motion.extractor import MotionExtractor
from conf.sender.portrait.captured_face import CapturedFace
from conf.sender.portrait.photo_builder import FULL, PhotoBuilder
from conf.sender.portrait.recent_frames import RecentFrame
from conf.sender.portrait.reference_photo import ReferencePhoto, patch_residual
from conf.sender.tracking.canonical_face import load_canonical_face
from conf.sender.tracking.model_files import fetch_models
from conf.sender.tracking.tracker import FaceTracker
from tools.bench.portrait_clip import FPS, SIZE, load_frames
from tools.train.codec_fit import UNIT_SCALE

PHOTO_AT = 8  # number of the frame used as the photo, when the tracker has settled
PATCH_INTERVAL = 6  # frames
STEPS = (14, 19, 24)  # quantiser steps around those in use
CHECKED_STEP = 19
DEADZONE = 0.6  # steps; smaller coefficients become 0
COEFFICIENTS = 64


@dataclass
class PatchCounts:
    """Counts of coefficients. Kinds of blocks: luma, chroma.

    coded : (2, 3, 2) blocks by kind, number of coded neighbours, and whether the block is coded
    last : (2, 64) blocks by kind and index of the last coded coefficient
    levels, level_count : (2, 64) sums of magnitudes, and their number, by kind and coefficient
    """

    coded: NDArray[np.float64] = field(default_factory=lambda: np.full((2, 3, 2), 2.0))
    last: NDArray[np.float64] = field(default_factory=lambda: np.full((2, COEFFICIENTS), 0.2))
    levels: NDArray[np.float64] = field(default_factory=lambda: np.full((2, COEFFICIENTS), 0.1))
    level_count: NDArray[np.float64] = field(default_factory=lambda: np.full((2, COEFFICIENTS), 0.5))

    def __add__(self, other: "PatchCounts") -> "PatchCounts":
        """Return the sum of both counts."""
        names = self.__dataclass_fields__
        return PatchCounts(**{name: getattr(self, name) + getattr(other, name) for name in names})

    def count(self, planes: Planes) -> None:
        """Count the coefficients of a patch, in quantiser steps."""
        for kind, plane in zip((0, 1, 1), planes, strict=True):
            level = np.where(np.abs(plane) >= DEADZONE, np.maximum(np.rint(np.abs(plane)), 1), 0)
            ends = np.where(level > 0, np.arange(1, COEFFICIENTS + 1), 0).max(axis=2)
            is_coded = np.pad((ends > 0).astype(int), ((1, 0), (1, 0)))
            neighbours = is_coded[:-1, 1:] + is_coded[1:, :-1]
            np.add.at(self.coded[kind], (neighbours.ravel(), is_coded[1:, 1:].ravel()), 1)
            np.add.at(self.last[kind], ends[ends > 0] - 1, 1)
            before = np.arange(COEFFICIENTS) < ends[..., None]
            self.levels[kind] += (level * before).sum(axis=(0, 1))
            self.level_count[kind] += before.sum(axis=(0, 1))

    def model(self) -> BlockModel:
        """Return the probability model of the coder."""
        probability = self.coded[..., 1] / self.coded.sum(axis=2)
        coded = np.clip(np.rint(probability * TOTAL), 64, TOTAL - 64).astype(np.int64)
        last = np.array([_to_integer_frequencies(_smooth(row)) for row in self.last])
        mean = np.array([_smooth(row) for row in self.levels / self.level_count])
        scale = np.rint(UNIT_SCALE + SCALES_PER_OCTAVE * np.log2(mean / np.log(4)))
        return BlockModel(coded, last, np.maximum(scale, 0).astype(np.int64))


def _smooth(row: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.asarray(np.convolve(np.pad(row, 2, "edge"), [0.1, 0.2, 0.4, 0.2, 0.1], "valid"))


def _to_integer_frequencies(weights: NDArray[np.float64]) -> NDArray[np.int64]:
    result = np.asarray(1 + np.floor((TOTAL - len(weights)) * weights / weights.sum()), np.int64)
    result[np.argmax(result)] += TOTAL - result.sum()
    return result


def read_patches(clip: Path) -> list[Patch]:
    """Return patches of a clip's frames relative to frame PHOTO_AT, coefficients in grey levels."""
    models = fetch_models()
    canonical, tracker = load_canonical_face(), FaceTracker(models)
    extractor = MotionExtractor(canonical, SIZE)
    reference: ReferencePhoto | None = None
    found = []
    for number, pixels in enumerate(load_frames(clip)):
        tracking = tracker.track(pixels)
        if tracking is None:
            continue
        motion = extractor.update(tracking, number / FPS)
        face = CapturedFace(pixels, tracking.landmarks, extractor.neutral_points, extractor.fapu)
        if reference is None and number >= PHOTO_AT:
            photo = PhotoBuilder(face, canonical, 0, replace(FULL, steps_per_slice=100)).advance()
            assert photo is not None
            reference = ReferencePhoto.from_bytes(encode_object(photo), face)
        elif reference is not None and number % PATCH_INTERVAL == 0:
            frame = RecentFrame.reduced(face, motion, 0.0, FULL.max_height)
            for region, feature in enumerate(FEATURES):
                if reference.can_patch(frame, region):
                    difference, points = patch_residual(reference, frame, feature)
                    size = difference.shape[1], difference.shape[0]
                    found.append(
                        Patch(0, region, 0, frame.descriptors[region], points, size, 0, forward_dct(difference))
                    )
    return found


def count_patches(found: Sequence[Patch]) -> PatchCounts:
    """Count the coefficients of patches at each of STEPS."""
    counts = PatchCounts()
    for patch in found:
        for step in STEPS:
            counts.count([plane / step_size(step) for plane in patch.coefficients])
    return counts


def cost_of_patches(model: PortraitModel, found: Sequence[Patch]) -> str:
    """Return the mean bytes of patches at CHECKED_STEP."""
    size = step_size(CHECKED_STEP)
    quantised = [
        replace(patch, step=CHECKED_STEP, coefficients=[plane / size for plane in patch.coefficients])
        for patch in found
    ]
    sizes = [len(encode_patch(patch, model=model)) for patch in quantised]
    return f"{np.mean(sizes):6.1f} B of {len(sizes)}"
