"""Published crease patterns as FOLD files, in the manners of different programs.

    python tests/patterns/make.py

writes them anew beside this script. Each function names its source; what a file lacks or does in
its own way is what programs do: no faces, no fold angles, inches, clockwise faces, U and J edges.
"""

from __future__ import annotations

import json
from itertools import pairwise
from math import cos, pi, sin, sqrt, tan
from pathlib import Path

HERE = Path(__file__).parent


class Sheet:
    """Vertices by place, edges by their ends; borders are given as any other edge."""

    def __init__(self) -> None:
        self.points: list[tuple[float, float]] = []
        self.edges: dict[tuple[int, int], str] = {}

    def vertex(self, x: float, y: float) -> int:
        for number, (u, v) in enumerate(self.points):
            if abs(u - x) + abs(v - y) < 1e-9:
                return number
        self.points.append((x, y))
        return len(self.points) - 1

    def line(self, letter: str, *points: tuple[float, float]) -> None:
        ends = [self.vertex(*point) for point in points]
        for one, two in pairwise(ends):
            assert (one, two) not in self.edges
            assert (two, one) not in self.edges
            self.edges[one, two] = letter

    def document(self, title: str, spec: float = 1.1, **more: object) -> dict:
        return {
            "file_spec": spec,
            "file_title": title,
            "frame_classes": ["creasePattern"],
            "vertices_coords": [list(point) for point in self.points],
            "edges_vertices": [list(edge) for edge in self.edges],
            "edges_assignment": list(self.edges.values()),
            **more,
        }


def bird_base() -> dict:
    """The bird base, traditional; as in R. J. Lang, Origami Design Secrets (2nd ed. 2011), ch. 4.

    Creases at multiples of 22.5 degrees: from each corner to the points P at 2 - sqrt 2 of the
    half side on the midlines, the petal folds' hinges from P to P. Six inches wide. Diagonals that
    stay flat join faces (J).
    """
    sheet, h = Sheet(), 3.0
    p = h * (1 - tan(pi / 8))
    axes = [(1, 0), (0, 1), (-1, 0), (0, -1)]
    for k, (x, y) in enumerate(axes):
        u, v = axes[(k + 1) % 4]
        corner, middle, apex = (h * (x + u), h * (y + v)), (h * x, h * y), (p * x, p * y)
        after, following = (h * u, h * v), (p * u, p * v)
        petal = (p * (x + u) / 2, p * (y + v) / 2)
        sheet.line("B", middle, corner, after)
        sheet.line("M", middle, apex, (0, 0))
        sheet.line("V", apex, corner)
        sheet.line("V", following, corner)
        sheet.line("V", apex, petal, following)
        sheet.line("V" if k % 2 else "J", (0, 0), petal)
        sheet.line("M" if k % 2 else "J", petal, corner)
    return sheet.document("bird base", frame_unit="in", file_creator="no faces, no angles")


def square_twist() -> dict:
    """The square twist of S. Fujimoto and Y. Momotani; as in R. J. Lang, Twists, Tilings and
    Tessellations (2018), ch. 3: pleats leave a square that is turned against them by 22.5 degrees.
    """
    sheet, half, side = Sheet(), 60.0, 30.0
    reach = side / sqrt(2)
    corners = [
        (reach * cos(k * pi / 2 + pi / 8), reach * sin(k * pi / 2 + pi / 8)) for k in range(4)
    ]
    axes = [(1, 0), (0, 1), (-1, 0), (0, -1)]
    rim = []
    for k in range(4):
        corner = corners[k]
        for turn, letter in ((k, "M"), (k + 1, "V")):
            x, y = axes[turn % 4]
            end = tuple(half * a if a else c for a, c in zip((x, y), corner, strict=True))
            sheet.line(letter, corner, end)
            rim.append(end)
        sheet.line("V", corner, corners[(k + 1) % 4])
    rim += [(half, half), (-half, half), (-half, -half), (half, -half)]
    number = sorted(rim, key=lambda q: _around_square(*q, half))
    sheet.line("B", *number, number[0])
    angles = [{"M": -170, "V": 170}.get(letter) for letter in sheet.edges.values()]
    return sheet.document("square twist", 1.2, frame_unit="mm", edges_foldAngle=angles)


def _around_square(x: float, y: float, half: float) -> float:
    """Way along the border, counterclockwise from the lower right corner."""
    if x == half and y < half:
        return y + half
    if y == half and x > -half:
        return 3 * half - x
    if x == -half and y > -half:
        return 5 * half - y
    return 7 * half + x


def waterbomb() -> dict:
    """The waterbomb tessellation; as in Y. Chen, H. Feng, J. Ma, R. Peng, Z. You, Symmetric
    waterbomb origami, Proc. R. Soc. A 472 (2016): square bases in rows shifted by half of one.

    Faces wound clockwise, no unit.
    """
    columns, rows = 4, 4
    sheet, width, height = Sheet(), 2 * columns, 2 * rows

    def crease(letter: str, *points: tuple[float, float]) -> None:
        if all(0 <= x <= width for x, _ in points):
            rim = any(len({point[i] for point in points}) == 1 for i in (0, 1)) and any(
                all(point[i] == bound for point in points)
                for i, bound in ((0, 0), (0, width), (1, 0), (1, height))
            )
            sheet.line("B" if rim else letter, *points)

    faces = []
    for j in range(rows):
        shift, low, middle, high = j % 2, 2 * j, 2 * j + 1, 2 * j + 2
        for x in range(-1, width + 2):
            crease("M", (x, low), (x + 1, low))
            if x % 2 == shift:  # between two bases
                crease("M", (x, low), (x, high))
                continue
            crease("M", (x, low), (x, middle), (x, high))
            for side in (-1, 1):
                crease("V", (x, middle), (x + side, low))
                crease("V", (x, middle), (x + side, high))
                for outline in (
                    [(x, middle), (x, low), (x + side, low)],
                    [(x, middle), (x + side, low), (x + side, high)],
                    [(x, middle), (x + side, high), (x, high)],
                ):
                    if all(0 <= u <= width for u, _ in outline):
                        faces.append(outline if side < 0 else outline[::-1])
    for x in range(width):
        crease("B", (x, height), (x + 1, height))
    numbers = [[sheet.vertex(*point) for point in face] for face in faces]
    return sheet.document("waterbomb tessellation", faces_vertices=numbers)


def resch() -> dict:
    """A patch of the triangular tessellation of R. D. Resch (US patent 3407558, 1968); as in T.
    Tachi, Designing freeform origami tessellations by generalizing Resch's patterns, J. Mech. Des.
    135 (2013): triangles, and hexagons that are tucked in; folded, a quarter of the area is seen.

    Mountains around the triangles, valleys to the middles of the hexagons; every other spoke of a
    hexagon is left unassigned (U). No faces, lower-case letters.
    """
    sheet, count = Sheet(), 8

    def place(i: int, j: int) -> tuple[float, float]:
        return i + j / 2, j * sqrt(3) / 2

    for j in range(count + 1):
        for i in range(count + 1):
            for k, (a, b) in enumerate([(1, 0), (0, 1), (-1, 1)]):
                u, v = i + a, j + b
                if not (0 <= u <= count and 0 <= v <= count):
                    continue
                rim = (j == v and j in (0, count)) or (i == u and i in (0, count))
                spoke = "v" if (i % 2 == 0 and j % 2 == 0) == (k % 2 == 0) else "u"
                middle = (i % 2 == 0 and j % 2 == 0) or (u % 2 == 0 and v % 2 == 0)
                sheet.line("b" if rim else spoke if middle else "m", place(i, j), place(u, v))
    return sheet.document("triangular tessellation of Resch", frame_unit="cm")


def popup() -> dict:
    """Two boxes of a pop-up card; as in D. A. Carter, J. Diaz, The Elements of Pop-Up (1999):
    cut on both sides (C), creased at back, edge and floor. Below them rows of staggered slits that
    touch no crease; as in A. Rafsanjani, K. Bertoldi, Buckling-induced kirigami, Phys. Rev. Lett.
    118 (2017). Angles of 90 degrees.
    """
    sheet, half = Sheet(), 6.0
    boxes = [(-4.0, -2.0, 3.0, 1.0), (1.0, 3.0, 2.0, 2.0)]  # left, right, height, depth
    gutter = [(-8.0, 0.0)]
    for left, right, height, depth in boxes:
        for x in (left, right):
            marks = sorted({-depth, 0.0, height - depth, height})
            sheet.line("C", *[(x, y) for y in marks])
        sheet.line("V", (left, height), (right, height))
        sheet.line("M", (left, height - depth), (right, height - depth))
        sheet.line("V", (left, -depth), (right, -depth))
        sheet.line("V", gutter.pop(), (left, 0.0))
        gutter.append((right, 0.0))
    sheet.line("V", gutter.pop(), (8.0, 0.0))
    rim = [(-8.0, -half), (8.0, -half), (8.0, 0.0), (8.0, half), (-8.0, half), (-8.0, 0.0)]
    sheet.line("B", *rim, rim[0])
    for row in range(3):
        for i in range(4):
            x = -7.0 + 3.5 * i + 1.5 * (row % 2)
            sheet.line("C", (x, -5.5 + row), (x + 2.5, -5.5 + row))
    angles = [{"M": -90, "V": 90}.get(letter, 0) for letter in sheet.edges.values()]
    return sheet.document("pop-up boxes with slits", 1.2, frame_unit="cm", edges_foldAngle=angles)


def yoshimura() -> dict:
    """The diamond pattern of Y. Yoshimura, On the mechanism of buckling of a circular cylindrical
    shell under axial compression, NACA TM 1390 (1955). All faces are triangles. Points of type,
    three coordinates.
    """
    sheet, columns, rows, w, h = Sheet(), 6, 4, 72.0, 40.0
    faces = []
    for j in range(rows):
        low, high = w / 2 * (j % 2), w / 2 * ((j + 1) % 2)
        for i in range(columns):
            a, b = (low + i * w, j * h), (low + i * w + w, j * h)
            c, d = (high + i * w, (j + 1) * h), (high + i * w + w, (j + 1) * h)
            sheet.line("M" if j else "B", a, b)
            if j == rows - 1:
                sheet.line("B", c, d)
            sheet.line("V", *((b, c) if low < high else (a, d)))
            sheet.line("V" if i else "B", a, c)
            if i == columns - 1:
                sheet.line("B", b, d)
            faces += [[a, b, c], [b, d, c]] if low < high else [[a, b, d], [a, d, c]]
    numbers = [[sheet.vertex(*point) for point in face] for face in faces]
    document = sheet.document("Yoshimura pattern", 1.2, frame_unit="pt", faces_vertices=numbers)
    document["vertices_coords"] = [[x, y, 0] for x, y in sheet.points]
    document["frame_attributes"] = ["2D"]
    return document


PATTERNS = (bird_base, square_twist, waterbomb, resch, popup, yoshimura)


def text_of(document: dict) -> str:
    rows = [f"{json.dumps(key)}: {json.dumps(value)}" for key, value in document.items()]
    return "{\n" + ",\n".join(rows) + "\n}\n"


if __name__ == "__main__":
    for pattern in PATTERNS:
        (HERE / f"{pattern.__name__}.fold").write_text(text_of(pattern()))
