"""File formats of meshes (OBJ, PLY, GLB, STL), control points (PPC), motion (DPC) and expressions (EPC)."""
