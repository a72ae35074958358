"""Loads: a folded sheet of a material, held somewhere, under its weight, pulls and air pressure.

- `load_settings` is what users ask for, `plate` what the sheet is made of, in SI.
- `refined` divides the faces into finer triangles, `plate_bending` bends them as plates.
- `forces` are the loads as potentials; `supports` finds the vertices that users name.
- `loaded_sheet` brings the sheet to rest: `load_sheet`, a `LoadedSheet`.
"""
