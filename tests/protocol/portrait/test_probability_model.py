"""The trained statistics of portraits."""

import numpy as np

from conf.face.control_points import CONTROL_POINT_COUNT
from conf.face.portrait import contours
from conf.face.portrait.patch_features import FEATURES
from conf.protocol.codec.range_coder import TOTAL
from conf.protocol.codec.symbol_coder import SymbolReader, SymbolWriter
from conf.protocol.portrait.probability_model import (
    MODEL_FILE,
    REGIONS,
    BlockModel,
    PointTree,
    PortraitModel,
    code_numbers,
    difference_tables,
    load_portrait_model,
)
from tests.protocol.independent_decoder import Range, live_tables, read_number, read_tree

MODEL = load_portrait_model()


def is_valid(tree: PointTree) -> bool:
    """Return whether every point occurs once and after its parent."""
    count = len(tree.mean)
    return (
        sorted(tree.order) == list(range(count))
        and tree.parents[0] == -1
        and all(0 <= tree.parents[i] < i for i in range(1, count))
        and tree.scale.shape == tree.mean.shape
    )


def test_the_model_has_the_points_of_portraits() -> None:
    assert MODEL.face.mean.shape == (len(contours.PORTRAIT_LANDMARKS), 3)
    assert MODEL.neutral_difference_scale.shape == (CONTROL_POINT_COUNT, 3)
    assert is_valid(MODEL.face)
    first = sorted(MODEL.face.order[:CONTROL_POINT_COUNT])
    assert first == list(range(CONTROL_POINT_COUNT)), "a neutral pose is coded without the other points"


def test_the_regions_are_the_features_that_are_patched() -> None:
    assert tuple(feature.name for feature in FEATURES) == REGIONS
    for feature, region in zip(FEATURES, MODEL.regions, strict=True):
        assert is_valid(region.points) and region.points.mean.shape == (len(feature.points), 2)
        assert len(region.descriptor_scale) == len(feature.descriptor(np.zeros((CONTROL_POINT_COUNT, 3))))


def test_the_tables_of_blocks_are_complete() -> None:
    assert (MODEL.blocks.last.sum(axis=1) == TOTAL).all() and (MODEL.blocks.last > 0).all()
    assert (MODEL.blocks.coded > 0).all() and (MODEL.blocks.coded < TOTAL).all()


def test_tables_of_blocks_are_cumulative() -> None:
    coded, last = np.array([[1000, 30000]]), np.array([[TOTAL - 10, 7, 3]])
    scales = np.array([[4, 5, 6]])
    assert BlockModel(coded, last, scales).tables() == (
        [[[0, TOTAL - 1000, TOTAL], [0, TOTAL - 30000, TOTAL]]],
        [[0, TOTAL - 10, TOTAL - 3, TOTAL]],
        [[4, 5, 6]],
    )


def test_points_are_read_as_written_and_likely_ones_cost_less() -> None:
    tree = MODEL.regions[0].points
    sizes = []
    for noise in (0, 5, 60):
        points = tree.mean + np.random.default_rng(1).integers(-noise, noise + 1, tree.mean.shape)
        writer = SymbolWriter(rd_lambda=0)
        np.testing.assert_array_equal(tree.code(writer, points), points)
        data = writer.finish()
        sizes.append(len(data))
        np.testing.assert_array_equal(tree.code(SymbolReader(data), np.zeros_like(points)), points)
        np.testing.assert_array_equal(read_tree(Range(data), "mouth"), points)
    assert sizes == sorted(sizes) and sizes[0] < tree.mean.size / 2


def test_the_first_points_are_coded_alone() -> None:
    points = MODEL.face.mean[:CONTROL_POINT_COUNT] + 3
    writer = SymbolWriter(rd_lambda=0)
    MODEL.face.code(writer, points)
    read = MODEL.face.code(SymbolReader(writer.finish()), np.zeros_like(points))
    np.testing.assert_array_equal(read, points)


def test_coding_leaves_the_model_unchanged() -> None:
    mean = MODEL.face.mean.copy()
    MODEL.face.code(SymbolWriter(rd_lambda=0), mean + 5)
    np.testing.assert_array_equal(MODEL.face.mean, mean)


def test_numbers_are_coded_at_their_scales_with_the_tables_of_live() -> None:
    scales = np.array([[0, 12], [20, 28]])
    numbers = np.array([[0, 3], [-7, 40]])
    writer = SymbolWriter(rd_lambda=0)
    np.testing.assert_array_equal(code_numbers(writer, scales, numbers), numbers)
    string = Range(writer.finish())
    assert [read_number(string, live_tables(), scale) for scale in (0, 12, 20, 28)] == [0, 3, -7, 40]
    assert np.diff(difference_tables().cumulative, axis=1).tolist() == live_tables()


def test_the_model_holds_the_arrays_of_the_file() -> None:
    with MODEL_FILE.open("rb") as file:
        loaded = PortraitModel.load(file)
    with MODEL_FILE.open("rb") as file, np.load(file) as arrays:
        trees = {"face": loaded.face, "mouth": loaded.regions[0].points, "eyes": loaded.regions[1].points}
        for name, tree in trees.items():
            for key, field in (("mean", "mean"), ("order", "order"), ("parents", "parents"), ("spread", "scale")):
                np.testing.assert_array_equal(getattr(tree, field), arrays[f"{name}_{key}"])
                assert getattr(tree, field).dtype == np.int64
        for name, region in zip(("mouth", "eyes"), loaded.regions, strict=True):
            np.testing.assert_array_equal(region.descriptor_scale, arrays[f"{name}_key_spread"])
        np.testing.assert_array_equal(loaded.neutral_difference_scale, arrays["stir_spread"])
        np.testing.assert_array_equal(loaded.blocks.coded, arrays["coded"])
        np.testing.assert_array_equal(loaded.blocks.last, arrays["last"])
        np.testing.assert_array_equal(loaded.blocks.coefficient_scale, arrays["level_spread"])
