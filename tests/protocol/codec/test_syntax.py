"""Values, point residuals and prediction: both directions and the independent decoder agree."""

from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from conf.errors import ProtocolError
from conf.protocol.codec.model import load_models
from conf.protocol.codec.payload_header import PayloadHeader
from conf.protocol.codec.reference_frames import MissingReferenceError, PointResidual, QuantisedFrame, ReferenceFrames
from conf.protocol.codec.symbol_coder import LIMIT, SymbolReader, SymbolWriter
from conf.protocol.codec.syntax import (
    FEATURE_COUNT,
    MAX_RESIDUALS,
    Context,
    FrameCoder,
    code_point_residuals,
    first_context,
    next_context,
)
from tests.protocol.independent_decoder import Frame, PayloadReader, Range, uniform, weighted

MODEL = load_models()["live"]
COUNT = len(MODEL.default_reference.values)
STEP = st.integers(-300, 300)
RESIDUALS = st.dictionaries(st.integers(0, MODEL.points - 1), st.tuples(STEP, STEP, STEP), max_size=12)
READER = PayloadReader()
FRAMES = [QuantisedFrame((n,) * COUNT) for n in range(6)]


def independent(frame: QuantisedFrame) -> Frame:
    """Return the frame as the independent decoder stores it."""
    return Frame(list(frame.values), frame.staggered, frame.residuals)


def random_residuals(rng: np.random.Generator) -> dict[int, PointResidual]:
    """Return residuals of up to 12 points, some of them 0."""
    points = rng.choice(MODEL.points, int(rng.integers(0, 13)), replace=False).tolist()
    return {point: tuple((rng.integers(-300, 301, 3) * rng.integers(0, 2)).tolist()) for point in points}


@pytest.mark.parametrize("seed", range(24))
@pytest.mark.parametrize("has_second", [False, True])
def test_both_decoders_read_the_frame_that_was_written(seed: int, has_second: bool) -> None:
    rng = np.random.default_rng(seed)
    limit = (3, 40, 700, LIMIT)[seed % 4]
    reference_values, second_values, targets = rng.integers(-limit, limit + 1, (3, COUNT)).tolist()
    age, known, changes = int(rng.integers(1, 64)), random_residuals(rng), random_residuals(rng)
    reference = QuantisedFrame(tuple(reference_values), residuals=known)
    second = QuantisedFrame(tuple(second_values)) if has_second else None
    row = (MODEL.second_reference_rows if second else MODEL.rows)[age]
    context = Context(row, reference, second)
    writer = SymbolWriter(rd_lambda=0.1)
    written = FrameCoder(writer, MODEL, context)
    written.code([float(value) for value in targets])
    residuals = code_point_residuals(writer, MODEL, known, changes)
    payload = writer.finish()
    reader = SymbolReader(payload)
    read = FrameCoder(reader, MODEL, context)
    read.code([0.0] * COUNT)
    assert read.values == written.values
    assert code_point_residuals(reader, MODEL, known, {}) == residuals
    string = Range(payload)
    context_read = independent(reference), independent(second) if second else None, age
    assert READER.read_frame(string, "live", context_read) == Frame(
        written.values, residuals=residuals, staggered=False
    )
    assert string.end() == payload


@pytest.mark.slow
@given(RESIDUALS, RESIDUALS)
def test_changed_residuals_replace_those_of_the_reference(
    reference: dict[int, PointResidual], changes: dict[int, PointResidual]
) -> None:
    coded = code_point_residuals(SymbolWriter(rd_lambda=0.0), MODEL, reference, changes)
    assert coded == {
        point: steps for point, steps in (reference | changes).items() if any(steps) or point not in changes
    }


def test_a_residual_is_removed_only_if_all_axes_are_zero() -> None:
    changes = {3: (0, 0, 5), 4: (0, 1, 0), 5: (2, 0, 0), 6: (0, 0, 0)}
    coded = code_point_residuals(SymbolWriter(rd_lambda=0.0), MODEL, {6: (1, 1, 1)}, changes)
    assert coded == {3: (0, 0, 5), 4: (0, 1, 0), 5: (2, 0, 0)}


@dataclass
class FakeCoder:
    """A coder that returns a constant number and records scales and targets."""

    result: int
    scales: list[int] = field(default_factory=list)
    tables: list[object] = field(default_factory=list)
    targets: list[float] = field(default_factory=list)

    def number(self, tables: object, scale: int, target: float) -> int:
        """Record the scale and the target."""
        self.scales.append(scale)
        self.targets.append(target)
        return self.result

    def symbol(self, cumulative: object, value: int) -> int:
        """Record the table."""
        self.tables.append(cumulative)
        return value


def fake_coder(result: int) -> Any:
    """Return a FakeCoder, typed as the coder for which it is used."""
    return FakeCoder(result)


def test_point_residuals_use_the_tables_of_wire_md() -> None:
    coder = fake_coder(1)
    assert code_point_residuals(coder, MODEL, {3: (5, 6, 7)}, {3: (1, 1, 1), 8: (0, 0, 2)}) == {
        3: (6, 7, 8),
        8: (1, 1, 1),
    }
    count = weighted([3000, 12, 10, 8, 6, 4, 4, 3, 2, 2, 2, 1, 1])
    assert coder.tables == [count, uniform(50), uniform(50)]
    assert (coder.scales, coder.targets) == ([24] * 6, [-4, -5, -6, 0, 0, 2])
    assert (MAX_RESIDUALS, FEATURE_COUNT) == (12, 8)


@pytest.mark.parametrize(("value", "difference"), [(LIMIT, 1), (-LIMIT, -1)])
def test_a_value_out_of_range_is_rejected(value: int, difference: int) -> None:
    context = Context(0, QuantisedFrame((0, 0, *[value] * (COUNT - 2))))
    coder = FrameCoder(fake_coder(0), MODEL, context)
    coder.code([0.0] * 3)
    assert coder.values == [0, 0, value]
    with pytest.raises(ProtocolError, match="out of range"):
        FrameCoder(fake_coder(difference), MODEL, context).code([0.0] * 3)
    with pytest.raises(ProtocolError, match="out of range"):
        code_point_residuals(fake_coder(difference), MODEL, {2: (0, value, 0)}, {2: (1, 1, 1)})


def test_the_features_count_motion_in_sixteenths_of_an_octave() -> None:
    """One weight at a time is 1, so that the scale is the feature."""
    reference = QuantisedFrame(tuple([0, 3, 0, 0, 0, 0, 7, *[0] * (COUNT - 8), 2000]))
    second = QuantisedFrame(tuple([1, 0, 0, 0, 0, 0, 4, *[0] * (COUNT - 7)]))
    expected = {0: [16] * 8, 2: [0, 16, 25, 32, 37, 41, 44, 44], 3: [0] * 7 + [16], 4: [16, 32, 0, 0, 0, 0, 32, 0]}
    expected |= {1: [0, *[1] * 7], 5: [52] * 8, 6: [37] * 8, 7: [52] * 8}
    for feature, scales in expected.items():
        weights = [[[256 * (i == feature) for i in range(8)]] * COUNT]
        coder = fake_coder(1)
        FrameCoder(coder, replace(MODEL, weights=weights), Context(0, reference, second)).code([0.0] * 8)
        assert coder.scales == scales, feature


def test_the_face_centre_is_predicted_in_face_sizes() -> None:
    reference = QuantisedFrame((10, 0, 0, 100, 1000, -1000, 1000, *[0] * (COUNT - 7)))
    coder = fake_coder(0)
    model = replace(MODEL, scale_coupling=655)
    frame = FrameCoder(coder, model, Context(0, reference))
    frame.values = [14]
    frame.code([0.0] * 6)
    assert coder.targets == [0, 0, -100, -1000 + (1000 * 4 * 655 >> 16), 1000 + (-1000 * 4 * 655 >> 16), -1000]


def test_a_growing_face_at_the_same_position_costs_fewer_bits() -> None:
    far, near = [0] * COUNT, [0] * COUNT
    far[4] = 120
    near[0], near[4] = 4, 120 - (120 * 4 * MODEL.scale_coupling >> 16)
    bits = []
    for targets in (near, [4, *far[1:]]):
        writer = SymbolWriter(rd_lambda=0.0)
        FrameCoder(writer, MODEL, Context(MODEL.rows[2], QuantisedFrame(tuple(far)))).code(targets)
        bits.append(writer.bits)
    assert bits[0] < bits[1]


def stored() -> ReferenceFrames:
    """Return frames 0 to 5, frame n with the value n."""
    references = ReferenceFrames()
    for number, frame in enumerate(FRAMES):
        references.add(number, frame)
    return references


@pytest.mark.parametrize(("frame_number", "staggered"), [(4, False), (5, True)])
def test_without_reference_the_default_reference_is_used(frame_number: int, staggered: bool) -> None:
    header = PayloadHeader("live", 1, 1, 0, second_reference=False)
    context = first_context(MODEL, header, frame_number, stored().require)
    default = replace(MODEL.default_reference, staggered=staggered)
    assert context == Context(0, default)


def test_references_are_found_by_age_and_stride() -> None:
    for second in (True, False):
        header = PayloadHeader("live", 1, 2, 3, second_reference=second)
        context = first_context(MODEL, header, 6, stored().require)
        rows = MODEL.second_reference_rows if second else MODEL.rows
        assert context == Context(rows[3], FRAMES[3], FRAMES[1] if second else None)


def test_an_unknown_second_reference_is_missing() -> None:
    with pytest.raises(MissingReferenceError, match="frame -1"):
        first_context(MODEL, PayloadHeader("live", 1, 1, 5, second_reference=True), 5, stored().require)


def test_later_frames_of_a_payload_are_predicted_from_earlier_ones() -> None:
    header = PayloadHeader("live", 3, 2, 0, second_reference=False)
    assert next_context(MODEL, header, FRAMES[:1]) == Context(MODEL.rows[2], FRAMES[0])
    assert next_context(MODEL, header, FRAMES[:2]) == Context(MODEL.second_reference_rows[2], FRAMES[1], FRAMES[0])
    assert next_context(MODEL, header, FRAMES[:4]) == Context(MODEL.second_reference_rows[2], FRAMES[3], FRAMES[2])
