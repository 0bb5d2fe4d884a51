"""Assemble the parts of the head and write its files."""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from conf.face.control_points import CONTROL_POINTS
from tools.assets.head.body import FAR, build_body, edge_rings, find_islands
from tools.assets.head.character import Character, align_to_canonical, build_character
from tools.assets.head.control_vertices import VERTICES
from tools.assets.head.corrections import close_lips, soften_nose_wings
from tools.assets.head.eyeballs import build_eyeball
from tools.assets.head.files import TEXTURE, write_obj, write_ppc, write_rig, write_shapes
from tools.assets.head.hair import build_hair
from tools.assets.head.lashes import build_lashes
from tools.assets.head.painting.atlas import paint_atlas
from tools.assets.head.part import Part, join, split_quads
from tools.assets.head.scalp import build_scalp
from tools.assets.head.shirt import build_shirt
from tools.assets.head.source import Source
from tools.assets.head.teeth import build_teeth

_ATLAS_SIZE = 2048
_WET_RINGS = 1  # edge loops of the lips that belong to the mouth group


def build_head(source: Source, folder: Path) -> Part:
    """Build every part, paint the atlas, write all files into the folder and return the head."""
    character = soften_nose_wings(close_lips(align_to_canonical(build_character(source))))
    names = list(character.shapes)
    body, origin = build_body(character)
    eyes = {side: _eye(character, side) for side in "lr"}
    balls = [build_eyeball(f"eye_{side}", centre, radius) for side, (centre, radius) in eyes.items()]
    body_rings = edge_rings(character, find_islands(character))[origin]
    blinks = {"l": names.index("eyeBlinkLeft"), "r": names.index("eyeBlinkRight")}
    lashes = build_lashes(body, body_rings[:, 1], blinks)
    scalp = build_scalp(body.vertices, split_quads(body.groups["skin"])[..., 0])
    head = join([body, *balls, *_teeth(character), build_shirt(character), lashes, build_hair(scalp)])
    rings = np.full((len(head.vertices), 2), FAR)
    rings[: len(origin)] = body_rings
    control_points = _control_points(character, balls)
    points = dict(zip((p.name for p in CONTROL_POINTS), control_points, strict=True))
    paint_atlas(head, rings, points, size=_ATLAS_SIZE).save(folder / TEXTURE, quality=90, method=6)
    head = _inner_lips_to_mouth(head, rings[:, 0])
    write_obj(folder, head)
    write_ppc(folder, control_points)
    write_shapes(folder, names, head.shapes)
    write_rig(folder, _rig(character, eyes))
    return head


def _inner_lips_to_mouth(head: Part, mouth_ring: NDArray[np.float64]) -> Part:
    """Move the inner rim of the lips from group skin to group mouth, which is drawn darker."""
    skin = head.groups["skin"]
    inside = mouth_ring[skin[..., 0]].max(axis=1) <= _WET_RINGS
    groups = {**head.groups, "skin": skin[~inside], "mouth": np.concatenate([head.groups["mouth"], skin[inside]])}
    return Part(head.vertices, head.shapes, head.uvs, groups)


def _eye(character: Character, side: str) -> tuple[NDArray[np.float64], float]:
    helper = character.eye_helper(side)
    centre = helper.mean(axis=0)
    return centre, float(np.median(np.linalg.norm(helper - centre, axis=1))) - 0.03


def _teeth(character: Character) -> list[Part]:
    lips = character.vertices[VERTICES["inner_lip_upper_mid"]]
    return [
        build_teeth("upper", lips + np.array([0.0, 0.62, -0.25]), 2.7, 3.6),
        build_teeth("lower", lips + np.array([0.0, -1.06, -0.62]), 2.5, 3.4),
    ]


def _control_points(character: Character, balls: list[Part]) -> NDArray[np.float64]:
    fronts = {"pupil_l": balls[0].vertices[0], "pupil_r": balls[1].vertices[0]}
    return np.array(
        [fronts[p.name] if p.name in fronts else character.vertices[VERTICES[p.name]] for p in CONTROL_POINTS]
    )


def _rig(character: Character, eyes: dict[str, tuple[NDArray[np.float64], float]]) -> dict[str, object]:
    rounded = {f"eye_{side}": {"centre": [round(float(x), 4) for x in centre]} for side, (centre, _) in eyes.items()}
    return {**rounded, "jaw": {"centre": _JAW_HINGE, "axis": [1.0, 0.0, 0.0]}, "anchors": _anchors(character)}


_JAW_HINGE = [0.0, 0.3, -4.6]  # cm, between the fronts of the ears
# Directions from the middle of the head to points that no expression moves: skull, ears, nape, neck.
_ANCHORS = (
    [(0, 1, 0), (0, 1, 1), (0, 1, -1), (0, 0.2, -1), (0, -0.4, -1)]
    + [(s * 0.8, 1, 0.5) for s in (1, -1)]
    + [(s, 0.6, -0.5) for s in (1, -1)]
    + [(s, 0, -0.3) for s in (1, -1)]
)


def _anchors(character: Character) -> list[list[float]]:
    """Return about 18 surface points that no expression moves."""
    still = np.max([np.linalg.norm(o, axis=1) for o in character.shapes.values()], axis=0) < 0.01
    body = character.base.members("body")
    body = body[still[body]]
    points = character.vertices[body]
    centre = np.array([0.0, 3.0, -4.0])
    directions = points - centre
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    near = np.linalg.norm(points - centre, axis=1) < 22
    targets = np.array(_ANCHORS, dtype=float)
    targets /= np.linalg.norm(targets, axis=1, keepdims=True)
    chosen = [points[near][np.argmax(directions[near] @ target)] for target in targets]
    for x, y, z in ((4.0, -14.0, -2.0), (0.0, -14.0, 1.5), (6.5, -14.5, -6.0)):
        for sign in (1.0, -1.0) if x else (1.0,):
            chosen.append(points[np.argmin(np.linalg.norm(points - [sign * x, y, z], axis=1))])
    return [[round(float(x), 4) for x in point] for point in chosen]
