"""A dropped datagram has a reason that can be counted."""

from conf.errors import ProtocolError
from conf.protocol.session.drop_reasons import DatagramError, DropReason


def test_a_datagram_error_is_a_protocol_error_with_its_reason() -> None:
    error = DatagramError(DropReason.SEAL)
    assert isinstance(error, ProtocolError)
    assert error.reason is DropReason.SEAL
    assert str(error) == "seal"
