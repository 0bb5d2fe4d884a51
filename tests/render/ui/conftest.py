"""The ImGui stage for the tests of this folder."""

from tests.support.imgui_stage import stage

__all__ = ["stage"]
