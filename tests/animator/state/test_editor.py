from pathlib import Path

from conf.animator.file_export import check_output, parse_fps, parse_size
from conf.animator.state.editor import CURRENT_VIEW, EditorState


def test_the_default_fields_can_be_exported() -> None:
    fields = EditorState().fields
    check_output(Path(fields.output))
    assert parse_size(fields.size) == (1280, 720) and parse_fps(fields.fps) == 30.0 and fields.source == CURRENT_VIEW
