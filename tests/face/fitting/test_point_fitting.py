"""Control points fitted to the default head from observations with the tracker's mean error."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from numpy.typing import NDArray

from conf.face.control_points import CONTROL_POINT_COUNT, CONTROL_POINT_INDEX, PUPILS
from conf.face.default_head import DEFAULT_HEAD, default_points
from conf.face.fitting.face_prior import FacePrior, load_prior
from conf.face.fitting.point_fitting import FittedPoints, fit_control_points
from conf.face.mesh.mesh import Mesh, load_mesh
from conf.face.mesh.surface_graph import SurfaceGraph
from conf.face.similarity import fit_similarity

GROUPS = ("skin", "eye_l", "eye_r", "mouth", "tongue")


@cache
def head() -> tuple[Mesh, NDArray[np.float64], FacePrior]:
    """Return the default head, its control points and the prior, all in the prior's frame."""
    mesh, points, prior = load_mesh(DEFAULT_HEAD), default_points(), load_prior()
    frame = fit_similarity(points, prior.mean)
    triangles = np.concatenate([mesh.triangles[mesh.groups[name]] for name in GROUPS])
    visible = replace(mesh, vertices=frame.apply(mesh.vertices), triangles=triangles, groups={})
    return visible, frame.apply(points), prior


def fitted(noise: float = 0.0, groups: tuple[str, ...] = GROUPS) -> tuple[FittedPoints, NDArray[np.float64]]:
    mesh, truth, prior = head()
    observed = prior.mean_observed.copy()
    observed[:CONTROL_POINT_COUNT] += truth - prior.mean
    observed += np.random.default_rng(1).normal(size=observed.shape) * noise
    triangles = mesh.triangles
    if groups != GROUPS:
        whole = load_mesh(DEFAULT_HEAD)
        triangles = np.concatenate([whole.triangles[whole.groups[name]] for name in groups])
    return fit_control_points(observed, mesh.vertices, triangles, prior), truth


@pytest.mark.slow
@pytest.mark.parametrize("noise", [0.0, 0.05])
def test_points_are_fitted_close_to_the_true_ones(noise: float) -> None:
    result, truth = fitted(noise)
    errors = np.linalg.norm(result.points - truth, axis=1)
    assert errors.mean() < 0.2  # cm
    assert errors.max() < 0.6
    assert (result.lip_lines, result.eyeballs, result.mouth_open) == (3, 2, True)
    assert result.lid_edges >= 3


@pytest.mark.slow
def test_each_inner_lip_point_is_on_its_own_lip() -> None:
    mesh, points = head()[0], fitted(0.05)[0].points
    surface = SurfaceGraph(mesh.vertices, mesh.triangles)
    for side in ("mid", "l", "r"):
        names = [f"{edge}_lip_{lip}_{side}" for edge in ("outer", "inner") for lip in ("upper", "lower")]
        upper, lower, *inner = surface.nearest_vertices(
            points[[CONTROL_POINT_INDEX[name] for name in names]], tolerance=0.3
        )
        to_upper, to_lower = (surface.distances(np.array([lip]), limit=9.0)[inner] for lip in (upper, lower))
        assert to_upper[0] < to_lower[0]
        assert to_lower[1] < to_upper[1]


@pytest.mark.slow
def test_pupils_are_predicted_without_eyeballs() -> None:
    result, truth = fitted(groups=("skin", "mouth"))
    assert result.eyeballs == 0
    assert np.linalg.norm(result.points - truth, axis=1)[PUPILS].max() < 0.4


@pytest.mark.slow
def test_an_inside_out_mesh_gives_the_same_points() -> None:
    mesh, truth, prior = head()
    observed = prior.mean_observed.copy()
    observed[:CONTROL_POINT_COUNT] += truth - prior.mean
    flipped = np.ascontiguousarray(mesh.triangles[:, ::-1])
    points = fit_control_points(observed, mesh.vertices, flipped, prior).points
    np.testing.assert_allclose(points, fitted()[0].points, atol=1e-9)


@pytest.mark.slow
def test_pupils_lie_between_the_lids_on_their_eyeballs() -> None:
    mesh, truth, _ = head()
    points = fitted()[0].points
    for side in "lr":
        pupil, upper, lower = (
            points[CONTROL_POINT_INDEX[f"{name}_{side}"]] for name in ("pupil", "eyelid_upper", "eyelid_lower")
        )
        assert (pupil[1] - lower[1]) / (upper[1] - lower[1]) == pytest.approx(0.62, abs=1e-6)
        assert np.linalg.norm(pupil - truth[CONTROL_POINT_INDEX[f"pupil_{side}"]]) < 0.25
        assert np.linalg.norm(mesh.vertices - pupil, axis=1).min() < 0.15
