"""Values and corrections: what is read is what was written, and a new size does not move the face."""

from hypothesis import given
from hypothesis import strategies as st

from conf.protocol.codec.model import load_models
from conf.protocol.codec.reference_frames import PointResidual, QuantisedFrame
from conf.protocol.codec.symbol_coder import LIMIT, SymbolReader, SymbolWriter
from conf.protocol.codec.syntax import Context, FrameCoder, code_point_residuals

MODEL = load_models()["live"]
COUNT = len(MODEL.default_reference.values)
VALUES = st.lists(st.integers(-LIMIT, LIMIT), min_size=COUNT, max_size=COUNT)
STEP = st.integers(-300, 300)
CORRECTIONS = st.dictionaries(st.integers(0, MODEL.points - 1), st.tuples(STEP, STEP, STEP), max_size=12)


@given(VALUES, VALUES, st.integers(0, len(MODEL.weights) - 1))
def test_any_values_come_back(reference: list[int], wanted: list[int], row: int) -> None:
    context = Context(row, QuantisedFrame(tuple(reference)), MODEL.default_reference)
    writer = SymbolWriter(rd_lambda=0.1)
    written = FrameCoder(writer, MODEL, context)
    written.code([float(value) for value in wanted])
    read = FrameCoder(SymbolReader(writer.finish()), MODEL, context)
    read.code([0.0] * COUNT)
    assert read.values == written.values
    assert all(abs(value) <= LIMIT for value in read.values)


@given(CORRECTIONS, CORRECTIONS)
def test_corrections_come_back(reference: dict[int, PointResidual], wanted: dict[int, PointResidual]) -> None:
    writer = SymbolWriter(rd_lambda=0.0)
    written = code_point_residuals(writer, MODEL, reference, wanted)
    assert code_point_residuals(SymbolReader(writer.finish()), MODEL, reference, {}) == written
    expected = {point: steps for point, steps in (reference | wanted).items() if any(steps) or point not in wanted}
    assert written == expected


def test_a_growing_face_that_stays_where_it_is_costs_little_more() -> None:
    """The middle is measured in face sizes, so it seems to recede when the face grows: that is foreseen."""
    far, near = [0] * COUNT, [0] * COUNT
    far[4], far[0] = 120, 0
    near[0] = 4
    near[4] = 120 - (120 * 4 * MODEL.scale_coupling >> 16)
    bits = []
    for target in (near, [4, *far[1:]]):
        writer = SymbolWriter(rd_lambda=0.0)
        FrameCoder(writer, MODEL, Context(MODEL.rows[2], QuantisedFrame(tuple(far)))).code(target)
        bits.append(writer.bits)
    assert bits[0] < bits[1]
