"""Materials, machines and files: what a cutter, a printer and a simulator take."""
