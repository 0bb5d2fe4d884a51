"""Put the default head's teeth and tongue into a mouth that has none, or has placeholders only."""

from dataclasses import replace
from functools import cache

import numpy as np
from numpy.typing import NDArray

from conf.face.control_points import CONTROL_POINT_INDEX, control_point_indices
from conf.face.default_head import DEFAULT_HEAD, default_points
from conf.face.mesh.edge_split import drop_triangles
from conf.face.mesh.editing import submesh
from conf.face.mesh.mesh import Mesh, load_mesh
from conf.face.mesh.raycast import cast_front_rays

TEETH = ("teeth_upper", "teeth_lower")
GROUPS = (*TEETH, "tongue")
_MIN_TRIANGLES = 112  # of an arch without a texture, 8 a tooth: fewer are a plain band, which looks like a mouthguard
_SCALES = (0.75, 1.1)  # of the default head's teeth
_STEP, _STEPS = 0.15, 10  # cm by which the teeth are moved back, and how often, until the closed lips hide them
_COVER = (0.05, 0.3)  # cm of skin before the teeth: at the line of the lips, and at the roots, where it moves less
_MAX_VISIBLE = 0.02  # fraction of the vertices
# Where a tongue lies: half width relative to the teeth's, height about their edge, least and most behind them, cm.
_TONGUE_BOX = 0.25, 0.9, 0.9, 3.5
_CORNERS = control_point_indices("inner_lip_corner")
_SEAM = [CONTROL_POINT_INDEX[f"inner_lip_{lip}_mid"] for lip in ("upper", "lower")]


def complete_teeth(mesh: Mesh, points: NDArray[np.float64], /, *, outwards: bool) -> tuple[Mesh, str | None]:
    """Return the mesh with teeth and tongue as far as it has none, and a remark on what was put in.

    Arguments are those of `insert_teeth`.
    """
    own = [group for group in TEETH if group in mesh.groups]
    if not own:
        return insert_teeth(mesh, points, outwards=outwards), "no teeth: put in"
    if all(_is_band(mesh, group) for group in own):
        dropped = np.zeros(len(mesh.triangles), np.bool_)
        for group in GROUPS:
            dropped[mesh.groups.get(group, [])] = True
        mesh = drop_triangles(mesh, dropped)
        return insert_teeth(mesh, points, outwards=outwards), "teeth without a shape: replaced"
    if "teeth_lower" in own and _is_tongue_missing(mesh):
        return _insert_tongue(mesh, outwards=outwards), "no tongue: put in"
    return mesh, None


def _is_band(mesh: Mesh, group: str) -> bool:
    """Tell whether an arch of teeth is a strip on which no teeth can be told apart."""
    rows = mesh.groups[group]
    numbers = mesh.materials_of_triangles()[rows]
    has_image = mesh.texture is not None or any(n >= 0 and mesh.materials[n].image is not None for n in numbers)
    return len(rows) < _MIN_TRIANGLES and not has_image


def _is_tongue_missing(mesh: Mesh) -> bool:
    """Tell whether nothing lies between the lower teeth."""
    if "tongue" in mesh.groups:
        return False
    arch = mesh.vertices[mesh.group_vertices("teeth_lower")]
    others = np.setdiff1d(np.unique(mesh.triangles), mesh.group_vertices(*TEETH))
    middle = np.array([(arch[:, 0].min() + arch[:, 0].max()) / 2, *arch[:, 1:].max(axis=0)])
    side, height, near, far = _TONGUE_BOX
    x, y, z = (mesh.vertices[others] - middle).T
    inside = (np.abs(x) < side * np.ptp(arch[:, 0])) & (np.abs(y) < height) & (z < -near) & (z > -far)
    return not inside.any()


def _insert_tongue(mesh: Mesh, *, outwards: bool) -> Mesh:
    """Return the mesh with the default head's tongue behind its own lower teeth."""
    own, default = (m.vertices[m.group_vertices("teeth_lower")] for m in (mesh, load_mesh(DEFAULT_HEAD)))
    anchors = [
        np.array([(arch[:, 0].min() + arch[:, 0].max()) / 2, *arch[:, 1:].max(axis=0)]) for arch in (own, default)
    ]
    scale = float(np.clip(np.ptp(own[:, 0]) / np.ptp(default[:, 0]), *_SCALES))
    tongue = _default_parts(("tongue",))
    return _append(mesh, tongue, (tongue.vertices - anchors[1]) * scale + anchors[0], outwards=outwards)


def insert_teeth(mesh: Mesh, points: NDArray[np.float64], /, *, outwards: bool) -> Mesh:
    """Return the mesh with teeth and tongue behind the lips, in groups of their own.

    mesh, points : upright, in model centimetres; points (n, 3). New vertices come after those of the mesh.
    outwards : whether the mesh's triangles face outwards
    """
    teeth, default = _default_parts(GROUPS), default_points()
    scale = float(np.clip(np.ptp(points[_CORNERS, 0]) / np.ptp(default[_CORNERS, 0]), *_SCALES))
    seam = points[_SEAM].mean(axis=0)
    vertices = (teeth.vertices - default[_SEAM].mean(axis=0)) * scale + seam
    skin_depth = cast_front_rays(vertices[:, :2], mesh.vertices, mesh.triangles).points[:, 2]
    cover = np.interp(np.abs(vertices[:, 1] - seam[1]), [0.0, 1.0], _COVER)
    for _ in range(_STEPS):  # a miss, nan, hides nothing
        if np.mean(~(skin_depth > vertices[:, 2] + cover)) <= _MAX_VISIBLE:
            break
        vertices = vertices - [0.0, 0.0, _STEP]
    return _append(mesh, teeth, vertices, outwards=outwards)


def _append(mesh: Mesh, teeth: Mesh, vertices: NDArray[np.float64], *, outwards: bool) -> Mesh:
    """Return the mesh with teeth or tongue at vertices (k, 3)."""
    triangles, render_triangles = teeth.triangles, teeth.render_triangles
    if not outwards:
        triangles, render_triangles = triangles[:, ::-1], render_triangles[:, ::-1]
    materials, colours = mesh.extended_colours(len(triangles), len(vertices))
    return replace(
        mesh,
        triangle_materials=materials,
        vertex_colours=colours,
        vertices=np.concatenate([mesh.vertices, vertices]),
        triangles=np.concatenate([mesh.triangles, triangles + len(mesh.vertices)]).astype(np.int32),
        uvs=np.concatenate([mesh.uvs, np.zeros_like(teeth.uvs)]),
        render_vertices=np.concatenate([mesh.render_vertices, teeth.render_vertices + len(mesh.vertices)]).astype(
            np.int32
        ),
        render_triangles=np.concatenate([mesh.render_triangles, render_triangles + len(mesh.render_vertices)]).astype(
            np.int32
        ),
        groups=mesh.groups | {name: members + len(mesh.triangles) for name, members in teeth.groups.items()},
    )


@cache
def _default_parts(groups: tuple[str, ...]) -> Mesh:
    """Return some groups of the default head."""
    head = load_mesh(DEFAULT_HEAD)
    kept = np.zeros(len(head.triangles), dtype=np.bool_)
    for name in groups:
        kept[head.groups[name]] = True
    return submesh(head, kept)
