"""Send and receive datagrams: the only package that opens sockets."""
