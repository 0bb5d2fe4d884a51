"""Files that the program writes: images, video, motion, meshes."""
