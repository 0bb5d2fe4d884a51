"""Paint the texture of faces without one: `python tools/assets/default_texture.py` writes conf/assets/plain.webp.

It holds the eye of the default head, remapped so that the distance from the centre is the arc length on the eyeball,
and four plain colours.
"""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

import cv2
import numpy as np
from numpy.typing import NDArray

from conf.face.default_head import DEFAULT_HEAD
from conf.face.fitting.default_texture import COLOUR_UVS, EYE_ARC, EYE_UV, EYE_UV_RADII, TEXTURE_FILE
from conf.render.textures import PLAIN_SKIN
from tools.assets.head.eyeballs import CAP_ANGLE, IRIS_ANGLE, eye_uv
from tools.assets.head.painting.noise import smoothstep
from tools.assets.head.part import FRAMES

HEIGHT, WIDTH = 192, 384
COLOUR_SIZE = (0.25, 0.5)  # u, v
BLEED = 1.02  # radius to which the eye is painted, relative to that of its rim
EYE_RADIUS = 1.7  # of the eyeballs of the default head, cm
RGB = {"skin": PLAIN_SKIN[:3], "teeth": (232, 222, 206), "tongue": (172, 96, 90), "mouth": (132, 58, 54)}
WHITE = np.array([216, 206, 200.0])
QUALITY = 92


def main() -> None:
    """Write the texture."""
    v, u = (np.mgrid[:HEIGHT, :WIDTH] + 0.5) / np.array([[[HEIGHT]], [[WIDTH]]])
    v = 1 - v
    texture = np.zeros((HEIGHT, WIDTH, 3), np.uint8)
    for name, (left, bottom) in COLOUR_UVS.items():
        inside = (np.abs(u - left) <= COLOUR_SIZE[0] / 2) & (np.abs(v - bottom) <= COLOUR_SIZE[1] / 2)
        texture[inside] = RGB[name][::-1]
    eye = u < EYE_UV[0] * 2
    texture[eye] = eye_colours(np.stack([u[eye], v[eye]], axis=1))
    cv2.imwrite(str(TEXTURE_FILE), texture, [cv2.IMWRITE_WEBP_QUALITY, QUALITY])
    print(f"{TEXTURE_FILE}: {TEXTURE_FILE.stat().st_size:,} B")


def eye_colours(uvs: NDArray[np.float64]) -> NDArray[np.uint8]:
    """Return the (k, 3) BGR colours of the default head's eye at (k, 2) texture coordinates."""
    x, y = ((uvs - EYE_UV) / EYE_UV_RADII).T
    angle = np.minimum(np.hypot(x, y), BLEED) * EYE_ARC / EYE_RADIUS
    atlas_uvs = FRAMES["eye"].map_into(eye_uv(np.minimum(angle, CAP_ANGLE), np.arctan2(y, x)))
    atlas = cv2.imread(str(DEFAULT_HEAD.with_name("skin.webp")))
    assert atlas is not None, "the default head has a texture"
    column = (atlas_uvs[:, 0] * atlas.shape[1] - 0.5).astype(np.float32)
    row = ((1 - atlas_uvs[:, 1]) * atlas.shape[0] - 0.5).astype(np.float32)
    sampled = cv2.remap(atlas, column.reshape(HEIGHT, -1), row.reshape(HEIGHT, -1), cv2.INTER_CUBIC)
    # Outside the iris the default head's eye is shaded for its own lids; here it is white.
    white = smoothstep(IRIS_ANGLE + 0.02, IRIS_ANGLE + 0.06, angle)[:, None]
    return np.asarray(sampled.reshape(-1, 3) * (1 - white) + white * WHITE[::-1], np.uint8)


if __name__ == "__main__":
    main()
