"""Every control of the start window has a tooltip, and every tooltip a control."""

import ast
from pathlib import Path

import conf.start.gui
from conf.start.gui.tooltips import TOOLTIPS, tooltip_of

FOLDER = Path(conf.start.gui.__file__).parent


def control_labels() -> set[str]:
    """Return the texts of all controls in the source, and what other texts a tooltip may be named by."""
    labels = set()
    for path in FOLDER.glob("*.py"):
        if path.name == "tooltips.py":
            continue
        for node in ast.walk(ast.parse(path.read_text())):
            if isinstance(node, ast.Constant) and isinstance(node.value, str):
                labels.add(node.value)
    return labels


def test_every_tooltip_has_a_control() -> None:
    assert set(TOOLTIPS) <= control_labels()


def test_a_tooltip_is_found_by_what_is_before_or_after_the_number_signs() -> None:
    assert tooltip_of("Call") == tooltip_of("Call##2") == TOOLTIPS["Call"]
    assert tooltip_of("##address") == TOOLTIPS["address"]
    assert tooltip_of("nothing") == ""
