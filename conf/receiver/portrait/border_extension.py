"""Extend a person beyond the border of the photo, where the head or the body moves into view.

Head: a dome, opaque up to its edge. In each direction from the head's middle the person's edge has a radius, relative
to an ellipse around the face. Where the border hides the edge, this ratio is interpolated from the directions beside.
The colours of the border continue outwards, and change towards those of the visible edge: a head cut off at the
forehead has hair above it. Body: below the chin the alpha of the border is continued and the colours are mirrored.
"""

from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import NDArray

from conf.face.control_points import CONTROL_POINT_INDEX
from conf.face.interpolation import smoothstep
from conf.face.portrait.contours import OVAL_ROWS
from conf.face.portrait.photo_mesh import border_extension
from conf.face.portrait.photographed_face import PhotographedFace, project
from conf.receiver.portrait.inpainting import push_pull_fill

HEAD_ELLIPSE = (0.62, 0.75)  # semi-axes of the head, of the width and height of the face's oval
HEAD_OFFSET = 0.12  # of the oval's height: the head's centre above the oval's
DIRECTIONS = 96  # in which the person's edge is looked for
MIN_RATIO, MAX_RATIO = 0.85, 1.6  # of the edge's radius to the ellipse's; long hair is wider than a dome
LOWEST_DIRECTION = -0.35  # sine of an angle: farther down neck and shoulders are the edge
MIN_DOME = 0.22  # of the oval's width, that a head cut off continues beyond the border at least, in the middle
SOFT_EDGE = 0.07  # of the oval's width, over which the dome's alpha falls to 0
NECK_BLEND = 0.15  # of the oval's height below the chin, over which the body takes over from the dome
EDGE_DEPTH = 0.9  # of the edge's radius: where its colour is read
END = 0.9  # of the extension: the dome fades before the mesh ends

Positions = NDArray[np.float64]


def extend_border(
    colours: NDArray[np.uint8], alpha: NDArray[np.uint8], face: PhotographedFace, /
) -> tuple[NDArray[np.uint8], NDArray[np.uint8], NDArray[np.float64]]:
    """Return colours and alpha with a margin on all sides, and (2,) the margin as fractions of width and height.

    colours : (H, W, 3) uint8 of the person; alpha : (H, W) uint8
    """
    height, width = alpha.shape
    margin = int(np.ceil(border_extension(face) * height))
    around = np.pad(np.zeros((height, width), bool), margin, constant_values=True)
    y, x = np.nonzero(around)
    y, x = y - margin, x - margin
    nearest_x, nearest_y = np.clip(x, 0, width - 1), np.clip(y, 0, height - 1)
    outside = np.hypot(x - nearest_x, y - nearest_y) / margin
    dome = _Dome.fit(colours, alpha, face)
    offsets = dome.offsets(_positions(x, y, alpha.shape))
    dome_alpha, dome_colours = dome.sample(offsets, colours)
    dome_alpha *= smoothstep((1 - outside) / (1 - END))
    body = smoothstep((dome.chin - offsets[:, 1]) / (NECK_BLEND * dome.size[1]))
    chin_row = int(np.clip(np.ceil((0.5 - dome.chin_height) * height), 0, height - 1))
    chest_row = min(height - 1, (chin_row + 3 * height) // 4)  # rows above may show the neck
    mirrored_y = np.maximum(_mirror(y, height), np.minimum(chest_row, nearest_y))
    mirrored_x = _mirror(x, width)
    body_colours = colours[mirrored_y, mirrored_x].astype(np.float64)
    neck = _neck(colours, alpha, face, chest_row)
    blurred = _blurred_outwards(colours, (alpha > 127) & ~neck, margin, first_row=chest_row)
    space = min(margin, 2 * (height - chin_row))
    smooth = np.maximum(smoothstep(outside * margin / space), neck[mirrored_y, mirrored_x])
    body_colours += (blurred[around] - body_colours) * smooth[:, None]
    mixed = dome_colours + (body_colours - dome_colours) * body[:, None]
    extended, extended_alpha = np.pad(colours, ((margin, margin), (margin, margin), (0, 0))), np.pad(alpha, margin)
    extended[around] = np.clip(np.rint(mixed), 0, 255)
    border_alpha = alpha[nearest_y, nearest_x]
    extended_alpha[around] = np.rint(255 * dome_alpha + (border_alpha - 255 * dome_alpha) * body)
    return extended, extended_alpha, np.array([margin / width, margin / height])


def _neck(
    colours: NDArray[np.uint8], alpha: NDArray[np.uint8], face: PhotographedFace, first_row: int
) -> NDArray[np.bool_]:
    """Return (H, W): True where, from a row downwards, a person is nearer in colour to the face than to the clothes.

    Mirrored at the border, what a neckline shows of the neck would be a second one.
    """
    x, y = _pixels(project(face.points, face.pose)[OVAL_ROWS], alpha.shape)
    left, right = np.clip((x.min(), x.max()), 0, alpha.shape[1])
    person = alpha > 127
    clothes, skin = np.zeros_like(person), np.zeros_like(person)
    clothes[first_row:, :left] = clothes[first_row:, right:] = True
    skin[max(0, y.min()) : max(0, y.max()), left:right] = True
    neck = np.zeros_like(person)
    if (clothes & person).any() and (skin & person).any():
        image = colours[first_row:].astype(np.float64)
        to_skin, to_clothes = (
            np.linalg.norm(image - np.median(colours[where & person], axis=0), axis=2) for where in (skin, clothes)
        )
        neck[first_row:, left:right] = (to_skin < to_clothes)[:, left:right]
    return neck & person


def _blurred_outwards(
    colours: NDArray[np.uint8], known: NDArray[np.bool_], margin: int, *, first_row: int
) -> NDArray[np.float32]:
    """Return the colours of known pixels (H, W) from a row downwards with a margin, smoother the farther out."""
    if known[first_row:].any():
        known[:first_row] = False
    if not known.any():
        known = np.ones_like(known)
    values = np.pad(colours.astype(np.float32), ((margin, margin), (margin, margin), (0, 0)))
    return push_pull_fill(values, np.pad(known, margin))


@dataclass(frozen=True)
class _Dome:
    """The edge of a head in all directions from its middle.

    face : its photo; middle, size : (2,) of head and oval, upright; chin : the chin's height above the middle, upright
    chin_height : above the photo's centre
    angles : (n,) ascending; radius, reached : (n,) of the edge, and of the photo's border or the edge, if nearer
    edge_colours : (n, 3). Lengths in image heights
    """

    face: PhotographedFace
    middle: Positions
    size: Positions
    chin: float
    chin_height: float
    angles: Positions
    radius: Positions
    reached: Positions
    edge_colours: NDArray[np.float64]

    @classmethod
    def fit(cls, colours: NDArray[np.uint8], alpha: NDArray[np.uint8], face: PhotographedFace) -> Self:
        points = project(face.points, face.pose)
        oval = face.upright(points[OVAL_ROWS])
        low, high = oval.min(axis=0), oval.max(axis=0)
        size = high - low
        middle = (low + high) / 2 + (0.0, HEAD_OFFSET * size[1])
        angles = np.linspace(-np.pi, np.pi, DIRECTIONS, endpoint=False)
        direction = np.stack([np.cos(angles), np.sin(angles)], axis=1)
        ellipse = 1 / np.linalg.norm(direction / (size * HEAD_ELLIPSE), axis=1)
        reached, visible = _edge(alpha, face, middle, direction)
        at_edge = _tilted(middle + direction * (EDGE_DEPTH * reached)[:, None], face)
        edge_colours = _read(colours, at_edge)
        ratio = np.ones(DIRECTIONS)
        if (known := visible & (direction[:, 1] > LOWEST_DIRECTION)).any():
            ratio = np.interp(angles, angles[known], reached[known] / ellipse[known], period=2 * np.pi)
            edge_colours = np.stack(
                [np.interp(angles, angles[known], c[known], period=2 * np.pi) for c in edge_colours.T], axis=1
            )
        radius = np.clip(ratio, MIN_RATIO, MAX_RATIO) * ellipse
        radius = np.maximum(radius, reached + MIN_DOME * size[0] * _bulge(visible))
        chin, chin_height = float(low[1] - middle[1]), float(points[CONTROL_POINT_INDEX["chin_bottom"], 1])
        return cls(face, middle, size, chin, chin_height, angles, radius, reached, edge_colours)

    def offsets(self, positions: Positions) -> Positions:
        """Return positions (k, 2) in image heights relative to the head's middle, upright."""
        return self.face.upright(positions) - self.middle

    def sample(self, offsets: Positions, colours: NDArray[np.uint8]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return alpha (k,), 0 to 1, and colours (k, 3) at offsets (k, 2)."""
        angle, distance = np.arctan2(offsets[:, 1], offsets[:, 0]), np.linalg.norm(offsets, axis=1)
        radius, reached = (np.interp(angle, self.angles, r, period=2 * np.pi) for r in (self.radius, self.reached))
        soft = SOFT_EDGE * self.size[0]
        inward = np.minimum(1, 0.97 * reached / np.maximum(distance, 1e-9))[:, None]
        continued = _read(colours, _tilted(self.middle + offsets * inward, self.face))
        edge = np.stack([np.interp(angle, self.angles, c, period=2 * np.pi) for c in self.edge_colours.T], axis=1)
        towards_edge = smoothstep((distance - reached) / np.maximum(radius - reached, 1e-6))
        return smoothstep((radius - distance) / soft + 0.5), continued + (edge - continued) * towards_edge[:, None]


def _edge(
    alpha: NDArray[np.uint8], face: PhotographedFace, middle: Positions, direction: Positions
) -> tuple[Positions, NDArray[np.bool_]]:
    """Return for each direction (n, 2) the distance from the middle to the person's edge or to the photo's border.

    Also (n,) bool: whether it is the edge.
    """
    height, width = alpha.shape
    steps = np.arange(1, int(np.hypot(width, height))) / height
    positions = _tilted(middle + direction[:, None] * steps[:, None], face)  # (n, steps, 2)
    x, y = _pixels(positions, alpha.shape)
    inside = (x >= 0) & (x < width) & (y >= 0) & (y < height)
    person = inside & (alpha[np.clip(y, 0, height - 1), np.clip(x, 0, width - 1)] > 127)
    # The middle may be outside the photo, or the outline have a hole: the last pixel of the person counts.
    last = person.shape[1] - 1 - np.argmax(person[:, ::-1], axis=1)
    visible = inside[np.arange(len(last)), np.minimum(last + 1, person.shape[1] - 1)] & person.any(axis=1)
    return np.where(person.any(axis=1), steps[last], steps[0]), visible


def _bulge(visible: NDArray[np.bool_]) -> NDArray[np.float64]:
    """Return (n,), around a circle: 0 where the edge is visible, 1 in the middle of each arc where it is not."""
    if not visible.any():
        return np.ones(len(visible))
    index, around = np.arange(3 * len(visible)), np.tile(visible, 3)
    before = np.maximum.accumulate(np.where(around, index, -1))
    after = np.minimum.accumulate(np.where(around, index, 3 * len(visible))[::-1])[::-1]
    position = (index - before) / np.maximum(after - before, 1)
    return np.asarray((4 * position * (1 - position))[len(visible) : 2 * len(visible)])


def _tilted(upright: Positions, face: PhotographedFace) -> Positions:
    """Return upright positions (..., 2) as they are in the photo: the inverse of PhotographedFace.upright."""
    return np.asarray(upright @ face.upright(np.eye(2)).T)


def _positions(x: NDArray[np.integer], y: NDArray[np.integer], shape: tuple[int, ...]) -> Positions:
    """Return the positions (k, 2), image heights from the photo's centre, y up, of pixels."""
    return np.stack([x + 0.5 - shape[1] / 2, shape[0] / 2 - y - 0.5], axis=-1) / shape[0]


def _pixels(positions: Positions, shape: tuple[int, ...]) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Return column and row of the pixels at positions (..., 2); they may be outside the photo."""
    x = np.floor(positions[..., 0] * shape[0] + shape[1] / 2).astype(np.intp)
    y = np.floor(shape[0] / 2 - positions[..., 1] * shape[0]).astype(np.intp)
    return x, y


def _read(colours: NDArray[np.uint8], positions: Positions) -> NDArray[np.float64]:
    """Return the colours (k, 3) at positions (k, 2), at the border beyond it."""
    x, y = _pixels(positions, colours.shape)
    height, width = colours.shape[:2]
    return colours[np.clip(y, 0, height - 1), np.clip(x, 0, width - 1)].astype(np.float64)


def _mirror(index: NDArray[np.integer], length: int) -> NDArray[np.integer]:
    """Return indices mirrored at the first and the last pixel."""
    period = max(2 * length - 2, 1)
    folded = np.abs(index) % period
    return np.asarray(np.minimum(folded, period - folded))
