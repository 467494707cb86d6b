"""XML of notation files."""

from io import BytesIO
from xml.etree import ElementTree
from xml.etree.ElementTree import Element, ParseError, TreeBuilder, XMLParser
from xml.parsers import expat

from lanindex.errors import shown
from lanindex.notation.text import refuse

_DEEPEST = 100  # elements inside elements: those of notations are a dozen


def parse_xml(content: bytes, place: str, root: str) -> Element:
    """Return the root of an XML file, comments inside it kept."""
    try:
        _look(content, place)
        builder = TreeBuilder(insert_comments=True, insert_pis=True)
        document = ElementTree.parse(BytesIO(content), XMLParser(target=builder)).getroot()
    except expat.ExpatError as error:
        found = f"damaged XML ({expat.ErrorString(error.code)})"
        refuse(f"{place}:{error.lineno}", found, "a whole file")
    except (ParseError, ValueError, LookupError) as error:
        refuse(place, f"XML that cannot be read ({error})")
    if document.tag != root:
        refuse(place, f"XML of <{shown(document.tag)}>", f"<{root}>")
    return document


def _look(content: bytes, place: str) -> None:
    """Refuse DTDs and elements nested too deep."""
    depth = 0
    parser = expat.ParserCreate()

    def declared(*_: object) -> None:
        line = parser.CurrentLineNumber
        refuse(f"{place}:{line}", "a DTD", "XML without one")

    def begun(*_: object) -> None:
        nonlocal depth
        depth += 1
        if depth > _DEEPEST:
            line = parser.CurrentLineNumber
            refuse(f"{place}:{line}", f"more than {_DEEPEST} elements inside each other", "fewer")

    def ended(_: str) -> None:
        nonlocal depth
        depth -= 1

    parser.StartDoctypeDeclHandler = declared
    parser.StartElementHandler, parser.EndElementHandler = begun, ended
    parser.Parse(content, True)


def write_xml(root: Element) -> bytes:
    """Return a document as a file, one element a line."""
    ElementTree.indent(root, "    ")
    content: bytes = ElementTree.tostring(root, "UTF-8", xml_declaration=True)
    return content + b"\n"
