"""A mesh sits for its portraits: find the face in it, come near, and see where the tracker sees its landmarks."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from conf.commands.portraits import FRONT, SIDE, Studio, pose_towards, triangulate
from conf.face.casting import front_hits
from conf.face.face_prior import FacePrior, Similarity
from conf.face.mesh import Mesh
from conf.face.orientation import turn_upright
from conf.receiver.offscreen import OffscreenWindow
from conf.sender.models import fetch_models
from conf.sender.tracker import FaceTracker

Progress = Callable[[str], None]

ROUGH_SIDES = [(-15.0, 0.0), FRONT, (15.0, 0.0)]
FINE_SIDES = [(yaw, pitch) for yaw in (-20.0, 0.0, 20.0) for pitch in (-10.0, 0.0, 10.0)]
PICTURE_CM = 24.0  # height of a close drawing
WHOLE_CM = 24.0  # to what a mesh of unknown size is brought at first
# What may be the face: the whole mesh, or the top of a bust or a figure; share of the height, largest first.
SLICES = (1.0, 0.5, 0.25, 0.14)
LEAST_LIKENESS = 0.9  # of what is seen to an upright face: 0.98 for faces, 0 for one that lies on its side
HEAD_CM = 25.0  # what lies farther from the eyes is not looked at


@dataclass(frozen=True)
class Sitting:
    """What came of it.

    observed : (m, 3) landmarks where the tracker sees them, those of conf.face.face_prior, in the prior's frame
    frame : what carries the mesh's own coordinates into the prior's frame
    mesh : the part of the mesh around the face, in the prior's frame
    axes : how the mesh stands, (up, front)
    """

    observed: NDArray[np.float64]
    frame: Similarity
    mesh: Mesh
    axes: tuple[str, str]


def observe(
    mesh: Mesh,
    prior: FacePrior,
    *,
    axes: Sequence[tuple[str, str]] = (("y", "z"),),
    on_progress: Progress | None = None,
) -> Sitting | None:
    """Find the face of a mesh and see its landmarks from several sides; None if no face is seen.

    axes : ways the mesh may stand, (up, front) as `turn_upright` takes them, tried in turn
    Raises GraphicsError, ModelError.
    """
    tell = on_progress or (lambda text: None)
    mesh = part_of(welded(mesh), np.ones(len(mesh.triangles), dtype=bool))  # vertices that nothing uses say nothing
    tracker = FaceTracker(fetch_models())
    with OffscreenWindow(SIDE, SIDE) as window:
        for up, front in axes:
            tell(f"looking for the face, {up} up and {front} to the front")
            frame = _find_face(window, tracker, mesh, prior, turn_upright(up, front))
            for sides in (ROUGH_SIDES, FINE_SIDES):
                if frame is not None:
                    tell(f"looking at it from {len(sides)} sides")
                    seen = _observe(window, tracker, _closer(mesh, frame), sides, prior)
                    step = None if seen is None else prior.frame(seen)
                    frame = None if step is None else _chain(frame, step)
            if frame is not None and seen is not None and step is not None:
                return Sitting(step.apply(seen), frame, _closer(mesh, frame), (up, front))
    return None


def welded(mesh: Mesh, /) -> Mesh:
    """Join vertices at one place where the file repeats every one of them (STL), so that light runs smooth."""
    if len(mesh.vertices) < 3 * len(mesh.triangles):
        return mesh
    places, inverse = np.unique(mesh.vertices, axis=0, return_inverse=True)
    triangles = inverse.ravel()[mesh.triangles].astype(np.int32)
    ones = np.arange(len(places), dtype=np.int32)
    return replace(
        mesh, vertices=places, triangles=triangles, render_triangles=triangles, render_vertices=ones,
        uvs=np.zeros((len(places), 2)), texture=None,
    )  # fmt: skip


def _find_face(
    window: OffscreenWindow, tracker: FaceTracker, mesh: Mesh, prior: FacePrior, turn: NDArray[np.float64]
) -> Similarity | None:
    """Return roughly what carries a mesh, turned, into the prior's frame, from one drawing of it or of its top."""
    upright = mesh.vertices @ turn.T
    low, high = upright.min(axis=0), upright.max(axis=0)
    scale = WHOLE_CM / max(float((high - low)[1]), 1e-300)
    whole = Similarity(turn, scale, -scale * (low + high) / 2)
    standing = replace(mesh, vertices=whole.apply(mesh.vertices))
    studio = Studio(window, tracker, standing, prior.mean)
    try:
        for share in SLICES:
            height = 1.15 * share * WHOLE_CM
            centre = (0.0, (1 - share) * WHOLE_CM / 2)
            for sight in studio.look(pose_towards(FRONT, height=height, centre=centre)):
                places = sight.places * height / 2 + centre
                step = _rough_frame(places, standing, prior)
                if step is not None:
                    return _chain(whole, step)
    finally:
        studio.release()
    return None


def _rough_frame(places: NDArray[np.float64], mesh: Mesh, prior: FacePrior) -> Similarity | None:
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


def part_of(mesh: Mesh, kept: NDArray[np.bool_], /) -> Mesh:
    """Return the triangles that are kept, (F,), and the vertices they use."""
    used, triangles = np.unique(mesh.triangles[kept], return_inverse=True)
    used_rows, rows = np.unique(mesh.render_triangles[kept], return_inverse=True)
    numbers = np.cumsum(kept) - 1
    groups = {name: numbers[members[kept[members]]] for name, members in mesh.groups.items()}
    return replace(
        mesh,
        vertices=mesh.vertices[used],
        triangles=triangles.reshape(-1, 3).astype(np.int32),
        uvs=mesh.uvs[used_rows],
        render_vertices=np.searchsorted(used, mesh.render_vertices[used_rows]).astype(np.int32),
        render_triangles=rows.reshape(-1, 3).astype(np.int32),
        groups={name: members for name, members in groups.items() if len(members)},
    )


def _observe(
    window: OffscreenWindow, tracker: FaceTracker, mesh: Mesh, sides: list[tuple[float, float]], prior: FacePrior
) -> NDArray[np.float64] | None:
    """Return the (m, 3) landmarks as the tracker sees them from several sides, or None from fewer than two."""
    studio = Studio(window, tracker, mesh, prior.mean)
    try:
        sights = [s for side in sides for s in studio.look(pose_towards(side, height=PICTURE_CM, centre=(0.0, -0.5)))]
    finally:
        studio.release()
    clips = {sight.clip.tobytes() for sight in sights}
    return triangulate(sights) if len(clips) > 1 else None


def _chain(first: Similarity, then: Similarity) -> Similarity:
    """Return the two, one after the other."""
    return Similarity(then.rotation @ first.rotation, then.scale * first.scale, then.apply(first.shift))
