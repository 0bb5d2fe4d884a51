"""Where everything stands in the animator's window: a column left and right, the time line below, the face between."""

from dataclasses import dataclass

from conf.animator.picking import Rect

COLUMN = 276.0  # at scale 1, in a window of 1280 x 800
TIMELINE = 84.0
REFERENCE = 1.42  # height of the reference face over its width
SCALE_LIMITS = (0.8, 2.0)
DESIGNED_FOR = (1280, 800)


def scale_of(size: tuple[int, int], pixel_ratio: float) -> float:
    """Return how much larger than at 1280 x 800 panels and text are. size : pixels"""
    low, high = SCALE_LIMITS
    fit = min(size[0] / DESIGNED_FOR[0], size[1] / DESIGNED_FOR[1]) / pixel_ratio
    return float(min(max(fit**0.7, low), high) * pixel_ratio)


@dataclass(frozen=True)
class Layout:
    """Rectangles in pixels of the window."""

    left: Rect
    right: Rect
    timeline: Rect
    face: Rect
    reference: Rect

    @classmethod
    def of(cls, size: tuple[int, int], scale: float) -> "Layout":
        """Divide a window of (W, H) pixels."""
        width, height = size
        column, below = round(COLUMN * scale), round(TIMELINE * scale)
        column = min(column, width // 3)
        middle = max(1, width - 2 * column)
        tall = round(column * REFERENCE)
        return cls(
            left=Rect(0, 0, column, height),
            right=Rect(width - column, 0, column, height),
            timeline=Rect(column, height - below, middle, below),
            face=Rect(column, 0, middle, max(1, height - below)),
            reference=Rect(0, height - tall, column, tall),
        )

    def face_viewport(self, height: int) -> tuple[int, int, int, int]:
        """Return the face's rectangle as OpenGL has it: x, y of the lower left corner, width, height."""
        face = self.face
        return round(face.x), round(height - face.y - face.height), round(face.width), round(face.height)
