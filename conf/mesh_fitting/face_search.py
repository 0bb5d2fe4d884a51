"""Find the face in a mesh: render it, track the images, approach, and triangulate the landmarks."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from conf.face.fitting.face_prior import FacePrior
from conf.face.mesh.axes import axes_rotation
from conf.face.mesh.editing import submesh, weld_vertices
from conf.face.mesh.mesh import Mesh
from conf.face.mesh.raycast import cast_front_rays
from conf.face.similarity import SimilarityTransform
from conf.mesh_fitting.multiview import FRONT, IMAGE_SIZE, LandmarkView, MultiviewTracker, camera_pose, triangulate
from conf.render.window.offscreen import OffscreenWindow
from conf.sender.tracking.model_files import fetch_models
from conf.sender.tracking.tracker import FaceTracker

Progress = Callable[[float, str], None]  # called with the fraction that is done, and what is done now

COARSE_VIEWS = [(-15.0, 0.0), FRONT, (15.0, 0.0)]  # yaw and pitch, degrees
FINE_VIEWS = [(yaw, pitch) for yaw in (-20.0, 0.0, 20.0) for pitch in (-10.0, 0.0, 10.0)]
VIEW_CM = 24.0  # height of a close image
MESH_CM = 24.0  # height to which a mesh of unknown size is scaled first
SCALES = (1.0, 0.5, 0.25, 0.14)  # of the mesh's height that may be the face: all of it, or the top of a bust or figure
MIN_CORRELATION = 0.9  # of the landmarks with an upright face: 0.98 for faces, 0 for a face that lies on its side
MAX_RMS_CM = 0.85  # from the mean face: faces 0.14 to 0.53; false faces on a head upside down 1.2 to 3.3
MIN_FLATNESS = 1e-3  # height over the largest extent
HEAD_CM = 25.0  # radius around the eyes within which the mesh is kept
# Fractions of the whole fit, roughly by their time on a head that is upright in its file: until the mesh is read, until
# the tracker is loaded, until the face is found in one image, and until it is tracked from all sides.
READ, LOADED, FOUND, TRACKED = 0.05, 0.1, 0.2, 0.85


@dataclass(frozen=True)
class FaceSearchResult:
    """A face in a mesh.

    observed : (m, 3) triangulated landmarks, those of conf.face.fitting.face_prior, in the prior's frame
    frame : from the mesh's own coordinates to the prior's frame
    mesh : the part of the mesh around the face, in the prior's frame
    axes : of the mesh, (up, front)
    rms_from_mean_cm : RMS distance of the landmarks from the mean face
    """

    observed: NDArray[np.float64]
    frame: SimilarityTransform
    mesh: Mesh
    axes: tuple[str, str]
    rms_from_mean_cm: float


def find_face(
    mesh: Mesh, prior: FacePrior, *, axes: Sequence[tuple[str, str]], on_progress: Progress | None = None
) -> FaceSearchResult | None:
    """Return the face of a mesh, None if there is none.

    axes : orientations that the mesh may have, (up, front), tried until one shows a plausible face
    on_progress : fractions up to TRACKED
    Raises GraphicsError, ModelError.
    """
    mesh = submesh(weld_vertices(mesh), np.ones(len(mesh.triangles), dtype=bool))  # drops unused vertices
    best: FaceSearchResult | None = None
    with OffscreenWindow(IMAGE_SIZE, IMAGE_SIZE) as window:
        progress = _Progress(on_progress)
        progress.report(READ, "loading the face tracker")
        search = _FaceSearch(window, FaceTracker(fetch_models()), prior, progress)
        for number, (up, front) in enumerate(axes):
            fraction = LOADED + (FOUND - LOADED) * number / len(axes)
            progress.report(fraction, f"looking for the face, {up} up and {front} to the front")
            found = search.search(mesh, (up, front))
            if found is not None and (best is None or found.rms_from_mean_cm < best.rms_from_mean_cm):
                best = found
            if best is not None and best.rms_from_mean_cm < MAX_RMS_CM:
                break
    return best


class _Progress:
    """Reports fractions that never fall: a second orientation may be tracked after a first that was a false face."""

    def __init__(self, on_progress: Progress | None) -> None:
        self._on_progress = on_progress
        self._fraction = 0.0

    def report(self, fraction: float, text: str) -> None:
        self._fraction = max(self._fraction, fraction)
        if self._on_progress:
            self._on_progress(self._fraction, text)


@dataclass(frozen=True)
class _FaceSearch:
    window: OffscreenWindow
    tracker: FaceTracker
    prior: FacePrior
    progress: _Progress

    def search(self, mesh: Mesh, axes: tuple[str, str]) -> FaceSearchResult | None:
        """Search one orientation of a mesh, then triangulate twice, from nearer and from more sides."""
        frame = self._find_frame(mesh, axes_rotation(*axes))
        if frame is None:
            return None
        for views, done in ((COARSE_VIEWS, 0), (FINE_VIEWS, len(COARSE_VIEWS))):
            landmarks = self._triangulate(_crop_head(mesh, frame), views, done)
            if landmarks is None:
                return None
            step = self.prior.frame(landmarks)
            frame, observed = frame.then(step), step.apply(landmarks)
        rms = float(np.sqrt(((observed - self.prior.mean_observed) ** 2).sum(axis=1).mean()))
        return FaceSearchResult(observed, frame, _crop_head(mesh, frame), axes, rms)

    def _find_frame(self, mesh: Mesh, rotation: NDArray[np.float64]) -> SimilarityTransform | None:
        """Return the approximate transform to the prior's frame, from one image of a rotated mesh or of its top."""
        upright = mesh.vertices @ rotation.T
        low, high = upright.min(axis=0), upright.max(axis=0)
        extent = high - low
        if not extent[1] > MIN_FLATNESS * extent.max():  # seen edge on
            return None
        scale = float(MESH_CM / extent[1])
        to_cm = SimilarityTransform(rotation, scale, -scale * (low + high) / 2)
        scaled = replace(mesh, vertices=to_cm.apply(mesh.vertices))
        with MultiviewTracker(self.window, self.tracker, scaled, self.prior.mean) as multiview:
            for part in SCALES:
                height, centre = 1.15 * part * MESH_CM, (0.0, (1 - part) * MESH_CM / 2)
                for view in multiview.track_views(camera_pose(FRONT, height=height, centre=centre)):
                    step = initial_alignment(view.positions * height / 2 + centre, scaled, self.prior)
                    if step is not None:
                        return to_cm.then(step)
        return None

    def _triangulate(self, mesh: Mesh, views: list[tuple[float, float]], done: int) -> NDArray[np.float64] | None:
        """Return the landmarks (m, 3) from several views, None if fewer than two show a face.

        done : number of views that were tracked before
        """
        tracked: list[LandmarkView] = []
        total = len(COARSE_VIEWS) + len(FINE_VIEWS)
        with MultiviewTracker(self.window, self.tracker, mesh, self.prior.mean) as multiview:
            for number, view in enumerate(views, start=done):
                fraction = FOUND + (TRACKED - FOUND) * number / total
                self.progress.report(fraction, f"tracking the face from side {number + 1} of {total}")
                tracked += multiview.track_views(camera_pose(view, height=VIEW_CM, centre=(0.0, -0.5)))
        return triangulate(tracked) if len({view.clip.tobytes() for view in tracked}) > 1 else None


def initial_alignment(positions: NDArray[np.float64], mesh: Mesh, prior: FacePrior) -> SimilarityTransform | None:
    """Return scale and shift to the prior's frame from landmarks (m, 2) in an image, cm; None unless upright."""
    positions, mean = positions[: len(prior.mean)], prior.mean[:, :2]
    a, b = positions - positions.mean(axis=0), mean - mean.mean(axis=0)
    scale = float((a * b).sum() / (a * a).sum())
    correlation = float((a * b).sum() / np.sqrt((a * a).sum() * (b * b).sum()))
    depth = cast_front_rays(positions, mesh.vertices, mesh.triangles).points[:, 2]
    if correlation < MIN_CORRELATION or np.isnan(depth).all():  # lying or upside down, or no surface there
        return None
    z = float(np.nanmedian(prior.mean[:, 2] - scale * depth))
    shift = mean.mean(axis=0) - scale * positions.mean(axis=0)
    return SimilarityTransform(np.eye(3), scale, np.array([*shift, z]))


def _crop_head(mesh: Mesh, frame: SimilarityTransform) -> Mesh:
    """Return the part of the mesh around the face, in the prior's frame."""
    vertices = frame.apply(mesh.vertices)
    is_near = np.linalg.norm(vertices, axis=1) < HEAD_CM
    return submesh(replace(mesh, vertices=vertices), is_near[mesh.triangles].all(axis=1))
