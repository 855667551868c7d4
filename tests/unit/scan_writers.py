"""Writers of small scan files in every format, for tests."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

import laspy
import numpy as np
import pye57

Array = np.ndarray


@dataclass(frozen=True)
class Station:
    """One scan: points in the common coordinates, where the scanner stood and how it was turned about z."""

    positions: Array
    scanner: Array
    turn: float = 0.0
    name: str = "Station"
    intensity: Array | None = None
    colour: Array | None = None
    time: Array | None = field(default=None)

    @property
    def rotation(self) -> Array:
        c, s = np.cos(self.turn), np.sin(self.turn)
        return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])

    @property
    def local(self) -> Array:
        with np.errstate(invalid="ignore"):
            return (self.positions - self.scanner) @ self.rotation

    @property
    def quaternion(self) -> Array:
        return np.array([np.cos(self.turn / 2), 0.0, 0.0, np.sin(self.turn / 2)])


def write_e57(path: Path, *stations: Station) -> Path:
    with pye57.E57(str(path), mode="w") as file:
        for station in stations:
            columns = {f"cartesian{a}": station.local[:, i].copy() for i, a in enumerate("XYZ")}
            if station.intensity is not None:
                columns["intensity"] = station.intensity.astype("f8")
            if station.colour is not None:
                columns |= {f"color{c}": station.colour[:, i].copy() for i, c in enumerate(("Red", "Green", "Blue"))}
            file.write_scan_raw(columns, name=station.name, rotation=station.quaternion, translation=station.scanner)
    return path


def write_ptx(path: Path, *stations: Station) -> Path:
    with path.open("w") as file:
        for station in stations:
            pose = np.eye(4)
            pose[:3, :3], pose[3, :3] = station.rotation.T, station.scanner
            header = [station.scanner, *pose[:3, :3], *pose]
            file.write(f"{len(station.positions)}\n1\n")
            file.writelines(" ".join(repr(float(v)) for v in row) + "\n" for row in header)
            np.savetxt(file, np.column_stack(_columns(station, station.local)), fmt="%.7g")
    return path


def _columns(station: Station, positions: Array) -> list[Array]:
    intensity = np.full(len(positions), 0.5) if station.intensity is None else station.intensity
    return [positions, intensity] + ([] if station.colour is None else [station.colour])


def write_ply(path: Path, station: Station, form: str = "binary_little_endian", kind: str = "f8") -> Path:
    row = [(axis, kind) for axis in "xyz"]
    names = {"f8": "double", "f4": "float", "u1": "uchar"}
    if station.intensity is not None:
        row += [("intensity", "f4")]
    if station.colour is not None:
        row += [(channel, "u1") for channel in ("red", "green", "blue")]
    properties = [f"property {names[type]} {name}" for name, type in row]
    lines = ["ply", f"format {form} 1.0", f"element vertex {len(station.positions)}", *properties, "end_header"]
    columns = np.column_stack([c for c in (station.positions, station.intensity, station.colour) if c is not None])
    with path.open("wb") as file:
        file.write(("\n".join(lines) + "\n").encode())
        if form == "ascii":
            np.savetxt(file, columns, fmt="%.9g")
        else:
            order = "<" if "little" in form else ">"
            table = np.empty(len(columns), [(name, order + type) for name, type in row])
            for name, column in zip(table.dtype.names, columns.T, strict=True):
                table[name] = column
            table.tofile(file)
    return path


def write_pcd(path: Path, station: Station, form: str = "binary", *, viewpoint: bool = True) -> Path:
    row = [*((axis, "<f8") for axis in "xyz"), *([] if station.intensity is None else [("intensity", "<f4")])]
    row += [] if station.colour is None else [("rgb", "<u4")]
    table = np.zeros(len(station.positions), row)
    for axis, name in enumerate("xyz"):
        table[name] = station.positions[:, axis]
    if station.intensity is not None:
        table["intensity"] = station.intensity
    if station.colour is not None:
        red, green, blue = station.colour.T.astype(np.uint32)
        table["rgb"] = red << 16 | green << 8 | blue
    x, y, z = station.scanner if viewpoint else (0.0, 0.0, 0.0)
    kinds = [np.dtype(type) for _, type in row]
    lines = [
        "# .PCD v0.7",
        "VERSION 0.7",
        "FIELDS " + " ".join(name for name, _ in row),
        "SIZE " + " ".join(str(kind.itemsize) for kind in kinds),
        "TYPE " + " ".join(kind.kind.upper() for kind in kinds),
        "COUNT " + " ".join("1" for _ in row),
        f"WIDTH {len(table)}",
        "HEIGHT 1",
        f"VIEWPOINT {x!r} {y!r} {z!r} 1 0 0 0".replace("np.float64(", "").replace(")", ""),
        f"POINTS {len(table)}",
        f"DATA {form}",
    ]
    with path.open("wb") as file:
        file.write(("\n".join(lines) + "\n").encode())
        if form == "ascii":
            np.savetxt(file, np.column_stack([table[name] for name, _ in row]), fmt="%.9g")
        elif form == "binary":
            table.tofile(file)
        else:
            whole = b"".join(table[name].tobytes() for name, _ in row)
            packed = lzf(whole)
            np.array([len(packed), len(whole)], "<u4").tofile(file)
            file.write(packed)
    return path


def lzf(whole: bytes) -> bytes:
    """Compress: literals, and references where the last three bytes were seen a little before."""
    packed, literal, at = bytearray(), bytearray(), 0
    last: dict[bytes, int] = {}

    def flush() -> None:
        for start in range(0, len(literal), 32):
            part = literal[start : start + 32]
            packed.append(len(part) - 1)
            packed.extend(part)
        literal.clear()

    while at < len(whole):
        three = whole[at : at + 3]
        seen = last.get(three, -1) if len(three) == 3 else -1
        last[three] = at
        if seen < 0 or at - seen > 8191:
            literal.append(whole[at])
            at += 1
            continue
        length = 3
        while length < 264 and at + length < len(whole) and whole[at + length] == whole[seen + length]:
            length += 1
        flush()
        back, coded = at - seen - 1, length - 2
        packed.append(min(coded, 7) << 5 | back >> 8)
        if coded >= 7:
            packed.append(coded - 7)
        packed.append(back & 255)
        at += length
    flush()
    return bytes(packed)


def write_las(path: Path, station: Station, *, wide_colour: bool = True) -> Path:
    header = laspy.LasHeader(point_format=3, version="1.2")
    header.offsets, header.scales = np.floor(station.positions.min(axis=0)), np.full(3, 1e-5)
    las = laspy.LasData(header)
    las.x, las.y, las.z = station.positions.T
    if station.intensity is not None:
        las.intensity = station.intensity.astype(np.uint16)
    if station.colour is not None:
        las.red, las.green, las.blue = station.colour.T.astype(np.uint16) * (257 if wide_colour else 1)
    if station.time is not None:
        las.gps_time = station.time
    las.write(str(path))
    return path


def write_positions(path: Path, stations: Sequence[tuple[str, Array]], by: str = "file") -> Path:
    lines = [f"{by},x,y,z", *(f"{name},{','.join(repr(float(v)) for v in place)}" for name, place in stations)]
    path.write_text("\n".join(lines) + "\n")
    return path
