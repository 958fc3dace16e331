"""Writes docs/robots.md from the records of the survey."""

import json
import re
from collections import Counter, defaultdict
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent.parent
QUANTITIES = ("M", "bias", "gravity")
PEERS = ("pinocchio", "drake", "mujoco")
TITLES = {"pinocchio": "Pinocchio", "drake": "Drake", "mujoco": "MuJoCo"}


def refuses(record, program):
    """Whether the program fails to load the record's file."""
    said = record.get(program, {})
    return "refused" in said or "died" in said


def cause(text):
    """An error message without the file's own names and numbers."""
    lines = [line.strip() for line in text.strip().splitlines()]
    text = next((line for line in lines if not re.search(r": \d+ errors$", line)), "")
    text = text.removeprefix("error: ").replace("FILE: ", "")
    text = re.sub(r"^line \d+(, column \d+)?: ", "", text)
    text = re.sub(r'\b(joint|link) "[^"]*"(/\w+)*', r"\1 …", text)
    text = re.sub(r"""("[^"]*"|`[^`]*`|'[^']*'|\[[^]]*\])""", "…", text)
    text = re.sub(r"(?<![\w.])-?\d+(\.\d+)?([eE][+-]?\d+)?(?![\w.])", "#", text)
    return text.split("; ")[0].replace("|", "\\|").replace("<", "\\<")


def verdict(record):
    """The survey's verdict for a file and base."""
    if "survey failed" in record or "died" in record["ours"]:
        return "the survey failed"
    if "refused" in record["ours"]:
        return "not loaded"
    if record.get("agrees"):
        return "agrees on the very file"
    written = record.get("written", {})
    if written.get("agrees"):
        return "agrees with the defaults written out"
    if record.get("agrees") is False or written.get("agrees") is False:
        return "DIFFERS"
    reason = written.get("why") or record.get("why", "")
    if "nothing moves" in (reason, record.get("why")):
        return "nothing moves"
    return "not compared"


def reason(record):
    """The reason why a file was not compared."""
    text = record.get("written", {}).get("why") or record.get("why") or record.get("survey failed") or str(record["ours"])
    text = re.sub(r"\s+at line \d+ in \S+", ". ", text.replace("\n", " "))
    text = re.sub(r"ValueError: The file \S+ does not contain a valid URDF model\.\s*", "", text)
    return " ".join(text.split()).replace("|", "\\|")[:160]


def worst_of(record):
    """The largest relevant errors."""
    return record["worst"] if record.get("agrees") else record["written"]["worst"]


def write_summary(records_path, page, manifest):
    """Writes the page."""
    records = [json.loads(line) for line in records_path.read_text(encoding="utf-8").splitlines()]
    records.sort(key=lambda record: (record["file"], record["base"]))
    fixed = [record for record in records if record["base"] == "fixed"]
    out = ["# Tested robot files", ""]
    out += [
        f"{len(fixed)} URDF files with different content, from the packages and repositories below, each with fixed and floating",
        "root. `python3 bench/robots/survey.py` writes this page; [bench/robots](../bench/robots/README.md) explains it. No file",
        "is copied into this repository.",
        "",
        *verdicts(records),
        *loaded(fixed),
        *written(records),
        *refused(records),
        *peers_refuse(fixed),
        *uncompared(records),
    ]
    if manifest:
        out += sources(manifest)
    Path(page).write_text("\n".join(out).rstrip() + "\n", encoding="utf-8")


def verdicts(records):
    """The number of files with each verdict, and the largest errors."""
    counts = Counter((verdict(record), record["base"]) for record in records)
    kinds = ["agrees on the very file", "agrees with the defaults written out", "DIFFERS", "nothing moves"]
    kinds += ["not loaded", "not compared", "the survey failed"]
    out = ["## M, bias and gravity compared with Pinocchio", "", "| | root fixed | root floating |", "| --- | ---: | ---: |"]
    for kind in kinds:
        row = [counts[kind, "fixed"], counts[kind, "floating"]]
        if any(row) or kind == "DIFFERS":
            out.append(f"| {kind} | {row[0]} | {row[1]} |")
    agreeing = [record for record in records if verdict(record).startswith("agrees")]
    out += ["", "| error | median | largest | of |", "| --- | ---: | ---: | --- |"]
    for quantity in QUANTITIES:
        ranked = sorted(agreeing, key=lambda record: worst_of(record)[quantity])
        if ranked:
            middle, last = (worst_of(ranked[i])[quantity] for i in (len(ranked) // 2, -1))
            out.append(f"| {quantity} | {middle:.1e} | {last:.1e} | {ranked[-1]['file']}, {ranked[-1]['base']} |")
    out += ["", "The largest of the three errors:", "", "| up to | 1e-15 | 1e-14 | 1e-13 | 1e-12 | 1e-11 | 1e-10 | 1e-9 |"]
    largest = sorted((max(worst_of(record).values()), record["file"], record["base"]) for record in agreeing)
    counts = [sum(error <= 10.0**power for error, *_ in largest) for power in range(-15, -8)]
    out += ["| --- " + "| ---: " * 7 + "|", "| tries | " + " | ".join(map(str, counts)) + " |", ""]
    beyond = [entry for entry in reversed(largest) if entry[0] > 1e-12]
    if beyond:
        out += [f"Largest errors, {len(beyond)} of which exceed 1e-12:", ""]
        out += [f"- {f}, {b} ({e:.0e})" for e, f, b in beyond[:12]]
    differing = [record for record in records if verdict(record) == "DIFFERS"]
    for record in differing:
        numbers = (record.get("written") or {}).get("worst") or record.get("worst")
        out.append(f"\n{record['file']}, {record['base']}: {numbers}")
    return [*out, ""]


def loaded(fixed):
    """The number of files that each program loads, and files that load elsewhere but not here."""
    out = ["## Loaded, root fixed", "", "| program | loads | of these not loaded here |", "| --- | ---: | ---: |"]
    for program in ("ours", *PEERS):
        files = [record for record in fixed if not refuses(record, program)]
        missing = sum(refuses(record, "ours") for record in files)
        name = {"ours": "this project", "pinocchio": "Pinocchio", "drake": "Drake", "mujoco": "MuJoCo (shapes taken out)"}
        out.append(f"| {name[program]} | {len(files)} | {missing} |")
    suspicious = [record for record in fixed if record["ours"].get("warnings")]
    out += ["", f"{len(suspicious)} of the files loaded here have a warning.", ""]
    return out


def written(records):
    """Features that Pinocchio drops or rejects and that are written out for the comparison."""
    groups = defaultdict(set)
    for record in records:
        if verdict(record) == "agrees with the defaults written out":
            theirs = record.get("pinocchio", {})
            told = theirs.get("said") or theirs.get("refused", "").removeprefix("ValueError: ")
            dropped = f"refuses: {cause(told.removeprefix('Error:').strip()).split('. ')[0]}" if theirs else "takes less of the file"
            groups[dropped, "; ".join(record["written"]["changes"])].add(record["file"])
    out = ["## Where Pinocchio refuses or drops an element", ""]
    out += ["These files are compared with the default values written out.", "", "| Pinocchio | written out | files |"]
    out.append("| --- | --- | --- |")
    for (what, changes), files in sorted(groups.items(), key=lambda item: (-len(item[1]), item[0])):
        out.append(f"| {what} | {changes} | {listing(files)} |")
    return [*out, ""]


def listing(files, most=6):
    """A few names and the number of others."""
    names = sorted(files)
    return ", ".join(names[:most]) + (f" and {len(names) - most} more" if len(names) > most else "")


def refused(records):
    """The files that do not load, by cause."""
    groups, other = defaultdict(dict), {}
    for record in records:
        if record["base"] == "fixed":
            other[record["file"]] = record
    for record in records:
        if "refused" in record["ours"]:
            freed = record["base"] == "floating" and not refuses(other[record["file"]], "ours")
            key = cause(record["ours"]["refused"]) + (" (root floating only)" if freed else "")
            if freed or record["base"] == "fixed":
                groups[key][record["file"]] = other[record["file"]]
    out = ["## Files that do not load here", ""]
    out += ["The first error of each file, and the programs that load it. A file without links has no robot. A mimic"]
    out += ["joint without its leader is an error by [decision](decisions/faulty-files.md); the programs that load it"]
    out += ["let the joint move freely.", ""]
    for key, files in sorted(groups.items(), key=lambda item: (-len(item[1]), item[0])):
        out += [f"### {len(files)}: {key}", "", "| file | loaded by |", "| --- | --- |"]
        for name, record in sorted(files.items())[:60]:
            loading = ", ".join(TITLES[p] for p in PEERS if not refuses(record, p))
            out.append(f"| {name} | {loading} |")
        if len(files) > 60:
            out.append(f"| and {len(files) - 60} more | |")
        out.append("")
    return out


def peers_refuse(fixed):
    """Files that load here and are rejected elsewhere."""
    out = ["## Files that load here and not there", "", "| program | files |", "| --- | ---: |"]
    for program in PEERS:
        count = sum(refuses(record, program) and not refuses(record, "ours") for record in fixed)
        out.append(f"| {TITLES[program]} | {count} |")
    return [*out, ""]


def uncompared(records):
    """Files that load and could not be compared."""
    left = [record for record in records if verdict(record) in ("not compared", "the survey failed")]
    if not left:
        return []
    out = ["## Not compared", "", "| file | root | why |", "| --- | --- | --- |"]
    return [*out, *(f"| {record['file']} | {record['base']} | {reason(record)} |" for record in left), ""]


def sources(manifest):
    """The packages and repositories with their versions."""
    counts, versions = Counter(), {}
    for line in manifest.read_text(encoding="utf-8").splitlines()[1:]:
        _, source, version, _, kept = line.split("\t")
        counts[source] += kept == "kept"
        versions[source] = version
    out = ["## Sources", "", "Each content is counted once, under the first source that has it.", ""]
    out += ["| source | version or commit | files kept |", "| --- | --- | ---: |"]
    return [*out, *(f"| {source} | {versions[source]} | {counts[source]} |" for source in sorted(versions)), ""]
