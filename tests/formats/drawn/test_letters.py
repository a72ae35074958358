"""Colours and names of lines give assignments."""

import pytest

from fab.formats.drawn.letters import (
    colour_of,
    key_of,
    letter_of,
    parse_colours,
    unlettered_finding,
    unused_colours,
)
from solver.errors import InvalidValue


@pytest.mark.parametrize(
    ("colour", "letter"),
    [
        ("#ff0000", "M"),
        ("#F00", "M"),
        ("#f008", "M"),
        ("#ff0000ff", "M"),
        ("red", "M"),
        ("Crimson", "M"),
        ("rgb(255,0,0)", "M"),
        ("rgb(100% 0% 0%)", "M"),
        ("#ed1c24", "M"),
        ("#e14929", "M"),
        ("#0000ff", "V"),
        ("royalblue", "V"),
        ("hsl(240, 100%, 50%)", "V"),
        ("#2e3192", "V"),
        ("#314f69", "V"),
        ("black", "B"),
        ("#231F20", "B"),
        ("rgb(0,0,0)", "B"),
        ("#00ff00", "C"),
        ("green", "C"),
        ("#00A651", "C"),
        ("yellow", "F"),
        ("#fff200", "F"),
        ("#64c8c8", "F"),
        ("magenta", "U"),
        ("#ec008c", "U"),
        ("orange", None),
        ("#808080", None),
        ("white", None),
        ("cyan", None),
        ("pink", None),
        ("#8b4513", None),
        ("none", None),
        ("url(#grid)", None),
        ("var(--line)", None),
        ("#12", None),
    ],
)
def test_colours(colour, letter):
    assert letter_of(colour, [], {}) == letter


@pytest.mark.parametrize(
    ("name", "letter"),
    [
        ("Mountain", "M"),
        ("MOUNTAIN FOLDS", "M"),
        ("mountain_2", "M"),
        ("mountainFold", "M"),
        ("valley-creases", "V"),
        ("Cut_x0020_lines", "C"),
        ("cut outline", "C"),
        ("m", "M"),
        ("V", "V"),
        ("Outline", "B"),
        ("boundary", "B"),
        ("engrave", "U"),
        ("Score mountain", "M"),
        ("Vallée", "V"),
        ("pli montagne", "M"),
        ("Bergfalten", "M"),
        ("Talfalte 3", "V"),
        ("monte", "M"),
        ("valle", "V"),
        ("yama-ori", "M"),
        ("tani", "V"),
        ("山折り", "M"),
        ("谷", "V"),
        ("auxiliary", "F"),
        ("layer1", None),
        ("mountain or valley", None),
        ("shortcut", None),
        ("creases", "U"),
    ],
)
def test_names(name, letter):
    assert letter_of(None, [name], {}) == letter


def test_what_comes_first():
    assert letter_of("red", ["CUT"], {}) == "C"
    assert letter_of("red", ["layer1", "valley", "CUT"], {}) == "V"
    assert letter_of("red", ["creases"], {}) == "M"
    assert letter_of("#808080", ["creases"], {}) == "U"
    assert letter_of("#FF0000", ["CUT"], {"#ff0000": "V"}) == "V"
    assert letter_of("red", ["CUT"], {"cut": "F", "#ff0000": "V"}) == "F"


def test_alpha():
    assert colour_of("rgb(255 0 0 / 25%)") == ("#ff0000", 0.25)
    assert colour_of("transparent") == ("#000000", 0.0)


def test_colours_of_the_user():
    found = parse_colours("#F0A=mountain, Layer 2 = Cut;rgb(1, 2, 3)=v,red=F,a=b=hinge,")
    assert found == {
        "#ff00aa": "M",
        "layer 2": "C",
        "#010203": "V",
        "#ff0000": "F",
        "red": "F",
        "a=b": "U",
    }
    assert parse_colours("") == {}


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("red", "be a colour or name"),
        ("=cut", "be a colour or name"),
        ("#12=cut", "#rgb"),
        ("a=montain", "Did you mean mountain?"),
        ("a=cut,A=valley", "one assignment"),
    ],
)
def test_wrong_colours_of_the_user(text, words):
    with pytest.raises(InvalidValue) as error:
        parse_colours(text)
    assert words in str(error.value)


def test_the_finding_lists_the_commonest_and_counts_the_rest():
    finding = unlettered_finding({f"#00000{n}": n for n in range(1, 10)})
    assert finding.text.startswith("45 lines have")
    assert "9 #000009" in finding.text
    assert "6 of 3 other colours" in finding.text
    assert '--colours "#000009=mountain"' in finding.text


def test_colours_that_nothing_has_are_named():
    colours = parse_colours("red=mountain,#00F=valley,blue layer=valley,navy=cut")
    keys = {key_of(text) for text in ("Red", "#000080", "blue Layers")}
    (finding,) = unused_colours(colours, keys)
    assert "name '#0000ff', 'blue layer'" in finding.text
    assert unused_colours(colours, keys | {"#0000ff", "blue layer"}) == []
    (finding,) = unused_colours(parse_colours("blue layer=valley"), keys)
    assert "Did you mean blue layers?" in finding.text


def test_layers_with_parentheses_and_paints_without_a_colour_are_named():
    colours = parse_colours("folds (M)=mountain,var(--v)=valley,rgb(1, 2, 3)=cut")
    assert letter_of("#888", ["Folds (M)"], colours) == "M"
    assert letter_of("var(--v)", [], colours) == "V"
    assert letter_of("#010203", [], colours) == "C"
    assert letter_of("red icc-color(cmyk, 0, 1, 1, 0)", [], {}) == "M"
