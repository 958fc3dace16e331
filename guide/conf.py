"""Sphinx settings of the guide. `cargo xtask site` prepares the pages and runs Sphinx."""

import __future__
import importlib.util
import re
import sys
from importlib.machinery import SourceFileLoader
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]

project = "Robot dynamics"
author = "The robot-dynamics developers"
copyright = author
extensions = ["myst_parser", "sphinx_design", "sphinx.ext.autodoc"]
source_suffix = {".md": "markdown", ".rst": "restructuredtext"}
exclude_patterns = ["files"]

# Pages.
myst_enable_extensions = ["colon_fence"]
myst_heading_anchors = 4
myst_links_external_new_tab = False
# Documents of the repository are pages too. They may start at any heading level.
suppress_warnings = ["myst.header", "misc.highlighting_failure"]
highlight_language = "text"

# Appearance. The pages load no external fonts or scripts.
html_theme = "furo"
html_title = "Robot dynamics"
html_static_path = ["static"]
html_favicon = "static/favicon.svg"
html_css_files = ["guide.css"]
html_js_files = [("guide.js", {"defer": "defer"})]
html_copy_source = False
html_show_sphinx = False
html_show_copyright = False
html_theme_options = {"navigation_with_keys": True}
pygments_style = "friendly"
pygments_dark_style = "github-dark"

# The Python reference, from the package's sources and the stubs of its compiled part, so nothing is compiled.
default_role = "py:obj"
autodoc_member_order = "bysource"
autodoc_typehints = "none"
autodoc_default_options = {"members": True, "inherited-members": True, "undoc-members": False}
autodoc_mock_imports = [
    "casadi", "gymnasium", "jax", "jaxlib", "matplotlib", "meshcat", "polars", "pyarrow", "ray", "torch",
]
add_module_names = False
toc_object_entries_show_parents = "hide"


class _DefaultValue:
    """A default value by its name. Only the compiled module has the value."""

    def __init__(self, name):
        self.name = name

    def __repr__(self):
        return self.name

    def __iter__(self):
        yield _DefaultValue("...")


class _DefaultValues(dict):
    """The default values of signatures, which show their names."""

    def __missing__(self, name):
        return _DefaultValue(f"defaults.{name.upper()}")


def _load_stubs() -> None:
    """Installs the stubs in place of the compiled module; they have its names, signatures and docstrings."""
    name, path = "robot_dynamics._native", ROOT / "python" / "robot_dynamics" / "_native.pyi"
    loader = SourceFileLoader(name, str(path))
    module = importlib.util.module_from_spec(importlib.util.spec_from_loader(name, loader))
    source = path.read_text(encoding="utf-8")
    # The last overload of a name has the docstring, which `typing.overload` would discard.
    source = source.replace("    @overload\n", "")
    # Only annotations need these imports. They are not evaluated, and the package is not importable yet.
    source = "".join(line for line in source.splitlines(True) if not line.startswith("from robot_dynamics."))
    module.__version__ = ""
    sys.modules[name] = module
    exec(compile(source, str(path), "exec", __future__.annotations.compiler_flag), module.__dict__)
    module._defaults = _DefaultValues


sys.path.insert(0, str(ROOT / "python"))
_load_stubs()


def _as_plain_words(app, what, name, obj, options, lines) -> None:
    """Converts docstrings, plain text with `names` in back quotes, to reStructuredText.

    In them |x| and q* are mathematics instead of markup, and indented lines are code.
    """
    plain, in_session, in_code = [], False, False
    for line in lines:
        in_session = line.lstrip().startswith(">>>") or (in_session and line.strip() != "")
        if line.startswith("    ") and not in_session:
            if not in_code and plain and plain[-1] == "":
                plain += ["::", ""]
            in_code = True
        elif line:
            in_code = False
            if not in_session:
                line = re.sub(r"(``.*?``|`.*?`)|([|*])", lambda m: m[1] or "\\" + m[2], line)
        plain.append(line)
    lines[:] = plain


def setup(app) -> None:
    """Sphinx calls this."""
    app.connect("autodoc-process-docstring", _as_plain_words)
