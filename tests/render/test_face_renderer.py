from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from conf.errors import FileFormatError
from conf.face.control_points import control_point_indices
from conf.face.deformation.face_model import FaceModel
from conf.face.deformation.lip_opening import LipOpening
from conf.face.formats.mtl import MeshMaterial
from conf.face.furrows import SkinFurrows
from conf.face.head_pose import HeadPose
from conf.render.camera import ViewState, clip_matrix, project
from conf.render.face_renderer import FaceRenderer, ordered_parts
from conf.render.window.offscreen import OffscreenWindow
from tests.support.image_measures import Pixels, box, drawn
from tests.support.stand_in_head import SIZE

pytestmark = pytest.mark.slow

ASPECT = SIZE[0] / SIZE[1]


def pose(x: float = 0.0, y: float = 0.0, scale: float = 0.03, yaw: float = 0.0) -> HeadPose:
    return HeadPose(np.array([0.0, yaw, 0.0]), np.array([x, y]), float(np.log(scale)))


def rendered(window: OffscreenWindow, face: FaceModel, at: HeadPose, view: ViewState | None = None) -> Pixels:
    renderer = FaceRenderer(window.ctx, face)
    window.begin()
    renderer.draw(face.neutral, at, view or ViewState(), window.framebuffer)
    window.end()
    renderer.release()
    return window.read()


@pytest.mark.parametrize("at", [pose(), pose(0.3, 0.1, 0.02), pose(-0.4, -0.2, 0.015, yaw=0.7)])
def test_the_head_covers_the_pixels_its_vertices_project_to(
    window: OffscreenWindow, face: FaceModel, at: HeadPose
) -> None:
    used = face.mesh.vertices[np.unique(face.mesh.triangles)]
    corners = project(used, clip_matrix(at, ViewState(), aspect=ASPECT), SIZE)
    found = box(drawn(rendered(window, face, at)))
    np.testing.assert_allclose(found, [*corners.min(axis=0), *corners.max(axis=0)], atol=1.5)


def test_left_and_right_are_not_swapped(window: OffscreenWindow, face: FaceModel) -> None:
    vertices = face.mesh.vertices.copy()
    vertices[face.mesh.group_vertices("eye_r")] += [0.0, 0.0, -6.0]  # moves the right eye inside the skull
    mesh = replace(face.mesh, vertices=vertices)
    pixels = rendered(window, replace(face, mesh=mesh), pose()).astype(int)
    (x, y), (x_r, y_r) = project(face.control_points[[16, 17]], clip_matrix(pose(), ViewState(), aspect=ASPECT), SIZE)
    assert x > SIZE[0] / 2 > x_r and y == pytest.approx(y_r) and y < SIZE[1] / 2
    asymmetry = np.abs(pixels - pixels[:, ::-1]).sum(axis=2)
    eye = slice(int(y) - 6, int(y) + 6), slice(int(x) - 8, int(x) + 8)
    assert asymmetry[eye].mean() > 25  # only one side has an eye


def test_the_image_changes_only_with_the_pose(window: OffscreenWindow, face: FaceModel) -> None:
    still = rendered(window, face, pose())
    np.testing.assert_array_equal(still, rendered(window, face, pose()))
    assert (rendered(window, face, pose(yaw=0.05)) != still).any(axis=2).sum() > 500


def test_moved_vertices_are_drawn_moved(window: OffscreenWindow, face: FaceModel) -> None:
    renderer = FaceRenderer(window.ctx, face)
    tops = []
    for lift in (0.0, 2.0):
        window.begin()
        renderer.draw(face.neutral + np.array([0.0, lift, 0.0], np.float32), pose(), ViewState(), window.framebuffer)
        tops.append(box(drawn(window.read()))[1])
    renderer.release()
    assert tops[0] - tops[1] == pytest.approx(2.0 * 0.03 * SIZE[1], abs=2)


def test_the_key_light_comes_from_the_upper_left(window: OffscreenWindow, face: FaceModel) -> None:
    pixels = rendered(window, face, pose()).astype(int).sum(axis=2)
    upper_left, lower_right = pixels[90:100, 125:135].mean(), pixels[150:160, 195:205].mean()
    assert upper_left > 1.25 * lower_right


def test_an_occluder_of_the_key_light_casts_a_shadow(window: OffscreenWindow, face: FaceModel) -> None:
    """The hair, moved between the light and the nose, darkens the nose."""
    vertices = face.mesh.vertices.copy()
    vertices[face.mesh.group_vertices("hair")] += [-4.5, -2.0, 6.0]
    lit = rendered(window, face, pose()).astype(int).sum(axis=2)
    mesh = replace(face.mesh, vertices=vertices)
    shaded = rendered(window, replace(face, mesh=mesh), pose()).astype(int).sum(axis=2)
    nose = slice(115, 130), slice(155, 175)
    assert shaded[nose].mean() < 0.97 * lit[nose].mean()
    assert (shaded[nose] < 0.85 * lit[nose]).any()


def test_the_wireframe_has_the_same_outline_and_dark_gaps(window: OffscreenWindow, face: FaceModel) -> None:
    solid, wire = rendered(window, face, pose()), rendered(window, face, pose(), ViewState(wireframe=True))
    np.testing.assert_allclose(box(drawn(wire)), box(drawn(solid)), atol=3)
    inside = wire[90:150, 120:200].max(axis=2)
    assert (inside < 60).mean() > 0.2 and (inside > 100).mean() > 0.1


def test_a_face_is_drawn_into_its_viewport_only(window: OffscreenWindow, face: FaceModel) -> None:
    renderer = FaceRenderer(window.ctx, face)
    window.begin()
    for x in (0, 160):
        window.framebuffer.viewport = (x, 60, 160, 120)
        renderer.draw(face.neutral, pose(), ViewState(), window.framebuffer)
    pixels = window.read()
    renderer.release()
    assert not pixels[:60].any() and not pixels[180:].any()
    np.testing.assert_array_equal(pixels[60:180, :160], pixels[60:180, 160:])


def test_the_texture_is_upright_on_the_face(window: OffscreenWindow, face: FaceModel, tmp_path: Path) -> None:
    atlas = np.zeros((8, 8, 3), np.uint8)
    atlas[:4], atlas[4:] = (40, 40, 220), (220, 60, 40)  # red above blue
    cv2.imwrite(str(tmp_path / "atlas.png"), atlas)
    positions = face.mesh.vertices[face.mesh.render_vertices]
    low, high = positions.min(axis=0)[:2], positions.max(axis=0)[:2]
    mesh = replace(face.mesh, uvs=(positions[:, :2] - low) / (high - low), texture=tmp_path / "atlas.png")
    pixels = rendered(window, replace(face, mesh=mesh), pose()).astype(int)
    forehead, chin = pixels[75:82, 150:170].mean(axis=(0, 1)), pixels[170:180, 150:170].mean(axis=(0, 1))
    assert forehead[2] > 2 * forehead[0] and chin[0] > 2 * chin[2]


def test_an_invalid_texture_file_is_named(window: OffscreenWindow, face: FaceModel, tmp_path: Path) -> None:
    (tmp_path / "atlas.png").write_text("no picture")
    mesh = replace(face.mesh, texture=tmp_path / "atlas.png")
    with pytest.raises(FileFormatError, match=r"atlas\.png: expected a PNG, JPEG or WebP image"):
        FaceRenderer(window.ctx, replace(face, mesh=mesh))


def test_a_mesh_with_reversed_triangles_looks_the_same(window: OffscreenWindow, face: FaceModel) -> None:
    mesh = face.mesh
    reversed_mesh = replace(mesh, triangles=mesh.triangles[:, ::-1], render_triangles=mesh.render_triangles[:, ::-1])
    expected = rendered(window, face, pose()).astype(int)
    np.testing.assert_allclose(
        rendered(window, replace(face, mesh=reversed_mesh), pose()).astype(int), expected, atol=40
    )


def test_the_parts_partition_the_triangles_with_skin_first_and_hair_last(face: FaceModel) -> None:
    groups = {name: triangles for name, triangles in face.mesh.groups.items() if name != "eye_l"}
    parts = ordered_parts(replace(face.mesh, groups=groups))
    assert parts[0][0] == "skin" and parts[-1][0] == "hair"
    every = np.sort(np.concatenate([triangles for *_, triangles in parts]))
    np.testing.assert_array_equal(every, np.arange(len(face.mesh.triangles)))


def test_groups_that_are_drawn_alike_are_one_part_but_each_eye_and_each_material_is_its_own(face: FaceModel) -> None:
    count = len(face.mesh.triangles)
    names = ("brows", "eye_l", "teeth_upper", "ear", "eye_r", "hair", "lashes", "tongue", "nose")
    groups = {name: np.arange(i, count, len(names)) for i, name in enumerate(names)}
    mesh = replace(face.mesh, groups=groups)
    assert [name for name, *_ in ordered_parts(mesh)] == ["ear", "eye_l", "eye_r", "teeth_upper", "brows", "lashes"]
    sizes = {name: len(triangles) for name, _, triangles in ordered_parts(mesh)}
    assert sizes["ear"] == len(groups["ear"]) + len(groups["nose"])
    assert sizes["brows"] == len(groups["brows"]) + len(groups["hair"])
    halves = replace(
        mesh, materials=(MeshMaterial(), MeshMaterial()), triangle_materials=np.arange(count, dtype=np.int32) % 2
    )
    assert [part[:2] for part in ordered_parts(halves)][:3] == [("ear", 0), ("ear", 1), ("eye_l", 0)]


def test_a_rotated_head_shows_its_other_side(window: OffscreenWindow, face: FaceModel) -> None:
    back = HeadPose(Rotation.from_euler("Y", np.pi).as_rotvec(), np.zeros(2), float(np.log(0.03)))
    eyes = (slice(80, 100), slice(125, 195))
    front_pixels, back_pixels = (rendered(window, face, at)[eyes].astype(int) for at in (pose(), back))
    assert (np.abs(front_pixels - back_pixels).max(axis=2) > 40).mean() > 0.02


def test_a_smaller_internal_resolution_shows_the_same_face_in_the_same_size(
    window: OffscreenWindow, face: FaceModel
) -> None:
    images = []
    with FaceRenderer(window.ctx, face) as renderer:
        for scale in (1.0, 0.5):
            renderer.scale = scale
            window.begin()
            renderer.draw(face.neutral, pose(), ViewState(), window.framebuffer)
            assert renderer.target and renderer.target.size == (SIZE[0] * scale, SIZE[1] * scale)
            images.append(window.read().astype(int))
    assert 0.1 < np.abs(images[0] - images[1]).mean() < 3.0


def test_no_teeth_show_through_a_slit_between_the_lips(
    window: OffscreenWindow, face: FaceModel, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The whole head is drawn as teeth, so that they are visible whatever the lips do."""
    everything = {"teeth_upper": np.arange(len(face.mesh.triangles))}
    teeth = replace(face, mesh=replace(face.mesh, groups=everything))
    brightness = []
    for opening in (0.0, 0.02, 0.4):
        monkeypatch.setattr(LipOpening, "measure", lambda lips, vertices, opening=opening: opening)
        pixels = rendered(window, teeth, pose())
        brightness.append(float(pixels[drawn(pixels)].mean()))
    assert brightness[0] == pytest.approx(brightness[1], abs=2)
    assert brightness[2] > 1.5 * brightness[0]


def furrowed(window: OffscreenWindow, face: FaceModel, furrows: SkinFurrows) -> NDArray[np.int64]:
    with FaceRenderer(window.ctx, face) as renderer:
        window.begin()
        renderer.draw(face.neutral, pose(scale=0.05, y=-0.2), ViewState(), window.framebuffer, furrows=furrows)
        return window.read().astype(np.int64)


@pytest.mark.parametrize(
    ("furrows", "low", "high"),
    [(SkinFurrows(between_brows=1.0), (-1.7, -1.1), (1.7, 1.9)), (SkinFurrows(forehead=1.0), (-4.5, 0.5), (4.5, 3.9))],
)
def test_furrows_are_drawn_where_skin_folds(
    window: OffscreenWindow, face: FaceModel, furrows: SkinFurrows, low: tuple[float, float], high: tuple[float, float]
) -> None:
    """low, high : cm from the middle between the brows, to the subject's left and up"""
    change = np.abs(furrowed(window, face, furrows) - furrowed(window, face, SkinFurrows())).max(axis=2)
    middle = face.control_points[control_point_indices("brow_inner")].mean(axis=0)
    corners = np.stack([middle + np.array([*corner, 0.0]) for corner in (low, high)])
    (left, bottom), (right, top) = project(
        corners, clip_matrix(pose(scale=0.05, y=-0.2), ViewState(), aspect=ASPECT), SIZE
    )
    y, x = np.nonzero(change > 8)
    assert change.max() > 25 and len(x) > 30
    assert left <= x.min() and x.max() <= right and top <= y.min() and y.max() <= bottom
    np.testing.assert_allclose(
        x.mean(), (left + right) / 2, atol=4, err_msg="the furrows are symmetric, the light is not"
    )
