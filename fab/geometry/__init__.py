"""Plane and solid geometry as arrays; knows no origami.

Plane: `rings` (polygons one after another), `boxes` (the smallest around a figure), `planar_graph`
(faces that lines enclose, crossings), `triangulation` (triangles over regions with holes).
Solids with planar sides: `bodies` (many at once), `extrusion`, `side_loops` and `half_edges` (rings
around their sides, and back), `separating_planes` (which are near, which stay apart).
To libraries and back: `booleans` (manifold3d), `brep` (build123d), both loaded when they are used.
"""
