"""Lines and labels of the axes of a plot."""

import xml.etree.ElementTree as ET

from stretch_bt.draw.axes import Frame, columns, rows, words
from stretch_bt.draw.scale import Linear

FRAME = Frame(Linear(0.0, 10.0, 50.0, 450.0), Linear(-1.0, 1.0, 300.0, 20.0))


def elements(drawing):
    return list(ET.fromstring(f"<svg>{drawing}</svg>"))


def test_each_mark_has_a_line_and_a_label_at_its_place():
    drawing = columns([(FRAME.x(2.5), "2.5")], 20, 300, 315) + rows([(FRAME.y(0.0), "0 N")], 50, 450)
    down, below, across, beside = elements(drawing)
    assert (down.get("d"), across.get("d")) == ("M150.0 20V300", "M50 160.0H450")
    assert (below.text, below.get("class"), below.get("x"), below.get("y")) == ("2.5", "c", "150.0", "315.0")
    assert (beside.text, beside.get("class"), beside.get("x"), beside.get("y")) == ("0 N", "r", "44.0", "164.0")


def test_text_is_escaped():
    (text,) = elements(words(1, 2, "a < b & c"))
    assert (text.text, text.get("class")) == ("a < b & c", None)
