"""Paint the atlas: each group by its painter, then the gutters filled with the nearest colour."""

from collections.abc import Callable, Mapping

import numpy as np
from numpy.typing import NDArray
from PIL import Image
from scipy.ndimage import distance_transform_edt

from tools.assets.head.occlusion import ambient_occlusion
from tools.assets.head.paint_eyes import paint_eye
from tools.assets.head.paint_hair import paint_hair
from tools.assets.head.paint_lashes import paint_lashes
from tools.assets.head.paint_mouth import paint_bag, paint_teeth, paint_tongue
from tools.assets.head.paint_shirt import paint_shirt
from tools.assets.head.paint_skin import paint_skin
from tools.assets.head.part import Part, split_quads
from tools.assets.head.texels import Texels, bake_texels, vertex_normals

Points = Mapping[str, NDArray[np.float64]]
_CASTS_NO_SHADOW = ("lashes",)
_PAINTERS: dict[str, Callable[[Texels], NDArray[np.float64]]] = {
    "eye_l": paint_eye,
    "teeth_upper": paint_teeth,
    "teeth_lower": paint_teeth,
    "tongue": paint_tongue,
    "mouth": paint_bag,
    "shirt": paint_shirt,
    "hair": paint_hair,
    "lashes": paint_lashes,
}


def paint_atlas(head: Part, rings: NDArray[np.float64], points: Points, *, size: int) -> Image.Image:
    """Paint every group's texels.

    rings : (V, 2) edge loops from lip contact and lid; points : control points by name
    """
    normals = vertex_normals(head.vertices, head.triangles()[..., 0])
    solid = np.concatenate([split_quads(c) for name, c in head.groups.items() if name not in _CASTS_NO_SHADOW])
    sky = ambient_occlusion(head.vertices, normals, head.vertices, solid[..., 0])
    attributes = np.concatenate([head.vertices, normals, sky[:, None], rings], axis=1)
    picture = np.full((size, size, 4), 255.0)
    drawn = np.zeros((size, size), dtype=bool)
    for group in head.groups:
        texels = bake_texels(size, head, group, attributes)
        if group == "skin":
            colours = paint_skin(texels, points)
        elif group in _PAINTERS:
            colours = _PAINTERS[group](texels)
        else:
            continue
        picture[texels.row, texels.column, : colours.shape[1]] = colours
        drawn[texels.row, texels.column] = True
    nearest = distance_transform_edt(~drawn, return_distances=False, return_indices=True)
    return Image.fromarray(np.rint(picture[tuple(nearest)]).astype(np.uint8))
