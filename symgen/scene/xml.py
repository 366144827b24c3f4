"""XML text → elements that know their line. Entities, external references and deep nesting are refused."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from io import BytesIO
from xml.sax import SAXException, SAXParseException
from xml.sax.handler import ContentHandler
from xml.sax.xmlreader import AttributesImpl, Locator

import defusedxml.sax
from defusedxml import DefusedXmlException

from symgen.errors import SceneError
from symgen.scene.document import clean

MAX_DEPTH = 60
MAX_ELEMENTS = 200_000
"""Largest file read: a robot has some thousands."""


@dataclass(frozen=True)
class Element:
    """One element: tag, attributes, children, and the line it starts on."""

    tag: str
    attributes: dict[str, str]
    line: int
    children: list[Element] = field(default_factory=list)

    def find(self, tag: str) -> Element | None:
        """The first child called ``tag``."""
        return next(self.all(tag), None)

    def all(self, tag: str) -> Iterator[Element]:
        return (child for child in self.children if child.tag == tag)


class _Handler(ContentHandler):
    def __init__(self, file: str) -> None:
        super().__init__()
        self.file = file
        self.root: Element | None = None
        self.stack: list[Element] = []
        self.count = 0
        self.locator: Locator | None = None

    def setDocumentLocator(self, locator: Locator) -> None:
        self.locator = locator

    def startElement(self, name: str, attrs: AttributesImpl) -> None:
        line = (self.locator.getLineNumber() if self.locator else None) or 1
        element = Element(name, {key: attrs.getValue(key) for key in attrs.getNames()}, line)
        if len(self.stack) >= MAX_DEPTH:
            raise SceneError(f"nested more than {MAX_DEPTH} deep", f"{self.file}:{line}")
        self.count += 1
        if self.count > MAX_ELEMENTS:
            raise SceneError(f"has more than {MAX_ELEMENTS} elements", f"{self.file}:{line}")
        if self.stack:
            self.stack[-1].children.append(element)
        elif self.root is None:
            self.root = element
        self.stack.append(element)

    def endElement(self, name: str) -> None:
        self.stack.pop()


def parse_xml(data: bytes, file: str) -> Element:
    """The root element. Raises SceneError naming file and line."""
    handler = _Handler(file)
    try:
        defusedxml.sax.parse(BytesIO(data), handler)
    except SAXParseException as error:
        raise SceneError(f"not valid XML: {clean(error.getMessage())}", f"{file}:{error.getLineNumber()}") from None
    except DefusedXmlException:
        raise SceneError("declares XML entities, which are not read", file) from None
    except (SAXException, ValueError, LookupError) as error:
        raise SceneError(f"not valid XML: {clean(str(error))}", file) from None
    if handler.root is None:
        raise SceneError("not valid XML: no element", file)
    return handler.root
