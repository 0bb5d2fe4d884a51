"""From control-point displacements to vertices: RBF operators, rigs, blendshapes, Waters muscles."""
