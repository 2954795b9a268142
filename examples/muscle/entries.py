"""Entries of the solver's parameter files (deal.II's): `subsection X`, `set A = B`, `end`."""
import re

from raw import fail
from shared import files


def read(path):
    """{"Section/Entry": (text, place)}"""
    found, section = {}, None
    for line, text in enumerate(files.read_text(path).split("\n"), 1):
        text, place = text.split("#")[0].strip(), f"{path}:{line}"
        if not text:
            continue
        if match := re.fullmatch(r"subsection\s+(\S.*)", text):
            if section:
                fail(place, f"subsection within {section}")
            section = match[1]
        elif text == "end" and section:
            section = None
        elif (match := re.fullmatch(r"set\s+(.+?)\s*=\s*(.*)", text)) and section:
            found[f"{section}/{match[1]}"] = (match[2], place)
        else:
            fail(place, f"{files.shown(text)}: expected 'subsection NAME', 'set ENTRY = VALUE' or 'end'")
    return found


def override(found, texts):
    """With `Section/Entry=value` of the command line."""
    for text in texts:
        name, _, value = text.partition("=")
        found[name.strip()] = (value.strip(), name.strip())
    return found
