"""The face: control points, FAPU, meshes, kernels and the operator that carries points to vertices. Pure."""
