"""Draw a portrait: motion in, a picture of the caller out.

The background lies still. Over it goes the person, cut out, through the mesh that the motion has moved. Over mouth and
eyes go the one or two patches that are nearest to what they do now, through the same mesh, fading towards their edges.
"""

from dataclasses import replace

import moderngl
import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from conf.face.control_points import CONTROL_POINT_INDEX
from conf.face.head_pose import HeadPose
from conf.face.portrait.motion_deadband import dampen_descriptor
from conf.face.portrait.patch_features import DESCRIPTOR_STEP, FEATURES, MOUTH
from conf.face.portrait.patch_mapping import PatchMapping
from conf.receiver.portrait.border_extension import extend_border
from conf.receiver.portrait.layer import TexturedLayer, load_texture
from conf.receiver.portrait.patch_blending import blend_weights, compositing_order
from conf.receiver.portrait.portrait_store import PortraitStore, ReceivedPatch, ReceivedPhoto
from conf.render.camera import ViewState, view_rotation
from conf.render.shader_programs import load_program

LETTERBOX = (0.13, 0.14, 0.17)  # beside a picture of another shape than the window
ALPHA_BLEND = (moderngl.SRC_ALPHA, moderngl.ONE_MINUS_SRC_ALPHA, moderngl.ONE, moderngl.ONE)
DARK_MOUTH = (0.16, 0.07, 0.07)
MAX_MOUTH_OPACITY = 0.75  # opacity: some of what is there stays to be seen
OPEN_CM = (0.25, 0.8)  # wider than what is shown in it was: where the mouth's inside begins to be dark, and is
PATCH_FADE = 0.06
MAX_ORBIT = np.radians(20)  # the farthest that the viewer's hand turns a face of which there is one side only
_LIP = CONTROL_POINT_INDEX["inner_lip_upper_mid"]


class PortraitRenderer:
    """Draws one caller's portrait from an album that fills while the call goes on."""

    def __init__(self, ctx: moderngl.Context, album: PortraitStore) -> None:
        self._ctx = ctx
        self._album = album
        self._program = load_program(ctx, "portrait", "portrait")
        self._mouth_program = load_program(ctx, "portrait", "portrait_mouth")
        self._mouth_program["dark"] = DARK_MOUTH
        self._set: _PhotoScene | None = None

    @property
    def ready(self) -> bool:
        """Whether a photograph has arrived."""
        return self._album.photo is not None

    def draw(
        self, displacements: NDArray[np.floating], pose: HeadPose, view: ViewState, framebuffer: moderngl.Framebuffer
    ) -> None:
        """Draw the caller into the framebuffer's viewport.

        displacements : (n, 3) FAPU units
        Raises ValueError if no photograph has arrived.
        """
        sitter = self._album.photo
        if sitter is None:
            raise ValueError("the album must have a photograph")
        if self._set is None or self._set.sitter is not sitter:
            self._release_set()
            self._set = _PhotoScene(self._ctx, self._program, self._mouth_program, sitter)
        self._set.sync_patches(self._album)
        framebuffer.use()
        x, y, width, height = framebuffer.viewport
        framebuffer.clear(*LETTERBOX, viewport=(x, y, width, height))
        aspect = sitter.warp.shape.aspect
        frame, part = _fit(aspect, view, (width, height))
        self._ctx.scissor = (x + part[0], y + part[1], *part[2:])
        self._program["frame"] = self._mouth_program["frame"] = frame
        self._ctx.enable_only(moderngl.BLEND)
        # The window's own alpha stays 1, or a desktop would shine through; moderngl's stub knows two numbers only.
        self._ctx.blend_func = ALPHA_BLEND  # type: ignore[assignment]
        self._set.draw(displacements, _limited_orbit(pose, view))
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


class _PhotoScene:
    """One photograph on the card, with its patches."""

    def __init__(
        self,
        ctx: moderngl.Context,
        photo_program: moderngl.Program,
        mouth_program: moderngl.Program,
        sitter: ReceivedPhoto,
    ) -> None:
        self.sitter = sitter
        self._ctx = ctx
        self._program, self._mouth_program = photo_program, mouth_program
        mesh, warp = sitter.warp.mesh, sitter.warp
        self._places = ctx.buffer(reserve=mesh.positions.shape[0] * 8)
        half = np.array([warp.shape.aspect / 2, 0.5])
        uvs = np.column_stack([mesh.positions[:, 0] / half[0], -mesh.positions[:, 1] / half[1]]) / 2 + 0.5
        whole = np.ones(len(uvs))
        colours, share, margin = extend_border(sitter.cutout.colours, sitter.cutout.alpha)
        within = (uvs + margin) / (1 + 2 * margin)
        person = load_texture(ctx, colours, share)
        self._person = TexturedLayer(
            ctx,
            photo_program,
            self._places,
            uvs=within,
            alphas=warp.border_alpha,
            triangles=mesh.triangles,
            texture=person,
        )
        inside = mesh.triangles[mesh.in_mouth]
        plain = load_texture(ctx, np.zeros((1, 1, 3), np.uint8))
        self._inside = TexturedLayer(
            ctx, mouth_program, self._places, uvs=uvs, alphas=whole, triangles=inside, texture=plain
        )
        corners = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]])
        self._still = ctx.buffer((corners * half).astype("f4").tobytes())
        self._backdrop = TexturedLayer(
            ctx,
            photo_program,
            self._still,
            uvs=corners * (0.5, -0.5) + 0.5,
            alphas=np.ones(4),
            triangles=np.array([[0, 1, 2], [0, 2, 3]]),
            texture=load_texture(ctx, sitter.cutout.backdrop),
        )
        self._maps = [PatchMapping(feature, warp) for feature in FEATURES]
        self._stickers: dict[tuple[int, int], tuple[ReceivedPatch, TexturedLayer]] = {}

    def sync_patches(self, album: PortraitStore) -> None:
        """Take patches that are new in the album to the card, and those that are gone from it."""
        for at, (sticker, layer) in list(self._stickers.items()):
            if album.patches.get(at) is not sticker:
                layer.release()
                del self._stickers[at]
        for at, sticker in album.patches.items():
            if at not in self._stickers:
                self._stickers[at] = (sticker, self._layer_of(at[0], sticker))

    def draw(self, displacements: NDArray[np.floating], pose: HeadPose) -> None:
        """Draw background, person, mouth and patches."""
        warp = self.sitter.warp
        places = warp.deform(displacements, pose)
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
        photo = np.array(feature.descriptor(self.sitter.warp.photo_displacements())) / DESCRIPTOR_STEP
        now = dampen_descriptor(np.array(feature.descriptor(displacements)) / DESCRIPTOR_STEP, photo, still)
        keys = np.array([photo, *(sticker.keys for sticker, _ in candidates)])
        shares = blend_weights(now, list(keys))
        for index, opacity in compositing_order({i - 1: float(share) for i, share in enumerate(shares)}):
            self._program["opacity"] = opacity
            candidates[index][1].draw()
        return np.asarray(shares @ keys)

    def _darken(self, shown: NDArray[np.float64], displacements: NDArray[np.floating]) -> None:
        """Darken the mouth as far as it is open wider than what is shown in it was: teeth do not stretch."""
        wider = (
            float(MOUTH.descriptor(displacements)[0] - shown[0] * DESCRIPTOR_STEP)
            * self.sitter.warp.shape.fapu_lengths[_LIP, 1]
        )
        self._mouth_program["opacity"] = MAX_MOUTH_OPACITY * float(
            np.clip((wider - OPEN_CM[0]) / (OPEN_CM[1] - OPEN_CM[0]), 0, 1)
        )
        self._inside.draw()

    def release(self) -> None:
        """Free everything on the card."""
        for layer in (self._person, self._inside, self._backdrop, *(layer for _, layer in self._stickers.values())):
            layer.release()
        self._places.release()
        self._still.release()

    def _layer_of(self, region: int, sticker: ReceivedPatch) -> TexturedLayer:
        feature_map, triangles = self._maps[region], self.sitter.warp.mesh.triangles
        return TexturedLayer(
            self._ctx,
            self._program,
            self._places,
            uvs=feature_map.map_vertices(sticker.points, sticker.pixels.shape[1::-1]),
            alphas=feature_map.weights,
            triangles=triangles[(feature_map.weights[triangles] > 0).any(axis=1)],
            texture=load_texture(self._ctx, sticker.pixels),
        )


def _limited_orbit(pose: HeadPose, view: ViewState) -> HeadPose:
    """Return the pose as the viewer's hand has turned it, as far as a photograph can be."""
    yaw, pitch = np.clip((view.yaw, view.pitch), -MAX_ORBIT, MAX_ORBIT)
    within = replace(view, yaw=float(yaw), pitch=float(pitch))
    return HeadPose(Rotation.from_matrix(view_rotation(pose, within)).as_rotvec(), pose.position, pose.log_scale)


def _fit(
    aspect: float, view: ViewState, size: tuple[int, int]
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
