"""Layout of the window: a column left and right, the timeline below, the face between."""

from dataclasses import dataclass

from conf.render.ui.rectangle import Rect
from conf.render.ui.scaling import ScaleRule

COLUMN_PX = 276.0  # width at scale 1
TIMELINE_PX = 84.0  # height at scale 1
REFERENCE_ASPECT = 1.42  # height over width of the reference face
SCALE = ScaleRule((1280, 800), exponent=0.7, limits=(0.8, 2.0))


@dataclass(frozen=True)
class Layout:
    """Rectangles in window pixels. reference : the reference face, over the left column's lower end."""

    left: Rect
    right: Rect
    timeline: Rect
    face: Rect
    reference: Rect

    @classmethod
    def of(cls, size: tuple[int, int], scale: float) -> "Layout":
        """Divide a window of (W, H) pixels."""
        width, height = size
        column, timeline = min(round(COLUMN_PX * scale), width // 3), round(TIMELINE_PX * scale)
        middle = max(1, width - 2 * column)
        reference = round(column * REFERENCE_ASPECT)
        return cls(
            left=Rect(0, 0, column, height),
            right=Rect(width - column, 0, column, height),
            timeline=Rect(column, height - timeline, middle, timeline),
            face=Rect(column, 0, middle, max(1, height - timeline)),
            reference=Rect(0, height - reference, column, reference),
        )

    def face_viewport(self, window_height: int) -> tuple[int, int, int, int]:
        """Return the face's OpenGL viewport: x, y of the lower left corner, width, height."""
        face = self.face
        return round(face.x), round(window_height - face.y - face.height), round(face.width), round(face.height)
