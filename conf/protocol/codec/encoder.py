"""The sending half of the codec: motion in, payloads out, predicted only from what was acknowledged."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from conf.protocol.codec.decoder import DecodedFrame
from conf.protocol.codec.model import MAX_AGE, CodecModel, load_models
from conf.protocol.codec.payload_header import MAX_FRAMES, MAX_STRIDE, PayloadHeader, code_header
from conf.protocol.codec.point_residuals import MIN_RESIDUAL, MIN_RESIDUAL_INTRA, choose_point_residuals
from conf.protocol.codec.prediction import first_context, next_context
from conf.protocol.codec.profiles import LIVE, Profile
from conf.protocol.codec.quantised_frame import LOG_SCALE, POSE_VALUES, QuantisedFrame
from conf.protocol.codec.reference_frames import ReferenceFrames
from conf.protocol.codec.symbol_coder import LIMIT, SymbolCoder, SymbolWriter
from conf.protocol.codec.syntax import Context, FrameCoder, code_point_residuals
from conf.protocol.messages import MotionFrame

LAMBDA_FACTORS = (
    0.5,
    1.5,
)  # times the profile's trade: a payload ends on a whole byte, so either may be the better bargain
INTER_LAMBDA_FACTOR = 0.5  # times the profile's trade: beside its headers such a payload is small, so bits are cheap
LOG_SCALE_HYSTERESIS = (
    0.7  # steps: log scale keeps the reference's value while it is this near, because the middle is measured in it
)
SKIP_THRESHOLD = 1.0  # steps: a face that has moved less than this in every direction need not be sent
MAX_POSE = 50.0  # radians, picture heights or e-folds: no pose is


class Encoder:
    """Encode bundles of frames for one receiver that tells which it has decoded."""

    def __init__(self, profile: Profile = LIVE, models: Mapping[str, CodecModel] | None = None) -> None:
        self._profile = profile
        self._models = load_models() if models is None else models
        self._references_by_profile = {name: ReferenceFrames() for name in self._models}
        self._acknowledged: set[int] = set()
        self._newest: QuantisedFrame | None = None

    @property
    def profile(self) -> Profile:
        """The profile of the next payload. A new one starts without references."""
        return self._profile

    @profile.setter
    def profile(self, profile: Profile) -> None:
        if profile != self._profile:
            self._profile, self._newest = profile, None
            self._acknowledged.clear()

    def encode(self, frames: Sequence[MotionFrame], number: int, *, stride: int = 1) -> bytes:
        """Return the payload of one or more frames.

        number : of the first frame, in ticks of the frame clock, greater than of any frame of this profile before
        stride : ticks from each frame to the next
        Raises ValueError if the number is not new, there are too many frames, the stride is too long or a frame is not
        finite.
        """
        self._check(frames, number, stride)
        model = self._models[self.profile.name]
        header = self._header(len(frames), number, stride)
        context = first_context(model, header, number, self._references.require)
        trade = self.profile.rd_lambda * (INTER_LAMBDA_FACTOR if header.age else 1.0)
        attempts = [_attempt(model, header, context, frames, thrift * trade) for thrift in LAMBDA_FACTORS]
        best = min(attempts, key=lambda attempt: attempt.error + 8 * trade * len(attempt.payload))
        for position, quantised in enumerate(best.frames):
            self._references.add(number + position * stride, quantised)
        self._newest = best.frames[-1]
        return best.payload

    def acknowledge(self, numbers: Iterable[int]) -> None:
        """Note the numbers of frames that the receiver has decoded: later ones may be predicted from them."""
        self._acknowledged.update(numbers)
        self._acknowledged.intersection_update(self._references.numbers())

    def drop_references(self) -> None:
        """Predict from nothing until the next acknowledgement: the receiver misses a reference."""
        self._acknowledged.clear()

    def differs_visibly(self, frame: MotionFrame) -> bool:
        """Tell whether a frame differs visibly from the newest that was encoded; if not, nothing need be sent."""
        if self._newest is None:
            return True
        model, shown = self._models[self.profile.name], self._newest
        values = model.transform.forward(frame.displacements, frame.pose, log_scale=shown.values[LOG_SCALE])
        values[LOG_SCALE] = model.transform.log_scale(frame.pose)
        if (np.abs(values - model.transform.dequantise(shown)) > SKIP_THRESHOLD).any():
            return True
        known = shown.residuals
        return bool(
            choose_point_residuals(model, frame.displacements, known, threshold=MIN_RESIDUAL_INTRA, bits_spent=0.0)
        )

    def decode_own(self, number: int, *, stride: int = 1) -> DecodedFrame | None:
        """Return frame `number` as a receiver shows it that has missed nothing, while it is remembered."""
        frame, before = self._references.get(number), self._references.get(number - stride)
        if frame is None:
            return None
        return DecodedFrame(number, *self._models[self.profile.name].transform.inverse(frame, before))

    def _check(self, frames: Sequence[MotionFrame], number: int, stride: int) -> None:
        if number <= self._references.newest:
            raise ValueError(f"number {number} is not greater than {self._references.newest}")
        if not 1 <= len(frames) <= MAX_FRAMES:
            raise ValueError(f"a bundle has 1 to {MAX_FRAMES} frames, not {len(frames)}")
        if not 1 <= stride <= MAX_STRIDE:
            raise ValueError(f"stride must be 1 to {MAX_STRIDE}, not {stride}")
        for frame in frames:
            if not (np.isfinite(frame.displacements).all() and (np.abs(frame.pose) < MAX_POSE).all()):
                raise ValueError("a frame is not finite, or its pose is absurd")

    @property
    def _references(self) -> ReferenceFrames:
        return self._references_by_profile[self.profile.name]

    def _usable(self, number: int) -> bool:
        return number in self._acknowledged and self._references.get(number) is not None

    def _header(self, count: int, number: int, stride: int) -> PayloadHeader:
        age = next((age for age in range(1, MAX_AGE + 1) if self._usable(number - age)), 0)
        companion = age > 0 and self._usable(number - age - stride)
        return PayloadHeader(self.profile.name, count, stride, age, companion)


@dataclass(frozen=True)
class _Attempt:
    """A bundle encoded at one price of a bit; error: the sum of squares, in steps."""

    payload: bytes
    frames: list[QuantisedFrame]
    error: float


def _attempt(
    model: CodecModel, header: PayloadHeader, context: Context, frames: Sequence[MotionFrame], trade: float
) -> _Attempt:
    writer = SymbolWriter(rd_lambda=trade)
    code_header(writer, header)
    coded: list[QuantisedFrame] = []
    total = 0.0
    for position, frame in enumerate(frames):
        plain, error = code_frame(writer, model, context, frame)
        total += error
        known = context.reference.residuals
        threshold = MIN_RESIDUAL if header.age or position else MIN_RESIDUAL_INTRA
        spent = writer.bits - position * model.profile.target_bits
        chosen = choose_point_residuals(model, frame.displacements, known, threshold=threshold, bits_spent=spent)
        coded.append(replace(plain, residuals=code_point_residuals(writer, model, known, chosen)))
        context = next_context(model, header, coded)
    return _Attempt(writer.finish(), coded, total)


def code_frame(
    coder: SymbolCoder, model: CodecModel, context: Context, frame: MotionFrame
) -> tuple[QuantisedFrame, float]:
    """Code a frame, changes of corrections apart; return it and the sum of their squared errors, in steps."""
    transform = model.transform
    log_scale = _choose_log_scale(model, context, frame)
    wanted = transform.forward(frame.displacements, frame.pose, log_scale=log_scale)
    if context.reference.staggered:
        wanted -= transform.stagger
    pose = np.clip(wanted[:POSE_VALUES], -LIMIT, LIMIT)
    coded = FrameCoder(coder, model, context)
    coded.code(pose.tolist())
    pose_error = pose - coded.values
    expression = np.clip(wanted[POSE_VALUES:] + transform.compensate_pose_error(pose_error), -LIMIT, LIMIT)
    coded.code(expression.tolist())
    error = expression - coded.values[POSE_VALUES:]
    quantised = replace(context.reference, values=tuple(coded.values))
    return quantised, float(pose_error @ pose_error + error @ error)


def _choose_log_scale(model: CodecModel, context: Context, frame: MotionFrame) -> int:
    wanted = model.transform.log_scale(frame.pose)
    reference = context.reference.values[LOG_SCALE]
    return reference if abs(wanted - reference) < LOG_SCALE_HYSTERESIS else max(-LIMIT, min(LIMIT, round(wanted)))
