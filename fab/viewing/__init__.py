"""Viewing: what a sheet looks like, flat, on its way and folded.

- `scene` is the one description that all pictures, pages and models are drawn from: a `Scene`.
- `scene_builders` makes it: `pattern_scene` of a crease pattern, `folding_scene` of a simulation,
  `thick_scene` of panels and hinges; `over_surface` adds the surface that a sheet follows.
- `figures` are those about the method: what a flap angle decides, how sheets grow and fold.
- `scales` are the scales of colours, the same for every sheet.
"""
