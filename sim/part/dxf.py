"""Drawings in DXF, R12 to 2018, read with ezdxf."""

from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import ezdxf
import numpy as np
from ezdxf import units

from .drawn import Drawing, Drawn, Reading, Unit
from .dxf_entities import READERS, NotFlatError

IMPERIAL = (units.IN, units.FT, units.YD, units.MI)
_LAYER_0 = "0"


def read_dxf(file: Path, reading: Reading) -> Drawing:
    """Entities of the model space on the chosen layers.

    Raises ValueError for an entity that cannot be cut, by type, handle and layer, for a unit in
    doubt, and for a file that is no drawing; OSError if it cannot be read.
    """
    try:
        document = ezdxf.readfile(file)  # pyright: ignore[reportPrivateImportUsage]
    except OSError as error:
        if error.errno is not None:
            raise
        raise ValueError("this is no DXF drawing") from error  # as ezdxf says it
    except Exception as error:  # a damaged file fails anywhere in the parser
        raise ValueError(f"this is no DXF drawing: {error}") from error
    return drawing_of(document, reading)


def drawing_of(document: Any, reading: Reading) -> Drawing:
    """As `read_dxf`, of a document of ezdxf."""
    scale = _metres(document, reading.unit)
    reading.check_layers([layer.dxf.name for layer in document.layers])
    left_out: Counter[str] = Counter()
    found: list[Drawn] = []
    for entity, layer, name in _entities(document.modelspace()):
        if not reading.chooses(layer, _visible(document, entity, layer)):
            left_out[layer] += 1
            continue
        found.append(_read(entity, layer, name, scale))
    notes = [
        f"layer {layer} is not cut: {n} {'entity' if n == 1 else 'entities'}"
        for layer, n in sorted(left_out.items())
    ]
    if n := sum(e.dxftype() != "VIEWPORT" for view in document.layouts for e in _of_paper(view)):
        notes.append(f"{n} entities of paper space are not cut")
    return Drawing(tuple(found), tuple(notes))


def _of_paper(layout: Any) -> list[Any]:
    return list(layout) if layout.is_any_paperspace else []


def _read(entity: Any, layer: str, name: str, scale: float) -> Drawn:
    reader = READERS.get(entity.dxftype())
    said = f"{name} on layer {layer}"
    if reader is None:
        raise ValueError(f"{said} cannot be cut; choose the layers to cut, or remove it")
    try:
        chain = reader(entity, scale)
    except NotFlatError as error:
        raise ValueError(f"{said} is not drawn in the x-y plane") from error
    except ValueError as error:
        raise ValueError(f"{said}: {error}") from error
    if not np.isfinite(chain.points).all():
        raise ValueError(f"{said} has coordinates that are not finite")
    return Drawn(chain, name, layer)


def _entities(container: Any, layer: str = "", name: str = "") -> Iterator[tuple[Any, str, str]]:
    """Entities, their layers and names, blocks taken apart. Layer 0 of a block is its insert's."""
    for entity in container:
        own = _layer_of(entity)
        effective = layer if layer and own == _LAYER_0 else own
        said = f"{entity.dxftype()}{name or f' #{entity.dxf.handle}'}"
        if entity.dxftype() != "INSERT":
            yield entity, effective, said
            continue
        within = name or f" of INSERT #{entity.dxf.handle}"
        yield from ((a, a.dxf.layer, f"ATTRIB{within}") for a in entity.attribs)
        for each in entity.multi_insert() if entity.mcount > 1 else [entity]:
            yield from _entities(_parts(each, effective, within), effective, within)


def _layer_of(entity: Any) -> str:
    """Layer of an entity, of types that ezdxf does not know as well."""
    if entity.dxf.is_supported("layer"):
        return entity.dxf.get("layer", _LAYER_0)
    tags = entity.xtags
    own = tags.get_subclass("AcDbEntity") if tags.has_subclass("AcDbEntity") else tags.noclass
    return str(own.get_first_value(8, _LAYER_0))


def _parts(insert: Any, layer: str, within: str) -> list[Any]:
    block = insert.block()
    if block is None or block.block.is_xref:
        what = "is not in the file" if block is None else "is another file (XREF)"
        raise ValueError(f"block {insert.dxf.name!r}{within} on layer {layer} {what}")
    skipped: list[str] = []
    parts = list(
        insert.virtual_entities(
            skipped_entity_callback=lambda entity, _: skipped.append(entity.dxftype())
        )
    )
    if skipped:
        raise ValueError(f"{skipped[0]}{within} on layer {layer} cannot be cut; remove it")
    return parts


def _visible(document: Any, entity: Any, layer: str) -> bool:
    known = entity.dxf.is_supported("invisible")
    if known and entity.dxf.get("invisible", 0):
        return False
    if layer not in document.layers:
        return True
    found = document.layers.get(layer)
    return not (found.is_off() or found.is_frozen())


def _metres(document: Any, chosen: Unit | None) -> float:
    """Metres per unit of a drawing. ValueError where millimetres and inches are in doubt."""
    if chosen is not None:
        return chosen.metres
    own, system = document.units, document.header.get("$MEASUREMENT", None)
    if not own:
        raise ValueError("its unit is not stated ($INSUNITS): say --units mm or --units inch")
    scale = units.conversion_factor(own, units.M)  # pyright: ignore[reportArgumentType]
    said = units.unit_name(own)
    if own in (units.MM, units.IN) and system is not None and (own in IMPERIAL) == bool(system):
        other = "metric" if system else "imperial"
        raise ValueError(
            f"its unit is in doubt: $INSUNITS says {said}, $MEASUREMENT says {other}; say "
            "--units mm or --units inch"
        )
    return float(scale)
