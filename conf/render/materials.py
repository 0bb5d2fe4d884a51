"""Which shader draws which part of a face, and in which order."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Material:
    """How a group of triangles is drawn.

    shader : name of a fragment shader
    vertex_shader : "face", or "face_shadowed" where the key light's shadow falls on it
    two_sided : also drawn from behind
    blended : drawn last, over the rest, by the atlas's alpha
    casts_shadow : whether it stands in the key light's way
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

# The groups of the shipped head. Any other group, and a mesh without groups, is skin.
MATERIALS = {
    "eye_l": EYE,
    "eye_r": EYE,
    "teeth_upper": MOUTH,
    "teeth_lower": MOUTH,
    "tongue": MOUTH,
    "mouth": MOUTH,
    "shirt": CLOTH,
    "hair": HAIR,
    "brows": HAIR,
    "lashes": Material("hair", two_sided=True, blended=True, casts_shadow=False),
}


def material_of(group: str) -> Material:
    """Return the material of a group by its name."""
    return MATERIALS.get(group, SKIN)
