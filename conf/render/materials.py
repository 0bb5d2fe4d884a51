"""Materials: which shaders draw which group of a face's triangles, and in which order."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from conf.face.mesh.mesh import Mesh


@dataclass(frozen=True)
class Material:
    """How a group of triangles is drawn.

    shader : name of a fragment shader
    vertex_shader : "face", or "face_shadowed" where the key light's shadow falls on it
    two_sided : back faces are drawn too
    blended : drawn last, alpha-blended with the alpha of the texture
    casts_shadow : drawn into the shadow map of the key light
    """

    shader: str
    vertex_shader: str = "face"
    two_sided: bool = False
    blended: bool = False
    casts_shadow: bool = True


SKIN = Material("skin", "face_shadowed")
EYE = Material("eye", casts_shadow=False)
MOUTH = Material("mouth", casts_shadow=False)
CLOTH = Material("cloth", "face_shadowed", casts_shadow=False)
HAIR = Material("hair", blended=True)

TRANSLUCENT = "translucent"  # group of the parts that are transparent by their alpha, whatever their name

# The groups of the default head, and "inner_lips", the side of other heads' lips that faces into the mouth. Any other
# group, and a mesh without groups, is skin.
MATERIALS = {
    "eye_l": EYE,
    "eye_r": EYE,
    "teeth_upper": MOUTH,
    "teeth_lower": MOUTH,
    "tongue": MOUTH,
    "mouth": MOUTH,
    "inner_lips": MOUTH,
    "shirt": CLOTH,
    "hair": HAIR,
    "brows": HAIR,
    "lashes": Material("hair", two_sided=True, blended=True, casts_shadow=False),
    TRANSLUCENT: Material("hair", two_sided=True, blended=True, casts_shadow=False),
}


def material_of(group: str) -> Material:
    """Return the material of a group by its name."""
    return MATERIALS.get(group, SKIN)


def group_triangles(mesh: Mesh) -> list[tuple[str, NDArray[np.int64]]]:
    """Return the name and the triangles of each non-empty group; "rest" holds those in no group."""
    is_ungrouped = np.ones(len(mesh.triangles), np.bool_)
    for triangles in mesh.groups.values():
        is_ungrouped[triangles] = False
    groups = [*mesh.groups.items(), ("rest", np.flatnonzero(is_ungrouped))]
    return [(name, triangles) for name, triangles in groups if len(triangles)]
