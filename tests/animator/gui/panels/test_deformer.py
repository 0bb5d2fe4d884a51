from collections.abc import Callable

from conf.animator.gui.panels.deformer import draw_deformer
from conf.face.deformation.face_model import DeformerOptions
from tests.animator.conftest import Worked


def test_kernel_regions_and_defaults(work: Callable[..., Worked]) -> None:
    panel = work(draw_deformer)
    assert panel.desk.deformer == DeformerOptions(), "drawing changes nothing"
    panel.press("thin-plate")
    panel.press("lips and lids apart")
    assert (panel.desk.deformer.kernel, panel.desk.deformer.use_regions) == ("thin-plate", False)
    panel.press("##locality, 1/cm")
    assert panel.desk.deformer.epsilon is not None
    panel.press("Back to the defaults")
    assert panel.desk.deformer == DeformerOptions()
    panel.press("Waters' muscles")
    assert panel.desk.muscling.active
