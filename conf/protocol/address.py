"""The network address of a peer, as the socket calls give it."""

# (host, port) for IPv4; (host, port, flow info, scope id) for IPv6.
Address = tuple[str, int] | tuple[str, int, int, int]
