"""Layout of the start window: a header, two columns of controls, a footer."""

from dataclasses import dataclass

from conf.render.ui.rectangle import Rect
from conf.render.ui.scaling import ScaleRule

MIN_SIZE = (800, 600)  # points; the window of scale 1
HEADER_PX = 40.0  # heights at scale 1
FOOTER_PX = 40.0
SCALE = ScaleRule(MIN_SIZE, exponent=0.6, limits=(1.0, 1.8))


@dataclass(frozen=True)
class Layout:
    """Rectangles in window pixels. page : between header and footer"""

    window: Rect
    header: Rect
    left: Rect
    right: Rect
    page: Rect
    footer: Rect

    @classmethod
    def of(cls, size: tuple[int, int], scale: float) -> "Layout":
        """Divide a window of (W, H) pixels."""
        width, height = size
        header, footer = round(HEADER_PX * scale), round(FOOTER_PX * scale)
        middle, half = max(1, height - header - footer), width // 2
        return cls(
            window=Rect(0, 0, width, height),
            header=Rect(0, 0, width, header),
            left=Rect(0, header, half, middle),
            right=Rect(half, header, width - half, middle),
            page=Rect(0, header, width, middle),
            footer=Rect(0, height - footer, width, footer),
        )
