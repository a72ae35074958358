"""Viewing: what a sheet looks like, flat, on its way and folded.

- `scene` is the one description that all pictures, pages and models are drawn from: a `Scene`.
- `scene_builders` makes it: `pattern_scene` of a crease pattern, `folding_scene` of a simulation,
  `thick_scene` of panels and hinges; `over_surface` adds the surface that a sheet follows.
- `figures` are those about the method: what a flap angle decides, how sheets grow and fold.
- `predicted_fold` adds states between flat and folded where nobody simulated them.
- `glb` writes models of a scene with their animation, `page` the result page that shows all that a
  command made: its numbers by `page_tables`, its drawings by `page_drawings`, what its script draws
  by `page_data`. The script in `page_assets` is made of `page_source` and three.js.
- `scales` are the scales of colours, the same for every sheet.

Pictures of a scene: `sheet_picture` (folded form and crease pattern), `folding_picture` (its
states, also as a movie), `thick_picture` (bodies and plates), `reading_picture` (what was read from
a file). They are drawn by `drawing` in boxes of a `canvas`, seen by a `camera` as `view_choice`
says, from triangles (`shapes`, `face_triangles`) that are lit by `painting`, hidden by `raster`.
`growth_picture` shows a sheet strip by strip; `movie_files` makes GIF and MP4 files of pictures.
"""
