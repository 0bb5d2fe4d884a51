import numpy as np

from conf.face.deformation.face_model import FaceModel
from conf.render.shader_programs import to_column_major
from conf.render.vertex_normals import VertexNormals
from conf.render.window.offscreen import OffscreenWindow
from conf.render.wireframe import EDGE_COLOUR, FILL_COLOUR, WireframeRenderer


def test_edges_are_bright_and_the_fill_between_them_is_dark(window: OffscreenWindow, face: FaceModel) -> None:
    rows = VertexNormals(face.mesh.triangles, face.mesh.render_vertices).interleaved(face.neutral)
    vertices = window.ctx.buffer(rows.tobytes())
    wireframe = WireframeRenderer(window.ctx, face.mesh, vertices)
    window.begin()
    clip = np.diag([0.09, 0.12, -0.02, 1.0])
    wireframe.draw(clip=to_column_major(clip), rotation=to_column_major(np.eye(3)))
    wireframe.release()
    middle = window.read()[100:140, 140:180, ::-1] / 255
    bright = (np.abs(middle - EDGE_COLOUR) < 0.12).all(axis=2).mean()
    dark = (np.abs(middle - FILL_COLOUR) < 0.04).all(axis=2).mean()
    assert bright > 0.05 and dark > 0.5 and not window.ctx.wireframe
