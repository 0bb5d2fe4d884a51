"""Paint the texture atlas: the texels of each group, then the space between them with the nearest colour."""

from collections.abc import Callable, Mapping

import numpy as np
from numpy.typing import NDArray
from PIL import Image
from scipy.ndimage import distance_transform_edt

from tools.assets.head.painting.eyes import paint_eye
from tools.assets.head.painting.hair import paint_hair
from tools.assets.head.painting.lashes import paint_lashes
from tools.assets.head.painting.mouth import paint_cavity, paint_teeth, paint_tongue
from tools.assets.head.painting.occlusion import ambient_occlusion
from tools.assets.head.painting.shirt import paint_shirt
from tools.assets.head.painting.skin import paint_skin
from tools.assets.head.painting.texels import Texels, bake_texels, vertex_normals
from tools.assets.head.parameters import HeadParameters
from tools.assets.head.part import Part, split_quads

Points = Mapping[str, NDArray[np.float64]]
_WITHOUT_SHADOW = ("lashes",)
_PAINTERS: dict[str, Callable[[Texels, HeadParameters], NDArray[np.float64]]] = {
    "eye_l": paint_eye,
    "teeth_upper": paint_teeth,
    "teeth_lower": paint_teeth,
    "tongue": paint_tongue,
    "mouth": paint_cavity,
    "shirt": paint_shirt,
    "hair": paint_hair,
    "lashes": paint_lashes,
}


def paint_atlas(
    head: Part,
    canonical: NDArray[np.float64],
    rings: NDArray[np.float64],
    points: Points,
    parameters: HeadParameters,
    *,
    size: int,
) -> Image.Image:
    """Return the atlas of the head.

    canonical : (V, 3) position of each vertex on the default head, for which the painters are written
    rings : (V, 2) number of edges to the mouth cavity and to the eye socket
    points : control points of the default head by name
    """
    normals = vertex_normals(head.vertices, head.triangles()[..., 0])
    without = (*_WITHOUT_SHADOW, *(["hair"] if parameters.hair.crown else []))  # most of it is transparent
    solid = np.concatenate([split_quads(c) for name, c in head.groups.items() if name not in without])
    sky = ambient_occlusion(head.vertices, normals, head.vertices, solid[..., 0])
    attributes = np.concatenate([canonical, normals, sky[:, None], rings], axis=1)
    atlas = np.full((size, size, 4), 255.0)
    drawn = np.zeros((size, size), dtype=bool)
    for group in head.groups:
        texels = bake_texels(size, head, group, attributes)
        if group == "skin":
            colours = paint_skin(texels, points, parameters)
        elif group in _PAINTERS:
            colours = _PAINTERS[group](texels, parameters)
        else:
            continue
        atlas[texels.row, texels.column, : colours.shape[1]] = colours
        drawn[texels.row, texels.column] = True
    nearest = distance_transform_edt(~drawn, return_distances=False, return_indices=True)
    return Image.fromarray(np.rint(atlas[tuple(nearest)]).astype(np.uint8))
