import pytest

from conf.errors import ConfError, FileFormatError


@pytest.mark.parametrize(
    ("line", "message"), [(3, "face.ppc, line 3: expected 50 points"), (None, "face.ppc: expected 50 points")]
)
def test_a_file_format_error_names_file_line_and_expectation(line: int | None, message: str) -> None:
    error = FileFormatError("face.ppc", line, "expected 50 points")
    assert str(error) == message and isinstance(error, ConfError)
