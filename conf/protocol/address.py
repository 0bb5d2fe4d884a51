"""The network address of a peer, as the socket calls give it."""

# (host, port) for IPv4; (host, port, flow info, scope id) for IPv6.
Address = tuple[str, int] | tuple[str, int, int, int]


def format_address(address: Address, /) -> str:
    """Return an address as a user types it: host:port, or [host]:port for IPv6; no host stands for all addresses."""
    host, port = address[:2]
    return f"[{host}]:{port}" if ":" in host else f"{host or '0.0.0.0'}:{port}"
