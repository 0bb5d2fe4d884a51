"""Draw the figures of the thesis on the default head: `python tools/docs/figures.py [--output docs/figures]`.

- smile.jpg, open_mouth.jpg: one expression by radial basis functions and by Waters' muscles (figures 4.5, 4.6, 4.11)
- square_mesh.png: a flat mesh contracted with angles of pi/2 and pi/6 (figure 4.10)
- emotions.jpg: the six emotions of table 3.3
- action_units.jpg: the action units of table 3.2
"""

import argparse
import os
import sys
from collections.abc import Sequence
from pathlib import Path

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

import cv2
import numpy as np
from numpy.typing import NDArray

from conf.face.animation.action_units import action_unit_label as unit_label
from conf.face.animation.action_units import load_action_units, load_emotions
from conf.face.control_points import CONTROL_POINT_COUNT, CONTROL_POINT_INDEX
from conf.face.deformation.face_model import FaceModel
from conf.face.deformation.facial_muscles import MuscleDeformer
from conf.face.deformation.waters_muscles import LinearMuscle
from conf.face.head_pose import HeadPose
from conf.face.loading import build_face, load_face
from conf.render.camera import ViewState
from conf.render.face_renderer import FaceRenderer
from conf.render.window.offscreen import OffscreenWindow

Image = NDArray[np.uint8]

POSE = HeadPose(np.zeros(3), np.array([0.0, -0.03]), float(np.log(0.036)))
CLOSE = ViewState(zoom=1.7, pan=(0.0, 0.22))
TILE = (400, 440)
SUPERSAMPLING = 2
QUALITY = {".jpg": [cv2.IMWRITE_JPEG_QUALITY, 90], ".png": [cv2.IMWRITE_PNG_COMPRESSION, 9]}
INK, PAPER, RED = (40, 40, 40), (255, 255, 255), (40, 40, 200)

# Displacements of control points in mm, as in figures 4.5 and 4.6.
SMILE_MM = {"lip_corner": (6.0, 9.0, -4.0)}
OPEN_MM = {
    "chin": (0.0, -17.0, -7.0), "lip_lower_mid": (0.0, -17.0, -6.0), "lip_lower_l": (-0.5, -13.0, -5.0),
    "lip_lower_r": (-0.5, -13.0, -5.0), "lip_corner": (-2.0, -4.0, -2.0), "lip_upper": (0.0, 1.5, 0.0),
}  # fmt: skip
SMILE_MUSCLES = {"zygomatic_major": 0.25}
OPEN_MUSCLES, OPEN_JAW = {"depressor_labii": 0.12, "levator_labii": 0.03}, 0.18  # contractions, radians


def main() -> None:
    """Write every figure and print its path."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    default = Path(__file__).resolve().parents[2] / "docs" / "figures"
    parser.add_argument("--output", type=Path, default=default, help="folder of the images")
    folder: Path = parser.parse_args().output
    folder.mkdir(parents=True, exist_ok=True)
    camera = FigureCamera(load_face())
    figures = {
        "smile.jpg": smile(camera),
        "open_mouth.jpg": open_mouth(camera),
        "emotions.jpg": emotions(camera),
        "action_units.jpg": action_units(camera),
        "square_mesh.png": square_mesh(),
    }
    camera.release()
    for name, image in figures.items():
        cv2.imwrite(str(folder / name), image, QUALITY[Path(name).suffix])
        print(f"{folder / name}  {image.shape[1]} x {image.shape[0]}")


class FigureCamera:
    """Draws images of one face."""

    def __init__(self, face: FaceModel) -> None:
        self.face = face
        # The model without the correction that is trained on the sculpted blendshapes.
        self.untrained = build_face(face.mesh, face.control_points, rig=face.rig)
        self.muscles = MuscleDeformer(face)
        self._window = OffscreenWindow(TILE[0] * SUPERSAMPLING, TILE[1] * SUPERSAMPLING)
        self._renderer = FaceRenderer(self._window.ctx, face)

    def draw(self, vertices: NDArray[np.float32], text: str, view: ViewState) -> Image:
        """Return an image of the (V, 3) vertices with a line of text."""
        self._window.begin()
        self._renderer.draw(vertices, POSE, view, self._window.framebuffer)
        self._window.end()
        image = cv2.resize(self._window.read(), TILE, interpolation=cv2.INTER_AREA)
        return write(np.asarray(image, np.uint8), text)

    def release(self) -> None:
        """Release the OpenGL objects."""
        self._renderer.release()
        self._window.release()


def smile(camera: FigureCamera) -> Image:
    """Return neutral, RBF and Waters: the corners of the mouth raised."""
    corners = move_points(camera.untrained, SMILE_MM)
    pulled = camera.muscles.deform(both_sides(SMILE_MUSCLES))
    return comparison(camera, corners, pulled)


def open_mouth(camera: FigureCamera) -> Image:
    """Return neutral, RBF and Waters: an open mouth."""
    opened = camera.muscles.deform(both_sides(OPEN_MUSCLES), jaw=OPEN_JAW)
    return comparison(camera, move_points(camera.untrained, OPEN_MM), opened)


def comparison(camera: FigureCamera, points: NDArray[np.float32], muscles: NDArray[np.float32]) -> Image:
    """Return two rows, skin and wireframe, of neutral, RBF and Waters."""
    columns = {"neutral": camera.face.neutral, "radial basis functions": points, "Waters' muscles": muscles}
    rows = (CLOSE, CLOSE.toggled("wireframe"))
    return np.vstack([np.hstack([camera.draw(v, text, view) for text, v in columns.items()]) for view in rows])


def emotions(camera: FigureCamera) -> Image:
    """Return the six emotions, three in a row."""
    loaded = load_emotions()
    return sheet([camera.draw(camera.face.deform(loaded[name]), name, ViewState()) for name in loaded.names], columns=3)


def action_units(camera: FigureCamera) -> Image:
    """Return the action units, four in a row, at half size."""
    tiles = [
        camera.draw(camera.face.deform(displacements), unit_label(unit), ViewState())
        for unit, displacements in load_action_units().items()
    ]
    image = sheet(tiles, columns=4)
    return np.asarray(cv2.resize(image, None, fx=0.75, fy=0.75, interpolation=cv2.INTER_AREA), np.uint8)


def move_points(face: FaceModel, shifts: dict[str, tuple[float, float, float]]) -> NDArray[np.float32]:
    """Return the (V, 3) vertices with control points moved by shifts in mm, x positive away from the middle."""
    displacements = np.zeros((CONTROL_POINT_COUNT, 3))
    for part, shift in shifts.items():
        for name in (name for name in CONTROL_POINT_INDEX if part in name):
            outwards = {"l": 1, "r": -1}.get(name[-1], 0)
            displacements[CONTROL_POINT_INDEX[name]] = np.array(shift) / 10 * [outwards, 1, 1]
    return face.deform(displacements / face.fapu.lengths())


def both_sides(contractions: dict[str, float]) -> dict[str, float]:
    """Return the contractions of the muscles of both sides."""
    return {f"{name}_{side}": strength for name, strength in contractions.items() for side in "lr"}


def square_mesh(size: int = 440, lines: int = 25) -> Image:
    """Return a flat square mesh at rest and contracted by a muscle of two angles, origin A and insertion I marked."""
    grid = np.stack(np.meshgrid(np.linspace(-1, 1, lines), np.linspace(-1, 1, lines)), axis=-1)
    flat = np.concatenate([grid, np.zeros((lines, lines, 1))], axis=-1)
    root, insertion = np.array([0.0, 0.75, 0.0]), np.array([0.0, -0.15, 0.0])
    tiles = [draw_grid(flat, (root, insertion), size, "at rest")]
    for text, angle in (("angle pi/2", np.pi / 2), ("angle pi/6", np.pi / 6)):
        muscle = LinearMuscle(root, insertion, angle, start=0.7, end=1.5)
        offsets = muscle.offsets(flat.reshape(-1, 3)).reshape(flat.shape)
        tiles.append(draw_grid(flat + 0.45 * offsets, (root, insertion), size, text))
    return np.hstack(tiles)


def draw_grid(
    vertices: NDArray[np.float64], ends: tuple[NDArray[np.float64], NDArray[np.float64]], size: int, text: str
) -> Image:
    """Return a drawing of a (rows, columns, 3) mesh and of its muscle from A to I."""
    image = np.full((size, size, 3), PAPER, np.uint8)
    for line in (*vertices, *vertices.swapaxes(0, 1)):
        cv2.polylines(image, [_pixels(line, size)], False, INK, 1, cv2.LINE_AA, 4)
    for name, end in zip("AI", ends, strict=True):
        (centre,) = _pixels(end[None], size)
        cv2.circle(image, tuple(map(int, centre)), 5 << 4, RED, -1, cv2.LINE_AA, 4)
        cv2.putText(image, name, (int(centre[0]) // 16 + 8, int(centre[1]) // 16 + 5), 0, 0.55, RED, 2, cv2.LINE_AA)
    return write(image, text, colour=INK)


def sheet(tiles: Sequence[Image], *, columns: int) -> Image:
    """Return images of equal size in rows."""
    rows = [np.hstack(tiles[i : i + columns]) for i in range(0, len(tiles), columns)]
    return np.vstack(rows)


def write(image: Image, text: str, *, colour: tuple[int, int, int] = PAPER) -> Image:
    """Return the image with a line of text at its upper left."""
    labelled = image.copy()
    cv2.putText(labelled, text, (10, 24), cv2.FONT_HERSHEY_SIMPLEX, 0.6, colour, 1, cv2.LINE_AA)
    return labelled


def _pixels(points: NDArray[np.float64], size: int) -> NDArray[np.int32]:
    """Return (n, 2) positions in 1/16 px of points between -1 and 1, with a margin."""
    scaled = points[:, :2] * [0.44, -0.44] + [0.5, 0.52]
    return np.rint(scaled * size * 16).astype(np.int32)


if __name__ == "__main__":
    main()
