"""SVG drawings: read from any program, written for Origami Simulator.

`reader` gives the lines of a file. `safe_xml` parses it, `tree` finds every shape that is drawn, in
its style (`styles`), at its place (`lengths`, `viewports`), as straight lines (`shapes`). `writer`
draws a pattern in the colours that Origami Simulator reads.
"""
