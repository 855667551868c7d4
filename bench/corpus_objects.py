"""Objects to furnish a corpus with: measured ones out of graphs, or described from meshes by hand."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from enfilade.descriptors import DEFAULT_LAYOUT, mesh_views, quantise, read_shape
from enfilade.schema.exchange import read_graphs
from enfilade.schema.graph import BuildingGraph, Node
from enfilade.stores import open_store

U16 = NDArray[np.uint16]

SPREAD: Final = 0.4
"""Standard deviation of the logarithm of what each bin is multiplied by: no two scans of a chair are the same."""


@dataclass(frozen=True, slots=True)
class Model:
    """One object as it was measured.

    Attributes
    ----------
    size
        Extent along x y z, metres.
    floor_offset
        Height of its foot over the floor, metres.
    point_count
        Thinned points.
    descriptor, foot_descriptor
        ``(bins,) uint16`` counts.
    """

    size: tuple[float, float, float]
    floor_offset: float
    point_count: int
    descriptor: U16
    foot_descriptor: U16


def measured_models(sources: Sequence[Path | str]) -> list[Model]:
    """Return the single objects with both descriptors in graph files and stores.

    Raises
    ------
    ValueError
        If there are none of the usual shape.
    """
    found = [_model(node.properties) for graph in _graphs(sources) for node in graph.of_label("Object") if _fits(node)]
    if not found:
        raise ValueError(f"no object with descriptors of shape {DEFAULT_LAYOUT.shape} in what was named")
    return found


def described_models(meshes: Path) -> list[Model]:
    """Return what a scanner would see of each mesh in a folder, standing on the floor, from each side."""
    return [model for path in sorted(meshes.glob("*/*.obj")) for model in _seen(path)]


def scanned_again(models: Sequence[Model], chosen: Sequence[int], rng: np.random.Generator) -> Iterator[dict[str, Any]]:
    """Yield the properties of objects that are some of the models, turned and seen a little differently."""
    shape = DEFAULT_LAYOUT.shape
    for index in chosen:
        model = models[index]
        turn = int(rng.integers(shape[2]))
        factor = float(rng.uniform(0.9, 1.1))
        yield {
            "size": [round(side * factor, 3) for side in model.size],
            "floor_offset": round(model.floor_offset, 3),
            "point_count": int(model.point_count * factor**2),
            "descriptor": _again(model.descriptor, turn, rng),
            "foot_descriptor": _again(model.foot_descriptor, turn, rng),
        }


def _again(counts: U16, turn: int, rng: np.random.Generator) -> U16:
    turned = np.roll(counts.reshape(DEFAULT_LAYOUT.shape), turn, axis=2).ravel()
    filled = np.flatnonzero(turned)
    values = np.zeros(len(turned))
    values[filled] = turned[filled] * rng.lognormal(0.0, SPREAD, len(filled))
    return quantise(values)


def _graphs(sources: Iterable[Path | str]) -> Iterator[BuildingGraph]:
    for source in map(str, sources):
        if source.endswith((".json", ".jsonl", ".jsonl.gz")):
            yield from read_graphs(Path(source))
            continue
        with open_store(source, create=False) as store:
            yield from (store.read(summary.id) for summary in store.buildings())


def _fits(node: Node) -> bool:
    bins = [len(node.properties.get(name, ())) for name in ("descriptor", "foot_descriptor")]
    return bins == [DEFAULT_LAYOUT.bins] * 2 and node.properties.get("parts", 1) == 1


def _model(properties: dict[str, Any]) -> Model:
    a, b, c = properties.get("size", (0.5, 0.5, 0.5))
    return Model(
        (a, b, c),
        properties.get("floor_offset", 0.0),
        properties.get("point_count", 1000),
        properties["descriptor"],
        properties["foot_descriptor"],
    )


def _seen(path: Path) -> Iterator[Model]:
    shape = read_shape(path)
    a, b, c = np.ptp(shape.vertices, axis=0).tolist()
    for view in mesh_views(shape):
        yield Model((a, b, c), 0.0, 2000, view, view)
