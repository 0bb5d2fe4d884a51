"""What is done with a mesh once, before it is drawn frame after frame. It needs SciPy, so its result is cached."""
