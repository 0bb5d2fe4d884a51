"""Writers of images, video, motion and meshes."""
