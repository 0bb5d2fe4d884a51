"""Dear ImGui's renderer backend on moderngl, the same for a window on a display and in memory.

Strategy: ImGui's own OpenGL backends load OpenGL from the window system, which an EGL context without a display does
not have, or need PyOpenGL. A backend has little to do: keep the font texture up to date and draw lists of triangles,
each clipped to a rectangle. Source: imgui_impl_opengl3.cpp of Dear ImGui 1.92 and later (RendererHasTextures).
"""

import ctypes

import moderngl
import numpy as np
from imgui_bundle import imgui

from conf.render.gpu_object import GpuObject
from conf.render.shader_programs import load_program


class ImGuiRenderer(GpuObject):
    """Owner of the textures and buffers of one ImGui context."""

    def __init__(self, ctx: moderngl.Context) -> None:
        self._ctx = ctx
        self._program = load_program(ctx, "imgui", "imgui")
        self._program["glyphs"] = 0
        self._vertices = ctx.buffer(reserve=1 << 16, dynamic=True)
        self._indices = ctx.buffer(reserve=1 << 16, dynamic=True)
        layout = [(self._vertices, "2f4 2f4 4f1", "in_position", "in_uv", "in_colour")]
        self._array = ctx.vertex_array(self._program, layout, self._indices, index_element_size=imgui.INDEX_SIZE)
        self._textures: dict[int, moderngl.Texture] = {}
        self._owned = (self._array, self._vertices, self._indices, self._program)
        imgui.get_io().backend_flags |= imgui.BackendFlags_.renderer_has_textures

    def draw(self, data: imgui.ImDrawData, framebuffer: moderngl.Framebuffer, size: tuple[int, int]) -> None:
        """Draw over the framebuffer's content; size is its width and height in pixels."""
        for texture in imgui.get_platform_io().textures:
            self._update(texture)
        framebuffer.use()
        self._ctx.enable_only(moderngl.BLEND)
        self._ctx.blend_func = moderngl.SRC_ALPHA, moderngl.ONE_MINUS_SRC_ALPHA
        self._program["size"] = size
        for commands in data.cmd_lists:
            _upload(self._vertices, commands.vtx_buffer, imgui.VERTEX_SIZE)
            _upload(self._indices, commands.idx_buffer, imgui.INDEX_SIZE)
            for command in commands.cmd_buffer:
                left, top, right, bottom = (int(edge) for edge in command.clip_rect)
                if right <= left or bottom <= top:
                    continue
                self._ctx.scissor = (left, size[1] - bottom, right - left, bottom - top)
                self._textures[command.tex_ref.get_tex_id()].use(0)
                self._array.render(moderngl.TRIANGLES, vertices=command.elem_count, first=command.idx_offset)
        self._ctx.scissor = None

    def show_texture(self, texture: moderngl.Texture) -> imgui.ImTextureRef:
        """Return a reference for ImGui's images to a texture that the caller owns."""
        self._textures[texture.glo] = texture
        return imgui.ImTextureRef(texture.glo)

    def release(self) -> None:
        """Free everything on the graphics card and mark ImGui's textures as destroyed."""
        for texture in imgui.get_platform_io().textures:
            if texture.tex_id in self._textures:
                self._destroy(texture)
        imgui.get_io().backend_flags &= ~imgui.BackendFlags_.renderer_has_textures
        super().release()

    def _update(self, texture: imgui.ImTextureData) -> None:
        match texture.status:
            case imgui.ImTextureStatus.want_create:
                created = self._ctx.texture((texture.width, texture.height), 4, _pixels(texture).tobytes())
                self._textures[created.glo] = created
                texture.set_tex_id(created.glo)
                texture.status = imgui.ImTextureStatus.ok
            case imgui.ImTextureStatus.want_updates:
                area = texture.update_rect
                pixels = _pixels(texture)[area.y : area.y + area.h, area.x : area.x + area.w]
                viewport = (area.x, area.y, area.w, area.h)
                self._textures[texture.tex_id].write(np.ascontiguousarray(pixels).tobytes(), viewport=viewport)
                texture.status = imgui.ImTextureStatus.ok
            case imgui.ImTextureStatus.want_destroy if texture.unused_frames > 0:
                self._destroy(texture)

    def _destroy(self, texture: imgui.ImTextureData) -> None:
        self._textures.pop(texture.tex_id).release()
        texture.set_tex_id(0)
        texture.status = imgui.ImTextureStatus.destroyed


def _pixels(texture: imgui.ImTextureData) -> "np.ndarray[tuple[int, int, int], np.dtype[np.uint8]]":
    return np.asarray(texture.get_pixels_array(), np.uint8).reshape(texture.height, texture.width, 4)


def _upload(buffer: moderngl.Buffer, source: "imgui.ImVector_ImDrawVert | imgui.ImVector_ImDrawIdx", item: int) -> None:
    size = source.size() * item
    if size:
        buffer.orphan(max(size, buffer.size))
        buffer.write(ctypes.string_at(source.data_address(), size))
