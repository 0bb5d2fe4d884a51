"""Draw a face: deformed vertices and a head pose in, an image out.

For each frame the neck is bent and the vertex normals are computed, both are uploaded, each group of triangles is
drawn with its material's shaders into a render target, and the target is resolved into the framebuffer.
"""

from dataclasses import dataclass
from itertools import groupby

import moderngl
import numpy as np
from numpy.typing import NDArray

from conf.face.deformation.face_model import FaceModel
from conf.face.deformation.lip_opening import INNER_LIPS, LipOpening
from conf.face.deformation.neck import NeckBend
from conf.face.furrows import SMOOTH_SKIN, SkinFurrows
from conf.face.head_pose import HeadPose
from conf.face.mesh.mesh import Mesh
from conf.render.camera import ViewState, clip_matrix, view_rotation
from conf.render.control_point_markers import ControlPointMarkers
from conf.render.drawn_area import covered_bands, longest_edges
from conf.render.gpu_object import GpuObject
from conf.render.lighting import STUDIO, Lighting
from conf.render.materials import EYE, MOUTH, SKIN, Material, group_triangles, material_of
from conf.render.preparation.drawn_mesh import drawn_mesh
from conf.render.preparation.forehead import forehead_positions, on_forehead
from conf.render.render_target import RenderTarget
from conf.render.shader_programs import DrawCall, to_column_major
from conf.render.shadow_map import ShadowMap, light_matrix
from conf.render.textures import MeshImages, MeshTextures
from conf.render.vertex_colour_renderer import VertexColourRenderer
from conf.render.vertex_normals import VertexNormals
from conf.render.wireframe import WireframeRenderer

CLIP_TO_TEXTURE = np.array([[0.5, 0, 0, 0.5], [0, 0.5, 0, 0.5], [0, 0, 0.5, 0.5], [0, 0, 0, 1]])
MAX_TARGETS = 6  # render targets kept, one per size and scale: the cells of a grid of participants differ in size


@dataclass(frozen=True)
class PreparedMesh:
    """What a renderer needs of a mesh and can be made by another thread than that of the graphics card."""

    mesh: Mesh
    images: MeshImages


def prepare_mesh(mesh: Mesh, /) -> PreparedMesh:
    """Order a mesh for drawing and read its textures. Raises FileFormatError if a texture is not an image."""
    prepared = _begin_to_prepare(mesh)
    for number in prepared.images.numbers:
        prepared.images.pixels(number)  # wait until it is read
    return prepared


def _begin_to_prepare(mesh: Mesh) -> PreparedMesh:
    """Order a mesh for drawing while its textures are being read."""
    images = MeshImages(mesh)
    images.read_ahead()
    return PreparedMesh(drawn_mesh(mesh, images), images)


class FaceRenderer(GpuObject):
    """Draws one face frame after frame."""

    def __init__(
        self,
        ctx: moderngl.Context,
        face: FaceModel,
        *,
        lighting: Lighting = STUDIO,
        prepared: PreparedMesh | None = None,
    ) -> None:
        """prepared : of the face's mesh, None to prepare it here"""
        prepared = prepared or _begin_to_prepare(face.mesh)
        mesh, images = prepared.mesh, prepared.images
        self.background = "wall"  # a key of render_target.BACKDROPS or SOLID_COLOURS
        self.scale = 1.0  # of the width and height in which the face is drawn, before it is enlarged to the viewport
        self.target: RenderTarget | None = None  # of the last draw
        self._ctx = ctx
        self._mesh = mesh
        self._lighting = lighting
        self._edges = longest_edges(mesh.vertices, mesh.triangles)
        self._neck = NeckBend(mesh)
        self._normals = VertexNormals(mesh.triangles, mesh.render_vertices)
        self._targets: dict[tuple[tuple[int, int], float, str], RenderTarget] = {}
        self._textures = MeshTextures(ctx, images)
        self._vertices = ctx.buffer(reserve=len(mesh.render_vertices) * 24)
        count = len(mesh.render_vertices)
        uvs = ctx.buffer((mesh.uvs if len(mesh.uvs) == count else np.zeros((count, 2))).astype("f4").tobytes())
        colours = ctx.buffer(vertex_colours(mesh).tobytes())
        positions = forehead_positions(mesh, face.control_points)
        forehead = ctx.buffer(np.ascontiguousarray(positions[:, :2]).tobytes())
        self._parts = [
            MeshPart(
                ctx, group, part, (self._vertices, uvs, colours, forehead), lighting, images.tint(number), number,
                is_furrowed=is_furrowed,
            )
            for group, number, triangles in ordered_parts(mesh)
            for part, is_furrowed in split_forehead(group, mesh.render_triangles[triangles], positions)
        ]  # fmt: skip
        self._face = face
        self._shift: NDArray[np.float32] | None = None
        for part in self._parts:
            part.set_anatomy(face)
        self._wireframe = WireframeRenderer(ctx, mesh, self._vertices)
        self._shadow = ShadowMap(ctx, mesh, self._vertices)
        self._lips = LipOpening(face)
        self._markers = ControlPointMarkers(ctx, face.control_points, mesh.vertices)
        self._vertex_colours: VertexColourRenderer | None = None
        self._is_coloured = False
        self._owned = (
            *(*self._parts, self._wireframe, self._shadow, self._markers),
            *(uvs, colours, forehead, self._vertices, self._textures),
        )

    def draw(
        self,
        vertices: NDArray[np.float32],
        pose: HeadPose,
        view: ViewState,
        framebuffer: moderngl.Framebuffer,
        *,
        participant: int = 0,
        shift: NDArray[np.float32] | None = None,
        furrows: SkinFurrows = SMOOTH_SKIN,
    ) -> None:
        """Draw the face into the framebuffer's viewport.

        vertices : (V, 3) float32, face axes, cm
        participant : number of who is drawn, where several are drawn in turn
        shift : (V, 3) of the neutral face that the vertices are deformed from, from the renderer's face; None for none
        furrows : how deep the skin is folded
        """
        if shift is not self._shift:
            self._shift = shift
            for part in self._parts:
                part.set_anatomy(self._face, shift)
        bent = self._neck.apply(vertices, pose)
        interleaved = self._normals.interleaved(bent)
        points = self._markers.positions(vertices)
        self._vertices.orphan()
        self._vertices.write(interleaved)
        _, _, width, height = framebuffer.viewport
        self.target = target = self._target_of((width, height))
        clip_to_image = clip_matrix(pose, view, aspect=width / height)
        clip = to_column_major(clip_to_image)
        rotation = view_rotation(pose, view)
        matrices = {"clip": clip, "rotation": to_column_major(rotation)}
        if view.wireframe:
            target.begin()
            self._wireframe.draw(**matrices)
        elif self._vertex_colours and self._is_coloured:
            target.begin()
            self._vertex_colours.draw(**matrices)
        else:
            light = self._shadow.update(light_matrix(rotation, self._lighting.key), points, participant=participant)
            target.begin()
            self._shadow.depth.use(1)
            matrices["light"] = to_column_major(CLIP_TO_TEXTURE @ light)
            matrices["opening"] = np.float32(self._lips.measure(vertices)).tobytes()
            matrices["furrows"] = np.array([furrows.between_brows, furrows.forehead], np.float32).tobytes()
            for part in self._parts:
                self._textures.use(part.number, 0)
                part.draw(**matrices)
        target.resolve(framebuffer, covered_bands(bent, clip_to_image, target.size, edges=self._edges))
        if view.points:
            self._markers.draw(points, clip, target.depth)

    def set_colours(self, colours: NDArray[np.float32] | None) -> None:
        """Draw the vertices in these colours, (V, 3) sRGB 0 to 1, from now on; None draws the materials again."""
        self._is_coloured = colours is not None
        if colours is not None:
            if self._vertex_colours is None:
                self._vertex_colours = VertexColourRenderer(self._ctx, self._mesh, self._vertices)
                self._owned = (self._vertex_colours, *self._owned)
            self._vertex_colours.set_colours(colours)

    def release(self) -> None:
        self._release_targets()
        super().release()

    def _target_of(self, size: tuple[int, int]) -> RenderTarget:
        key = (size, self.scale, self.background)
        if key not in self._targets:
            if len(self._targets) >= MAX_TARGETS:  # the window was resized
                self._release_targets()
            scaled = max(1, round(size[0] * self.scale)), max(1, round(size[1] * self.scale))
            self._targets[key] = RenderTarget(self._ctx, scaled, self.background, full_size=size)
        return self._targets[key]

    def _release_targets(self) -> None:
        for target in self._targets.values():
            target.release()
        self._targets.clear()
        self.target = None


class MeshPart(DrawCall):
    """One group of triangles with the shaders of its material."""

    def __init__(
        self,
        ctx: moderngl.Context,
        group: str,
        triangles: NDArray[np.int32],
        buffers: tuple[moderngl.Buffer, ...],
        lighting: Lighting,
        tint: tuple[float, float, float, float] | None = None,
        number: int = -1,
        *,
        is_furrowed: bool = False,
    ) -> None:
        """Build the part.

        triangles : (F, 3) render vertices
        buffers : (R, 6) positions and normals, (R, 2) texture coordinates, (R, 3) colours, (R, 2) positions on
            the forehead
        tint : linear colour and alpha that multiply those of texture and vertices; None for all ones
        number : index of the mesh's material, -1 for none
        is_furrowed : whether furrows are drawn
        """
        self.group, self.number = group, number
        self.material = material_of(group)
        vertices, uvs, colours, forehead = buffers
        attributes = [(vertices, "3f4 3f4", "in_position", "in_normal"), (uvs, "2f4", "in_uv")]
        attributes += [(colours, "3f4", "in_colour"), (forehead, "2f4", "in_forehead")]
        constants = lighting.constants() if tint is None else lighting.constants() | {"TINTED": "true"}
        if is_furrowed:
            constants = constants | {"FURROWED": "true"}
        shaders = (self.material.vertex_shader, self.material.shader)
        super().__init__(ctx, shaders, attributes, triangles, constants)
        self._ctx = ctx
        for unit, name in enumerate(("atlas", "shadow")):
            if name in self.program:
                self.program[name] = unit
        if tint is not None and "tint" in self.program:
            self.program["tint"] = tint

    def set_anatomy(self, face: FaceModel, shift: NDArray[np.float32] | None = None) -> None:
        """Set the uniforms of eyes and mouth to their position on the neutral face.

        shift : (V, 3) of its vertices, cm
        """
        if self.material is EYE:
            members = face.mesh.group_vertices(self.group)
            ball = face.mesh.vertices[members] + (0.0 if shift is None else shift[members])
            self.program["centre"] = tuple((ball.min(axis=0) + ball.max(axis=0)) / 2)
            self.program["radius"] = np.ptp(ball[:, 1]) / 2
        if self.material is MOUTH:
            teeth = face.mesh.group_vertices("teeth_upper")
            moved = 0.0 if shift is None or not len(teeth) else shift[teeth].mean(axis=0)
            self.program["centre"] = tuple(face.control_points[INNER_LIPS].mean(axis=0) + moved)

    def draw(self, **matrices: bytes) -> None:
        """Draw the group.

        matrices : clip, rotation, light (to texture coordinates of the shadow map), the opening of the lips, cm,
            and the depths of furrows
        """
        self._ctx.enable_only(moderngl.DEPTH_TEST)
        if not self.material.two_sided:
            self._ctx.enable(moderngl.CULL_FACE)
        if self.material.blended:
            self._ctx.enable(moderngl.BLEND)
        super().draw(**matrices)


def ordered_parts(mesh: Mesh) -> list[tuple[str, int, NDArray[np.int64]]]:
    """Return what is drawn at once, in drawing order: a group, the index of its material, and its triangles.

    Skin comes first, as it hides most, blended groups last and in the order of the mesh. Groups that are drawn in
    the same way, one after the other, are one part with the name of the first.
    """
    numbers = mesh.materials_of_triangles()
    found = [
        (material_of(group), number, group, triangles[numbers[triangles] == number])
        for group, triangles in group_triangles(mesh)
        for number in np.unique(numbers[triangles]).tolist()
    ]
    order = list(dict.fromkeys(material for material, *_ in found))

    def rank(part: tuple[Material, int, str, NDArray[np.int64]]) -> tuple[int, ...]:
        material, number, *_ = part
        return (1,) if material.blended else (0, material is not SKIN, order.index(material), number)

    parts = []
    for _, alike in groupby(sorted(found, key=rank), key=lambda part: (*part[:2], part[2] if part[0] is EYE else "")):
        _, numbers_of, names, triangles = zip(*alike, strict=True)
        parts.append((names[0], numbers_of[0], np.concatenate(triangles)))
    return parts


def vertex_colours(mesh: Mesh) -> NDArray[np.float32]:
    """Return (R, 3) float32 sRGB; white for a mesh without vertex colours."""
    if mesh.vertex_colours is None:
        return np.ones((len(mesh.render_vertices), 3), np.float32)
    return np.ascontiguousarray(mesh.vertex_colours[mesh.render_vertices], np.float32)


def split_forehead(
    group: str, triangles: NDArray[np.int32], positions: NDArray[np.float32]
) -> list[tuple[NDArray[np.int32], bool]]:
    """Return the triangles (F, 3) of a part, those that are drawn with furrows apart; and which these are.

    positions : (R, 3) cm from the middle between the brows
    """
    if material_of(group) is not SKIN:
        return [(triangles, False)]
    is_furrowed = on_forehead(positions, triangles)
    return [(part, choice) for choice in (False, True) if len(part := triangles[is_furrowed == choice])]
