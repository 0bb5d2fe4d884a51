"""Draw a portrait: motion in, a picture of the caller out.

The background lies still. Over it goes the person, cut out, through the mesh that the motion has moved. Over mouth and
eyes go the one or two patches that are nearest to what they do now, through the same mesh, fading towards their edges.
"""

from dataclasses import replace

import moderngl
import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from conf.face.control_points import INDEX
from conf.face.head_pose import HeadPose
from conf.face.portrait.motion_deadband import settle_keys
from conf.face.portrait.patch_features import FEATURES, KEY_STEP, MOUTH
from conf.face.portrait.patch_mapping import FeatureMap
from conf.receiver.portrait.border_extension import draw_out
from conf.receiver.portrait.layer import Layer, load_texture
from conf.receiver.portrait.patch_blending import blend_shares, layers
from conf.receiver.portrait.portrait_store import Album, Sitter, Sticker
from conf.render.camera import View, rotation
from conf.render.shader_programs import program

SURROUND = (0.13, 0.14, 0.17)  # beside a picture of another shape than the window
OVER = (moderngl.SRC_ALPHA, moderngl.ONE_MINUS_SRC_ALPHA, moderngl.ONE, moderngl.ONE)
DARK_MOUTH = (0.16, 0.07, 0.07)
DARKEST = 0.75  # opacity: some of what is there stays to be seen
OPEN_CM = (0.25, 0.8)  # wider than what is shown in it was: where the mouth's inside begins to be dark, and is
PATCH_FADE = 0.06
HAND_TURN = np.radians(20)  # the farthest that the viewer's hand turns a face of which there is one side only
_LIP = INDEX["inner_lip_upper_mid"]


class PortraitRenderer:
    """Draws one caller's portrait from an album that fills while the call goes on."""

    def __init__(self, ctx: moderngl.Context, album: Album) -> None:
        self._ctx = ctx
        self._album = album
        self._program = program(ctx, "portrait", "portrait")
        self._mouth_program = program(ctx, "portrait", "portrait_mouth")
        self._mouth_program["dark"] = DARK_MOUTH
        self._set: _Set | None = None

    @property
    def ready(self) -> bool:
        """Whether a photograph has arrived."""
        return self._album.sitter is not None

    def draw(
        self, displacements: NDArray[np.floating], pose: HeadPose, view: View, framebuffer: moderngl.Framebuffer
    ) -> None:
        """Draw the caller into the framebuffer's viewport.

        displacements : (n, 3) FAPU units
        Raises ValueError if no photograph has arrived.
        """
        sitter = self._album.sitter
        if sitter is None:
            raise ValueError("the album must have a photograph")
        if self._set is None or self._set.sitter is not sitter:
            self._release_set()
            self._set = _Set(self._ctx, self._program, self._mouth_program, sitter)
        self._set.refresh(self._album)
        framebuffer.use()
        x, y, width, height = framebuffer.viewport
        framebuffer.clear(*SURROUND, viewport=(x, y, width, height))
        aspect = sitter.warp.shape.aspect
        frame, part = _fit(aspect, view, (width, height))
        self._ctx.scissor = (x + part[0], y + part[1], *part[2:])
        self._program["frame"] = self._mouth_program["frame"] = frame
        self._ctx.enable_only(moderngl.BLEND)
        # The window's own alpha stays 1, or a desktop would shine through; moderngl's stub knows two numbers only.
        self._ctx.blend_func = OVER  # type: ignore[assignment]
        self._set.draw(displacements, _seen_from(pose, view))
        self._ctx.scissor = None

    def release(self) -> None:
        """Free everything on the card."""
        self._release_set()
        self._program.release()
        self._mouth_program.release()

    def _release_set(self) -> None:
        if self._set is not None:
            self._set.release()
            self._set = None


class _Set:
    """One photograph on the card, with its patches."""

    def __init__(
        self, ctx: moderngl.Context, photo_program: moderngl.Program, mouth_program: moderngl.Program, sitter: Sitter
    ) -> None:
        self.sitter = sitter
        self._ctx = ctx
        self._program, self._mouth_program = photo_program, mouth_program
        mesh, warp = sitter.warp.mesh, sitter.warp
        self._places = ctx.buffer(reserve=mesh.places.shape[0] * 8)
        half = np.array([warp.shape.aspect / 2, 0.5])
        uvs = np.column_stack([mesh.places[:, 0] / half[0], -mesh.places[:, 1] / half[1]]) / 2 + 0.5
        whole = np.ones(len(uvs))
        colours, share, margin = draw_out(sitter.cutout.colours, sitter.cutout.share)
        within = (uvs + margin) / (1 + 2 * margin)
        person = load_texture(ctx, colours, share)
        self._person = Layer(
            ctx, photo_program, self._places, uvs=within, shares=warp.presence, triangles=mesh.triangles, texture=person
        )
        inside = mesh.triangles[mesh.in_mouth]
        plain = load_texture(ctx, np.zeros((1, 1, 3), np.uint8))
        self._inside = Layer(ctx, mouth_program, self._places, uvs=uvs, shares=whole, triangles=inside, texture=plain)
        corners = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]])
        self._still = ctx.buffer((corners * half).astype("f4").tobytes())
        self._backdrop = Layer(
            ctx,
            photo_program,
            self._still,
            uvs=corners * (0.5, -0.5) + 0.5,
            shares=np.ones(4),
            triangles=np.array([[0, 1, 2], [0, 2, 3]]),
            texture=load_texture(ctx, sitter.cutout.backdrop),
        )
        self._maps = [FeatureMap(feature, warp) for feature in FEATURES]
        self._stickers: dict[tuple[int, int], tuple[Sticker, Layer]] = {}

    def refresh(self, album: Album) -> None:
        """Take patches that are new in the album to the card, and those that are gone from it."""
        for at, (sticker, layer) in list(self._stickers.items()):
            if album.stickers.get(at) is not sticker:
                layer.release()
                del self._stickers[at]
        for at, sticker in album.stickers.items():
            if at not in self._stickers:
                self._stickers[at] = (sticker, self._layer_of(at[0], sticker))

    def draw(self, displacements: NDArray[np.floating], pose: HeadPose) -> None:
        """Draw background, person, mouth and patches."""
        warp = self.sitter.warp
        places = warp.place(displacements, pose)
        still = warp.stillness(places)
        self._places.write(places.astype("f4").tobytes())
        self._program["fade"] = 0.0
        self._program["opacity"] = 1.0
        self._backdrop.draw()
        self._person.draw()
        self._program["fade"] = PATCH_FADE
        for region, feature in enumerate(FEATURES):
            shown = self._draw_patches(region, displacements, still)
            if feature is MOUTH:
                self._darken(shown, displacements)

    def _draw_patches(self, region: int, displacements: NDArray[np.floating], still: float) -> NDArray[np.float64]:
        """Draw the patches of a feature; return the keys of what is seen then, photograph and patches together."""
        feature = FEATURES[region]
        candidates = [(sticker, layer) for (r, _), (sticker, layer) in self._stickers.items() if r == region]
        photo = np.array(feature.keys(self.sitter.warp.photographed())) / KEY_STEP
        now = settle_keys(np.array(feature.keys(displacements)) / KEY_STEP, photo, still)
        keys = np.array([photo, *(sticker.keys for sticker, _ in candidates)])
        shares = blend_shares(now, list(keys))
        for index, opacity in layers({i - 1: float(share) for i, share in enumerate(shares)}):
            self._program["opacity"] = opacity
            candidates[index][1].draw()
        return np.asarray(shares @ keys)

    def _darken(self, shown: NDArray[np.float64], displacements: NDArray[np.floating]) -> None:
        """Darken the mouth as far as it is open wider than what is shown in it was: teeth do not stretch."""
        wider = float(MOUTH.keys(displacements)[0] - shown[0] * KEY_STEP) * self.sitter.warp.shape.unit[_LIP, 1]
        self._mouth_program["opacity"] = DARKEST * float(
            np.clip((wider - OPEN_CM[0]) / (OPEN_CM[1] - OPEN_CM[0]), 0, 1)
        )
        self._inside.draw()

    def release(self) -> None:
        """Free everything on the card."""
        for layer in (self._person, self._inside, self._backdrop, *(layer for _, layer in self._stickers.values())):
            layer.release()
        self._places.release()
        self._still.release()

    def _layer_of(self, region: int, sticker: Sticker) -> Layer:
        feature_map, triangles = self._maps[region], self.sitter.warp.mesh.triangles
        return Layer(
            self._ctx,
            self._program,
            self._places,
            uvs=feature_map.place(sticker.points, sticker.pixels.shape[1::-1]),
            shares=feature_map.weights,
            triangles=triangles[(feature_map.weights[triangles] > 0).any(axis=1)],
            texture=load_texture(self._ctx, sticker.pixels),
        )


def _seen_from(pose: HeadPose, view: View) -> HeadPose:
    """Return the pose as the viewer's hand has turned it, as far as a photograph can be."""
    yaw, pitch = np.clip((view.yaw, view.pitch), -HAND_TURN, HAND_TURN)
    within = replace(view, yaw=float(yaw), pitch=float(pitch))
    return HeadPose(Rotation.from_matrix(rotation(pose, within)).as_rotvec(), pose.position, pose.log_scale)


def _fit(
    aspect: float, view: View, size: tuple[int, int]
) -> tuple[tuple[float, float, float, float], tuple[int, int, int, int]]:
    """Fit a picture into a window.

    aspect : width of the picture over its height; size : of the window in pixels
    Returns the shader's `frame`, and left, bottom, width and height in pixels of the part that may be drawn on.
    """
    width, height = size
    fit = min(1.0, width / height / aspect) * view.zoom
    scale = (2 * fit * height / width, 2 * fit)
    shift = (2 * view.pan[0] * height / width, 2 * view.pan[1])
    half = (scale[0] * aspect / 2, scale[1] / 2)
    low = [max(0, round((1 + s - h) / 2 * side)) for s, h, side in zip(shift, half, size, strict=True)]
    high = [min(side, round((1 + s + h) / 2 * side)) for s, h, side in zip(shift, half, size, strict=True)]
    part = (low[0], low[1], max(0, high[0] - low[0]), max(0, high[1] - low[1]))
    return (*scale, *shift), part
