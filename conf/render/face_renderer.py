"""Draw a face: deformed vertices and a head pose in, a picture out.

Each frame the neck is bent (neck.py) and the normals are computed again from the vertices (surface.py), both are
uploaded, each group of triangles is drawn with its material's shader into a canvas, and the canvas goes over the
background with its edges smoothed.
"""

import cv2
import moderngl
import numpy as np
from numpy.typing import NDArray

from conf.errors import FileFormatError
from conf.face.control_points import CONTROL_POINT_INDEX
from conf.face.deformation.face_model import FaceModel
from conf.face.deformation.neck import NeckBend
from conf.face.head_pose import HeadPose
from conf.face.mesh.mesh import Mesh
from conf.face.mesh.winding import orient_outwards
from conf.render.camera import ViewState, clip_matrix, view_rotation
from conf.render.control_point_markers import ControlPointMarkers
from conf.render.lighting import STUDIO, Lighting
from conf.render.materials import EYE, MOUTH, SKIN, material_of
from conf.render.render_target import RenderTarget
from conf.render.shader_programs import load_program, set_matrix, to_column_major
from conf.render.shadow_map import ShadowMap, light_matrix
from conf.render.vertex_cache import optimise_vertex_cache
from conf.render.vertex_normals import VertexNormals
from conf.render.wireframe import WireframeRenderer

CLIP_TO_TEXTURE = np.array(
    [[0.5, 0, 0, 0.5], [0, 0.5, 0, 0.5], [0, 0, 0.5, 0.5], [0, 0, 0, 1]]
)  # clip to texture coordinates
MAX_TARGETS = 6  # sizes of picture drawn in turn, as the cells of several callers are
PLAIN_SKIN = (226, 178, 150, 255)  # sRGB, of a mesh without a texture


class FaceRenderer:
    """Draws one face again and again."""

    def __init__(self, ctx: moderngl.Context, face: FaceModel, *, lighting: Lighting = STUDIO) -> None:
        mesh = optimise_vertex_cache(orient_outwards(face.mesh))
        self.background = "wall"  # a name from canvas.py
        self._ctx = ctx
        self._lighting = lighting
        self._neck = NeckBend(mesh)
        self._surface = VertexNormals(mesh.triangles, mesh.render_vertices)
        self._canvases: dict[tuple[tuple[int, int], str], RenderTarget] = {}
        self._atlas = load_texture(ctx, mesh)
        self._moving = ctx.buffer(reserve=len(mesh.render_vertices) * 24)
        self._uvs = ctx.buffer(texture_coordinates(mesh).tobytes())
        self._parts = [
            MeshPart(ctx, group, mesh.render_triangles[triangles], (self._moving, self._uvs), lighting)
            for group, triangles in ordered_groups(mesh)
        ]
        for part in self._parts:
            part.set_anatomy(face)
        self._wireframe = WireframeRenderer(ctx, mesh, self._moving)
        self._shadow = ShadowMap(ctx, mesh, self._moving)
        self._marks = ControlPointMarkers(ctx, face.control_points, mesh.vertices)
        self._rows = np.empty((0, 6), np.float32)
        self.canvas: RenderTarget | None = None  # what was drawn on last
        self._places = face.control_points.astype(np.float32)

    def draw(
        self, vertices: NDArray[np.float32], pose: HeadPose, view: ViewState, framebuffer: moderngl.Framebuffer
    ) -> None:
        """Draw the face into the framebuffer's viewport.

        vertices : (V, 3) float32, face axes, cm
        """
        self.prepare(vertices, pose)
        self.upload()
        self.draw_uploaded(pose, view, framebuffer)

    def prepare(self, vertices: NDArray[np.float32], pose: HeadPose) -> None:
        """First part of `draw`: bend the neck, compute the normals of the (V, 3) vertices."""
        self._rows = self._surface.interleaved(self._neck.apply(vertices, pose))
        self._places = self._marks.positions(vertices)

    def upload(self) -> None:
        """Second part of `draw`: send positions and normals to the card."""
        self._moving.orphan()
        self._moving.write(self._rows)

    def draw_uploaded(self, pose: HeadPose, view: ViewState, framebuffer: moderngl.Framebuffer) -> None:
        """Third part of `draw`: draw what was uploaded last."""
        _, _, width, height = framebuffer.viewport
        self.canvas = canvas = self._canvas_of((width, height))
        clip = to_column_major(clip_matrix(pose, view, aspect=width / height))
        turn = to_column_major(view_rotation(pose, view))
        if view.wireframe:
            canvas.begin()
            self._wireframe.draw(clip, turn)
        else:
            lamp = self._shadow.update(light_matrix(view_rotation(pose, view), self._lighting.key), self._places)
            canvas.begin()
            self._atlas.use(0)
            self._shadow.depth.use(1)
            to_texture = to_column_major(CLIP_TO_TEXTURE @ lamp)
            for part in self._parts:
                part.draw(clip, turn, to_texture)
        canvas.resolve(framebuffer)
        if view.points:
            self._marks.draw(self._places, clip, canvas.depth)

    def release(self) -> None:
        """Free everything on the card."""
        for part in self._parts:
            part.release()
        self._release_canvases()
        for thing in (self._wireframe, self._shadow, self._marks, self._uvs, self._moving, self._atlas):
            thing.release()

    def _canvas_of(self, size: tuple[int, int]) -> RenderTarget:
        key = (size, self.background)
        if key not in self._canvases:
            if len(self._canvases) >= MAX_TARGETS:  # the window has got another size
                self._release_canvases()
            self._canvases[key] = RenderTarget(self._ctx, size, self.background)
        return self._canvases[key]

    def _release_canvases(self) -> None:
        for canvas in self._canvases.values():
            canvas.release()
        self._canvases.clear()
        self.canvas = None


class MeshPart:
    """One group of triangles with its shader."""

    def __init__(
        self,
        ctx: moderngl.Context,
        group: str,
        triangles: NDArray[np.int32],
        buffers: tuple[moderngl.Buffer, moderngl.Buffer],
        lighting: Lighting,
    ) -> None:
        """triangles : (F, 3) render vertices; buffers : (R, 6) positions and normals, (R, 2) texture coordinates"""
        self.group = group
        self.material = material_of(group)
        self._ctx = ctx
        self._program = load_program(ctx, self.material.vertex_shader, self.material.shader, lighting.constants())
        self._indices = ctx.buffer(np.ascontiguousarray(triangles, dtype=np.int32).tobytes())
        moving, uvs = buffers
        layout = [(moving, "3f4 3f4", "in_position", "in_normal"), (uvs, "2f4", "in_uv")]
        self._array = ctx.vertex_array(self._program, layout, self._indices, skip_errors=True)
        for unit, name in enumerate(("atlas", "shadow")):
            if name in self._program:
                self._program[name] = unit

    def set_anatomy(self, face: FaceModel) -> None:
        """Tell the shader where its part of the neutral face lies."""
        if self.material is EYE:
            ball = face.mesh.vertices[face.mesh.group_vertices(self.group)]
            self._program["centre"] = tuple((ball.min(axis=0) + ball.max(axis=0)) / 2)
            self._program["radius"] = np.ptp(ball[:, 1]) / 2
        if self.material is MOUTH:
            lips = face.control_points[
                [CONTROL_POINT_INDEX["inner_lip_upper_mid"], CONTROL_POINT_INDEX["inner_lip_lower_mid"]]
            ]
            self._program["centre"] = tuple(lips.mean(axis=0))

    def draw(self, clip: bytes, rotation: bytes, light: bytes) -> None:
        """Draw the group: the matrices as `columns` gives them."""
        self._ctx.enable_only(moderngl.DEPTH_TEST)
        if not self.material.two_sided:
            self._ctx.enable(moderngl.CULL_FACE)
        if self.material.blended:
            self._ctx.enable(moderngl.BLEND)
        set_matrix(self._program, "clip", clip)
        set_matrix(self._program, "turn", rotation)
        set_matrix(self._program, "lamp", light)
        self._array.render(moderngl.TRIANGLES)

    def release(self) -> None:
        """Free everything on the card."""
        for thing in (self._array, self._indices, self._program):
            thing.release()


def ordered_groups(mesh: Mesh) -> list[tuple[str, NDArray[np.int64]]]:
    """Return the groups with their triangles in the order they are drawn: skin first, as it hides the most."""
    rest = np.ones(len(mesh.triangles), dtype=bool)
    for triangles in mesh.groups.values():
        rest[triangles] = False
    groups = [*mesh.groups.items(), ("in no group", np.flatnonzero(rest))]
    filled = [(name, triangles) for name, triangles in groups if len(triangles)]
    return sorted(filled, key=lambda group: (material_of(group[0]).blended, material_of(group[0]) is not SKIN))


def texture_coordinates(mesh: Mesh) -> NDArray[np.float32]:
    """Return (R, 2) float32; zeros for a mesh that has none."""
    if len(mesh.uvs) == len(mesh.render_vertices):
        return np.ascontiguousarray(mesh.uvs, dtype=np.float32)
    return np.zeros((len(mesh.render_vertices), 2), np.float32)


def load_texture(ctx: moderngl.Context, mesh: Mesh) -> moderngl.Texture:
    """Return the mesh's texture on the card, plain skin where it has none.

    Raises FileFormatError if the file is no picture.
    """
    if mesh.texture is None or len(mesh.uvs) == 0:
        return ctx.texture((1, 1), 4, bytes(PLAIN_SKIN))
    picture = cv2.imread(str(mesh.texture), cv2.IMREAD_UNCHANGED)
    if picture is None or picture.dtype != np.uint8:
        raise FileFormatError(mesh.texture, None, "expected a PNG, JPEG or WebP picture with 8 bits a channel")
    if picture.ndim == 2:
        picture = cv2.cvtColor(picture, cv2.COLOR_GRAY2BGR)
    to_rgba = cv2.COLOR_BGRA2RGBA if picture.shape[2] == 4 else cv2.COLOR_BGR2RGBA
    rgba = np.ascontiguousarray(cv2.cvtColor(picture, to_rgba)[::-1])
    atlas = ctx.texture((rgba.shape[1], rgba.shape[0]), 4, rgba.tobytes())
    atlas.build_mipmaps()
    atlas.filter = (moderngl.LINEAR_MIPMAP_NEAREST, moderngl.LINEAR)
    return atlas
