"""The receiver: the receiving loop, one image of all participants, the viewer's controls, call statistics."""
