"""Send and receive datagrams: the only package that opens sockets, but for the ports of a relay."""
