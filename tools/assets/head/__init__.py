"""Modules of `tools/assets/build_head.py`; each makes one part of the default head."""
