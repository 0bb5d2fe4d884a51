"""Cameras, microphones and speakers while they are chosen: lists, live picture, level meters, test tone.

Each open device has a thread of its own, as libraries block while they open one.
"""
