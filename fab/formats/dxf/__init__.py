"""DXF drawings: read from any CAD or drawing program, written as whole lines.

`reader` gives the lines of a file, which `document` opens; `curves` makes straight lines of its
entities. `writer` draws a pattern with one layer for each letter; cut paths of sheets are in
`fab.drawings`.
"""
