"""XML from files that anybody may have written: no entities, no document types, nothing fetched."""

from pathlib import Path
from xml.etree.ElementTree import Element

from alloc.errors import FileError, NotInstalled, VehicleError
from alloc.files.textfile import read_text

LARGEST = 5_000_000  # bytes; a robot's description has some hundred thousand
DEEPEST = 100


def read_xml(path: Path) -> Element:
    """The root of a file; raises FileError, NotInstalled, and VehicleError for xacro, which is none yet."""
    text = read_text(path, LARGEST)
    try:
        from defusedxml import ElementTree
        from defusedxml.common import DefusedXmlException
    except ImportError:
        raise NotInstalled("reading URDF and SDF needs defusedxml; pip install 'thrustbench[urdf]'") from None
    try:
        root: Element = ElementTree.fromstring(text.encode(), forbid_dtd=True)
    except DefusedXmlException as error:
        raise FileError(
            f"holds {type(error).__name__}; take out <!DOCTYPE> and entities", path=path
        ) from None
    except (ElementTree.ParseError, ValueError, LookupError) as error:  # ValueError: an unknown encoding
        line = getattr(error, "position", (None,))[0]
        raise FileError(f"not XML ({str(error)[:60]}); mend it", path=path, line=line) from None
    if _depth(root) > DEEPEST:
        raise FileError(f"is nested deeper than {DEEPEST} elements; a robot's description is not", path=path)
    if any("xacro" in str(element.tag) for element in root.iter()) or "$(" in text or "${" in text:
        stem = path.name.partition(".")[0]
        # A shell empties the target before xacro reads: it must be another file.
        target = f"{stem}-expanded.urdf" if path.name == f"{stem}.urdf" else f"{stem}.urdf"
        raise VehicleError(f"{path}: is xacro, which makes a description; expand it: xacro {path} > {target}")
    return root


def _depth(root: Element) -> int:
    deepest, level = 0, [root]
    while level and deepest <= DEEPEST:
        deepest, level = deepest + 1, [child for element in level for child in element]
    return deepest
