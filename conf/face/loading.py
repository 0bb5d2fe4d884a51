"""Load a face from its files: mesh, control points, rig and blendshapes."""

from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from conf.disk_cache import cache_key, cached
from conf.errors import FileFormatError
from conf.face.default_head import DEFAULT_HEAD, default_joints
from conf.face.deformation.blendshapes import Blendshapes, load_blendshapes
from conf.face.deformation.face_model import DeformerOptions, FaceModel
from conf.face.deformation.operator_builder import OperatorBuilder
from conf.face.deformation.rbf import Operator
from conf.face.deformation.rig import Rig
from conf.face.deformation.rig_builder import build_rig
from conf.face.fitting.custom_face import prepare_face
from conf.face.formats.ppc import read_ppc
from conf.face.head_catalogue import Head
from conf.face.head_variant import read_head_variant
from conf.face.mesh.mesh import Mesh, load_mesh

_CACHE_VERSION = 20  # raise whenever the way from the files to the operator changes


def load_face(path: Path | str | None = None, /, *, kernel: str = "multiquadric") -> FaceModel:
    """Load the default head, or any mesh whose control points are in a PPC file of the same name beside it.

    Raises FileFormatError if a file is missing or malformed, ValueError for an unknown kernel.
    """
    path = DEFAULT_HEAD if path is None else Path(path)
    ppc = path.with_suffix(".ppc")
    mesh = load_mesh(path)
    if not ppc.exists():
        raise FileFormatError(ppc, None, f"expected a file; `conf fit {path}` makes it")
    points, options = read_ppc(ppc), DeformerOptions(kernel)
    if path.resolve() == DEFAULT_HEAD.resolve():
        blendshapes = load_blendshapes(path.with_name("shapes.npz"), len(mesh.vertices))
        rig = build_rig(mesh, points, default_joints(), blendshapes)
        return build_face(mesh, points, options, rig=rig, blendshapes=blendshapes)
    try:
        face = prepare_face(mesh, points)
    except ValueError as error:
        raise FileFormatError(ppc, None, f"expected the points of this face: {error}") from error
    return replace(build_face(face.mesh, face.points, options, rig=face.rig), file_to_model=face.file_to_model)


def load_head(head: Head, /, *, kernel: str = "multiquadric") -> FaceModel:
    """Load one of the shipped heads.

    Raises FileFormatError if a file is missing or malformed, ValueError for an unknown kernel.
    """
    if head.is_default:
        return load_face(kernel=kernel)
    default = load_mesh(DEFAULT_HEAD)
    shapes = load_blendshapes(DEFAULT_HEAD.with_name("shapes.npz"), len(default.vertices))
    own = read_head_variant(head.path, default, shapes)
    rig = build_rig(own.mesh, own.points, own.joints, own.blendshapes)
    return build_face(own.mesh, own.points, DeformerOptions(kernel), rig=rig, blendshapes=own.blendshapes)


def build_face(
    mesh: Mesh,
    points: NDArray[np.float64],
    options: DeformerOptions | None = None,
    /,
    *,
    rig: Rig | None = None,
    blendshapes: Blendshapes | None = None,
) -> FaceModel:
    """Build a face; read its operator from the user's cache if the same face was built before.

    points : (n, 3) control points on the mesh, model centimetres
    blendshapes : of the mesh; the operator is refined on them
    Raises ValueError for an unknown kernel, or control points that all coincide.
    """
    options = options or DeformerOptions()
    builder = OperatorBuilder(mesh, points, rig, blendshapes)
    rigid = b"" if rig is None else rig.rigid
    jaw = b"" if rig is None or rig.jaw is None else rig.jaw.weighted_offsets
    lids = b"" if rig is None or rig.eyelid_helpers is None else rig.eyelid_helpers.weights
    parts = (rigid, jaw, lids, b"" if blendshapes is None else blendshapes.offsets)
    key = cache_key(_CACHE_VERSION, mesh.vertices, mesh.triangles, points, builder.anchors, *parts, options)
    operator = cached("operators", key, lambda: builder.build(options), Operator)
    return builder.face(operator)
