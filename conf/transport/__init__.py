"""Datagrams in and out: the only package that opens sockets."""
