"""The encoder: motion to payloads, predicted only from acknowledged frames."""

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from conf.protocol.codec.decoder import DecodedFrame
from conf.protocol.codec.model import CodecModel, load_models
from conf.protocol.codec.mouth_curve import MouthCurve
from conf.protocol.codec.payload_header import MAX_FRAMES, MAX_STRIDE, PayloadHeader, code_header
from conf.protocol.codec.point_residuals import MIN_RESIDUAL, MIN_RESIDUAL_INTRA, choose_point_residuals
from conf.protocol.codec.profiles import LIVE, Profile
from conf.protocol.codec.reference_frames import LOG_SCALE, MAX_AGE, POSE_VALUES, QuantisedFrame, ReferenceFrames
from conf.protocol.codec.symbol_coder import LIMIT, SymbolCoder, SymbolWriter
from conf.protocol.codec.syntax import Context, FrameCoder, code_point_residuals, first_context, next_context
from conf.protocol.messages import MotionFrame

# Lagrange multipliers tried, times the profile's; the attempt with the lower D + lambda R after byte rounding is sent.
LAMBDA_FACTORS = (0.5, 1.5)
# The same for a payload with a reference: its headers are larger than it is, so its bits count less.
INTER_LAMBDA_FACTOR = 0.5
COARSER_FACTORS = (4.0, 10.0)  # tried one after another when the payload is too long
# Steps: log scale keeps the reference's value within this distance, because the face centre is measured in it.
LOG_SCALE_HYSTERESIS = 0.7
MOUTH_ATTEMPTS = 3  # at most, to bring opening and width of the mouth near enough; two usually do
MAX_POSE = 50.0  # radians, image heights or e-folds: larger values are invalid


class Encoder:
    """Encode frames for one receiver, which acknowledges those that it has decoded."""

    def __init__(self, profile: Profile = LIVE, models: Mapping[str, CodecModel] | None = None) -> None:
        self._profile = profile
        self._models = load_models() if models is None else models
        # Each profile counts its own ticks.
        self._references_by_profile = {name: ReferenceFrames() for name in self._models}
        self._acknowledged: set[int] = set()
        self._newest: QuantisedFrame | None = None

    @property
    def profile(self) -> Profile:
        """The profile of the next payload. A new profile starts without references."""
        return self._profile

    @profile.setter
    def profile(self, profile: Profile) -> None:
        if profile != self._profile:
            self._profile, self._newest = profile, None
            self._acknowledged.clear()

    def encode(
        self, frames: Sequence[MotionFrame], frame_number: int, *, stride: int = 1, max_bytes: float = math.inf
    ) -> bytes:
        """Return the payload of one or more frames.

        frame_number : of the first frame, ticks of the frame clock; greater than that of any earlier frame
        stride : ticks from each frame to the next
        max_bytes : if the payload is longer, precision is given up for length; it may be longer nevertheless
        Raises ValueError if the number is not greater, the number of frames or the stride is out of range, or a frame
        is not finite.
        """
        self._check(frames, frame_number, stride)
        model = self._models[self.profile.name]
        header = self._header(len(frames), frame_number, stride)
        context = first_context(model, header, frame_number, self._references.require)
        rd_lambda = self.profile.rd_lambda * (INTER_LAMBDA_FACTOR if header.age else 1.0)
        attempts = [_attempt(model, header, context, frames, factor * rd_lambda) for factor in LAMBDA_FACTORS]
        best = min(attempts, key=lambda attempt: attempt.error + 8 * rd_lambda * len(attempt.payload))
        for factor in COARSER_FACTORS:
            if len(best.payload) > max_bytes:
                best = _attempt(model, header, context, frames, factor * rd_lambda)
        earlier = self._references.before(frame_number, stride)

        def attempt_again(targets: Sequence[MotionFrame]) -> _Attempt:
            return _attempt(model, header, context, targets, LAMBDA_FACTORS[0] * rd_lambda)

        nearer = _with_mouth_nearer(model, best, frames, earlier, attempt_again)
        best = nearer if len(nearer.payload) <= max_bytes else best
        for position, quantised in enumerate(best.frames):
            self._references.add(frame_number + position * stride, quantised)
        self._newest = best.frames[-1]
        return best.payload

    def acknowledge(self, frame_numbers: Iterable[int]) -> None:
        """Allow prediction from frames that the receiver has decoded."""
        self._acknowledged.update(frame_numbers)
        self._acknowledged.intersection_update(self._references.numbers())

    def drop_references(self) -> None:
        """Encode without reference until the next acknowledgement, after the receiver reported a missing one."""
        self._acknowledged.clear()

    def differs_visibly(self, frame: MotionFrame) -> bool:
        """Return whether a frame differs visibly from the newest encoded one; otherwise it need not be sent."""
        if self._newest is None:
            return True
        model, newest = self._models[self.profile.name], self._newest
        values = model.transform.forward(frame.displacements, frame.pose, log_scale=newest.values[LOG_SCALE])
        values[LOG_SCALE] = model.transform.log_scale(frame.pose)
        if (np.abs(values - model.transform.dequantise(newest)) > self.profile.skip_threshold).any():
            return True
        known, threshold = newest.residuals, MIN_RESIDUAL_INTRA
        return bool(choose_point_residuals(model, frame.displacements, known, threshold=threshold, bits_spent=0.0))

    def decode_own(self, frame_number: int, *, stride: int = 1) -> DecodedFrame | None:
        """Return a frame as a receiver without losses decodes it, or None if it is no longer stored."""
        frame, earlier = self._references.get(frame_number), self._references.before(frame_number, stride)
        if frame is None:
            return None
        return DecodedFrame(frame_number, *self._models[self.profile.name].transform.inverse(frame, earlier))

    def _check(self, frames: Sequence[MotionFrame], frame_number: int, stride: int) -> None:
        if frame_number <= self._references.newest:
            raise ValueError(f"frame_number {frame_number} is not greater than {self._references.newest}")
        if not 1 <= len(frames) <= MAX_FRAMES:
            raise ValueError(f"a payload has 1 to {MAX_FRAMES} frames, not {len(frames)}")
        if not 1 <= stride <= MAX_STRIDE:
            raise ValueError(f"stride must be 1 to {MAX_STRIDE}, not {stride}")
        for frame in frames:
            if not (np.isfinite(frame.displacements).all() and (np.abs(frame.pose) < MAX_POSE).all()):
                raise ValueError(f"a frame is not finite, or a value of its pose is {MAX_POSE:g} or more")

    @property
    def _references(self) -> ReferenceFrames:
        return self._references_by_profile[self.profile.name]

    def _usable(self, frame_number: int) -> bool:
        return frame_number in self._acknowledged and self._references.get(frame_number) is not None

    def _header(self, count: int, frame_number: int, stride: int) -> PayloadHeader:
        age = next((age for age in range(1, MAX_AGE + 1) if self._usable(frame_number - age)), 0)
        second_reference = age > 0 and self._usable(frame_number - age - stride)
        return PayloadHeader(self.profile.name, count, stride, age, second_reference)


@dataclass(frozen=True)
class _Attempt:
    """A payload encoded with one Lagrange multiplier. error : sum of squared errors, steps squared"""

    payload: bytes
    frames: list[QuantisedFrame]
    error: float


def _attempt(
    model: CodecModel, header: PayloadHeader, context: Context, frames: Sequence[MotionFrame], rd_lambda: float
) -> _Attempt:
    writer = SymbolWriter(rd_lambda=rd_lambda)
    code_header(writer, header)
    coded: list[QuantisedFrame] = []
    total = 0.0
    for position, frame in enumerate(frames):
        quantised, error = code_frame(writer, model, context, frame)
        total += error
        known = context.reference.residuals
        threshold = MIN_RESIDUAL if header.age or position else MIN_RESIDUAL_INTRA
        spent = writer.bits - position * model.profile.target_bits
        chosen = choose_point_residuals(model, frame.displacements, known, threshold=threshold, bits_spent=spent)
        coded.append(replace(quantised, residuals=code_point_residuals(writer, model, known, chosen)))
        context = next_context(model, header, coded)
    return _Attempt(writer.finish(), coded, total)


def code_frame(
    coder: SymbolCoder, model: CodecModel, context: Context, frame: MotionFrame
) -> tuple[QuantisedFrame, float]:
    """Code a frame without point residuals; return it and its squared error, steps squared."""
    transform = model.transform
    log_scale = _choose_log_scale(model, context, frame)
    values = transform.forward(frame.displacements, frame.pose, log_scale=log_scale)
    if context.reference.staggered:
        values -= transform.stagger
    pose = np.clip(values[:POSE_VALUES], -LIMIT, LIMIT)
    coded = FrameCoder(coder, model, context)
    coded.code(pose.tolist())
    pose_error = pose - coded.values
    components = np.clip(values[POSE_VALUES:] + transform.compensate_pose_error(pose_error), -LIMIT, LIMIT)
    coded.code(components.tolist())
    error = components - coded.values[POSE_VALUES:]
    quantised = replace(context.reference, values=tuple(coded.values))
    return quantised, float(pose_error @ pose_error + error @ error)


def _with_mouth_nearer(
    model: CodecModel,
    best: _Attempt,
    frames: Sequence[MotionFrame],
    earlier: Sequence[QuantisedFrame],
    attempt: Callable[[Sequence[MotionFrame]], _Attempt],
) -> _Attempt:
    """Return the attempt with the smallest error of the mouth's opening and, of equal ones, of its width."""
    curves: list[MouthCurve] = [model.lip_opening]
    if model.mouth_width is not None:
        curves.append(model.mouth_width)
    targets, smallest, candidate = frames, [math.inf], best
    for _ in range(MOUTH_ATTEMPTS):
        errors = [curve.errors(model.transform, frames, candidate.frames, earlier) for curve in curves]
        largest = [max(map(abs, of_curve)) for of_curve in errors]
        if largest < smallest:
            best, smallest = candidate, largest
        if not any(largest):
            break
        for curve, of_curve in zip(curves, errors, strict=True):
            targets = curve.correct(targets, of_curve)
        candidate = attempt(targets)
    return best


def _choose_log_scale(model: CodecModel, context: Context, frame: MotionFrame) -> int:
    exact = model.transform.log_scale(frame.pose)
    reference = context.reference.values[LOG_SCALE]
    return reference if abs(exact - reference) < LOG_SCALE_HYSTERESIS else max(-LIMIT, min(LIMIT, round(exact)))
