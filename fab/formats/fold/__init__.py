"""FOLD files.

`reader` makes a pattern of the frames of a file. `frames` finds the flat sheet among them,
also of several (`sheet_frames`), in any plane (`flat_frames`) or unfolded (`unfolding`); `faces`
has the faces that a file lists. `writer` writes the pattern, its folded states and, where they are
flat, the order of their faces (`face_orders`).
"""
