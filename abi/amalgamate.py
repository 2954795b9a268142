"""Writes a source file and the headers of ours that it includes as one file, in plain ASCII.

amalgamate.py SOURCE OUTPUT INCLUDE_FOLDER VERSION
"""
import pathlib
import re
import sys

BANNER = """// myogrowth {version}: the UMAT in one file, made from abi/{name} and its headers. Do not edit it: edit those.
//
//     abaqus job=JOB user={output}
//
// For Abaqus before 2019 take the // from the next line:
// #define MYOGROWTH_ABAQUS_BEFORE_2019
//
{license}
#define MYOGROWTH_SINGLE_FILE
"""
# Comments speak of tensors in symbols that some compilers' code pages lack.
ASCII = {"⊗": "(x)", "·": ".", "∘": "o", "é": "e", "ö": "oe"}


def inlined(path, include, seen):
    """The text of a file with each of our headers in the place of its first #include."""
    lines = []
    for line in path.read_text(encoding="utf-8").splitlines():
        own = re.match(r'#include (?:"([^"]+)"|<(myogrowth/[^>]+)>)', line)
        if not own:
            lines.append(line)
            continue
        target = (path.parent / own.group(1) if own.group(1) else include / own.group(2)).resolve()
        if target not in seen:
            seen.add(target)
            lines.append(inlined(target, include, seen))
    return "\n".join(lines)


def main():
    source, output, include = (pathlib.Path(a) for a in sys.argv[1:4])
    license_text = (pathlib.Path(__file__).parent.parent / "LICENSE").read_text(encoding="utf-8")
    banner = BANNER.format(version=sys.argv[4], name=source.name, output=output.name,
                           license="\n".join(f"// {line}".rstrip() for line in license_text.splitlines()))
    text = banner + "\n" + inlined(source, include, set()) + "\n"
    for symbol, plain in ASCII.items():
        text = text.replace(symbol, plain)
    try:
        output.write_text(text, encoding="ascii")
    except UnicodeEncodeError as error:
        sys.exit(f"amalgamate.py: no ASCII for {text[error.start]!r}: add it to the table")


main()
