"""Published crease patterns as FOLD files, in the manners of different programs.

    python tests/patterns/make.py

writes them anew beside this script. Each function names its source; what a file lacks or does in
its own way is what programs do: no faces, no fold angles, inches, clockwise faces, U and J edges.
"""

from __future__ import annotations

import json
from itertools import pairwise
from math import atan, cos, degrees, hypot, pi, radians, sin, sqrt, tan
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
    angles = [{"M": -180, "V": 180}.get(letter) for letter in sheet.edges.values()]
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


def crane() -> dict:
    """The crane, traditional: a bird base, its four corners beside the legs folded to the middle,
    both legs reversed inside for neck and tail, and the end of the neck once more for the head.
    Folded flat, wings up; as in R. J. Lang, Origami Design Secrets (2nd ed. 2011), ch. 4.

    The legs are the corners on the rising diagonal, each of eight layers between rays at multiples
    of 11.25 degrees. Fold angles on all edges, no faces.
    """
    sheet, h, step = Sheet(), 75.0, pi / 16
    p = h * (1 - tan(pi / 8))
    to_p = h / cos(pi / 8)

    def turned(x: float, y: float, leg: int, mirrored: bool) -> tuple[float, float]:
        return (leg * y, leg * x) if mirrored else (leg * x, leg * y)

    def reverse(radius: float, turn: float) -> list[float]:
        """Places on the rays 0 to 4: the fold turns by 2 turn from pointing back."""
        other = radius * cos(turn) / cos(turn - step)
        return [other if j % 2 else radius for j in range(5)]

    def kite(toward: float) -> tuple[float, float]:
        """Where the fold around P, from the corner of the leg, meets the ray in a direction."""
        beta = {180: 112.5, 225: 67.5, 292.5: 135}[toward]
        reach = to_p * sin(step) / sin(radians(beta) + step)
        return p + reach * cos(radians(toward)), reach * sin(radians(toward))

    for leg, mirrored in ((1, False), (1, True), (-1, False), (-1, True)):

        def place(x: float, y: float, which=(leg, mirrored)) -> tuple[float, float]:
            return turned(x, y, *which)

        def ray(j: int, radius: float, at=place) -> tuple[float, float]:
            turn = -pi / 2 - j * step
            return at(h + radius * cos(turn), h + radius * sin(turn))

        corner, wing, center, point = place(h, h), place(h, -h), (0.0, 0.0), place(p, 0)
        x, y, z = (place(*kite(toward)) for toward in (180, 225, 292.5))
        folds = [reverse(h, pi / 8)] + [reverse(0.35 * h, pi / 4)] * (leg == 1)
        ends = {1: ("M", z), 2: ("V", point), 3: ("V", x)}
        for j, (letter, end) in ends.items():
            sheet.line(letter, end, *[ray(j, radii[j]) for radii in folds], corner)
        if not mirrored:
            marks = [center, *[ray(4, radii[4]) for radii in folds], corner]
            for letter, one, two in zip("MVM", marks, marks[1:], strict=False):
                sheet.line(letter, one, two)
        for letters, radii in zip(("VMVM", "MVMV"), folds, strict=False):
            for j, letter in enumerate(letters):
                sheet.line(letter, ray(j, radii[j]), ray(j + 1, radii[j + 1]))
        rim = [ray(0, radii[0]) for radii in folds]
        sheet.line("B", wing, *rim, corner)
        sheet.line("V", center, x, point)
        sheet.line("V", point, z, wing)
        sheet.line("M", x, y)
        sheet.line("V", y, z)
        sheet.line("M", point, y)
        if leg == 1:  # the hinge of a wing, from this kite to that of the other leg
            sheet.line("M", y, turned(*kite(225), -leg, not mirrored))
    angles = [{"M": -180, "V": 180, "B": 0}[letter] for letter in sheet.edges.values()]
    return sheet.document("crane", 1.1, frame_unit="mm", edges_foldAngle=angles)


def box() -> dict:
    """An open box, traditional: walls of one unit, and corners folded in two, outside on a wall.

    Angles that close: walls stand at 90 degrees, corners lie flat on them. Two inches high.
    """
    sheet, size, height = Sheet(), 3.0, 2.0
    angles: list[float] = []

    def line(angle: float, *points: tuple[float, float]) -> None:
        sheet.line("B" if not angle else "V" if angle > 0 else "M", *points)
        angles.extend([angle] * (len(sheet.edges) - len(angles)))

    a, b = size / 2, size / 2 + height
    for c, s in ((1, 0), (0, 1), (-1, 0), (0, -1)):

        def place(x: float, y: float, turn=(c, s)) -> tuple[float, float]:
            return turn[0] * x - turn[1] * y, turn[1] * x + turn[0] * y

        line(90, place(a, -a), place(a, a))
        line(90, place(a, a), place(b, a))
        line(180, place(a, a), place(b, b))
        line(-180, place(a, a), place(a, b))
        line(0, place(b, -a), place(b, a), place(b, b), place(a, b))
    return sheet.document("box", 1.2, frame_unit="in", edges_foldAngle=angles)


def maze() -> dict:
    """Walls along all lines of a grid, of height h = 1 between cells of 1; as in E. D. Demaine, M.
    L. Demaine, J. Ku, Folding any orthogonal maze, Origami 5 (2011): each cell takes 2h + 1 of
    paper. Walls are ridges of two layers; where two of them cross, a square of 2h becomes a flap
    of eight triangles that lies on one of the walls, here on another one each time.

    Angles of 90 and 180 degrees that close. No unit; faces left out.
    """
    sheet, count = Sheet(), 2
    angles: list[float] = []
    end = 3.0 * count

    def line(angle: float, letter: str, *points: tuple[float, float]) -> None:
        sheet.line(letter, *points)
        angles.extend([angle] * (len(sheet.edges) - len(angles)))

    for k in range(count):
        for m in range(count):
            turn = ((1, 0), (0, 1), (-1, 0), (0, -1))[(2 * k + m) % 4]

            def place(x: float, y: float, at=(k, m), t=turn) -> tuple[float, float]:
                return 3 * at[0] + 1.5 + t[0] * x - t[1] * y, 3 * at[1] + 1.5 + t[1] * x + t[0] * y

            center = place(0, 0)
            for x, y in ((1, 0), (0, 1), (-1, 0), (0, -1)):
                line(-180, "M", center, place(x, y), place(1.5 * x, 1.5 * y))
                for side in (-1, 1):
                    one, two = (
                        (x - side * y, y + side * x),
                        (1.5 * x - side * y, 1.5 * y + side * x),
                    )
                    line(90, "V", place(*one), place(*two))
            line(-180, "M", center, place(1, 1))
            for x, y in ((-1, 1), (-1, -1), (1, -1)):
                line(180, "V", center, place(x, y))
            line(180, "V", place(1, 0), place(1, 1))
            line(-180, "M", place(1, 0), place(1, -1))
            line(90, "V", place(0, 1), place(1, 1))
            line(90, "V", place(0, -1), place(1, -1))
            line(-90, "M", place(0, 1), place(-1, 1))
            line(-90, "M", place(0, -1), place(-1, -1))
            line(0, "F", place(-1, 0), place(-1, 1))
            line(0, "F", place(-1, 0), place(-1, -1))
    marks = sorted({0.0, end, *(3 * k + 1.5 + side for k in range(count) for side in (-1, 0, 1))})
    for fixed in (0.0, end):
        line(0, "B", *[(mark, fixed) for mark in marks])
        line(0, "B", *[(fixed, mark) for mark in marks])
    return sheet.document("maze", 1.2, edges_foldAngle=angles)


def miura() -> dict:
    """The sheet of K. Miura, Method of packaging and deployment of large membranes in space (1985),
    triangulated for a program that knows no other faces: their short diagonals join them (J).

    Rows fold by 2 atan(cos 60 tan(fold / 2)), columns by fold = 110 degrees, so that angles close.
    """
    sheet, columns, rows, size, sector = Sheet(), 5, 4, 30.0, pi / 3
    fold = 110.0
    bend = degrees(2 * atan(cos(sector) * tan(radians(fold) / 2)))
    angles, faces = [], []

    def place(i: int, j: int) -> tuple[float, float]:
        return size * (i + (j % 2) * cos(sector)), size * j * sin(sector)

    def line(angle: float, letter: str, *points: tuple[float, float]) -> None:
        sheet.line(letter, *points)
        angles.append(angle if letter == "V" else -angle if letter == "M" else 0.0)

    for j in range(rows + 1):
        for i in range(columns + 1):
            if i < columns:
                letter = "MV"[(i + j) % 2]
                line(bend, "B" if j in (0, rows) else letter, place(i, j), place(i + 1, j))
            if j < rows:
                letter = "VM"[i % 2]
                line(fold, "B" if i in (0, columns) else letter, place(i, j), place(i, j + 1))
            if i < columns and j < rows:
                a, b = place(i, j), place(i + 1, j)
                c, d = place(i + 1, j + 1), place(i, j + 1)
                short = hypot(a[0] - c[0], a[1] - c[1]) < hypot(b[0] - d[0], b[1] - d[1])
                line(0.0, "J", *((a, c) if short else (b, d)))
                faces += [[a, b, c], [a, c, d]] if short else [[a, b, d], [b, c, d]]
    numbers = [[sheet.vertex(*point) for point in face] for face in faces]
    return sheet.document(
        "Miura sheet of triangles",
        1.1,
        frame_unit="mm",
        faces_vertices=numbers,
        edges_foldAngle=angles,
    )


PATTERNS = (
    bird_base,
    box,
    crane,
    maze,
    miura,
    popup,
    resch,
    square_twist,
    waterbomb,
    yoshimura,
)


def text_of(document: dict) -> str:
    rows = [f"{json.dumps(key)}: {json.dumps(value)}" for key, value in document.items()]
    return "{\n" + ",\n".join(rows) + "\n}\n"


if __name__ == "__main__":
    for pattern in PATTERNS:
        (HERE / f"{pattern.__name__}.fold").write_text(text_of(pattern()))
