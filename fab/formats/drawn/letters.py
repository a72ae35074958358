"""Assignments of drawn lines, from their colours and from the names of layers, classes and ids.

Colours are read as Origami Simulator reads them (https://origamisimulator.org), and so are those
near to them; names come before colours, as drawings for laser cutters have colours of their own.
"""

from __future__ import annotations

import colorsys
import re
import unicodedata
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field
from functools import lru_cache

from fab.errors import Finding, Severity, did_you_mean
from solver.errors import InvalidValue

__all__ = [
    "colour_of",
    "given_letter",
    "key_of",
    "letter_of",
    "parse_colours",
    "unlettered_finding",
    "unused_colours",
    "unused_in_all",
]

# Words in the names of layers that say what their lines are, without accents and in lower case.
_WORDS = {
    "M": """
        mountain mountains mtn mountainfold mountainfolds montagne montagnes berg bergfalte
        bergfalten bergfalz bergfalze monte monti montana montanas yama yamaori
        山 山折 山折り 山折り線
        """,
    "V": """
        valley valleys vly valleyfold valleyfolds vallee vallees tal talfalte talfalten talfalz
        talfalze valle valli valles tani taniori 谷 谷折 谷折り 谷折り線
        """,
    "B": """
        border borders boundary boundaries outline outlines contour contours perimeter bord bords
        bordure rand umriss kontur bordo contorno borde 輪郭 輪郭線
        """,
    "C": """
        cut cuts cutting slit slits coupe decoupe decoupes schnitt schnitte schneiden taglio tagli
        corte cortes 切断 切り込み
        """,
    "F": """
        facet facets flat auxiliary aux triangulation triangulations mark marks auxiliaire
        hilfslinie hilfslinien ausiliaria ausiliarie auxiliar auxiliares 補助線
        """,
    "U": """
        unassigned undriven hinge hinges score scores scoring engrave engraves engraved engraving
        rainage gravure gravur rillen incisione grabado
        """,
    "J": "join joins joined",
}
_LETTER_OF_WORD = {word: letter for letter, words in _WORDS.items() for word in words.split()}
# Whole names that are a letter; other single letters are too common as names of anything.
_SHORT = {"m": "M", "v": "V"}
# Words of lines that fold, of which a colour may say more.
_FOLDS = frozenset(
    {
        *("crease", "creases", "fold", "folds", "folding", "pli", "plis", "falte", "falten"),
        *("falz", "falze", "piega", "pieghe", "pliegue", "pliegues", "ori"),
    }
)
_MEANINGS = {
    **{letter.lower(): letter for letter in "BMVFUCJ"},
    **_LETTER_OF_WORD,
}
_CHOICES = ("border", "mountain", "valley", "facet", "undriven", "cut", "join")
# Hues in degrees, from and to, of colours that are neither black nor pale.
_HUES = (
    ("M", 340.0, 380.0),
    ("F", 45.0, 75.0),
    ("C", 80.0, 155.0),
    ("V", 200.0, 262.0),
    ("U", 275.0, 332.0),
)
_LEAST_SATURATION = 0.4
_AUXILIARY = "#64c8c8"
# Lightness below which grey is black; brightness below which every colour is.
_BLACK_BELOW = 0.25
_LISTED = 6


@lru_cache(maxsize=4096)
def colour_of(text: str) -> tuple[str, float] | None:
    """The colour that a CSS text names: "#rrggbb" in lower case, and its alpha from 0 to 1.

    None where it names no colour (such as "none", "url(#a)", "inherit").

    >>> colour_of("rgb(255, 0, 0)"), colour_of("#00f8")
    (('#ff0000', 1.0), ('#0000ff', 0.5333333333333333))
    """
    from tinycss2.color4 import parse_color

    plain = text.partition("icc-color(")[0].strip()  # "#f00 icc-color(...)": sRGB comes first
    if re.fullmatch(r"#[0-9a-fA-F]{6}", plain):
        return plain.lower(), 1.0
    try:
        colour = parse_color(plain)
        if colour is None or isinstance(colour, str):
            return None
        red, green, blue = colour.to("srgb").coordinates
        alpha = min(max(float(colour.alpha), 0.0), 1.0)
        parts = [round(min(max(float(c or 0.0), 0.0), 1.0) * 255) for c in (red, green, blue)]
    except (ValueError, ArithmeticError, NotImplementedError, RecursionError):
        return None
    return "#%02x%02x%02x" % tuple(parts), alpha


def letter_of(colour: str | None, names: Sequence[str], colours: Mapping[str, str]) -> str | None:
    """The assignment of a line by its colour and its names; None where they say nothing.

    Parameters
    ----------
    colour : any CSS colour; None where the line has none.
    names : of the line itself (class, id, layer) first, then of the groups around it.
    colours : letters that the user gives, by "#rrggbb" or by name (`parse_colours`).

    What the user gives comes first: by name, then by colour. Next are the words in names, the
    innermost name first: "Mountain folds", "valley_2" and "bergfalten" have one, "layer1" has none,
    and "cut or mountain" contradicts itself and is passed over. Then comes the colour: red is
    mountain (hue 340 to 20), blue valley (200 to 262), black border (or darker than a quarter),
    green cut (80 to 155), yellow a facet crease (45 to 75) and magenta undriven (275 to 332);
    #64c8c8, in which Oriedita draws auxiliary lines, is a facet crease too. Pale and grey ones, and
    hues between these, say nothing. Last are names of creases of any kind
    ("folds"): unassigned.

    >>> letter_of("red", [], {}), letter_of("red", ["CUT"], {}), letter_of("#808080", [], {})
    ('M', 'C', None)
    """
    if (given := given_letter(colour, names, colours)) is not None:
        return given
    found = None if colour is None else colour_of(colour)
    named = [_letter_of_name(name) for name in names]
    strong = next((letter for letter, _ in named if letter), None)
    if strong is not None:
        return strong
    if found is not None and (letter := _letter_of_hue(found[0])) is not None:
        return letter
    return "U" if any(folds for _, folds in named) else None


def given_letter(
    colour: str | None, names: Sequence[str], colours: Mapping[str, str]
) -> str | None:
    """The assignment that the user gives a line, by name, then by colour; see `letter_of`."""
    if not colours:
        return None
    for name in names:
        if (given := colours.get(_key(name))) is not None:
            return given
    return colours.get(key_of(colour or ""))


def parse_colours(text: str) -> dict[str, str]:
    """Letters by colour or name, of a text such as "#ff00aa=mountain,layer-name=cut".

    Colours become "#rrggbb", names lower case; a name of a colour ("red") is both. A letter is one
    of B, M, V, F, U, C, J or a word for it: border, mountain, valley, facet, undriven, cut, join.

    Raises `InvalidValue` for anything else, and for a key with two letters.

    >>> parse_colours("#F0A=mountain,Layer 2=cut")
    {'#ff00aa': 'M', 'layer 2': 'C'}
    """
    out: dict[str, str] = {}
    for entry in re.split(r"[,;](?![^(]*\))", text):
        if not entry.strip():
            continue
        key, equals, word = (part.strip() for part in entry.rpartition("="))
        if not equals or not key or not word:
            raise InvalidValue(
                "colours",
                repr(entry.strip()),
                "be a colour or name, =, and an assignment",
                'Write for example "#ff00aa=mountain,layer-name=cut".',
            )
        letter = _MEANINGS.get(_plain(word))
        if letter is None:
            raise InvalidValue(
                f"colours: assignment of {key!r}",
                repr(word),
                f"be one of {', '.join(_CHOICES)}",
                f"Take one of these words, or a letter of B, M, V, F, U, C, J.{_hint(word)}",
            )
        colour = colour_of(key)
        if colour is None and key.startswith("#"):
            raise InvalidValue(
                "colours", repr(key), "be #rgb or #rrggbb, digits 0 to f", "Correct the colour."
            )
        keys = [] if colour is None else [colour[0]]
        if not key.startswith("#") and (colour is None or "(" not in key):
            keys.append(_key(key))
        for own in keys:
            if out.setdefault(own, letter) != letter:
                raise InvalidValue(
                    "colours", repr(own), "have one assignment", "Remove one of the two entries."
                )
    return out


@dataclass(frozen=True)
class _UnusedColours(Finding):
    """Colours and names that nothing in a file has.

    Attributes
    ----------
    colours : all that the user gives.
    keys : names and colours of all lines of the file.
    """

    colours: Mapping[str, str] = field(default_factory=dict, hash=False)
    keys: frozenset[str] = frozenset()


def unused_colours(colours: Mapping[str, str], keys: Collection[str]) -> list[Finding]:
    """The finding of what the user gives a letter that nothing in a file has.

    colours : of `parse_colours`. keys : of the names and colours of all lines (`key_of`).
    Code: "colours-unused".
    """
    groups: dict[str, list[str]] = {}
    for key in colours:  # a name of a colour is there as both
        found = colour_of(key)
        groups.setdefault(key if found is None else found[0], []).append(key)
    unused = [own[-1] for own in groups.values() if not any(key in keys for key in own)]
    if not unused:
        return []
    listed = ", ".join(map(repr, unused[:_LISTED]))
    listed += f" and {len(unused) - _LISTED} more" if len(unused) > _LISTED else ""
    hint = did_you_mean(unused[0], sorted(keys))
    text = f"--colours: no line of the file has the colour, layer or name {listed}.{hint}"
    plain = Finding("colours-unused", Severity.WARNING, text)
    known = frozenset(keys)
    return [_UnusedColours(plain.code, plain.severity, plain.text, colours=colours, keys=known)]


def unused_in_all(files: Sequence[Sequence[Finding]]) -> list[tuple[Finding, ...]]:
    """Findings of files that are read with the same colours: what one of them has is not unused."""
    unused = [[f for f in found if isinstance(f, _UnusedColours)] for found in files]
    left: list[Finding] = []
    if unused and all(unused):
        keys = frozenset().union(*(own[0].keys for own in unused))
        left = unused_colours(unused[0][0].colours, keys)
    return [
        tuple(f for f in found if not isinstance(f, _UnusedColours)) + tuple(left)
        for found in files
    ]


def key_of(text: str) -> str:
    """What `parse_colours` makes of a colour or a name.

    >>> key_of("red"), key_of("Layer 2")
    ('#ff0000', 'layer 2')
    """
    found = colour_of(text)
    return _key(text) if found is None else found[0]


def unlettered_finding(counts: Mapping[str, int]) -> Finding:
    """The finding of lines without an assignment, by what they are drawn with.

    counts : of lines, by colour or name as the file has it.
    """
    total = sum(counts.values())
    ranked = sorted(counts.items(), key=lambda item: (-item[1], item[0]))
    listed = ", ".join(f"{count} {name}" for name, count in ranked[:_LISTED])
    if len(ranked) > _LISTED:
        rest = sum(count for _, count in ranked[_LISTED:])
        listed += f", {rest} of {len(ranked) - _LISTED} other colours"
    return Finding(
        "colour-unknown",
        Severity.WARNING,
        f"{total} {'line has' if total == 1 else 'lines have'} neither a colour nor a name of an "
        f"assignment: {listed}. Give it with --colours, such as "
        f'--colours "{ranked[0][0]}=mountain".',
    )


def _hint(word: str) -> str:
    return did_you_mean(_plain(word), _CHOICES)


@lru_cache(maxsize=4096)
def _letter_of_name(name: str) -> tuple[str | None, bool]:
    """The letter that a name gives, and whether it names creases of any kind."""
    whole = _plain(name)
    if whole in _SHORT:
        return _SHORT[whole], False
    words = _words(name)
    letters = {_LETTER_OF_WORD[word] for word in words if word in _LETTER_OF_WORD}
    if len(letters) > 1:  # "mountain score", "engraved facets"
        letters = letters & {"M", "V"} or letters - {"U"}
    if letters == {"B", "C"}:  # "cut outline": what is cut at the rim is a border anyway
        letters = {"C"}
    return (letters.pop() if len(letters) == 1 else None), bool(_FOLDS & words)


def _words(name: str) -> frozenset[str]:
    # Adobe Illustrator writes characters that an id cannot have as _x20_ or _x0020_.
    text = re.sub(r"_x([0-9A-Fa-f]{2,4})_", lambda m: chr(int(m[1], 16)), name)
    text = re.sub(r"([a-z])([A-Z])", r"\1 \2", text)
    return frozenset(re.findall(r"[^\W\d_]+", _plain(text)))


def _plain(text: str) -> str:
    """The text in lower case without accents."""
    parts = unicodedata.normalize("NFKD", text.strip().casefold())
    kept = "".join(c for c in parts if unicodedata.category(c) != "Mn" or "\u3040" <= c <= "\u30ff")
    return unicodedata.normalize("NFC", kept)


def _key(name: str) -> str:
    return name.strip().casefold()


@lru_cache(maxsize=4096)
def _letter_of_hue(colour: str) -> str | None:
    if colour == _AUXILIARY:
        return "F"
    red, green, blue = (int(colour[i : i + 2], 16) / 255 for i in (1, 3, 5))
    hue, saturation, value = colorsys.rgb_to_hsv(red, green, blue)
    if value < _BLACK_BELOW:
        return "B"
    if saturation < _LEAST_SATURATION:
        return None
    degrees = hue * 360
    for letter, low, high in _HUES:
        if low <= degrees <= high or low <= degrees + 360 <= high:
            return letter
    return None
