"""Assemble the parts of a head and write its files."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from PIL import Image
from scipy.spatial import KDTree

from conf.face.control_points import CONTROL_POINT_INDEX, CONTROL_POINTS
from conf.face.formats.ppc import write_ppc
from tools.assets.head.body import FAR, build_body, edge_rings, find_islands
from tools.assets.head.character import Character, align_to_canonical, build_character
from tools.assets.head.control_vertices import VERTICES
from tools.assets.head.corrections import NECK_AXIS, close_lips, fit_neck, soften_nose_wings
from tools.assets.head.eyeballs import build_eyeball
from tools.assets.head.files import TEXTURE, Variant, write_obj, write_rig, write_shapes, write_variant
from tools.assets.head.hair import build_hair
from tools.assets.head.lashes import build_lashes
from tools.assets.head.painting.atlas import paint_atlas
from tools.assets.head.parameters import DEFAULT, HeadParameters
from tools.assets.head.part import Part, join, split_quads
from tools.assets.head.scalp import Hairline, build_scalp, find_hairline
from tools.assets.head.shirt import build_shirt
from tools.assets.head.source import Source
from tools.assets.head.teeth import build_teeth

_ATLAS_SIZE = 2048
_VARIANT_QUALITY = 82  # of WebP
_WET_RINGS = 1  # edge loops of the lips that belong to the mouth group


@dataclass(frozen=True)
class Head:
    """A head before it is written.

    part : the mesh, inner lips in group mouth; rings : (V, 2) edges to the mouth and to the eyes
    points : (50, 3) control points; rig : as rig.json has it; scalp : the skull
    """

    character: Character
    part: Part
    rings: NDArray[np.float64]
    points: NDArray[np.float64]
    rig: dict[str, object]


def build_head(source: Source, folder: Path) -> Part:
    """Build the default head, paint its atlas, write all its files into the folder and return it."""
    head = assemble(source, DEFAULT)
    paint(head, head, DEFAULT).save(folder / TEXTURE, quality=90, method=6)
    part = _inner_lips_to_mouth(head.part, head.rings[:, 0])
    write_obj(folder, part)
    write_ppc(folder / "head.ppc", head.points.round(4))
    write_shapes(folder, list(head.character.shapes), part.shapes)
    write_rig(folder, head.rig)
    return part


def build_variant(source: Source, default: Head, parameters: HeadParameters, stem: Path) -> Head:
    """Build a head with the topology of the default head and write it to stem.npz and stem.webp."""
    head = assemble(source, parameters, default)
    paint(head, default, parameters).save(stem.with_suffix(".webp"), quality=_VARIANT_QUALITY, method=6)
    write_variant(stem.with_suffix(".npz"), _variant(head, default))
    return head


def assemble(source: Source, parameters: HeadParameters, default: Head | None = None) -> Head:
    """Build all parts of a head. default : the default head, None if this is it"""
    layout = None if default is None else default.character.vertices
    character = align_to_canonical(build_character(source, parameters.shape, layout))
    character = fit_neck(soften_nose_wings(close_lips(character)), parameters.shape.shoulders)
    names = list(character.shapes)
    body, origin = build_body(character)
    eyes = {side: _eye(character, side) for side in "lr"}
    balls = [build_eyeball(f"eye_{side}", centre, radius) for side, (centre, radius) in eyes.items()]
    body_rings = edge_rings(character, find_islands(character))[origin]
    blinks = {"l": names.index("eyeBlinkLeft"), "r": names.index("eyeBlinkRight")}
    lashes = build_lashes(body, body_rings[:, 1], blinks, scale=parameters.eyes.lashes)
    shirt = build_shirt(character if default is None else default.character)
    parts = [body, *balls, *_teeth(character), _scaled(shirt, parameters.shape.shoulders), lashes]
    hair = _hair(character, body, parameters, default)
    part = join([*parts, hair] if hair else parts)
    rings = np.full((len(part.vertices), 2), FAR)
    rings[: len(origin)] = body_rings
    return Head(character, part, rings, _control_points(character, balls), _rig(character, eyes))


def paint(head: Head, default: Head, parameters: HeadParameters) -> Image.Image:
    """Return the texture atlas of a head."""
    canonical = head.part.vertices.copy()
    skin = np.unique(np.concatenate([head.part.groups[g][..., 0].ravel() for g in ("skin", "mouth", "tongue")]))
    canonical[skin] = default.part.vertices[skin]
    points = dict(zip((p.name for p in CONTROL_POINTS), default.points, strict=True))
    return paint_atlas(head.part, canonical, head.rings, points, parameters, size=_ATLAS_SIZE)


def _hair(character: Character, body: Part, parameters: HeadParameters, default: Head | None) -> Part | None:
    hairline = find_hairline(parameters.hair.hairline, parameters.hair.receding)
    if default is not None:  # the same hairline on another skull
        _, nearest = KDTree(default.part.vertices[: len(body.vertices)]).query(hairline.points)
        hairline = Hairline(hairline.points, body.vertices[nearest] - default.part.vertices[nearest])
    return build_hair(build_scalp(body.vertices, split_quads(body.groups["skin"])[..., 0], hairline), parameters.hair)


def _scaled(shirt: Part, shoulders: float) -> Part:
    scale, axis = np.array([shoulders, 1.0, shoulders]), np.array([0.0, 0.0, NECK_AXIS])
    return Part((shirt.vertices - axis) * scale + axis, shirt.shapes, shirt.uvs, shirt.groups)


def _variant(head: Head, default: Head) -> Variant:
    """Return what a head has of its own."""
    part = head.part
    shared = len(default.part.vertices) - len(np.unique(default.part.groups["hair"][..., 0]))
    hair = part.groups.get("hair", np.empty((0, 4, 2), np.int64)).astype(np.int64)
    uvs = len(default.part.uvs) - len(np.unique(default.part.groups["hair"][..., 1]))
    turn = np.linalg.inv(default.character.turn.T) @ head.character.turn.T
    names = list(head.character.shapes)
    gaps = _lid_gap(head.points) / _lid_gap(default.points)
    scales = np.array([gaps if name.startswith(("eyeBlink", "eyeSquint", "eyeWide")) else 1.0 for name in names])
    return Variant(part.vertices, hair - np.array([shared, uvs]), part.uvs[uvs:], turn, scales, head.points, head.rig)


def _lid_gap(points: NDArray[np.float64]) -> float:
    rows = [CONTROL_POINT_INDEX[f"eyelid_{lid}_l"] for lid in ("upper", "lower")]
    return float(np.linalg.norm(np.subtract(*points[rows])))


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
