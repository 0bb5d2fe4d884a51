"""A mesh sits for its portraits: find the face in it, come near, and see where the tracker sees its landmarks."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from conf.face.fitting.face_prior import FacePrior
from conf.face.mesh.axes import turn_upright
from conf.face.mesh.editing import part_of, welded
from conf.face.mesh.mesh import Mesh
from conf.face.mesh.raycast import front_hits
from conf.face.similarity import Similarity
from conf.mesh_fitting.multiview import FRONT, SIDE, Studio, pose_towards, triangulate
from conf.render.window.offscreen import OffscreenWindow
from conf.sender.tracking.model_files import fetch_models
from conf.sender.tracking.tracker import FaceTracker

Progress = Callable[[str], None]

ROUGH_SIDES = [(-15.0, 0.0), FRONT, (15.0, 0.0)]
FINE_SIDES = [(yaw, pitch) for yaw in (-20.0, 0.0, 20.0) for pitch in (-10.0, 0.0, 10.0)]
PICTURE_CM = 24.0  # height of a close drawing
WHOLE_CM = 24.0  # to what a mesh of unknown size is brought at first
# What may be the face: the whole mesh, or the top of a bust or a figure; share of the height, largest first.
SLICES = (1.0, 0.5, 0.25, 0.14)
LEAST_LIKENESS = 0.9  # of what is seen to an upright face: 0.98 for faces, 0 for one that lies on its side
FAMILIAR_CM = 0.85  # faces were seen 0.14 to 0.53 from the mean; what passes for one in a head on its crown 1.2 to 3.3
FLATTEST = 1e-3  # height over the largest extent
HEAD_CM = 25.0  # what lies farther from the eyes is not looked at


@dataclass(frozen=True)
class Sitting:
    """What came of it.

    observed : (m, 3) landmarks where the tracker sees them, those of conf.face.fitting.face_prior, in the prior's frame
    frame : what carries the mesh's own coordinates into the prior's frame
    mesh : the part of the mesh around the face, in the prior's frame
    axes : how the mesh stands, (up, front)
    strangeness : how far the landmarks are from the mean face, root mean square, cm
    """

    observed: NDArray[np.float64]
    frame: Similarity
    mesh: Mesh
    axes: tuple[str, str]
    strangeness: float


def observe(
    mesh: Mesh, prior: FacePrior, *, axes: Sequence[tuple[str, str]], on_progress: Progress | None = None
) -> Sitting | None:
    """Find the face of a mesh and see its landmarks from several sides; None if no face is seen.

    axes : ways the mesh may stand, (up, front) as `turn_upright` takes them, tried until one shows a familiar face
    Raises GraphicsError, ModelError.
    """
    mesh = part_of(welded(mesh), np.ones(len(mesh.triangles), dtype=bool))  # vertices that nothing uses say nothing
    tell = on_progress or (lambda text: None)
    best: Sitting | None = None
    with OffscreenWindow(SIDE, SIDE) as window:
        photographer = _Photographer(window, FaceTracker(fetch_models()), prior)
        for up, front in axes:
            tell(f"looking for the face, {up} up and {front} to the front")
            sitting = photographer.portray(mesh, (up, front))
            if sitting is not None and (best is None or sitting.strangeness < best.strangeness):
                best = sitting
            if best is not None and best.strangeness < FAMILIAR_CM:
                break
    return best


@dataclass(frozen=True)
class _Photographer:
    """Who draws and tracks, and what is known of faces."""

    window: OffscreenWindow
    tracker: FaceTracker
    prior: FacePrior

    def portray(self, mesh: Mesh, axes: tuple[str, str]) -> Sitting | None:
        """Look for a face in one orientation of a mesh, then look at it twice, nearer and from more sides."""
        frame = self._find(mesh, turn_upright(*axes))
        if frame is None:
            return None
        for sides in (ROUGH_SIDES, FINE_SIDES):
            seen = self._see(_closer(mesh, frame), sides)
            if seen is None:
                return None
            step = self.prior.frame(seen)
            frame, observed = frame.then(step), step.apply(seen)
        strangeness = float(np.sqrt(((observed - self.prior.seen) ** 2).sum(axis=1).mean()))
        return Sitting(observed, frame, _closer(mesh, frame), axes, strangeness)

    def _find(self, mesh: Mesh, turn: NDArray[np.float64]) -> Similarity | None:
        """Return roughly what carries a mesh, turned, into the prior's frame, from a drawing of it or of its top."""
        upright = mesh.vertices @ turn.T
        low, high = upright.min(axis=0), upright.max(axis=0)
        extent = high - low
        if not extent[1] > FLATTEST * extent.max():  # seen edge on there is nothing
            return None
        scale = float(WHOLE_CM / extent[1])
        whole = Similarity(turn, scale, -scale * (low + high) / 2)
        standing = replace(mesh, vertices=whole.apply(mesh.vertices))
        with Studio(self.window, self.tracker, standing, self.prior.mean) as studio:
            for share in SLICES:
                height, centre = 1.15 * share * WHOLE_CM, (0.0, (1 - share) * WHOLE_CM / 2)
                for sight in studio.look(pose_towards(FRONT, height=height, centre=centre)):
                    step = rough_frame(sight.places * height / 2 + centre, standing, self.prior)
                    if step is not None:
                        return whole.then(step)
        return None

    def _see(self, mesh: Mesh, sides: list[tuple[float, float]]) -> NDArray[np.float64] | None:
        """Return the (m, 3) landmarks as the tracker sees them from several sides, or None from fewer than two."""
        poses = [pose_towards(side, height=PICTURE_CM, centre=(0.0, -0.5)) for side in sides]
        with Studio(self.window, self.tracker, mesh, self.prior.mean) as studio:
            sights = [sight for pose in poses for sight in studio.look(pose)]
        clips = {sight.clip.tobytes() for sight in sights}
        return triangulate(sights) if len(clips) > 1 else None


def rough_frame(places: NDArray[np.float64], mesh: Mesh, prior: FacePrior) -> Similarity | None:
    """Return a size and a shift from where landmarks (m, 2) are seen in a drawing, cm; None unless upright."""
    places, seen = places[: len(prior.mean)], prior.mean[:, :2]
    a, b = places - places.mean(axis=0), seen - seen.mean(axis=0)
    scale = float((a * b).sum() / (a * a).sum())
    likeness = float((a * b).sum() / np.sqrt((a * a).sum() * (b * b).sum()))
    depth = front_hits(places, mesh.vertices, mesh.triangles).points[:, 2]
    if likeness < LEAST_LIKENESS or np.isnan(depth).all():  # lying or upside down, or no surface there
        return None
    back = float(np.nanmedian(prior.mean[:, 2] - scale * depth))
    return Similarity(np.eye(3), scale, np.array([*(seen.mean(axis=0) - scale * places.mean(axis=0)), back]))


def _closer(mesh: Mesh, near: Similarity) -> Mesh:
    """Return the part of the mesh around the face, in the prior's frame."""
    vertices = near.apply(mesh.vertices)
    around = np.linalg.norm(vertices, axis=1) < HEAD_CM
    return part_of(replace(mesh, vertices=vertices), around[mesh.triangles].all(axis=1))
