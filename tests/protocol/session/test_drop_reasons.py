"""Reasons are countable and cheap."""

from conf.errors import ProtocolError
from conf.protocol.session.drop_reasons import DatagramError, Reason


def test_a_datagram_error_is_a_protocol_error_with_its_reason() -> None:
    error = DatagramError(Reason.SEAL)
    assert isinstance(error, ProtocolError)
    assert error.reason is Reason.SEAL
    assert str(error) == "seal"
