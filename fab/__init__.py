"""Materials, machines and files: from a folded mesh to what a cutter, a printer and a simulator take."""
