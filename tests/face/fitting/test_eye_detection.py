"""Spheres, nested spheres and shells in front of them at the eyes of the default head."""

import numpy as np
import pytest
import trimesh
from numpy.typing import NDArray

from conf.face.control_points import PUPILS
from conf.face.default_head import default_joints, default_points
from conf.face.fitting.eye_detection import Components, find_eyeball, fit_sphere, without_eye_covers
from conf.face.mesh.surface_graph import component_labels, triangle_edges
from tests.support.modified_heads import EYEBALLS, head_without

Arrays = tuple[NDArray[np.float64], NDArray[np.int32]]


def joined(*parts: Arrays) -> Arrays:
    starts = np.cumsum([0, *(len(vertices) for vertices, _ in parts)])
    triangles = [part[1] + start for part, start in zip(parts, starts, strict=False)]
    return np.concatenate([part[0] for part in parts]), np.concatenate(triangles).astype(np.int32)


def sphere(radius: float, height: tuple[float, float] | None = None) -> Arrays:
    """Return a sphere around the left eye's centre, or the front of it between two heights, relative to the radius."""
    ball = trimesh.creation.icosphere(subdivisions=3, radius=radius)
    vertices, triangles = np.asarray(ball.vertices), np.asarray(ball.faces)
    if height is not None:
        middle = vertices[triangles].mean(axis=1) / radius
        triangles = triangles[(middle[:, 2] > 0.4) & (middle[:, 1] > height[0]) & (middle[:, 1] < height[1])]
        used, triangles = np.unique(triangles, return_inverse=True)
        vertices, triangles = vertices[used], triangles.reshape(-1, 3)
    return vertices + default_joints().eyes["eye_l"], triangles.astype(np.int32)


def skin() -> Arrays:
    head = head_without(*EYEBALLS)
    return head.vertices, head.triangles


@pytest.mark.slow
def test_nested_shells_are_one_eyeball_and_a_strip_along_a_lid_is_none() -> None:
    vertices, triangles = joined(skin(), sphere(1.6), sphere(1.4), sphere(1.65, (-1.0, -0.6)))
    labels = component_labels(triangle_edges(triangles), len(vertices))
    eyeball = find_eyeball(Components.of(vertices, labels), default_points()[PUPILS[0]], {int(labels[0])})
    assert eyeball is not None
    assert abs(eyeball.radius - 1.6) < 0.02
    assert np.linalg.norm(eyeball.centre - default_joints().eyes["eye_l"]) < 0.02
    assert find_eyeball(Components.of(vertices, labels), default_points()[PUPILS[1]], {int(labels[0])}) is None


@pytest.mark.slow
def test_shells_before_the_eyeball_are_found() -> None:
    """They are a tear film along the lower lid, the shadow of the lids and lashes."""
    parts = (skin(), sphere(1.6), sphere(1.66, (-0.9, -0.5)), sphere(1.9, (-0.5, 0.5)), sphere(2.6, (0.0, 0.4)))
    vertices, triangles = joined(*parts)
    kept = without_eye_covers(vertices, triangles, default_points()[PUPILS])
    covers = sum(len(part[1]) for part in parts[2:])
    assert not kept[-covers:].any() and kept[:-covers].all()


@pytest.mark.slow
def test_without_eyeballs_nothing_covers_them() -> None:
    vertices, triangles = joined(skin(), sphere(1.66, (-0.5, -0.2)))
    assert without_eye_covers(vertices, triangles, default_points()[PUPILS]).all()


def test_a_sphere_is_fitted_exactly() -> None:
    centre, radius, error = fit_sphere(sphere(1.3)[0])
    np.testing.assert_allclose(
        [*(centre - default_joints().eyes["eye_l"]), radius, error], [0, 0, 0, 1.3, 0], atol=1e-9
    )


def test_an_eyeball_that_is_no_sphere_belongs_to_its_eye() -> None:
    """A head scaled in one direction has ellipsoids, which reach beyond the sphere that fits them."""
    ball = trimesh.creation.icosphere(subdivisions=3, radius=1.4)
    vertices = np.asarray(ball.vertices) * [1.35, 1.0, 1.0] + [3.2, 2.8, 2.0]
    components = Components.of(vertices, np.zeros(len(vertices), np.int32))
    eyeball = find_eyeball(components, np.array([3.2, 2.8, 3.4]), set())
    assert eyeball is not None
    assert eyeball.components == [0]
