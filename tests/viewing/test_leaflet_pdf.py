"""Pages of leaflets: facts beside each other can be told apart."""

from itertools import pairwise

import pypdfium2
from hypothesis import given, settings
from hypothesis import strategies as st

from fab.viewing.leaflet import Facts, Leaflet
from fab.viewing.leaflet_pdf import leaflet_pdf_bytes

MM = 72 / 25.4


@given(st.integers(1, 40))
@settings(max_examples=12, deadline=None)
def test_no_value_comes_near_to_the_name_beside_it(length):
    words = " ".join(["x" * length] * 40)
    facts = Facts((("Printer", words), ("Parts", words)))
    page = pypdfium2.PdfDocument(leaflet_pdf_bytes(Leaflet("m", "quadfold", (facts,))))[0]
    text = page.get_textpage()
    lines = {}
    for number in range(text.count_rects()):
        left, low, right, _ = text.get_rect(number)
        lines.setdefault(round(low), []).append((left, right))
    lines = [sorted(line) for line in lines.values()]
    apart = [second[0] - first[1] for line in lines for first, second in pairwise(line)]
    assert apart
    assert min(apart) >= 3 * MM
