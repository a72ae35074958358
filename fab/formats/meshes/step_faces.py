"""Faces of STEP files as splines, read by OpenCASCADE.

Damaged files make OpenCASCADE crash, or keep it busy without end: `surface`, beside this
module, calls it in a process of its own.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from fab.errors import InvalidFile
from fab.formats.meshes.spline_face import SplineFace
from solver.errors import InvalidValue
from solver.vectors import FloatArray

if TYPE_CHECKING:
    from build123d import Face

__all__ = ["listed_faces", "spline_face", "step_face"]

# Kinds of faces that are (rational) splines exactly; others would be approximated.
_EXACT = (
    "BEZIER",
    "BSPLINE",
    "CONE",
    "CYLINDER",
    "EXTRUSION",
    "PLANE",
    "REVOLUTION",
    "SPHERE",
    "TORUS",
)
# Sides of the polygon that stands for an edge of a face, in its parameters; faces an error lists.
_SIDES = 256
_LISTED = 20


def step_face(path: str, face: int | None) -> dict[str, Any]:
    """The `arrays` of a face of a STEP file as a `SplineFace`.

    face : its number, from 0; may be left out where there is one alone. Raises `InvalidFile` or
    `InvalidValue`.
    """
    return spline_face(_chosen(Path(path), face)).arrays()


def _chosen(file: Path, number: int | None) -> Face:
    from build123d import import_step

    faces = import_step(file).faces()
    if not faces:
        raise InvalidFile(f"{file}: it holds no faces, or is no STEP file.")
    if number is None and len(faces) == 1:
        number = 0
    if number is None or not 0 <= number < len(faces):
        last = len(faces) - 1
        raise InvalidValue("face", number, f"lie from 0 to {last}", listed_faces(faces))
    face = faces[number]
    if face.geom_type.name not in _EXACT:
        cure = "Convert it to a B-spline surface in the CAD program, or export it as a mesh."
        kinds = ", ".join(_EXACT).lower()
        raise InvalidValue("kind of the face", face.geom_type.name.lower(), f"be {kinds}", cure)
    return face


def listed_faces(faces: Sequence[Face]) -> str:
    """The first faces of a file, with their kinds and areas, so that one may be chosen."""
    lines = [
        f"{number}: {face.geom_type.name.lower()} of {face.area:.6g} mm2"
        for number, face in enumerate(faces[:_LISTED])
    ]
    more = "; ..." if len(faces) > _LISTED else ""
    return f"The faces are numbered {'; '.join(lines)}{more}."


def spline_face(face: Face) -> SplineFace:
    """A face of a CAD model as a spline."""
    from OCP.BRep import BRep_Tool
    from OCP.BRepBuilderAPI import BRepBuilderAPI_NurbsConvert
    from OCP.BRepTools import BRepTools
    from OCP.GeomConvert import GeomConvert
    from OCP.TopAbs import TopAbs_Orientation
    from OCP.TopoDS import TopoDS
    from scipy.interpolate import NdBSpline

    converted = TopoDS.Face(BRepBuilderAPI_NurbsConvert(face.wrapped, True).Shape())
    surface = GeomConvert.SurfaceToBSplineSurface_s(BRep_Tool.Surface_s(converted))
    low_u, high_u, low_v, high_v = BRepTools.UVBounds_s(converted)
    closed = np.array([surface.IsUPeriodic(), surface.IsVPeriodic()])
    if closed[0]:
        surface.SetUNotPeriodic()
    if closed[1]:
        surface.SetVNotPeriodic()
    start_u, end_u, start_v, end_v = surface.Bounds()
    start = np.array([start_u, start_v])
    weights = np.array(
        [
            [surface.Weight(i, j) for j in range(1, surface.NbVPoles() + 1)]
            for i in range(1, surface.NbUPoles() + 1)
        ]
    )
    poles = np.array(
        [
            [surface.Pole(i, j).Coord() for j in range(1, surface.NbVPoles() + 1)]
            for i in range(1, surface.NbUPoles() + 1)
        ]
    )
    half = np.array([high_u - low_u, high_v - low_v]) / 2
    if converted.Orientation() == TopAbs_Orientation.TopAbs_REVERSED:
        half[0] = -half[0]
    return SplineFace(
        NdBSpline(
            (_knots(surface.UKnotSequence()), _knots(surface.VKnotSequence())),
            np.concatenate([poles * weights[..., None], weights[..., None]], axis=-1),
            (surface.UDegree(), surface.VDegree()),
            extrapolate=True,
        ),
        np.array([low_u + high_u, low_v + high_v]) / 2,
        half,
        start,
        np.where(closed, [end_u - start_u, end_v - start_v], np.inf),
        _outline(converted),
    )


def _knots(sequence: Any) -> FloatArray:
    first = sequence.Lower()
    return np.array([sequence.Value(first + i) for i in range(sequence.Length())])


def _outline(face: Any) -> Any:
    """The face in its surface's parameters: the largest of its loops, less the others."""
    import shapely
    from OCP.BRepAdaptor import BRepAdaptor_Curve2d
    from OCP.BRepTools import BRepTools_WireExplorer
    from OCP.TopAbs import TopAbs_Orientation, TopAbs_WIRE
    from OCP.TopExp import TopExp_Explorer
    from OCP.TopoDS import TopoDS

    forward = TopoDS.Face(face.Oriented(TopAbs_Orientation.TopAbs_FORWARD))
    loops = []
    wires = TopExp_Explorer(forward, TopAbs_WIRE)
    while wires.More():
        points: list[tuple[float, float]] = []
        edges = BRepTools_WireExplorer(TopoDS.Wire(wires.Current()), forward)
        while edges.More():
            edge = edges.Current()
            curve = BRepAdaptor_Curve2d(edge, forward)
            along = np.linspace(curve.FirstParameter(), curve.LastParameter(), _SIDES + 1)
            if edge.Orientation() == TopAbs_Orientation.TopAbs_REVERSED:
                along = along[::-1]
            points += [curve.Value(t).Coord() for t in along.tolist()]
            edges.Next()
        loops.append(shapely.make_valid(shapely.Polygon(points)))
        wires.Next()
    largest = max(range(len(loops)), key=lambda i: float(loops[i].area))
    holes = shapely.union_all(loops[:largest] + loops[largest + 1 :])
    return shapely.difference(loops[largest], holes)
