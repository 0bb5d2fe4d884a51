"""The pieces of `tools/assets/build_head.py`: each module makes one part of the default head."""
