"""XML files: read whole, without what could make a small one large, and written."""

from __future__ import annotations

from io import BytesIO
from xml.etree import ElementTree
from xml.etree.ElementTree import Element, ParseError, TreeBuilder, XMLParser
from xml.parsers import expat

from lanindex.errors import NotationError, shown

_DEEPEST = 100
"""Elements inside elements: those of notations are a dozen."""


def parse(content: bytes, place: str, root: str) -> Element:
    """Return the root of an XML file, comments inside it kept."""
    try:
        _look(content, place)
        builder = TreeBuilder(insert_comments=True, insert_pis=True)
        document = ElementTree.parse(BytesIO(content), XMLParser(target=builder)).getroot()
    except expat.ExpatError as error:
        found = f"damaged XML ({expat.ErrorString(error.code)})"
        where = f"{place}:{error.lineno}"
        raise NotationError(found, place=where, wanted="a whole file") from error
    except (ParseError, ValueError, LookupError) as error:
        raise NotationError(f"XML that cannot be read ({error})", place=place) from error
    if document.tag != root:
        found = f"XML of <{shown(document.tag)}>"
        raise NotationError(found, place=place, wanted=f"<{root}>")
    return document


def _look(content: bytes, place: str) -> None:
    """Refuse declarations of what stands for other text, and elements too deep to be meant."""
    depth = 0
    parser = expat.ParserCreate()

    def declared(*_: object) -> None:
        line = parser.CurrentLineNumber
        raise NotationError("a DTD", place=f"{place}:{line}", wanted="XML without one")

    def begun(*_: object) -> None:
        nonlocal depth
        depth += 1
        if depth > _DEEPEST:
            line = parser.CurrentLineNumber
            found = f"more than {_DEEPEST} elements inside each other"
            raise NotationError(found, place=f"{place}:{line}", wanted="fewer")

    def ended(_: str) -> None:
        nonlocal depth
        depth -= 1

    parser.StartDoctypeDeclHandler = declared
    parser.StartElementHandler, parser.EndElementHandler = begun, ended
    parser.Parse(content, True)


def written(root: Element) -> bytes:
    """Return a document as a file, one element a line."""
    ElementTree.indent(root, "    ")
    content: bytes = ElementTree.tostring(root, "UTF-8", xml_declaration=True)
    return content + b"\n"
