"""Voice codecs, one module each, behind the interface of `interface`, chosen by name in `registry`."""
