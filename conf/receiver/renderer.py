"""Draw a face: deformed vertices and a head pose in, a picture out.

Each frame the normals are computed again from the vertices (surface.py), both are uploaded, each group of triangles is
drawn with its material's shader into a canvas, and the canvas goes over the background with its edges smoothed.
"""

import cv2
import moderngl
import numpy as np
from numpy.typing import NDArray

from conf.errors import FileFormatError
from conf.face.control_points import INDEX
from conf.face.head import FaceModel
from conf.face.head_pose import HeadPose
from conf.face.mesh import Mesh
from conf.receiver.canvas import Canvas
from conf.receiver.marks import ControlPointMarks
from conf.receiver.materials import EYE, MOUTH, SKIN, Material, material_of
from conf.receiver.programs import program
from conf.receiver.scene import View, clip_matrix, rotation
from conf.receiver.shadow import Shadow, lamp_matrix
from conf.receiver.surface import Surface
from conf.receiver.wireframe import Wireframe

HALF = np.array([[0.5, 0, 0, 0.5], [0, 0.5, 0, 0.5], [0, 0, 0.5, 0.5], [0, 0, 0, 1]])  # clip to texture coordinates
PLAIN_SKIN = (226, 178, 150, 255)  # sRGB, of a mesh without a texture


class FaceRenderer:
    """Draws one face again and again."""

    def __init__(self, ctx: moderngl.Context, face: FaceModel) -> None:
        mesh = face.mesh
        self._ctx = ctx
        self._surface = Surface(mesh.triangles, mesh.render_vertices)
        self._canvas: Canvas | None = None
        self._atlas = load_atlas(ctx, mesh)
        self._moving = ctx.buffer(reserve=len(mesh.render_vertices) * 24)
        self._parts = [Part(ctx, face, group, self._moving) for group in ordered_groups(mesh)]
        self._wireframe = Wireframe(ctx, mesh, self._moving)
        self._shadow = Shadow(ctx, mesh, self._moving)
        self._marks = ControlPointMarks(ctx, face.control_points, mesh.vertices)
        self._rows = np.empty((0, 6), np.float32)
        self._places = face.control_points.astype(np.float32)

    def draw(
        self, vertices: NDArray[np.float32], pose: HeadPose, view: View, framebuffer: moderngl.Framebuffer
    ) -> None:
        """Draw the face into the framebuffer's viewport.

        vertices : (V, 3) float32, face axes, cm
        """
        self.prepare(vertices)
        self.upload()
        self.show(pose, view, framebuffer)

    def prepare(self, vertices: NDArray[np.float32]) -> None:
        """First part of `draw`: compute the normals of the (V, 3) vertices."""
        self._rows = self._surface.rows(vertices)
        self._places = self._marks.places(vertices)

    def upload(self) -> None:
        """Second part of `draw`: send positions and normals to the card."""
        self._moving.orphan()
        self._moving.write(self._rows)

    def show(self, pose: HeadPose, view: View, framebuffer: moderngl.Framebuffer) -> None:
        """Third part of `draw`: draw what was uploaded last."""
        x, y, width, height = framebuffer.viewport
        canvas = self._canvas_of((width, height))
        clip = clip_matrix(pose, view, aspect=width / height).T.astype("f4").tobytes()
        turn = rotation(pose, view).T.astype("f4").tobytes()
        if view.wireframe:
            canvas.begin()
            self._wireframe.draw(clip, turn)
        else:
            lamp = lamp_matrix(rotation(pose, view))
            self._shadow.draw(lamp.T.astype("f4").tobytes())
            canvas.begin()
            self._atlas.use(0)
            self._shadow.depth.use(1)
            to_texture = (HALF @ lamp).T.astype("f4").tobytes()
            for part in self._parts:
                part.draw(clip, turn, to_texture)
        canvas.show(framebuffer, (x, y))
        if view.points:
            self._marks.draw(self._places, clip, canvas.depth)

    def release(self) -> None:
        """Free everything on the card."""
        for part in self._parts:
            part.release()
        for thing in (self._wireframe, self._shadow, self._marks, self._canvas, self._moving, self._atlas):
            if thing is not None:
                thing.release()

    def _canvas_of(self, size: tuple[int, int]) -> Canvas:
        if self._canvas is None or self._canvas.size != size:
            if self._canvas is not None:
                self._canvas.release()
            self._canvas = Canvas(self._ctx, size)
        return self._canvas


class Part:
    """One group of triangles with its shader."""

    def __init__(self, ctx: moderngl.Context, face: FaceModel, group: str, moving: moderngl.Buffer) -> None:
        mesh = face.mesh
        self.material = material_of(group)
        self._ctx = ctx
        self._program = program(ctx, "skin" if self.material is SKIN else "face", self.material.shader)
        triangles = mesh.render_triangles[mesh.groups[group]] if group in mesh.groups else mesh.render_triangles
        self._indices = ctx.buffer(np.ascontiguousarray(triangles, dtype=np.int32).tobytes())
        self._uvs = ctx.buffer(texture_coordinates(mesh).tobytes())
        self._array = ctx.vertex_array(
            self._program,
            [(moving, "3f4 3f4", "in_position", "in_normal"), (self._uvs, "2f4", "in_uv")],
            self._indices,
            skip_errors=True,
        )
        for unit, name in enumerate(("atlas", "shadow")):
            if name in self._program:
                self._program[name] = unit
        for name, value in places(face, group, self.material).items():
            self._program[name] = value

    def draw(self, clip: bytes, turn: bytes, lamp: bytes) -> None:
        """Draw the group: the matrices as float32, column after column."""
        self._ctx.enable_only(moderngl.DEPTH_TEST)
        if not self.material.two_sided:
            self._ctx.enable(moderngl.CULL_FACE)
        if self.material.blended:
            self._ctx.enable(moderngl.BLEND)
        self._program["clip"].write(clip)
        self._program["turn"].write(turn)
        if "lamp" in self._program:
            self._program["lamp"].write(lamp)
        self._array.render(moderngl.TRIANGLES)

    def release(self) -> None:
        """Free everything on the card."""
        for thing in (self._array, self._indices, self._uvs, self._program):
            thing.release()


def ordered_groups(mesh: Mesh) -> list[str]:
    """Return the groups in the order they are drawn: skin first, as it hides the most, blended ones last."""
    groups = [name for name, triangles in mesh.groups.items() if len(triangles)] or ["skin"]
    return sorted(groups, key=lambda name: (material_of(name).blended, material_of(name).shader != "skin"))


def places(face: FaceModel, group: str, material: Material) -> dict[str, tuple[float, ...] | float]:
    """Return what a material's shader must know about where its part lies, face axes, cm."""
    mesh = face.mesh
    if material is EYE:
        ball = mesh.vertices[np.unique(mesh.triangles[mesh.groups[group]])]
        centre = (ball.min(axis=0) + ball.max(axis=0)) / 2
        return {"centre": tuple(map(float, centre)), "radius": float(np.ptp(ball[:, 1]) / 2)}
    if material is MOUTH:
        lips = face.control_points[[INDEX["inner_lip_upper_mid"], INDEX["inner_lip_lower_mid"]]]
        return {"centre": tuple(map(float, lips.mean(axis=0)))}
    return {}


def texture_coordinates(mesh: Mesh) -> NDArray[np.float32]:
    """Return (R, 2) float32; zeros for a mesh that has none."""
    if len(mesh.uvs) == len(mesh.render_vertices):
        return np.ascontiguousarray(mesh.uvs, dtype=np.float32)
    return np.zeros((len(mesh.render_vertices), 2), np.float32)


def load_atlas(ctx: moderngl.Context, mesh: Mesh) -> moderngl.Texture:
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
