"""Findings of surfaces that are read from meshes and STEP models, each a repair or a fact."""

from __future__ import annotations

from fab.findings.explanation import NOTE, WARNING, Explanation

__all__ = ["MESHES"]

_NOTHING = "Nothing, unless the place in the text looks wrong in a mesh editor."

MESHES = (
    Explanation(
        "mesh-vertices-merged",
        (NOTE,),
        "Vertices within a millionth of the size are made one.",
        "STL and some other files repeat each vertex for every triangle.",
        _NOTHING,
    ),
    Explanation(
        "mesh-faces-repeated",
        (NOTE,),
        "Triangles that are there twice are kept once.",
        "The model was exported or joined twice.",
        _NOTHING,
    ),
    Explanation(
        "mesh-faces-without-area",
        (NOTE,),
        "Triangles that are nearly lines are left out, and no gap is left.",
        "CAD programs make slivers where curved faces meet.",
        _NOTHING,
    ),
    Explanation(
        "mesh-branches",
        (WARNING,),
        "Edges had more than two triangles: the two that continue each other most smoothly stay "
        "joined.",
        "Walls inside the model, or bodies that share an edge.",
        "Remove the inner walls in a mesh editor.",
    ),
    Explanation(
        "mesh-parts-touch",
        (NOTE,),
        "Parts that touched at single vertices are taken apart there.",
        "Two bodies, or two corners of one, meet in a point.",
        _NOTHING,
    ),
    Explanation(
        "mesh-pieces",
        (NOTE, WARNING),
        "The mesh is in pieces, of which the largest is kept.",
        "A scan with specks, or a model of several bodies. It is a warning where others hold 1 "
        "% of the area "
        "or more.",
        "Join pieces in a mesh editor where they belong together, or give each as a file of its "
        "own.",
    ),
    Explanation(
        "mesh-windings",
        (NOTE,),
        "Triangles that were wound against the others are turned over.",
        "The program that wrote the file keeps no orientation.",
        _NOTHING,
    ),
    Explanation(
        "mesh-inside-out",
        (NOTE,),
        "A closed surface was inside out: its normals point outwards now.",
        "The program that wrote the file winds triangles the other way.",
        _NOTHING,
    ),
    Explanation(
        "mesh-one-sided",
        (NOTE,),
        "The surface has one side only, as a Moebius band has.",
        "It is such a band, or a wrong joint in the model.",
        "Cut it across in a mesh editor where it is not meant.",
    ),
    Explanation(
        "mesh-holes-filled",
        (NOTE,),
        "Small holes are filled with covers of least area.",
        "Gaps of a scan.",
        "Nothing; a hole that is meant must be larger than the bound in the text.",
    ),
    Explanation(
        "mesh-small-holes",
        (NOTE,),
        "Small holes are kept.",
        "They have very many sides, or corners that are joined already.",
        "Fill them in a mesh editor.",
    ),
    Explanation(
        "mesh-decimated",
        (NOTE,),
        "A fine mesh was made coarser, by no more than the text says.",
        "It has many more triangles than a sheet can follow.",
        "Nothing.",
    ),
    Explanation(
        "mesh-large",
        (NOTE,),
        "A fine mesh is kept as it is.",
        "It could not be made coarser without a fault.",
        "Nothing, but it takes longer. Decimate it in a mesh editor.",
    ),
    Explanation(
        "mesh-moved",
        (NOTE,),
        "A surface over 100 times its size from the origin is moved there, and so is its sheet.",
        "Coordinates of a map, or of a part of something large.",
        "Nothing; to lay the sheet over the model, move it back by the middle in the text.",
    ),
    Explanation(
        "mesh-neighbours-cross",
        (NOTE,),
        "Neighbouring triangles cross each other.",
        "Noise of a scan.",
        "Nothing: smoothing takes it away.",
    ),
    Explanation(
        "mesh-crosses-itself",
        (WARNING,),
        "The surface passes through itself.",
        "It was modelled so, or parts of a scan overlap.",
        "Cut it apart there; a sheet that follows it would cross itself too.",
    ),
    Explanation(
        "model-faces",
        (NOTE,),
        "All faces of a STEP model are taken together.",
        "The job names none of them.",
        "Give face, a number or a list of them, to follow some of them alone.",
    ),
)
