from collections.abc import Callable

import pytest

from conf.animator.gui.panels.deformer import draw_deformer, draw_muscles
from conf.face.deformation.face_model import DeformerOptions
from tests.animator.conftest import PanelDriver

pytestmark = pytest.mark.slow


def test_widgets_change_the_deformer_options(open_panel: Callable[..., PanelDriver]) -> None:
    panel = open_panel(draw_deformer)
    assert panel.state.deformer == DeformerOptions(), "drawing changes nothing"
    panel.press("thin-plate")
    panel.press("separate lips and eyelids")
    assert (panel.state.deformer.kernel, panel.state.deformer.use_regions) == ("thin-plate", False)
    panel.press("##locality, 1/cm")
    assert panel.state.deformer.epsilon is not None
    panel.press("Reset to defaults")
    assert panel.state.deformer == DeformerOptions()
    panel.press("Waters' muscles")
    assert panel.state.muscles.active


def test_a_slider_contracts_both_sides(open_panel: Callable[..., PanelDriver]) -> None:
    panel = open_panel(draw_muscles)
    panel.press("##corrugator")
    assert panel.state.muscles.active
    contractions = panel.state.muscles.contractions
    assert contractions["corrugator_l"] == pytest.approx(0.25, abs=0.03)
    assert contractions["corrugator_r"] == contractions["corrugator_l"]
    panel.press("relaxed")
    assert not panel.state.muscles.contractions
