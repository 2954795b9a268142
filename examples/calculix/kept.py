"""What a run leaves in its folder, and what is checked before it is used again: case.json, ccx/leg*.npz, fields.npz.

A file that is damaged, or was made by a run with other options, raises FileError with the file and what is wrong with it.
"""
import hashlib
import io
import math

import numpy as np

import deck
import history
from shared import files

AGAIN = "start again without --resume"


def write_case(folder, case):
    files.write_json(folder / "case.json", case._asdict())


def read_case(folder):
    """The case that a run was made for."""
    path = folder / "case.json"
    saved = files.read_json(path)
    for name in [*deck.Case._fields, *saved]:
        if name not in saved or name not in deck.Case._fields:
            raise files.FileError(f"{path}: {name} is {'missing' if name not in saved else 'unknown'}: expected "
                                  f"{', '.join(deck.Case._fields)}")
    for name, default in deck.Case._field_defaults.items():
        allowed = {str: str, int: int, float: (int, float)}[type(default)]
        if isinstance(saved[name], bool) or not isinstance(saved[name], allowed):
            raise files.FileError(f"{path}: {name} = {saved[name]!r}: expected {'a text' if allowed is str else 'a number'}")
        if not isinstance(saved[name], str) and not math.isfinite(saved[name]):
            raise files.FileError(f"{path}: {name} = {saved[name]}: expected a finite number")
    if saved["ends"] not in deck.ENDS:
        raise files.FileError(f"{path}: ends = {saved['ends']!r}: expected one of {', '.join(deck.ENDS)}")
    return deck.Case(**saved)


def differences(old, new):
    """What an old case has that a new one has not, in words; empty where they are the same."""
    return "; ".join(f"{name} = {was}, not {now}" for name, was, now in zip(deck.Case._fields, old, new) if was != now)


def programs(ccx, library):
    """The digests of the two programs that a run is made with."""
    return {path.name: digest(files.read_bytes(path)) for path in (ccx, library)}


def write_programs(folder, now):
    files.write_json(folder / "programs.json", now)


def changed_programs(folder, now):
    """The names of the programs that have changed since the run in a folder was made."""
    path = folder / "programs.json"
    then = files.read_json(path) if path.is_file() else now
    return [name for name in now if then.get(name) != now[name]]


def arrays(path, *names):
    """The arrays of a .npz by their names; those of numbers are finite."""
    content = io.BytesIO(files.read_bytes(path))
    try:
        with np.load(content, allow_pickle=False) as kept:
            missing = [name for name in names if name not in kept]
            found = {name: kept[name] for name in names if not missing}
    except Exception:  # zipfile and NumPy raise a dozen kinds for what is damaged
        raise files.FileError(f"{path}: is damaged or cut, or no .npz") from None
    if missing:
        raise files.FileError(f"{path}: has no {', '.join(missing)}")
    for name, values in found.items():
        if values.dtype.kind == "f" and not np.isfinite(values).all():
            at = tuple(int(i) for i in np.argwhere(~np.isfinite(values))[0])
            raise files.FileError(f"{path}: {name}{list(at)} = {values[at]}: expected a finite number")
    return found


def demand_shape(path, name, values, shape):
    """None in the shape: any number."""
    if values.ndim != len(shape) or any(n is not None and n != m for n, m in zip(shape, values.shape)):
        raise files.FileError(f"{path}: {name} has shape {values.shape}: expected {tuple(n or 'any' for n in shape)}")


def digest(content):
    return hashlib.sha256(content).hexdigest()


def write_leg(path, rows, state, inp, frd, restart):
    """A leg that is done: rows of the history, the last state of the Gauss points, and the digests of its deck (a text), its
    .frd and the restart file it has made (None after the last leg), the last of which is returned."""
    digests = [digest(inp.encode("ascii")), *(digest(files.read_bytes(file)) if file else "" for file in (frd, restart))]
    np.savez(path, rows=rows, state=np.asarray(state, dtype=np.float32), digests=digests)
    return digests[-1]


def read_leg(path, inp, frd, points, end):
    """(rows, state, digest of the restart file) of a leg that ends on day `end`, made from the deck with the text `inp`."""
    kept = arrays(path, "rows", "state", "digests")
    rows, state = kept["rows"], kept["state"]
    demand_shape(path, "rows", rows, (None, len(history.COLUMNS)))
    demand_shape(path, "state", state, (points, len(deck.STATE)))
    demand_shape(path, "digests", kept["digests"], (3,))
    made_from, made, restart = kept["digests"].tolist()
    if made_from != digest(inp.encode("ascii")):
        raise files.FileError(f"{path}: was made with another deck (mesh, material, steps) than this program writes: {AGAIN}")
    if len(rows) == 0 or not ends_on(rows[-1][0], end):
        raise files.FileError(f"{path}: ends on day {rows[-1][0] if len(rows) else 0:g}, not on day {end:g}: {AGAIN}")
    if digest(files.read_bytes(frd)) != made:
        raise files.FileError(f"{frd}: is cut, or not the one that this run wrote: {AGAIN}")
    return rows.tolist(), state, restart


def ends_on(time, end):
    """Whether a time that CalculiX has printed with seven digits is `end`."""
    return abs(time - end) <= 1e-6 * end
