"""Images of a mesh's materials, and their textures."""

from concurrent.futures import Future, ThreadPoolExecutor
from pathlib import Path

import cv2
import moderngl
import numpy as np
from numpy.typing import NDArray

from conf.errors import FileFormatError
from conf.face.formats.mtl import MeshMaterial
from conf.face.mesh.mesh import Mesh
from conf.render.gpu_object import GpuObject

PLAIN_SKIN = (226, 178, 150, 255)  # sRGB with alpha, of a mesh without a texture
_WHITE = (255, 255, 255, 255)
MAX_THREADS = 2  # that read images; decoders leave the interpreter to the others
_MAX_SIZE = 8192  # pixels a side; every OpenGL 3.3 driver of today takes it

Pixels = NDArray[np.uint8]


class MeshImages:
    """The images of one mesh, each read once: (h, w, 4) uint8 RGBA, the bottom row first."""

    def __init__(self, mesh: Mesh) -> None:
        """Raises FileFormatError if a file is not an image."""
        self._mesh = mesh
        self._reading: dict[object, Future[Pixels]] = {}
        self._threads = ThreadPoolExecutor(MAX_THREADS)
        self.numbers = np.unique(mesh.materials_of_triangles()).tolist()
        # A file in which everything is invisible does not mean it.
        self.ignores_alpha = all(self.material(number).alpha == 0.0 for number in self.numbers)

    def read_ahead(self) -> None:
        """Begin to read all images: decoding one of 2048 x 2048 pixels takes a tenth of a second."""
        for number in self.numbers:
            if self.material(number).image is not None:
                self._read(number)

    def pixels(self, number: int) -> Pixels | None:
        """Return the image of a material, that of the mesh for -1; None if it has none."""
        if self.material(number).image is None:
            return None
        return self._read(number).result()

    def _read(self, number: int) -> Future[Pixels]:
        key = self.key(number)
        if key not in self._reading:
            self._reading[key] = self._threads.submit(read_image, self.material(number))
        return self._reading[key]

    def material(self, number: int) -> MeshMaterial:
        """Return a material; for -1 the mesh's texture as a material."""
        if number >= 0:
            return self._mesh.materials[number]
        return MeshMaterial(image=self._mesh.texture if len(self._mesh.uvs) else None)

    def tint(self, number: int) -> tuple[float, float, float, float] | None:
        """Return the linear colour and alpha of a material; None if it and the vertex colours change nothing."""
        material = self.material(number)
        if self._mesh.vertex_colours is None and material.colour == (1.0, 1.0, 1.0) and material.alpha == 1.0:
            return None
        red, green, blue = linear_from_srgb(np.array(material.colour)).tolist()
        return red, green, blue, 1.0 if self.ignores_alpha else material.alpha

    def key(self, number: int) -> object:
        """Return what is equal for materials with the same image."""
        material = self.material(number)
        image = material.image if isinstance(material.image, Path) else id(material.image)
        return image, material.alpha_image, material.image is None and number < 0


class MeshTextures(GpuObject):
    """The images of one mesh on the graphics card."""

    def __init__(self, ctx: moderngl.Context, images: MeshImages) -> None:
        textures: dict[object, moderngl.Texture] = {}
        for number in images.numbers:
            if images.key(number) not in textures:
                textures[images.key(number)] = _upload(ctx, images.pixels(number), is_default=number < 0)
        self._textures = {number: textures[images.key(number)] for number in images.numbers}
        self._owned = tuple(textures.values())

    def use(self, number: int, location: int) -> None:
        """Bind the texture of a material, -1 for triangles without one."""
        self._textures[number].use(location)


def _upload(ctx: moderngl.Context, pixels: Pixels | None, *, is_default: bool) -> moderngl.Texture:
    """Return a texture with mipmaps, or one pixel of white or PLAIN_SKIN if there is no image."""
    if pixels is None:
        return ctx.texture((1, 1), 4, bytes(PLAIN_SKIN if is_default else _WHITE))
    if max(pixels.shape[:2]) > _MAX_SIZE:
        scale = _MAX_SIZE / max(pixels.shape[:2])
        size = max(int(pixels.shape[1] * scale), 1), max(int(pixels.shape[0] * scale), 1)
        pixels = np.asarray(cv2.resize(pixels, size, interpolation=cv2.INTER_AREA), np.uint8)
    texture = ctx.texture((pixels.shape[1], pixels.shape[0]), 4, np.ascontiguousarray(pixels).tobytes())
    texture.build_mipmaps()
    texture.filter = (moderngl.LINEAR_MIPMAP_NEAREST, moderngl.LINEAR)
    return texture


def linear_from_srgb(values: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return linear values, 0 to 1, of sRGB ones. Source: IEC 61966-2-1."""
    return np.asarray(np.where(values <= 0.04045, values / 12.92, ((values + 0.055) / 1.055) ** 2.4))


def read_image(material: MeshMaterial) -> Pixels:
    """Return the image of a material with its alpha, (h, w, 4) RGBA, the bottom row first.

    Raises FileFormatError if a file is not an image.
    """
    if not isinstance(material.image, Path):
        return np.ascontiguousarray(np.asarray(material.image)[::-1])
    image = read_image_file(material.image)
    to_rgba = cv2.COLOR_BGRA2RGBA if image.shape[2] == 4 else cv2.COLOR_BGR2RGBA
    rgba = np.asarray(cv2.cvtColor(image, to_rgba), np.uint8)
    if material.alpha_image not in (None, material.image):
        assert material.alpha_image is not None
        mask = read_image_file(material.alpha_image)
        alpha = mask[..., 3] if mask.shape[2] == 4 else cv2.cvtColor(mask, cv2.COLOR_BGR2GRAY)
        rgba[..., 3] = cv2.resize(alpha, (rgba.shape[1], rgba.shape[0]), interpolation=cv2.INTER_LINEAR)
    return np.ascontiguousarray(rgba[::-1])


def read_image_file(path: Path) -> Pixels:
    """Return (h, w, 3 or 4) BGR with 8 bits a channel. Raises FileFormatError.

    The file is read here, because names that are not UTF-8 end the process in OpenCV.
    """
    try:
        data = np.frombuffer(path.read_bytes(), np.uint8)
        image = cv2.imdecode(data, cv2.IMREAD_UNCHANGED)
    except (OSError, cv2.error):
        image = None
    if image is None or image.dtype not in (np.uint8, np.uint16):
        raise FileFormatError(path, None, "expected a PNG, JPEG or WebP image with 8 bits a channel")
    if image.dtype == np.uint16:
        image = (image // 257).astype(np.uint8)
    if image.ndim == 2 or image.shape[2] == 1:
        image = cv2.cvtColor(image, cv2.COLOR_GRAY2BGR)
    elif image.shape[2] == 2:  # grey with alpha
        image = cv2.merge([image[..., 0], image[..., 0], image[..., 0], image[..., 1]])
    return np.asarray(image, np.uint8)
