import pytest

from conf.errors import ConfError, FileFormatError, explain


@pytest.mark.parametrize(
    ("line", "message"), [(3, "face.ppc, line 3: expected 50 points"), (None, "face.ppc: expected 50 points")]
)
def test_a_file_format_error_names_file_line_and_expectation(line: int | None, message: str) -> None:
    error = FileFormatError("face.ppc", line, "expected 50 points")
    assert str(error) == message and isinstance(error, ConfError)


def test_an_explanation_is_the_message_with_its_notes() -> None:
    error = ConfError("the disk is full")
    assert explain(error) == "the disk is full"
    error.add_note("a.mp4 is as it was before")
    assert explain(error) == "the disk is full; a.mp4 is as it was before"
