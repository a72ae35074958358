"""Layout: faces divided into pieces, and pieces placed on beds; for cut sheets and for prints.

- `partition` divides a flat sheet into connected sets of faces that fit a bed: `Sheet`,
  `partition`, `upright`.
- `assembly_order` orders and names the pieces: `assembly_order`, `piece_name`.
- `nesting` places pieces on as few beds as it finds: `nest`, `Placements`; `gap_filling` fills the
  gaps between them.
"""
