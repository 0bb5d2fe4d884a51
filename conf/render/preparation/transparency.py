"""Find the transparent parts of a mesh, such as hair and lashes, by the alpha of its materials and images."""

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.sparse.csgraph import connected_components

from conf.face.mesh.editing import regroup
from conf.face.mesh.mesh import Mesh
from conf.face.mesh.orientation import weld_indices
from conf.render.materials import TRANSLUCENT, material_of
from conf.render.textures import MeshImages

_OPAQUE = 200  # alpha, 0 to 255, above which a texel counts as opaque
_MIN_TRANSPARENT = 0.05  # of the triangles of a connected part, which is then drawn blended
# The alpha of an image is coverage if at least this fraction of its texels is fully transparent or opaque: games
# store gloss and other things there.
_MIN_COVERAGE = 0.6
# Where the alpha of a triangle is sampled, barycentric.
_SAMPLES = np.array(
    [[1, 0, 0], [0, 1, 0], [0, 0, 1], [0.5, 0.5, 0], [0, 0.5, 0.5], [0.5, 0, 0.5], [1 / 3, 1 / 3, 1 / 3]]
)


def separate_transparent(mesh: Mesh, images: MeshImages) -> Mesh:
    """Return the mesh with its transparent parts, such as hair and lashes, in the group TRANSLUCENT.

    A connected part is transparent if the alpha of its material or image says so. Groups that are drawn blended
    by their name stay as they are.
    """
    is_candidate = np.ones(len(mesh.triangles), np.bool_)
    for name, triangles in mesh.groups.items():
        if material_of(name).blended:
            is_candidate[triangles] = False
    numbers = mesh.materials_of_triangles()
    transparent = np.zeros(len(mesh.triangles), np.bool_)
    for number in images.numbers:
        rows = np.flatnonzero(is_candidate & (numbers == number))
        transparent[rows] = _is_transparent(mesh, rows, images, number)
    if images.ignores_alpha or not transparent.any():
        return mesh
    parts = _connected_parts(mesh, is_candidate, numbers)
    fraction = np.bincount(parts, transparent) / np.maximum(np.bincount(parts), 1)
    blended = is_candidate & (fraction[parts] >= _MIN_TRANSPARENT)
    return regroup(mesh, {TRANSLUCENT: np.flatnonzero(blended)}) if blended.any() else mesh


def with_transparent_parts(mesh: Mesh) -> Mesh:
    """Return `separate_transparent` of a mesh without its images at hand; a mesh with blended groups as it is.

    Raises FileFormatError if a file is not an image.
    """
    is_named = any(material_of(name).blended for name in mesh.groups)
    return mesh if is_named else separate_transparent(mesh, MeshImages(mesh))


def _is_transparent(mesh: Mesh, rows: NDArray[np.int64], images: MeshImages, number: int) -> NDArray[np.bool_]:
    """Return (k,) whether each of the triangles (k,) of one material is transparent somewhere."""
    material = images.material(number)
    if material.alpha < 1.0:
        return np.ones(len(rows), np.bool_)
    none = np.zeros(len(rows), np.bool_)
    pixels = images.pixels(number)
    if pixels is None or not len(rows) or material.has_alpha is False:
        return none
    alpha = pixels[..., 3]
    height, width = alpha.shape
    at = np.einsum("sc,fcd->fsd", _SAMPLES, mesh.uvs[mesh.render_triangles[rows]]) % 1.0
    column = np.minimum((at[..., 0] * width).astype(np.int64), width - 1)
    row = np.minimum((at[..., 1] * height).astype(np.int64), height - 1)
    found = np.asarray((alpha[row, column] < _OPAQUE).any(axis=1))
    if material.has_alpha is None and found.any():
        is_extreme = (alpha <= 8) | (alpha >= 247)
        if is_extreme.mean() < _MIN_COVERAGE or alpha.max() <= 8:
            return none
    return found


def _connected_parts(mesh: Mesh, rows: NDArray[np.bool_], numbers: NDArray[np.int32]) -> NDArray[np.int64]:
    """Return (F,) the number of the connected part of one material that each triangle belongs to."""
    corners = weld_indices(mesh.vertices)[mesh.triangles] * (int(numbers.max()) + 2) + numbers[:, None] + 1
    corners = np.unique(corners, return_inverse=True)[1].reshape(-1, 3)
    starts, ends = corners[rows].ravel(), np.roll(corners[rows], 1, axis=1).ravel()
    count = int(corners.max()) + 1
    graph = sparse.coo_array((np.ones(len(starts), np.bool_), (starts, ends)), (count, count))
    labels = np.asarray(connected_components(graph, directed=False)[1], np.int64)
    return np.asarray(labels[corners[:, 0]])
