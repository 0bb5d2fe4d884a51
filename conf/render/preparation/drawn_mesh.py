"""The mesh as it is drawn, from the user's cache: transparent parts apart, outside out, sorted for the vertex cache."""

from dataclasses import fields, replace

from conf.disk_cache import cache_key, cached, file_state, source_state
from conf.face.mesh.mesh import Mesh
from conf.render.textures import MeshImages

_MAX_TRIANGLES = 100_000  # of a mesh that is cached: 10 MB


def drawn_mesh(mesh: Mesh, images: MeshImages, /) -> Mesh:
    """Return a mesh with its triangles and render vertices in the order of drawing; the vertices keep theirs.

    images : of the mesh
    Raises FileFormatError if a file is not an image.
    """

    def prepare() -> Mesh:
        from conf.face.mesh.winding import orient_outwards
        from conf.render.preparation.transparency import separate_transparent
        from conf.render.preparation.vertex_cache import optimise_vertex_cache

        prepared = optimise_vertex_cache(orient_outwards(separate_transparent(mesh, images)))
        return replace(prepared, materials=(), texture=None)  # images may be large

    if len(mesh.triangles) > _MAX_TRIANGLES:
        prepared = prepare()
    else:
        prepared = cached("meshes", _key(mesh, images), prepare, Mesh)
    return replace(prepared, materials=mesh.materials, texture=mesh.texture)


def _key(mesh: Mesh, images: MeshImages) -> str:
    """Return what changes with all that the order of drawing depends on."""
    arrays = (mesh.vertices, mesh.triangles, mesh.uvs, mesh.render_vertices, mesh.render_triangles)
    groups = [part for name, triangles in mesh.groups.items() for part in (name, triangles)]
    materials = [images.material(number) for number in images.numbers]
    parts = [file_state(getattr(material, field.name)) for material in materials for field in fields(material)]
    code = source_state("face"), source_state("render")
    return cache_key(code, *arrays, *groups, mesh.triangle_materials, mesh.vertex_colours, *parts)
