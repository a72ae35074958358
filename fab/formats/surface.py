"""Which surface does a file hold: a mesh, or a face of a CAD model?"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from fab.errors import InvalidFile
from solver.errors import InvalidValue
from solver.targets.base import Target
from solver.targets.mesh import MeshSurface
from solver.targets.parametric import ParametricSurface
from solver.vectors import BoolArray, FloatArray

if TYPE_CHECKING:
    from build123d import Face

__all__ = ["SplineFace", "read_surface"]

_MESHES = (".obj", ".ply", ".stl")
_MODELS = (".step", ".stp")
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


@dataclass(frozen=True)
class SplineFace:
    """A face of a CAD model as a rational tensor-product spline, u and v in [-1, 1] around it.

    Exact within the face; beyond, the spline's outermost pieces go on, and where the surface
    closes on itself it goes on all around. Its normals X_u x X_v point out of the model.

    Attributes
    ----------
    spline : `scipy.interpolate.NdBSpline` with values (n, 4): weight times point, and weight.
    middle, half : the spline's parameters are middle + half (u, v), each of shape (2,).
    start, period : parameters are brought into [start, start + period); inf where open, (2,).
    outline : shapely polygon of the face in the spline's parameters, with its holes.
    """

    spline: Any
    middle: FloatArray
    half: FloatArray
    start: FloatArray
    period: FloatArray
    outline: Any

    def position(self, u: FloatArray, v: FloatArray) -> FloatArray:
        """Points X(u, v), shape (n, 3), in the file's units as millimetres."""
        value = self.spline(self._wrapped(u, v))
        out: FloatArray = value[:, :3] / value[:, 3:]
        return out

    def derivatives(self, u: FloatArray, v: FloatArray) -> tuple[FloatArray, FloatArray]:
        """X_u and X_v, each (n, 3), by the quotient rule."""
        at = self._wrapped(u, v)
        value = self.spline(at)
        weight = value[:, 3:]
        position = value[:, :3] / weight
        by_u, by_v = (
            half * (slope[:, :3] - position * slope[:, 3:]) / weight
            for half, slope in zip(
                self.half.tolist(),
                (self.spline(at, nu=(1, 0)), self.spline(at, nu=(0, 1))),
                strict=True,
            )
        )
        return by_u, by_v

    def within(self, u: FloatArray, v: FloatArray) -> BoolArray:
        """Whether parameters belong to the face, shape (n,).

        Its edges are polygons of 256 sides each: right but for some 1e-4 of an edge's size.
        """
        import shapely

        s, t = (self.middle + self.half * np.column_stack([u, v])).T
        inside: BoolArray = shapely.intersects_xy(self.outline, s, t)
        return inside

    def _wrapped(self, u: FloatArray, v: FloatArray) -> FloatArray:
        at = self.middle + self.half * np.column_stack([u, v])
        closed = np.isfinite(self.period)
        start, period = self.start[closed], self.period[closed]
        at[:, closed] = start + (at[:, closed] - start) % period
        return at


def read_surface(
    path: str | Path,
    face: int | None = None,
    up: Sequence[float] | None = None,
) -> Target:
    """The surface in an STL, OBJ, PLY, STEP or STP file, as a target of surface fitting.

    face : number of the face of a STEP file, from 0; may be left out where there is one alone.
    up : direction from which a mesh is seen (see `MeshSurface.from_faces`).
    Lengths of STEP files are in millimetres, whatever unit they were written in. Raises
    `InvalidFile` or `InvalidValue`.
    """
    file = Path(path)
    ending = file.suffix.lower()
    if ending not in _MESHES + _MODELS:
        endings = ", ".join(_MESHES + _MODELS)
        raise InvalidFile(f"{file}: surfaces are read from files that end in {endings}.")
    if not file.is_file():
        what = "a folder, not a file" if file.is_dir() else "there is no such file"
        raise InvalidFile(f"{file}: {what}.")
    if ending in _MESHES:
        if face is not None:
            cure = "Faces are chosen in STEP files; a mesh is followed as a whole."
            raise InvalidValue("face", face, "be None for a mesh", cure)
        return MeshSurface.read(file, up=up)
    if up is not None:
        cure = "The side of a face of a STEP file is the one on which its normals stand."
        raise InvalidValue("up", up, "be None for a STEP file", cure)
    if face is not None and (isinstance(face, bool) or not isinstance(face, int)):
        raise InvalidValue("face", face, "be a whole number", "Faces are numbered from 0.")
    spline = _spline_face(_chosen(file, face))
    return ParametricSurface(spline.position, spline.derivatives, spline.within)


def _chosen(file: Path, number: int | None) -> Face:
    from build123d import import_step

    faces = import_step(file).faces()
    if not faces:
        raise InvalidFile(f"{file}: it holds no faces, or is no STEP file.")
    if number is None and len(faces) == 1:
        number = 0
    if number is None or not 0 <= number < len(faces):
        last = len(faces) - 1
        raise InvalidValue("face", number, f"lie from 0 to {last}", _listed(faces))
    face = faces[number]
    if face.geom_type.name not in _EXACT:
        cure = "Convert it to a B-spline surface in the CAD program, or export it as a mesh."
        kinds = ", ".join(_EXACT).lower()
        raise InvalidValue("kind of the face", face.geom_type.name.lower(), f"be {kinds}", cure)
    return face


def _listed(faces: Sequence[Face]) -> str:
    lines = [
        f"{number}: {face.geom_type.name.lower()} of {face.area:.6g} mm2"
        for number, face in enumerate(faces[:_LISTED])
    ]
    more = "; ..." if len(faces) > _LISTED else ""
    return f"The faces are {'; '.join(lines)}{more}."


def _spline_face(face: Face) -> SplineFace:
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
    outline = shapely.difference(loops[largest], holes)
    shapely.prepare(outline)
    return outline
