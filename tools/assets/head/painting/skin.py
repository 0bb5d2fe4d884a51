"""Paint the skin: tone, redness, lips, lids, brows, pores, stubble or beard, wrinkles, and ambient occlusion.

Positions are those of the default head, whatever head is painted.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tools.assets.head.painting.brows import brow_coverage
from tools.assets.head.painting.hair import coverage
from tools.assets.head.painting.noise import layered, noise, smoothstep
from tools.assets.head.painting.texels import Texels
from tools.assets.head.painting.wrinkles import paint_spots, wrinkle_depth
from tools.assets.head.parameters import Colour, HeadParameters
from tools.assets.head.scalp import find_hairline, polar

Points = Mapping[str, NDArray[np.float64]]
Colours = NDArray[np.float64]

# sRGB, 0 to 255, on skin of the tone _TONE.
_TONE = (218, 172, 147)
_FLUSH = (206, 128, 110)
_SALLOW = (214, 172, 136)
_STUBBLE = (150, 124, 112)
_SHADE = (176, 128, 112)
_LID = (196, 144, 124)
_LIP = (184, 112, 102)
_LIP_INNER = (138, 70, 66)
_NOSTRIL = (84, 44, 38)
_WET = (204, 138, 124)
_LASH = (44, 30, 26)
_FRECKLE = (172, 118, 94)
_SHINE = (232, 190, 168)


@dataclass(frozen=True)
class Palette:
    """Colours of a skin. Those of the default head keep their relation to the tone."""

    head: HeadParameters

    def __call__(self, colour: Colour) -> Colour:
        """Return the colour that a colour of the default head's skin corresponds to."""
        red, green, blue = (c * t / d for c, t, d in zip(colour, self.head.skin.tone, _TONE, strict=True))
        return red, green, blue

    @property
    def lip(self) -> Colour:
        """The colour of the lips."""
        return self.head.skin.lip or self(_LIP)


def paint_skin(texels: Texels, points: Points, head: HeadParameters) -> Colours:
    """Return (N, 3) sRGB colours 0 to 255 of the skin's texels."""
    palette = Palette(head)
    colours = np.tile(np.array(head.skin.tone, dtype=float), (len(texels.row), 1))
    for layer in (_flush, _wrinkles, _stubble, _scalp, _around_eyes, _nostrils, _lips, _beard, _brows):
        layer(colours, texels, points, palette)
    _grain(colours, texels, palette)
    return _occlusion(colours, texels)


def blend(colours: Colours, target: Colour, amount: NDArray[np.floating]) -> None:
    """Blend the colours with the target in place; amount : (N,) 0 to 1."""
    colours += (np.array(target, dtype=float) - colours) * amount[:, None]


def _blob(texels: Texels, centre: NDArray[np.float64], radius: tuple[float, float, float]) -> NDArray[np.float64]:
    """Return (N,) weights of a soft spot on both sides of the face: 1 at the centre, near 0 beyond the radius."""
    fold = np.array([np.sign(centre[0]), 1, 1])
    folded = np.where(
        centre[0] == 0, texels.position, np.abs(texels.position) * [1, 0, 0] + texels.position * [0, 1, 1]
    )
    offset = folded - centre * fold
    return np.asarray(np.exp(-2.0 * ((offset / radius) ** 2).sum(axis=1)))


def _flush(colours: Colours, texels: Texels, points: Points, palette: Palette) -> None:
    mottle = 1 + 0.45 * layered(texels.position, 0.9, 3)
    nose = (points["nose_bottom_edge_l"] + points["nose_bottom_edge_r"]) / 2 + [0, 0.6, 1.0]
    cheek = points["cheekbone_l"] * [0.9, 1, 1] + [0, -0.3, 0]
    chin = points["chin_boss"] + [0, 0.3, 0]
    ear = np.array([8.9, 0.6, -6.5])
    for centre, radius, amount in (
        (nose, (1.7, 1.5, 2.2), 0.42),
        (cheek, (2.6, 2.0, 4.0), 0.34),
        (chin, (1.8, 1.2, 2.5), 0.16),
        (ear, (1.1, 3.2, 2.6), 0.34),
    ):
        blend(
            colours,
            palette(_FLUSH),
            np.clip(palette.head.skin.flush * amount * mottle * _blob(texels, np.asarray(centre), radius), 0, 1),
        )
    blend(
        colours,
        palette(_SALLOW),
        0.5 * smoothstep(4.5, 8.0, texels.position[:, 1]) * smoothstep(-4, 2, texels.position[:, 2]),
    )


def _stubble(colours: Colours, texels: Texels, points: Points, palette: Palette) -> None:
    fine = 1 + 0.6 * noise(texels.position, 16.0)
    blend(colours, palette(_STUBBLE), np.clip(palette.head.skin.stubble * _bearded(texels, points) * fine, 0, 1))


def _bearded(texels: Texels, points: Points) -> NDArray[np.float64]:
    """Return (N,) where a beard grows, 0 to 1."""
    x, y, z = texels.position.T
    lip = points["outer_lip_upper_mid"][1]
    jaw = (
        smoothstep(lip + 1.3, lip - 0.6, y - 0.16 * np.abs(x)) * smoothstep(-12.8, -10.0, y) * smoothstep(-4.2, -1.0, z)
    )
    moustache = np.exp(-(((y - lip - 0.5) / 0.55) ** 2)) * smoothstep(2.6, 1.6, np.abs(x)) * smoothstep(2, 4, z)
    return np.asarray(np.maximum(jaw, moustache))


def _beard(colours: Colours, texels: Texels, points: Points, palette: Palette) -> None:
    """Paint a short beard: hairs in the colour of the head's, denser at the chin, none on the lips."""
    strength = palette.head.skin.beard
    if not strength:
        return
    x, y, z = texels.position.T
    side, rough = np.abs(x), noise(texels.position, 1.6)
    lip = points["outer_lip_upper_mid"][1]
    cheek = lip - 0.1 + 0.42 * np.clip(side - 3.2, 0, 4.2) + 1.1 * smoothstep(5.8, 7.4, side)
    cheek = cheek + 0.3 * noise(texels.position, 2.0)
    throat = smoothstep(-0.7, 0.6, y + 10.5 - 0.3 * side + 0.25 * rough)
    back = smoothstep(-5.2, -3.4, z + 0.4 * rough)
    below_lip = smoothstep(0.85, 1.2, np.hypot(x / 2.5, (y + 6.0) / 1.15) + 0.08 * rough)
    whiskers = smoothstep(0.9, -0.9, y - cheek) * below_lip * throat * back
    chin = smoothstep(3.6, 2.6, np.hypot(x, (y + 8.6) * 0.85)) * smoothstep(-6.1, -6.9, y) * throat
    under_lip = 0.8 * np.exp(-((x / 0.5) ** 2)) * smoothstep(-8.0, -7.0, y) * smoothstep(-5.4, -6.0, y)
    droop = 0.13 * side + 0.45 * np.clip(side - 2.0, 0, None)
    moustache = smoothstep(0.9, 0.5, np.abs(y - lip - 0.62 + droop)) * smoothstep(3.6, 2.7, side + 0.15 * rough)
    moustache = moustache * smoothstep(2, 4, z) * (1 - 0.5 * np.exp(-((x / 0.25) ** 2)))
    joint = np.exp(-(((side - 3.2) / 0.8) ** 2)) * smoothstep(lip + 0.8, lip - 0.4, y) * smoothstep(-8.5, -7.5, y)
    sideburn = smoothstep(6.0, 6.8, side) * smoothstep(1.3, 0.5, np.abs(z + 2.9 - 0.2 * y)) * smoothstep(1.0, 0.0, y)
    whiskers = np.maximum(whiskers, sideburn * smoothstep(-3.5, -2.5, y))
    front = [under_lip * smoothstep(2, 4, z), moustache * smoothstep(2.0, 3.0, z)]
    where = np.maximum.reduce([whiskers, chin, *front, 0.9 * joint])
    skin = 1 - smoothstep(7.6, 6.4, texels.mouth_ring)  # not on the lips
    hairs = 0.5 + 0.5 * noise(texels.position, (11.0, 3.2, 5.0)) + 0.35 * noise(texels.position, (24.0, 7.0, 12.0))
    amount = np.clip(strength * where * skin * (0.55 + 0.75 * np.clip(hairs, 0, 1)), 0, 0.96)
    dark, light = np.array(palette.head.hair.dark, float), np.array(palette.head.hair.middle, float)
    target = dark + (light - dark) * np.clip(hairs, 0, 1)[:, None]
    colours += (target - colours) * amount[:, None]


def _wrinkles(colours: Colours, texels: Texels, points: Points, palette: Palette) -> None:
    """Darken wrinkles, and add spots of age."""
    skin = palette.head.skin
    if skin.lines:
        depth = np.clip(skin.lines * wrinkle_depth(texels, points), 0, 1)
        colours *= 1 - depth[:, None] * [0.22, 0.30, 0.33]
    if skin.spots:
        blend(colours, palette(_FRECKLE), np.clip(skin.spots * paint_spots(texels), 0, 1))


def _scalp(colours: Colours, texels: Texels, points: Points, palette: Palette) -> None:
    """Darken the skin between the roots of the hair, faded at the hairline."""
    hair = palette.head.hair
    around, down, out = polar(texels.position)
    edge = find_hairline(hair.hairline, hair.receding)(around)
    depth = (edge - down) * out
    x, y, z = texels.position.T
    ear = smoothstep(1.15, 0.85, np.hypot((y - 0.6) / 3.1, (z + 6.6) / 2.9)) * smoothstep(7.6, 7.9, np.abs(x))
    roots = smoothstep(-0.25, 0.9, depth + 0.25 * noise(texels.position, 5.0)) * (1 - ear)
    roots = roots * coverage(around, down / edge, hair)
    blend(colours, hair.root, hair.roots * roots)


def _around_eyes(colours: Colours, texels: Texels, points: Points, palette: Palette) -> None:
    lid = points["eyelid_upper_l"]
    under = points["eyelid_lower_l"] + np.array([-0.5, -0.75, 0])
    socket = lid + np.array([-1.0, 0.75, 0])
    blend(colours, palette(_LID), 0.55 * _blob(texels, lid + np.array([0.1, 0.3, 0]), (1.9, 0.75, 2.5)))
    blend(colours, palette(_SHADE), 0.3 * _blob(texels, under, (1.6, 0.55, 2.0)))
    blend(colours, palette(_SHADE), 0.25 * _blob(texels, socket, (0.9, 0.6, 2.0)))
    ring = texels.eye_ring
    upper = texels.position[:, 1] > np.interp(np.abs(texels.position[:, 0]), *_canthus_line(points))
    outward = smoothstep(1.7, 3.4, np.abs(texels.position[:, 0]))
    blend(colours, palette(_WET), 0.75 * smoothstep(4.6, 3.0, ring))
    line = np.exp(-(((ring - 3.6) / 0.75) ** 2))
    eyes = palette.head.eyes
    blend(colours, _LASH, np.where(upper, 0.35 + 0.5 * outward, 0.12 + 0.2 * outward) * line)
    if eyes.liner:
        wide = np.exp(-(((ring - 4.2) / 1.1) ** 2))
        blend(colours, _LASH, np.clip(eyes.liner * np.where(upper, 0.5 + 0.5 * outward, 0.4 * outward) * wide, 0, 1))
    blend(colours, palette(_WET), 0.6 * smoothstep(2.4, 1.6, ring))


def _canthus_line(points: Points) -> tuple[list[float], list[float]]:
    inner, outer = points["eye_inner_corner_l"], points["eye_outer_corner_l"]
    return [inner[0], outer[0]], [inner[1], outer[1]]


def _nostrils(colours: Colours, texels: Texels, points: Points, palette: Palette) -> None:
    """Darken the inside of the nostrils."""
    base = (points["nose_bottom_edge_l"] + points["nose_bottom_edge_r"]) / 2
    near = smoothstep(1.9, 1.3, np.linalg.norm((texels.position - base - [0, 0.3, 0.6]) / [1.0, 0.8, 1.0], axis=1))
    blend(colours, palette(_NOSTRIL), 0.9 * near * smoothstep(0.62, 0.3, texels.sky))


def _lips(colours: Colours, texels: Texels, points: Points, palette: Palette) -> None:
    x, y, _ = texels.position.T
    ring = texels.mouth_ring
    contact = points["inner_lip_upper_mid"][1]
    upper = y > contact
    irregularity = 0.22 * noise(texels.position, 3.0)
    edge = np.where(upper, 6.0, 7.0) + irregularity
    vermilion = smoothstep(edge + 0.55, edge - 0.75, ring)
    creases = noise(texels.position, (9.0, 0.8, 0.8)) * smoothstep(2.4, 1.2, np.abs(x))
    tone = np.array(palette.lip, dtype=float) * np.where(upper, 0.93, 1.03)[:, None] * (1 + 0.055 * creases)[:, None]
    colours += (tone - colours) * (0.86 * vermilion)[:, None]
    blend(colours, palette(_LIP_INNER), 0.9 * smoothstep(3.4, 0.8, ring))
    shine = np.exp(-(((ring - edge - 0.9) / 0.6) ** 2)) * smoothstep(2.3, 1.0, np.abs(x))
    blend(colours, palette(_SHINE), 0.16 * shine)


def _brows(colours: Colours, texels: Texels, points: Points, palette: Palette) -> None:
    eyes = palette.head.eyes
    amount = 0.88 * brow_coverage(texels, points, eyes.brow_thickness) * eyes.brow_strength
    blend(colours, eyes.brow, np.clip(amount, 0, 0.95))


def _grain(colours: Colours, texels: Texels, palette: Palette) -> None:
    position = texels.position
    blotches = 0.022 * layered(position, 0.6, 4)
    pores = 0.02 * noise(position, 10.0) + 0.015 * noise(position, 22.0)
    colours *= (1 + blotches + pores)[:, None]
    freckles = smoothstep(0.84, 0.97, noise(position + 7.0, 4.2)) * smoothstep(-3.5, 1.0, position[:, 2])
    strength = palette.head.skin.freckles
    blend(colours, palette(_FRECKLE), 0.16 * freckles if strength == 0.16 else _freckled(texels, strength))


def _freckled(texels: Texels, strength: float) -> NDArray[np.float64]:
    """Return the (N,) strength of freckles, on nose and cheeks above all."""
    x, y, z = texels.position.T
    fine = smoothstep(0.55, 0.8, noise(texels.position + 7.0, 4.2)) + smoothstep(0.6, 0.85, noise(texels.position, 7.0))
    middle = np.exp(-(((y + 0.2) / 2.2) ** 2)) * smoothstep(6.5, 3.5, np.abs(x))
    return np.asarray(np.clip(strength * fine * (0.15 + 0.85 * middle) * smoothstep(-3.5, 1.0, z), 0, 1))


def _occlusion(colours: Colours, texels: Texels) -> Colours:
    """Apply ambient occlusion; light scattered in skin is red, so red is darkened least."""
    sky = np.clip(texels.sky, 0.05, 1)[:, None]
    return np.asarray(np.clip(colours * sky ** np.array([0.5, 0.62, 0.66]) * 1.02, 0, 255))
