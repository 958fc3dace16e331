"""Compares each `ccall` and each structure of RobotDynamics.jl with the C header. Needs Python alone."""

import pathlib
import re
import sys

FOLDER = pathlib.Path(__file__).resolve().parent
HEADER = FOLDER / "../../cpp/include/robot_dynamics.h"

#: The types of Julia that have the layout of a type of C.
JULIA_OF = {
    "rd_status": {"Int32", "Cint"},
    "int32_t": {"Int32", "Cint"},
    "uint32_t": {"UInt32", "Cuint"},
    "uint64_t": {"UInt64"},
    "size_t": {"Csize_t"},
    "double": {"Cdouble", "Float64"},
    "double *": {"Ptr{Cdouble}", "Ptr{Float64}"},
    "char *": {"Cstring"},
}
#: The names in Julia of the structures of C.
STRUCTURES = {"rd_model": "Model", "rd_workspace": "Workspace", "rd_load_options": "LoadOptions"}
for c_name, name in STRUCTURES.items():
    JULIA_OF[c_name] = {name}
    JULIA_OF[c_name + " *"] = {f"Ref{{{name}}}", f"Ptr{{{name}}}"}


def split(text: str) -> list[str]:
    """The parts of a list with commas, without empty ones."""
    return [part.strip() for part in text.split(",") if part.strip()]


def c_type(declaration: str, has_name: bool) -> str:
    """The type of a declaration, without `const` and the name, as `double *`."""
    text = re.sub(r"\bconst\b", "", declaration)
    if has_name:
        text = re.sub(r"\w+\s*$", "", text)
    stars = text.count("*")
    return " ".join(text.replace("*", " ").split()) + (" " + "*" * stars if stars else "")


def functions_of(header: str) -> dict[str, list[str]]:
    """The types of each function of the header: the result, then the arguments."""
    found = {}
    for result, name, arguments in re.findall(r"^(\w[\w \*]*?)(rd_\w+)\(([^)]*)\);", header, re.MULTILINE):
        types = [] if arguments.strip() == "void" else [c_type(a, True) for a in split(arguments)]
        found[name] = [c_type(result, False), *types]
    return found


def fields_of(header: str, name: str) -> list[tuple[str, str]]:
    """The names and the types of the fields of a structure of the header."""
    body = re.search(r"typedef struct \{([^}]*)\} " + name + ";", header).group(1)
    fields = [field for field in body.split(";") if field.strip()]
    return [(re.search(r"(\w+)\s*$", field).group(1), c_type(field, True)) for field in fields]


def check(julia: str, header: str) -> tuple[int, list[str]]:
    """The number of calls, and the differences."""
    header = re.sub(r"/\*.*?\*/", "", header, flags=re.DOTALL)
    functions = functions_of(header)
    errors = []
    calls = re.findall(r"ccall\(\(:(\w+), library\),\s*(\w+),\s*\(([^)]*)\)", julia)
    if len(calls) != julia.count("ccall("):
        errors.append("a ccall has a form that this check does not read")
    for name, result, arguments in calls:
        expected, given = functions.get(name), [result, *split(arguments)]
        if expected is None:
            errors.append(f"{name}: the header does not declare it")
        elif len(expected) != len(given):
            errors.append(f"{name}: {len(given) - 1} arguments instead of {len(expected) - 1}")
        else:
            errors += [
                f"{name}: {theirs} for {ours}"
                for ours, theirs in zip(expected, given)
                if theirs not in JULIA_OF.get(ours, ())
            ]
    for c_name, name in STRUCTURES.items():
        body = re.search(r"^struct " + name + r"\n(.*?)^end", julia, re.MULTILINE | re.DOTALL).group(1)
        given = [tuple(line.strip().split("::")) for line in body.splitlines()]
        expected = fields_of(header, c_name)
        if [field for field, _ in given] != [field for field, _ in expected] or any(
            theirs not in JULIA_OF[ours] for (_, theirs), (_, ours) in zip(given, expected)
        ):
            errors.append(f"struct {name}: {given} instead of {expected}")
    return len(calls), errors


def main() -> int:
    julia, header = (FOLDER / "RobotDynamics.jl").read_text(), HEADER.read_text()
    calls, errors = check(julia, header)
    # The check itself must see a wrong type, a missing argument and a wrong field.
    for right, wrong in [
        ("(Model, Ptr{Cdouble}, Csize_t)", "(Model, Ptr{Cfloat}, Csize_t)"),
        ("(Model, Csize_t)", "(Model,)"),
        ("strict::Int32", "strict::Int64"),
    ]:
        if not check(julia.replace(right, wrong), header)[1]:
            errors.append(f"the check does not see {wrong} in the place of {right}")
    print(*errors, f"{calls} calls compared with the header", sep="\n")
    return 1 if errors else 0


if __name__ == "__main__":
    sys.exit(main())
