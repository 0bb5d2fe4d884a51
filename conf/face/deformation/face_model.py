"""A face that can be moved: mesh, control points, operator and rigid parts together."""

from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from conf.errors import FileFormatError
from conf.face.control_points import PUPILS
from conf.face.default_head import DEFAULT_HEAD as DEFAULT_HEAD
from conf.face.deformation.anchors import choose_anchors
from conf.face.deformation.blendshapes import Blendshapes, load_shapes
from conf.face.deformation.eyelid_helpers import append_helpers, fold_helpers
from conf.face.deformation.kernels import KERNELS
from conf.face.deformation.operator_cache import cache_key, cached_operator
from conf.face.deformation.rbf import Operator, build_operator
from conf.face.deformation.regions import Regions, split_regions
from conf.face.deformation.ridge_refinement import refine_with_blendshapes, subtract_jaw_motion
from conf.face.deformation.rig import Rig, jaw_offsets
from conf.face.deformation.rig_json import load_rig
from conf.face.fapu import Fapu
from conf.face.fitting.custom_face import prepare_face
from conf.face.formats.ppc import read_ppc
from conf.face.head_pose import ES0_CM
from conf.face.mesh.mesh import Mesh, load_mesh
from conf.face.mesh.surface_graph import SurfaceGraph
from conf.face.similarity import IDENTITY, SimilarityTransform

_CACHE_VERSION = 12  # one more whenever the way from the files to the operator changes


@dataclass(frozen=True)
class DeformerOptions:
    """How control points carry the skin: what the user may choose.

    kernel : a name from KERNELS
    epsilon : locality, 1/cm; None takes the kernel's own
    degree : of the polynomial, -1 none to 1 linear; None takes the least that is sound
    smoothing : lambda; a little halves what the tracker's noise does to the skin where two points are close, and keeps
        every point within 0.4 mm of where it is told to be; 0 keeps it there exactly
    split : keep the lips and the lids apart by regions of influence
    learned : refine the operator on the face's sculpted shapes, if it has any
    """

    kernel: str = "multiquadric"
    epsilon: float | None = None
    degree: int | None = None
    smoothing: float = 0.02
    use_regions: bool = True
    use_ridge_refinement: bool = True


@dataclass(frozen=True)
class FaceModel:
    """A neutral face and what moves it, in model centimetres (6.4 between the pupils).

    control_points : (n, 3) float64, neutral
    fapu : the face's own units
    operator : (V, n) float32, vertex offsets for displacements of the control points
    smoothing : the lambda the operator took; more than asked for says that the system was singular
    rig : rigid parts, if the face has any
    placement : what carried the file's coordinates to model centimetres
    """

    mesh: Mesh
    control_points: NDArray[np.float64]
    fapu: Fapu
    operator: NDArray[np.float32]
    smoothing: float = 0.0
    rig: Rig | None = None
    placement: SimilarityTransform = IDENTITY

    @cached_property
    def neutral(self) -> NDArray[np.float32]:
        """The (V, 3) vertices at rest."""
        return self.mesh.vertices.astype(np.float32)

    @cached_property
    def _units(self) -> NDArray[np.float32]:
        return self.fapu.lengths().astype(np.float32)

    def deform(
        self, displacements: NDArray[np.floating], /, *, out: NDArray[np.float32] | None = None
    ) -> NDArray[np.float32]:
        """Move the face.

        displacements : (n, 3) FAPU units, head pose removed
        out : (V, 3) float32 to write to; without it a new array is made
        Returns (V, 3) float32, model centimetres.
        """
        offsets = np.asarray(displacements, dtype=np.float32) * self._units
        if self.rig is None:
            vertices = np.matmul(self.operator, offsets, out=out)
            vertices += self.neutral
            return vertices
        carried, jaw, points = offsets, self.rig.jaw, self.control_points
        if jaw is not None:
            motion = jaw.estimate_motion(points, offsets)
            carried = offsets - jaw_offsets(jaw.point_arms, jaw.point_shares, motion)
        vertices = np.matmul(self.operator, carried, out=out)
        vertices += self.neutral
        if jaw is not None:
            vertices[jaw.vertices] += jaw_offsets(jaw.weighted_offsets, jaw.weights, motion)
        for eye in self.rig.eyes:
            eye.apply(self.neutral, vertices, np.stack([points[eye.pupil], offsets[eye.pupil]]))
        return vertices

    def deformed_points(self, displacements: NDArray[np.floating], /) -> NDArray[np.float32]:
        """Return the (n, 3) control points where the displacements (FAPU units) have taken them, model centimetres."""
        return self.control_points.astype(np.float32) + np.asarray(displacements, dtype=np.float32) * self._units

    def to_file_coordinates(self, places: NDArray[np.floating], /) -> NDArray[np.float64]:
        """Return (..., 3) places, model centimetres, in the coordinates and the unit of the face's own file."""
        return self.placement.inverse_apply(np.asarray(places, np.float64))


def load_face(path: Path | str | None = None, /, *, kernel: str = "multiquadric") -> FaceModel:
    """Open a face: the default head, or any mesh with its control points in a PPC file of the same name beside it.

    Raises FileFormatError if a file is missing or is not what it should be; ValueError for an unknown kernel.
    """
    path = DEFAULT_HEAD if path is None else Path(path)
    mesh = load_mesh(path)
    if not path.with_suffix(".ppc").exists():
        raise FileFormatError(path.with_suffix(".ppc"), None, f"expected a file; `conf fit {path}` makes it")
    points = read_ppc(path.with_suffix(".ppc"))
    if path.resolve() == DEFAULT_HEAD.resolve():
        shapes = load_shapes(path.with_name("shapes.npz"), len(mesh.vertices))
        rig = load_rig(path.with_name("rig.json"), mesh, points, shapes)
        return build_face(mesh, points, DeformerOptions(kernel), rig=rig, shapes=shapes)
    try:
        own = prepare_face(mesh, points)
    except ValueError as error:
        raise FileFormatError(path.with_suffix(".ppc"), None, f"expected the points of this face: {error}") from error
    return replace(build_face(own.mesh, own.points, DeformerOptions(kernel), rig=own.rig), placement=own.file_to_model)


def build_face(
    mesh: Mesh,
    points: NDArray[np.float64],
    deformer: DeformerOptions | None = None,
    /,
    *,
    rig: Rig | None = None,
    shapes: Blendshapes | None = None,
) -> FaceModel:
    """Put a face together; its operator comes from the cache if it was there before.

    points : (n, 3) control points on the mesh, model centimetres
    shapes : sculpted shapes of the mesh that the operator is refined on
    """
    deformer = deformer or DeformerOptions()
    if deformer.kernel not in KERNELS:
        raise ValueError(f"kernel must be one of {', '.join(KERNELS)}, got {deformer.kernel!r}")
    known = None if rig is None else rig.anchors
    anchors = choose_anchors(mesh.vertices, points, eye_distance=ES0_CM, initial=known)
    learned = b"" if shapes is None else shapes.offsets
    rigid = b"" if rig is None else rig.rigid
    jaw = b"" if rig is None or rig.jaw is None else rig.jaw.weighted_offsets
    lids = b"" if rig is None or rig.margins is None else rig.margins.weights
    parts = (rigid, jaw, lids, learned)
    key = cache_key(_CACHE_VERSION, mesh.vertices, mesh.triangles, points, anchors, *parts, deformer)
    shape = (len(mesh.vertices), len(points))
    operator = cached_operator(key, shape, lambda: _operator(mesh, points, deformer, anchors, rig, shapes))
    return FaceModel(mesh, points, Fapu.measure(points), operator.matrix, operator.smoothing, rig)


def _operator(
    mesh: Mesh,
    points: NDArray[np.float64],
    deformer: DeformerOptions,
    anchors: NDArray[np.float64],
    rig: Rig | None,
    shapes: Blendshapes | None,
) -> Operator:
    kernel = KERNELS[deformer.kernel]
    if deformer.degree is not None:
        kernel = replace(kernel, degree=deformer.degree)
    surface = SurfaceGraph(mesh.vertices, mesh.triangles)
    whole = Regions.unrestricted(len(mesh.vertices), anchors=anchors)
    regions = split_regions(surface, points, anchors=anchors) if deformer.use_regions else whole
    regions = regions.excluding(PUPILS)  # a pupil turns its eyeball; skin does not follow it
    margins = None if rig is None else rig.margins
    centres, fields = append_helpers(points, regions, margins)
    operator = build_operator(
        mesh.vertices,
        centres,
        kernel=kernel,
        epsilon=deformer.epsilon or kernel.epsilon,
        regions=fields,
        smoothing=deformer.smoothing,
    )
    matrix = fold_helpers(operator.matrix, margins)
    if shapes is not None and deformer.use_ridge_refinement:
        displacements, offsets = shapes.offsets_at(surface.nearest_vertices(points, tolerance=0.0)), shapes.offsets
        if rig is not None and rig.jaw is not None:
            displacements, offsets = subtract_jaw_motion(rig.jaw, points, displacements, offsets)
        matrix = refine_with_blendshapes(matrix, displacements, offsets, regions=regions)
    if rig is not None:
        matrix[rig.rigid] = 0.0
    return Operator(matrix, operator.smoothing)
