"""Render a portrait from motion.

The background is drawn unmoved, then the person, cut out, through the deformed mesh. Over the face the views nearest to
the current pose and expression are drawn through the same mesh. Over mouth and eyes the one or two
patches nearest to the current expression are drawn through the same mesh, fading towards their edges. The inside of a
mouth that is open wider than in these, and lids that are closer together than in the photo, are predicted.
"""

from dataclasses import replace

import moderngl
import numpy as np
from numpy.typing import NDArray

from conf.face.control_points import CONTROL_POINT_COUNT, CONTROL_POINT_INDEX
from conf.face.head_pose import HeadPose
from conf.face.portrait.head_views import describe_shape, view_alpha, view_weights
from conf.face.portrait.image_blending import blend_weights, compositing_order
from conf.face.portrait.motion_deadband import dampen_descriptor
from conf.face.portrait.patch_features import DESCRIPTOR_STEP, FEATURES, MOUTH
from conf.face.portrait.patch_mapping import PatchMapping
from conf.face.rotations import rotation_vector
from conf.receiver.portrait.border_extension import extend_border
from conf.receiver.portrait.mouth_interior import MouthInterior, predict_mouth_interior
from conf.receiver.portrait.portrait_store import PortraitStore, ReceivedPatch, ReceivedPhoto, ReceivedView
from conf.receiver.portrait.shut_lids import ShutLid, predict_shut_lids
from conf.render.camera import ViewState, view_rotation
from conf.render.gpu_object import GpuObject
from conf.render.shader_programs import load_program

LETTERBOX = (0.13, 0.14, 0.17)  # RGB beside a photo of another aspect ratio than the viewport
ALPHA_BLEND = (moderngl.SRC_ALPHA, moderngl.ONE_MINUS_SRC_ALPHA, moderngl.ONE, moderngl.ONE)
MAX_MOUTH_OPACITY = 0.88  # of the predicted inside
OPEN_CM = (0.25, 0.8)  # mouth opening beyond that of the images shown, over which the inside is predicted
PATCH_FADE = 0.06  # of the patch's width and height, over which its border fades
MAX_ORBIT = np.radians(20)  # limit of the viewer's yaw and pitch: a photo shows one side of the face only
_LIP = CONTROL_POINT_INDEX["inner_lip_upper_mid"]


def load_texture(
    ctx: moderngl.Context, pixels: NDArray[np.uint8], alpha: NDArray[np.uint8] | None = None
) -> moderngl.Texture:
    """Return a texture of (H, W, 3) uint8 BGR and (H, W) uint8 alpha, first row first."""
    height, width = pixels.shape[:2]
    texture = ctx.texture((width, height), 4, _rgba(pixels, alpha))
    texture.filter = (moderngl.LINEAR, moderngl.LINEAR)
    texture.repeat_x = texture.repeat_y = False
    return texture


def _rgba(pixels: NDArray[np.uint8], alpha: NDArray[np.uint8] | None = None) -> bytes:
    rgba = np.empty((*pixels.shape[:2], 4), np.uint8)
    rgba[..., :3] = pixels[..., ::-1]
    rgba[..., 3] = 255 if alpha is None else alpha
    return rgba.tobytes()


class TexturedLayer(GpuObject):
    """A texture with its coordinates on the mesh."""

    def __init__(
        self,
        ctx: moderngl.Context,
        program: moderngl.Program,
        positions: moderngl.Buffer,
        *,
        uvs: NDArray[np.floating],
        alphas: NDArray[np.floating],
        triangles: NDArray[np.integer],
        texture: moderngl.Texture,
    ) -> None:
        """Take over the texture. positions : (V, 2) float32, shared; uvs : (V, 2); alphas : (V,); triangles : (F, 3)"""
        self._texture = texture
        attributes = ctx.buffer(np.column_stack([uvs, alphas]).astype("f4").tobytes())
        indices = ctx.buffer(np.ascontiguousarray(triangles, dtype=np.int32).tobytes())
        content = [(positions, "2f4", "in_position"), (attributes, "2f4 1f4", "in_uv", "in_alpha")]
        self._array = ctx.vertex_array(program, content, indices, skip_errors=True)
        self._owned = (self._array, indices, attributes, texture)

    def replace_image(self, pixels: NDArray[np.uint8]) -> None:
        """Replace the texture's pixels by (H, W, 3) uint8 BGR of the same size."""
        self._texture.write(_rgba(pixels))

    def draw(self) -> None:
        """Draw with the program's current uniforms."""
        self._texture.use(0)
        self._array.render(moderngl.TRIANGLES)


class PortraitRenderer(GpuObject):
    """Draws one participant's portrait from a store that fills during the call."""

    def __init__(self, ctx: moderngl.Context, store: PortraitStore) -> None:
        self._ctx = ctx
        self.store = store
        self._program = load_program(ctx, "portrait", "portrait")
        self._scene: _PhotoScene | None = None
        self._owned = (self._program,)

    @property
    def ready(self) -> bool:
        """Whether a photo has been received."""
        return self.store.photo is not None

    def draw(
        self, displacements: NDArray[np.floating], pose: HeadPose, view: ViewState, framebuffer: moderngl.Framebuffer
    ) -> None:
        """Draw the portrait into the framebuffer's viewport.

        displacements : (n, 3) FAPU units
        Raises ValueError if no photo has been received.
        """
        photo = self.store.photo
        if photo is None:
            raise ValueError("the store must have a photo")
        if self._scene is None or self._scene.photo is not photo:
            if self._scene is not None:
                self._scene.release()
            self._scene = _PhotoScene(self._ctx, self._program, photo)
            self._owned = (self._scene, self._program)
        self._scene.sync(self.store)
        framebuffer.use()
        x, y, width, height = framebuffer.viewport
        framebuffer.clear(*LETTERBOX, depth=1.0, viewport=(x, y, width, height))
        frame, scissor = _fit(photo.warp.shape.aspect, view, (width, height))
        self._ctx.scissor = (x + scissor[0], y + scissor[1], *scissor[2:])
        self._program["frame"] = frame
        self._ctx.enable_only(moderngl.BLEND)
        # The window's own alpha must stay 1, or the desktop shines through. moderngl's stub allows two factors only.
        self._ctx.blend_func = ALPHA_BLEND  # type: ignore[assignment]
        self._scene.draw(displacements, _limited_orbit(pose, view))
        self._ctx.scissor = None


class _PhotoScene(GpuObject):
    """The GPU objects of one photo and its patches."""

    def __init__(self, ctx: moderngl.Context, program: moderngl.Program, photo: ReceivedPhoto) -> None:
        self.photo = photo
        self._ctx = ctx
        self._program = program
        mesh, warp = photo.warp.mesh, photo.warp
        self._positions = ctx.buffer(reserve=mesh.positions.shape[0] * 8)
        half = np.array([warp.shape.aspect / 2, 0.5])
        uvs = np.column_stack([mesh.positions[:, 0] / half[0], -mesh.positions[:, 1] / half[1]]) / 2 + 0.5
        colours, alpha, margin = extend_border(photo.matte.colours, photo.matte.alpha, warp.shape)
        self._person = TexturedLayer(
            ctx, program, self._positions, uvs=(uvs + margin) / (1 + 2 * margin), alphas=np.ones(len(uvs)),
            triangles=mesh.triangles, texture=load_texture(ctx, colours, alpha),
        )  # fmt: skip
        self._mouth = predict_mouth_interior(photo.pixels, warp)
        self._mouth_positions, self._mouth_layer = self._load_grid(self._mouth)
        corners = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]])
        backdrop_positions = ctx.buffer((corners * half).astype("f4").tobytes())
        self._backdrop = TexturedLayer(
            ctx, program, backdrop_positions, uvs=corners * (0.5, -0.5) + 0.5, alphas=np.ones(4),
            triangles=np.array([[0, 1, 2], [0, 2, 3]]), texture=load_texture(ctx, photo.matte.backdrop),
        )  # fmt: skip
        self._backdrop_pixels = photo.matte.backdrop
        self._owned = (self._person, self._backdrop, self._mouth_layer)
        self._owned += (self._positions, backdrop_positions, self._mouth_positions)
        self._lids = [(lid, *self._load_grid(lid)) for lid in predict_shut_lids(photo.pixels, warp)]
        self._owned += tuple(item for _, buffer, layer in self._lids for item in (layer, buffer))
        self._mappings = [PatchMapping(region, warp) for region in FEATURES]
        self._patches: dict[tuple[int, int], tuple[ReceivedPatch, TexturedLayer]] = {}
        self._views: dict[int, tuple[ReceivedView, TexturedLayer]] = {}
        pixels = mesh.positions * (1, -1) / (warp.shape.aspect, 1) + 0.5
        self._view_alpha = view_alpha(warp) * sample_alpha(photo.matte.alpha, pixels)
        self._photo_shape = describe_shape(warp.shape.points[:CONTROL_POINT_COUNT], warp.shape.pose)

    def sync(self, store: PortraitStore) -> None:
        """Upload the store's new background, views and patches, and release those that it no longer has."""
        if store.backdrop is not None and store.backdrop is not self._backdrop_pixels:
            self._backdrop_pixels = store.backdrop
            self._backdrop.replace_image(store.backdrop)
        for number, (view, layer) in list(self._views.items()):
            if store.views.get(number) is not view:
                layer.release()
                del self._views[number]
        for number, view in store.views.items():
            if number not in self._views:
                self._views[number] = (view, self._load_view(view))
        for slot, (patch, layer) in list(self._patches.items()):
            if store.patches.get(slot) is not patch:
                layer.release()
                del self._patches[slot]
        for slot, patch in store.patches.items():
            if slot not in self._patches:
                self._patches[slot] = (patch, self._load_patch(slot[0], patch))

    def draw(self, displacements: NDArray[np.floating], pose: HeadPose) -> None:
        """Draw background, person, patches and mouth."""
        warp = self.photo.warp
        positions = warp.deform(displacements, pose)
        stillness = warp.stillness(positions)
        self._positions.write(positions.astype("f4").tobytes())
        self._program["fade"] = self._program["depth"] = 0.0
        self._program["opacity"] = 1.0
        self._backdrop.draw()
        self._person.draw()
        shown = self._draw_views(displacements, pose)
        self._program["fade"] = PATCH_FADE
        for index, region in enumerate(FEATURES):
            descriptor = self._draw_patches(index, displacements, shown, stillness)
            if region is MOUTH:
                self._draw_mouth(descriptor, displacements, positions)
        self._draw_lids(positions)

    def _draw_views(self, displacements: NDArray[np.floating], pose: HeadPose) -> NDArray[np.float64]:
        """Blend the views over the photo's face, those most whose shape is nearest to the current one.

        Returns the displacements (n, 3), FAPU units, that photo and views together show.
        """
        warp = self.photo.warp
        photo = warp.photo_displacements()
        if not self._views:
            return photo
        current = describe_shape(warp.control_points(displacements), pose)
        views = list(self._views.values())
        shapes = np.array([self._photo_shape, *(view.head.descriptor for view, _ in views)])
        weights = view_weights(current, shapes)
        # A closing lid covers the eyeball: of triangles of one view, at one depth, only the first drawn may be seen.
        self._ctx.enable(moderngl.DEPTH_TEST)
        order = compositing_order({i - 1: float(weight) for i, weight in enumerate(weights)})
        for layer, (index, opacity) in enumerate(order, start=1):
            self._program["depth"] = -layer / len(shapes)
            self._program["opacity"] = opacity
            views[index][1].draw()
        self._ctx.disable(moderngl.DEPTH_TEST)
        self._program["depth"] = 0.0
        return np.tensordot(weights, [photo, *(warp.displacements(view.points) for view, _ in views)], axes=1)

    def _draw_patches(
        self, region: int, displacements: NDArray[np.floating], shown: NDArray[np.float64], stillness: float
    ) -> NDArray[np.float64]:
        """Draw the patches of a region over what photo and views show; return the descriptor that all together show.

        shown : (n, 3) FAPU units, from _draw_views
        """
        candidates = [entry for (r, _), entry in self._patches.items() if r == region]
        describe = FEATURES[region].descriptor
        below = np.array(describe(shown)) / DESCRIPTOR_STEP
        current = dampen_descriptor(np.array(describe(displacements)) / DESCRIPTOR_STEP, below, stillness)
        descriptors = np.array([below, *(patch.descriptor for patch, _ in candidates)])
        weights = blend_weights(current, list(descriptors))
        for index, opacity in compositing_order({i - 1: float(weight) for i, weight in enumerate(weights)}):
            self._program["opacity"] = opacity
            candidates[index][1].draw()
        return np.asarray(weights @ descriptors)

    def _draw_lids(self, positions: NDArray[np.float64]) -> None:
        """Cover eyes that are closer shut than in the photo with predicted lids."""
        self._program["fade"] = 0.0
        for lid, buffer, layer in self._lids:
            vertices, opacity = lid.grid(positions)
            if opacity > 0:
                buffer.write(vertices.astype("f4").tobytes())
                self._program["opacity"] = opacity
                layer.draw()

    def _draw_mouth(
        self, shown: NDArray[np.float64], displacements: NDArray[np.floating], positions: NDArray[np.float64]
    ) -> None:
        """Predict the inside of a mouth that is open wider than in the images shown: stretched teeth look wrong."""
        units = float(MOUTH.descriptor(displacements)[0] - shown[0] * DESCRIPTOR_STEP)
        opening_cm = units * self.photo.warp.shape.fapu_lengths[_LIP, 1]
        weight = float(np.clip((opening_cm - OPEN_CM[0]) / (OPEN_CM[1] - OPEN_CM[0]), 0, 1))
        if weight > 0:
            self._mouth_positions.write(self._mouth.grid(positions).astype("f4").tobytes())
            self._program["fade"] = 0.0
            self._program["opacity"] = MAX_MOUTH_OPACITY * weight
            self._mouth_layer.draw()
            self._program["fade"] = PATCH_FADE

    def release(self) -> None:
        for _, layer in (*self._patches.values(), *self._views.values()):
            layer.release()
        super().release()

    def _load_grid(self, grid: ShutLid | MouthInterior) -> tuple[moderngl.Buffer, TexturedLayer]:
        buffer = self._ctx.buffer(reserve=len(grid.uvs) * 8)
        layer = TexturedLayer(
            self._ctx, self._program, buffer, uvs=grid.uvs, alphas=np.ones(len(grid.uvs)),
            triangles=grid.triangles, texture=load_texture(self._ctx, grid.colours, grid.alpha),
        )  # fmt: skip
        return buffer, layer

    def _load_view(self, view: ReceivedView) -> TexturedLayer:
        alphas = self._view_alpha * ((view.uvs > 0) & (view.uvs < 1)).all(axis=1)
        triangles = self.photo.warp.mesh.triangles
        return TexturedLayer(
            self._ctx, self._program, self._positions, uvs=view.uvs, alphas=alphas,
            triangles=triangles[(alphas[triangles] > 0).any(axis=1)][::-1],  # lids before eyeballs
            texture=load_texture(self._ctx, view.pixels),
        )  # fmt: skip

    def _load_patch(self, region: int, patch: ReceivedPatch) -> TexturedLayer:
        mapping, triangles = self._mappings[region], self.photo.warp.mesh.triangles
        return TexturedLayer(
            self._ctx, self._program, self._positions,
            uvs=mapping.map_vertices(patch.points, patch.pixels.shape[1::-1]), alphas=mapping.weights,
            triangles=triangles[(mapping.weights[triangles] > 0).any(axis=1)],
            texture=load_texture(self._ctx, patch.pixels),
        )  # fmt: skip


def sample_alpha(alpha: NDArray[np.uint8], uvs: NDArray[np.float64], /) -> NDArray[np.float64]:
    """Return (V,), 0 to 1, an alpha (H, W) uint8 at texture coordinates (V, 2), beyond the border replicated."""
    height, width = alpha.shape
    x, y = (np.clip(np.rint(uvs * (width, height) - 0.5), 0, (width - 1, height - 1)).astype(int)).T
    return np.asarray(alpha[y, x] / 255, np.float64)


def _limited_orbit(pose: HeadPose, view: ViewState) -> HeadPose:
    """Return the pose rotated by the viewer's orbit, limited to what a photo can show."""
    yaw, pitch = np.clip((view.yaw, view.pitch), -MAX_ORBIT, MAX_ORBIT)
    limited = replace(view, yaw=float(yaw), pitch=float(pitch))
    return HeadPose(rotation_vector(view_rotation(pose, limited)), pose.position, pose.log_scale)


def _fit(
    aspect: float, view: ViewState, size: tuple[int, int]
) -> tuple[tuple[float, float, float, float], tuple[int, int, int, int]]:
    """Fit an image into a viewport.

    aspect : width of the image over its height; size : of the viewport in pixels
    Returns the shader's `frame`, and left, bottom, width and height in pixels of the area to draw in.
    """
    width, height = size
    fit = min(1.0, width / height / aspect) * view.zoom
    scale = (2 * fit * height / width, 2 * fit)
    shift = (2 * view.pan[0] * height / width, 2 * view.pan[1])
    half = (scale[0] * aspect / 2, scale[1] / 2)
    low = [max(0, round((1 + s - h) / 2 * side)) for s, h, side in zip(shift, half, size, strict=True)]
    high = [min(side, round((1 + s + h) / 2 * side)) for s, h, side in zip(shift, half, size, strict=True)]
    return (*scale, *shift), (low[0], low[1], max(0, high[0] - low[0]), max(0, high[1] - low[1]))
