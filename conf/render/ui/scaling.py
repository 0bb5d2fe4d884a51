"""The scale of text and controls: it grows more slowly than the window."""

from dataclasses import dataclass


@dataclass(frozen=True)
class ScaleRule:
    """How the scale of an interface follows its window.

    design_size : width and height in points of the window of scale 1; exponent : of the window's size, 0 to 1
    limits : of the scale on a display of one pixel per point
    """

    design_size: tuple[int, int]
    exponent: float
    limits: tuple[float, float]

    def scale(self, size: tuple[int, int], pixel_ratio: float) -> float:
        """Return the scale in a window.

        size : width and height in pixels; pixel_ratio : pixels per point of the display, 2 on a HiDPI display
        """
        low, high = self.limits
        ratio = min(size[0] / self.design_size[0], size[1] / self.design_size[1]) / pixel_ratio
        return float(min(max(ratio**self.exponent, low), high) * pixel_ratio)
