"""The pieces of `tools/build_head.py`: each module makes one part of the default head."""
