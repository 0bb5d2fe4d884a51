"""Files of faces and motion: OBJ and other meshes, PPC, DPC, EPC."""
