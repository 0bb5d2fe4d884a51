"""A picture to draw panels on."""

from tests.support.imgui_stage import stage

__all__ = ["stage"]
