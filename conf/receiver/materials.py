"""Which shader draws which part of a face, and in which order."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Material:
    """How a group of triangles is drawn.

    shader : name of a fragment shader
    two_sided : also drawn from behind: thin sheets
    blended : drawn last, over the rest, by the atlas's alpha
    """

    shader: str
    two_sided: bool = False
    blended: bool = False


SKIN = Material("skin")
EYE = Material("eye")
MOUTH = Material("mouth")
HAIR = Material("hair", two_sided=True, blended=True)

# The groups of the shipped head. Any other group, and a mesh without groups, is skin.
MATERIALS = {
    "eye_l": EYE,
    "eye_r": EYE,
    "teeth_upper": MOUTH,
    "teeth_lower": MOUTH,
    "tongue": MOUTH,
    "mouth": MOUTH,
    "hair": HAIR,
    "brows": HAIR,
    "lashes": HAIR,
}


def material_of(group: str) -> Material:
    """Return the material of a group by its name."""
    return MATERIALS.get(group, SKIN)
