from collections.abc import Callable

from conf.animator.gui.panels.deformer import draw_deformer
from conf.face.deformation.face_model import DeformerOptions
from tests.animator.conftest import PanelDriver


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
