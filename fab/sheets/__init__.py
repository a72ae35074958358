"""Sheets: a crease pattern cut from sheet material by a laser cutter or plotter.

From pattern to files:

- `cutter_settings`: the table `[cutter]`, from which a request is built; `cut_wishes`: its keys of
  bridges, slots, tabs and titles.
- `sheet_request`: what is asked for: material, machine, copies, sides, formats;
  `fab.jobs.sheet_files` makes it, from all that follows; `sheet_report`: the report.
- `materials`: sheet materials and cutters, as data.

Pieces:

- `pieces`: the pattern in pieces that fit the bed; `piece_patterns`: each as a pattern of its own.
- `seams`: where pieces are glued together.
- `seam_joints`: how they are joined: by `glue_tabs` (of `tab_offers`), `slot_tabs` or `stitches`;
  `openings`: slots and holes of these.
- `piece_labels`: names and numbers to engrave; `labels`: where they are; `stroke_letters`: their
  letters; `rim_points`: numbers where rims of sheets meet.
- `cut_pieces`: all pieces of a pattern with the lines along which they are cut.

Lines to cut:

- `perforation`: creases, relief holes and outlines of a piece as cut paths;
  `perforation_settings`: what can be set; `crease_styles`: dashes, dots, lattices and others;
  `crease_cuts`: where along a crease each style cuts.
- `lattice_room`: room for lattice hinges; `relief_holes`: holes at vertices; `kerf`: outlines moved
  by half the beam.
- `crease_findings`, `feature_size`: what is too fine to be cut as asked for.

Work on the machine:

- `shared_cuts`: pieces placed side to side, so that the lines that they share are cut once.
- `sheet_drawings`: pieces placed on sheets, drawn, and what the report says of them.
- `turned_cuts`: pieces cut anew for a beam that is wider along an axis; `sheet_finish`: bridges,
  mirror and knife; `sheet_title`: a title beside the pieces.
- `registration`: front and back of a sheet scored on both sides.
- `cutting_order`: the order of lines, by `tours` with little travel; `work_estimate`: time.
- `coupon`: a test card for a material on a machine.
"""
