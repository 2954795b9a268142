"""Reading, writing and checking for all Python programs here, so that nothing fails silently.

    with files.faults_in_one_line("cylinder.py"):       # around main(): no traceback for a full disk or a bad file
        folder = files.make_folder(path)                # made, and tried, before the work starts
        files.write_text(folder / "tables.md", text)    # whole or not at all; an error names file and reason
        for line, row in files.rows("history.csv", ["time", "G"]): ...

Whatever is wrong becomes a FileError whose text names the file, the line and the column, what stands there and what is
allowed. Needs Python 3.9 and nothing else.
"""
import argparse
import contextlib
import csv
import errno
import io
import json
import math
import os
import pathlib
import re
import stat
import subprocess
import sys
import tempfile

FULL = (errno.ENOSPC, errno.EFBIG, errno.EDQUOT, errno.EIO)
TRIAL = 65536  # bytes, written on trial where results are to go
MOST_OF_DEVICE = 2**28  # bytes


class FileError(ValueError):
    """A file that cannot be read or written, or does not hold what it should. The text is meant for users."""


def reason(error):
    """Why the system refused, in its own words."""
    return error.strerror or str(error) or type(error).__name__


def shown(text, length=60):
    """A text as one can see it: quoted, what does not print by its code, and cut where it is long."""
    text = text if len(text) <= length else text[:length] + "…"
    return "'" + "".join(c if c.isprintable() else c.encode("unicode_escape").decode() for c in text) + "'"


# ---- Programs

@contextlib.contextmanager
def faults_in_one_line(program, *more):
    """Around main(): ends the program with status 1 and one line on standard error for files, results of other programs,
    and the exceptions in `more`. What was printed must have arrived as well."""
    if sys.stdout is None:
        sys.exit(f"{program}: standard output is closed")
    if isinstance(sys.stdout, io.TextIOWrapper):  # what the terminal's encoding does not have is shown by its code
        sys.stdout.reconfigure(errors="backslashreplace")
    try:
        yield
        sys.stdout.flush()
    except BrokenPipeError:  # `| head`: the reader has ended, and needs no message
        _drop_standard_output()
        sys.exit(1)
    except subprocess.CalledProcessError as e:
        command = e.cmd if isinstance(e.cmd, (str, os.PathLike)) else e.cmd[0]
        said = e.stderr.decode(errors="replace") if isinstance(e.stderr, bytes) else e.stderr or ""
        sys.exit(f"{program}: {command} {ended(e.returncode)}" + (f":\n{said.strip()}" if said.strip() else ""))
    except OSError as e:
        if e.filename is not None:
            sys.exit(f"{program}: {os.fspath(e.filename)}: {reason(e)}")
        if e.errno not in FULL:
            sys.exit(f"{program}: {reason(e)}")
        _drop_standard_output()  # files have names: see writing()
        sys.exit(f"{program}: standard output cannot be written: {reason(e)}")
    except (FileError, MemoryError, *more) as e:
        sys.exit(f"{program}: {e or 'not enough memory'}")


def _drop_standard_output():
    """So that Python does not try to write it once more, and complain, at its end."""
    with contextlib.suppress(OSError, ValueError):
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def ended(status):
    """How a program ended: `ended with status 3`, or `was killed by signal 9 (Killed)`."""
    if status >= 0:
        return f"ended with status {status}"
    import signal

    return f"was killed by signal {-status} ({signal.strsignal(-status)})"


def number(low=None, high=None, *, above=None, below=None, kind=float):
    """A type for argparse: a finite number within these limits, which the message names."""
    limits = [f"{sign} {limit:.12g}" for sign, limit in ((">", above), (">=", low), ("<", below), ("<=", high))
              if limit is not None]
    allowed = ("a whole number " if kind is int else "a finite number ") + " and ".join(limits)

    def parse(text):
        try:
            if "_" in text:
                raise ValueError
            x = kind(text)
        except ValueError:
            hint = ": write a decimal point" if re.fullmatch(r"\s*[-+]?\d*,\d+\s*", text) else ""
            raise argparse.ArgumentTypeError(f"{shown(text)}: must be {allowed.strip()}{hint}") from None
        if not (math.isfinite(x) and (low is None or x >= low) and (high is None or x <= high)
                and (above is None or x > above) and (below is None or x < below)):
            raise argparse.ArgumentTypeError(f"{text}: must be {allowed.strip()}")
        return x

    return parse


# ---- Writing

def make_folder(path):
    """Makes a folder where there is none, and tries whether files can be written there."""
    path = pathlib.Path(path)
    try:
        path.mkdir(parents=True, exist_ok=True)
        with tempfile.NamedTemporaryFile(dir=path, prefix="trial_") as trial:
            trial.write(bytes(TRIAL))
            trial.flush()
    except FileExistsError:
        raise FileError(f"{path}: cannot be made a folder: there is a file of that name") from None
    except NotADirectoryError:
        raise FileError(f"{path}: cannot be made a folder: a part of its name is a file") from None
    except OSError as e:
        raise FileError(f"{path}: cannot be written to: {reason(e)}") from None
    return path


@contextlib.contextmanager
def writing(path):
    """Gives the name to write to, and renames that file to `path` when all of it is written: `path` is the old file or the
    new one, never a part. Devices and pipes are written directly."""
    path = pathlib.Path(path)
    try:
        exists = path.exists()
        direct = exists and not stat.S_ISREG(path.stat().st_mode)
        if path.is_dir():
            raise FileError(f"{path}: cannot be written: it is a folder")
        target = path if direct else path.resolve()
        part = path if direct else target.with_name(f"part_{os.getpid()}_{target.name}")  # same suffix: it selects the format
    except OSError as e:
        raise FileError(f"{path}: cannot be written: {reason(e)}") from None
    try:
        yield part
        if not direct:
            if exists:
                os.chmod(part, stat.S_IMODE(target.stat().st_mode))
            with open(part, "rb") as f:  # a file system may tell only now that it is full
                os.fsync(f.fileno())
            os.replace(part, target)
    except OSError as e:
        if e.filename is not None and os.fspath(e.filename) != os.fspath(part):
            raise  # another file's
        raise FileError(f"{path}: cannot be written: {reason(e)}") from None
    finally:
        if not direct:
            with contextlib.suppress(OSError):
                part.unlink()


def write_text(path, text, encoding="utf-8"):
    """A text file, lines as they are."""
    with writing(path) as part, open(part, "w", encoding=encoding, newline="\n") as f:
        f.write(text)


def write_text_or_print(path, text, encoding="utf-8", source=None):
    """To the file, or to standard output where `path` is None. `source` is the file that the text was made from."""
    if path and source and os.path.exists(path) and os.path.samefile(path, source):
        raise FileError(f"{path}: cannot be written: it is the file that was read")
    if path is None:
        sys.stdout.write(text)
    else:
        write_text(path, text, encoding)


def write_json(path, value, indent=1):
    write_text(path, json.dumps(value, indent=indent) + "\n")


def write_csv(path, columns, rows):
    with writing(path) as part, open(part, "w", encoding="utf-8", newline="") as f:
        table = csv.writer(f, lineterminator="\n")
        table.writerow(columns)
        table.writerows(rows)


def remove(paths):
    """Results of an older run, so that they are not taken for those of this one."""
    for path in paths:
        try:
            path.unlink(missing_ok=True)
        except OSError as e:
            raise FileError(f"{path}: an older run's, cannot be removed: {reason(e)}") from None


_locks = []  # open as long as the program runs


def lock(path):
    """Keeps others from the folder of this file until this program ends, and those it starts with `pass_fds=locks()`."""
    import fcntl

    _locks.append(open(path, "a"))
    try:
        fcntl.flock(_locks[-1], fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        raise FileError(f"{path.parent}: another run is at work there") from None
    except OSError:  # a file system without locks
        pass


def locks():
    """For `pass_fds` of a program that writes to a locked folder, and may outlive us if we are killed."""
    return [f.fileno() for f in _locks]


# ---- Reading

def read_bytes(path, offset=0):
    """A file from `offset` on, whole; an OSError has its name. Of a device or a pipe, which may have no end, at most
    MOST_OF_DEVICE."""
    try:
        with open(path, "rb") as f:
            if stat.S_ISREG(os.fstat(f.fileno()).st_mode):
                f.seek(offset)
                return f.read()
            data = f.read(MOST_OF_DEVICE + 1)[offset:]
    except OSError as e:
        e.filename = e.filename or os.fspath(path)
        raise
    if len(data) > MOST_OF_DEVICE:
        raise FileError(f"{path}: is no file, and larger than {MOST_OF_DEVICE >> 20} MiB")
    return data


def read_text(path):
    """UTF-8 (or ASCII) with or without a byte-order mark; ends of lines become \\n."""
    raw = read_bytes(path)
    if raw[:2] in (b"\xff\xfe", b"\xfe\xff"):
        raise FileError(f"{path}: is UTF-16: save it as UTF-8 or ASCII")
    try:
        text = raw.decode("utf-8-sig")
    except UnicodeDecodeError as e:
        line = raw.count(b"\n", 0, e.start) + 1
        raise FileError(f"{path}:{line}: byte {raw[e.start]:#04x} is not UTF-8: save it as UTF-8 or ASCII") from None
    if "\0" in text:
        line = text.count("\n", 0, text.index("\0")) + 1
        raise FileError(f"{path}:{line}: has a byte of value 0: expected a text file")
    return text.replace("\r\n", "\n").replace("\r", "\n")


def read_json(path, wanted=dict):
    """A JSON file with an object (or what `wanted` says) at its top."""
    try:
        value = json.loads(read_text(path))
    except json.JSONDecodeError as e:
        raise FileError(f"{path}:{e.lineno}: column {e.colno}: is damaged or no JSON: {e.msg}") from None
    except RecursionError:
        raise FileError(f"{path}: is no JSON of ours: nested too deeply") from None
    if not isinstance(value, wanted):
        raise FileError(f"{path}: expected {'an object' if wanted is dict else 'a list'}, is {shown(json.dumps(value))}")
    return value


def rows(path, columns, comment="#"):
    """(line, fields) of a table of comma-separated values whose header is `columns`.

    Blank lines, what follows `comment`, blanks around fields, and the trailing commas of spreadsheets are skipped. At
    least one row is needed. Semicolons and decimal commas are named as such.
    """
    found, headed = [], False
    for line, text in enumerate(read_text(path).split("\n"), 1):
        text = text.split(comment)[0] if comment else text
        try:
            fields = [field.strip() for field in next(csv.reader([text], strict=True), [])]
        except csv.Error as e:
            raise FileError(f"{path}:{line}: {shown(text)}: cannot be split at its commas: {e}") from None
        while len(fields) > (len(columns) if headed else 0) and not fields[-1]:
            fields.pop()
        if not any(fields):
            continue
        if ";" in text:
            raise FileError(f"{path}:{line}: {shown(text)}: expected commas between the columns, not semicolons (and decimal "
                            "points, not decimal commas)")
        if not headed:
            if fields != list(columns):
                raise FileError(f"{path}:{line}: {shown(','.join(fields))}: expected the header {','.join(columns)}")
            headed = True
            continue
        if len(fields) != len(columns):
            hint = "; numbers need a decimal point, not a decimal comma" if len(fields) > len(columns) else ""
            raise FileError(f"{path}:{line}: {len(fields)} values: expected {len(columns)}, {', '.join(columns)}{hint}")
        found.append((line, fields))
    if not found:
        what = "rows below the header" if headed else "the header " + ",".join(columns)
        raise FileError(f"{path}: is empty: expected {what}" if not headed else f"{path}: expected {what}")
    return found


def finite(path, line, column, text):
    """The number that a field of a table has."""
    try:
        x = float(text) if "_" not in text else math.nan
        if math.isfinite(x):
            return x
        expected = "expected a finite number"
    except ValueError:
        expected = "expected a finite number"
        if re.fullmatch(r"[-+]?\d*,\d+([eE][-+]?\d+)?", text):
            expected += ", with a decimal point"
    if not text:
        raise FileError(f"{path}:{line}: {column} is missing: {expected}")
    raise FileError(f"{path}:{line}: {column} = {shown(text)}: {expected}")


def read_columns(path, columns):
    """{column: [numbers]} of a table in which all is numbers."""
    table = [[finite(path, line, *pair) for pair in zip(columns, fields)] for line, fields in rows(path, columns)]
    return {name: list(values) for name, values in zip(columns, zip(*table))}
