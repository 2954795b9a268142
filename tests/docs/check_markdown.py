"""Lines of Markdown have at most 120 characters: tables, blocks of code and the targets of links do not count.

    check_markdown.py FILE.md ...
"""
import pathlib
import re
import sys

LONGEST = 120


def long_lines(text):
    """The numbers and lengths of lines that are too long, without what does not count."""
    code = False
    for number, line in enumerate(text.splitlines(), 1):
        if re.match(r"\s*(```|~~~)", line):
            code = not code
        elif not code and not line.lstrip().startswith("|"):
            length = len(re.sub(r"\]\([^)]*\)|<?https?://\S+", "", line))
            if length > LONGEST and " " in line.strip():
                yield number, length


def self_test():
    """What must be found, and nothing else."""
    words = "word " * 30
    page = "\n".join([words, "| " + words, "```", words, "```", words, f"[a](https://example.org/{'x' * 200})", "x" * 200])
    found = [number for number, _ in long_lines(page)]
    assert found == [1, 6], found


self_test()
faults = [f"{path}:{number}: {length} characters, at most {LONGEST}" for path in sys.argv[1:]
          for number, length in long_lines(pathlib.Path(path).read_text(encoding="utf-8"))]
print("\n".join(faults) or f"{len(sys.argv) - 1} pages")
sys.exit(bool(faults) or len(sys.argv) < 2)
