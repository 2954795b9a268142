"""./run release: checks that the tree can be released, runs the tests, and makes what a release has in out/release/.

    release.py [--tested]     --tested: the tests have passed already, as in CI
"""
import datetime
import hashlib
import os
import pathlib
import re
import shutil
import subprocess
import sys

HEADINGS = ("Added", "Changed", "Deprecated", "Removed", "Fixed", "Security")  # of "Keep a Changelog"


def version(root):
    """major.minor.patch of the header, the one place where it is written."""
    text = (root / "include/myogrowth/version.hpp").read_text(encoding="utf-8")
    return ".".join(re.search(rf"#define MYOGROWTH_VERSION_{part} (\d+)", text).group(1) for part in ("MAJOR", "MINOR", "PATCH"))


def changelog_entry(root, v):
    """The date as it stands there and the text of the version's entry; None where there is no such entry."""
    text = (root / "CHANGELOG.md").read_text(encoding="utf-8")
    found = re.search(rf"^## \[{re.escape(v)}\](?: - (\S*))?\s*\n(.*?)(?=^## |\Z)", text, re.M | re.S)
    return found and (found.group(1) or "", found.group(2).strip())


def version_faults(root):
    """What does not agree between version.hpp, CITATION.cff and CHANGELOG.md."""
    v = version(root)
    citation = dict(re.findall(r"^(version|date-released): *[\"']?([^\"'\s]*)", (root / "CITATION.cff").read_text(encoding="utf-8"), re.M))
    if citation.get("version") != v:
        yield f"CITATION.cff: version {citation.get('version')}, but include/myogrowth/version.hpp has {v}"
    text = (root / "CHANGELOG.md").read_text(encoding="utf-8")
    unreleased = changelog_entry(root, "Unreleased")
    if unreleased and unreleased[1]:
        yield "CHANGELOG.md: [Unreleased] is not empty: its lines belong to this version"
    newest = [name for name in re.findall(r"^## \[?([^\]\s]*)", text, re.M) if name != "Unreleased"]
    entry = changelog_entry(root, v)
    if not entry or newest[0] != v:
        yield f"CHANGELOG.md: the newest entry is {newest[0] if newest else 'missing'}, expected '## [{v}] - YYYY-MM-DD'"
        return
    date, body = entry
    try:
        if not re.fullmatch(r"\d{4}-\d\d-\d\d", date):
            raise ValueError("not YYYY-MM-DD")
        if datetime.date.fromisoformat(date) > datetime.date.today():
            yield f"CHANGELOG.md: [{v}] has the date {date}, which is yet to come"
    except ValueError as e:
        yield f"CHANGELOG.md: [{v}] has the date '{date}' ({e}), expected YYYY-MM-DD"
    if citation.get("date-released") != date:
        yield f"CITATION.cff: date-released {citation.get('date-released')}, but CHANGELOG.md has {date}"
    headings = re.findall(r"^### (.*?)\s*$", body, re.M)
    for heading in headings:
        if heading not in HEADINGS:
            yield f"CHANGELOG.md: [{v}] has the heading '{heading}', allowed: {', '.join(HEADINGS)}"
    if not headings or not re.search(r"^[-*] ", body, re.M):
        yield f"CHANGELOG.md: [{v}] names no change under a heading such as '### {HEADINGS[0]}'"


def git(root, *arguments):
    p = subprocess.run(["git", "-C", root, *arguments], capture_output=True, text=True, check=False)
    if p.returncode:
        sys.exit(f"./run release: git {' '.join(arguments)}: {p.stderr.strip()}")
    return p.stdout.rstrip()  # the first line of a status may begin with a blank


def tree_faults(root):
    """What keeps the commit from being what is released."""
    changed = git(root, "status", "--porcelain").splitlines()
    if changed:
        yield f"the tree has {len(changed)} files that are not committed: {', '.join(line[3:] for line in changed[:5])}"
    tag, head = f"v{version(root)}", git(root, "rev-parse", "HEAD")
    if git(root, "tag", "--list", tag) and git(root, "rev-list", "-n", "1", tag) != head:
        yield f"{tag} is released already: its tag is on another commit"
    for other in git(root, "tag", "--points-at", head, "--list", "v*").split():
        if other != tag:
            yield f"this commit has the tag {other}, but include/myogrowth/version.hpp has {version(root)}"


def make(root):
    """The packages, the UMAT in one file, their check-sums and the notes, in out/release/; nothing there where it fails."""
    v, out = version(root), root / "out/release"
    shutil.rmtree(out, ignore_errors=True)
    environment = {**os.environ, "SOURCE_DATE_EPOCH": git(root, "log", "-1", "--format=%ct")}
    subprocess.run([root / "run", "package"], check=True, env=environment, stdout=subprocess.DEVNULL)
    files = [*sorted((root / "out/package").glob("*.deb")), *sorted((root / "out/package").glob("*.zip")),
             *sorted((root / "out/package").glob("*.tar.gz")),
             root / "build/abi/myogrowth_umat_single.cpp"]
    for ending in (".deb", ".tar.gz"):
        found = [f.name for f in files if f.name.endswith(ending)]
        if len(found) != 1 or v not in found[0]:
            sys.exit(f"./run release: expected one {ending} of version {v}, ./run package made {found}")
    part = out.with_name("release.part")
    shutil.rmtree(part, ignore_errors=True)
    part.mkdir()
    sums = []
    for f in files:
        shutil.copy(f, part / f.name)
        sums.append(f"{hashlib.sha256(f.read_bytes()).hexdigest()}  {f.name}\n")
    (part / "SHA256SUMS").write_text("".join(sums), encoding="utf-8")
    (part / "notes.md").write_text(changelog_entry(root, v)[1] + "\n", encoding="utf-8")
    part.rename(out)
    return sorted(out.iterdir())


def main():
    root = pathlib.Path(__file__).resolve().parents[1]
    faults = [*version_faults(root), *tree_faults(root)]
    if faults:
        sys.exit("".join(f"./run release: {fault}\n" for fault in faults).rstrip())
    if "--tested" not in sys.argv[1:]:
        status = subprocess.run([root / "run", "test"], check=False).returncode
        if status:
            sys.exit(f"./run release: ./run test ended with status {status}: nothing is released")
    try:
        for path in make(root):
            print(path.relative_to(root))
    except subprocess.CalledProcessError as e:
        sys.exit(f"./run release: ./run package ended with status {e.returncode}: nothing is released")


if __name__ == "__main__":
    main()
