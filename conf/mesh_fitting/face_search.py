"""A mesh sits for its portraits: find the face in it, come near, and see where the tracker sees its landmarks."""

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
from conf.mesh_fitting.multiview import FRONT, IMAGE_SIZE, MultiviewTracker, camera_pose, triangulate
from conf.render.window.offscreen import OffscreenWindow
from conf.sender.tracking.model_files import fetch_models
from conf.sender.tracking.tracker import FaceTracker

Progress = Callable[[str], None]

ROUGH_SIDES = [(-15.0, 0.0), FRONT, (15.0, 0.0)]
FINE_SIDES = [(yaw, pitch) for yaw in (-20.0, 0.0, 20.0) for pitch in (-10.0, 0.0, 10.0)]
PICTURE_CM = 24.0  # height of a close drawing
WHOLE_CM = 24.0  # to what a mesh of unknown size is brought at first
# What may be the face: the whole mesh, or the top of a bust or a figure; share of the height, largest first.
SCALES = (1.0, 0.5, 0.25, 0.14)
MIN_CORRELATION = 0.9  # of what is seen to an upright face: 0.98 for faces, 0 for one that lies on its side
MAX_RMS_CM = 0.85  # faces were seen 0.14 to 0.53 from the mean; what passes for one in a head on its crown 1.2 to 3.3
FLATTEST = 1e-3  # height over the largest extent
HEAD_CM = 25.0  # what lies farther from the eyes is not looked at


@dataclass(frozen=True)
class FaceSearchResult:
    """What came of it.

    observed : (m, 3) landmarks where the tracker sees them, those of conf.face.fitting.face_prior, in the prior's frame
    frame : what carries the mesh's own coordinates into the prior's frame
    mesh : the part of the mesh around the face, in the prior's frame
    axes : how the mesh stands, (up, front)
    strangeness : how far the landmarks are from the mean face, root mean square, cm
    """

    observed: NDArray[np.float64]
    frame: SimilarityTransform
    mesh: Mesh
    axes: tuple[str, str]
    rms_from_mean_cm: float


def find_face(
    mesh: Mesh, prior: FacePrior, *, axes: Sequence[tuple[str, str]], on_progress: Progress | None = None
) -> FaceSearchResult | None:
    """Find the face of a mesh and see its landmarks from several sides; None if no face is seen.

    axes : ways the mesh may stand, (up, front) as `turn_upright` takes them, tried until one shows a familiar face
    Raises GraphicsError, ModelError.
    """
    mesh = submesh(
        weld_vertices(mesh), np.ones(len(mesh.triangles), dtype=bool)
    )  # vertices that nothing uses say nothing
    tell = on_progress or (lambda text: None)
    best: FaceSearchResult | None = None
    with OffscreenWindow(IMAGE_SIZE, IMAGE_SIZE) as window:
        photographer = _FaceSearch(window, FaceTracker(fetch_models()), prior)
        for up, front in axes:
            tell(f"looking for the face, {up} up and {front} to the front")
            sitting = photographer.search(mesh, (up, front))
            if sitting is not None and (best is None or sitting.rms_from_mean_cm < best.rms_from_mean_cm):
                best = sitting
            if best is not None and best.rms_from_mean_cm < MAX_RMS_CM:
                break
    return best


@dataclass(frozen=True)
class _FaceSearch:
    """Who draws and tracks, and what is known of faces."""

    window: OffscreenWindow
    tracker: FaceTracker
    prior: FacePrior

    def search(self, mesh: Mesh, axes: tuple[str, str]) -> FaceSearchResult | None:
        """Look for a face in one orientation of a mesh, then look at it twice, nearer and from more sides."""
        frame = self._find(mesh, axes_rotation(*axes))
        if frame is None:
            return None
        for sides in (ROUGH_SIDES, FINE_SIDES):
            seen = self._see(_closer(mesh, frame), sides)
            if seen is None:
                return None
            step = self.prior.frame(seen)
            frame, observed = frame.then(step), step.apply(seen)
        strangeness = float(np.sqrt(((observed - self.prior.mean_observed) ** 2).sum(axis=1).mean()))
        return FaceSearchResult(observed, frame, _closer(mesh, frame), axes, strangeness)

    def _find(self, mesh: Mesh, turn: NDArray[np.float64]) -> SimilarityTransform | None:
        """Return roughly what carries a mesh, turned, into the prior's frame, from a drawing of it or of its top."""
        upright = mesh.vertices @ turn.T
        low, high = upright.min(axis=0), upright.max(axis=0)
        extent = high - low
        if not extent[1] > FLATTEST * extent.max():  # seen edge on there is nothing
            return None
        scale = float(WHOLE_CM / extent[1])
        whole = SimilarityTransform(turn, scale, -scale * (low + high) / 2)
        standing = replace(mesh, vertices=whole.apply(mesh.vertices))
        with MultiviewTracker(self.window, self.tracker, standing, self.prior.mean) as studio:
            for share in SCALES:
                height, centre = 1.15 * share * WHOLE_CM, (0.0, (1 - share) * WHOLE_CM / 2)
                for sight in studio.track_views(camera_pose(FRONT, height=height, centre=centre)):
                    step = initial_alignment(sight.places * height / 2 + centre, standing, self.prior)
                    if step is not None:
                        return whole.then(step)
        return None

    def _see(self, mesh: Mesh, sides: list[tuple[float, float]]) -> NDArray[np.float64] | None:
        """Return the (m, 3) landmarks as the tracker sees them from several sides, or None from fewer than two."""
        poses = [camera_pose(side, height=PICTURE_CM, centre=(0.0, -0.5)) for side in sides]
        with MultiviewTracker(self.window, self.tracker, mesh, self.prior.mean) as studio:
            sights = [sight for pose in poses for sight in studio.track_views(pose)]
        clips = {sight.clip.tobytes() for sight in sights}
        return triangulate(sights) if len(clips) > 1 else None


def initial_alignment(places: NDArray[np.float64], mesh: Mesh, prior: FacePrior) -> SimilarityTransform | None:
    """Return a size and a shift from where landmarks (m, 2) are seen in a drawing, cm; None unless upright."""
    places, seen = places[: len(prior.mean)], prior.mean[:, :2]
    a, b = places - places.mean(axis=0), seen - seen.mean(axis=0)
    scale = float((a * b).sum() / (a * a).sum())
    likeness = float((a * b).sum() / np.sqrt((a * a).sum() * (b * b).sum()))
    depth = cast_front_rays(places, mesh.vertices, mesh.triangles).points[:, 2]
    if likeness < MIN_CORRELATION or np.isnan(depth).all():  # lying or upside down, or no surface there
        return None
    back = float(np.nanmedian(prior.mean[:, 2] - scale * depth))
    return SimilarityTransform(np.eye(3), scale, np.array([*(seen.mean(axis=0) - scale * places.mean(axis=0)), back]))


def _closer(mesh: Mesh, near: SimilarityTransform) -> Mesh:
    """Return the part of the mesh around the face, in the prior's frame."""
    vertices = near.apply(mesh.vertices)
    around = np.linalg.norm(vertices, axis=1) < HEAD_CM
    return submesh(replace(mesh, vertices=vertices), around[mesh.triangles].all(axis=1))
