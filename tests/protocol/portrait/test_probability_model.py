from pathlib import Path

import numpy as np

from conf.face.control_points import CONTROL_POINT_COUNT
from conf.face.portrait import contours
from conf.face.portrait.patch_features import FEATURES
from conf.protocol.codec.range_coder import TOTAL
from conf.protocol.codec.symbol_coder import SymbolReader, SymbolWriter
from conf.protocol.portrait.probability_model import REGIONS, PointTree, PortraitModel, load_portrait_model

MODEL = load_portrait_model()


def sound(tree: PointTree) -> bool:
    count = len(tree.mean)
    return (
        sorted(tree.order) == list(range(count))
        and tree.parents[0] == -1
        and all(0 <= tree.parents[i] < i for i in range(1, count))
        and tree.scale.shape == tree.mean.shape
    )


def test_the_model_has_the_points_that_both_sides_use() -> None:
    assert MODEL.face.mean.shape == (len(contours.PORTRAIT_LANDMARKS), 3) and MODEL.neutral_difference_scale.shape == (
        CONTROL_POINT_COUNT,
        3,
    )
    assert sound(MODEL.face)
    assert sorted(MODEL.face.order[:CONTROL_POINT_COUNT]) == list(range(CONTROL_POINT_COUNT)), "a neutral pose is alone"


def test_the_regions_are_the_features_that_are_patched() -> None:
    assert tuple(feature.name for feature in FEATURES) == REGIONS
    for feature, region in zip(FEATURES, MODEL.regions, strict=True):
        assert sound(region.points) and region.points.mean.shape == (len(feature.points), 2)
        assert len(region.descriptor_scale) == len(feature.descriptor(np.zeros((CONTROL_POINT_COUNT, 3))))


def test_the_tables_of_blocks_add_up() -> None:
    assert (MODEL.blocks.last.sum(axis=1) == TOTAL).all() and (MODEL.blocks.last > 0).all()
    assert (MODEL.blocks.coded > 0).all() and (MODEL.blocks.coded < TOTAL).all()


def test_points_come_back_and_likely_ones_cost_less() -> None:
    tree = MODEL.regions[0].points
    sizes = []
    for noise in (0, 5, 60):
        wanted = tree.mean + np.random.default_rng(1).integers(-noise, noise + 1, tree.mean.shape)
        writer = SymbolWriter(rd_lambda=0)
        tree.code(writer, wanted)
        data = writer.finish()
        sizes.append(len(data))
        np.testing.assert_array_equal(tree.code(SymbolReader(data), np.zeros_like(wanted)), wanted)
    assert sizes == sorted(sizes) and sizes[0] < tree.mean.size / 2


def test_a_model_is_kept_in_a_file(tmp_path: Path) -> None:
    MODEL.save(tmp_path / "portrait.npz")
    again = PortraitModel.load(tmp_path / "portrait.npz")
    np.testing.assert_array_equal(again.face.scale, MODEL.face.scale)
    np.testing.assert_array_equal(again.blocks.last, MODEL.blocks.last)
    np.testing.assert_array_equal(again.regions[1].descriptor_scale, MODEL.regions[1].descriptor_scale)
