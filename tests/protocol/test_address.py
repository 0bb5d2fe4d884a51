import pytest

from conf.protocol.address import Address, format_address


@pytest.mark.parametrize(
    ("address", "text"),
    [
        (("127.0.0.1", 5005), "127.0.0.1:5005"),
        (("::", 6001, 0, 0), "[::]:6001"),
        (("fe80::1%eth0", 1, 0, 2), "[fe80::1%eth0]:1"),
        (("", 5005), "0.0.0.0:5005"),
    ],
)
def test_addresses_are_written_as_they_are_typed(address: Address, text: str) -> None:
    assert format_address(address) == text
