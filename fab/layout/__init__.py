"""Layout: faces divided into pieces, and pieces placed on beds; for cut sheets and for prints.

- `face_sets` is about sets of faces of a flat sheet, a `SheetToDivide`: whether they fit a bed with
  their tabs (`extent`, `upright`); `partition` divides the sheet into such sets.
- `assembly_order` orders and names the pieces: `assembly_order`, `piece_name`.
- `nesting` places pieces on as few beds as it finds: `nest`, `Placements`; `turned_pieces` are what
  it places, `bed_filling` fills one bed after another, and `gap_filling` the gaps between pieces.
- `blocks` lays pieces side to side along equal sides, to be placed as one; `block_places` are where
  they may lie.
- `piece_gaps` sets pieces apart that touch or come too near.
"""
